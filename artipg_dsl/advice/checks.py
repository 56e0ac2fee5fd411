"""What makes the check of an object slow, or wrong."""

from __future__ import annotations

from ..quality.cost import find_heavy, measure_costs
from ..quality.untested import find_untested
from .seen import Seen


def warn_of_cost(seen: Seen) -> None:
    """Name the parts that the check of an object takes long for."""
    for cost in find_heavy(measure_costs(seen.batch)):
        pairs = f", and {cost.pairs:.0f} pairs of them with pieces on other links" if cost.pairs >= 1 else ""
        if cost.shared >= 1:
            pairs += f", and {cost.shared:.0f} pairs of primitives that may overlap, which `require stable` weighs"
        seen.report.warning(
            "expensive-check",
            seen.span,
            f"`{cost.part}` has {cost.pieces:.0f} convex pieces in an object{pairs}: its check takes long",
            hint="use fewer or simpler primitives, or `--unchecked`; `apgc profile` shows all parts",
        )


def warn_untested(seen: Seen) -> None:
    """Name the primitives whose box does not hold them at values that their `test` ranges leave out."""
    for wrong in find_untested(seen.batch):
        low, high = wrong.test
        what = "a convex piece of " if wrong.piece else ""
        seen.report.warning(
            "untested-values",
            seen.of(wrong.part) or seen.span,
            f"{what}`{wrong.part}` reaches {1000 * wrong.reach:.3g} mm out of its box: here `{wrong.parameter}` of `{wrong.primitive}` "
            f"is {wrong.value:.4g}, and its `test` range is {low:.4g} .. {high:.4g} (a length in metres, an angle in radians)",
            hint=f"give it a value in that range; if `{wrong.primitive}` is your own, state a wider `test low .. high` of "
            f"`{wrong.parameter}`, since its box is made for the values tested",
        )
