"""Warns of repeats that say where their elements lie, and in which nothing goes by that."""

from __future__ import annotations

from collections.abc import Iterator
from typing import TYPE_CHECKING

from ...language import FACES
from ...syntax import ast
from ...syntax.walk import walk

if TYPE_CHECKING:
    from ..program import Lowering

_AXES = "xyz"
_FORMS = ("pitch", "spread", "fill")
_OF_BOX = {*FACES, "center", "size", "box"}


def warn_idle_places(lowering: Lowering) -> None:
    """Report each repeat of the file whose elements lie at a distance along an axis, where no part is placed by its element along it."""
    tree = lowering.root.module.tree
    for declaration in tree.declarations:
        for repeat in walk(declaration):
            if not isinstance(repeat, ast.RepeatStmt) or repeat.form not in _FORMS or repeat.along is None:
                continue
            axis = repeat.along.value.span.words.lstrip("-")
            if axis in _AXES and _idle(lowering, declaration, repeat, _AXES.index(axis)):
                part = next(node for node in walk(repeat.body) if isinstance(node, ast.PartDecl))
                lowering.context.report.warning(
                    "unused",
                    repeat.name_span,
                    f"nothing goes by where the elements of `{repeat.name}` lie: other equations place its parts along {axis}",
                    hint=f"write `align {part.name}.center.{axis} = {repeat.name}.center.{axis}`, or leave `{repeat.form}` and its "
                    f"clauses out: `repeat {repeat.name}[i] in 0 ..< n`",
                )


def _idle(lowering: Lowering, declaration: ast.Node, repeat: ast.RepeatStmt, axis: int) -> bool:
    """Whether the text never names an element as a place, and no part of the body is centred in one along the axis."""
    if any(isinstance(node, ast.NameExpr) and node.name == repeat.name for node in walk(repeat.body)):
        return False
    if any(node.name in _OF_BOX and _is_element(node.obj, repeat.name) for node in _members(declaration)):
        return False
    spans = {node.name_span for node in walk(repeat.body) if isinstance(node, ast.PartDecl)}
    parts = [part for part in lowering.context.parts if part.span in spans]
    return bool(parts) and not any(axis in lowering.context.centred.get(part, ()) for part in parts)


def _members(node: ast.Node) -> Iterator[ast.MemberExpr]:
    return (inner for inner in walk(node) if isinstance(inner, ast.MemberExpr))


def _is_element(node: ast.Expr, name: str) -> bool:
    """Whether an expression is an element of a repeat: ``row``, ``row[0]``."""
    if isinstance(node, ast.IndexExpr):
        node = node.obj
    return isinstance(node, ast.NameExpr) and node.name == name
