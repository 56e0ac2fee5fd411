"""Rings: links that hang on one another through their joints, and joints that follow one another.

Whether a chain comes back to where it began is a question about rows: alternatives exclude one another, and `previous`
leads from element to element. So a chain is followed in symbols: the ranks of each row in terms of those of the row that
it began in, and what must hold for it to be there.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import field
from itertools import product
from typing import Any

from ...graph import expr as E
from ...graph.expr import Column, Expr, Scope
from ...graph.program import Draw
from ...graph.reference import Elsewhere, Onward, Reference, Under, definitions_of
from ...graph.substitution import substitute
from ...records import dataclass
from ...source import Span
from ..solve.cases import TooManyCases, combinations
from ..values.kinds import part_of
from .links import Links, first_parts

_LONGEST = 12  # links of a chain that is followed from element to element of a repeat
_COUNTS = 5  # values of a count, and ranks, that are tried
_TRIALS = 5_000
_MOST_ROWS = 300
_MOST_NOTES = 6


@dataclass(frozen=True, slots=True)
class Row:
    """A row seen from the one that a chain began in: the ranks of its repeats where they differ, and what holds if it is there."""

    ranks: Mapping[Scope, Expr] = field(default_factory=dict)
    holds: Expr = E.TRUE

    def rank(self, repeat: Scope) -> Expr:
        return self.ranks.get(repeat, E.rank(repeat))

    def said(self, expr: Expr) -> Expr:
        """An expression of this row in terms of the row that the chain began in."""
        names: dict[Expr, Expr] = {E.rank(repeat): rank for repeat, rank in self.ranks.items()}
        for column in E.leaves(expr):
            moved = [s for s in column.scope.ancestors() if s in self.ranks]
            if moved:  # the same column of another row: a value of its own
                names[E.col(column)] = E.var(f"{column.path} at {', '.join(E.show(self.ranks[s]) for s in moved)}")
        return substitute(expr, names) if names else expr

    def within(self, scope: Scope) -> Row:
        """The same row, known to be one where the guards of ``scope`` hold."""
        guards = (self.said(at.count) for at in scope.ancestors() if at.kind == "guard" and at.count is not None)
        return Row(self.ranks, E.all_of((self.holds, *guards)))

    def at(self, repeat: Scope, rank: Expr | None) -> Row:
        """The row of another element of a repeat, of ``rank`` or the one before, if there is such an element."""
        there = E.sub(self.rank(repeat), E.ONE) if rank is None else self.said(rank)
        assert repeat.count is not None
        holds = E.both(self.holds, E.call("le", E.ZERO, there))
        if rank is not None:
            holds = E.both(holds, E.call("lt", there, self.said(repeat.count)))
        return Row({**self.ranks, repeat: there}, holds)


@dataclass(slots=True, eq=False)
class Chains:
    """Chains of definitions ``above`` (of each, what it hangs on or follows), whose rows stand in ``scopes``."""

    scopes: list[Scope]
    above: dict[int, Reference]
    draws: list[Draw]

    def ring(self) -> list[int] | None:
        """Definitions that hang on one another in some object, the first again at the end left out."""
        for start in self.above:
            around = {k for k in self.reached(start) if start in self.reached(k)}
            if start not in around:
                continue
            # what leads to elements before alone never comes back: it is followed where something leads on from there
            far = any(_jumps(self.above[k]) for k in around)
            row = Row().within(self.scopes[start])
            if (found := self.back(start, start, row, [start], around, far, set())) is not None:
                return found
        return None

    def reached(self, start: int) -> set[int]:
        found: set[int] = set()
        stack = [start]
        while stack:
            for k in definitions_of(self.above.get(stack.pop(), ())):
                if k not in found:
                    found.add(k)
                    stack.append(k)
        return found

    def back(
        self, start: int, at: int, row: Row, chain: list[int], around: set[int], far: bool, seen: set[tuple[Any, ...]]
    ) -> list[int] | None:
        """The first chain from ``at`` that comes back to the row of ``start`` that it began in."""
        for to, there in self.steps(self.above[at], row, far):
            if to not in around or there.holds is E.FALSE:
                continue
            if to == start and self.possible(there, self.scopes[start]):
                return chain
            place = (to, there.holds, *there.ranks.items())
            if len(chain) < _LONGEST and len(seen) < _MOST_ROWS and place not in seen:
                seen.add(place)
                if (found := self.back(start, to, there, [*chain, to], around, far, seen)) is not None:
                    return found
        return None

    def steps(self, reference: Reference, row: Row, far: bool) -> Iterator[tuple[int, Row]]:
        """What a reference comes to from a row: definitions, each with its row; in the same elements alone unless ``far``."""
        for item in reference:
            match item:
                case int():
                    yield item, row.within(self.scopes[item])
                case Under(scope, links):
                    yield from self.steps(links, row.within(scope), far)
                case Elsewhere(scope, repeat, rank, links) if far:
                    yield from self.steps(links, row.within(scope).at(repeat, rank), far)
                case Onward(scope, _, links):
                    yield from self.steps(links, row, far)
                    for _ in range(_COUNTS if far else 0):
                        row = row.at(scope, None)
                        yield from self.steps(links, row, far)

    def possible(self, row: Row, scope: Scope) -> bool:
        """Whether a row of ``scope`` can be the very row that the chain began in."""
        holds = row.holds
        for repeat in scope.ancestors():
            if repeat in row.ranks:
                if _descends(row.ranks[repeat], repeat):
                    return False
                holds = E.both(holds, E.call("eq", row.ranks[repeat], E.rank(repeat)))
        return any(self.can_hold(case) for case in self.cases(holds))

    def cases(self, condition: Expr) -> Iterator[Expr]:
        """The condition with whole numbers put in for ranks, counts and choices: a few of each."""
        known = {draw.column: draw for draw in self.draws}
        ranks: dict[Expr, Scope] = {}
        counts: dict[Expr, list[float]] = {}
        stack = [condition]
        while stack:
            node = stack.pop()
            stack.extend(node.args)
            if node.op == "rank" and node not in ranks:
                ranks[node] = node.value
                if node.value.count is not None:
                    stack.append(node.value.count)
            elif node.op == "col" and node not in counts and (values := some(node.value, known)):
                counts[node] = values
        total = 1
        for tried in (*counts.values(), *([0.0] * _COUNTS for _ in ranks)):
            total *= len(tried)
        if total > _TRIALS:
            yield condition
            return
        for picked in product(*counts.values(), *(range(_COUNTS) for _ in ranks)):
            given = {node: E.const(value) for node, value in zip((*counts, *ranks), picked, strict=True)}
            case = substitute(condition, given)
            for node, repeat in ranks.items():
                if repeat.count is not None:
                    case = E.both(case, E.call("lt", given[node], substitute(repeat.count, given)))
            if case is not E.FALSE:
                yield case

    def can_hold(self, condition: Expr) -> bool:
        try:
            return any(holds for (holds,) in combinations([condition], self.draws))
        except TooManyCases:
            return True


def some(column: Column, known: Mapping[Column, Draw]) -> list[float]:
    """Values to try for a count or a choice; none for others."""
    draw = known.get(column)
    if draw is None:
        return []
    if draw.kind == "choice":
        return [float(k) for k in range(len(draw.options))]
    if draw.kind != "count":
        return []
    low = 0.0 if draw.low is None or draw.low.constant is None else float(draw.low.constant)
    high = low + _COUNTS if draw.high is None or draw.high.constant is None else float(draw.high.constant)
    return [low + k for k in range(_COUNTS) if low + k <= high]


def _jumps(reference: Reference) -> bool:
    """Whether a reference leads to an element that it names by its rank."""
    return any(
        isinstance(item, Elsewhere) and item.rank is not None or not isinstance(item, int) and _jumps(item.links)
        for item in reference
    )


def _descends(rank: Expr, repeat: Scope) -> bool:
    """Whether a rank is that of an element before the one of rank ``rank(repeat)``: what `previous` leads to."""
    steps = 0
    while rank.op == "sub" and rank.args[1] is E.ONE:
        rank, steps = rank.args[0], steps + 1
    return steps > 0 and rank is E.rank(repeat)


def refuse(links: Links) -> None:
    """Report links that hang on one another in a ring, and joints that follow or wait for one another."""
    program = links.context.program
    joints = list(enumerate(program.joints))
    hung: dict[int, Reference] = {joint.child: joint.parent for joint in program.joints}
    follows: dict[int, Reference] = {k: j.mimic[0] for k, j in joints if j.mimic is not None}
    waits: dict[int, Reference] = {k: tuple(to for gate in j.gates for to in gate.joint) for k, j in joints if j.gates}
    for verb, above in (("hangs on", hung), ("follows", follows), ("waits for", waits)):
        ends = program.links if above is hung else program.joints
        ring = Chains([end.scope for end in ends], above, program.draws).ring()
        if ring is not None:
            _tell(links, [links.joints[link] for link in ring] if above is hung else ring, verb)
            return


def _tell(links: Links, ring: list[int], verb: str) -> None:
    joints = [links.context.program.joints[k] for k in ring]
    hangs = verb == "hangs on"
    names = [f"`{links.owners[j.child].path if hangs else j.path}`" for j in joints]
    others = list(dict.fromkeys(n for n in names if n != names[0]))
    via = f", by way of {' and '.join(others)}" if others else ""
    if hangs:
        message = f"{names[0]} is attached to itself{via}: the links form a ring"
        hint = "attach one of these parts to the root, or to a part that is attached to it; a loop of joints is closed with `close`"
    else:
        message = f"the joint {names[0]} {verb} itself{via}"
        hint = f"one of these joints must move independently: drop its `{'mimic' if verb == 'follows' else 'when'}`"
    notes: dict[Span, str] = {}
    for number, name, onto in zip(ring, names, [*names[1:], names[0]], strict=True):
        notes.setdefault(links.stated[number].span, f"{name} {verb} {onto}")
        for span, text in between(links, number) if hangs else ():
            notes.setdefault(span, text)
    span = links.stated[ring[0]].span
    notes.pop(span)
    links.context.error("circular-definition", span, message, hint=hint, notes=tuple(notes.items())[:_MOST_NOTES])


def between(links: Links, number: int) -> Iterator[tuple[Span, str]]:
    """What lies rigidly between the parent of a joint and the link that carries it: the parts, and why each is carried."""
    child = links.context.program.joints[number].child
    owner = links.owners[child]
    attachment = next(a for a, link in links.own.items() if link == child)
    parts, seen = attachment.to, {owner}
    while parts and (part := part_of(parts[0])) not in seen:
        seen.add(part)
        attachments = links.attachments(part)
        if any(a.joint is not None for a in attachments):
            return
        if attachments:
            yield attachments[0].span, f"carries `{part.name}`"
            parts = attachments[0].to
        else:
            instance = part.env.root.instance
            first = None if instance is None else next(iter(first_parts(instance)), part)
            if first is None or first is part:
                return
            yield part.span, f"`{part.name}` is not attached: it moves with `{first.name}`, the first part"
            parts = (first,)
