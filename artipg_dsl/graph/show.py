"""Expressions as people read them; the exact form is in ``graph.text``."""

from __future__ import annotations

from collections.abc import Callable
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from .expr import Expr

_INFIX = {
    "add": "+",
    "sub": "-",
    "mul": "*",
    "div": "/",
    "pow": "^",
    "lt": "<",
    "le": "<=",
    "eq": "==",
    "and": "and",
    "or": "or",
}


def is_short(node: Expr, most: int) -> bool:
    """Whether the written form of an expression, which repeats what is shared, has at most so many nodes."""
    left, stack = most, [node]
    while stack and left >= 0:
        left -= 1
        stack.extend(stack.pop().args)
    return left >= 0


def show(node: Expr, most: int = 20_000) -> str:
    """A readable form. What is shared is repeated, so after ``most`` nodes there are dots."""
    left = [most]

    def inner(node: Expr) -> str:
        left[0] -= 1
        return "..." if left[0] < 0 else _shown(node, inner)

    return inner(node)


def _shown(node: Expr, show: Callable[[Expr], str]) -> str:
    if node.op == "const":
        return f"{node.value:.9g}" if not isinstance(node.value, bool) else str(node.value).lower()
    if node.op == "col":
        return node.value.path
    if node.op == "var":
        return str(node.value)
    if node.op == "rank":
        return f"rank({node.value.name})"
    if node.op in _INFIX:
        return f"({show(node.args[0])} {_INFIX[node.op]} {show(node.args[1])})"
    if node.op == "neg":
        return f"-{show(node.args[0])}"
    if node.op == "solve":
        return f"newton({', '.join(show(a) + ' = 0' for a in node.args[: node.value[0]])})"
    inner = ", ".join(show(a) for a in node.args)
    if node.op == "phi":
        return f"phi({inner})"
    if node.op == "reduce":
        kind, child = node.value
        return f"{kind}[{child.name}]({inner})"
    if node.op == "root":
        return f"{inner}[{node.value[0]}]"
    return f"{node.op}({inner})"
