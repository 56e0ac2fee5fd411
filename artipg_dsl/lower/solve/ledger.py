"""The ledger in words: what determines each unknown, under which guard, alone or together with which others."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Sequence
from typing import TYPE_CHECKING

from ...graph import expr as E
from ...graph.expr import Column, Expr
from ...graph.program import Draw
from ...graph.reference import Reference, definitions_of
from ...records import dataclass
from ..expressions.context import Equation, Settled, Unknown
from ..values.kinds import part_of

if TYPE_CHECKING:
    from ..elaborate.links import Links
    from ..elaborate.part import Component
    from ..elaborate.place import Mount

WORDS = {"centred": "nothing: centred", "default": "nothing: its default", "drawn": "drawn from its domain"}
_SIGNS = {"eq": "=", "le": "<=", "lt": "<"}
_OPPOSITE = {"eq": "is not", "le": ">", "lt": ">="}


@dataclass(frozen=True, slots=True)
class Line:
    """One way in which an unknown is settled: ``when`` (empty: always), ``how``, and where the text says so."""

    when: str
    how: str
    place: str


def lines(unknown: Unknown, draws: Iterable[Draw]) -> list[Line]:
    """The ways in which an unknown is settled, those that differ by a guard one after the other."""
    options = {d.column: d.options for d in draws if d.kind == "choice"}
    groups: dict[tuple[str, str], Expr] = {}
    for one in unknown.settled:
        key = how(one), str(one.equation.span if one.equation is not None else unknown.span)
        groups[key] = E.either(groups.get(key, E.FALSE), one.when)
    if len(groups) == 1:
        ((told, place),) = groups
        return [Line("", told, place)]
    return [Line(condition(when, options), told, place) for (told, place), when in groups.items()]


def how(one: Settled) -> str:
    """``align a.left = b.left``, and what it is solved together with."""
    if one.equation is None:
        return WORDS.get(one.reason, one.reason)
    together = f", together with {' and '.join(one.others)}" if one.others else ""
    return one.equation.text + together + (f" (searched from {one.start})" if one.start else "")


def carriage(links: Links, part: Component) -> Iterator[Line]:
    """The link that a part lies on, and why: in each branch of ``when`` that attaches it."""
    attachments, several = links.attachments(part), len(links.attachments(part)) > 1
    draws = {d.column: d.options for d in links.context.draws if d.kind == "choice"}
    for one in attachments:
        guards = [s.count for s in one.env.scope.ancestors() if s.count is not None and s is not part.env.scope]
        when = condition(E.all_of(guards), draws) if several and guards else ""
        if one.joint is not None:
            told = f"its own, which the joint `{one.env.path}{one.joint.name}` moves"
        elif one.base:
            told = f"{named(links, links.base(part.env))}, of what it is a part of"
        else:
            names = " and ".join(dict.fromkeys(f"`{part_of(to).path}`" for to in one.to))
            told = f"{named(links, links.carried(one.to, one.span))}, as it is attached to {names}"
        yield Line(when, told, str(one.span))
    if not attachments:
        yield Line("", f"{named(links, links.of(part))}, with what it is a part of", str(part.span))


def mounting(links: Links, part: Component, mounts: Sequence[Mount]) -> Iterator[Line]:
    """What fixes the whole pose of a part: in each branch of ``when`` that mounts it."""
    draws = {d.column: d.options for d in links.context.draws if d.kind == "choice"}
    for one in mounts:
        guards = [s.count for s in one.env.scope.ancestors() if s.count is not None and s is not part.env.scope]
        when = condition(E.all_of(guards), draws) if len(mounts) > 1 and guards else ""
        yield Line(when, one.words, str(one.statement.span))


def named(links: Links, reference: Reference) -> str:
    """Links by the paths of the parts that they are named after: those of several alternatives with `or`."""
    paths = dict.fromkeys(links.context.program.links[number].path for number in definitions_of(reference))
    return " or ".join(f"`{path}`" for path in paths)


def condition(node: Expr, options: dict[Column, tuple[str, ...]]) -> str:
    """A guard as the text would say it: ``door = SlabDoor and rows > 2``."""
    if node.op == "or":
        parts = dict.fromkeys(condition(a, options) for a in flat(node, "or"))
        return " or ".join(parts)
    told = list(dict.fromkeys(_literals(list(flat(node, "and")), options)))
    return " and ".join(told) or "always"


def flat(node: Expr, op: str) -> Iterator[Expr]:
    if node.op == op:
        for inner in node.args:
            yield from flat(inner, op)
    else:
        yield node


def _literals(nodes: Sequence[Expr], options: dict[Column, tuple[str, ...]]) -> Iterator[str]:
    """Conditions that hold together; a choice that is one thing need not be said to be no other."""
    known = {n.args[0] for n in nodes if n.op == "eq"}
    for node in nodes:
        inner, negated = (node.args[0], True) if node.op == "not" else (node, False)
        if inner.op in ("and", "or"):
            yield f"not ({condition(inner, options)})" if negated else f"({condition(inner, options)})"
        elif inner.op not in _SIGNS:
            yield f"not {E.show(inner)}" if negated else E.show(inner)
        elif not (negated and inner.op == "eq" and inner.args[0] in known):
            yield comparison(inner, negated, options)


def comparison(node: Expr, negated: bool, options: dict[Column, tuple[str, ...]]) -> str:
    sign = (_OPPOSITE if negated else _SIGNS)[node.op]
    left, right = node.args
    names = options.get(left.value, ()) if left.op == "col" else ()
    if names and right.constant is not None and 0 <= int(right.constant) < len(names):
        return f"{left.value.name} {sign} {names[int(right.constant)]}"
    return f"{said(left)} {sign} {said(right)}"


def said(node: Expr) -> str:
    return node.value.name if node.op == "col" else E.show(node)


def blocks(unknowns: Iterable[Unknown], draws: Sequence[Draw]) -> Iterator[str]:
    """A line per block of equations: what it determines, from what, and how it is solved."""
    options = {d.column: d.options for d in draws if d.kind == "choice"}
    groups: dict[tuple[Column | None, Expr], list[tuple[Unknown, Settled]]] = {}
    for unknown in unknowns:
        for one in unknown.settled:
            if one.equation is not None:
                groups.setdefault((one.block, one.when), []).append((unknown, one))
    for (_, when), members in groups.items():
        names = ", ".join(u.name.replace("`", "") for u, _ in members)
        equations: dict[Equation, None] = dict.fromkeys(s.equation for _, s in members if s.equation is not None)
        method = "search" if members[0][1].start else "elimination" if len(members) > 1 else "assignment"
        guard = "" if when is E.TRUE else f" where {condition(when, options)}"
        stated = "; ".join(f"{q.text} ({q.span})" for q in equations)
        yield f"{names} by {method}{guard}: {stated}"
