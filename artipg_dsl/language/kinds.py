"""Words that say of which kind a statement is: kinds of joints, forms of a repeat, operators on curves, distributions."""

from __future__ import annotations

import sys
from collections.abc import Container

from ..records import dataclass


@dataclass(frozen=True, slots=True)
class Kind:
    """One kind of a statement: the clauses that it ``needs`` and those that it ``takes`` as well.

    An operator and a distribution have as many ``arguments``, of which the ``positive`` ones are above 0. A joint ``moves``: it turns,
    slides or tilts; ``clears``: it may go as far as nothing is in the way. ``example`` is what messages suggest, ``about`` its rows
    in the reference.
    """

    name: str
    about: str = ""
    example: str = ""
    needs: tuple[str, ...] = ()
    takes: tuple[str, ...] = ()
    arguments: Container[int] = ()
    positive: tuple[int, ...] = ()
    moves: str = ""
    clears: bool = False

    @property
    def clauses(self) -> tuple[str, ...]:
        return (*self.needs, *self.takes)

    @property
    def call(self) -> str:
        """How it is written with all that it takes: what the last row of the reference shows."""
        return self.about.splitlines()[-1].split("`")[1]

    @property
    def axis(self) -> str:
        """The clause that gives the axis of a joint, ``about`` or ``along``; none for a joint about a point."""
        return next((word for word in ("about", "along") if word in self.takes), "")

    @property
    def turns(self) -> bool:
        """Whether a joint turns about an axis."""
        return self.moves == "turns"

    @property
    def slides(self) -> bool:
        """Whether a joint slides along an axis: its value is a length, else an angle."""
        return self.moves == "slides"

    @property
    def tilts(self) -> bool:
        """Whether a joint turns about a point."""
        return self.moves == "tilts"

    @property
    def advances(self) -> bool:
        """Whether a joint slides as it turns."""
        return "pitch" in self.clauses

    @property
    def endless(self) -> bool:
        """Whether a joint turns without limits."""
        return self.turns and "range" not in self.clauses


def _by_name(*kinds: Kind) -> dict[str, Kind]:
    return {kind.name: kind for kind in kinds}


_SOME, _SEVERAL = range(1, sys.maxsize), range(2, sys.maxsize)
_PHYSICS = ("damping", "friction", "effort", "velocity", "rest", "mimic", "when")

JOINTS = _by_name(
    Kind(
        "revolute",
        "`revolute` | `about` an edge, line or port | `range low .. high`, angles",
        "add `range 0deg .. 90deg`, or make it continuous",
        needs=("range",),
        takes=("about", "positions", "stiffness", *_PHYSICS),
        moves="turns",
        clears=True,
    ),
    Kind(
        "prismatic",
        "`prismatic` | `along` a direction | `range low .. high`, lengths",
        "add `range 0cm .. 30cm`",
        needs=("range",),
        takes=("along", "positions", "stiffness", *_PHYSICS),
        moves="slides",
        clears=True,
    ),
    Kind("continuous", "`continuous` | `about` | none", takes=("about", "positions", *_PHYSICS), moves="turns"),
    Kind(
        "screw",
        "`screw` | `about` | `range`, angles; `pitch` length per turn",
        "for example `range 0turn .. 3turn pitch 2mm`",
        needs=("range", "pitch"),
        takes=("about", "stiffness", *_PHYSICS),
        moves="turns",
    ),
    Kind(
        "ball",
        "`ball` | at the port or point | `range 0deg .. limit`: how far it tilts to any side; or none",
        takes=("range", *_PHYSICS),
        moves="tilts",
    ),
    Kind("fixed", "`fixed` | - | -"),
)
"""By name: how a joint moves."""

REPEATS = _by_name(
    Kind(""),
    Kind("split", needs=("along",), takes=("weight", "gap", "each")),
    Kind("spread", needs=("along",), takes=("margin",)),
    Kind("pitch", needs=("along",), takes=("margin",)),
    Kind("fill", needs=("along", "every"), takes=("margin",)),
    Kind("ring", needs=("about",)),
    Kind("mirror", needs=("across",)),
)
"""By name, which is a clause itself: how the elements of a repeat lie."""

OPERATORS = _by_name(
    Kind(
        "lathe",
        "`lathe(profile)` | `about z` | a solid of revolution; the profile is [radius, height]",
        "lathe(skin) about z",
        takes=("about",),
        arguments=(1, 2),
    ),
    Kind(
        "extrude",
        "`extrude(outline)` | `along z from a to b` | a prism with a plane outline\n"
        "`extrude(outline, hole, ...)` | `along z from a to b` | the same, with holes",
        "extrude(edge) along z from 0 to thick",
        needs=("from", "to"),
        takes=("along",),
        arguments=_SOME,
    ),
    Kind(
        "sweep",
        "`sweep(section)` | `along path up y` | a bar along any path; `start` and `end` are ports that point away from it, "
        "with the `up` of the section",
        "sweep(circle(r)) along path up y",
        needs=("along",),
        takes=("up",),
        arguments=(1, 2),
    ),
    Kind(
        "loft",
        "`loft(first, ..., last)` | `along z from a to b` | a solid through sections at equal steps, or at any levels: "
        "`along z at [a, b, c, d]`; `smooth` avoids kinks\n"
        "`loft(first, last)` | `along path up y` | a bar along any path, with a changing section; `start` and `end` as in `sweep`",
        "loft(base, top) along z from 0 to h",
        takes=("along", "up", "from", "to", "at", "smooth"),
        arguments=_SEVERAL,
    ),
)
"""By name: what makes a solid of curves."""

DISTRIBUTIONS = _by_name(
    Kind(
        "uniform",
        "none, or `uniform` | uniform over the domain\n"
        "`uniform(a, b)` | uniform over the part of the domain between a and b",
        "no arguments or two ends",
        arguments=(0, 2),
    ),
    Kind(
        "normal",
        "`normal(mean, deviation)` | normal, truncated to the domain",
        "a mean and a deviation",
        arguments=(2,),
        positive=(1,),
    ),
    Kind(
        "lognormal",
        "`lognormal(median, relative deviation)` | lognormal, truncated to the domain",
        "a median and a relative deviation",
        arguments=(2,),
        positive=(0, 1),
    ),
    Kind(
        "values",
        "`values(a, b, ...)` | one of the values or of the words of a choice, all equally likely; repeat one to make it more likely",
        "at least one value",
        arguments=_SOME,
    ),
)
"""By name: how a parameter is drawn."""

WEIGHTED = "weighted"
"""A distribution that no program states: some values, then as many weights. Priors make it."""
