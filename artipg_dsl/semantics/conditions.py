"""Expressions that are true or false: their checks, and what they say about parts, counts and choices."""

from __future__ import annotations

from typing import TYPE_CHECKING

from ..diagnostics.suggest import did_you_mean
from ..syntax import ast
from .fold import constant
from .guards import OPERATORS, TRUE, VERSUS, Atom, Compare, Condition, Not, Or, conjunction
from .meanings import Global, Word
from .offers import TEMPLATES, missing
from .remedies import instead
from .scope import Guard
from .symbols import is_a
from .types import BOOL, BOX, UNKNOWN, ChoiceType, PartType, ScalarType, StyleType, Type

if TYPE_CHECKING:
    from .checker import Checker, Context

_FLIPPED = {"<": ">", "<=": ">=", ">": "<", ">=": "<=", "==": "==", "!=": "!="}


def truth(ck: Checker, ctx: Context, expr: ast.Expr) -> None:
    """Checks that an expression can be asked: it is true or false, or a part that may be there."""
    kind = ck.infer(ctx.but(lenient=[], asked=True) if _asks_presence(expr) else ctx, expr)
    if kind in (BOOL, UNKNOWN) or isinstance(kind, PartType) or (kind == BOX and isinstance(expr, ast.MemberExpr)):
        return
    ck.unfit(expr, kind, "a condition must be true or false", hint=instead(expr, kind, BOOL))


def _asks_presence(expr: ast.Expr) -> bool:
    return isinstance(expr, ast.NameExpr | ast.MemberExpr | ast.IndexExpr)


def equated_part(ck: Checker, ctx: Context, expr: ast.BinaryExpr) -> tuple[ast.Expr, bool] | None:
    """The part that ``lid == true`` compares, and whether that asks for its presence; None where no part is compared so."""
    for path, word in ((expr.left, expr.right), (expr.right, expr.left)):
        if isinstance(word, ast.NameExpr) and word.name in ("true", "false") and _asks_presence(path):
            if expr.op in ("==", "!=") and isinstance(_quiet(ck, ctx, path)[0], PartType):
                return path, (word.name == "true") == (expr.op == "==")
    return None


def check_is(ck: Checker, ctx: Context, expr: ast.IsExpr) -> Type:
    """``part is Template``: the subject is a part or a style (absence is just false), the name something it can be."""
    subject = ck.infer(ctx.but(lenient=[], asked=True), expr.subject)
    wanted = ctx.module.find(expr.type_name)
    if wanted is None or wanted.kind not in TEMPLATES:
        message = f"there is no role or template `{expr.type_name}` here"
        hint = missing(expr.type_name, ctx.module.named(*TEMPLATES), *TEMPLATES)
        if isinstance(subject, ChoiceType) and expr.type_name in subject.values:
            written = f"{expr.subject.span.words} == {expr.type_name}"
            hint = f"`is` tests a part or a style; an option is compared: `{written}`"
        ck.unknown(ctx.module, expr.type_name, "unknown-template", expr.type_span, message, hint)
        return BOOL
    ck.mean(expr, Global(wanted))
    if isinstance(subject, PartType | StyleType):
        known = [v for v in subject.domain if v is not None]
        if all(v.symbol is not None for v in known):
            if not any(v.symbol and (is_a(v.symbol, wanted) or is_a(wanted, v.symbol)) for v in known):
                names = sorted({v.name for v in known})
                ck.error(
                    "unrelated-type",
                    expr.type_span,
                    f"this {'part' if isinstance(subject, PartType) else 'style'} can never be {expr.type_name}",
                    hint=did_you_mean(expr.type_name, names) or f"it is {' or '.join(names)}",
                )
    elif subject != UNKNOWN:
        ck.unfit(
            expr.subject,
            subject,
            "`is` tests a part or a style",
            hint=f"compare it: `{expr.subject.span.words} == ...`",
        )
    return BOOL


def of_guard(ck: Checker, ctx: Context, guard: Guard) -> Condition:
    """What is known in one branch of a ``when``."""
    condition = of(ck, ctx, guard.test)
    return condition if guard.truth else Not(condition)


