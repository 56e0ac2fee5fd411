"""Actions for what stands in a body: declarations, connections, control, labels."""

from __future__ import annotations

from typing import Any

from ..language import REPEATS
from . import ast
from .build import Piece, body_of, exprs, split_number, tokens, unquote
from .build_expressions import ExpressionBuilder
from .token import Token

Children = list[Any]


class StatementBuilder(ExpressionBuilder):
    # ---------------------------------------------------------------- pieces of declarations

    def domain(self, c: Children) -> Piece:
        return self.piece("in", c[1], c)

    def positive(self, c: Children) -> Piece:
        if float(split_number(c[1].value)[0]):
            self.problem(c[1], "only `> 0` is allowed here", "for other bounds, write a range: `in 1cm .. 2cm`")
        return self.piece(">", True, c)

    def default(self, c: Children) -> Piece:
        return self.piece("=", c[1], c)

    def distribution(self, c: Children) -> Piece:
        found = ast.Distribution(span=self.span(c), name=c[1].value, arguments=c[2].value if len(c) > 2 else ())
        return self.piece("~", found, c)

    def vary(self, c: Children) -> Piece:
        return self.piece("vary", c[1], c)

    def derived(self, c: Children) -> Piece:
        return self.piece("derived", True, c)

    def test(self, c: Children) -> Piece:
        return self.piece("test", c[1], c)

    def was(self, c: Children) -> Piece:
        return self.piece("was", c[1].value, c)

    def param(self, c: Children) -> ast.Stmt:
        found = self.pieces(c)
        names: list[Token] = found["names"]
        return ast.ParamDecl(
            **self.stmt(c),
            keyword=c[0].value,
            names=tuple(t.value for t in names),
            name_spans=tuple(self.at(t) for t in names),
            type=next(x for x in c if isinstance(x, ast.TypeRef)),
            domain=found.get("in"),
            positive=found.get(">", False),
            default=found.get("="),
            distribution=found.get("~"),
            vary=found.get("vary"),
            derived=found.get("derived", False),
            test=found.get("test"),
            was=found.get("was"),
        )

    def count(self, c: Children) -> ast.Stmt:
        found = self.pieces(c)
        for kind in ("vary", "derived", "test"):
            if kind in found:
                piece = next(x for x in c if isinstance(x, Piece) and x.kind == kind)
                self.problem(
                    piece, f"a count cannot take `{kind}`", "`count name in lo .. hi = default ~ distribution`"
                )
        domain = found.get("in")
        if domain is None:
            self.problem(
                c[1],
                f"the count `{c[1].value}` has no range",
                f"for example `count {c[1].value} in 1 .. 4`; a number that is always the same is named by `let {c[1].value} = 3`",
            )
            none = ast.NumberExpr(span=self.at(c[1]), value=0.0, unit="")
            domain = ast.RangeExpr(span=none.span, low=none, high=none)
        return ast.CountDecl(
            **self.stmt(c),
            **self.named(c[1]),
            domain=domain,
            default=found.get("="),
            distribution=found.get("~"),
            was=found.get("was"),
        )

    def let(self, c: Children) -> ast.Stmt:
        return ast.LetDecl(
            **self.stmt(c),
            keyword="let",
            **self.named(c[1]),
            parameters=self.pieces(c).get("parameters", ()),
            value=c[-1],
        )

    # ---------------------------------------------------------------- parts

    def along(self, c: Children) -> ast.Placement:
        return ast.Placement(span=self.span(c), kind="along", direction=c[1])

    def turned(self, c: Children) -> ast.Placement:
        return ast.Placement(span=self.span(c), kind="turned", direction=c[3], angle=c[1])

    def weight(self, c: Children) -> Piece:
        return self.piece("weight", c[1], c)

    def guard(self, c: Children) -> Piece:
        return self.piece("when", c[1], c)

    def reference(self, c: Children) -> Piece:
        return self.piece("reference", c, c)

    def alternative(self, c: Children) -> ast.Alternative:
        found = self.pieces(c)
        head = found["reference"] if "reference" in found else c[:1]
        return ast.Alternative(
            span=self.span(c),
            name=head[0].value if "reference" in found else None,
            name_span=self.at(head[0]),
            arguments=self.pieces(head).get("arguments", ()),
            placements=tuple(x for x in head if isinstance(x, ast.Placement)),
            weight=found.get("weight"),
            guard=found.get("when"),
        )

    def alternatives(self, c: Children) -> Piece:
        return self.piece("alternatives", tuple(x for x in c if isinstance(x, ast.Alternative)), c)

    def part(self, c: Children) -> ast.Stmt:
        root = c[0].type == "ROOT"
        found = self.pieces(c)
        head: Children = found.get("reference", [])
        return ast.PartDecl(
            **self.stmt(c),
            root=root,
            **self.named(c[1 + root]),
            role=head[0].value if head else None,
            role_span=self.at(head[0]) if head else None,
            arguments=self.pieces(head).get("arguments", ()),
            placements=tuple(x for x in head if isinstance(x, ast.Placement)),
            alternatives=found["alternatives"],
            was=found.get("was"),
        )

    def style(self, c: Children) -> ast.Stmt:
        found = self.pieces(c)
        return ast.StyleDecl(
            **self.stmt(c),
            **self.named(c[1]),
            role=c[3].value,
            role_span=self.at(c[3]),
            alternatives=found["alternatives"],
            was=found.get("was"),
        )

    def port_index(self, c: Children) -> Piece:
        return self.piece("index", c[1], c)

    def port_type(self, c: Children) -> Piece:
        return self.piece("type", c[1], c)

    def port(self, c: Children) -> ast.Stmt:
        found = self.pieces(c)
        return ast.PortDecl(
            **self.stmt(c),
            **self.named(c[1]),
            index=found.get("index"),
            optional=bool(tokens(c, "QUESTION")),
            type=found.get("type"),
            value=found.get("="),
        )

    # ---------------------------------------------------------------- connections

    def joint(self, c: Children) -> ast.Stmt:
        optional = bool(tokens(c, "QUESTION"))
        if not tokens(c, "COLON"):
            return ast.JointDecl(**self.stmt(c), **self.named(c[1]), optional=optional)
        at = 3 + optional
        return ast.JointDecl(
            **self.stmt(c),
            **self.named(c[1]),
            optional=optional,
            kind=c[at].value,
            kind_span=self.at(c[at]),
            parent=c[at + 1],
            child=c[at + 3],
            **self.clauses(c),
        )

    def known(self, kind: type[ast.Stmt], clauses: list[ast.Clause[Any]]) -> dict[str, Any]:
        """The clauses of a block in which any word may stand: those that the statement has, and the others."""
        words = ast.clause_words(kind)
        unknown = tuple(c for c in clauses if c.word not in words)
        return {**self.clauses([c for c in clauses if c.word in words]), "unknown": unknown}

    def stable(self, c: Children) -> Piece:
        return self.piece("stable", "open" if len(c) > 1 else "rest", c)

    def otherwise(self, c: Children) -> Piece:
        return self.piece("else", unquote(c[1].value), c)

    def repair(self, c: Children) -> Piece:
        return self.piece("repair", c[1], c)

    def require(self, c: Children) -> ast.Stmt:
        found = self.pieces(c)
        return ast.RequireStmt(
            **self.stmt(c),
            condition=c[1] if isinstance(c[1], ast.Expr) else None,
            stable=found.get("stable"),
            message=found.get("else"),
            repair=found.get("repair"),
        )

    def allow(self, c: Children) -> ast.Stmt:
        word, reason = c[1].value, unquote(c[-1].value)
        return ast.AllowStmt(
            **self.stmt(c), kind=word, subject=c[2], other=c[4] if word == "overlap" else None, reason=reason
        )

    def free(self, c: Children) -> ast.Stmt:
        reason = unquote(c[5].value) if len(c) > 4 else None
        return ast.AllowStmt(**self.stmt(c), kind="free", subject=c[1], other=c[3], reason=reason)

    # ---------------------------------------------------------------- control

    def block(self, c: Children) -> Piece:
        return self.piece("body", tuple(x for x in c if isinstance(x, ast.Stmt)), c)

    def index_name(self, c: Children) -> Piece:
        return self.piece("index", c[1].value, c)

    def repeat_count(self, c: Children) -> Piece:
        low = c[1]
        if not (isinstance(low, ast.NumberExpr) and low.value == 0 and not low.unit):
            self.problem(
                low, "elements must be counted from 0", "write `in 0 ..< n`; the index is then 0, 1, ... n - 1"
            )
        return self.piece("in", c[3], c)

    def repeat(self, c: Children) -> ast.Stmt:
        found = self.pieces(c)
        clauses = self.clauses(c)
        forms = [word for word in clauses if word in REPEATS]
        form = forms[0] if forms else ""
        if len(forms) > 1:
            self.problem(
                clauses[forms[1]], f"a repeat can have only one form, and `{form}` is already given", "keep only one"
            )
        number = found.get("in")
        if form == "ring":
            if number is not None:
                self.problem(clauses[form], "the number of elements is given twice", "`repeat x[k] ring n about axis`")
            number = clauses[form].value
        elif form in ("fill", "mirror"):
            if number is not None:
                fixed = "two elements" if form == "mirror" else "a number of elements that depends on the space"
                self.problem(c[1], f"`{form}` makes {fixed}, so `in 0 ..< n` is not allowed", "leave out the `in`")
        elif number is None:
            self.problem(c[1], f"the repeat `{c[1].value}` has no number of elements", "for example `in 0 ..< 4`")
        return ast.RepeatStmt(
            **self.stmt(c),
            **self.named(c[1]),
            index=found.get("index"),
            count=number,
            form=form,
            body=body_of(c),
            **clauses,
        )

    def when(self, c: Children) -> ast.Stmt:
        otherwise: tuple[ast.Stmt, ...] = ()
        if len(c) > 3:
            otherwise = (c[4],) if isinstance(c[4], ast.Stmt) else c[4].value
        return ast.WhenStmt(**self.stmt(c), guard=c[1], body=c[2].value, otherwise=otherwise)

    # ---------------------------------------------------------------- labels, looks

    def label(self, c: Children) -> ast.Stmt:
        targets, where, value = self.formula(c)
        joint = targets[0] if isinstance(c[4], Token) and c[4].type == "FOR" else None
        return ast.LabelStmt(
            **self.stmt(c),
            vocabulary=c[1].value,
            label=c[3].value,
            label_span=self.at(c[3]),
            targets=targets[joint is not None :],
            joint=joint,
            where=where,
            value=value,
        )

    def field(self, c: Children) -> ast.Stmt:
        targets, where, value = self.formula(c)
        assert value is not None
        return ast.FieldStmt(**self.stmt(c), **self.named(c[1]), type=c[3], targets=targets, where=where, value=value)

    def formula(self, c: Children) -> tuple[tuple[ast.Expr, ...], ast.Expr | None, ast.Expr | None]:
        """What stands behind ``on``: the targets, the condition and the value."""
        at = {token.type: k for k, token in enumerate(c) if isinstance(token, Token)}
        where = c[at["WHERE"] + 1] if "WHERE" in at else None
        value = c[at["EQUAL"] + 1] if "EQUAL" in at else None
        return exprs(c)[: len(exprs(c)) - (where is not None) - (value is not None)], where, value

    def grasp_family(self, c: Children) -> Piece:
        return self.piece("for", (c[1].value, c[3]), c)

    def grasp(self, c: Children) -> ast.Stmt:
        found = self.pieces(c)
        parameter, range_ = found.get("for", (None, None))
        clauses = self.known(ast.GraspStmt, found["properties"])
        for clause in found["properties"]:
            if isinstance(clause.value, ast.RangeExpr):
                self.problem(
                    clause,
                    f"`{clause.word}` of a grasp must be a single value, not a range",
                    "a family of grasps: `grasp g on grip for t in -0.4 .. 0.4 { ... }`",
                )
        return ast.GraspStmt(
            **self.stmt(c), **self.named(c[1]), target=c[3], parameter=parameter, range=range_, **clauses
        )

    def symmetry(self, c: Children) -> ast.Stmt:
        turn = c[4] if c[3].type == "TURN" else None
        if isinstance(turn, ast.NumberExpr) and (turn.unit or turn.value < 2 or turn.value != int(turn.value)):
            self.trouble(
                turn.span,
                "the number of turns of a symmetry must be a whole number, at least 2",
                "use `any` for symmetry at every angle",
            )
        return ast.SymmetryStmt(**self.stmt(c), target=c[1], turn=turn, direction=c[-1])

    def coat(self, c: Children) -> ast.Stmt:
        return ast.MaterialStmt(**self.stmt(c), material=c[1].value, material_span=self.at(c[1]), targets=exprs(c))
