"""Types of expressions: literals, operators and conditions; names and calls are in ``paths`` and ``calls``."""

from __future__ import annotations

from fractions import Fraction
from typing import TYPE_CHECKING

from ..diagnostics.suggest import did_you_mean
from ..syntax import ast
from ..units import UNITS
from . import calls, conditions, foreign, members, paths
from .fold import constant, is_unitless
from .guards import Condition, Not, consistent
from .meanings import Global
from .remedies import instead, usual_unit
from .types import (
    BOOL,
    COUNT,
    DIRECTION,
    LENGTH,
    LENGTH_DIM,
    MATERIAL,
    NONE,
    PLANE,
    POINT,
    RATIO,
    SIZE,
    STRING,
    UNKNOWN,
    ZERO,
    ChoiceType,
    ElementType,
    PartType,
    ScalarType,
    StyleType,
    Type,
    VecType,
    dimension_of,
    fits,
    is_number,
    power,
    times,
)

if TYPE_CHECKING:
    from .checker import Checker, Context


def infer(ck: Checker, ctx: Context, expr: ast.Expr) -> Type:
    """The type of an expression where it stands."""
    match expr:
        case ast.NumberExpr():
            return _number(ck, ctx, expr)
        case ast.StringExpr():
            return STRING
        case ast.NameExpr():
            return paths.name(ck, ctx, expr)
        case ast.MemberExpr():
            return members.member(ck, ctx, expr)
        case ast.IndexExpr():
            return members.index(ck, ctx, expr)
        case ast.CallExpr():
            return calls.call(ck, ctx, expr)
        case ast.ChainExpr():
            return calls.chain(ck, ctx, expr)
        case ast.VectorExpr():
            return _vector(ck, ctx, expr)
        case ast.HoleExpr():
            return ck.error(
                "misplaced-hole",
                expr.span,
                "`_` can only replace a component of a vector argument",
                hint="as in `Cuboid(size = [_, wall, _])`; to leave a single number to the equations, omit the argument",
            )
        case ast.UnaryExpr(op="not", operand=operand):
            conditions.truth(ck, ctx, operand)
            return BOOL
        case ast.UnaryExpr(op=op, operand=operand):
            kind = ck.infer(ctx, operand)
            if isinstance(kind, ScalarType | VecType) or kind in (UNKNOWN, DIRECTION):
                return kind
            if kind == PLANE:
                return LENGTH
            return ck.unfit(
                expr, kind, f"`{op}` needs a number, a vector or a direction", hint=instead(expr.operand, kind, RATIO)
            )
        case ast.BinaryExpr(op="and" | "or"):
            conditions.truth(ck, ctx, expr.left)
            known = conditions.of(ck, ctx, expr.left)
            conditions.truth(ck, ctx.given(known if expr.op == "and" else Not(known)), expr.right)
            return BOOL
        case ast.BinaryExpr(op="==" | "!=" | "<" | "<=" | ">" | ">="):
            return _compare(ck, ctx, expr)
        case ast.BinaryExpr():
            return _arithmetic(ck, ctx, expr)
        case ast.IsExpr():
            return conditions.check_is(ck, ctx, expr)
        case ast.IfExpr():
            return _if(ck, ctx, expr)
    raise TypeError(f"no rule for {type(expr).__name__}")


def _number(ck: Checker, ctx: Context, expr: ast.NumberExpr) -> Type:
    if expr.unit:
        if expr.unit not in UNITS:
            times = f"a unit follows a number directly; to multiply, write `{expr.value:g} * {expr.unit}`"
            return ck.error(
                "unknown-unit",
                expr.span,
                f"there is no unit `{expr.unit}`",
                hint=(times if expr.unit in ctx.names() else None)
                or foreign.UNITS.get(expr.unit.lower())
                or did_you_mean(expr.unit, UNITS)
                or "use mm, cm or m for lengths, deg, rad or turn for angles",
            )
        return ScalarType(UNITS[expr.unit][1])
    if expr.value == 0:
        return ZERO
    return ScalarType(NONE, count=float(expr.value).is_integer())


