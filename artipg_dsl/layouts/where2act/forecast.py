"""What annotations say will become of a trial of Where2Act: whether the hand gets there, and how far a point goes along its joint.

A hand that is led by a way ``u`` takes a point of a link along as far as one joint lets it: to the place on the path of the
point (``exp`` of the joint's twist, the column of the Jacobian) next to where the hand ends, no further than the joint has
room, and short of it by what the joint rubs and carries. What is in the way of the link is left out; the finger of a push meets
what stands before the point. A joint that waits for another does not move.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import TYPE_CHECKING

import numpy as np

from ...annotate.gripper import meet_pieces
from ...annotate.jacobian import find_jacobian, find_rates
from ...geometry.vectors import cross
from ...records import dataclass
from ...robot.substitute import simple_joints
from ...runtime.motion import apply
from ...validity.bodies import gather
from .hand import ALONG, FAR, GRIP, LENGTH, MOVED, PRESS, RADIUS, SHARE, START, STIFF, Trial, sprung

if TYPE_CHECKING:
    from ...robot.model import Robot
    from ...runtime.batch import Batch

_G = 9.81  # m/s2
_STEPS = 300  # of a joint's way, on which the nearest place is looked for
_SWEEPS = 12  # over the joints of a chain
_TURN = np.pi  # no hand turns a hinge further by leading a point straight on
BLOCKED, _SLIPS, _LITTLE = "finger blocked", "slips", "moves too little"


@dataclass(frozen=True)
class Scene:
    """One object, a batch of its own, with the joints at ``state`` (J,); ``rubs`` (J,) newton metres or newton that hold each, ``weighs``
    (J,) that pull it back from greater values, ``springs`` (J,) by how much more for each radian or metre; ``stiff``: newton per metre
    that the hand is behind."""

    batch: Batch
    state: np.ndarray
    rubs: np.ndarray
    weighs: np.ndarray
    springs: np.ndarray
    stiff: float = STIFF

    @staticmethod
    def of(batch: Batch, robot: Robot, state: np.ndarray) -> Scene:
        """With the masses and the friction that the files of the object state."""
        stated = {joint.name: joint.friction for joint in sprung(simple_joints(robot), robot).joints}
        rubs = np.array([stated.get(name, 0.0) for name in batch.joints().name])
        springs = np.nan_to_num(batch.joints().stiffness)
        return Scene(batch, state, _led(batch, state, rubs, np.abs), weights(batch, robot, state), springs)


@dataclass(frozen=True)
class Paths:
    """Of (T,) trials and the (D,) joints that drive the link: ``row`` of the joint table, -1 for none, by how much each value goes
    up, ``gone`` (radian, metre), the ``way`` (T, 3) of the point, and by how many metres the hand ``needs`` (T,) to be behind it
    at its end for what rubs and weighs."""

    row: np.ndarray
    gone: np.ndarray
    way: np.ndarray
    needs: np.ndarray


@dataclass(frozen=True)
class Forecast:
    """Of (T,) trials: whether they succeed by Where2Act's rule, why not ("" of those that do), and the paths."""

    good: np.ndarray
    why: np.ndarray
    paths: Paths


