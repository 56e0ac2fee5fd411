"""Requirements to conditional ranges: which draw each inequality narrows, and to what.

An inequality binds the variable among those it names that is drawn last, solved for it where it stands alone. When two
bounds of one variable could exclude one another, that they do not is a new requirement on what was drawn before
(Fourier and Motzkin's elimination), so that later draws find room.
"""

from __future__ import annotations

from collections import deque
from collections.abc import Collection, Iterator
from typing import NamedTuple

from ...graph import expr as E
from ...graph.depend import SIDEWAYS
from ...graph.expr import Column, Expr, Scope
from ...graph.inequality import Ends, Half, bounds_of, least_of
from ...graph.linear import LinearForm
from ...graph.program import Bound, Draw, Limit, Program
from ...graph.substitution import substitute
from .inline import inline
from .readers import Readers
from .unions import unite

_MOST_DERIVED = 400
DEPTH = 24


class Inequality(NamedTuple):
    """``low <= high`` in the rows of ``scope`` in which ``guard`` holds, said by the requirement ``number`` and, of what follows from
    several, by ``also``; ``depth``: how many eliminations it comes from."""

    scope: Scope
    low: Expr
    high: Expr
    guard: Expr
    number: int
    depth: int = 0
    also: tuple[int, ...] = ()


def attach_bounds(program: Program, strict: Collection[int]) -> list[tuple[Scope, tuple[int, ...]]]:
    """Fill ``bounds`` of the draws and ``limits`` of the choices from the requirements.

    The sides of the requirements ``strict`` must differ, if only a little. Returns the requirements that contradict one another
    whatever is drawn, with the rows in which they do.
    """
    elimination = _Elimination(program, strict)
    elimination.begin()
    while elimination.pending:
        elimination.follow(elimination.pending.popleft())
    return elimination.hollow


