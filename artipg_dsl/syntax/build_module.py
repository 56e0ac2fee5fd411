"""Actions for primitives and for the top level of a file."""

from __future__ import annotations

from typing import Any

from ..source import Span
from . import ast
from .build import Piece, body_of, exprs, tokens
from .build_statements import StatementBuilder

Children = list[Any]

_VERSION = 1
"""The version of the language that this parser reads."""


class TreeBuilder(StatementBuilder):
    # ---------------------------------------------------------------- primitives

    def patch_index(self, c: Children) -> Piece:
        return self._index(c)

    def piece_index(self, c: Children) -> Piece:
        return self._index(c)

    def _index(self, c: Children) -> Piece:
        """``[i in 0 ..< n]`` or ``(i in 0 ..< n)``."""
        self.repeat_count(c[2:-1])
        return self.piece("index", (c[1].value, c[5]), c)

    def surface(self, c: Children) -> ast.Stmt:
        found = self.pieces(c)
        index, number = found.get("index", (None, None))
        at = 3 if index is None else 4
        return ast.SurfaceDecl(
            **self.stmt(c),
            **self.named(c[1]),
            u=c[at].value,
            u_range=c[at + 2],
            v=c[at + 4].value,
            v_range=c[at + 6],
            value=c[at + 9],
            guard=found.get("when"),
            index=index,
            index_count=number,
        )

    def piece_of_chain(self, c: Children) -> ast.CallExpr:
        return ast.CallExpr(span=self.span(c), function=self.name(c[:1]), arguments=c[1].value)

    def chain(self, c: Children) -> ast.Stmt:
        value, rest = c[3], tuple(c[4:])
        first = isinstance(value, ast.CallExpr) and isinstance(value.function, ast.NameExpr)
        if rest and not first:
            self.problem(value, "a chain of curves must begin with a point", "`from([0, 0, 0], z) line(1cm) arc(...)`")
        elif rest or first and value.function.name == "from":
            value = ast.ChainExpr(span=self.span(c[3:]), pieces=(value, *rest))
        return ast.LetDecl(**self.stmt(c), keyword="curve", **self.named(c[1]), parameters=(), value=value)

    def box(self, c: Children) -> ast.Stmt:
        if isinstance(c[2], ast.RangeExpr):
            return ast.BoxDecl(**self.stmt(c), low=c[2].low, high=c[2].high)
        return ast.BoxDecl(**self.stmt(c), value=c[2])

    def hull_points(self, value: ast.Expr) -> tuple[ast.Expr, ...]:
        match value:
            case ast.CallExpr(function=ast.NameExpr(name="hull")) if not any(a.name for a in value.arguments):
                return tuple(a.value for a in value.arguments)
        self.problem(value, "a piece must be the hull of its corners", "write `= hull(a, b, c, d)`")
        return (value,)

    def piece_decl(self, c: Children) -> ast.Stmt:
        found = self.pieces(c)
        index, number = found.get("index", (None, None))
        return ast.PieceDecl(
            **self.stmt(c),
            **self.named(c[1]),
            index=index,
            count=number,
            points=self.hull_points(exprs(c)[0]),
            guard=found.get("when"),
        )

    # ---------------------------------------------------------------- top level

    def refines(self, c: Children) -> Piece:
        return self.piece("refines", c[1], c)

    def _role(self, c: Children) -> tuple[str | None, Span | None]:
        parent = self.pieces(c).get("refines")
        return (parent.value, self.at(parent)) if parent is not None else (None, None)

    def role(self, c: Children) -> ast.Decl:
        parent, parent_span = self._role(c)
        return ast.RoleDecl(**self.stmt(c), **self.named(c[1]), parent=parent, parent_span=parent_span, body=body_of(c))

    def template(self, c: Children) -> ast.Decl:
        role, role_span = self._role(c)
        return ast.TemplateDecl(**self.stmt(c), **self.named(c[1]), role=role, role_span=role_span, body=body_of(c))

    def material(self, c: Children) -> ast.Decl:
        properties = [self.ranged(p) for p in self.pieces(c)["properties"]]
        return ast.MaterialDecl(**self.stmt(c), **self.named(c[1]), **self.known(ast.MaterialDecl, properties))

    def ranged(self, clause: ast.Clause[Any]) -> ast.Clause[ast.RangeExpr]:
        """A property with its range; one value is both ends of it."""
        value = clause.value
        if not isinstance(value, ast.RangeExpr):
            value = ast.RangeExpr(span=value.span, low=value, high=value)
        return ast.Clause(span=clause.span, word=clause.word, value=value)

    def vocabulary(self, c: Children) -> ast.Decl:
        words = tokens(c, "WORD")
        told = {c.index(word): word for word in words}
        motions = {
            told[k - 2].value: c[k].value for k in range(len(c)) if k - 2 in told and c[k].type in ("ALONG", "ABOUT")
        }
        return ast.VocabularyDecl(
            **self.stmt(c),
            **self.named(c[1]),
            words=tuple(t.value for t in words),
            word_spans=tuple(self.at(t) for t in words),
            motions=tuple(motions.get(t.value, "") for t in words),
        )

    def use(self, c: Children) -> ast.UseDecl:
        names = tokens(c, "NAME")[1:]
        return ast.UseDecl(
            span=self.span(c),
            module=c[1].value,
            module_span=self.at(c[1]),
            names=tuple(t.value for t in names),
            name_spans=tuple(self.at(t) for t in names),
        )

    def version(self, c: Children) -> Piece:
        if c[1].value != str(_VERSION):
            self.problem(
                c[1],
                f"this file is written in version {c[1].value} of the language",
                f"this compiler reads `apg {_VERSION}`",
            )
        return self.piece("version", _VERSION, c)

    def module(self, c: Children) -> ast.Module:
        return ast.Module(
            span=Span(self.source, 0, len(self.source.text)),
            version=_VERSION,
            uses=tuple(x for x in c if isinstance(x, ast.UseDecl)),
            declarations=tuple(x for x in c if isinstance(x, ast.Decl)),
        )
