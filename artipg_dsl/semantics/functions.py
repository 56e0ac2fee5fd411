"""Types of the functions of the language: arguments and parameters, and the rules that the table of functions names."""

from __future__ import annotations

from collections.abc import Callable
from fractions import Fraction
from typing import TYPE_CHECKING

from ..diagnostics.suggest import any_of, did_you_mean, given
from ..language import FACES, METHODS, Form, Parameter
from ..syntax import ast
from ..syntax.walk import walk
from .fold import is_unitless
from .guards import consistent
from .meanings import BuiltIn, Declared, Inner
from .remedies import instead, with_likely_units
from .surfaces import check_parameters
from .types import (
    ANGLE,
    BOOL,
    COUNT,
    CURVE,
    LENGTH,
    PLANE,
    RATIO,
    SURFACE,
    UNKNOWN,
    Boxed,
    ElementType,
    JointType,
    PartType,
    ScalarType,
    SlotType,
    Type,
    VecType,
    dimension_of,
    fits,
    is_number,
    named,
    power,
    with_article,
)

if TYPE_CHECKING:
    from .checker import Checker, Context


Bound = list[tuple[ast.Argument, Parameter]]


def built_in(ck: Checker, ctx: Context, expr: ast.CallExpr, forms: tuple[Form, ...]) -> Type:
    """A call of a function of the language: of its first form that takes arguments of these names."""
    names = [a.name for a in expr.arguments]
    form = next((f for f in forms if f.takes(names)), forms[0] if len(forms) == 1 else None)
    if form is None:
        known = any_of([f.call for f in forms])
        ck.error(
            "wrong-arguments", expr.span, f"`{forms[0].name}` does not take these arguments", hint=f"write {known}"
        )
    elif (bound := _bound(ck, expr, form)) is not None:
        ck.mean(expr.function, BuiltIn(form))
        kind = RULES[form.rule](ck, ctx, expr, form, bound)
        return kind if kind != CURVE else _made(ck, ctx, expr, form)
    taken = {parameter.name for form in forms for parameter in form.parameters}
    for argument in expr.arguments:
        if argument.name is None or argument.name in taken:
            ck.infer(ctx.but(many=True), argument.value)
    return UNKNOWN


def _made(ck: Checker, ctx: Context, expr: ast.CallExpr, form: Form) -> Type:
    """A curve is made where it gets a name or a solid is made of it, a piece of a path behind the pieces before it."""
    if isinstance(ctx.making, ast.ChainExpr) if form.meaning == "path" else ctx.making is expr:
        return CURVE
    if form.meaning == "path":
        hint = "a path is `from(point, direction)`, then `line(length)` and `arc(radius, angle, towards)`"
        return ck.error(
            "wrong-type", expr.span, f"`{form.name}` is a piece of a path, which has no value alone", hint=hint
        )
    hint = f"give it a name first, as in `curve edge = {form.call}`"
    return ck.error("wrong-type", expr.span, f"`{form.name}` makes a curve, which cannot stand here", hint=hint)


def _bound(ck: Checker, expr: ast.CallExpr, form: Form) -> Bound | None:
    """The arguments with the parameters that they are for; what is too many, unknown, twice or missing is reported."""
    names = [a.name for a in expr.arguments]
    pairs = list(zip(expr.arguments, form.bind(names), strict=True))
    if form.takes(names):
        return [(argument, parameter) for argument, parameter in pairs if parameter is not None]
    known, word = [p.name for p in form.parameters], form.name
    if not any(names) and form.kind in ("number", "reduction", "force"):
        ck.error(
            "wrong-arguments",
            expr.span,
            f"`{word}` takes {_counted(form)}, {given(len(names))}",
            hint=f"write `{form.call}`",
        )
        return None
    found: set[str] = set()
    for argument, parameter in pairs:
        if parameter is None:
            what = f"has no argument `{argument.name}`" if argument.name else f"takes {_counted(form)} at most"
            hint = did_you_mean(argument.name or "", known) or "it takes " + ", ".join(known)
            ck.error("unknown-argument", argument.span, f"`{word}` {what}", hint=hint)
        elif parameter.name in found:
            ck.error("wrong-arguments", argument.span, f"`{parameter.name}` is given twice", hint="keep one of the two")
        found.add("" if parameter is None else parameter.name)
    missing = [p.name for p in form.required if p.name not in found]
    if missing and "" not in found:
        late = [a for a in expr.arguments[1:] if a.name is None and any(names)]
        hint = f"write `{form.call}`" + (f"; `{late[0].span.words}`, without a name, comes first" if late else "")
        ck.error("missing-argument", expr.span, f"`{word}` needs {any_of(missing, 'and')}", hint=hint)
    return None