def of(ck: Checker, ctx: Context, expr: ast.Expr) -> Condition:
    """What an expression says when it is true; a variable of its own where it is not about discrete facts."""
    match expr:
        case ast.UnaryExpr(op="not", operand=operand):
            return Not(of(ck, ctx, operand))
        case ast.BinaryExpr(op="and", left=left, right=right):
            known = of(ck, ctx, left)
            return conjunction((known, of(ck, ctx.given(known), right)))
        case ast.BinaryExpr(op="or", left=left, right=right):
            known = of(ck, ctx, left)
            return Or((known, of(ck, ctx.given(Not(known)), right)))
        case ast.IsExpr():
            return _is(ck, ctx, expr)
        case ast.BinaryExpr() if expr.op in OPERATORS and (part := equated_part(ck, ctx, expr)):
            there = _presence(ck, ctx, part[0])  # reported: what it guards is not to blame
            return there if part[1] else Not(there)
        case ast.BinaryExpr() if expr.op in OPERATORS:
            return _compare(ck, ctx, expr)
        case ast.NameExpr(name="true"):
            return TRUE
        case ast.NameExpr(name="false"):
            return Not(TRUE)
        case ast.NameExpr() | ast.MemberExpr() | ast.IndexExpr():
            return _presence(ck, ctx, expr)
    return _opaque(ctx, expr)


def _quiet(ck: Checker, ctx: Context, expr: ast.Expr) -> tuple[Type, list[Condition]]:
    """The type of a path without a second report, and what its being there takes."""
    noted: list[Condition] = []
    with ck.muted():
        kind = ck.infer(ctx.but(lenient=noted), expr)
    return kind, noted


def _presence(ck: Checker, ctx: Context, expr: ast.Expr) -> Condition:
    kind, noted = _quiet(ck, ctx, expr)
    if isinstance(kind, PartType):
        return conjunction((*noted, kind.there))
    if kind == BOX:
        return conjunction(noted)
    return conjunction((*noted, Atom(_key(ctx, expr), frozenset((True,)), (True, False))))


def _is(ck: Checker, ctx: Context, expr: ast.IsExpr) -> Condition:
    kind, noted = _quiet(ck, ctx, expr.subject)
    wanted = ctx.module.find(expr.type_name)
    if not isinstance(kind, PartType) or wanted is None:
        return _opaque(ctx, expr)
    allowed = frozenset(v for v in kind.domain if v is not None and v.symbol is not None and is_a(v.symbol, wanted))
    if not allowed:  # a style parameter knows its role alone: the question stands for itself
        return conjunction((*noted, _opaque(ctx, expr)))
    return conjunction((*noted, Atom(kind.key, allowed, kind.domain)))


def _compare(ck: Checker, ctx: Context, expr: ast.BinaryExpr) -> Condition:
    for subject, other, op in ((expr.left, expr.right, expr.op), (expr.right, expr.left, _FLIPPED[expr.op])):
        value = constant(other)
        if value is not None and value == int(value) and isinstance(subject, ast.NameExpr | ast.MemberExpr):
            kind, noted = _quiet(ck, ctx, subject)
            if isinstance(kind, ScalarType) and kind.count:
                return conjunction((*noted, Compare(_key(ctx, subject), op, int(value), *ends(ctx, subject))))
        if isinstance(other, ast.NameExpr) and expr.op in ("==", "!="):
            with ck.muted():
                word = choice_word(ck, ctx, subject, other)
            if isinstance(word, ChoiceType):
                chosen = Atom(_key(ctx, subject), frozenset((other.name,)), word.values)
                return chosen if expr.op == "==" else Not(chosen)
    return _difference(ctx, expr)


def _difference(ctx: Context, expr: ast.BinaryExpr) -> Condition:
    """Two values compared: of below, equal and above exactly one holds, whatever they are."""
    left, right, op = expr.left, expr.right, expr.op
    if left.span.words > right.span.words:
        left, right, op = right, left, _FLIPPED[op]
    low, high = (0 if _last(ctx, right, left) else -1), (0 if _last(ctx, left, right) else 1)
    return Compare(_own_key(ctx, f"{left.span.words}{VERSUS}{right.span.words}"), op, 0, low, high)


def _last(ctx: Context, index: ast.Expr, other: ast.Expr) -> bool:
    """Whether these are the index of a repeat around and one less than its count: no element goes beyond it."""
    match other:
        case ast.BinaryExpr(op="-", left=count, right=ast.NumberExpr(value=1)) if isinstance(index, ast.NameExpr):
            around = (s.repeat for s in (ctx.scope.chain() if ctx.scope is not None else ()) if s.repeat is not None)
            repeat = next((r for r in around if r.index == index.name), None)
            return repeat is not None and repeat.count is not None and repeat.count.span.words == count.span.words
    return False


def ends(ctx: Context, expr: ast.Expr) -> tuple[int, int | None]:
    """The range of a count, or of the index of a repeat, where it is written with constants; None: no end is known."""
    entries = ctx.scope.find(expr.name) if isinstance(expr, ast.NameExpr) and ctx.scope is not None else []
    if entries and isinstance(repeat := entries[0].node, ast.RepeatStmt) and entries[0].kind == "index":
        most = 2 if repeat.form == "mirror" else None if repeat.count is None else ends(ctx, repeat.count)[1]
        return 0, None if most is None else max(most - 1, 0)
    if entries and isinstance(entries[0].node, ast.CountDecl):
        domain = entries[0].node.domain
        low, high = constant(domain.low, ctx.module), constant(domain.high, ctx.module)
        return (0 if low is None else int(low)), (None if high is None else int(high))
    value = constant(expr, ctx.module)
    return (0, None) if value is None else (int(value), int(value))