def _vector(ck: Checker, ctx: Context, expr: ast.VectorExpr) -> Type:
    if len(expr.items) not in (2, 3):
        return ck.error(
            "wrong-type",
            expr.span,
            f"a vector has two or three components, but this one has {len(expr.items)}",
            hint="write `[x, y, z]` or `[x, y]`; more values are several vectors",
        )
    dimension = ctx.component
    first: ast.Expr | None = None
    plain = ctx.but(holes=False, component=None)
    failed = False
    for item in expr.items:
        if isinstance(item, ast.HoleExpr) and ctx.holes:
            continue
        kind = ck.infer(plain, item)
        if kind == UNKNOWN:
            failed = True
            continue
        if not is_number(kind):
            failed = True
            ck.unfit(
                item,
                kind,
                "a component of a vector must be a number",
                hint=instead(item, kind, RATIO if ctx.component is None else ScalarType(ctx.component)),
            )
            continue
        found = dimension_of(kind)
        if found is None:
            continue
        if dimension is None:
            dimension, first = found, item
        elif found != dimension:
            failed = True
            wanted = ScalarType(dimension)
            if first is not None and is_unitless(first):  # the one without a unit is the one to blame
                ck.mismatch(first, ScalarType(dimension), kind, "this component of the vector")
            else:
                ck.mismatch(item, kind, wanted, "this component of the vector")
    return UNKNOWN if failed else VecType(len(expr.items), dimension)


def _if(ck: Checker, ctx: Context, expr: ast.IfExpr) -> Type:
    conditions.truth(ck, ctx, expr.condition)
    known = conditions.of(ck, ctx, expr.condition)
    then = ck.infer(_branch(ctx, known), expr.then)
    otherwise = ck.infer(_branch(ctx, Not(known)), expr.otherwise)
    for a, b in ((then, otherwise), (otherwise, then)):
        if UNKNOWN in (a, b) or not fits(a, b):
            continue
        if isinstance(b, ScalarType | VecType) or b in (POINT, DIRECTION, BOOL) or isinstance(b, ChoiceType) and a == b:
            return b
        if b == PLANE:
            return LENGTH
        hint = _instead_of_if(ck, expr, b)
        message = f"`if` chooses between numbers, vectors and points, but this is {b}"
        return ck.error("wrong-type", expr.span, message, hint=hint)
    if UNKNOWN in (then, otherwise):
        return UNKNOWN
    if isinstance(then, StyleType) and isinstance(otherwise, StyleType):
        return ck.error(
            "wrong-type", expr.span, "`if` cannot choose between templates", hint=_instead_of_if(ck, expr, then)
        )
    ck.mismatch(expr.otherwise, otherwise, then, "the other branch")
    return UNKNOWN


def _branch(ctx: Context, known: Condition) -> Context:
    """Where a branch is read: in one that is never taken, which the ranges tell, no name is missed."""
    given = ctx.given(known)
    return given if consistent(given.condition) or not consistent(ctx.condition) else ctx.but(lenient=[], asked=True)


def _instead_of_if(ck: Checker, expr: ast.IfExpr, kind: Type) -> str:
    """What to write in place of an `if` between values that cannot be computed with."""
    named = [ck.meanings.get(id(branch)) for branch in (expr.then, expr.otherwise)]
    role = "material" if kind == MATERIAL else "ROLE" if isinstance(kind, StyleType) else None
    if role is None:
        return "choose the part that has it by `when`, or its numbers one by one"
    a, b = (m.symbol.name if isinstance(m, Global) else letter for m, letter in zip(named, "AB", strict=True))
    c = expr.condition.span.words
    grouped = c if isinstance(expr.condition, ast.NameExpr | ast.CallExpr | ast.MemberExpr) else f"({c})"
    return f"declare a style and use it here: `style chosen : {role} = {a} when {c} | {b} when not {grouped}`"


def _compare(ck: Checker, ctx: Context, expr: ast.BinaryExpr) -> Type:
    if conditions.compares_with_either(ck, ctx, expr):
        return BOOL
    if (part := conditions.equated_part(ck, ctx, expr)) is not None:
        words = part[0].span.words
        said = f"`{words}` is a part, which is not compared with `true` or `false`"
        ck.error(
            "wrong-type",
            expr.span,
            said,
            hint=f"it tells by itself whether it is there: write `{'' if part[1] else 'not '}{words}`",
        )
        return BOOL
    left = conditions.choice_word(ck, ctx, expr.right, expr.left) or ck.infer(ctx, expr.left)
    right = conditions.choice_word(ck, ctx, expr.left, expr.right) or ck.infer(ctx, expr.right)
    if UNKNOWN in (left, right):
        return BOOL
    if is_number(left) and is_number(right):
        if None not in (dimension_of(left), dimension_of(right)) and dimension_of(left) != dimension_of(right):
            _blame(ck, expr, left, right, f"`{expr.op}` compares values of the same kind")
        return BOOL
    same = left == right == BOOL or left == right == STRING or _asks_material(ck, expr, left, right)
    if expr.op in ("==", "!=") and (same or isinstance(left, ChoiceType) and isinstance(right, ChoiceType)):
        return BOOL
    hint = _hint_of_comparison(expr, left, right)
    ck.error("wrong-type", expr.span, f"`{expr.op}` cannot compare {left} and {right}", hint=hint)
    return BOOL