def _counted(form: Form) -> str:
    number = len(form.parameters)
    return ("one argument" if number == 1 else f"{number} arguments") + " or more" * form.more


def _dimension(kind: Type) -> Type:
    """A plane counts as its coordinate."""
    return LENGTH if kind == PLANE else kind


def _one(ck: Checker, ctx: Context, expr: ast.CallExpr, form: Form, bound: Bound) -> Type:
    """One number, of the dimension that its parameter says."""
    ((argument, parameter),) = bound
    kind = _dimension(ck.infer(ctx, argument.value))
    if kind == UNKNOWN:
        return UNKNOWN
    wanted = None if parameter.type == "number" else named(parameter.type)
    angle_zero = wanted == ANGLE and isinstance(kind, ScalarType) and kind.zero
    if not isinstance(kind, ScalarType) or not (wanted is None or angle_zero or kind.dimension == dimension_of(wanted)):
        hint = (
            _angle(argument.value)
            if wanted == ANGLE and kind in (RATIO, COUNT)
            else instead(argument.value, kind, wanted or RATIO)
        )
        code = "wrong-dimension" if isinstance(kind, ScalarType) else "wrong-type"
        takes = with_article(parameter.type)
        return ck.error(code, argument.span, f"`{form.name}` takes {takes}, but this is {kind}", hint=hint)
    if form.gives == "root":
        return ScalarType(power(kind.dimension, Fraction(1, 2)))
    return kind if form.gives == "number" else named(form.gives)


def _angle(value: ast.Expr) -> str:
    """How a number without a unit becomes an angle."""
    if isinstance(value, ast.NumberExpr):
        return f"an angle needs a unit: write {with_likely_units(value, ANGLE.dimension)}"
    return "an angle needs a unit: multiply by 1deg, 1rad or 1turn"


def _alike(ck: Checker, ctx: Context, expr: ast.CallExpr, form: Form, bound: Bound) -> Type:
    """Numbers of one dimension."""
    found: Type | None = None
    first: ast.Argument | None = None
    kinds = [_dimension(ck.infer(ctx, argument.value)) for argument, _ in bound]
    for (argument, _), kind in zip(bound, kinds, strict=True):
        if kind == UNKNOWN:
            return UNKNOWN
        if not isinstance(kind, ScalarType):
            return ck.unfit(argument, kind, f"`{form.name}` takes numbers", hint=instead(argument.value, kind, RATIO))
        if kind.zero:
            found = found or kind
        elif not isinstance(found, ScalarType) or found.zero:
            found, first = kind, argument
        elif kind.dimension != found.dimension:
            if first is not None and is_unitless(first.value):
                ck.mismatch(first.value, found, kind, "this argument")
            else:
                ck.mismatch(argument.value, kind, found, "this argument")
            return UNKNOWN
        elif not kind.count:
            found = kind
    return found or UNKNOWN if form.gives == "number" else named(form.gives)


def _elements(ck: Checker, ctx: Context, expr: ast.CallExpr, form: Form, bound: Bound) -> Type:
    """A number of each element of a repeat: ``sum(cell.size.z)``."""
    ((argument, _),) = bound
    kind = _dimension(ck.infer(ctx.but(many=True), argument.value))
    if kind == UNKNOWN or not _one_repeat(ck, ctx, argument.value, form):
        return UNKNOWN
    if not is_number(kind):
        return ck.unfit(
            argument,
            kind,
            f"`{form.name}` takes one number per element",
            hint="name a number of the elements, as in `sum(row.size.z)`",
        )
    return kind