def foretell(scene: Scene, trials: Sequence[Trial], unit: float, groups: np.ndarray) -> Forecast:
    """What becomes of trials from one state. ``unit`` in metres; ``groups`` (L,): links of one number move as one."""
    turn, shift = scene.batch.pose(scene.state)
    link = np.array([t.link for t in trials])
    point = apply(turn[link], np.stack([t.point for t in trials])) + shift[link]
    normal = apply(turn[link], np.stack([t.normal for t in trials]))
    toward, lead = (np.stack([getattr(t, name) for t in trials]) for name in ("toward", "lead"))
    pushing = np.array([t.primitive.startswith("pushing") for t in trials])
    plain = np.array([t.primitive == "pushing" for t in trials])
    far = lead * FAR * unit
    press = np.where(plain, 1e-4, PRESS)[:, None] * unit * toward
    place = scene, link, point
    held, taken, shoved = (
        (paths, _goes(scene, paths, lead, plain, unit))
        for paths in (
            follow(*place, far),
            take_along(*place, normal, press, far, GRIP),
            _shove(*place, normal, press + far, GRIP),
        )
    )
    paths = _of(pushing, _of(shoved[1] & ~taken[1], shoved[0], taken[0]), held[0])
    good = np.where(pushing, taken[1] | shoved[1], held[1])
    why = np.where(good, "", np.where(held[1], _SLIPS, _LITTLE)).astype(object)
    pushed = np.flatnonzero(pushing)
    for k in np.unique(link[pushed]):
        at = pushed[link[pushed] == k]
        tip, wide, long = (point + normal * RADIUS * unit)[at], RADIUS * unit, LENGTH * unit
        free = clear(scene, np.flatnonzero(groups == groups[k]), tip, toward[at], wide, START * unit + long)
        free &= clear(scene, np.zeros(0, dtype=np.int64), tip - toward[at] * START * unit, toward[at], wide, long)
        why[at[~free]] = BLOCKED
        good[at[~free]] = False
    reached = (why != BLOCKED)[:, None]
    return Forecast(good, why, Paths(paths.row, reached * paths.gone, reached * paths.way, paths.needs))


def _of(which: np.ndarray, one: Paths, other: Paths) -> Paths:
    """The paths of one where ``which`` (T,) holds, elsewhere of the other; of either the same joints drive."""
    choose = which[:, None]
    needs = np.where(which, one.needs, other.needs)
    return Paths(one.row, np.where(choose, one.gone, other.gone), np.where(choose, one.way, other.way), needs)


def _goes(scene: Scene, paths: Paths, lead: np.ndarray, plain: np.ndarray, unit: float) -> np.ndarray:
    """Whether what moves so counts as moved (T,)."""
    joints, gone = scene.batch.joints(), np.abs(paths.gone)
    slides = joints.that("slides")[paths.row]
    span = np.asarray(joints.high - joints.low)[paths.row]
    enough = (gone > np.where(slides, MOVED * unit, MOVED)) | (gone > SHARE * np.where(np.isnan(span), np.inf, span))
    cosine = _dot(paths.way, lead) / np.maximum(_size(paths.way), 1e-12)
    moved: np.ndarray = (enough & (paths.row >= 0)).any(axis=1) & (plain | (cosine > ALONG))
    return moved


def weights(batch: Batch, robot: Robot, state: np.ndarray) -> np.ndarray:
    """What the weight of what it carries, and of what follows it, and its spring pull each joint (J,) back with, newton metres or newton."""
    joints, (turn, shift) = batch.joints(), batch.pose(state)
    mass = np.array([link.mass for link in robot.links])
    center = apply(turn, np.stack([link.origin + link.center for link in robot.links])) + shift
    axis = apply(turn[joints.child], joints.axis)
    place = apply(turn[joints.child], joints.origin) + shift[joints.child]
    carried = np.zeros((len(joints.owner), len(mass)), dtype=bool)
    carried[np.arange(len(carried)), joints.child] = True
    for _ in range(len(carried)):  # down the tree
        for parent, child in zip(joints.parent, joints.child, strict=True):
            carried[:, child] |= carried[:, parent]
    lever = cross(axis[:, None], center[None] - place[:, None])[..., 2]
    rise = np.where(joints.that("slides")[:, None], axis[:, None, 2], lever)
    own = np.where(joints.that("slides", "turns"), (_G * mass * rise * carried).sum(axis=1), 0.0)
    drawn = np.nan_to_num(joints.stiffness) * (state - joints.rest)
    return _led(batch, state, own) + drawn


def _led(
    batch: Batch, state: np.ndarray, own: np.ndarray, sign: Callable[[np.ndarray], np.ndarray] = np.positive
) -> np.ndarray:
    """What is on each joint (J,) and, at the rate that they go along, on those that follow it."""
    drivers, rate, _ = find_rates(batch, state)
    found, there = own.copy(), drivers[0] >= 0
    found[drivers[0, there]] = (sign(rate[:, there]) * own[:, None]).sum(axis=0)
    return found