class _Elimination:
    """Inequalities that are still to be turned into bounds, first those of the requirements, then what these ask of earlier draws."""

    def __init__(self, program: Program, strict: Collection[int]):
        self.requirements, self.apart = program.requirements, frozenset(strict)
        self.draws = {d.column: d for d in program.draws}
        self.readers = Readers(program)
        self.pending: deque[Inequality] = deque()
        self.hollow: list[tuple[Scope, tuple[int, ...]]] = []
        self.made = {False: 0, True: 0}  # derived from linear bounds, and from others
        self.told: dict[object, float] = {}

    def begin(self) -> None:
        """What the requirements themselves say."""
        readers = self.readers
        for number, requirement in enumerate(self.requirements):
            scope, guard = requirement.scope, requirement.guard
            if requirement.slack is not None:
                self.pending.append(Inequality(scope, *requirement.slack, guard, number))
                continue
            last = readers.last(scope, requirement.condition, guard)
            if last is None:
                continue
            if self.draws[last].kind == "choice":
                _limit_choice(readers, self.draws[last], scope, requirement.condition, guard, number)
                continue
            whole = E.either(E.negate(guard), requirement.condition)
            rest = unite(readers, self.draws[last], scope, whole, number)
            if rest is not None:
                self.pending.append(Inequality(scope, *rest, E.TRUE, number, 1))

    def follow(self, one: Inequality) -> None:
        """Bounds of the value that is drawn last among those it names, and what they ask of those drawn before."""
        scope, guard, readers = one.scope, one.guard, self.readers
        derived = one.depth > 0 and guard is E.TRUE
        if derived and not self.apart.isdisjoint((one.number, *one.also)) and self._meet(one):
            self._note_hollow(one)
            return
        holds, difference = E.call("le", one.low, one.high), E.sub(one.low, one.high)
        if readers.intervals.of(holds)[0] >= 1.0:
            return
        last = readers.last(scope, difference, guard)
        if last is None:
            return
        draw = self.draws[last]
        if draw.kind == "choice":
            _limit_choice(readers, draw, scope, holds, guard, one.number)
            return
        form = readers.drawn.form(difference)
        if derived and form is not None and not form[0] and form[1].constant is not None:
            if form[1].constant > 1e-9:
                self._note_hollow(one)
            return
        if form is not None and _weaker(form, scope, guard, last, self.told) and one.depth:
            return
        alone = readers.ends(last)
        if alone.linear.reads(guard) or alone.linear.form(difference) is None:  # it may leave several intervals
            rest = unite(readers, draw, scope, E.either(E.negate(guard), holds), one.number, one.also)
            if rest is not None and self._may_go_on(one, True):
                self._derive(one, True, scope, *rest, E.TRUE)
        bent = linear(alone, scope, difference, guard) is None and not readers.open_ended(difference)
        if bent and self._may_go_on(one, bent):  # that the value drawn last has a chance at all
            least = least_of(difference, alone)
            if least is not None and scope.within(least.scope) and not readers.late(last, [least, guard]):
                self._derive(one, bent, scope, least, E.ZERO, guard)
        self._oppose(one, draw, bent)

    def _oppose(self, one: Inequality, draw: Draw, bent: bool) -> None:
        """Bind the value drawn last: between its bound and those on the other side there is room."""
        for bound, stated, inner in bind(self.readers, draw, one):
            if not self._may_go_on(one, bent):
                break
            for other in _opposite(draw, bound):
                lower, upper = (other, stated) if bound.side == "high" else (stated, other)
                more = () if other.requirement == one.number else (other.requirement,)
                also = tuple(dict.fromkeys((*one.also, *other.also, *more)))
                guard = E.both(lower.guard, upper.guard)
                self._derive(one._replace(also=also), bent, inner, lower.value, upper.value, guard)

    def _may_go_on(self, one: Inequality, bent: bool) -> bool:
        """Whether more may be derived: it grows fast with the depth, and says less and less."""
        return one.depth < DEPTH and self.made[bent] < _MOST_DERIVED

    def _derive(self, one: Inequality, bent: bool, scope: Scope, low: Expr, high: Expr, guard: Expr) -> None:
        self.made[bent] += 1
        self.pending.append(Inequality(scope, low, high, guard, one.number, one.depth + 1, one.also))

    def _meet(self, one: Inequality) -> bool:
        """Whether both sides are always equal."""
        form = self.readers.drawn.form(E.sub(one.low, one.high))
        left = None if form is None or form[0] else form[1].constant
        return left is not None and abs(left) < 1e-12

    def _note_hollow(self, one: Inequality) -> None:
        self.hollow.append((one.scope, (one.number, *one.also)))


def _weaker(form: LinearForm, scope: Scope, guard: Expr, last: Column, told: dict[object, float]) -> bool:
    """Whether ``form <= 0`` says no more than a multiple of it that was told before; else it is noted.

    Elimination comes to the same sum on many ways: without this their number would grow with the power of the variables.
    """
    factors = {column: factor.constant for column, factor in form[0].items()}
    rest = form[1].constant
    if rest is None or None in factors.values() or not factors.get(last):
        return False
    scale = abs(float(factors[last] or 0.0))
    shape = frozenset((column, round(float(f) / scale, 9)) for column, f in factors.items() if f)
    before = told.get((scope, guard, shape))
    if before is not None and before >= float(rest) / scale - 1e-12:
        return True
    told[scope, guard, shape] = float(rest) / scale
    return False


def _limit_choice(readers: Readers, draw: Draw, scope: Scope, condition: Expr, guard: Expr, number: int) -> None:
    """A requirement whose names are all known but a choice removes alternatives of it."""
    last = draw.column
    holds = E.either(E.negate(guard), condition)
    while not last.scope.within(scope):
        if scope.parent is None or scope.count is None:
            return
        if scope.kind == "repeat":
            holds = E.reduce("all", scope, holds)
        elif scope.parent.within(holds.scope):
            holds = E.either(E.negate(scope.count), holds)
        elif not readers.ends(last).linear.reads(scope.count):
            holds = E.phi(scope.parent, [(scope, holds)], E.TRUE)
        else:
            return
        scope = scope.parent
    if not last.scope.within(holds.scope):
        return
    holds = inline(holds, [last], readers.definitions)
    if _reads_siblings(holds, last):
        return
    for code in range(len(draw.options)):
        allowed = substitute(holds, {E.col(last): E.const(float(code))})
        if allowed is not E.TRUE:
            draw.limits.append(Limit(code, allowed, number))


