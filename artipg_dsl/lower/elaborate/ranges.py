"""The legal ranges of the numbers that an object is made of: one table, read by ``legal`` and by the materials.

Lengths are in metres, angles in radians, all else in SI units.
"""

from __future__ import annotations

import math

from ...graph import expr as E
from ...graph.expr import Expr, Scope
from ...graph.program import Where
from ...records import dataclass
from ...source import Span

_FAR = 1e3  # 1 km
NEAR = 1e-6  # 1 um
_MOST_ELEMENTS = 5000
_MOST_ROWS = 20_000  # the runtime makes no more (``runtime.kernels``)


@dataclass(frozen=True, slots=True)
class Legal:
    """A closed range, in ``words`` that stand behind the value ("..., but a size lies between ..."), for a value above it in those
    of ``beyond`` where they differ; ``unit``: that of the values, so that a message shows them in one that people use;
    ``remedy`` is what to try.
    """

    low: float
    high: float
    words: str
    unit: str = ""
    beyond: str = ""
    remedy: str = ""

    def holds(self, value: float) -> bool:
        """Whether a number is legal; nan is not."""
        return self.low <= value <= self.high

    def refusal(self, value: float) -> str:
        """The words for a value that is not legal, or for the lowest of several."""
        return self.beyond if self.beyond and value > self.high else self.words


@dataclass(frozen=True, slots=True, eq=False)
class OnSurface:
    """A place on a surface, called at ``span``: ``why`` it may have no value, and the ``remedy``. It is given by ``name``, in a ``unit``,
    which is one of ``ends`` at the ends of the surface, and between them if it is a coordinate."""

    span: Span
    why: str
    remedy: str
    name: str = ""
    value: Expr = E.ZERO
    ends: tuple[Expr, ...] = (E.ZERO, E.ZERO)
    unit: str = ""

    @property
    def told(self) -> str:
        return f"`{self.span.words}` has no value: {self.why}"


@dataclass(frozen=True, slots=True, eq=False)
class Quantity:
    """A number of ``scope``, named for messages, with the range that is legal for it where ``guard`` holds; ``place``: that a place
    lies on a surface; ``span``: the number itself in the statement at ``where``."""

    name: str
    scope: Scope
    value: Expr
    legal: Legal
    where: Where | None
    guard: Expr = E.TRUE
    place: OnSurface | None = None
    span: Span | None = None

    def is_of(self, other: Quantity) -> bool:
        """Whether the same is asked of the same value."""
        return (self.scope, self.value, self.legal) == (other.scope, other.value, other.legal)


