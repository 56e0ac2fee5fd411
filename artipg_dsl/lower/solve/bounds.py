"""Requirements to conditional ranges: which draw each inequality narrows, and to what.

An inequality binds the variable among those it names that is drawn last, solved for it where it stands alone. When two
bounds of one variable could exclude one another, that they do not is a new requirement on what was drawn before
(Fourier and Motzkin's elimination), so that later draws find room.
"""

from __future__ import annotations

import math
from collections.abc import Iterator

from ...graph import expr as E
from ...graph.depend import columns_behind
from ...graph.expr import Column, Expr, Scope
from ...graph.inequality import Half, bounds_of, least_of
from ...graph.interval import Intervals
from ...graph.linear import Linear, LinearForm
from ...graph.program import Bound, Draw, Limit, Program
from .inline import inline
from .unions import unite

_MOST_DERIVED = 400
DEPTH = 24


def attach_bounds(program: Program) -> list[tuple[Scope, tuple[int, ...]]]:
    """Fill ``bounds`` of the draws and ``limits`` of the choices from the requirements.

    Returns the requirements that contradict one another whatever is drawn, with the rows in which they do.
    """
    hollow: list[tuple[Scope, tuple[int, ...]]] = []
    draws = {d.column: d for d in program.draws}
    order = {d.column: k for k, d in enumerate(program.draws)}
    intervals = Intervals(program.draws, program.definitions)
    reader = Linear(lambda c: c in draws, program.definitions, through=True)
    pending: list[tuple[Scope, Expr, Expr, Expr, int, int, tuple[int, ...]]] = []
    for number, requirement in enumerate(program.requirements):
        if requirement.slack is not None:
            low, high = requirement.slack
            pending.append((requirement.scope, low, high, requirement.guard, number, 0, ()))
            continue
        last = _last_drawn(reader, order, requirement.scope, requirement.condition, requirement.guard)
        if last is None:
            continue
        if draws[last].kind == "choice":
            _limit_choice(
                program, reader, draws[last], requirement.scope, requirement.condition, requirement.guard, number
            )
            continue
        whole = E.either(E.negate(requirement.guard), requirement.condition)
        rest = unite(program, order, draws[last], requirement.scope, whole, number)
        if rest is not None:
            pending.append((requirement.scope, *rest, E.TRUE, number, 1, ()))
    made = {False: 0, True: 0}  # derived from linear bounds, and from others
    told: dict[object, float] = {}
    while pending:
        scope, low, high, guard, number, depth, also = pending.pop(0)
        if intervals.of(E.call("le", low, high))[0] >= 1.0:
            continue
        last = _last_drawn(reader, order, scope, E.sub(low, high), guard)
        if last is None:
            continue
        if draws[last].kind == "choice":
            _limit_choice(program, reader, draws[last], scope, E.call("le", low, high), guard, number)
            continue
        form = reader.form(E.sub(low, high))
        if depth and guard is E.TRUE and form is not None and not form[0] and form[1].constant is not None:
            if form[1].constant > 1e-9:
                hollow.append((scope, (number, *also)))
            continue
        if form is not None and _weaker(form, scope, guard, last, told) and depth:
            continue
        if parted(low, high, guard, last, program):
            rest = unite(
                program, order, draws[last], scope, E.either(E.negate(guard), E.call("le", low, high)), number, also
            )
            if rest is not None and depth < DEPTH and made[True] < _MOST_DERIVED:
                made[True] += 1
                pending.append((scope, *rest, E.TRUE, number, depth + 1, also))
        bent = linear(program, last, scope, low, high, guard) is None and not _open_ended(E.sub(low, high))
        if bent and depth < DEPTH and made[bent] < _MOST_DERIVED:  # that the value drawn last has a chance at all
            least = least_of(E.sub(low, high), last, intervals, program.definitions)
            if least is not None and scope.within(least.scope) and not _late(program, order, last, [least, guard]):
                made[bent] += 1
                pending.append((scope, least, E.ZERO, guard, number, depth + 1, also))
        for draw, bound, stated, inner in bind(program, order, draws[last], scope, low, high, guard, number, also):
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


