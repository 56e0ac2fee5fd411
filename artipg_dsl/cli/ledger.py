"""``apgc ledger``: the degrees of freedom of parts, and what takes each of them."""

from __future__ import annotations

import argparse
from collections.abc import Iterable, Iterator
from typing import TYPE_CHECKING

from ..diagnostics import CompileError
from ..diagnostics.suggest import did_you_mean
from ..errors import UserError
from .compile import of_text

if TYPE_CHECKING:
    from ..graph.expr import Column, Scope
    from ..lower.elaborate.part import Component
    from ..lower.expressions.context import Draft, Unknown
    from ..lower.program import Lowering
    from ..lower.solve.ledger import Line


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
    from ..lower.solve.ledger import lines as ledger_lines

    found: dict[
        tuple[str, str], list[str]
    ] = {}  # the lines of each part and case, which stages of the lowering tell apart
    told = set()
    options = {draw.column: draw.options for draw in lowering.context.draws if draw.kind == "choice"}
    parts = {instance.part.path: instance.part for instance in lowering.links.nodes}
    for part, unknown in lowering.context.ledger:
        path = part.path if part is not None else ""
        if wanted is not None and path != wanted and not path.startswith(wanted + "."):
            continue
        guards = _conditions(lowering.context, unknown.column.scope, options)
        if (path, guards) not in found:
            found[path, guards] = [(path or lowering.program.name) + (f"   with {guards}" if guards else "")]
            if part is not None and path not in told and (path == wanted or lowering.links.attachments(part)):
                found[path, guards] += _held(lowering, part)
            told.add(path)
        found[path, guards] += _shown_lines(_quantity(unknown), ledger_lines(unknown, lowering.context.draws))
    for group in found.values():
        yield from group
    if wanted in parts and wanted not in told:
        yield wanted
        yield from _held(lowering, parts[wanted])
    if wanted is not None and wanted not in parts:
        yield from _port(lowering, parts, wanted)


def _held(lowering: Lowering, part: Component) -> Iterator[str]:
    """The link of a part, and what fixes its whole pose where no equation does."""
    from ..lower.elaborate.place import mounts_of
    from ..lower.solve.ledger import carriage, mounting

    yield from _shown_lines("link", carriage(lowering.links, part))
    yield from _shown_lines("pose", mounting(lowering.links, part, mounts_of(part)))


def _shown_lines(name: str, lines: Iterable[Line]) -> Iterator[str]:
    for line in lines:
        told = line.how if not line.when else f"where {line.when}: {line.how}"
        yield f"    {name:<14} {told:<44} {line.place}"
        name = ""


def _port(lowering: Lowering, parts: dict[str, Component], wanted: str) -> Iterator[str]:
    """The link on which a port of a part lies, and through which part."""
    from ..lower.elaborate.connect import carriers
    from ..lower.expressions import members
    from ..lower.expressions.evaluate import Evaluator
    from ..lower.solve.ledger import named
    from ..lower.values.kinds import part_of, reference
    from ..syntax import ast

    path, _, name = wanted.rpartition(".")
    part = parts.get(path)
    ports = {
        instance.symbol: statement
        for instance in (part.instances if part is not None else ())
        for statement in instance.symbol.body
        if isinstance(statement, ast.PortDecl) and statement.name == name
    }
    if part is None or not ports:
        return
    without = frozenset(instance.symbol for instance in part.instances if instance.symbol not in ports)
    found = members.declared(Evaluator(part.env), reference(part), name, without)
    on = carriers(found, part.env.scope) if found is not None else ()
    links = named(lowering.links, lowering.links.carried(on, part.span))
    through = " and ".join(dict.fromkeys(f"`{part_of(one).path}`" for one in on))
    yield wanted
    yield f"    {'link':<14} {f'{links}, as it lies on {through}':<44} {next(iter(ports.values())).span}"


def _conditions(draft: Draft, scope: Scope, options: dict[Column, tuple[str, ...]]) -> str:
    """The alternatives, and the branches of ``when``, in which a table has rows: ``door = SlabDoor``, ``rows > 2``."""
    from ..lower.solve.ledger import condition

    found = []
    for guard in scope.ancestors():
        there = draft.present.get(guard)
        if there is not None:
            found.append(f"{there.path} exists" if there.option is None else f"{there.path} = {there.option}")
        elif guard.kind == "guard" and guard.count is not None:
            found.append(condition(guard.count, options))
    return ", ".join(reversed(found))


def _quantity(unknown: Unknown) -> str:
    """``along x`` for a position; a parameter by its name."""
    name = unknown.name.replace("`", "")
    return "along " + "xyz"[unknown.axis] if unknown.kind == "position" else name.split(".", 1)[-1]


def _nothing(lowering: Lowering, wanted: str | None) -> UserError:
    if wanted is None:
        return UserError(f"{lowering.program.name} has no unknowns: every value follows from the text")
    paths = {part.path for part in lowering.program.parts}
    parts = ", ".join(dict.fromkeys(p.path for p in lowering.program.parts if p.parent < 0))
    return UserError(
        f"{lowering.program.name} has no part `{wanted}`", did_you_mean(wanted, paths) or f"its parts are {parts}"
    )
