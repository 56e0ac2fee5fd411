"""A stretch of a path with sections at its ends."""

from __future__ import annotations

from collections.abc import Sequence

from ...graph import expr as E
from ...graph.expr import ONE, ZERO, Expr
from ...graph.primitive import Triple, pair
from ...graph.substitution import substitute_all
from ...records import dataclass
from ..values.vectors import plus, times
from .frames import Frames
from .paths import Stretch
from .profiles import Point, Span
from .smooth import Course

# 0 at the first section of a bay, 1 at its last. No parameter of an author is called so, nor a component of one
BLEND = E.var("section.blend")
Chains = list[list[Span]]


@dataclass(frozen=True, slots=True, eq=False)
class Bay:
    """A stretch of the path with the sections at its ends, and how they stand across it."""

    rail: Stretch
    frames: Frames
    first: Chains
    last: Chains
    course: Course | None = None  # how one becomes the other; None: along straight lines

    def section(self, blend: Expr) -> Chains:
        """The section between the two."""
        mix = mixed if self.course is None else self.course.mixed
        return [
            [mix(a, b, blend) for a, b in zip(*pair, strict=True)] for pair in zip(self.first, self.last, strict=True)
        ]

    def place(self, across: Point, v: Expr | float) -> Triple:
        return plus(self.rail.at(v), plus(times(self.frames.side(v), across[0]), times(self.frames.up(v), across[1])))

    @property
    def even(self) -> bool:
        return self.first is self.last

    @property
    def ends(self) -> tuple[Chains, Chains]:
        return self.first, self.last


def mixed(a: Span, b: Span, blend: Expr) -> Span:
    """A curve between two, both over v = 0 .. 1."""
    if a is b:
        return a
    ends = zip(a.by_fraction, b.by_fraction, strict=True)
    position = pair(E.add(p, E.mul(blend, E.sub(q, p))) for p, q in ends)
    return Span(a.name, position, ZERO, ONE, a.closing)


def swapped(point: Sequence[Expr], mapping: dict[Expr, Expr]) -> Point:
    return pair(substitute_all(point, mapping))
