"""One model of an object that every robot format is written from: links with mass, what is seen, what collides, joints.

Frames: the root link's is the object's; any other link has its origin at its joint's and the axes of the object at
joint value 0, so that joint frames need no rotation and every mesh of a link is in axes that a reader recognises.
"""

from __future__ import annotations

from dataclasses import field

import numpy as np

from ..language import JOINTS, Kind
from ..records import dataclass
from .primitives import Collider, Visual

SMALLEST_MASS = 1e-6  # kg


@dataclass(frozen=True, slots=True)
class RobotLink:
    """``origin`` (3,) of its frame in the object at joint value 0; centre of mass and inertia in the link's frame."""

    name: str
    origin: np.ndarray
    mass: float
    center: np.ndarray
    inertia: np.ndarray
    visuals: tuple[Visual, ...]
    colliders: tuple[Collider, ...]
    meshes: dict[str, str] = field(default_factory=dict)  # the name of what is seen of each material


@dataclass(frozen=True, slots=True)
class RobotJoint:
    """``origin`` in the parent link's frame, ``axis`` in the object's axes. ``low``, ``high`` None: no limit.

    ``mimic`` is (name of the leader, multiplier, offset), ``pitch`` a screw's advance by a turn, ``positions`` in how many
    values it catches (0: anywhere), ``gates`` what it waits for: (name of a joint, from, to), -inf and inf where there is no
    such end. ``curve`` is how a joint follows by a formula: values of the leader over its range, and its own at these (k,);
    ``mimic`` is then the straight line between the ends. A spring of ``stiffness`` (0: none) draws it back to ``rest``;
    ``unsprung`` is its friction, its damping and its effort where a format has no springs. Radians and metres, N m/rad and N/m.
    """

    name: str
    kind: str
    parent: int
    child: int
    origin: np.ndarray
    axis: np.ndarray
    low: float | None
    high: float | None
    rest: float
    effort: float
    velocity: float
    damping: float
    friction: float
    mimic: tuple[str, float, float] | None
    pitch: float = 0.0
    positions: int = 0
    armature: float = 0.0
    stiffness: float = 0.0
    unsprung: tuple[float, float, float] | None = None  # None: the object has no springs
    gates: tuple[tuple[str, float, float], ...] = ()
    curve: tuple[np.ndarray, np.ndarray] | None = None

    @property
    def traits(self) -> Kind:
        """What is so of all joints of its kind."""
        return JOINTS[self.kind]

    @property
    def limited(self) -> bool:
        return self.low is not None and self.high is not None

    @property
    def advance(self) -> float | None:
        """How far it slides per unit of its value: 1 of what slides, metres per radian of a screw; None of others."""
        return 1.0 if self.traits.slides else self.pitch / (2 * np.pi) if self.traits.advances else None

    def following(self, lead: np.ndarray) -> np.ndarray:
        """Its values where its leader is at ``lead`` (...,)."""
        assert self.mimic is not None
        if self.curve is None:
            return self.mimic[1] * lead + self.mimic[2]
        from scipy.interpolate import CubicSpline  # start-up: few joints need it

        return CubicSpline(*self.curve)(lead)

    @property
    def hinge(self) -> str:
        """Its kind, of a hinge by the formats' rule that one without limits is continuous."""
        return "continuous" if self.kind == "revolute" and not self.limited else self.kind


@dataclass(frozen=True, slots=True)
class RobotClosure:
    """Points (3,) of two links, each in its link's frame, that stay together: where a loop closes."""

    links: tuple[int, int]
    points: tuple[np.ndarray, np.ndarray]


@dataclass(frozen=True, slots=True)
class Robot:
    """One object. ``links[0]`` is the root; ``overlaps`` are pairs of links that the text allows to overlap."""

    name: str
    number: int
    links: tuple[RobotLink, ...]
    joints: tuple[RobotJoint, ...]
    closures: tuple[RobotClosure, ...] = ()
    overlaps: tuple[tuple[int, int], ...] = ()
    note: str = ""  # what its files say of the surfaces

    def leader(self, joint: RobotJoint) -> RobotJoint | None:
        """The joint that one follows."""
        return next((other for other in self.joints if joint.mimic and other.name == joint.mimic[0]), None)
