"""Defined columns written out in an expression."""

from __future__ import annotations

from ...graph import expr as E
from ...graph.expr import Column, Expr
from ...graph.linear import Linear
from ...graph.substitution import substitute


def inline(node: Expr, columns: list[Column], definitions: dict[Column, Expr], *, through: bool = False) -> Expr:
    """An expression with every defined column that depends on one of ``columns`` written out."""
    reader = Linear(lambda c: c in columns, definitions, through=through)
    while True:
        hidden = [c for c in E.leaves(node) if c not in columns and c in definitions and reader.reads(E.col(c))]
        if not hidden:
            return node
        node = substitute(node, {E.col(c): definitions[c] for c in hidden})