def parted(low: Expr, high: Expr, guard: Expr, column: Column, program: Program) -> bool:
    """Whether an inequality may leave a variable several intervals: its guard reads it, or it is not linear in it."""
    alone = _reader_of(column, program)
    return alone.reads(guard) or alone.form(E.sub(low, high)) is None


def _last_drawn(reader: Linear, order: dict[Column, int], scope: Scope, *nodes: Expr) -> Column | None:
    """Of all that a requirement names, the choices that its table stands under included, what is drawn last."""
    guards = [s.count for s in scope.ancestors() if s.kind == "guard" and s.count is not None]
    names = set().union(*(reader.columns(node) for node in [*nodes, *guards]))
    return max(names, key=order.__getitem__, default=None)


def _limit_choice(
    program: Program, reader: Linear, draw: Draw, scope: Scope, condition: Expr, guard: Expr, number: int
) -> None:
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
        elif last not in reader.columns(scope.count):
            holds = E.phi(scope.parent, [(scope, holds)], E.TRUE)
        else:
            return
        scope = scope.parent
    if not last.scope.within(holds.scope):
        return
    holds = inline(holds, [last], program.definitions)
    for code in range(len(draw.options)):
        allowed = E.substitute(holds, {E.col(last): E.const(float(code))})
        if allowed is not E.TRUE:
            draw.limits.append(Limit(code, allowed, number))


def _opposite(draw: Draw, bound: Bound) -> Iterator[Bound]:
    """The domain's other end, and the bounds on the other side that come from other requirements."""
    assert draw.low is not None and draw.high is not None
    side, end = ("low", draw.low) if bound.side == "high" else ("high", draw.high)
    yield Bound(side, end, E.TRUE, bound.requirement)
    for other in draw.bounds:
        if other.side != bound.side and other is not bound:
            yield other


def bind(
    program: Program,
    order: dict[Column, int],
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
    column = draw.column
    halves = linear(program, column, scope, low, high, guard)
    bent = None
    if halves is None:
        if _open_ended(E.sub(low, high)):
            return []
        intervals = Intervals(program.draws, program.definitions)
        halves = bent = bounds_of(low, high, guard, scope, column, intervals, program.definitions)
    found = []
    for half in halves:
        lifted = lift(half.scope, column.scope, half.value, half.guard, half.side)
        if lifted is None or not column.scope.within(lifted[0].scope) or not column.scope.within(lifted[1].scope):
            continue
        if halves is bent and _late(program, order, column, [*lifted]):
            continue
        bound = Bound(half.side, lifted[0], lifted[1], number, also)
        if any(b.side == bound.side and b.value is bound.value and b.guard is bound.guard for b in draw.bounds):
            continue
        draw.bounds.append(bound)
        found.append((draw, bound, Bound(half.side, half.value, half.guard, number, also), half.scope))
    return found


def _open_ended(root: Expr) -> bool:
    """Whether an expression says "no bound" in some rows: it comes from bounds of other alternatives."""
    return any(node.op == "const" and math.isinf(node.value) for node in E.nodes(root))


def _late(program: Program, order: dict[Column, int], column: Column, roots: list[Expr]) -> bool:
    """Whether expressions need the column itself or what is drawn after it, be it to count the rows they stand in."""
    return any(order.get(c, -1) >= order[column] for c in columns_behind(program, roots))


def _reader_of(column: Column, program: Program) -> Linear:
    """Linear forms in one column, read through the definitions."""
    return Linear(lambda c: c is column, program.definitions, through=True)


def linear(program: Program, column: Column, scope: Scope, low: Expr, high: Expr, guard: Expr) -> list[Half] | None:
    """The bound of an inequality that is linear in the variable, with a factor of one sign; None where it is not."""
    alone = _reader_of(column, program)
    form = alone.form(E.sub(low, high))
    if form is None or column not in form[0] or alone.reads(guard):
        return None
    factor = form[0][column]
    sign = _sign_of(program, factor)
    if sign == 0:
        return None
    return [Half("high" if sign > 0 else "low", E.div(E.neg(form[1]), factor), guard, scope)]


def _sign_of(program: Program, factor: Expr) -> int:
    low, high = Intervals(program.draws, program.definitions).of(factor)
    return 1 if low > 0 else -1 if high < 0 else 0


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
