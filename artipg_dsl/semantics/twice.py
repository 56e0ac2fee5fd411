"""What statements say that has no more effect when it is said again: requirements, limits, and what may touch or must not."""

from __future__ import annotations

from collections.abc import Iterator

from ..syntax import ast

_TURNED = {">": "<", ">=": "<="}


def sayings(stmt: ast.Stmt) -> Iterator[tuple[tuple[str, ...], ast.Node, str]]:
    """Each thing that a statement says: what is equal to others that say the same, where it stands, and its words."""
    match stmt:
        case ast.RequireStmt(condition=None):
            yield ("stable", str(stmt.stable)), stmt, stmt.span.words.partition(" else ")[0]
        case ast.RequireStmt() | ast.PreferStmt() if stmt.condition is not None:
            for part in _conjuncts(stmt.condition) if isinstance(stmt, ast.RequireStmt) else (stmt.condition,):
                yield (type(stmt).__name__, *_compared(part)), part, part.span.words
        case ast.ClearStmt():
            pair = sorted((stmt.subject.span.words, stmt.other.span.words))
            yield ("clear", *pair, stmt.distance.span.words, str(stmt.all)), stmt, stmt.span.words
        case ast.AllowStmt():
            pair = sorted(node.span.words for node in ast.present(stmt.subject, stmt.other))
            yield (stmt.kind, *pair), stmt, stmt.span.words.partition(" because ")[0]
        case ast.LimitStmt() | ast.CloseStmt():
            yield ("said", stmt.span.words), stmt, stmt.span.words
        case _:
            pass


def _conjuncts(node: ast.Expr) -> Iterator[ast.Expr]:
    if isinstance(node, ast.BinaryExpr) and node.op == "and":
        yield from _conjuncts(node.left)
        yield from _conjuncts(node.right)
    else:
        yield node


def _compared(node: ast.Expr) -> tuple[str, ...]:
    """The words of a condition; `b > a` is `a < b`, and `b == a` is `a == b`."""
    if not isinstance(node, ast.BinaryExpr):
        return (node.span.words,)
    left, right = _ordered(node.left), _ordered(node.right)
    if node.op in _TURNED:
        return right, _TURNED[node.op], left
    if node.op in _TURNED.values():
        return left, node.op, right
    if node.op in ("==", "!="):
        return min(left, right), node.op, max(left, right)
    return (node.span.words,)


def _ordered(node: ast.Expr) -> str:
    """The words of a number, the terms of a sum and the factors of a product in one order."""
    if not isinstance(node, ast.BinaryExpr) or node.op not in ("+", "-", "*"):
        return node.span.words
    same = ("*",) if node.op == "*" else ("+", "-")
    terms: list[str] = []
    sign = same[0]
    rest: ast.Expr = node
    while isinstance(rest, ast.BinaryExpr) and rest.op in same:
        terms.append(f"{rest.op} {_grouped(rest.right)}")
        rest = rest.left
    return " ".join(sorted([*terms, f"{sign} {_grouped(rest)}"]))


def _grouped(node: ast.Expr) -> str:
    return f"({_ordered(node)})" if isinstance(node, ast.BinaryExpr) and node.op in ("+", "-") else _ordered(node)