def follow(scene: Scene, link: np.ndarray, point: np.ndarray, lead: np.ndarray) -> Paths:
    """Where points (T, 3) of the rows ``link`` (T,) come to when a hand leads them by ``lead`` (T, 3) metres.

    Joints of a chain take their turns; what they do adds up.
    """
    batch, state = scene.batch, scene.state
    jacobian, joints = find_jacobian(batch, state), batch.joints()
    row = np.full(int(np.asarray(joints.number).max()) + 2, -1)
    row[np.asarray(joints.number)] = np.arange(len(joints.owner))
    driver = row[jacobian.driver[link]]
    turn, speed = jacobian.turn[link], jacobian.at(link, point)
    low, high = (np.where(np.isnan(limit), end, limit) for limit, end in ((joints.low, -np.inf), (joints.high, np.inf)))
    below, above = np.clip(state - low, 0, None)[driver], np.clip(high - state, 0, None)[driver]
    if batch.gates is not None:
        waits = np.zeros(len(joints.owner), dtype=bool)
        waits[batch.gates.joint[batch.gates.held(state)]] = True
        driver = np.where(waits[driver], -1, driver)
    below, above = np.where(driver >= 0, below, 0.0), np.where(driver >= 0, above, 0.0)
    rubs, weighs, springs = (v[driver] / scene.stiff for v in (scene.rubs, scene.weighs, scene.springs))
    gone, steps = np.zeros(driver.shape), np.zeros((*driver.shape, 3))
    for _ in range(_SWEEPS if driver.shape[1] > 1 else 1):
        for d in range(driver.shape[1]):
            rest = lead - steps.sum(axis=1) + steps[:, d]
            room = below[:, d], above[:, d]
            held = rubs[:, d], weighs[:, d], springs[:, d]
            gone[:, d], steps[:, d] = _nearest(turn[:, d], speed[:, d], *room, rest, *held)
    way = steps.sum(axis=1)
    last = np.maximum(_size(speed + np.cross(turn, way[:, None])), 1e-9)
    needs = np.where(gone != 0, np.maximum(rubs + np.sign(gone) * (weighs + springs * gone), 0.0) / last, 0.0).max(
        axis=1
    )
    return Paths(driver, gone, way, needs)


def _nearest(
    turn: np.ndarray,
    speed: np.ndarray,
    below: np.ndarray,
    above: np.ndarray,
    lead: np.ndarray,
    rubs: np.ndarray,
    weighs: np.ndarray,
    springs: np.ndarray,
) -> tuple[np.ndarray, np.ndarray]:
    """How far (T,) one joint goes, and the way (T, 3) of the point, to the first place on its path where the hand, by what it
    is still behind, no longer overcomes what ``rubs`` and ``weighs`` (T,), in metres of the hand times metres of the point per unit,
    and what ``springs`` (T,) draw more per unit."""
    rate, size, far = (np.sqrt((v**2).sum(axis=-1)) for v in (turn, speed, lead))
    way = np.sign((speed * lead).sum(axis=-1))
    reach = np.where(rate > 0, _TURN, far / np.maximum(size, 1e-9))
    end = np.where(size > 1e-9, np.minimum(np.where(way > 0, above, below), reach), 0.0)
    step = (way * end)[:, None] * np.linspace(0, 1, _STEPS + 1)
    safe = np.where(rate > 0, rate, 1.0)[:, None]
    along = np.where(rate[:, None] > 0, np.sin(safe * step) / safe, step)
    across = np.where(rate[:, None] > 0, (1 - np.cos(safe * step)) / safe**2, 0.0)
    moved = along[..., None] * speed[:, None] + across[..., None] * np.cross(turn, speed)[:, None]
    gained = -np.diff(((moved - lead[:, None]) ** 2).sum(axis=-1) / 2, axis=-1)
    drawn = springs[:, None] * (step[:, 1:] + step[:, :-1]) / 2
    held = np.maximum(rubs[:, None] + way[:, None] * (weighs[:, None] + drawn), 0.0)
    ends = gained < held * (end / _STEPS)[:, None]
    best = np.where(ends.any(axis=-1), ends.argmax(axis=-1), _STEPS)
    at = np.arange(len(best))
    return step[at, best], moved[at, best]


