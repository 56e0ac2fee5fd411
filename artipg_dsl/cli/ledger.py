"""``apgc ledger``: the degrees of freedom of parts, and what takes each of them."""

from __future__ import annotations

import argparse
from collections.abc import Iterator
from typing import TYPE_CHECKING

from ..diagnostics import CompileError
from ..diagnostics.suggest import did_you_mean
from ..errors import UserError
from .compile import of_text

if TYPE_CHECKING:
    from ..graph.expr import Scope
    from ..lower.context import Unknown
    from ..lower.program import Lowering


def run(options: argparse.Namespace) -> int:
    session = of_text(options.program)
    lowering = session.lowering
    if lowering is None:
        _ = session.report.failed or session.sampler  # reports that there is no category
        raise CompileError(session.report)
    lines = list(entries(lowering, options.part))
    if not lines:
        raise _nothing(lowering, options.part)
    print("\n".join(lines))
    return 0


def entries(lowering: Lowering, wanted: str | None) -> Iterator[str]:
    """A line per part and, indented, one per unknown and case: its name, what determines it, where the text says so."""
    from ..lower.ledger import lines as ledger_lines

    shown = None
    for part, unknown in lowering.context.ledger:
        path = part.path if part is not None else ""
        if wanted is not None and path != wanted and not path.startswith(wanted + "."):
            continue
        guards = conditions(unknown.column.scope)
        if (path, guards) != shown:
            shown = (path, guards)
            yield (path or lowering.program.name) + (f"   with {guards}" if guards else "")
        name = quantity(unknown)
        for line in ledger_lines(unknown, lowering.context.draws):
            told = line.how if not line.when else f"where {line.when}: {line.how}"
            yield f"    {name:<14} {told:<44} {line.place}"
            name = ""


def conditions(scope: Scope) -> str:
    """The alternatives in which a table has rows: ``door = SlabDoor``."""
    found = [s.name.replace("=", " = ") for s in scope.ancestors() if s.kind == "guard"]
    return ", ".join(reversed(found))


def quantity(unknown: Unknown) -> str:
    """``along x`` for a position; a parameter by its name."""
    name = unknown.name.replace("`", "")
    return "along " + "xyz"[unknown.axis] if unknown.kind == "position" else name.split(".", 1)[-1]


def _nothing(lowering: Lowering, wanted: str | None) -> UserError:
    if wanted is None:
        return UserError(f"{lowering.program.name} has no unknowns: every value follows from the text")
    paths = {part.path for part in lowering.program.parts}
    if wanted in paths:
        return UserError(f"`{wanted}` has no unknowns: its place and size follow from the text")
    parts = ", ".join(dict.fromkeys(p.path for p in lowering.program.parts if "." not in p.path))
    return UserError(
        f"{lowering.program.name} has no part `{wanted}`", did_you_mean(wanted, paths) or f"its parts are {parts}"
    )
