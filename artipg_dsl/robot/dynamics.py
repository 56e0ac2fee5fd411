"""What a joint gets where its text gives none: friction, damping, effort and velocity by kind and by what it moves.

With the joints at rest, for what a joint carries: its mass m (kg), its inertia I about the axis of a hinge (for a slide its
mass), and the load L, the most that gravity asks of the joint over its range (N m, for a slide N).

* friction: what runs rubs with a hundredth or two of its weight: ``SLIDING * m g`` on runners, ``PIN * m g`` about a pin. Where
  gravity pulls the joint off its rest and no limit holds it there (a lid that stands open, the neck of a tap), it holds itself:
  ``HOLD * L``; beside a spring, too, which not every format has. A spring that balances the weight (the door of a dishwasher)
  leaves less than L over the range, and friction holds that.
* damping: a free movement dies away within ``FADE`` seconds: I / FADE. A spring of stiffness k brings the joint back without
  swinging past: 2 sqrt(k I).
* effort: what friction, load and spring take, and half as much again or a push: ``HAND`` newtons at the far edge of what is moved,
  ``sqrt(3 I / m)`` from a hinge's axis (exact for a leaf), but no more than carries it, with ``FINGER`` at that edge, over its range
  within ``QUICK``. A key of a gram under the whole force of a hand would be at its other end, and back, before a
  simulator's next step: no controller holds it.
* armature: what a motor adds to the inertia, so that no effort carries the joint over its range within ``QUICK``, or within
  ``SWIFT`` where the text states the effort, which is often a guess and far too much for a button, or a spring, which brings it to
  its rest no sooner. None is needed but where next to nothing is moved, by a few millimetres or against much friction.
* velocity: by kind.

Of joints that move together, by a mimic or round a loop, each feels friction, load and inertia of all, at the rate at which
they move against it.

Hands: 50 N is class 2 of EN 12217, operating forces of doors; runners and pins: rolling friction 0.02, and dry steel, 0.2, on
a pin of 10 mm.
"""

from __future__ import annotations

import numpy as np

from ..annotate.frames import rotate
from ..geometry.vectors import cross, dot
from ..records import dataclass
from ..runtime.tables import JointTable
from ..validity.mass import Mass

GRAVITY = 9.81  # m/s2
SLIDING = 0.02  # of the weight
PIN = 0.001  # m: friction 0.2 at a radius of 5 mm
HOLD = 1.2  # times the load
HAND = 50.0  # N
FINGER = 0.01  # kg: what moves with a key that it presses
QUICK = 0.15  # s, from one end to the other
SWIFT = 0.05  # s, by an effort that the text states: ten steps of a simulator and more
FADE = {"revolute": 2.0, "continuous": 5.0, "prismatic": 2.0, "screw": 1.0, "ball": 2.0}  # s
VELOCITY = {"revolute": 3.0, "continuous": 6.0, "prismatic": 1.0, "screw": 6.0, "ball": 3.0}  # rad/s, m/s
_PLACES = 65  # of a range, at which is looked at what a spring leaves of a weight
_BALANCED = 1e-3  # of the load: less than this is no pull


@dataclass(frozen=True, slots=True)
class Dynamics:
    """Per joint (J,): N m, N m s/rad, rad/s and kg m2 of what turns; N, N s/m, m/s and kg of what slides."""

    friction: np.ndarray
    damping: np.ndarray
    effort: np.ndarray
    velocity: np.ndarray
    armature: np.ndarray


@dataclass(frozen=True, slots=True)
class _Loads:
    """Per joint (J,): the mass that it carries and its weight, what of it the joint moves (kg m2 of what turns, kg of what slides), and
    how gravity draws the value at rest (``pull``), at most anywhere in the range (``most``), and at most with the spring (``left``)."""

    mass: np.ndarray
    weight: np.ndarray
    moved: np.ndarray
    pull: np.ndarray
    most: np.ndarray
    left: np.ndarray


