"""What to try where a value is of another type than its place needs."""

from __future__ import annotations

from collections.abc import Iterable
from math import pi

from ..syntax import ast
from ..units import UNITS, Dimension
from .types import (
    ANGLE,
    BOOL,
    BOX,
    CURVE,
    DIRECTION,
    FRAME,
    LENGTH,
    LENGTH_DIM,
    LINE,
    NONE,
    PLANE,
    POINT,
    STRING,
    Boxed,
    ChoiceType,
    FunctionType,
    JointType,
    NamedType,
    ScalarType,
    Type,
    VecType,
    dimension_name,
    times,
    with_article,
)

_UNITS = {"length": "cm", "angle": "deg", "mass": "kg", "density": "kg/m3", "time": "s", "force": "N", "speed": "m/s"}
_FACTORS = _UNITS | {"angle": "rad"}  # 1rad is the unit whose factor is 1


def usual_unit(dimension: Dimension) -> str:
    """The unit to suggest for a dimension."""
    return _UNITS.get(dimension_name(dimension), "")


def with_likely_units(number: ast.NumberExpr, dimension: Dimension, beside: Iterable[ast.Expr | None] = ()) -> str:
    """A number with each of the units that may be meant: that of a number ``beside`` it, as the other end of its range; else small
    ones may be metres, radians or turns."""
    value, text = number.value, number.span.text
    units = (other.unit for other in beside if isinstance(other, ast.NumberExpr))
    if (unit := next((unit for unit in units if unit and UNITS[unit][1] == dimension), None)) is not None:
        return f"{text}{unit}"
    broken = value % 1 > 0
    small = {"length": {"m": value < 1}, "angle": {"rad": broken and value < 2 * pi, "turn": broken and value < 1}}
    rarer = [unit for unit, meant in small.get(dimension_name(dimension), {}).items() if meant]
    *others, last = [f"{text}{unit}" for unit in (usual_unit(dimension), *rarer)]
    return f"{', '.join(others)} or {last}" if others else last


def instead(expr: ast.Node, given: Type, wanted: Type) -> str | None:
    """How to get what is ``wanted`` of what stands there, or None where nobody can tell."""
    text = expr.span.words
    if isinstance(given, FunctionType):
        return f"write its arguments: `{text}(...)`"
    if isinstance(wanted, ScalarType):
        return _number(expr, given, wanted)
    if isinstance(wanted, VecType):
        if isinstance(given, VecType) and given.size != wanted.size:
            return f"write {wanted.size} components"
        if isinstance(given, ScalarType) and given.dimension == wanted.dimension:
            return f"give a value for each: [{', '.join([text] * wanted.size)}]"
        return f"write a vector: `[{', '.join('abc'[: wanted.size])}]`, each {_each(wanted)}"
    if isinstance(wanted, ChoiceType):
        if given == STRING and isinstance(expr, ast.StringExpr):
            return f"write the option without quotes: {' or '.join(f'`{value}`' for value in wanted.values)}"
        return f"write one of its options: {' or '.join(f'`{value}`' for value in wanted.values)}"
    return _place(text, given, wanted)


def _each(wanted: VecType) -> str:
    return "a number" if wanted.dimension is None else with_article(dimension_name(wanted.dimension))


def _place(text: str, given: Type, wanted: Type) -> str | None:
    """Of what is no number: a condition, a direction, a point, a line, a box, a curve."""
    if wanted == BOOL:
        return (
            f"compare it, as in `{text} > 0`" if isinstance(given, ScalarType) else "write a comparison, as in `a > b`"
        )
    if wanted == DIRECTION:
        return "write `x`, `y` or `z`, with a sign if need be, or a vector such as `[0, 1, 1]`"
    if wanted == POINT:
        if isinstance(given, Boxed) or given in (BOX, PLANE):
            return f"name a point of it: `{text}.center`"
        return "write a point: `[x, y, z]`, three lengths, or the `.center` of a part or a face"
    if wanted == FRAME:
        return "name a port or a face, or write `frame(at = ..., out = ..., up = ...)`"
    if wanted == LINE:
        return "name an edge, such as `part.left.back`, or write `line(at = ..., along = ...)`"
    if wanted == BOX:
        return f"write `{text}.box`" if isinstance(given, Boxed) else "name a part, or write `box(front = ..., ...)`"
    if wanted == CURVE:
        return "name a curve, or write one, such as `circle(1cm)`"
    return 'write a text in quotes: `"..."`' if wanted == STRING else None


