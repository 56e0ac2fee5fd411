"""Checks of the statements of a body, in the context of their guards."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

from ..diagnostics.suggest import any_of, did_you_mean, suggest
from ..language import REPEATS
from ..syntax import ast
from ..syntax.walk import walk
from . import alternatives, conditions, declarations, joints, labels, limits, names, placing, primitives, roles, twice
from .entries import of_reference, port_context
from .guards import Not, conjunction, consistent
from .remedies import instead
from .scope import BodyScope, Entry, Guards
from .symbols import NAMED, names_of
from .types import (
    BASE,
    BOOL,
    BOX,
    COUNT,
    CURVE,
    DIRECTION,
    EDGE,
    FRAME,
    LENGTH,
    LINE,
    PLANE,
    POINT,
    RATIO,
    UNKNOWN,
    ArrayType,
    Boxed,
    ChoiceType,
    ElementType,
    PartType,
    SlotType,
    dimension_of,
    fits,
    is_number,
)

if TYPE_CHECKING:
    from .checker import Checker, Context

_DECLARATIONS = (ast.ParamDecl, ast.LetDecl, ast.PortDecl, ast.RequireStmt)
SHAPE = (ast.SurfaceDecl, ast.CurveDecl, ast.InsideDecl, ast.BoxDecl, ast.PieceDecl, ast.SolidDecl)
_ROLE = (ast.ParamDecl, ast.SlotDecl, ast.PortDecl, ast.JointDecl)
_INSTEAD: dict[tuple[str, type[ast.Stmt]], str] = {
    ("role", ast.CountDecl): "write `param {0} : count in ...`",
    ("role", ast.RequireStmt): "write it in the templates that play the role, or where the part is declared",
    ("primitive", ast.CountDecl): "write `param {0} : count in ...`",
    ("primitive", ast.WhenStmt): "put the condition behind what it guards: `surface ... when`, `piece ... when`",
}

_PLACES = {
    "role": "a role declares what its templates have in common: `inherit`, `param`, `out`, `port`, `slot`, `joint`",
    "primitive": "a primitive declares one shape; the template or category that uses it says where that stands and what it is",
    "template": "write it in the category that uses the template",
    "category": "write it in a primitive, and make a part of that",
}


def check_body(ck: Checker, scope: BodyScope, body: tuple[ast.Stmt, ...], guards: Guards) -> None:
    """All statements of a body that stand under ``guards``; repeats and guarded blocks included."""
    ctx = ck.context(scope).given(ck.condition(guards))
    for stmt in body:
        if _misplaced(ck, scope, stmt):
            continue
        if isinstance(stmt, ast.WhenStmt):
            conditions.truth(ck, ctx, stmt.guard)
            conditions.check_discrete(ck, ctx, stmt.guard)
            for truth, branch in ((True, stmt.body), (False, stmt.otherwise)):
                if branch and not _never(ck, ctx, scope, stmt.guard, truth):
                    check_body(ck, scope, branch, scope.branches[id(stmt), truth])
        elif isinstance(stmt, ast.RepeatStmt):
            _repeat(ck, ctx, stmt)
            inner = scope.inner[id(stmt)]
            names.check_names(ck, inner)
            check_body(ck, inner, stmt.body, inner.guards)
        else:
            _statement(ck, ctx, stmt)
            _stated(ck, ctx, stmt)


def _stated(ck: Checker, ctx: Context, stmt: ast.Stmt) -> None:
    """Warns of what a statement says once more where it is said already."""
    for key, node, said in twice.sayings(stmt):
        before = ck.sayings.setdefault((ctx.scope, key), [])
        for condition, first, words in before:
            again = not consistent(ctx.condition, Not(condition))
            one, other = (node.span, first) if again else (first, node.span)
            if again or not consistent(condition, Not(ctx.condition)):
                message = f"`{said if again else words}` is stated twice"
                ck.warning("stated-twice", one, message, hint="leave one of the two out", notes=((other, "here, too"),))
                break
        before.append((ctx.condition, node.span, said))


def _never(ck: Checker, ctx: Context, scope: BodyScope, guard: ast.Expr, truth: bool) -> bool:
    """Whether a branch of a ``when`` is left out by its guard and those around it, which is reported."""
    asked = conditions.of(ck, ctx, guard)
    known = asked if truth else Not(asked)
    if consistent(ctx.condition, known) or not consistent(ctx.condition):
        return False
    words, alone = guard.span.words, not consistent(known)
    ends = "" if alone else ", given the `when` around it"
    said = (
        f"`{words}` never holds{ends}"
        if truth
        else f"`{words}` always holds{ends}: nothing under its `else` is ever there"
    )
    ranges = [
        f"`{name}` is in {text}"
        for name, node in {node.name: node for node in walk(guard) if isinstance(node, ast.NameExpr)}.items()
        for entry in scope.find(name)[:1]
        if (text := _range_in_words(ctx, entry, node)) is not None
    ]
    ck.error(
        "never-there",
        guard.span,
        said,
        hint=", ".join(ranges) or "correct the condition, or remove what stands under it",
    )
    return True


def _range_in_words(ctx: Context, entry: Entry, name: ast.NameExpr) -> str | None:
    """The range of a count as it is written, or of the index of a repeat."""
    if isinstance(entry.node, ast.CountDecl):
        return entry.node.domain.span.text
    _, most = conditions.ends(ctx, name) if entry.kind == "index" else (0, None)
    return None if most is None else f"0 .. {most}"


def _misplaced(ck: Checker, scope: BodyScope, stmt: ast.Stmt) -> bool:
    kind = scope.owner.kind
    if kind == "role":
        wrong = not isinstance(stmt, _ROLE)
    elif kind == "primitive":
        wrong = not isinstance(stmt, SHAPE + _DECLARATIONS)
    else:
        wrong = isinstance(stmt, SHAPE) and not isinstance(stmt, ast.CurveDecl)
    if isinstance(stmt, ast.ParamDecl) and stmt.keyword == "inherit" and kind != "role":
        hint = "declare a parameter of its own with `param`"
        ck.error("misplaced-statement", stmt.span, f"`inherit` is only allowed in a role, not in a {kind}", hint=hint)
        return True
    if wrong:
        instead = _INSTEAD.get((kind, type(stmt)), "").format(*names_of(stmt))
        ck.error("misplaced-statement", stmt.span, f"this is not allowed in a {kind}", hint=instead or _PLACES[kind])
    return wrong


def _statement(ck: Checker, ctx: Context, stmt: ast.Stmt) -> None:
    match stmt:
        case ast.ParamDecl() | ast.CountDecl() | ast.LetDecl() | ast.PartDecl() | ast.StyleDecl():
            _declaration(ck, ctx, stmt)
        case ast.SlotDecl() | ast.PortDecl() | ast.JointDecl():
            _member(ck, ctx, stmt)
        case ast.ConnectStmt():
            placing.check_connect(ck, ctx, stmt)
        case ast.AlignStmt():
            _align(ck, ctx, stmt.left, stmt.right, "align")
            for start in ast.value_of(stmt.near) or ():
                _align(ck, ctx, start.left, start.right, "near")
        case ast.RequireStmt() | ast.PreferStmt():
            _condition(ck, ctx, stmt)
        case ast.ClearStmt(subject=subject, other=other, distance=distance):
            _parts(ck, ctx, subject, other, "clear")
            ck.expect(ctx, distance, LENGTH, "the distance")
        case ast.AllowStmt(subject=subject, other=other, kind=word):
            _parts(ck, ctx, subject, other, word if word == "free" else f"allow {word}")
        case ast.LimitStmt():
            limits.check_limit(ck, ctx, stmt)
        case ast.CloseStmt(subject=subject, other=other):
            kind, inside = placing.subject(ck, ctx, subject)
            for expr, found in ((subject, kind), (other, ck.infer(inside, other))):
                if found not in (UNKNOWN, FRAME, LINE, EDGE) and not fits(found, POINT):
                    ck.unfit(
                        expr,
                        found,
                        "`close` joins points, lines or frames",
                        hint=f"name a point of it, such as `{expr.span.words}.center`"
                        if isinstance(found, Boxed) or found == PLANE
                        else "as in `close a.pin on b.pin`",
                    )
        case _ if isinstance(stmt, SHAPE):
            primitives.check(ck, ctx, stmt)
        case _:
            labels.check(ck, ctx, stmt)


def _declaration(ck: Checker, ctx: Context, stmt: ast.Stmt) -> None:
    assert ctx.scope is not None
    match stmt:
        case ast.ParamDecl():
            for name in stmt.names:
                for entry in ctx.scope.table.get(name, ()):
                    ck.entry_type(entry)
            declarations.check_param(ck, ctx, stmt)
            if stmt.keyword == "out" and ctx.scope.owner.kind != "role":
                for name in stmt.names:
                    _output(ck, ctx, stmt, name)
        case ast.CountDecl():
            declarations.check_count(ck, ctx, stmt)
        case ast.LetDecl():
            for entry in ctx.scope.table.get(stmt.name, ()):
                if entry.node is stmt and not stmt.parameters:
                    ck.entry_type(entry)
            if stmt.parameters:
                extra = dict.fromkeys(stmt.parameters, UNKNOWN)
                ck.infer(ctx.but(extra={**ctx.extra, **extra}), stmt.value)
            else:
                _output(ck, ctx, stmt, stmt.name)
        case ast.PartDecl():
            if stmt.root and ctx.scope.owner.kind != "category":
                ck.error(
                    "misplaced-statement",
                    stmt.name_span,
                    "only a category has a `root` part",
                    hint="write `part`: the first part of a template is what carries the others",
                )
            elif stmt.root and ctx.scope.repeat is not None:
                ck.error(
                    "misplaced-statement",
                    stmt.name_span,
                    "the `root` part cannot be in a repeat",
                    hint="move it out of the repeat, or make another part the root",
                )
            alternatives.check_part(ck, ctx, stmt)
        case ast.StyleDecl():
            alternatives.check_style(ck, ctx, stmt)


def _output(ck: Checker, ctx: Context, stmt: ast.ParamDecl | ast.LetDecl, name: str) -> None:
    """``out mouth : length = ...`` or ``let mouth = ...`` binds an output of the role, which says what it is."""
    assert ctx.scope is not None
    owner = ctx.scope.owner
    outputs = {
        n: d for n, (_, d) in ck.interface_of(owner).items() if isinstance(d, ast.ParamDecl) and d.keyword == "out"
    }
    declared = outputs.get(name)
    if isinstance(stmt, ast.ParamDecl):
        if declared is None:
            ck.error(
                "unknown-member",
                stmt.name_spans[0],
                f"the role of {owner.name} has no output `{name}`",
                hint=did_you_mean(name, outputs) or "declare a value of the template's own with `let`",
            )
        if stmt.default is None:
            hint = f"write `out {name} : {stmt.type.name} = ...`"
            ck.error("missing-value", stmt.span, f"the output `{name}` has no value", hint=hint)
    if declared is None:
        return
    with ck.muted():
        wanted = of_reference(ck, ctx, declared.type)
    if isinstance(stmt, ast.LetDecl):
        given = ck.types.get(id(stmt.value), UNKNOWN)
        if not fits(given, wanted):
            ck.mismatch(stmt.value, given, wanted, f"the output `{name}`")
    else:
        with ck.muted():
            own = of_reference(ck, ctx, stmt.type)
        if not fits(own, wanted):
            ck.error(
                "wrong-type",
                stmt.type.span,
                f"the output `{name}` is {wanted} in the role, but {own} here",
                hint="declare it as in the role",
            )


def _member(ck: Checker, ctx: Context, stmt: ast.SlotDecl | ast.PortDecl | ast.JointDecl) -> None:
    """A slot, a port or a joint: a role names it, any other body says what it is."""
    assert ctx.scope is not None
    word, role = NAMED[type(stmt)], ctx.scope.owner.kind == "role"
    match stmt:
        case ast.SlotDecl(targets=targets):
            bound = bool(targets)
            for target in targets:
                labels.target(ck, ctx, target, "a slot binds")
        case ast.PortDecl():
            bound = stmt.value is not None
            _port(ck, ctx, stmt)
        case ast.JointDecl():
            bound = stmt.kind is not None
            joints.check_joint(ck, ctx, stmt)
    if role and bound:
        said = f"a role only names its {word}s: each template says what they are"
        ck.error("misplaced-statement", stmt.span, said, hint=f"write `{word} {stmt.name}`")
    elif not role and not bound:
        said = f"the {word} `{stmt.name}` has no value"
        ck.error("missing-value", stmt.span, said, hint=roles.how_to_bind(word, stmt.name))
    elif not role and stmt.optional:
        said = f"`?` is only allowed in a role, not in a {ctx.scope.owner.kind}"
        ck.error("misplaced-statement", stmt.span, said, hint="leave it out, or declare this under `when`")


def _port(ck: Checker, ctx: Context, stmt: ast.PortDecl) -> None:
    assert ctx.scope is not None
    scope = ctx.scope
    entries = scope.root.table if stmt.index is not None else scope.table
    entry = next(e for e in entries[stmt.name] if e.node is stmt)
    kind = ck.entry_type(entry)
    ctx = port_context(ctx, stmt)
    if stmt.index is not None:
        ck.expect(ctx, stmt.index, COUNT, "the index of a port")
    if stmt.value is None:
        return
    wanted = kind.item if isinstance(kind, ArrayType) else kind
    given = ck.infer(ctx, stmt.value)
    places = (FRAME, PLANE, EDGE, LINE, POINT, BOX, CURVE, BASE)
    if wanted == UNKNOWN or given == UNKNOWN:
        return
    if not fits(given, wanted) and not (wanted == BOX and isinstance(given, Boxed)):
        ck.mismatch(stmt.value, given, wanted, f"the port `{stmt.name}`")
    elif given not in places and not is_number(given) and not isinstance(given, Boxed):
        if not fits(given, POINT):
            ck.unfit(
                stmt.value,
                given,
                "a port must be a place",
                hint="name a face, a point, a line, a box or a length, or write `frame(at = ..., out = ..., up = ...)`",
            )


def _align(ck: Checker, ctx: Context, first: ast.Expr, second: ast.Expr, word: str) -> None:
    noted: list[Any] = []  # it goes with the parts on its left
    left = ck.infer(ctx.but(lenient=noted), first)
    ck.subjects[id(first)] = conjunction(noted)
    right = ck.infer(ctx.given(*noted), second)
    if UNKNOWN in (left, right):
        return
    for kind, expr in ((left, first), (right, second)):
        if not is_number(kind) and not fits(kind, POINT):
            hint = None
            if isinstance(kind, PartType | ElementType | SlotType):
                hint = "name one of its faces (`.front`) or its center (`.center`)"
            elif kind in (FRAME, LINE, EDGE):
                hint = "use its point: `.origin`"
            elif kind == BOX:
                hint = "a part fills a box by `connect lid in body.inner`, or by `in body.inner` in its joint"
            ck.unfit(expr, kind, f"`{word}` equates planes, numbers or points", hint=hint)
            return
    if is_number(left) != is_number(right):
        number, kind = (first, left) if is_number(left) else (second, right)
        ck.unfit(
            number,
            kind,
            "a point can only be aligned with a point",
            hint="align a coordinate of the point: `a.center.z = ...`, or name a point on both sides",
        )
        return
    a, b = dimension_of(left), dimension_of(right)
    if is_number(left) and None not in (a, b) and a != b:
        wanted, given, expr = (left, right, second) if a != RATIO.dimension else (right, left, first)
        ck.mismatch(expr, given, LENGTH if wanted == PLANE else wanted, f"this side of `{word}`")


def _condition(ck: Checker, ctx: Context, stmt: ast.RequireStmt | ast.PreferStmt) -> None:
    if isinstance(stmt, ast.RequireStmt) and isinstance(named := stmt.condition, ast.NameExpr):
        known = ctx.names()
        if named.name not in known and suggest(named.name, [*known, "stable"]) == "stable":
            message = f"there is no `{named.name}` here"
            ck.error("unknown-name", named.span, message, hint="did you mean `stable`?")
            return
    if stmt.condition is not None:  # without the optional parts it names, it holds trivially
        kind = ck.infer(ctx.but(lenient=[]), stmt.condition)
        if kind not in (BOOL, UNKNOWN) and not isinstance(kind, PartType):
            word = "require" if isinstance(stmt, ast.RequireStmt) else "prefer"
            ck.unfit(stmt.condition, kind, f"`{word}` needs a condition", hint=instead(stmt.condition, kind, BOOL))
    if isinstance(stmt, ast.PreferStmt):
        if stmt.weight is not None:
            ck.expect(ctx, stmt.weight, RATIO, "the weight")
    elif stmt.repair is not None:
        kind = ck.infer(ctx.but(lenient=[], asked=True), stmt.repair)
        if not is_number(kind) and not isinstance(kind, ChoiceType | PartType) and kind != UNKNOWN:
            ck.unfit(
                stmt.repair,
                kind,
                "`repair` must name the parameters that may change",
                hint="name a parameter, a count, a choice or a part",
            )


def _parts(ck: Checker, ctx: Context, subject: ast.Expr, other: ast.Expr | None, word: str) -> None:
    for expr in ast.present(subject, other):
        kind = ck.infer(ctx.but(lenient=[], many=True, subject=True), expr)
        if not isinstance(kind, Boxed) and kind != UNKNOWN:
            ck.unfit(expr, kind, f"`{word}` names parts", hint="name a part, a slot or an element of a repeat")
        labels.not_previous(ck, expr, other is not None)


# ---------------------------------------------------------------- repeats


_EXAMPLES = {"along": "along z", "every": "every 2cm", "about": "about table.axis", "across": "across y"}


def _form(ck: Checker, stmt: ast.RepeatStmt) -> None:
    """A form has what it needs, and nothing that it would not read."""
    form = REPEATS[stmt.form]
    given = {clause.word: clause for clause in ast.clauses(stmt)}
    for word in form.needs:
        if word not in given:
            ck.error(
                "missing-clause",
                given[stmt.form].span,
                f"`{stmt.form}` needs `{word}`",
                hint=f"add it, for example `{_EXAMPLES[word]}`",
            )
    for word, clause in given.items():
        if word not in (*form.clauses, *REPEATS):
            what = f"`{stmt.form}`" if stmt.form else "a repeat without a form"
            takers = any_of([name for name, other in REPEATS.items() if word in other.clauses])
            ck.error("unknown-clause", clause.span, f"{what} takes no `{word}`", hint=f"`{word}` goes with {takers}")


def _repeat(ck: Checker, ctx: Context, stmt: ast.RepeatStmt) -> None:
    assert ctx.scope is not None
    _form(ck, stmt)
    if stmt.count is not None:
        kind = ck.expect(ctx, stmt.count, COUNT, "the number of elements")
        _, most = conditions.ends(ctx, stmt.count)
        if most == 0 and fits(kind, COUNT):
            said = f"`{stmt.name}` never has an element: `{stmt.count.span.words}` is never more than 0"
            ck.error("never-there", stmt.count.span, said, hint="widen the range of the count, or remove the repeat")
    for box in ast.present(stmt.spread, stmt.split, stmt.fill):
        kind = ck.infer(ctx, box.value)
        if not isinstance(kind, Boxed) and kind not in (BOX, UNKNOWN):
            hint = "name a part, a box or an element of another repeat"
            ck.unfit(box.value, kind, f"`{box.word}` needs a box", hint)
    for length in ast.present(stmt.pitch, stmt.margin, stmt.every, stmt.gap):
        ck.expect(ctx, length.value, LENGTH, f"the `{length.word}`")
    for axis in ast.present(stmt.along, stmt.across):
        ck.expect(ctx, axis.value, DIRECTION, f"the `{axis.word}`")
    if stmt.each is not None:
        declarations.check_range(ck, ctx, stmt.each.value, LENGTH, "the `each`")
    if stmt.about is not None:
        joints.axis_value(ck, "about", stmt.about.value, ck.infer(ctx, stmt.about.value))
    if stmt.weight is not None:
        ck.expect(ck.context(ctx.scope.inner[id(stmt)]), stmt.weight.value, RATIO, "the `weight`")
