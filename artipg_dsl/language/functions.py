"""The functions of the language: the forms in which each is called, one record per form."""

from __future__ import annotations

import re
from collections.abc import Sequence

from ..records import dataclass
from .members import FACES


@dataclass(frozen=True, slots=True)
class Parameter:
    """``type`` is the name of a type of the language, or ``number`` (any dimension), ``part``, ``elements``, ``joint``."""

    name: str
    type: str
    optional: bool = False

    def __str__(self) -> str:
        return f"{self.name}{'?' * self.optional}: {self.type}"


@dataclass(frozen=True, slots=True)
class Form:
    """One form of a function: what it takes and ``gives`` (a type; ``number``: the dimension of what it takes).

    ``more``: the last parameter may be given again and again. ``rule`` names the rule of types (``semantics.functions``), ``meaning`` what
    lowering makes of a call (``lower.expressions.builtins``; curves are made where solids are).
    """

    name: str
    parameters: tuple[Parameter, ...]
    gives: str
    more: bool
    kind: str  # number, reduction, place, curve, force
    rule: str
    meaning: str
    about: str

    @property
    def required(self) -> tuple[Parameter, ...]:
        return tuple(p for p in self.parameters if not p.optional)

    def bind(self, names: Sequence[str | None]) -> tuple[Parameter | None, ...]:
        """The parameter that each argument is for, by its name or in order; None for what the form does not take."""
        by_name = {p.name: p for p in self.parameters}
        last = self.parameters[-1] if self.more else None
        order = (self.parameters[k] if k < len(self.parameters) else last for k in range(len(names)))
        return tuple(nth if name is None else by_name.get(name) for name, nth in zip(names, order, strict=True))

    def takes(self, names: Sequence[str | None]) -> bool:
        """Whether arguments of these names (None: without one) make a call of this form."""
        bound = self.bind(names)
        once = bound[: len(self.parameters)]
        return None not in bound and len(set(once)) == len(once) and all(p in bound for p in self.required)

    @property
    def call(self) -> str:
        """How it is called: ``line(at, along)``."""
        words = [f"{p.name} = ..." if p.optional else p.name for p in self.parameters] + ["..."] * self.more
        return f"{self.name}({', '.join(words)})"

    def __str__(self) -> str:
        """``line(at: point, along: direction) -> line``."""
        return f"{self.name}({', '.join([*map(str, self.parameters), *['...'] * self.more])}) -> {self.gives}"


# how it is called, with the types of what it takes and gives | kind, rule, meaning | what it is
_TABLE = """
sin(a: angle) -> ratio                             | number one graph           | the sine
cos(a: angle) -> ratio                             | number one graph           | the cosine
tan(a: angle) -> ratio                             | number one graph           | the tangent
asin(r: ratio) -> angle                            | number one graph           | the angle with this sine, within -90deg .. 90deg
acos(r: ratio) -> angle                            | number one graph           | the angle with this cosine, within 0deg .. 180deg
atan(r: ratio) -> angle                            | number one graph           | the angle with this tangent, between -90deg and 90deg
atan2(a: number, b: number) -> angle               | number alike graph         | the angle from the first axis to the vector (b, a)
sqrt(a: number) -> root                            | number one graph           | the square root, with half the dimension
hypot(a: number, ...) -> number                    | number alike hypot         | the square root of the sum of the squares
abs(a: number) -> number                           | number one graph           | the absolute value
sign(a: number) -> count                           | number one graph           | the sign: -1, 0 or 1
min(path: number) -> number                        | reduction elements reduce  | the least value over the elements of a repeat
max(path: number) -> number                        | reduction elements reduce  | the greatest value over the elements of a repeat
min(a: number, b: number, ...) -> number           | number alike least         | the least of the arguments
max(a: number, b: number, ...) -> number           | number alike greatest      | the greatest of the arguments
sum(path: number) -> number                        | reduction elements reduce  | the sum over the elements of a repeat
number(path: elements) -> count                    | reduction counted count    | the number of elements of a repeat
floor(r: ratio) -> count                           | number one graph           | the greatest whole number not above r
ceil(r: ratio) -> count                            | number one graph           | the least whole number not below r
round(r: ratio) -> count                           | number one round           | the nearest whole number; halves are rounded up
exp(r: ratio) -> ratio                             | number one graph           | e to the power of r
log(r: ratio) -> ratio                             | number one graph           | the natural logarithm of r, which is above 0
mod(a: number, b: number) -> number                | number alike graph         | the remainder of a / b, with the sign of b
lowest(part: part, direction: direction) -> length | place typed lowest         | how far a part's box extends in a direction, from the origin
frame(at: point, out: direction, up: direction) -> frame | place typed frame          | a frame: a place with two directions
line(at: point, along: direction) -> line          | place typed line           | an axis through a point along a direction
line(at: point, to: point) -> line                 | place typed line           | an axis from one point to another
box(FACES) -> box                                  | place typed box            | a box; omitted faces are those of the template
circle(radius: length) -> curve                    | curve typed circle         | a circle about the origin
rectangle(width: length, height: length) -> curve  | curve typed rectangle      | a rectangle about the origin
polygon(a: length[2], b: length[2], c: length[2], ...) -> curve | curve typed polygon        | a polygon, given by its corners
offset(curve: curve, distance: length) -> curve    | curve moved offset         | a curve, or its point `skin(v)`, moved to the curve's right
from(at: point, along: direction) -> curve         | curve typed path           | the beginning of a path and its direction there
line(length: length) -> curve                      | curve typed path           | a straight piece of a path
arc(radius: length, angle: angle, towards: direction) -> curve | curve typed path           | a piece of a path that bends towards a side
pushes(joint: joint) -> bool                       | force force drive          | whether a push moves a joint away from rest
pulls(joint: joint) -> bool                        | force force drive          | whether a pull moves a joint away from rest
pushes_back(joint: joint) -> bool                  | force force drive          | whether a push moves a joint back to rest
pulls_back(joint: joint) -> bool                   | force force drive          | whether a pull moves a joint back to rest
at(u: number, v?: number, x?: length, y?: length, z?: length) -> frame | method typed at | a frame on a surface: `wall.at(0.25turn, z = h)`
"""
_FACES = ", ".join(f"{face}?: length" for face in FACES)


def _read(line: str) -> Form:
    signature, how, about = (cell.strip() for cell in line.split("|"))
    kind, rule, meaning = how.split()
    name, inside, gives = re.findall(r"(\w+)\((.*)\) -> (\w+)", signature.replace("FACES", _FACES))[0]
    parameters = (Parameter(n, t, bool(mark)) for n, mark, t in re.findall(r"(\w+)(\??): ([\w\[\]]+)", inside))
    return Form(name, tuple(parameters), gives, inside.endswith("..."), kind, rule, meaning, about)


FORMS = tuple(_read(line) for line in _TABLE.strip().splitlines())

FUNCTIONS = {f.name: tuple(g for g in FORMS if g.name == f.name) for f in FORMS if f.kind != "method"}
"""By name: the forms of a function, of which the first is meant that takes the arguments of a call."""

METHODS = {f.name: f for f in FORMS if f.kind == "method"}
"""Functions that stand after a dot, behind a surface."""
