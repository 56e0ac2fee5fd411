"""All nodes in a node of the tree."""

from __future__ import annotations

from collections.abc import Iterator

from .ast import BinaryExpr, Expr, IndexExpr, MemberExpr, Node, Stmt, VectorExpr, WhenStmt
from .data import inner


def walk(node: object) -> Iterator[Node]:
    """A node, then all nodes in it, in the order of the text; the nodes of a tuple of them."""
    if isinstance(node, Node):
        yield node
        for name in inner(node):
            yield from walk(getattr(node, name))
    elif isinstance(node, tuple):
        for item in node:
            yield from walk(item)


def children(node: Node) -> Iterator[Node]:
    """The nodes that stand in a node itself."""
    held = [getattr(node, name) for name in inner(node)]
    while held:
        match held.pop(0):
            case Node() as below:
                yield below
            case tuple() as items:
                held[:0] = items


def path_root(node: Expr) -> Expr:
    """What a path of members and indices begins with."""
    while isinstance(node, MemberExpr | IndexExpr):
        node = node.obj
    return node


def put_together(node: Expr) -> list[Expr]:
    """What ``a and b`` joins, or ``[a, b]`` lists, in order; nothing where neither is written."""
    if isinstance(node, VectorExpr):
        return list(node.items)
    if not isinstance(node, BinaryExpr) or node.op not in ("and", "or"):
        return []
    found: list[Expr] = [node]
    while isinstance(last := found[0], BinaryExpr) and last.op in ("and", "or"):
        found[:1] = [last.left, last.right]
    return found


def in_branches(body: tuple[Stmt, ...]) -> Iterator[Stmt]:
    """The statements of a body, each `when` before those in its branches; those inside a `repeat` not."""
    for stmt in body:
        yield stmt
        if isinstance(stmt, WhenStmt):
            yield from in_branches(stmt.body)
            yield from in_branches(stmt.otherwise)


def too_deep(tree: Node, most: int) -> Node | None:
    """A node within more than ``most`` others, the outermost of the first such; the passes go down a tree by a call for each."""
    inside: list[tuple[Node, int]] = [(tree, 0)]
    while inside:
        node, depth = inside.pop()
        if depth > most:
            return node
        held = [getattr(node, name) for name in inner(node)]
        while held:
            value = held.pop()
            if isinstance(value, tuple):
                held += value
            elif isinstance(value, Node):
                inside.append((value, depth + 1))
    return None