def _counted_elements(ck: Checker, ctx: Context, expr: ast.CallExpr, form: Form, bound: Bound) -> Type:
    ((argument, _),) = bound
    kind = ck.infer(ctx.but(many=True), argument.value)
    if kind == UNKNOWN:
        return UNKNOWN
    if not isinstance(kind, ElementType):
        return ck.unfit(
            argument, kind, "`number` counts the elements of a repeat", hint="name the repeat, as in `number(row)`"
        )
    return COUNT if _one_repeat(ck, ctx, argument.value, form) else UNKNOWN


def _one_repeat(ck: Checker, ctx: Context, expr: ast.Expr, form: Form) -> bool:
    """Whether what is reduced runs through one repeat of this body; if not, that is reported."""
    paths_through: dict[str, ast.NameExpr] = {}
    for node in walk(expr):
        home = ctx.scope.home(node.name) if isinstance(node, ast.NameExpr) and ctx.scope is not None else None
        if not isinstance(node, ast.NameExpr) or home is None or not isinstance(ck.meanings.get(id(node)), Declared):
            continue
        repeats = [e for e in home.table[node.name] if e.kind == "repeat"]
        if repeats:
            paths_through.setdefault(node.name, node)
        if sum(consistent(ctx.condition, ck.entry_condition(e)) for e in repeats) > 1:
            ck.error(
                "many-elements",
                node.span,
                f"`{node.name}` is a different repeat in each branch of a `when`",
                hint="reduce each inside its own branch",
                notes=tuple((e.span, "one of them") for e in repeats),
            )
            return False
    if len(paths_through) > 1:
        first, second, *_ = paths_through
        ck.error(
            "many-elements",
            paths_through[second].span,
            f"`{form.name}` reduces over the elements of one repeat, not over those of `{first}` and of `{second}`",
            hint=f"reduce each on its own, or give one of them a number, as in `{second}[0]`",
        )
        return False
    elements = [n for n in walk(expr) if isinstance(ck.types.get(id(n)), ElementType)]
    if paths_through and not any(isinstance(n, ast.IndexExpr) for n in elements):
        return True
    hint = "name a repeat in it, as in `sum(cell.size.z)`, or give several arguments"
    if elements:
        hint = (
            "what lies in a part or in one element is reduced there: `let total = sum(cell.size.z)`, then name `total`"
        )
    message = f"`{form.name}` with one argument reduces over the elements of a repeat"
    ck.error("wrong-arguments", expr.span, message + " of this body" * bool(elements), hint=hint)
    return False


def _typed(ck: Checker, ctx: Context, expr: ast.CallExpr, form: Form, bound: Bound) -> Type:
    """Each argument is of the type of its parameter."""
    failed = False
    for argument, parameter in bound:
        if parameter.type not in ("part", "number"):
            wanted = named(parameter.type)
            kind = ck.expect(ctx, argument.value, wanted, f"`{parameter.name}` of `{form.name}`")
            failed |= not fits(kind, wanted)
            continue
        kind = ck.infer(ctx, argument.value)
        if parameter.type == "part" and kind != UNKNOWN and not isinstance(kind, Boxed):
            ck.unfit(argument, kind, f"`{form.name}` reads the extent of a part", hint=f"as in `{form.name}(body, -z)`")
        if parameter.type == "number" and kind != UNKNOWN and not isinstance(_dimension(kind), ScalarType):
            message = f"`{parameter.name}` of `{form.name}` must be a number, but this is {kind}"
            ck.error("wrong-type", argument.span, message, hint="as in `wall.at(0.25turn, z = h)`")
            failed = True
    return UNKNOWN if failed else named(form.gives)


