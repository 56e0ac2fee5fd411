"""Coupled equations without a closed form: a block for Newton's method, with its Jacobian derived symbolically."""

from __future__ import annotations

from collections.abc import Sequence

from ...graph import expr as E
from ...graph.derive import derive
from ...graph.expr import CROSSING, Column, Expr
from ...graph.linear import Linear
from ...graph.substitution import rebuild, substitute
from ..expressions.context import Equation, Unknown
from ..expressions.env import Env
from .inline import inline

MOST = 8  # unknowns of one block
RELATIVE, ABSOLUTE = E.const(1e-9), E.const(1e-12)  # how far the two sides of an equation may lie apart
SIZE = E.const(0.1)  # where the search for a size without a domain begins, in metres


def numeric(
    env: Env, unknowns: Sequence[Unknown], equations: Sequence[Equation], differences: Sequence[Expr], guard: Expr
) -> dict[Column, Expr] | None:
    """Values of the unknowns for which all differences are 0; None where they are no formulas over one table.

    That they were found is a requirement, one per equation, where ``guard`` holds.
    """
    columns = [u.column for u in unknowns]
    scope = columns[0].scope
    if len(columns) > MOST or any(c.scope is not scope for c in columns):
        return None
    names = [E.var(f"solve.x{k}") for k in range(len(columns))]
    formulas = _Formulas(dict(zip(columns, names, strict=True)))
    try:
        residuals = [formulas.of(d) for d in differences]
        slopes = [derive(r, x) for r in residuals for x in names]
        starts = [start(env, u, columns, equations) for u in unknowns]
        bundle = E.solve(residuals, slopes, list(formulas.knowns), starts)
        solution = {c: E.root(bundle, k) for k, c in enumerate(columns)}
        if not scope.within(bundle.scope):
            return None
        demand(env, unknowns, equations, solution, guard)
    except (_NoFormula, E.ScopeError):
        return None
    return solution


class _NoFormula(Exception):
    """An unknown is read through another table."""


class _Formulas:
    """Expressions as formulas over ``solve.x0 ...`` for the unknowns and ``solve.p0 ...`` for all that is known."""

    def __init__(self, unknowns: dict[Column, Expr]):
        self.unknowns = unknowns
        self.reader = Linear(lambda c: c in unknowns, {})
        self.knowns: dict[Expr, Expr] = {}

    def of(self, node: Expr) -> Expr:
        if not self.reader.reads(node):
            return node if node.op == "const" else self.knowns.setdefault(node, E.var(f"solve.p{len(self.knowns)}"))
        if node.op == "col":
            return self.unknowns[node.value]
        if node.op in CROSSING or node.op in ("root", "solve"):
            raise _NoFormula
        return rebuild(node, tuple(self.of(a) for a in node.args))


def start(env: Env, unknown: Unknown, columns: Sequence[Column], equations: Sequence[Equation]) -> Expr:
    """Where the search begins, which is what chooses among several roots: what stands behind ``near``, the default, the
    middle of the domain, 0."""
    linear = Linear(lambda c: c in columns, env.context.program.definitions)
    for left, right in (pair for equation in equations for pair in equation.near):
        form = linear.form(E.sub(left, right))
        if form is not None and set(form[0]) == {unknown.column}:
            return E.div(E.neg(form[1]), form[0][unknown.column])
    draw = unknown.draw
    candidates = [unknown.default]
    if draw is not None:
        candidates.append(draw.default)
        if draw.low is not None and draw.high is not None:
            candidates.append(E.mul(E.const(0.5), E.add(draw.low, draw.high)))
    for candidate in candidates:
        if candidate is not None and not E.leaves(candidate) & set(columns):
            return candidate
    return E.ZERO if unknown.kind == "position" else SIZE


def demand(
    env: Env, unknowns: Sequence[Unknown], equations: Sequence[Equation], solution: dict[Column, Expr], guard: Expr
) -> None:
    """Require that both sides of every equation agree: where the search found nothing, the object is drawn again."""
    mapping = {E.col(c): v for c, v in solution.items()}
    named = " and ".join(u.name for u in unknowns)
    definitions = env.context.program.definitions
    for equation in equations:
        sides = [
            substitute(inline(side, list(solution), definitions), mapping) for side in (equation.left, equation.right)
        ]
        apart = E.call("abs", E.sub(*sides))
        size = E.add(E.call("abs", sides[0]), E.call("abs", sides[1]))
        holds = E.call("le", apart, E.add(E.mul(RELATIVE, size), ABSOLUTE))
        scope = E.deepest([holds, guard]) or env.scope
        message = f"no values of {named} were found that solve this"
        env.context.require(scope, holds, equation.span, message, guard, text=equation.text)
