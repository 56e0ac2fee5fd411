"""What a file declares, and what these declare in turn: for the outline beside a text."""

from __future__ import annotations

from collections.abc import Iterator

from ..records import dataclass
from ..semantics.symbols import KINDS, NAMED, Named
from ..source import Span
from ..syntax import ast
from .analysis import Analysis


@dataclass(frozen=True, slots=True)
class Item:
    """A declaration: its name, what it is (template, part, joint, ...), all of it, its name alone, and what is in it."""

    name: str
    kind: str
    span: Span
    name_span: Span
    inner: tuple[Item, ...] = ()


def outline(analysis: Analysis) -> list[Item]:
    """The declarations of a file in the order of its text."""
    if analysis.module is None:
        return []
    found = []
    for decl in analysis.module.tree.declarations:
        inner = tuple(_items(getattr(decl, "body", ())))
        found.append(Item(decl.name, KINDS[type(decl)], decl.span, decl.name_span, inner))
    return found


def _items(body: tuple[ast.Stmt, ...]) -> Iterator[Item]:
    for stmt in body:
        match stmt:
            case ast.ParamDecl(names=names, name_spans=spans, keyword=keyword):
                yield from (Item(name, keyword, stmt.span, span) for name, span in zip(names, spans, strict=True))
            case ast.RepeatStmt(name=name, name_span=span, body=inner):
                yield Item(name, "repeat", stmt.span, span, tuple(_items(inner)))
            case ast.WhenStmt(body=inner, otherwise=otherwise):
                yield from _items((*inner, *otherwise))
            case _ if isinstance(stmt, Named):
                yield Item(stmt.name, NAMED[type(stmt)], stmt.span, stmt.name_span)
