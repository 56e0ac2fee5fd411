"""Bounds of an inside function over boxes, by interval arithmetic: whether a whole face lies within a solid.

The rules are those of Moore, "Interval Analysis" (1966), without outward rounding: bounds hold but for the last bits.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from functools import lru_cache

import numpy as np

from ..graph.expr import Expr
from ..graph.primitive import Primitive

_Bounds = tuple[np.ndarray, np.ndarray]
_MONOTONE = {"sqrt": np.sqrt, "exp": np.exp, "atan": np.arctan, "floor": np.floor, "ceil": np.ceil, "sign": np.sign}


@lru_cache(maxsize=512)
def _steps(primitive: Primitive) -> tuple[Expr, ...] | None:
    """The nodes of the inside function, arguments first; None where one has no rule."""
    order: list[Expr] = []
    seen: set[int] = set()

    def visit(node: Expr) -> bool:
        if id(node) in seen:
            return True
        seen.add(id(node))
        if node.op not in _RULES and node.op not in _MONOTONE and node.op not in ("const", "var"):
            return False
        if not all([visit(a) for a in node.args]):
            return False
        order.append(node)
        return True

    return tuple(order) if visit(primitive.inside) else None


def bound_inside(
    primitive: Primitive, params: dict[str, np.ndarray], low: Sequence[np.ndarray], high: Sequence[np.ndarray]
) -> np.ndarray:
    """(m,) bounds from above of the inside function of m instances over boxes ``low .. high`` (three (m,) each).

    ``params`` holds a value per box. Infinite where the function has no bound that the rules tell.
    """
    size = len(low[0])
    steps = _steps(primitive)
    if steps is None:
        return np.full(size, np.inf)
    values: dict[int, _Bounds] = {}
    with np.errstate(all="ignore"):
        for node in steps:
            if node.op == "const":
                one = np.asarray(node.value, dtype=np.float64)
                values[id(node)] = one, one
            elif node.op == "var":
                name = str(node.value)
                axis = {"p.x": 0, "p.y": 1, "p.z": 2}.get(name)
                values[id(node)] = (params[name],) * 2 if axis is None else (low[axis], high[axis])
            elif node.op in _MONOTONE:
                function = _MONOTONE[node.op]
                least, most = values[id(node.args[0])]
                values[id(node)] = function(np.maximum(least, 0.0) if node.op == "sqrt" else least), function(most)
            elif node.op == "mul" and node.args[0] is node.args[1]:
                values[id(node)] = _square(values[id(node.args[0])])
            else:
                values[id(node)] = _RULES[node.op](*(values[id(a)] for a in node.args))
        most = np.broadcast_to(np.asarray(values[id(primitive.inside)][1], dtype=np.float64), (size,))
    return np.where(np.isnan(most), np.inf, most)


def _square(a: _Bounds) -> _Bounds:
    low, high = a[0] * a[0], a[1] * a[1]
    return np.where((a[0] <= 0.0) & (a[1] >= 0.0), 0.0, np.minimum(low, high)), np.maximum(low, high)


def _product(a: _Bounds, b: _Bounds) -> _Bounds:
    every = [x * y for x in a for y in b]
    return np.minimum(np.minimum(every[0], every[1]), np.minimum(every[2], every[3])), np.maximum(
        np.maximum(every[0], every[1]), np.maximum(every[2], every[3])
    )


def _quotient(a: _Bounds, b: _Bounds) -> _Bounds:
    clear = (b[0] > 0.0) | (b[1] < 0.0)
    low, high = _product(a, (1.0 / b[1], 1.0 / b[0]))
    return np.where(clear, low, -np.inf), np.where(clear, high, np.inf)


def _size(a: _Bounds) -> _Bounds:
    return np.maximum(np.maximum(a[0], -a[1]), 0.0), np.maximum(-a[0], a[1])


def _hypot(a: _Bounds, b: _Bounds) -> _Bounds:
    one, two = _size(a), _size(b)
    return np.hypot(one[0], two[0]), np.hypot(one[1], two[1])


_RULES: dict[str, Callable[..., _Bounds]] = {
    "add": lambda a, b: (a[0] + b[0], a[1] + b[1]),
    "sub": lambda a, b: (a[0] - b[1], a[1] - b[0]),
    "neg": lambda a: (-a[1], -a[0]),
    "mul": _product,
    "div": _quotient,
    "abs": _size,
    "hypot": _hypot,
    "min": lambda a, b: (np.minimum(a[0], b[0]), np.minimum(a[1], b[1])),
    "max": lambda a, b: (np.maximum(a[0], b[0]), np.maximum(a[1], b[1])),
}