def _hint_of_comparison(expr: ast.BinaryExpr, left: Type, right: Type) -> str | None:
    """What to write where two types cannot be compared, if that can be guessed."""
    sides = ((expr.left, right), (expr.right, left))  # each with the type of the other
    choices = isinstance(left, ChoiceType) or isinstance(right, ChoiceType)
    if expr.op not in ("==", "!=") and choices:
        return "the options of a choice have no order: compare them by `==` or `!=`"
    for side, other in sides:
        if isinstance(side, ast.NameExpr) and isinstance(other, ChoiceType) and side.name in other.values:
            return f"`{side.name}` is declared here, so it is not the option of that name: rename what is declared"
    if isinstance(left, StyleType) and isinstance(right, StyleType):
        return f"to test what a style is, write `{expr.left.span.words} is {expr.right.span.words}`"
    if isinstance(left, PartType) or isinstance(right, PartType):
        return "to test what a part is, write `part is Template`"
    if STRING in (left, right) and choices:
        return "the options of a choice are written without quotes"
    if any(isinstance(a, VecType) and isinstance(b, ScalarType) for a, b in ((left, right), (right, left))):
        return "compare a component of the vector, such as `size.x`"
    for side, _ in sides:
        if isinstance(side, ast.NameExpr) and side.name in ("x", "y", "z"):
            return f"`{side.name}` is a direction; the coordinate of a point p is `p.{side.name}`"
    return None


def _asks_material(ck: Checker, expr: ast.BinaryExpr, left: Type, right: Type) -> bool:
    """Whether a comparison asks which material a style of materials is."""
    if not left == right == MATERIAL:
        return False
    named = [isinstance(ck.meanings.get(id(side)), Global) for side in (expr.left, expr.right)]
    return named.count(True) == 1


def _blame(ck: Checker, expr: ast.BinaryExpr, left: Type, right: Type, rule: str) -> None:
    """Reports a mismatch of two operands at the one that carries no unit, else at the operator."""
    for operand, own, other in ((expr.left, left, right), (expr.right, right, left)):
        if isinstance(own, ScalarType | VecType) and own.dimension == NONE and is_unitless(operand):
            ck.mismatch(operand, own, other if other != PLANE else LENGTH, "this number")
            return
    ck.error(
        "wrong-dimension",
        expr.span,
        f"{rule}: on the left {left}, on the right {right}",
        hint=_reconciled(expr, left, right),
    )


def _arithmetic(ck: Checker, ctx: Context, expr: ast.BinaryExpr) -> Type:
    left, right = ck.infer(ctx, expr.left), ck.infer(ctx, expr.right)
    return UNKNOWN if UNKNOWN in (left, right) else arithmetic(ck, expr, left, right)


def arithmetic(ck: Checker, expr: ast.BinaryExpr, left: Type, right: Type) -> Type:
    """The type of a sum, product, quotient or power of operands of these types."""
    if expr.op in ("+", "-"):
        found = _sum(expr.op, left, right)
        if found is None and _addable(left) and _addable(right):
            _blame(ck, expr, left, right, f"`{expr.op}` needs the same dimension on both sides")
            return UNKNOWN
    elif expr.op == "^":
        return _power(ck, expr, left, right)
    else:
        found = _product(expr.op, left, right)
    if found is None:
        hint = next((operand.ranked for operand in (left, right) if isinstance(operand, ElementType)), None)
        hint = hint or _computable(expr, left, right)
        return ck.error("wrong-type", expr.span, f"`{expr.op}` does not apply to {left} and {right}", hint=hint)
    return found


