"""Names with a fixed meaning: types, axes, constants, places; and what a program may not call its own."""

from __future__ import annotations

import math

from ..records import dataclass
from .functions import FUNCTIONS


@dataclass(frozen=True, slots=True)
class Word:
    """``kind``: number or type (both name types), axis, constant, place. ``value`` of a constant. A ``free`` one may be declared
    in a body: it has its meaning only where a type is expected.
    """

    name: str
    kind: str
    about: str
    value: float | bool | None = None
    free: bool = False


_NUMBERS = "a number of that dimension; products and quotients have the resulting dimension"
_TABLE = (
    Word("length", "number", _NUMBERS),
    Word("angle", "number", _NUMBERS),
    Word("ratio", "number", _NUMBERS),
    *(
        Word(name, "number", _NUMBERS, free=True)
        for name in ("area", "volume", "mass", "density", "time", "speed", "force", "torque")
    ),
    Word("count", "number", "a whole number"),
    Word("bool", "number", "`true` or `false`"),
    Word("choice", "type", "one of the listed words: `choice a | b`"),
    Word(
        "vec",
        "type",
        "three plain numbers; `length[2]`, `length[3]` and so on are two or three quantities of one dimension",
    ),
    Word(
        "point",
        "type",
        "a place, written as a vector of lengths; one that a template is given counts in its own frame",
        free=True,
    ),
    Word("frame", "type", "a place with two directions, `out` and `up`"),
    Word("plane", "type", "a face: a plane across an axis; in a sum it stands for its coordinate, a length"),
    Word("edge", "type", "the line in which two faces of a box meet", free=True),
    Word("line", "type", "an axis: a place and a direction"),
    Word("box", "type", "a box, with faces, `center` and `size`"),
    Word("curve", "type", "a formula or a path that a solid is made from"),
    Word("material", "type", "a material, or a style of materials"),
    Word("string", "type", "text in quotes, for messages", free=True),
    Word("x", "axis", "the direction to the front"),
    Word("y", "axis", "the direction to the left"),
    Word("z", "axis", "the direction upwards"),
    Word("true", "constant", "holds", value=True),
    Word("false", "constant", "does not hold", value=False),
    Word("pi", "constant", "3.14159..., a plain number; half a turn is `1/2turn` or `pi * 1rad`", value=math.pi),
    Word("base", "place", "in the joints of a template: what the template is attached to"),
    Word("previous", "place", "inside a repeat: the element before"),
    Word("last", "place", "as an index: the number of the last element"),
)

WORDS: dict[str, Word] = {word.name: word for word in _TABLE if word.kind in ("axis", "constant", "place")}
"""By name: what stands for a value, a direction or a place."""

NUMBERS = {name: word.value for name, word in WORDS.items() if isinstance(word.value, float)}
"""By name: the numbers that the language gives a name."""

TYPES: dict[str, Word] = {word.name: word for word in _TABLE if word.name not in WORDS}
"""By name: the types."""

DIRECTIONS = tuple(name for name, word in WORDS.items() if word.kind == "axis")


def reserved_name(name: str) -> str | None:
    """Why nothing in a file can be called so ("a type name" ...), or None where it can."""
    if name in TYPES:
        return "a type name"
    if name in WORDS:
        return "a word of the language"
    return "a built-in function" if name in FUNCTIONS else None
