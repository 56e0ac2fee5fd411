"""``loft(a, b, c) along z at [...] smooth``: sections that go over into one another without a kink.

Along each axis across the loft the least and the greatest coordinate of the sections run from level to level as a cubic
of Hermite whose slopes never let it turn back or go beyond its ends (Fritsch and Butland, "A method for constructing
local monotone piecewise cubic interpolants"). Within these bounds the shape of one section becomes that of the next, by
a share whose slope is 0 where further sections follow: any other share would lead beyond the bounds there. So no place
reaches further than the sections do, straight lines stay straight, and circles stay circles.
"""

from __future__ import annotations

from collections.abc import Sequence

from ...graph import expr as E
from ...graph.expr import ONE, ZERO, Expr
from ...records import dataclass
from .probe import Probe
from .profiles import Span, extreme

_THREE = E.const(3.0)
_NATURAL = E.const(1.5)  # the slope of a share at the first and at the last section: its curvature is 0 there


@dataclass(frozen=True, slots=True, eq=False)
class Run:
    """A cubic over s = 0 .. 1 from ``first`` to ``last``, with its slopes there."""

    first: Expr
    last: Expr
    begin: Expr
    end: Expr

    def at(self, s: Expr) -> Expr:
        rest, change = E.sub(ONE, s), E.sub(self.last, self.first)
        bent = E.sub(E.mul(rest, E.sub(self.begin, change)), E.mul(s, E.sub(self.end, change)))
        return E.add(self.first, E.add(E.mul(s, change), E.mul(E.mul(s, rest), bent)))

    def fastest(self) -> Expr:
        """A bound of its slope: the corners of the slope's curve of Bezier, cut in its middle."""
        half = E.const(0.5)
        middle = E.sub(E.mul(_THREE, E.sub(self.last, self.first)), E.add(self.begin, self.end))
        corners = [self.begin, E.mul(half, E.add(self.begin, middle)), E.mul(half, E.add(middle, self.end)), self.end]
        return E.maximum(*(E.call("abs", c) for c in corners))


@dataclass(frozen=True, slots=True, eq=False)
class Course:
    """How the sections at the ends of a bay go over into one another.

    ``bounds`` are for each axis across how its least and its greatest coordinate run, ``alike`` whether the sections
    differ in these alone, and ``share`` how much of the last section there is.
    """

    bounds: tuple[tuple[Run, Run], tuple[Run, Run]]
    alike: tuple[bool, bool]
    share: Run

    def mixed(self, a: Span, b: Span, s: Expr) -> Span:
        """A curve between two partners, over v = 0 .. 1."""
        found = []
        for axis, (low, high) in enumerate(self.bounds):
            here, wide = low.at(s), E.sub(high.at(s), low.at(s))
            first, last = (
                E.add(here, E.mul(E.sub(span.by_fraction[axis], start), E.div(wide, E.sub(end, start))))
                for span, start, end in ((a, low.first, high.first), (b, low.last, high.last))
            )
            found.append(first if self.alike[axis] else E.add(first, E.mul(self.share.at(s), E.sub(last, first))))
        return Span(a.name, (found[0], found[1]), ZERO, ONE, a.closing)

    def fastest(self, pairs: Sequence[tuple[Span, Span]]) -> Expr:
        """A bound of how fast a place of the section moves in its plane, for a whole bay as the unit of time."""
        moves = []
        for axis, (low, high) in enumerate(self.bounds):
            move = E.maximum(low.fastest(), high.fastest())
            if not self.alike[axis]:
                wide = E.maximum(E.sub(high.first, low.first), E.sub(high.last, low.last))
                changes = [
                    E.call(
                        "abs",
                        E.sub(
                            within(b, axis, k / 16, low.last, high.last), within(a, axis, k / 16, low.first, high.first)
                        ),
                    )
                    for a, b in pairs
                    for k in range(17)
                ]
                move = E.add(move, E.mul(E.mul(wide, E.maximum(*changes)), E.mul(E.const(1.05), _NATURAL)))
            moves.append(move)
        return E.call("hypot", *moves)


