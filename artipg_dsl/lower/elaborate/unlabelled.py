"""Warns of surface without a semantic label, at the parts of the category that it belongs to."""

from __future__ import annotations

from typing import TYPE_CHECKING

from ...graph.program import Site
from ...graph.unlabelled import Bare, find_unlabelled
from ...source import Span

if TYPE_CHECKING:
    from ..program import Lowering
    from .part import Component

_NAMED = 6  # primitives that a warning names


def warn_unlabelled(lowering: Lowering, category: Span) -> None:
    """One warning for each part of the category, or a single one where nothing at all is labelled."""
    program, report = lowering.program, lowering.context.report
    bare = find_unlabelled(program)
    if not bare:
        return
    if len(bare) == len(program.sites) and not any(b.partly for b in bare):
        report.warning(
            "missing-label",
            category,
            f"no part of `{program.name}` has a semantic label",
            hint="write `label semantic.body on body`, and `use vocabularies { semantic }` for the words",
        )
        return
    known = {part.path: part for part in lowering.context.parts}
    of: dict[Component, list[Bare]] = {}
    for one in bare:
        of.setdefault(_outermost(known[program.sites[one.number].path]), []).append(one)
    for part, several in of.items():
        report.warning("missing-label", part.span, _message(several, program.sites), hint=_hint(part))


def _outermost(part: Component) -> Component:
    """The part of the category that a part belongs to."""
    while (instance := part.env.root.instance) is not None:
        part = instance.part
    return part


def _message(several: list[Bare], sites: list[Site]) -> str:
    told = []
    for path in dict.fromkeys(sites[b.number].path for b in several):
        names = dict.fromkeys(s for b in several if sites[b.number].path == path for s in b.surfaces)
        told.append(f"`{path}`" + (f" ({', '.join(names)})" if names else ""))
    named = ", ".join(told[:_NAMED]) + (f" and {len(told) - _NAMED} more" if len(told) > _NAMED else "")
    verb = "have" if len(told) > 1 else "has"
    if all(b.partly for b in several):
        return f"{named} {verb} a semantic label only under conditions, which need not hold"
    return f"{named} {verb} no semantic label"


def _hint(part: Component) -> str:
    return f"`label semantic.WORD on {part.name}` covers all of it, except where a deeper label does; without one it has class 0, `unlabelled`"
