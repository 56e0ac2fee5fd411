"""Types of expressions. A frozen value each; ``UNKNOWN`` stands after an error and silences what follows."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import field
from fractions import Fraction
from typing import TYPE_CHECKING

from ..records import dataclass
from ..syntax import ast
from ..units import Dimension
from .guards import TRUE, Atom, Condition

if TYPE_CHECKING:
    from .scope import Entry, Variant

NONE = Dimension(0, 0, 0, 0)
LENGTH_DIM = Dimension(1, 0, 0, 0)
_ANGLE_DIM = Dimension(0, 1, 0, 0)

DIMENSIONS: dict[str, Dimension] = {
    "ratio": NONE,
    "count": NONE,
    "length": LENGTH_DIM,
    "angle": _ANGLE_DIM,
    "area": Dimension(2, 0, 0, 0),
    "volume": Dimension(3, 0, 0, 0),
    "mass": Dimension(0, 0, 1, 0),
    "density": Dimension(-3, 0, 1, 0),
    "time": Dimension(0, 0, 0, 1),
    "speed": Dimension(1, 0, 0, -1),
    "force": Dimension(1, 0, 1, -2),
    "torque": Dimension(2, 0, 1, -2),
}
"""Type names of numbers to dimensions."""

_NAMES = {dimension: name for name, dimension in reversed(DIMENSIONS.items())} | {NONE: "ratio"}


def dimension_name(dimension: Dimension) -> str:
    """``length``, ``area``, or a product such as ``length^2 angle^-1``."""
    if dimension in _NAMES:
        return _NAMES[dimension]
    powers = zip(("length", "angle", "mass", "time"), dimension, strict=True)
    return " ".join(name if power == 1 else f"{name}^{power}" for name, power in powers if power)


def with_article(name: str) -> str:
    """``a length``, ``an angle``; products of dimensions stay as they are."""
    return name if " " in name or "^" in name else f"an {name}" if name[0] in "aeiou" else f"a {name}"


def times(a: Dimension, b: Dimension, sign: int = 1) -> Dimension:
    """The dimension of a product (``sign`` 1) or quotient (-1)."""
    return Dimension(*(x + sign * y for x, y in zip(a, b, strict=True)))


def power(a: Dimension, exponent: Fraction) -> Dimension:
    """The dimension of a power."""
    scaled = (Fraction(x) * exponent for x in a)
    # the root of a length has a broken exponent: it may stand in a formula on its way to a whole one
    return Dimension(*(int(x) if x.denominator == 1 else x for x in scaled))


@dataclass(frozen=True, slots=True)
class Type:
    """Base of all types; ``str`` gives the words that messages use."""


@dataclass(frozen=True, slots=True)
class _UnknownType(Type):
    def __str__(self) -> str:
        return "unknown"


@dataclass(frozen=True, slots=True)
class ScalarType(Type):
    """A number. ``count``: a whole number; ``zero``: the literal 0, which fits any dimension."""

    dimension: Dimension
    count: bool = False
    zero: bool = False

    def __str__(self) -> str:
        return "a count" if self.count else with_article(dimension_name(self.dimension))


@dataclass(frozen=True, slots=True)
class VecType(Type):
    """``size`` numbers of one dimension; None where every component is 0 or open."""

    size: int
    dimension: Dimension | None

    def __str__(self) -> str:
        return f"{dimension_name(self.dimension) if self.dimension is not None else 'vec'}[{self.size}]"


@dataclass(frozen=True, slots=True)
class NamedType(Type):
    """A type without parameters: bool, string, point, frame, plane, edge, line, box, curve, material, direction ..."""

    name: str

    def __str__(self) -> str:
        return _WORDS.get(self.name, f"a {self.name}")


_WORDS = {"bool": "true or false", "direction": "a direction (x, -y, ...)", "edge": "an edge"}


@dataclass(frozen=True, slots=True)
class ChoiceType(Type):
    values: tuple[str, ...]

    def __str__(self) -> str:
        return "one of " + ", ".join(self.values)


@dataclass(frozen=True, slots=True)
class ArrayType(Type):
    """Indexed ports: ``port socket[2] : frame``. ``bound``: which index each binding is of (None: any), and what it takes."""

    item: Type
    bound: tuple[tuple[int | None, Condition], ...] = field(default=(), compare=False)

    def __str__(self) -> str:
        return f"several values, each {self.item}"


@dataclass(frozen=True, slots=True)
class FunctionType(Type):
    """A ``let f(x)`` or a surface or curve of a primitive, which only a call may use."""

    entry: Entry = field(compare=False)

    def __str__(self) -> str:
        return "a function"


@dataclass(frozen=True, slots=True)
class PartType(Type):
    """An instance. ``domain`` is all that it can be (None: absent), ``variants`` what of that is left here.

    ``key`` names the part for guards; ``many`` says that it stands for one per element of a repeat.
    """

    variants: tuple[Variant, ...]
    key: str
    domain: tuple[Variant | None, ...]
    many: bool = False
    given: Condition = field(default=TRUE, compare=False)  # what its arguments say of its choices and counts

    @classmethod
    def of(cls, domain: Iterable[Variant | None], key: str, many: bool = False, given: Condition = TRUE) -> PartType:
        """A part of which nothing is excluded yet."""
        domain = tuple(dict.fromkeys(domain))
        return cls(tuple(v for v in domain if v is not None), key, domain, many, given)

    @property
    def there(self) -> Condition:
        """That it is present."""
        if None not in self.domain:
            return TRUE
        return Atom(self.key, frozenset(v for v in self.domain if v is not None), self.domain)

    def __str__(self) -> str:
        names = sorted({v.name for v in self.variants})
        return f"a part ({' or '.join(names)})" if names else "a part"


@dataclass(frozen=True, slots=True)
class StyleType(Type):
    """A style used as a value: its role, and what it chooses from (None: nothing)."""

    domain: tuple[Variant | None, ...]
    role: str

    def __str__(self) -> str:
        return f"a style of {self.role}"


@dataclass(frozen=True, slots=True)
class ElementType(Type):
    """An element of a repeat. ``many``: all of them.

    ``index``: which one, ``shift``: or how many before one's own. ``outer``: the element that holds its repeat,
    ``home``: or the template that does and the path of its instance.
    """

    entry: Entry = field(compare=False)
    key: str
    many: bool = False
    index: ast.Expr | None = field(default=None, compare=False)
    shift: int = field(default=0, compare=False)
    outer: ElementType | None = field(default=None, compare=False)
    home: tuple[str, str] | None = field(default=None, compare=False)

    def __str__(self) -> str:
        return "an element of a repeat"

    @property
    def ranked(self) -> str:
        """How to compute with its rank."""
        return f"to compute with its rank, name that: `repeat {self.entry.name}[k] in ...`, and write `k`"


@dataclass(frozen=True, slots=True)
class SlotType(Type):
    """What a slot binds: a box to outsiders; ``many`` as for parts."""

    name: str
    many: bool = False

    def __str__(self) -> str:
        return f"the slot {self.name}"


Boxed = PartType | SlotType | ElementType
"""What has a box of its own."""


@dataclass(frozen=True, slots=True)
class JointType(Type):
    kind: str | None  # None of a joint that only a role names

    def __str__(self) -> str:
        return "a joint"


SEVERAL = JointType("several")
"""A joint that alternatives bring in different kinds."""

UNKNOWN = _UnknownType()
RATIO = ScalarType(NONE)
COUNT = ScalarType(NONE, count=True)
LENGTH = ScalarType(LENGTH_DIM)
ANGLE = ScalarType(_ANGLE_DIM)
ZERO = ScalarType(NONE, count=True, zero=True)
SIZE = VecType(3, LENGTH_DIM)
BOOL = NamedType("bool")
STRING = NamedType("string")
POINT = NamedType("point")
FRAME = NamedType("frame")
PLANE = NamedType("plane")
EDGE = NamedType("edge")
LINE = NamedType("line")
BOX = NamedType("box")
CURVE = NamedType("curve")
MATERIAL = NamedType("material")
DIRECTION = NamedType("direction")
SURFACE = NamedType("surface")
BASE = NamedType("base")

PLACES: dict[str, Type] = {
    kind.name: kind for kind in (BOOL, STRING, POINT, FRAME, PLANE, EDGE, LINE, BOX, CURVE, MATERIAL)
}
"""Type names that stand for a ``NamedType``."""


def named(name: str) -> Type:
    """The type that the tables of the language call so: ``length``, ``length[3]``, ``direction``."""
    base, _, size = name.rstrip("]").partition("[")
    if base == "count" or base == "direction":
        return COUNT if base == "count" else DIRECTION
    if base in PLACES:
        return PLACES[base]
    return VecType(int(size), DIMENSIONS[base]) if size else ScalarType(DIMENSIONS[base])


def is_number(kind: Type) -> bool:
    """Whether a value can be computed with as one number: a scalar, or a plane read as its coordinate."""
    return isinstance(kind, ScalarType) or kind == PLANE


def dimension_of(kind: Type) -> Dimension | None:
    """The dimension of a number; None for 0 and for what is not a number."""
    if isinstance(kind, ScalarType):
        return None if kind.zero else kind.dimension
    return LENGTH_DIM if kind == PLANE else kind.dimension if isinstance(kind, VecType) else None


def sort_of(kind: Type | None) -> object:
    """What types have in common whose values can be those of one member, each of an alternative."""
    match kind:
        case VecType(size=size):
            return VecType, size
        case ElementType(entry=entry):
            return ElementType, id(entry)  # each repeat has elements of its own
        case ScalarType() | PartType():
            return type(kind)
    return kind


def fits(given: Type, wanted: Type) -> bool:
    """Whether a value of ``given`` may stand where ``wanted`` is expected."""
    if given is wanted or given is UNKNOWN or wanted is UNKNOWN or given == wanted:
        return True
    if isinstance(wanted, ScalarType):
        if given == PLANE:
            return wanted.dimension == LENGTH_DIM
        if not isinstance(given, ScalarType):
            return False
        if wanted.count and not given.count:
            return False
        return given.zero or given.dimension == wanted.dimension
    if isinstance(wanted, VecType):
        if given == POINT:
            return wanted == SIZE
        return (
            isinstance(given, VecType)
            and given.size == wanted.size
            and (None in (given.dimension, wanted.dimension) or given.dimension == wanted.dimension)
        )
    if wanted == POINT:
        return given in (SIZE, VecType(3, None))
    if wanted == DIRECTION:
        return isinstance(given, VecType) and given.size == 3
    if wanted == FRAME:
        return given == PLANE
    if wanted == LINE:
        return given == EDGE
    if wanted == BOX:
        return isinstance(given, ElementType) and not given.many
    if isinstance(wanted, ChoiceType):
        return isinstance(given, ChoiceType) and set(given.values) <= set(wanted.values)
    return False