def _moved(ck: Checker, ctx: Context, expr: ast.CallExpr, form: Form, bound: Bound) -> Type:
    """A curve, or the point of one at a value of its parameter, and a length."""
    (argument, _), (distance, parameter) = bound
    curve = ck.infer(ctx, argument.value)
    ck.expect(ctx, distance.value, LENGTH, f"`{parameter.name}` of `{form.name}`")
    if curve not in (CURVE, UNKNOWN) and not isinstance(curve, VecType):
        return ck.unfit(argument, curve, f"`{form.name}` takes a curve", hint=f"name a curve, as in `{form.call}`")
    return curve


def _force(ck: Checker, ctx: Context, expr: ast.CallExpr, form: Form, bound: Bound) -> Type:
    """``pushes(open)``: what a force on the surface does to a joint, in the formula of a label."""
    if "n" not in ctx.extra:
        return ck.error(
            "wrong-type",
            expr.span,
            f"`{form.name}` asks about a point of a surface, so it is only allowed in formulas of labels and fields",
            hint=f"as in `label affordance.push on door.panel where {form.name}(open)`",
        )
    ((argument, _),) = bound
    kind = ck.infer(ctx.but(lenient=[], asked=True, many=True), argument.value)
    if not isinstance(kind, JointType) and kind != UNKNOWN:
        ck.unfit(argument, kind, f"`{form.name}` takes a joint", hint=f"name a joint, as in `{form.name}(open)`")
    return BOOL


RULES: dict[str, Callable[[Checker, Context, ast.CallExpr, Form, Bound], Type]] = {
    "one": _one,
    "alike": _alike,
    "elements": _elements,
    "counted": _counted_elements,
    "typed": _typed,
    "moved": _moved,
    "force": _force,
}
"""The rules of types, by the name that the table of functions gives them."""


def method(ck: Checker, ctx: Context, expr: ast.CallExpr, function: ast.MemberExpr) -> Type:
    """``body.wall.at(u, z = h)``: a frame on a surface."""
    form, named = METHODS.get(function.name), function.obj
    if isinstance(named, ast.MemberExpr) and named.name in FACES:
        ck.meanings.pop(id(named), None)  # of a function that is called again
    obj = ck.infer(ctx, named)
    if obj == PLANE and form is not None and isinstance(named, ast.MemberExpr) and _all_have_surface(ck, named):
        ck.mean(named, Inner(named.name))  # the surface of that name, not the face of the box
        obj = SURFACE
    if obj == UNKNOWN or form is None or not (obj == SURFACE or isinstance(obj, SlotType)):
        for argument in expr.arguments:
            ck.infer(ctx, argument.value)
        if obj == UNKNOWN:
            return UNKNOWN
        hint = (
            "parts and values have no functions: write `f(a)`, or leave the arguments out"
            if form is None
            else "this is a face of a box: write `at` behind it, as in `to body.front at y = 2cm, z = 1cm`"
            if obj == PLANE
            else f"`{form.name}` is a function of surfaces of primitives: `body.wall.at(0.25turn, z = h)`"
        )
        return ck.error("unknown-function", function.name_span, f"{obj} has no function `{function.name}`", hint=hint)
    bound = _bound(ck, expr, form)
    if bound is not None and len(bound) != 2:
        return ck.error(
            "wrong-arguments",
            expr.span,
            "`at` needs two values, as in `wall.at(0.25turn, z = h)`",
            hint="give the place around and the height",
        )
    ck.mean(function, BuiltIn(form))
    kind = _typed(ck, ctx, expr, form, bound or [])
    return kind if kind == UNKNOWN or check_parameters(ck, named, bound or []) else UNKNOWN


def _all_have_surface(ck: Checker, face: ast.MemberExpr) -> bool:
    """Whether whatever a part is made of has a surface that is called like this face of its box."""
    part = ck.types.get(id(face.obj))
    return isinstance(part, PartType) and all(
        v.symbol is not None
        and any(entry.kind == "surface" for entry in ck.scope_of(v.symbol).table.get(face.name, ()))
        for v in part.variants
    )
