"""Bays of a loft along an axis that differ in numbers alone, as one bay of their number.

The sections of a solid are often one curve with other numbers. What would be written out for each bay, searches for the foot of a
point above all, is then written once, and the numbers are selected by the level of the point.
"""

from __future__ import annotations

from collections.abc import Sequence

from ...graph import expr as E
from ...graph.expr import ONE, ZERO, Expr
from ...graph.primitive import pair, triple
from ...graph.substitution import rebuild
from ...records import dataclass
from .bays import Bay
from .paths import Stretch
from .probe import Probe
from .profiles import Span, V
from .smooth import Course, Run

NUMBER = E.var("section.bay")  # of a bay among those that are one
_PADDED = {"add": ZERO, "sub": ZERO, "mul": ONE, "div": ONE, "pow": ONE}  # what leaves the other argument as it is


@dataclass(frozen=True, slots=True, eq=False)
class Bays:
    """Bays one after another; ``one`` is that of number ``NUMBER``."""

    members: tuple[Bay, ...]
    one: Bay

    def spread(self, probe: Probe) -> Probe:
        """Its rows once for each of them, those of the first bay first."""
        many = len(self.members)
        return probe if many == 1 else probe.spread(str(NUMBER.value), tuple(map(float, range(many))))

    def at_level(self, height: Expr, levels: Sequence[Expr]) -> dict[Expr, Expr]:
        """What to substitute in what reads ``NUMBER`` for the bay at a height; the ``levels`` are those where the bays begin."""
        return {_below(NUMBER, k): E.call("lt", height, level) for k, level in enumerate(levels[1:])}


def numbered(bays: Sequence[Bay]) -> list[Bays]:
    """Bays one after another in as few groups as may be."""
    found: list[Bays] = []
    for bay in bays:
        before = found[-1].members if found else ()
        one = _one((*before, bay)) if before else None
        if one is not None:
            found[-1] = Bays((*before, bay), one)
        else:
            found.append(Bays((bay,), bay))
    return found


def _below(index: Expr, number: int) -> Expr:
    return E.call("lt", index, E.const(number + 0.5))


def select(index: Expr, values: Sequence[Expr]) -> Expr:
    """Of values the one of an index, a formula that counts from 0."""
    found = values[-1]
    for k in range(len(values) - 2, -1, -1):
        found = E.where(_below(index, k), values[k], found)
    return found


def _one(bays: tuple[Bay, ...]) -> Bay | None:
    """Bays as one, or None where they differ in more than numbers."""
    sections = [_spans([bay.ends[k][0] for bay in bays]) for k in (0, 1)]
    courses = [bay.course for bay in bays]
    course = _course(courses)
    if sections[0] is None or sections[1] is None or course is None and any(courses):
        return None
    places = (tuple(bay.rail.place[axis] for bay in bays) for axis in range(3))
    place = triple(_common(along) or select(NUMBER, along) for along in places)
    rail = Stretch(place, bays[0].rail.direction, select(NUMBER, [bay.rail.length for bay in bays]))
    return Bay(rail, bays[0].frames, [sections[0]], [sections[1]], course)


def _spans(sections: Sequence[Sequence[Span]]) -> list[Span] | None:
    found = []
    for spans in zip(*sections, strict=True):
        x, y = (_common(tuple(span.by_fraction[axis] for span in spans)) for axis in (0, 1))
        if x is None or y is None:
            return None
        found.append(Span(spans[0].name, pair((x, y)), closing=spans[0].closing))
    return found


def _course(courses: Sequence[Course | None]) -> Course | None:
    made = [course for course in courses if course is not None]
    if len(made) < len(courses):
        return None
    (a, b), (c, d) = ([_run([course.bounds[axis][side] for course in made]) for side in (0, 1)] for axis in (0, 1))
    alike = all(course.alike[0] for course in made), all(course.alike[1] for course in made)
    return Course(((a, b), (c, d)), alike, _run([course.share for course in made]))


def _run(runs: Sequence[Run]) -> Run:
    ends = zip(*((run.first, run.last, run.begin, run.end) for run in runs), strict=True)
    return Run(*(select(NUMBER, values) for values in ends))


def _common(exprs: tuple[Expr, ...]) -> Expr | None:
    """What has the value of each of some expressions over ``V`` at its number; None where they differ in more than what does not read
    ``V``, or in terms and factors of it that some of them lack."""
    known: dict[tuple[Expr, ...], Expr | None] = {}

    def visit(some: tuple[Expr, ...]) -> Expr | None:
        if all(e is some[0] for e in some):
            return some[0]
        if not any(e.reads & V.reads for e in some):
            return select(NUMBER, some)
        if some not in known:
            known[some] = join(some)
        return known[some]

    def join(some: tuple[Expr, ...]) -> Expr | None:
        node, given = _aligned(some)
        args = []
        for column in zip(*given, strict=True):
            arg = visit(column)
            if arg is None:
                return None
            args.append(arg)
        return rebuild(node, tuple(args)) if args else None

    return visit(exprs)


def _aligned(some: tuple[Expr, ...]) -> tuple[Expr, list[tuple[Expr, ...]]]:
    """An operation that all of some expressions are, and the arguments of each; none where there is no such."""
    if all(e.op == some[0].op and e.value == some[0].value for e in some):
        return some[0], [e.args for e in some]
    for node in some:
        for at in (1, 0) if node.op in ("add", "mul") else (1,) if node.op in _PADDED else ():
            if not node.args[at].reads & V.reads:
                return node, [_padded(e, node.op, at) for e in some]
    return some[0], [() for _ in some]


def _padded(e: Expr, op: str, at: int) -> tuple[Expr, ...]:
    """The arguments of an expression as an operation whose argument ``at`` does not read ``V``."""
    if e.op == op and not e.args[at].reads & V.reads:
        return e.args
    if {e.op, op} == {"add", "sub"} and at == 1 and not e.args[1].reads & V.reads:
        return e.args[0], E.neg(e.args[1])
    if op == "pow" and e.op == "mul" and e.args[0] is e.args[1]:
        return e.args[0], E.const(2.0)
    return (e, _PADDED[op]) if at else (_PADDED[op], e)