def _reads_siblings(node: Expr, column: Column) -> bool:
    """Whether an expression reads the column in other rows than its own, which have another value: an element by its number, the
    one before, what several come to."""
    across = (n for n in E.nodes(node) if n.op in SIDEWAYS)
    tables = ((n, n.value[1] if n.op == "reduce" else n.value) for n in across)
    return any(column.scope.within(table) and column in E.leaves(n) for n, table in tables)


def _opposite(draw: Draw, bound: Bound) -> Iterator[Bound]:
    """The domain's other end, and the bounds on the other side that come from other requirements."""
    assert draw.low is not None and draw.high is not None
    side, end = ("low", draw.low) if bound.side == "high" else ("high", draw.high)
    yield Bound(side, end, E.TRUE, bound.requirement)
    for other in draw.bounds:
        if other.side != bound.side and other is not bound:
            yield other


def bind(readers: Readers, draw: Draw, one: Inequality) -> list[tuple[Bound, Bound, Scope]]:
    """Turn an inequality into bounds of the variable that is drawn last, as far as it can be solved for it.

    Each is returned twice: as one of the variable's table, and as stated in the rows of the scope that follows.
    """
    column, difference = draw.column, E.sub(one.low, one.high)
    alone = readers.ends(column)
    halves = linear(alone, one.scope, difference, one.guard)
    bent = None
    if halves is None:
        if readers.open_ended(difference):
            return []
        halves = bent = bounds_of(one.low, one.high, one.guard, one.scope, alone)
    found = []
    for half in halves:
        lifted = lift(half.scope, column.scope, half.value, half.guard, half.side)
        if lifted is None or not column.scope.within(lifted[0].scope) or not column.scope.within(lifted[1].scope):
            continue
        if halves is bent and readers.late(column, lifted):
            continue
        bound = Bound(half.side, lifted[0], lifted[1], one.number, one.also)
        if any(b.side == bound.side and b.value is bound.value and b.guard is bound.guard for b in draw.bounds):
            continue
        draw.bounds.append(bound)
        found.append((bound, Bound(half.side, half.value, half.guard, one.number, one.also), half.scope))
    return found


def linear(alone: Ends, scope: Scope, difference: Expr, guard: Expr) -> list[Half] | None:
    """The bound of ``difference <= 0`` that is linear in the variable, with a factor of one sign; None where it is not."""
    form = alone.linear.form(difference)
    if form is None or alone.column not in form[0] or alone.linear.reads(guard):
        return None
    factor = form[0][alone.column]
    least, most = alone.intervals.of(factor)
    if not (least > 0 or most < 0):  # of either sign, or not known: nan
        return None
    return [Half("high" if least > 0 else "low", E.div(E.neg(form[1]), factor), guard, scope)]


def lift(scope: Scope, target: Scope, value: Expr, guard: Expr, side: str) -> tuple[Expr, Expr] | None:
    """A bound stated in ``scope``, as one of the table where the variable is drawn: the tightest of its rows."""
    worst = E.const(float("inf") if side == "high" else float("-inf"))
    while True:
        if target.within(scope):
            return value, guard
        if not scope.within(target) or scope.parent is None:
            return None
        value = E.where(guard, value, worst) if guard is not E.TRUE else value
        guard = E.TRUE
        kind = "min" if side == "high" else "max"
        value = E.reduce(kind, scope, value) if scope.kind == "repeat" else E.phi(scope.parent, [(scope, value)], worst)
        scope = scope.parent