def take_along(
    scene: Scene,
    link: np.ndarray,
    point: np.ndarray,
    normal: np.ndarray,
    press: np.ndarray,
    lead: np.ndarray,
    friction: float,
) -> Paths:
    """As ``follow``, of a finger that is pressed on a surface with the outward ``normal`` by ``press`` and then led, (T, 3) each.

    What rubs in a joint is little beside the friction of a finger: the link follows along its joint's motion, while the
    finger slips across it, as long as the finger presses; and not where no force within the cone of friction moves it so. It
    sets off once the finger, which goes deeper where it is led into the surface, presses enough for what rubs and weighs.
    """
    ahead = -_dot(press, normal)
    whole = follow(scene, link, point, press + lead)
    way = whole.way
    rise = _dot(lead - way, normal)
    out = _dot(way, normal) / np.maximum(_size(way), 1e-12)
    grip = friction * np.sqrt(np.clip(1 - out**2, 0, 1)) - out  # force along the way per force that presses
    ahead -= whole.needs / np.maximum(grip, 1e-9)
    late = np.clip(-ahead / np.clip(-_dot(lead, normal), 1e-12, None), 0.0, 1.0)
    share = np.where(rise > 0, np.clip(ahead / np.where(rise > 0, rise, 1.0), 0.0, 1.0), 1.0 - late)
    found = follow(scene, link, point, press + share[:, None] * lead)
    return Paths(found.row, np.where((grip <= 0)[:, None], 0.0, found.gone), found.way, found.needs)


def _shove(
    scene: Scene, link: np.ndarray, point: np.ndarray, normal: np.ndarray, lead: np.ndarray, friction: float
) -> Paths:
    """As ``follow``, of a finger that slips along the surface: it pushes by what it goes in, and friction draws as it slips."""
    deep = np.minimum(_dot(lead, normal), 0.0)[:, None] * normal
    found = follow(scene, link, point, deep)
    slip = lead - found.way
    slip -= _dot(slip, normal)[:, None] * normal
    slip /= np.maximum(_size(slip), 1e-12)[:, None]
    jams = _dot(friction * slip - normal, found.way) <= 0
    return Paths(found.row, np.where(jams[:, None], 0.0, found.gone), found.way, found.needs)


def _dot(a: np.ndarray, b: np.ndarray) -> np.ndarray:
    made: np.ndarray = (a * b).sum(axis=-1)
    return made


def _size(a: np.ndarray) -> np.ndarray:
    made: np.ndarray = np.sqrt((a * a).sum(axis=-1))
    return made


def clear(
    scene: Scene, group: np.ndarray, tip: np.ndarray, along: np.ndarray, radius: float, length: float
) -> np.ndarray:
    """Whether a finger of a ``radius`` and a ``length`` whose tip's centre comes to ``tip`` (T, 3) ``along`` (T, 3) meets none
    but the links ``group`` (rows) of the one object of the batch."""
    turn, shift = scene.batch.pose(scene.state)
    body = gather(scene.batch, np.zeros(1, dtype=np.int64), turn, shift)
    others = body.part(np.flatnonzero(~np.isin(body.link, group)))
    if not len(others) or not len(tip):
        return np.ones(len(tip), dtype=bool)
    side = np.cross(along, np.where(np.abs(along[:, :1]) < 0.9, [[1.0, 0, 0]], [[0, 1.0, 0]]))
    side /= np.sqrt((side**2).sum(axis=1))[:, None]
    frame = np.stack([side, np.cross(along, side), along], axis=-1)
    wide = 0.85 * radius  # a square as large as the circle
    low, high = np.array([-wide, -wide, -length]), np.array([wide, wide, wide])
    boxes = [np.broadcast_to(corner, (len(tip), 1, 3)) for corner in (low, high)]
    return ~meet_pieces(others, np.zeros(len(tip), dtype=np.int64), tip, frame, *boxes)[:, 0]