NUMBER = Legal(-1e12, 1e12, "every value of an object must be a finite number", beyond="values are at most 1e12")
PLACE = Legal(-_FAR, _FAR, "places must lie within 1 km of the origin", "m")
SIZE = Legal(0.0, _FAR, "sizes must not be negative and are at most 1 km", "m")
TURN = Legal(
    -1.0 - NEAR,
    1.0 + NEAR,
    "a direction must not be [0, 0, 0]",
    remedy="name an axis, or make one component differ from 0",
)
AXIS = Legal(
    1.0 - NEAR, 1.0 + NEAR, "an axis must not be [0, 0, 0]", remedy="name an axis, or make one component differ from 0"
)
DIRECTION = Legal(
    NEAR, _FAR, "a direction must not be [0, 0, 0]", remedy="name an axis, or make one component differ from 0"
)
PARALLEL = Legal(
    -NEAR,
    NEAR,
    "axes that coincide must be parallel",
    remedy="turn one of them as the other, or close points, which have no direction",
)
APART = Legal(
    NEAR,
    _FAR,
    "a gripper must close across its approach",
    remedy="let `close` and `approach` be perpendicular, as in `approach -x  close y`",
)
MOTION = Legal(-1e4, 1e4, "the range of a joint must be finite", beyond="a joint goes no further than 10,000 m or rad")
PITCH = Legal(NEAR, _FAR, "the pitch of a screw must not be 0 and is at most 1 km", "m")
POSITIONS = Legal(
    2.0,
    1e5,
    "a joint has at least two positions",
    beyond="a joint has at most 100,000 positions",
    remedy="leave `positions` out for a joint that stays anywhere in its range",
)
HELD = Legal(0.0, 1e9, "it must be finite and not negative", beyond="it is at most 1e9", remedy="write 0 or more")
DRIVEN = Legal(
    1e-9,
    1e9,
    "it must be finite and above 0",
    beyond="it is at most 1e9",
    remedy="write a value above 0, or leave the clause out",
)
RESERVE = Legal(
    -1e-9,
    1e9,
    "a joint must take its spring to the end of its range",
    remedy="give the joint more `effort`, or the spring less `stiffness`",
)
OPENING = Legal(NEAR, _FAR, "an opening must be above 0", "m", "an opening is at most 1 km")
SHARE = Legal(
    0.0, 1.0, "it must lie in 0 .. 1", remedy="write a number from 0 to 1; a percentage needs its sign, as in `40%`"
)
ROOM = Legal(-1e-9, _FAR, "it must not be negative", "m")
DISTANCE = Legal(0.0, _FAR, "a distance must not be negative and is at most 1 km", "m")
EVERY = Legal(NEAR, _FAR, "the spacing of elements must be at least 0.001 mm", "m", "it is at most 1 km")
OPTION = Legal(
    1e-12,
    1e12,
    "at least one alternative needs a weight above 0",
    remedy="give one alternative a weight above 0, or put what is not drawn under `when`",
)
ELEMENTS = Legal(
    0.0,
    _MOST_ELEMENTS,
    f"a repeat must have 0 to {_MOST_ELEMENTS:,} elements",
    remedy="`0 ..< n` makes n elements; `fill` as many as the length divided by `every`",
)
ELEMENT = Legal(0.0, _MOST_ELEMENTS, "the repeat has no such element")
ROWS = Legal(
    0.0,
    _MOST_ROWS,
    f"an object must have 0 to {_MOST_ROWS:,} elements of one kind",
    remedy="narrow the range of a count, or widen `every`",
)
WEIGHTS = Legal(
    1e-12,
    math.inf,
    "at least one element needs a weight above 0",
    remedy="give one a weight above 0, or leave `weight` out for equal shares",
)
WEIGHT = Legal(
    0.0,
    1e12,
    "a weight must be finite and not negative",
    beyond="a weight is at most 1e12",
    remedy="write 0 or more; `when` leaves an alternative out",
)
SPREAD = Legal(
    1e-12,
    1e12,
    "a deviation must be finite and above 0",
    beyond="a deviation is at most 1e12",
    remedy="write a value above 0, or leave the range out for a fixed value",
)
MEDIAN = Legal(
    1e-12,
    1e12,
    "a median must be finite and above 0",
    beyond="a median is at most 1e12",
    remedy="write a value above 0, or `normal`, whose values may be negative",
)
STEP = Legal(
    0.0,
    1e12,
    "a step must be finite and not negative",
    beyond="a step is at most 1e12",
    remedy="write 0 or more, as in `vary 5%`: it goes both ways",
)

ON = Legal(-NEAR, math.inf, "it must lie on the surface")
THERE = Legal(1.0, 1.0, "the surface must be there")

MATERIAL = {
    "density": Legal(1e-3, 1e6, "a density must lie between 1 g/m3 and 1000 t/m3"),
    "friction_static": Legal(0.0, 1e3, "a coefficient of friction must not be negative", beyond="it is at most 1000"),
    "friction_dynamic": Legal(0.0, 1e3, "a coefficient of friction must not be negative", beyond="it is at most 1000"),
    "restitution": SHARE,
    "metalness": SHARE,
    "roughness": SHARE,
    "transparency": SHARE,
    "colour": Legal(0.0, 1.0, "red, green and blue must lie in 0 .. 1"),
}


def plain(value: float) -> str:
    """A value as messages show it."""
    return "not a number" if math.isnan(value) else f"{value:.6g}"
