"""Requirements to conditional ranges: which draw each inequality narrows, and to what.

An inequality binds the variable among those it names that is drawn last, solved for it where it stands alone. When two
bounds of one variable could exclude one another, that they do not is a new requirement on what was drawn before
(Fourier and Motzkin's elimination), so that later draws find room.
"""

from __future__ import annotations

from collections.abc import Iterator

from ..graph import expr as E
from ..graph.expr import Column, Expr, Scope
from ..graph.interval import Intervals
from ..graph.linear import Linear
from ..graph.program import Bound, Draw, Limit, Program
from .systems import inline

MOST_DERIVED = 400
DEPTH = 6


def attach_bounds(program: Program) -> None:
    """Fill ``bounds`` of the draws and ``limits`` of the choices from the requirements."""
    draws = {d.column: d for d in program.draws}
    order = {d.column: k for k, d in enumerate(program.draws)}
    intervals = Intervals(program.draws, program.definitions)
    reader = Linear(lambda c: c in draws, program.definitions, through=True)
    pending: list[tuple[Scope, Expr, Expr, Expr, int, int]] = []
    for number, requirement in enumerate(program.requirements):
        if requirement.slack is not None:
            low, high = requirement.slack
            pending.append((requirement.scope, low, high, requirement.guard, number, 0))
            continue
        last = last_drawn(reader, order, requirement.scope, requirement.condition, requirement.guard)
        if last is not None and draws[last].kind == "choice":
            limit_choice(program, reader, draws[last], requirement.scope, requirement.condition, requirement.guard, number)
    made = 0
    while pending:
        scope, low, high, guard, number, depth = pending.pop(0)
        if intervals.of(E.call("le", low, high))[0] >= 1.0:
            continue
        last = last_drawn(reader, order, scope, E.sub(low, high), guard)
        if last is None:
            continue
        if draws[last].kind == "choice":
            limit_choice(program, reader, draws[last], scope, E.call("le", low, high), guard, number)
            continue
        found = bind(program, draws[last], scope, low, high, guard, number)
        if found is None or depth >= DEPTH or made >= MOST_DERIVED:
            continue
        draw, bound, stated = found
        for other in opposite(draw, bound):
            made += 1
            lower, upper = (other, stated) if bound.side == "high" else (stated, other)
            pending.append((scope, lower.value, upper.value, E.both(lower.guard, upper.guard), number, depth + 1))


def last_drawn(reader: Linear, order: dict[Column, int], scope: Scope, *nodes: Expr) -> Column | None:
    """Of all that a requirement names, the choices that its table stands under included, what is drawn last."""
    guards = [s.count for s in scope.ancestors() if s.kind == "guard" and s.count is not None]
    names = set().union(*(reader.columns(node) for node in [*nodes, *guards]))
    return max(names, key=order.__getitem__, default=None)


def limit_choice(
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


def opposite(draw: Draw, bound: Bound) -> Iterator[Bound]:
    """The domain's other end, and the bounds on the other side that come from other requirements."""
    assert draw.low is not None and draw.high is not None
    if bound.side == "high":
        yield Bound("low", draw.low, E.TRUE, bound.requirement)
    else:
        yield Bound("high", draw.high, E.TRUE, bound.requirement)
    for other in draw.bounds:
        if other.side != bound.side and other is not bound:
            yield other


def bind(
    program: Program, draw: Draw, scope: Scope, low: Expr, high: Expr, guard: Expr, number: int
) -> tuple[Draw, Bound, Bound] | None:
    """Turn ``low <= high`` into a bound of the variable that is drawn last, if it can be solved for it.

    Returned twice: as one of the variable's table, and as stated in ``scope``.
    """
    column = draw.column
    alone = Linear(lambda c: c is column, program.definitions, through=True)
    form = alone.form(E.sub(low, high))
    if form is None or column not in form[0] or alone.reads(guard):
        return None
    factor = form[0][column]
    sign = sign_of(program, factor)
    if sign == 0:
        return None
    value = E.div(E.neg(form[1]), factor)
    side = "high" if sign > 0 else "low"
    lifted = lift(scope, column.scope, value, guard, side)
    if lifted is None:
        return None
    bound = Bound(side, lifted[0], lifted[1], number)
    if any(b.side == side and b.value is bound.value and b.guard is bound.guard for b in draw.bounds):
        return None
    draw.bounds.append(bound)
    return draw, bound, Bound(side, value, guard, number)


def sign_of(program: Program, factor: Expr) -> int:
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
