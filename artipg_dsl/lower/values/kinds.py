"""What an expression of the text means while it is lowered: scalars are ``graph`` expressions, the rest is built of them.

Every geometric value is expressed in the frame of the environment that evaluates it. ``on`` lists the parts whose
links a value lies on (see ``links``).
"""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Sequence
from typing import TYPE_CHECKING, TypeAlias, TypeVar

from ...graph import expr as E
from ...graph.expr import Expr, Scope
from ...graph.linear import tidy
from ...graph.primitive import Triple, triple
from ...graph.program import Pose
from ...records import dataclass
from .vectors import HERE, Matrix, minus, plus, times

if TYPE_CHECKING:
    from ...semantics.symbols import Symbol
    from ..elaborate.part import Component
    from ..expressions.env import Element, Function, Hinge
    from ..expressions.members import At
    from .handed import Handed


K = TypeVar("K")
S = TypeVar("S")
Carrier: TypeAlias = "Component | InElement"  # what a value lies on


class Alternatives(ABC):
    """One of several templates, drawn once (a style): it can be asked which with ``is``."""

    __slots__ = ()

    @abstractmethod
    def matches(self, symbol: Symbol) -> Expr:
        """Whether it is that template, or one of that role."""


class Placed(ABC):
    """What stands for values of another table: they are fetched one by one, each carried from frame to frame as this is."""

    __slots__ = ()

    @abstractmethod
    def carried(self, pose: Pose) -> Value:
        """The same as it is named in the outer frame that ``pose`` places it in."""


@dataclass(frozen=True, slots=True)
class Vec:
    """Two or three scalars: a size or displacement, or (``point``) a place, which moves with its frame."""

    items: tuple[Expr, ...]
    on: tuple[Carrier, ...] = ()
    point: bool = False


@dataclass(frozen=True, slots=True)
class Frame:
    """Origin and axes; ``rotation`` has the columns out, up x out, up. A face of a box is a frame with ``face``."""

    origin: Triple
    rotation: Matrix
    on: tuple[Carrier, ...] = ()
    face: bool = False

    @property
    def out(self) -> Triple:
        return triple(row[0] for row in self.rotation)

    @property
    def up(self) -> Triple:
        return triple(row[2] for row in self.rotation)


@dataclass(frozen=True, slots=True)
class Plane:
    """A plane across ``axis`` (None where its normal is no axis by construction) at ``coordinate``; ``side`` is 1 where the face
    that it comes from faces along the axis, -1 where against it."""

    axis: int | None
    coordinate: Expr
    on: tuple[Carrier, ...] = ()
    side: Expr = E.ONE


@dataclass(frozen=True, slots=True)
class Line:
    """A directed line through ``point``; ``to`` is its other end where it has one."""

    point: Triple
    direction: Triple
    to: Triple | None = None
    on: tuple[Carrier, ...] = ()


@dataclass(frozen=True, slots=True)
class Box:
    """A box: ``low`` and ``high`` in the frame that ``pose`` places. ``exists`` where it may be absent (a gap)."""

    low: Triple
    high: Triple
    pose: Pose = HERE
    on: tuple[Carrier, ...] = ()
    exists: Expr = E.TRUE

    @property
    def size(self) -> Triple:
        return triple(tidy(c) for c in minus(self.high, self.low))

    @property
    def center(self) -> Triple:
        return triple(tidy(c) for c in times(plus(self.low, self.high), E.const(0.5)))

    def between(self, axis: int, start: Expr, end: Expr, exists: Expr = E.TRUE) -> Box:
        """A box of its frame that goes from ``start`` to ``end`` along an axis, and as far as this one along the others."""
        low = triple(start if k == axis else c for k, c in enumerate(self.low))
        high = triple(end if k == axis else c for k, c in enumerate(self.high))
        return Box(low, high, self.pose, self.on, exists)


@dataclass(frozen=True, slots=True)
class Face(Frame):
    """A face of ``box``: the plane and the frame (its centre, out = normal, up = z, or x on top and bottom)."""

    box: Box | None = None
    axis: int = 0
    sign: int = 1


@dataclass(frozen=True, slots=True)
class Edge(Line):
    """The edge of two faces of a box, directed along normal(first) x normal(second)."""

    first: Face | None = None
    second: Face | None = None


@dataclass(frozen=True, slots=True)
class Choice:
    """One of named options, as a number."""

    code: Expr
    options: tuple[str, ...]

    def chosen(self, name: str) -> Expr:
        """The predicate that the option ``name`` is the one (an option may stand there twice)."""
        codes = (k for k, option in enumerate(self.options) if option == name)
        return E.any_of(E.call("eq", self.code, E.const(float(k))) for k in codes)


@dataclass(slots=True, eq=False)
class Look:
    """``style look : material = oak | white``: each material with the predicate under which it is the one."""

    options: tuple[tuple[str, Expr], ...]
    choice: Choice

    def chosen(self, name: str) -> Expr:
        return self.choice.chosen(name)


@dataclass(frozen=True, slots=True)
class Branch:
    """Parts that exist together in ``scope`` (None: wherever the reference is made), each with its pose."""

    scope: Scope | None
    members: tuple[tuple[Component, Pose], ...]


@dataclass(frozen=True, slots=True)
class Ref:
    """A reference to parts: a part has one branch with one member, a slot of a role one branch per alternative."""

    name: str
    branches: tuple[Branch, ...]
    own: bool = False  # seen from the part's own frame, while its pose is being sought
    frame: Pose = HERE  # carries what all branches have in common into the frame of the environment that names it


def reference(part: Component) -> Ref:
    """A part by its name, where it is declared."""
    return Ref(part.name, (Branch(None, ((part, HERE),)),))


@dataclass(frozen=True, slots=True)
class Surface:
    """A surface of a primitive part, or one of each alternative: (table, part, pose of the part's frame, name)."""

    branches: tuple[tuple[Scope | None, Component, Pose, str], ...]


@dataclass(slots=True, eq=False)
class Ports:
    """``port socket[2]``: values by index."""

    name: str
    values: dict[int, Value]

    def settled(self) -> dict[int, Value]:
        return self.values


@dataclass(frozen=True, slots=True)
class InElement:
    """A part of an element of ``repeat`` that is named from the rows of ``scope``: of the element of ``rank``, or (None) of the
    one before."""

    part: Carrier
    scope: Scope
    repeat: Scope
    rank: Expr | None


def part_of(carrier: Carrier) -> Component:
    """The part that a value lies on, whichever element it is of."""
    while isinstance(carrier, InElement):
        carrier = carrier.part
    return carrier


Lying = Vec | Frame | Plane | Line | Box  # what lies on parts
Value: TypeAlias = (
    "Expr | Vec | Frame | Plane | Line | Box | Choice | Ref | Surface | Ports | Alternatives | Look"
    " | Function | Element | At | Hinge | Handed | str"
)


def carriers_of(value: Value) -> tuple[Carrier, ...]:
    """What a value lies on."""
    return value.on if isinstance(value, Lying) else ()


def alike(kind: type[K], values: Sequence[tuple[S, object]]) -> list[tuple[S, K]] | None:
    """The values of alternatives where all are of one kind; None where one is of another."""
    found = [(s, v) for s, v in values if isinstance(v, kind)]
    return found if len(found) == len(values) else None