def complete_dynamics(
    joints: JointTable,
    rest: np.ndarray,
    first: np.ndarray,
    mass: Mass,
    pose: tuple[np.ndarray, np.ndarray],
    together: tuple[np.ndarray, np.ndarray],
    thrust: np.ndarray,
) -> Dynamics:
    """The given values of all joints, and where there are none, those that their kind and what they move ask for.

    ``rest`` (J,): the joints' values at rest. ``first`` (J,): row of link 0 of each joint's object. Of all links: the mass in the
    object's frame with the joints at 0, and the pose, rotation (L, 3, 3) and translation (L, 3), at rest. ``together``: who
    leads each joint (J,) and how fast it follows (J,). ``thrust`` (J,): torque or force of the floor along each value at rest.
    """
    loads = _weigh(joints, rest, first, mass, pose)
    rolling = loads.weight * np.where(joints.that("slides"), SLIDING, PIN)
    friction = _given(joints.friction, np.maximum(rolling, _held(joints, rest, loads, thrust)))
    effort, armature = _driven(joints, rest, loads, friction, together)
    settled = 2.0 * np.sqrt(np.nan_to_num(joints.stiffness) * (loads.moved + armature))
    damping = _given(joints.damping, np.maximum(loads.moved / _by_kind(joints, FADE), settled))
    return Dynamics(friction, damping, effort, _given(joints.velocity, _by_kind(joints, VELOCITY)), armature)


def _weigh(
    joints: JointTable, rest: np.ndarray, first: np.ndarray, mass: Mass, pose: tuple[np.ndarray, np.ndarray]
) -> _Loads:
    """What each joint carries, and how gravity pulls at it."""
    turn, shift = pose
    parent, child = first + joints.parent, first + joints.child
    place = rotate(turn[parent], joints.origin) + shift[parent]
    axis = rotate(turn[parent], joints.axis)
    center, inertia = rotate(turn, mass.center) + shift, _turned(turn, mass.inertia)
    carried, center, inertia = _carried(parent, child, mass.mass, center, inertia)
    m, arm = carried[child], center[child] - place
    slides, ball = joints.that("slides"), joints.that("tilts")
    reach = cross(axis, arm)  # how the centre moves as a hinge turns
    about = dot(axis, dot(inertia[child], axis[:, None])) + m * dot(reach, reach)
    weight, pitch = m * GRAVITY, np.nan_to_num(joints.pitch) / (2 * np.pi)
    pull = -weight * np.where(slides, axis[:, 2], reach[:, 2] + pitch * axis[:, 2])
    lift = weight * pitch * axis[:, 2]  # what a screw asks for on any turn
    cosine, sine = -weight * reach[:, 2], -weight * cross(axis, reach)[:, 2]
    swing = _most(cosine, sine, joints.low - rest, joints.high - rest)
    most = np.where(slides, np.abs(pull), np.where(ball, weight * np.sqrt(dot(arm, arm)), swing + np.abs(lift)))
    left = np.where(slides | ball, most, _left(cosine, sine, joints, rest, np.nan_to_num(joints.stiffness)))
    return _Loads(m, weight, np.where(slides, m, about), pull, most, left)


def _held(joints: JointTable, rest: np.ndarray, loads: _Loads, thrust: np.ndarray) -> np.ndarray:
    """(J,) what holds each joint at rest where gravity, or the floor on which it stands, would draw it off, and no limit is there."""
    near = 1e-6 + 1e-3 * np.nan_to_num(joints.high - joints.low)

    def off(force: np.ndarray) -> np.ndarray:
        return ~np.where(force > 0, rest >= joints.high - near, rest <= joints.low + near)

    pulled = np.abs(loads.pull) > _BALANCED * np.maximum(loads.most, 1e-9)
    hangs = np.where(joints.that("tilts"), True, pulled & off(loads.pull))
    stands = (thrust != 0.0) & off(loads.pull + thrust)
    hung = np.where(hangs, HOLD * np.minimum(loads.most, loads.left), 0.0)
    return np.maximum(hung, np.where(stands, HOLD * np.abs(loads.pull + thrust), 0.0))


def _driven(
    joints: JointTable, rest: np.ndarray, loads: _Loads, friction: np.ndarray, together: tuple[np.ndarray, np.ndarray]
) -> tuple[np.ndarray, np.ndarray]:
    """The effort of each joint (J,), and the armature by which no effort or spring carries it over its range too fast."""
    span, stiffness = np.nan_to_num(joints.high - joints.low), np.nan_to_num(joints.stiffness)
    way = np.where(span > 0.0, span, 2 * np.pi)  # what has no range turns round
    rubs = _of_all(friction, *together, 1)
    moves = _of_all(loads.moved, *together, 2)
    spring = _of_all(stiffness, *together, 2)
    drawn = spring * np.nan_to_num(np.maximum(rest - joints.low, joints.high - rest))
    taken = _of_all(friction + loads.most, *together, 1) + drawn
    lever = np.where(joints.that("slides"), 1.0, np.sqrt(3.0 * loads.moved / np.maximum(loads.mass, 1e-12)))
    push = np.minimum(HAND * lever, (moves + FINGER * lever**2) * 2.0 * way / QUICK**2)
    effort = _given(joints.effort, taken + np.maximum(0.5 * taken, push))
    least = np.where(np.isnan(joints.effort) & (spring == 0.0), QUICK, SWIFT)
    motor = (effort - rubs - drawn / 2.0) * least**2 / (2.0 * way)  # a spring takes half of its most on the way
    returned = stiffness * (SWIFT * 2.0 / np.pi) ** 2  # in a quarter of a period
    return effort, np.maximum(np.maximum(motor, returned) - moves, 0.0)


