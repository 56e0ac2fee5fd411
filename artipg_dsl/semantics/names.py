"""The words of the language that programs may not declare, and the built-in functions and constructors."""

from __future__ import annotations

FACES = ("front", "back", "left", "right", "top", "bottom")
"""The six faces of a box: +x -x +y -y +z -z."""

OWN = ("size", "center", "box")
"""Members that every box has besides its faces."""

DIRECTIONS = ("x", "y", "z")

SCALAR_TYPES = (
    "length",
    "angle",
    "ratio",
    "count",
    "bool",
    "area",
    "volume",
    "mass",
    "density",
    "time",
    "force",
    "torque",
    "speed",
)
"""Type names whose values are numbers."""

TYPE_NAMES = (
    *SCALAR_TYPES,
    "choice",
    "vec",
    "point",
    "frame",
    "plane",
    "edge",
    "line",
    "curve",
    "box",
    "material",
    "string",
)

DRIVES = ("pushes", "pulls", "pushes_back", "pulls_back")
"""The functions of a joint at a point of a surface, which stand in formulas of labels and fields."""

FUNCTIONS = (
    "sin",
    "cos",
    "tan",
    "asin",
    "acos",
    "atan",
    "atan2",
    "sqrt",
    "hypot",
    "abs",
    "min",
    "max",
    "sum",
    "floor",
    "ceil",
    "round",
    "exp",
    "log",
    "sign",
    "mod",
    "number",
    "lowest",
    *DRIVES,
)

RESERVED_TYPES = (
    "length",
    "angle",
    "ratio",
    "count",
    "bool",
    "choice",
    "vec",
    "frame",
    "plane",
    "line",
    "curve",
    "material",
)
"""Type names that a program may not take: the others are free, they only stand where a type is expected."""

CONSTRUCTORS = ("frame", "line", "box", "from", "arc", "circle", "rectangle", "polygon", "offset")

WORDS = ("base", "previous", "last", "true", "false", "pi", *DIRECTIONS)
"""Names with a fixed meaning inside bodies."""


def reserved_name(name: str) -> str | None:
    """Why a name cannot be declared at all ("a type name" ...), or None where it can."""
    if name in TYPE_NAMES:
        return "a type name"
    if name in CONSTRUCTORS:
        return "a constructor"
    if name in WORDS:
        return "a word of the language"
    if name in FUNCTIONS:
        return "a built-in function"
    return None
