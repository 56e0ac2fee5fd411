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
    """Fill ``bounds`` of the draws from the requirements, and weights of choices from those on choices."""
    draws = {d.column: d for d in program.draws}
    order = {d.column: k for k, d in enumerate(program.draws)}
    intervals = Intervals(program.draws, program.definitions)
    pending: list[tuple[Scope, Expr, Expr, Expr, int, int]] = []
    for number, requirement in enumerate(program.requirements):
        if requirement.slack is not None:
            low, high = requirement.slack
            pending.append((requirement.scope, low, high, requirement.guard, number, 0))
        limit_choice(program, draws, order, number)
    made = 0
    while pending:
        scope, low, high, guard, number, depth = pending.pop(0)
        if intervals.of(E.call("le", low, high))[0] >= 1.0:
            continue
        found = bind(program, draws, order, scope, low, high, guard, number)
        if found is None or depth >= DEPTH or made >= MOST_DERIVED:
            continue
        draw, bound, stated = found
        for other in opposite(draw, bound):
            made += 1
            lower, upper = (other, stated) if bound.side == "high" else (stated, other)
            pending.append((scope, lower.value, upper.value, E.both(lower.guard, upper.guard), number, depth + 1))


def limit_choice(program: Program, draws: dict[Column, Draw], order: dict[Column, int], number: int) -> None:
    """A requirement whose names are all known but a choice, which is drawn last, removes alternatives of it."""
    requirement = program.requirements[number]
    reader = Linear(lambda c: c in draws, program.definitions, through=True)
    holds = E.either(E.negate(requirement.guard), requirement.condition)
    guards = [s.count for s in requirement.scope.ancestors() if s.kind == "guard" and s.count is not None]
    names = set().union(*(reader.columns(node) for node in [holds, *guards]))
    if not names:
        return
    last = max(names, key=order.__getitem__)
    draw = draws[last]
    if draw.kind != "choice":
        return
    scope: Scope | None = requirement.scope
    while scope is not None and not last.scope.within(scope):
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
    if scope is None or not last.scope.within(holds.scope):
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
    program: Program, draws: dict[Column, Draw], order: dict[Column, int], scope: Scope, low: Expr, high: Expr, guard: Expr,
    number: int,
) -> tuple[Draw, Bound, Bound] | None:  # fmt: skip
    """Turn ``low <= high`` into a bound of the variable that is drawn last, if it can be solved for it.

    Returned twice: as one of the variable's table, and as stated in ``scope``.
    """
    difference = E.sub(low, high)
    everything = Linear(lambda c: c in draws, program.definitions)
    names = sorted(everything.columns(difference), key=lambda c: -order[c])
    for column in names:
        draw = draws[column]
        if draw.kind == "choice":
            return None
        if reads_later(program, draws, order, guard, column):
            continue
        alone = Linear(lambda c, column=column: c is column, program.definitions)  # type: ignore[misc]
        form = alone.form(difference)
        if form is None or column not in form[0]:
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
        draw.bounds.append(bound)
        return draw, bound, Bound(side, value, guard, number)
    return None


def reads_later(program: Program, draws: dict[Column, Draw], order: dict[Column, int], guard: Expr, column: Column) -> bool:
    """Whether the guard is only known after ``column`` is drawn."""
    reader = Linear(lambda c: c in draws, program.definitions)
    return any(order[c] >= order[column] for c in reader.columns(guard))


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