def _key(ctx: Context, expr: ast.Expr) -> str:
    """The guard variable that a path stands for."""
    if isinstance(expr, ast.NameExpr) and ctx.scope is not None:
        entries = ctx.scope.find(expr.name)
        if entries:
            return entries[0].key
    if isinstance(expr, ast.MemberExpr):
        return f"{_key(ctx, expr.obj)}.{expr.name}"
    return _own_key(ctx, expr.span.words)


def _opaque(ctx: Context, expr: ast.Expr) -> Condition:
    return Atom(_own_key(ctx, expr.span.words), frozenset((True,)), (True, False))


def _own_key(ctx: Context, words: str) -> str:
    """A guard variable for what stands in a body and is nothing else that guards know."""
    return f"{ctx.scope.path if ctx.scope is not None else ''}:{words}"


def check_discrete(ck: Checker, ctx: Context, expr: ast.Expr) -> None:
    """A guard of ``when`` is about parts, counts, ranks, choices and switches: never about lengths or angles."""
    match expr:
        case ast.UnaryExpr(operand=operand):
            check_discrete(ck, ctx, operand)
        case ast.BinaryExpr(op="and" | "or", left=left, right=right):
            check_discrete(ck, ctx, left)
            check_discrete(ck, ctx, right)
        case ast.BinaryExpr() if expr.op in OPERATORS:
            for side in (expr.left, expr.right):
                kind = ck.types.get(id(side), UNKNOWN)
                if isinstance(kind, ScalarType) and not kind.count:
                    ck.error(
                        "bad-guard",
                        expr.span,
                        f"a guard must compare counts, ranks or choices, but this is {kind}",
                        hint="for a condition on lengths or angles use `require`, or put it behind an alternative: "
                        "`part lid : Flat when w > 5cm` is absent otherwise",
                    )
                    return


def compares_with_either(ck: Checker, ctx: Context, expr: ast.BinaryExpr) -> bool:
    """Reports a choice that is compared with `a if c else b`, whose branches are bare options."""
    for subject, other in ((expr.left, expr.right), (expr.right, expr.left)):
        if not isinstance(other, ast.IfExpr) or not isinstance(subject, ast.NameExpr | ast.MemberExpr):
            continue
        with ck.muted():
            kind = ck.infer(ctx, subject)
        branches = [e for e in (other.then, other.otherwise) if isinstance(e, ast.NameExpr)]
        if not isinstance(kind, ChoiceType) or not all(e.name in kind.values for e in branches):
            continue
        if len(branches) == 2:
            name, c = subject.span.words, other.condition.span.words
            a, b = (f"{name} {expr.op} {e.name}" for e in branches)
            message = "a choice is compared with one option at a time"
            ck.error("wrong-type", other.span, message, hint=f"write `{a} if {c} else {b}`")
            return True
    return False


_NO_VALUES = ("part", "repeat", "slot", "port", "joint", "surface", "curve")
"""The kinds of declarations that are no value to compare with."""


def choice_word(ck: Checker, ctx: Context, other: ast.Expr, expr: ast.Expr) -> Type | None:
    """The type of ``expr`` where it is a bare word compared with a choice (``lever == left``), else None."""
    if not isinstance(expr, ast.NameExpr) or isinstance(other, ast.NumberExpr | ast.BinaryExpr | ast.CallExpr):
        return None
    if ctx.scope is None or isinstance(other, ast.NameExpr) and not ctx.scope.find(other.name):
        return None
    declared = ctx.scope.find(expr.name)
    if any(entry.kind not in _NO_VALUES for entry in declared):
        return None
    kind = ck.infer(ctx, other)
    if not isinstance(kind, ChoiceType):
        return None
    if declared:
        message = f"`{expr.name}` is a {declared[0].kind} here, so it is not the option of that name"
        return ck.error("wrong-type", expr.span, message, hint=f"rename the {declared[0].kind}, or the option")
    if expr.name not in kind.values:
        return ck.error(
            "unknown-choice",
            expr.span,
            f"`{expr.name}` is not one of {', '.join(kind.values)}",
            hint=did_you_mean(expr.name, kind.values) or instead(expr, UNKNOWN, kind),
        )
    ck.mean(expr, Word(expr.name))
    if not ctx.silent:
        ck.types[id(expr)] = kind
    return kind
