"""Rules of the grammar to nodes of the syntax tree, while the parser runs."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from typing import Any

from lark import Token, Transformer, v_args

from ..source import Source, Span
from . import ast

Child = Any  # a token, a node, or a list that a helper rule made


class Raw:
    """A helper rule's children with its span, for the rule above it."""

    __slots__ = ("rule", "children", "span")

    def __init__(self, rule: str, children: Sequence[Child], span: Span):
        self.rule, self.children, self.span = rule, list(children), span


HELPERS = (
    "domain", "positive", "default", "drawn", "vary", "derived", "test", "was", "weight", "guard", "parameters",
    "call_arguments", "arguments", "item", "names", "index", "body", "version", "link",
)  # fmt: skip


@v_args(inline=False)
class Builder(Transformer):
    """One instance per parse: it knows the source, for spans and for doc comments."""

    def __init__(self, source: Source):
        super().__init__(visit_tokens=False)
        self.source = source
        self.comments: list[Token] = []
        for rule in HELPERS:
            setattr(self, rule, lambda children, rule=rule: Raw(rule, children, self.span(children)))

    # ------------------------------------------------------------ helpers

    def at(self, child: Child) -> Span:
        if isinstance(child, Token):
            return Span(self.source, child.start_pos or 0, child.end_pos or 0)
        return child.span

    def span(self, children: Sequence[Child]) -> Span:
        real = [c for c in children if c is not None]
        if not real:
            return Span(self.source, 0, 0)
        return self.at(real[0]).to(self.at(real[-1]))

    def doc(self, span: Span) -> str:
        """The ``##`` comments on the lines right above a statement, or behind it on its first line."""
        line, found = span.line, []
        by_line = {c.line: c for c in reversed(self.comments) if c.startswith("##")}
        above = line - 1
        while above in by_line and not self.source.line(above).split("#")[0].strip():
            found.insert(0, by_line[above].lstrip("#").strip())
            above -= 1
        if not found and line in by_line and (by_line[line].start_pos or 0) > span.start:
            found.append(by_line[line].lstrip("#").strip())
        return " ".join(found)

    def words(self, children: Sequence[Child], kind: str = "NAME") -> list[Token]:
        return [c for c in children if isinstance(c, Token) and c.type == kind]

    def exprs(self, children: Sequence[Child]) -> list[ast.Expr]:
        return [c for c in children if isinstance(c, ast.Expr)]

    def find(self, children: Sequence[Child], rule: str) -> Raw | None:
        return next((c for c in children if isinstance(c, Raw) and c.rule == rule), None)

    def has(self, children: Sequence[Child], kind: str) -> bool:
        return any(isinstance(c, Token) and c.type == kind for c in children)

    def text(self, children: Sequence[Child]) -> str | None:
        found = self.words(children, "STRING")
        return unquote(found[0]) if found else None

    def statements(self, raw: Raw) -> tuple[ast.Stmt, ...]:
        return tuple(c for c in raw.children if isinstance(c, ast.Stmt))

    def call_values(self, raw: Raw | None) -> tuple[ast.Argument, ...]:
        if raw is None:
            return ()
        inner = raw if raw.rule == "arguments" else self.find(raw.children, "arguments")
        return tuple(c for c in inner.children if isinstance(c, ast.Argument)) if inner is not None else ()

    def base(self, children: Sequence[Child]) -> dict[str, Any]:
        span = self.span(children)
        return {"span": span, "doc": self.doc(span)}

    def named(self, children: Sequence[Child]) -> dict[str, Any]:
        token = self.words(children)[0]
        return {**self.base(children), "name": str(token), "name_span": self.at(token)}

    # ------------------------------------------------------------ top level

    def start(self, c: list[Child]) -> ast.Module:
        version = next((x for x in c if isinstance(x, Raw)), None)
        number = float(version.children[1]) if version is not None else 1.0
        uses = tuple(x for x in c if isinstance(x, ast.UseDecl))
        declarations = tuple(x for x in c if isinstance(x, ast.Decl))
        return ast.Module(span=Span(self.source, 0, len(self.source.text)), version=int(number), uses=uses, declarations=declarations)

    def use(self, c: list[Child]) -> ast.UseDecl:
        module, *names = self.words(c)
        spans = tuple(map(self.at, names))
        return ast.UseDecl(
            span=self.span(c), module=str(module), module_span=self.at(module), names=tuple(map(str, names)), name_spans=spans
        )

    def role(self, c: list[Child]) -> ast.RoleDecl:
        names = self.words(c)
        parent = names[1] if len(names) > 1 else None
        return ast.RoleDecl(
            **self.named(c), parent=None if parent is None else str(parent),
            parent_span=None if parent is None else self.at(parent), body=self.statements(c[-1]),
        )  # fmt: skip

    def template(self, c: list[Child]) -> ast.TemplateDecl:
        names = self.words(c)
        role = names[1] if len(names) > 1 else None
        return ast.TemplateDecl(
            **self.named(c), role=None if role is None else str(role), role_span=None if role is None else self.at(role),
            body=self.statements(c[-1]),
        )  # fmt: skip

    def primitive(self, c: list[Child]) -> ast.PrimitiveDecl:
        return ast.PrimitiveDecl(**self.named(c), body=self.statements(c[-1]))

    def category(self, c: list[Child]) -> ast.CategoryDecl:
        return ast.CategoryDecl(**self.named(c), body=self.statements(c[-1]))

    def material(self, c: list[Child]) -> ast.MaterialDecl:
        return ast.MaterialDecl(**self.named(c), properties=tuple(x for x in c if isinstance(x, ast.Clause)))

    def property(self, c: list[Child]) -> ast.Clause:
        low, high = c[1].low, c[1].high
        return ast.Clause(span=self.span(c), word=str(c[0]), values=(low,) if low is high else (low, high))

    def vocabulary(self, c: list[Child]) -> ast.VocabularyDecl:
        words = [t for t in c[2:] if isinstance(t, Token) and t.type in ("NAME", "GRASP", "SLOT", "PART", "LABEL")]
        return ast.VocabularyDecl(**self.named(c), words=tuple(map(str, words)), word_spans=tuple(map(self.at, words)))

    def function(self, c: list[Child]) -> ast.FunctionDecl:
        return ast.FunctionDecl(**self.named(c), parameters=self.parameter_names(c), value=self.exprs(c)[-1])

    def parameter_names(self, c: list[Child]) -> tuple[str, ...]:
        raw = self.find(c, "parameters")
        return tuple(map(str, self.words(raw.children))) if raw is not None else ()

    # ------------------------------------------------------------ declarations

    def tail(self, c: list[Child]) -> dict[str, Any]:
        found: dict[str, Any] = {}
        for raw in c:
            if not isinstance(raw, Raw):
                continue
            x = raw.children
            if raw.rule in ("domain", "test"):
                found[raw.rule] = x[1]
            elif raw.rule == "positive":
                found["positive"] = True
            elif raw.rule in ("default", "vary"):
                found[raw.rule] = x[1]
            elif raw.rule == "drawn":
                found["distribution"] = ast.Distribution(span=raw.span, name=str(x[1]), arguments=self.call_values(x[3]))
            elif raw.rule == "derived":
                found["derived"] = True
            elif raw.rule == "was":
                found["was"] = str(x[1])
        return found

    def param(self, c: list[Child]) -> ast.ParamDecl:
        names = self.words(c)
        kind = next(x for x in c if isinstance(x, ast.TypeRef))
        return ast.ParamDecl(
            **self.base(c), keyword=str(c[0]), names=tuple(map(str, names)), name_spans=tuple(map(self.at, names)), type=kind,
            **self.tail(c),
        )  # fmt: skip

    def type(self, c: list[Child]) -> ast.TypeRef:
        size = self.words(c, "NUMBER")
        return ast.TypeRef(span=self.span(c), name=str(c[0]), size=int(float(size[0])) if size else None)

    def style_type(self, c: list[Child]) -> ast.TypeRef:
        return ast.TypeRef(span=self.span(c), name=str(c[1]), style=True)

    def choice_type(self, c: list[Child]) -> ast.TypeRef:
        return ast.TypeRef(span=self.span(c), name="choice", values=tuple(map(str, self.words(c))))

    def count(self, c: list[Child]) -> ast.CountDecl:
        tail = self.tail(c)
        tail.pop("vary", None)
        zero = ast.NumberExpr(span=self.span(c), value=0.0, unit="")
        tail.setdefault("domain", ast.RangeExpr(span=self.span(c), low=zero, high=zero))
        return ast.CountDecl(**self.named(c), **tail)

    def let(self, c: list[Child]) -> ast.LetDecl:
        return ast.LetDecl(**self.named(c), keyword="let", parameters=self.parameter_names(c), value=self.exprs(c)[-1])

    def output(self, c: list[Child]) -> ast.LetDecl:
        return ast.LetDecl(**self.named(c), keyword="out", parameters=(), value=self.exprs(c)[-1])

    def curve(self, c: list[Child]) -> ast.CurveDecl:
        return ast.CurveDecl(
            **self.named(c), parameter=str(self.words(c)[1]), parameter_range=next(x for x in c if isinstance(x, ast.RangeExpr)),
            value=self.exprs(c)[-1],
        )  # fmt: skip

    def curve_let(self, c: list[Child]) -> ast.LetDecl:
        return ast.LetDecl(**self.named(c), keyword="curve", parameters=(), value=self.exprs(c)[-1])

    def chain(self, c: list[Child]) -> ast.ChainExpr:
        pieces = [c[0]]
        for raw in c[1:]:
            name, arguments = raw.children
            function = ast.NameExpr(span=self.at(name), name=str(name))
            pieces.append(ast.CallExpr(span=raw.span, function=function, arguments=self.call_values(arguments)))
        return ast.ChainExpr(span=self.span(c), pieces=tuple(pieces))

    def part(self, c: list[Child]) -> ast.PartDecl:
        alternatives = [x for x in c if isinstance(x, ast.Alternative)]
        role, arguments, placements = None, (), ()
        if self.has(c, "EQ"):
            head = alternatives.pop(0)
            role, arguments, placements = head, head.arguments, head.placements
        return ast.PartDecl(
            **self.named(c), root=self.has(c, "ROOT"), role=role.name if role else None, role_span=role.name_span if role else None,
            arguments=arguments, placements=placements, alternatives=tuple(alternatives), **self.tail(c),
        )  # fmt: skip

    def alternative(self, c: list[Child]) -> ast.Alternative:
        return ast.Alternative(
            span=self.span(c), name=str(c[0]), name_span=self.at(c[0]), arguments=self.call_values(self.find(c, "call_arguments")),
            placements=tuple(x for x in c if isinstance(x, ast.Placement)), **self.weighted(c),
        )  # fmt: skip

    def nothing(self, c: list[Child]) -> ast.Alternative:
        return ast.Alternative(span=self.span(c), name=None, name_span=self.at(c[0]), **self.weighted(c))

    def weighted(self, c: list[Child]) -> dict[str, Any]:
        weight, guard = self.find(c, "weight"), self.find(c, "guard")
        return {"weight": weight.children[1] if weight else None, "guard": guard.children[1] if guard else None}

    def placement(self, c: list[Child]) -> ast.Placement:
        values = self.exprs(c)
        angle = values[0] if len(values) == 2 else None
        return ast.Placement(span=self.span(c), kind=str(c[0]), direction=values[-1], angle=angle)

    def style(self, c: list[Child]) -> ast.StyleDecl:
        role = c[3]
        return ast.StyleDecl(
            **self.named(c), role=str(role), role_span=self.at(role),
            alternatives=tuple(x for x in c if isinstance(x, ast.Alternative)), **self.tail(c),
        )  # fmt: skip

    def slot(self, c: list[Child]) -> ast.SlotDecl:
        return ast.SlotDecl(**self.named(c), optional=self.has(c, "QUESTION"))

    def slot_binding(self, c: list[Child]) -> ast.SlotDecl:
        return ast.SlotDecl(**self.named(c), targets=tuple(self.exprs(c)))

    def port(self, c: list[Child]) -> ast.PortDecl:
        index = value = None
        for before, child in zip(c, c[1:], strict=False):
            if isinstance(child, ast.Expr) and isinstance(before, Token):
                if before == "[":
                    index = child
                elif before == "=":
                    value = child
        kind = next((x for x in c if isinstance(x, ast.TypeRef)), None)
        return ast.PortDecl(**self.named(c), index=index, optional=self.has(c, "QUESTION"), type=kind, value=value)

    def joint(self, c: list[Child]) -> ast.JointDecl:
        return ast.JointDecl(**self.named(c), optional=self.has(c, "QUESTION"))

    def joint_full(self, c: list[Child]) -> ast.JointDecl:
        kind = self.words(c)[1]
        parent, child = self.exprs(c)[:2]
        clauses = tuple(x for x in c if isinstance(x, ast.Clause))
        return ast.JointDecl(
            **self.named(c), kind=str(kind), kind_span=self.at(kind), parent=parent, child=child, clauses=clauses
        )

    # ------------------------------------------------------------ clauses

    def clause(self, c: list[Child]) -> ast.Clause:
        word, *rest = c
        ranges = [x for x in rest if isinstance(x, ast.RangeExpr)]
        if ranges:
            values: tuple[ast.Expr, ...] = (ranges[0].low, ranges[0].high)
        else:
            values = tuple(self.exprs(rest))
        return ast.Clause(span=self.span(c), word=str(word), values=values)

    place_clause = axis_clause = between_clause = grasp_clause = solid_clause = repeat_clause = clause

    def fit_clause(self, c: list[Child]) -> ast.Clause:
        names = tuple(ast.NameExpr(span=self.at(t), name=str(t)) for t in self.words(c))
        return ast.Clause(span=self.span(c), word="fit", values=names)

    def at_clause(self, c: list[Child]) -> ast.Clause:
        names, values = [], []
        for raw in c:
            if isinstance(raw, Raw):
                token = self.words(raw.children)
                names.append(str(token[0]) if token else "")
                values.append(self.exprs(raw.children)[-1])
        return ast.Clause(span=self.span(c), word="at", values=tuple(values), names=tuple(names))

    # ------------------------------------------------------------ statements

    def connect(self, c: list[Child]) -> ast.ConnectStmt:
        return ast.ConnectStmt(**self.base(c), subject=c[1], clauses=tuple(x for x in c if isinstance(x, ast.Clause)))

    def align(self, c: list[Child]) -> ast.AlignStmt:
        left, right = self.exprs(c)
        return ast.AlignStmt(**self.base(c), left=left, right=right)

    def require(self, c: list[Child]) -> ast.RequireStmt:
        values = self.exprs(c)
        repair = values[1] if len(values) > 1 else None
        return ast.RequireStmt(**self.base(c), condition=values[0], message=self.text(c), repair=repair)

    def stable(self, c: list[Child]) -> ast.RequireStmt:
        state = "open" if self.has(c, "OPEN") else "rest"
        return ast.RequireStmt(**self.base(c), condition=None, stable=state, message=self.text(c))

    def prefer(self, c: list[Child]) -> ast.PreferStmt:
        weight = self.find(c, "weight")
        return ast.PreferStmt(**self.base(c), condition=self.exprs(c)[0], weight=weight.children[1] if weight else None)

    def clear(self, c: list[Child]) -> ast.ClearStmt:
        subject, other, distance = self.exprs(c)
        return ast.ClearStmt(**self.base(c), subject=subject, other=other, distance=distance)

    def allow(self, c: list[Child]) -> ast.AllowStmt:
        subject, other = self.exprs(c)
        return ast.AllowStmt(**self.base(c), kind="overlap", subject=subject, other=other, reason=self.text(c))

    def free(self, c: list[Child]) -> ast.AllowStmt:
        subject, other = self.exprs(c)
        return ast.AllowStmt(**self.base(c), kind="free", subject=subject, other=other, reason=self.text(c))

    def limit(self, c: list[Child]) -> ast.LimitStmt:
        first, *rest = self.words(c[1].children)
        path: ast.Expr = ast.NameExpr(span=self.at(first), name=str(first))
        for token in rest:
            path = ast.MemberExpr(span=path.span.to(self.at(token)), obj=path, name=str(token), name_span=self.at(token))
        return ast.LimitStmt(**self.base(c), joint=path, range=c[2])

    def close(self, c: list[Child]) -> ast.CloseStmt:
        subject, other = self.exprs(c)
        return ast.CloseStmt(**self.base(c), subject=subject, other=other)

    def repeat(self, c: list[Child]) -> ast.RepeatStmt:
        names = self.words(c)
        clauses = [x for x in c if isinstance(x, ast.Clause)]
        counts = self.exprs(c)
        form = next((x.word for x in clauses if x.word in ("pitch", "spread", "fill", "split", "ring", "mirror")), "")
        count = counts[0] if counts else None
        if form == "ring" and count is None:
            count = next(x for x in clauses if x.word == "ring").values[0]
        return ast.RepeatStmt(
            **self.named(c), index=str(names[1]) if len(names) > 1 else None, count=count, form=form, clauses=tuple(clauses),
            body=self.statements(c[-1]),
        )  # fmt: skip

    def when(self, c: list[Child]) -> ast.WhenStmt:
        bodies = [x for x in c if isinstance(x, Raw)]
        nested = [x for x in c if isinstance(x, ast.WhenStmt)]
        otherwise = tuple(nested) if nested else self.statements(bodies[1]) if len(bodies) > 1 else ()
        return ast.WhenStmt(**self.base(c), guard=self.exprs(c)[0], body=self.statements(bodies[0]), otherwise=otherwise)

    # ------------------------------------------------------------ labels

    def label(self, c: list[Child]) -> ast.LabelStmt:
        vocabulary, word = c[1], c[3]
        values = self.exprs(c)
        where = value = None
        if self.has(c, "WHERE"):
            where = values.pop()
        elif any(isinstance(x, Token) and x == "=" for x in c):
            value = values.pop()
        return ast.LabelStmt(
            **self.base(c), vocabulary=str(vocabulary), label=str(word), label_span=self.at(vocabulary).to(self.at(word)),
            targets=tuple(values), where=where, value=value,
        )  # fmt: skip

    def field(self, c: list[Child]) -> ast.FieldStmt:
        *targets, value = self.exprs(c)
        kind = next(x for x in c if isinstance(x, ast.TypeRef))
        return ast.FieldStmt(**self.named(c), type=kind, targets=tuple(targets), value=value)

    def grasp(self, c: list[Child]) -> ast.GraspStmt:
        names = self.words(c)
        span = next((x for x in c if isinstance(x, ast.RangeExpr)), None)
        return ast.GraspStmt(
            **self.named(c), target=self.exprs(c)[0], parameter=str(names[1]) if len(names) > 1 else None, range=span,
            clauses=tuple(x for x in c if isinstance(x, ast.Clause)),
        )  # fmt: skip

    def keypoint(self, c: list[Child]) -> ast.KeypointStmt:
        values = self.exprs(c)
        return ast.KeypointStmt(**self.named(c), target=values[0], at=values[1] if len(values) > 1 else None)

    def symmetry(self, c: list[Child]) -> ast.SymmetryStmt:
        target, direction = self.exprs(c)
        turns = self.words(c, "NUMBER")
        return ast.SymmetryStmt(**self.base(c), target=target, turn=int(float(turns[0])) if turns else None, direction=direction)

    def dress(self, c: list[Child]) -> ast.MaterialStmt:
        name = self.words(c)[0]
        return ast.MaterialStmt(**self.base(c), material=str(name), material_span=self.at(name), targets=tuple(self.exprs(c)))

    # ------------------------------------------------------------ primitives

    def surface(self, c: list[Child]) -> ast.SurfaceDecl:
        names = self.words(c)
        ranges = [x for x in c if isinstance(x, ast.RangeExpr)]
        index, guard = self.find(c, "index"), self.find(c, "guard")
        return ast.SurfaceDecl(
            **self.named(c), u=str(names[1]), u_range=ranges[0], v=str(names[2]), v_range=ranges[1], value=self.exprs(c)[-1],
            guard=guard.children[1] if guard else None, index=str(self.words(index.children)[0]) if index else None,
            index_count=self.exprs(index.children)[0] if index else None,
        )  # fmt: skip

    def inside(self, c: list[Child]) -> ast.InsideDecl:
        return ast.InsideDecl(**self.base(c), parameter=str(self.words(c)[0]), value=self.exprs(c)[-1])

    def box(self, c: list[Child]) -> ast.BoxDecl:
        values = self.exprs(c)
        if len(values) == 1:
            return ast.BoxDecl(**self.base(c), value=values[0])
        return ast.BoxDecl(**self.base(c), low=values[0], high=values[1])

    def piece(self, c: list[Child]) -> ast.PieceDecl:
        names = self.words(c)
        guard = self.find(c, "guard")
        values = self.exprs(c)
        index = count = None
        if self.has(c, "IN"):
            index, count = str(names[1]), values.pop(0)
        return ast.PieceDecl(
            **self.named(c), index=index, count=count, points=tuple(values), guard=guard.children[1] if guard else None
        )

    def solid(self, c: list[Child]) -> ast.SolidDecl:
        clauses = tuple(x for x in c if isinstance(x, ast.Clause))
        arguments = self.call_values(self.find(c, "arguments"))
        return ast.SolidDecl(**self.base(c), operator=str(self.words(c)[0]), arguments=arguments, clauses=clauses)

    # ------------------------------------------------------------ expressions

    def range(self, c: list[Child]) -> ast.RangeExpr:
        values = self.exprs(c)
        return ast.RangeExpr(span=self.span(c), low=values[0], high=values[-1])

    def if_expr(self, c: list[Child]) -> ast.IfExpr:
        then, condition, otherwise = self.exprs(c)
        return ast.IfExpr(span=self.span(c), then=then, condition=condition, otherwise=otherwise)

    def binary(self, c: list[Child]) -> ast.BinaryExpr:
        return ast.BinaryExpr(span=self.span(c), op=str(c[1]), left=c[0], right=c[2])

    def unary(self, c: list[Child]) -> ast.UnaryExpr:
        return ast.UnaryExpr(span=self.span(c), op=str(c[0]), operand=c[1])

    def is_expr(self, c: list[Child]) -> ast.IsExpr:
        return ast.IsExpr(span=self.span(c), subject=c[0], type_name=str(c[2]), type_span=self.at(c[2]))

    def member(self, c: list[Child]) -> ast.MemberExpr:
        return ast.MemberExpr(span=self.span(c), obj=c[0], name=str(c[2]), name_span=self.at(c[2]))

    def index_expr(self, c: list[Child]) -> ast.IndexExpr:
        return ast.IndexExpr(span=self.span(c), obj=c[0], index=c[2])

    def call(self, c: list[Child]) -> ast.CallExpr:
        return ast.CallExpr(span=self.span(c), function=c[0], arguments=self.call_values(c[1]))

    def argument(self, c: list[Child]) -> ast.Argument:
        names = self.words(c)
        return ast.Argument(span=self.span(c), name=str(names[0]) if names else None, value=self.exprs(c)[-1])

    def number(self, c: list[Child]) -> ast.NumberExpr:
        value, unit = split_number(str(c[0]))
        return ast.NumberExpr(span=self.span(c), value=value, unit=unit)

    def string(self, c: list[Child]) -> ast.StringExpr:
        return ast.StringExpr(span=self.span(c), value=unquote(c[0]))

    def hole(self, c: list[Child]) -> ast.HoleExpr:
        return ast.HoleExpr(span=self.span(c))

    def name(self, c: list[Child]) -> ast.NameExpr:
        return ast.NameExpr(span=self.span(c), name=str(c[0]))

    def vector(self, c: list[Child]) -> ast.VectorExpr:
        return ast.VectorExpr(span=self.span(c), items=tuple(self.exprs(c)))

    def parenthesis(self, c: list[Child]) -> ast.Expr:
        return c[1]