def within(span: Span, axis: int, fraction: float, low: Expr, high: Expr) -> Expr:
    """Where a place lies between the bounds of its section: 0 .. 1."""
    return E.div(E.sub(span.fraction(fraction)[axis], low), E.sub(high, low))


def courses(probe: Probe, sections: list[list[Span]], levels: list[Expr]) -> list[Course]:
    """One for each two sections that follow one another."""
    count = len(sections) - 1
    runs = []
    for axis in (0, 1):
        ends = [[extreme(probe, section, axis, sign) for section in sections] for sign in (-1, 1)]
        if probe.zero(*(E.add(low, high) for low, high in zip(*ends, strict=True))):
            ends[0] = [E.neg(high) for high in ends[1]]
        runs.append([smooth(values, levels) for values in ends])
    found = []
    for k in range(count):
        first, second = ((low[k], high[k]) for low, high in runs)
        pairs = list(zip(sections[k], sections[k + 1], strict=True))
        one, two = (_same_shape(probe, pairs, axis, *bounds) for axis, bounds in enumerate((first, second)))
        share = Run(ZERO, ONE, _NATURAL if k == 0 else ZERO, _NATURAL if k == count - 1 else ZERO)
        found.append(Course((first, second), (one, two), share))
    return found


def _same_shape(probe: Probe, pairs: list[tuple[Span, Span]], axis: int, low: Run, high: Run) -> bool:
    """Whether each place of two sections lies as far between their bounds, for every test value."""
    ends = (low.first, high.first), (low.last, high.last)
    return probe.zero(
        *(
            E.sub(within(a, axis, k / 12, *ends[0]), within(b, axis, k / 12, *ends[1]))
            for a, b in pairs
            for k in range(13)
        )
    )


def smooth(values: list[Expr], levels: list[Expr]) -> list[Run]:
    """Through values at three levels or more: a cubic between each two, of one slope where they meet, and monotone."""
    heights = [E.sub(b, a) for a, b in zip(levels, levels[1:], strict=False)]
    steep = [E.div(E.sub(b, a), h) for a, b, h in zip(values, values[1:], heights, strict=False)]
    inner = [through(*steep[k : k + 2], *heights[k : k + 2]) for k in range(len(steep) - 1)]
    first = outer(steep[0], steep[1], heights[0], heights[1])
    last = outer(steep[-1], steep[-2], heights[-1], heights[-2])
    slopes = [first, *inner, last]
    return [
        Run(a, b, E.mul(slopes[k], h), E.mul(slopes[k + 1], h))
        for k, (a, b, h) in enumerate(zip(values, values[1:], heights, strict=False))
    ]


def through(before: Expr, after: Expr, low: Expr, high: Expr) -> Expr:
    """The slope where two stretches meet: a mean of theirs if they go the same way, else 0."""
    if before is ZERO or after is ZERO:
        return ZERO
    product = E.mul(before, after)
    one, other = E.add(E.add(high, high), low), E.add(E.add(low, low), high)
    sum_of_both = E.add(E.mul(one, after), E.mul(other, before))
    same = E.call("lt", ZERO, product)
    mean = E.div(E.mul(E.mul(_THREE, E.add(low, high)), product), E.where(same, sum_of_both, ONE))
    return E.where(same, mean, ZERO)


def outer(own: Expr, next_one: Expr, near: Expr, far: Expr) -> Expr:
    """The slope at the first or the last level: that of a parabola through three, between 0 and thrice the stretch's own."""
    both = E.add(near, far)
    parabola = E.div(E.sub(E.mul(E.add(near, both), own), E.mul(near, next_one)), both)
    most = E.mul(_THREE, own)
    return E.minimum(E.maximum(parabola, E.minimum(ZERO, most)), E.maximum(ZERO, most))