def _most(cosine: np.ndarray, sine: np.ndarray, low: np.ndarray, high: np.ndarray) -> np.ndarray:
    """The most of abs(cosine * cos(d) + sine * sin(d)) for d in low .. high, nan: anywhere."""
    peak = np.arctan2(sine, cosine)
    free = np.isnan(low) | np.isnan(high)
    first, last = np.where(free, 0.0, low), np.where(free, np.pi, high)
    ends = [np.abs(cosine * np.cos(d) + sine * np.sin(d)) for d in (first, last)]
    between = peak + np.pi * np.ceil((first - peak) / np.pi) <= last
    return np.where(between, np.hypot(cosine, sine), np.maximum(*ends))


def _left(
    cosine: np.ndarray, sine: np.ndarray, joints: JointTable, rest: np.ndarray, stiffness: np.ndarray
) -> np.ndarray:
    """The most of abs(cosine * cos(d) + sine * sin(d) - stiffness * d) over the range of each joint (J,): what a spring leaves of a
    weight. inf where there is no spring."""
    found = np.full(len(rest), np.inf)
    k = np.flatnonzero(stiffness > 0.0)
    low, high = (joints.low - rest)[k, None], (joints.high - rest)[k, None]
    d = low + (high - low) * np.linspace(0.0, 1.0, _PLACES)
    pulls = cosine[k, None] * np.cos(d) + sine[k, None] * np.sin(d) - stiffness[k, None] * d
    found[k] = np.abs(pulls).max(axis=1, initial=0.0)
    return found


def _of_all(value: np.ndarray, leader: np.ndarray, ratio: np.ndarray, power: int) -> np.ndarray:
    """What each joint feels of ``value`` (J,) of all that move together with it: forces with power 1, inertias with 2."""
    rate = np.abs(ratio) ** power
    total = np.bincount(leader, rate * value, len(value))[leader]
    return np.where(rate > 1e-6, total / np.maximum(rate, 1e-6), value)


def _carried(
    parent: np.ndarray, child: np.ndarray, mass: np.ndarray, center: np.ndarray, inertia: np.ndarray
) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Mass, centre and inertia of every link with all that hangs on it. Deepest joints first, in a fixed order."""
    above = np.full(len(mass), -1)
    above[child] = parent
    depth, link = np.zeros(len(mass), dtype=int), above.copy()
    while (link >= 0).any():
        depth += link >= 0
        link = np.where(link >= 0, above[link], -1)
    total, first = mass.copy(), mass[:, None] * center
    second = inertia + _parallel(mass, center)  # about the origin, where inertias add
    for level in range(int(depth.max(initial=0)), 0, -1):
        at = np.flatnonzero(depth == level)
        for sums in (total, first, second):
            np.add.at(sums, above[at], sums[at])
    middle = first / np.maximum(total, 1e-12)[:, None]
    return total, middle, second - _parallel(total, middle)


def _parallel(mass: np.ndarray, offset: np.ndarray) -> np.ndarray:
    outer = offset[:, :, None] * offset[:, None, :]
    return mass[:, None, None] * (dot(offset, offset)[:, None, None] * np.eye(3) - outer)


def _turned(turn: np.ndarray, tensor: np.ndarray) -> np.ndarray:
    half = np.stack([rotate(turn, tensor[..., j]) for j in range(3)], axis=-1)
    return np.stack([rotate(turn, half[:, j]) for j in range(3)], axis=-2)


def _by_kind(joints: JointTable, values: dict[str, float]) -> np.ndarray:
    return np.array([values.get(kind, values["revolute"]) for kind in joints.kind], dtype=np.float64)


def _given(value: np.ndarray, default: np.ndarray) -> np.ndarray:
    return np.where(np.isnan(value), default, value)