def _number(expr: ast.Node, given: Type, wanted: ScalarType) -> str | None:
    text, length = expr.span.words, wanted.dimension == LENGTH_DIM
    match given:
        case ScalarType():
            return _converted(expr, given, wanted)
        case VecType(size=size):
            if isinstance(expr, ast.VectorExpr):
                return "write one number, without brackets"
            return f"name one of its components, such as `{text}.{'xyz'[:size][-1]}`"
        case ChoiceType(values=values):
            return f"make a number of it: `a if {text} == {values[0]} else b`"
        case JointType():
            return "a joint's value is no number of the program: only `mimic` and `when` of a joint read it"
        case NamedType() if given == BOOL:
            return f"make a number of it: `a if {text} else b`"
        case NamedType() if given == DIRECTION:
            return f"`{text}` is a direction; the coordinate of a point p is `p.{text.lstrip('-+')}`"
    if isinstance(given, Boxed) or given == BOX:
        return f"name a measure of it, such as `{text}.size.z`" if length else "name a parameter of it"
    if given in (POINT, PLANE):
        return (
            f"name a coordinate of it, such as `{text}.z`"
            if given == POINT
            else f"name a coordinate, such as `{text}.center.z`"
        )
    return None


def _converted(expr: ast.Node, given: ScalarType, wanted: ScalarType) -> str | None:
    """How one quantity becomes another: a whole number by rounding, another dimension by the factor between the two."""
    text = expr.span.words
    literal = (
        isinstance(expr, ast.NumberExpr) or isinstance(expr, ast.UnaryExpr) and isinstance(expr.operand, ast.NumberExpr)
    )
    if wanted.count and given.dimension == NONE:
        return "write a whole number" if literal else f"round it: `floor({text})`, `round({text})` or `ceil({text})`"
    if wanted.dimension == NONE:
        if literal:
            return "write a number without a unit"
        what = with_article(dimension_name(given.dimension))
        whole = (
            f"({text})" if isinstance(expr, ast.BinaryExpr | ast.IfExpr | ast.UnaryExpr) and text[0] != "(" else text
        )
        share = f"divide it by {what}: `{whole} / ...`" if len(text) < 40 else f"divide it by {what}"
        return f"{share}, and round that with `floor`, `round` or `ceil`" if wanted.count else share
    if literal:
        unit = usual_unit(wanted.dimension)
        return f"write it in `{unit}`" if unit else f"write {wanted}"
    if (given.dimension, wanted.dimension) == (NONE, ANGLE.dimension):
        return "multiply it by the angle that 1 stands for: `1deg`, `1turn` or `1rad`"
    factor, divisor = times(wanted.dimension, given.dimension, -1), times(given.dimension, wanted.dimension, -1)
    for word, dimension in (("divide", divisor), ("multiply", factor)):
        name = dimension_name(dimension)
        if name in _FACTORS or name in ("area", "volume"):
            example = f", such as `1{_FACTORS[name]}`" if name in _FACTORS else ""
            return f"{word} it by {with_article(name)}{example}"
    if (given.dimension, wanted.dimension) in (
        (ANGLE.dimension, LENGTH.dimension),
        (LENGTH.dimension, ANGLE.dimension),
    ):
        quotient = "2cm / 90deg" if wanted == LENGTH else "90deg / 2cm"
        return f"multiply it by how much of the one goes with how much of the other, such as `({quotient})`"
    return f"check the formula: {with_article(dimension_name(wanted.dimension))} is needed"
