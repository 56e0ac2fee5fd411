"""Symbolic partial derivatives of expressions, folded while they are built."""

from __future__ import annotations

from collections.abc import Callable

from .expr import CROSSING, ONE, ZERO, Expr, add, call, const, div, mul, neg, power, show, sub, var, where
from .functions import PREDICATES


def derive(root: Expr, by: Expr | str) -> Expr:
    """The derivative of ``root`` by a variable or column (an expression, or the name of a free variable).

    Where a function has a corner (``abs``, ``min``, ``max``, ``where``) it is the derivative of the branch taken;
    ``floor``, ``ceil``, ``sign`` and predicates have derivative 0. Raises ValueError when ``root`` reads ``by``
    through another table.
    """
    target = var(by) if isinstance(by, str) else by
    memo: dict[int, Expr] = {}
    free = target.op == "var"

    def visit(node: Expr) -> Expr:
        if node is target:
            return ONE
        if not node.args or free and not node.reads & target.reads:
            return ZERO
        done = memo.get(id(node))
        if done is None:
            inner = [ZERO if node.op in PREDICATES else visit(a) for a in node.args]
            if all(d is ZERO for d in inner):
                done = ZERO
            elif node.op in CROSSING or node.op in ("solve", "root"):
                raise ValueError(
                    f"{show(node)} reads {show(target)} through another table, or equations solved together"
                )
            else:
                done = RULES[node.op](*node.args, *inner)
            memo[id(node)] = done
        return done

    return visit(root)


def _power(a: Expr, b: Expr, da: Expr, db: Expr) -> Expr:
    base = mul(mul(b, power(a, sub(b, ONE))), da)
    if db is ZERO:
        return base
    return add(base, mul(mul(call("pow", a, b), call("log", a)), db))


def _square(a: Expr) -> Expr:
    return mul(a, a)


_TWO = const(2.0)
RULES: dict[str, Callable[..., Expr]] = {
    "add": lambda a, b, da, db: add(da, db),
    "sub": lambda a, b, da, db: sub(da, db),
    "mul": lambda a, b, da, db: add(mul(da, b), mul(a, db)),
    "div": lambda a, b, da, db: div(da, b) if db is ZERO else div(sub(mul(da, b), mul(a, db)), _square(b)),
    "neg": lambda a, da: neg(da),
    "pow": _power,
    "abs": lambda a, da: mul(call("sign", a), da),
    "sqrt": lambda a, da: div(da, mul(_TWO, call("sqrt", a))),
    "sin": lambda a, da: mul(call("cos", a), da),
    "cos": lambda a, da: neg(mul(call("sin", a), da)),
    "tan": lambda a, da: div(da, _square(call("cos", a))),
    "asin": lambda a, da: div(da, call("sqrt", sub(ONE, _square(a)))),
    "acos": lambda a, da: neg(div(da, call("sqrt", sub(ONE, _square(a))))),
    "atan": lambda a, da: div(da, add(ONE, _square(a))),
    "atan2": lambda a, b, da, db: div(sub(mul(b, da), mul(a, db)), add(_square(a), _square(b))),
    "hypot": lambda a, b, da, db: div(add(mul(a, da), mul(b, db)), call("hypot", a, b)),
    "exp": lambda a, da: mul(call("exp", a), da),
    "log": lambda a, da: div(da, a),
    "floor": lambda a, da: ZERO,
    "ceil": lambda a, da: ZERO,
    "sign": lambda a, da: ZERO,
    "min": lambda a, b, da, db: where(call("le", a, b), da, db),
    "max": lambda a, b, da, db: where(call("le", b, a), da, db),
    "mod": lambda a, b, da, db: sub(da, mul(call("floor", div(a, b)), db)),
    "where": lambda c, a, b, dc, da, db: where(c, da, db),
}