def split_number(text: str) -> tuple[float, str]:
    """``5cm`` to 5 and ``cm``; ``1/2turn`` to 0.5 and ``turn``."""
    end = 0
    while end < len(text) and (text[end].isdigit() or text[end] == "."):
        end += 1
    rest = text[end:]
    if rest[:1] in ("e", "E") and rest[1:2] and (rest[1].isdigit() or rest[1] in "+-" and rest[2:3].isdigit()):
        stop = end + 2
        while stop < len(text) and text[stop].isdigit():
            stop += 1
        return float(text[:stop]), text[stop:]
    if rest[:1] == "/":
        stop = end + 1
        while stop < len(text) and text[stop].isdigit():
            stop += 1
        divisor = float(text[end + 1 : stop])
        return float(text[:end]) / divisor if divisor else 0.0, text[stop:]
    return float(text[:end]), rest


def unquote(token: str) -> str:
    return token[1:-1].replace('\\"', '"').replace("\\\\", "\\")


def iterate(node: ast.Node) -> Iterator[ast.Node]:
    """A node and all nodes below it, depth first in the order of the text."""
    yield node
    for name in node.__dataclass_fields__:
        value = getattr(node, name)
        for item in value if isinstance(value, tuple) else (value,):
            if isinstance(item, ast.Node):
                yield from iterate(item)
