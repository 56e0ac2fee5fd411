"""Requirements to conditional ranges: which draw each inequality narrows, and to what.

An inequality binds the variable among those it names that is drawn last, solved for it where it stands alone. When two
bounds of one variable could exclude one another, that they do not is a new requirement on what was drawn before
(Fourier and Motzkin's elimination), so that later draws find room.
"""

from __future__ import annotations

from collections.abc import Collection, Iterator

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


def attach_bounds(program: Program, strict: Collection[int]) -> list[tuple[Scope, tuple[int, ...]]]:
    """Fill ``bounds`` of the draws and ``limits`` of the choices from the requirements.

    The sides of the requirements ``strict`` must differ, if only a little. Returns the requirements that contradict one another
    whatever is drawn, with the rows in which they do.
    """
    apart = frozenset(strict)
    hollow: list[tuple[Scope, tuple[int, ...]]] = []
    draws = {d.column: d for d in program.draws}
    readers = Readers(program)
    pending: list[tuple[Scope, Expr, Expr, Expr, int, int, tuple[int, ...]]] = []
    for number, requirement in enumerate(program.requirements):
        if requirement.slack is not None:
            low, high = requirement.slack
            pending.append((requirement.scope, low, high, requirement.guard, number, 0, ()))
            continue
        last = readers.last(requirement.scope, requirement.condition, requirement.guard)
        if last is None:
            continue
        if draws[last].kind == "choice":
            _limit_choice(readers, draws[last], requirement.scope, requirement.condition, requirement.guard, number)
            continue
        whole = E.either(E.negate(requirement.guard), requirement.condition)
        rest = unite(readers, draws[last], requirement.scope, whole, number)
        if rest is not None:
            pending.append((requirement.scope, *rest, E.TRUE, number, 1, ()))
    made = {False: 0, True: 0}  # derived from linear bounds, and from others
    told: dict[object, float] = {}
    while pending:
        scope, low, high, guard, number, depth, also = pending.pop(0)
        if depth and guard is E.TRUE and not apart.isdisjoint((number, *also)):
            form = readers.drawn.form(E.sub(low, high))
            left = None if form is None or form[0] else form[1].constant
            if left is not None and abs(left) < 1e-12:  # they meet, and must not
                hollow.append((scope, (number, *also)))
                continue
        if readers.intervals.of(E.call("le", low, high))[0] >= 1.0:
            continue
        difference = E.sub(low, high)
        last = readers.last(scope, difference, guard)
        if last is None:
            continue
        if draws[last].kind == "choice":
            _limit_choice(readers, draws[last], scope, E.call("le", low, high), guard, number)
            continue
        form = readers.drawn.form(difference)
        if depth and guard is E.TRUE and form is not None and not form[0] and form[1].constant is not None:
            if form[1].constant > 1e-9:
                hollow.append((scope, (number, *also)))
            continue
        if form is not None and _weaker(form, scope, guard, last, told) and depth:
            continue
        alone = readers.ends(last)
        if alone.linear.reads(guard) or alone.linear.form(difference) is None:  # it may leave several intervals
            whole = E.either(E.negate(guard), E.call("le", low, high))
            rest = unite(readers, draws[last], scope, whole, number, also)
            if rest is not None and depth < DEPTH and made[True] < _MOST_DERIVED:
                made[True] += 1
                pending.append((scope, *rest, E.TRUE, number, depth + 1, also))
        bent = linear(alone, scope, difference, guard) is None and not readers.open_ended(difference)
        if bent and depth < DEPTH and made[bent] < _MOST_DERIVED:  # that the value drawn last has a chance at all
            least = least_of(difference, alone)
            if least is not None and scope.within(least.scope) and not readers.late(last, [least, guard]):
                made[bent] += 1
                pending.append((scope, least, E.ZERO, guard, number, depth + 1, also))
        for draw, bound, stated, inner in bind(readers, draws[last], scope, low, high, guard, number, also):
            if depth >= DEPTH or made[bent] >= _MOST_DERIVED:
                break
            for other in _opposite(draw, bound):
                made[bent] += 1
                lower, upper = (other, stated) if bound.side == "high" else (stated, other)
                reasons = tuple(
                    dict.fromkeys((*also, *other.also, *(() if other.requirement == number else (other.requirement,))))
                )
                pending.append(
                    (inner, lower.value, upper.value, E.both(lower.guard, upper.guard), number, depth + 1, reasons)
                )
    return hollow


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


def bind(
    readers: Readers,
    draw: Draw,
    scope: Scope,
    low: Expr,
    high: Expr,
    guard: Expr,
    number: int,
    also: tuple[int, ...] = (),
) -> list[tuple[Draw, Bound, Bound, Scope]]:
    """Turn ``low <= high`` into bounds of the variable that is drawn last, as far as it can be solved for it.

    Each is returned twice: as one of the variable's table, and as stated in the rows of the scope that follows.
    """
    column, difference = draw.column, E.sub(low, high)
    alone = readers.ends(column)
    halves = linear(alone, scope, difference, guard)
    bent = None
    if halves is None:
        if readers.open_ended(difference):
            return []
        halves = bent = bounds_of(low, high, guard, scope, alone)
    found = []
    for half in halves:
        lifted = lift(half.scope, column.scope, half.value, half.guard, half.side)
        if lifted is None or not column.scope.within(lifted[0].scope) or not column.scope.within(lifted[1].scope):
            continue
        if halves is bent and readers.late(column, lifted):
            continue
        bound = Bound(half.side, lifted[0], lifted[1], number, also)
        if any(b.side == bound.side and b.value is bound.value and b.guard is bound.guard for b in draw.bounds):
            continue
        draw.bounds.append(bound)
        found.append((draw, bound, Bound(half.side, half.value, half.guard, number, also), half.scope))
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
