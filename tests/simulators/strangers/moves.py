"""What a driver found, and what counts as reached."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from xml.etree import ElementTree

REACHED = 0.02  # of a joint's range
TURNED, SLID = 0.0175, 0.002  # by how much a follower may be off: one degree, two millimetres
SECONDS = 3.0  # for each end
STEADY = 0.2  # seconds in which it must not leave the end again


@dataclass(frozen=True)
class Move:
    """A joint on its way to one end of its range, and by how much the worst of what should follow was off, in shares of
    what it may be."""

    joint: str
    low: float
    high: float
    goal: float
    value: float
    lost: float = 0.0

    @property
    def error(self) -> float:
        """By how much it missed, as a share of its range."""
        return abs(self.value - self.goal) / (self.high - self.low)

    @property
    def reached(self) -> bool:
        return self.error <= REACHED

    @property
    def followed(self) -> bool:
        return self.lost <= 1.0

    def __str__(self) -> str:
        text = f"{self.joint} at {self.value:.4g} of {self.goal:.4g} ({100 * self.error:.1f} %)"
        return text if self.followed else f"{text}, its followers off by {self.lost:.3g} times what is allowed"


@dataclass(frozen=True)
class Follower:
    """What a URDF says of a joint that follows another: ``value = multiplier * leader + offset``; ``least``: of the slides and
    turns, by how much it may be off."""

    joint: str
    leader: str
    multiplier: float
    offset: float
    least: float

    def lost(self, leader: float, value: float) -> float:
        return abs(value - self.multiplier * leader - self.offset) / self.least


def followers(path: Path) -> dict[str, Follower]:
    """The mimics of a URDF by the name of the joint that follows: no simulator's loader gives them back."""
    found = {}
    for joint in ElementTree.parse(path).getroot().iter("joint"):
        mimic = joint.find("mimic")
        if mimic is not None:
            least = SLID if joint.get("type") == "prismatic" else TURNED
            terms = float(mimic.get("multiplier", 1.0)), float(mimic.get("offset", 0.0))
            found[joint.get("name", "")] = Follower(joint.get("name", ""), mimic.get("joint", ""), *terms, least)
    return found


def some(names: list[str], most: int | None) -> list[str]:
    """At most so many of the joints, evenly chosen in their order: all keys of a keyboard take an hour."""
    if most is None or len(names) <= most:
        return names
    return [names[(2 * k + 1) * len(names) // (2 * most)] for k in range(most)]


def start(low: float, high: float) -> float:
    """Where a limited joint is put before anything moves: at 0, or as near to it as its range allows."""
    return min(max(0.0, low), high)
