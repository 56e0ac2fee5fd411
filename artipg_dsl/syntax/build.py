"""The parser's actions: each rule of the grammar to a node of the tree, with its span taken from its own children.

A method bears the name of a rule and gets its children, tokens included. Rules that are not nodes of their own give
a ``Piece`` (a value with its place) or a ``Clause``. A statement whose rule is called like its node needs no method.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from dataclasses import fields
from functools import partial
from keyword import iskeyword
from typing import Any, NamedTuple

from ..source import Source, Span
from . import ast
from .layout import Layout
from .token import Token


class Piece(NamedTuple):
    """A part of a declaration: which one (``kind``), its value, where it stands."""

    kind: str
    value: Any
    start: int
    end: int


_SIGNS = {"=": "the default", "~": "the distribution", ">": "the bound"}


class Problem(NamedTuple):
    """Something the grammar takes and the language does not."""

    span: Span
    message: str
    hint: str | None


def _start_of(child: Any) -> int:
    if isinstance(child, ast.Node):
        return child.span.start
    return child.start_pos if isinstance(child, Token) else child.start


def _end_of(child: Any) -> int:
    if isinstance(child, ast.Node):
        return child.span.end
    return child.end_pos if isinstance(child, Token) else child.end


def split_number(text: str) -> tuple[str, str]:
    """``5cm`` to ``5`` and ``cm``; ``2e3mm`` to ``2e3`` and ``mm``."""
    at = 0
    while at < len(text) and (text[at].isdigit() or text[at] == "."):
        at += 1
    if text[at : at + 1] in ("e", "E"):
        rest = at + 1 + (text[at + 1 : at + 2] in ("+", "-"))
        if text[rest : rest + 1].isdigit():
            at = rest
            while at < len(text) and text[at].isdigit():
                at += 1
    return text[:at], text[at:]


def unquote(text: str) -> str:
    out, index, body = [], 0, text[1:-1]
    while index < len(body):
        char = body[index]
        if char == "\\":
            index += 1
            char = {"n": "\n", "t": "\t"}.get(body[index], body[index])
        out.append(char)
        index += 1
    return "".join(out)


class BuilderBase:
    """What all actions share: spans, docs, picking children."""

    def __init__(self, layout: Layout) -> None:
        self.layout = layout
        self.source = Source("", "")
        self.problems: list[Problem] = []

    def begin(self, source: Source) -> None:
        self.source = source
        self.problems = []

    def span(self, children: Sequence[Any]) -> Span:
        return Span(self.source, _start_of(children[0]), _end_of(children[-1]))

    def at(self, child: Any) -> Span:
        return Span(self.source, _start_of(child), _end_of(child))

    def stmt(self, children: Sequence[Any]) -> dict[str, Any]:
        """``span`` and ``doc`` of a statement."""
        start, end = _start_of(children[0]), _end_of(children[-1])
        return {"span": Span(self.source, start, end), "doc": self.layout.doc(start, end)}

    def named(self, token: Token) -> dict[str, Any]:
        return {"name": token.value, "name_span": self.at(token)}

    def piece(self, kind: str, value: Any, children: Sequence[Any]) -> Piece:
        return Piece(kind, value, _start_of(children[0]), _end_of(children[-1]))

    def problem(self, child: Any, message: str, hint: str | None = None) -> None:
        self.trouble(self.at(child), message, hint)

    def trouble(self, place: Span, message: str, hint: str | None) -> None:
        self.problems.append(Problem(place, message, hint))

    def pieces(self, children: Sequence[Any]) -> dict[str, Any]:
        """The values of the pieces among the children by kind; one that is given twice is a problem."""
        found: dict[str, Any] = {}
        for child in children:
            if isinstance(child, Piece):
                if child.kind in found:
                    what = _SIGNS.get(child.kind, f"`{child.kind}`")
                    self.problem(child, f"{what} is given twice", "keep only one")
                found[child.kind] = child.value
        return found

    def clauses(self, c: Sequence[Any]) -> dict[str, Any]:
        """The clauses among the children by the field of the tree that holds each; one that is given twice is a problem."""
        found: dict[str, ast.Clause[Any]] = {}
        for clause in c:
            if isinstance(clause, ast.Clause):
                field = clause.word + "_" * iskeyword(clause.word)
                if field in found:
                    self.problem(clause, f"`{clause.word}` is given twice", "keep only one")
                found.setdefault(field, clause)
        return found

    def __getattr__(self, rule: str) -> Callable[[Sequence[Any]], ast.Stmt]:
        """The action of a rule without a method: it makes the statement of that name as its fields say."""
        if rule not in KINDS:
            raise AttributeError(rule)
        return partial(self._made, KINDS[rule])

    def _made(self, kind: type[ast.Stmt], c: Sequence[Any]) -> ast.Stmt:
        """A statement from its children: what is named like a field, or else names, ranges and expressions in the order of the text."""
        found = {**self.stmt(c), **self.pieces(c), **self.clauses(c)}
        names, values = iter(tokens(c, "NAME")), iter(exprs(c))
        ranges = iter([x for x in c if isinstance(x, ast.RangeExpr)])
        for field in fields(kind):
            match field.type:
                case _ if field.name in found:
                    pass
                case "str":
                    token = next(names)
                    found |= {field.name: token.value, f"{field.name}_span": self.at(token)}
                case "bool":
                    found[field.name] = bool(tokens(c, _MARKS.get(field.name, field.name.upper())))
                case "RangeExpr":
                    found[field.name] = next(ranges)
                case "Expr" | "Expr | None":
                    found[field.name] = next(values, None)
                case "tuple[Expr, ...]":
                    found[field.name] = tuple(values)
                case "tuple[str, ...]":
                    found[field.name] = ()
        return kind(**{name: found[name] for name in kind.__dataclass_fields__ if name in found})


def _kinds(kind: type[ast.Stmt]) -> Iterator[type[ast.Stmt]]:
    for inner in kind.__subclasses__():
        yield inner
        yield from _kinds(inner)


KINDS: dict[str, type[ast.Stmt]] = {
    kind.__name__.removesuffix("Stmt").removesuffix("Decl").lower(): kind for kind in _kinds(ast.Stmt)
}
"""By the names of their rules: the statements that are built as their fields say."""
_MARKS = {"optional": "QUESTION"}


def exprs(children: Sequence[Any]) -> tuple[ast.Expr, ...]:
    return tuple(c for c in children if isinstance(c, ast.Expr))


def tokens(children: Sequence[Any], kind: str) -> list[Token]:
    return [c for c in children if isinstance(c, Token) and c.type == kind]


def body_of(children: Sequence[Any]) -> tuple[ast.Stmt, ...]:
    return next((c.value for c in children if isinstance(c, Piece) and c.kind == "body"), ())
