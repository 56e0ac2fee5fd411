"""Expressions with some of their nodes replaced, folded again as when they were built."""

from __future__ import annotations

from collections.abc import Callable, Iterable
from functools import lru_cache

from . import expr as E
from .expr import CROSSING, Expr, Scope


def substitute(root: Expr, mapping: dict[Expr, Expr]) -> Expr:
    """Replace nodes (columns or variables, as a rule) throughout, folding again."""
    return substitute_all((root,), mapping)[0]


def substitute_all(roots: Iterable[Expr], mapping: dict[Expr, Expr]) -> list[Expr]:
    """As ``substitute``, in several expressions; what they share is replaced once."""
    memo = replaced(*mapping, *mapping.values())
    memo.update(mapping)
    sought = 0  # the variables to be replaced; -1 where other nodes are
    for key in mapping:
        sought |= key.reads if key.op == "var" else -1

    def visit(node: Expr) -> Expr:
        if sought >= 0 and not node.reads & sought:
            return node
        done = memo.get(node)
        if done is None:
            args = tuple([visit(a) for a in node.args])
            done = memo[node] = node if args == node.args else rebuild(node, args)
        return done

    return list(map(visit, roots))


@lru_cache(maxsize=256)
def replaced(*mapping: Expr) -> dict[Expr, Expr]:
    """What nodes have become where the first half of some expressions was replaced by the second; operators ask again and again."""
    return {}


_BUILDERS: dict[str, Callable[..., Expr]] = {
    "add": E.add,
    "sub": E.sub,
    "mul": E.mul,
    "div": E.div,
    "neg": E.neg,
    "pow": E.power,
    "and": E.both,
    "or": E.either,
    "not": E.negate,
    "where": E.where,
}


def rebuild(node: Expr, args: tuple[Expr, ...]) -> Expr:
    """A node of the same operation on other arguments."""
    if node.op == "phi":
        scopes: tuple[Scope, ...] = node.value
        assert node.scope is not None
        return E.phi(node.scope, zip(scopes, args[:-1], strict=True), args[-1])
    if node.op in CROSSING:
        return E.raw(node.op, args, node.value, node.scope)
    if node.op in ("solve", "root"):
        return E.raw(node.op, args, node.value)
    return _BUILDERS[node.op](*args) if node.op in _BUILDERS else E.call(node.op, *args)