def _computable(expr: ast.BinaryExpr, left: Type, right: Type) -> str:
    """What to write for the operand that nothing can be computed with."""
    odd = next(
        ((e, k) for e, k in ((expr.left, left), (expr.right, right)) if not _addable(k) and k != DIRECTION), None
    )
    found = None if odd is None else instead(*odd, LENGTH if PLANE in (left, right) else RATIO)
    return found or "compute with numbers or vectors of the same size: name the components, as in `a.x`"


def _reconciled(expr: ast.BinaryExpr, left: Type, right: Type) -> str | None:
    """How one side of a sum or a comparison gets the dimension of the other."""
    a, b = (LENGTH if kind == PLANE else kind for kind in (left, right))
    if isinstance(a, VecType) and isinstance(b, ScalarType):
        return instead(expr.left, a, b)
    literal = isinstance(expr.right, ast.NumberExpr)  # what is computed may need a factor, a number another unit
    sides = (expr.left, a, b) if literal and not usual_unit(dimension_of(a) or NONE) else (expr.right, b, a)
    return instead(*sides)


def _addable(kind: Type) -> bool:
    return isinstance(kind, ScalarType | VecType) or kind in (PLANE, POINT)


def _sum(op: str, left: Type, right: Type) -> Type | None:
    if left == PLANE or right == PLANE:
        if left == right or (right == PLANE and op == "-"):
            return LENGTH if fits(left, LENGTH) else None
        return PLANE if fits(left, LENGTH) and fits(right, LENGTH) else None
    if isinstance(left, ScalarType) and isinstance(right, ScalarType):
        if left.zero or right.zero:
            kept = right if left.zero else left
            return kept
        if left.dimension != right.dimension:
            return None
        return ScalarType(left.dimension, count=left.count and right.count)
    if left == POINT or right == POINT:
        if not (fits(left, POINT) and fits(right, POINT)):
            return None
        return SIZE if left == right else POINT
    if DIRECTION in (left, right):
        left, right = (VecType(3, NONE) if t == DIRECTION else t for t in (left, right))
    if isinstance(left, VecType) and isinstance(right, VecType) and fits(left, right):
        return left if right.dimension is None else right
    return None


def _product(op: str, left: Type, right: Type) -> Type | None:
    sign = 1 if op == "*" else -1
    left, right = (
        LENGTH if t == PLANE else SIZE if t == POINT else VecType(3, NONE) if t == DIRECTION else t
        for t in (left, right)
    )
    if isinstance(left, ScalarType) and isinstance(right, ScalarType):
        if left.zero or (right.zero and op == "*"):
            return ZERO
        dimension = times(left.dimension, right.dimension, sign)
        return ScalarType(dimension, count=left.count and right.count and op == "*")
    if isinstance(left, VecType) and isinstance(right, ScalarType):
        return VecType(left.size, None if left.dimension is None else times(left.dimension, right.dimension, sign))
    if isinstance(left, ScalarType) and isinstance(right, VecType) and op == "*":
        return VecType(right.size, None if right.dimension is None else times(left.dimension, right.dimension))
    return None


def _power(ck: Checker, expr: ast.BinaryExpr, left: Type, right: Type) -> Type:
    if not isinstance(left, ScalarType) and left != PLANE:
        return ck.unfit(expr.left, left, "`^` needs a number", hint=instead(expr.left, left, RATIO))
    if not isinstance(right, ScalarType) or dimension_of(right) not in (NONE, None):
        hint = instead(expr.right, right, RATIO)
        if isinstance(expr.right, ast.NumberExpr) and "/" in (written := expr.right.span.text):
            divided = f"{expr.left.span.words}^{written.replace('/', ' / ')}"
            hint = f"without spaces `{written}` is one number; for a power that is divided, write `{divided}`"
        return ck.error(
            "wrong-dimension", expr.right.span, f"an exponent must be a plain number, but this is {right}", hint=hint
        )
    dimension = LENGTH_DIM if left == PLANE else left.dimension  # type: ignore[union-attr]
    if dimension == NONE:
        return COUNT if left == COUNT and right == COUNT else ScalarType(NONE)
    value = constant(expr.right)
    if value is None:
        return ck.error(
            "wrong-dimension",
            expr.right.span,
            f"{left} can only be raised to a constant power",
            hint="otherwise the dimension of the result is unknown",
        )
    return ScalarType(power(dimension, Fraction(value).limit_denominator(12)))
