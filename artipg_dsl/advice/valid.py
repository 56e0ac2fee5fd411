"""Objects that are never valid, or hardly ever, and objects that tip over unasked."""

from __future__ import annotations

from ..runtime.tables import plain_name
from ..validity.floating import Solids
from ..validity.rare import find_rare
from ..validity.stance import find_unasked, name_feet
from ..validity.stuck import find_never
from ..validity.validate import Collisions
from .seen import Seen


def warn_never(seen: Seen, solids: Solids) -> None:
    """Report faults that each of the objects has, but for parts that float and links that meet, which are told elsewhere."""
    for fault in find_never(solids):
        span = seen.line(fault.where)
        told = fault.what if span or fault.where is None else fault.words
        seen.report.warning(
            "never-valid",
            span or seen.of(fault.part or "") or seen.span,
            f"{told}, in every object examined",
            hint=f"no object would be valid{': ' * bool(fault.example)}{fault.example}; "
            "`apgc render --unchecked` draws some as they are",
        )


def warn_rare(seen: Seen, solids: Solids, found: Collisions) -> None:
    """Report that half of the objects or more are invalid, by what fails most."""
    rare = find_rare(solids, found)
    if rare is None:
        return
    topples = rare.where is not None and rare.where in {one.where for one in seen.batch.program.stable}
    remedy = (
        "broaden what it stands on, or bring its weight over that"
        if topples
        else "state by `require` or by ranges what must hold"
    )
    others = "" if rare.count == rare.many else f"; {rare.many} are invalid in all"
    few = len(seen.batch)
    where = "in every object examined" if rare.count == few else f"in {rare.count} of {few} objects examined{others}"
    seen.report.warning(
        "rarely-valid",
        seen.line(rare.where) or seen.of(plain_name(rare.part)) or seen.span,
        f"{rare.worst}, {where}",
        hint="; ".join(filter(None, (rare.example, remedy, "`apgc validate` counts all that fails"))),
    )


def warn_tipping(seen: Seen, solids: Solids) -> None:
    """Report that each of the objects tips over, and nothing requires that they stand."""
    if find_unasked(solids.tree, solids.body):
        seen.report.warning(
            "missing-stable",
            seen.span,
            f"each `{seen.batch.program.name}` examined tips over, and nothing requires that it stands",
            hint=f"{name_feet(solids.tree, solids.body, 0)}: broaden that, or bring the weight over it, and write `require stable`; "
            "if it is screwed down, label what holds it `flange` or `bracket`",
        )
