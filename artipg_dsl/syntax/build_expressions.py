"""Actions for expressions, ranges, arguments and clauses."""

from __future__ import annotations

import math
import re
import sys
from dataclasses import replace
from typing import Any

from . import ast, dangling
from .build import BuilderBase, Piece, exprs, split_number, unquote
from .token import Token

Children = list[Any]

_PART = re.compile(r"[ \t]+part\b")  # without it a `root` behind a bar is an option, which may be called so


class ExpressionBuilder(BuilderBase):
    def number(self, c: Children) -> ast.Expr:
        value, unit = split_number(c[0].value)
        number = float(value)
        if math.isinf(number):
            number = self.too_large(c[0])
        return ast.NumberExpr(span=self.span(c), value=number, unit=unit)

    def fraction(self, c: Children) -> ast.Expr:
        top, _, bottom = c[0].value.partition("/")
        value, unit = split_number(bottom)
        if not int(value):
            self.problem(c[0], "this divides by zero", "write a divisor other than 0")
            value = "1"
        if unit == "%":
            self.problem(
                c[0],
                f"`{c[0].value}` can be read in two ways",
                f"write `{top} / {value}%` for the quotient, `({top}/{value}) * 1%` for a share of one percent",
            )
        try:
            number = int(top) / int(value)
        except OverflowError:
            number = self.too_large(c[0])
        return ast.NumberExpr(span=self.span(c), value=number, unit=unit)

    def too_large(self, token: Token) -> float:
        self.problem(token, "this number is too large", f"the largest number is {sys.float_info.max:.2g}")
        return 1.0

    def string(self, c: Children) -> ast.Expr:
        return ast.StringExpr(span=self.span(c), value=unquote(c[0].value))

    def name(self, c: Children) -> ast.NameExpr:
        return ast.NameExpr(span=self.span(c), name=c[0].value)

    def hole(self, c: Children) -> ast.Expr:
        return ast.HoleExpr(span=self.span(c))

    def group(self, c: Children) -> ast.Expr:
        return replace(c[1], span=self.span(c))  # so that what it is part of has both parentheses

    def vector(self, c: Children) -> ast.Expr:
        return ast.VectorExpr(span=self.span(c), items=exprs(c))

    def unary(self, c: Children) -> ast.Expr:
        return ast.UnaryExpr(span=self.span(c), op=c[0].value, operand=c[1])

    def binary(self, c: Children) -> ast.Expr:
        if c[1].value in "+-*/^" and c[2].span.text.startswith(
            "+"
        ):  # it would change nothing: what stood before it is lost
            what = f"nothing stands between `{c[1].value}` and `+`"
            self.problem(c[1], what, "write what is missing there, or leave one of the two out")
        return ast.BinaryExpr(span=self.span(c), op=c[1].value, left=c[0], right=c[2])

    def is_test(self, c: Children) -> ast.Expr:
        return ast.IsExpr(span=self.span(c), subject=c[0], type_name=c[2].value, type_span=self.at(c[2]))

    def conditional(self, c: Children) -> ast.Expr:
        return ast.IfExpr(span=self.span(c), then=c[0], condition=c[2], otherwise=c[4])

    def member(self, c: Children) -> ast.Expr:
        return ast.MemberExpr(span=self.span(c), obj=c[0], name=c[2].value, name_span=self.at(c[2]))

    def index(self, c: Children) -> ast.Expr:
        return ast.IndexExpr(span=self.span(c), obj=c[0], index=c[2])

    def call(self, c: Children) -> ast.Expr:
        return ast.CallExpr(span=self.span(c), function=c[0], arguments=c[1].value)

    def path(self, c: Children) -> ast.Expr:
        found: ast.Expr = self.name(c[:1])
        for index in range(2, len(c), 2):
            found = ast.MemberExpr(
                span=self.span(c[: index + 1]), obj=found, name=c[index].value, name_span=self.at(c[index])
            )
        return found

    def range(self, c: Children) -> ast.RangeExpr:
        return ast.RangeExpr(span=self.span(c), low=c[0], high=c[2])

    def motion(self, c: Children) -> ast.RangeExpr:
        """``low .. high``, ``low .. clearance all``."""
        high = c[2]
        if len(c) > 3 and isinstance(high, ast.NameExpr) and high.name == "clearance":
            high = ast.AllExpr(span=self.span(c[2:]), value=high)
        elif len(c) > 3:
            self.problem(c[3], "`all` can only follow `clearance`", "write `range 0deg .. clearance all`")
        return ast.RangeExpr(span=self.span(c), low=c[0], high=high)

    def argument(self, c: Children) -> ast.Argument:
        return ast.Argument(span=self.span(c), name=None, value=c[0])

    def named_argument(self, c: Children) -> ast.Argument:
        return ast.Argument(span=self.span(c), name=c[0].value, value=c[2])

    def arguments(self, c: Children) -> Piece:
        return self.piece("arguments", tuple(a for a in c if isinstance(a, ast.Argument)), c)

    def word(self, value: Any, c: Children) -> ast.Clause[Any]:
        return ast.Clause(span=self.span(c), word=c[0].value, value=value)

    def clause(self, c: Children) -> ast.Clause[Any]:
        """``word e``, ``word low .. high``."""
        return self.word(c[1], c)

    property = clause

    def fit_clause(self, c: Children) -> ast.Clause[Any]:
        return self.word(exprs(c), c)

    def between_clause(self, c: Children) -> ast.Clause[Any]:
        return self.word((c[1], c[3]), c)

    def at_clause(self, c: Children) -> ast.Clause[Any]:
        return self.word(tuple(a for a in c if isinstance(a, ast.Argument)), c)

    def bare_clause(self, c: Children) -> ast.Clause[Any]:
        return self.word(None, c)

    def range_clause(self, c: Children) -> ast.Clause[Any]:
        value = c[1]
        if not isinstance(value, ast.RangeExpr):
            self.problem(
                c[1], "a range of motion needs two ends", "for example `range 0deg .. 90deg`, `range 0cm .. 30cm`"
            )
            value = ast.RangeExpr(span=value.span, low=value, high=value)
        return self.word(value, c)

    def start(self, c: Children) -> ast.Start:
        return ast.Start(span=self.span(c), left=c[0], right=c[2])

    def near(self, c: Children) -> ast.Clause[Any]:
        """``near a = 1cm, b = 2cm``."""
        return self.word(tuple(s for s in c if isinstance(s, ast.Start)), c)

    def properties(self, c: Children) -> Piece:
        return self.piece("properties", [p for p in c if isinstance(p, ast.Clause)], c)

    def names(self, c: Children) -> Piece:
        return self.piece("names", [t for t in c if t.type == "NAME"], c)

    def parameters(self, c: Children) -> Piece:
        return self.piece("parameters", self.words([t for t in c if t.type == "NAME"]), c)

    def words(self, tokens: list[Token]) -> tuple[str, ...]:
        """Words of a list in which each stands once."""
        for at, token in enumerate(tokens):
            if any(token.value == other.value for other in tokens[:at]):
                self.problem(token, f"`{token.value}` appears twice in this list", "keep only one")
        return tuple(t.value for t in tokens)

    def type(self, c: Children) -> ast.TypeRef:
        words = [t for t in c if isinstance(t, Token)]
        span = self.span(c)
        if words[0].type == "STYLE":
            return ast.TypeRef(span=span, name=words[1].value, style=True)
        if words[0].type == "CHOICE":
            bar = dangling.find_bar(words, self.source.text, {"ROOT"})
            if bar is not None and _PART.match(self.source.text, span.end):
                self.problem(bar, dangling.MESSAGE, dangling.HINT)
            return ast.TypeRef(span=span, name="choice", values=self.words([t for t in words[1:] if t.type == "NAME"]))
        if len(words) == 1:
            name = words[0].value
            return ast.TypeRef(span=span, name=name, size=3 if name == "vec" else None)
        size = words[2].value
        if not size.isdigit() or not int(size):
            self.problem(words[2], "the number of components must be a whole number", "for example `length[3]`")
            size = "3"
        return ast.TypeRef(span=span, name=words[0].value, size=int(size))
