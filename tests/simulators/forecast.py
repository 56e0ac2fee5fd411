"""What annotations say will become of a trial: whether the hand gets there, and how far a point goes along its joint.

A hand that is led by a way ``u`` takes a point of a link along as far as one joint lets it: to the place on the path of the
point (``exp`` of the joint's twist, the column of the Jacobian) next to where the hand ends, no further than the joint has
room, and short of it by what the joint rubs and carries. What is in the way of the link is left out; the finger of a push meets
what stands before the point. A joint that waits for another does not move.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from artipg_dsl.annotate.gripper import meet_pieces
from artipg_dsl.annotate.jacobian import find_jacobian
from artipg_dsl.runtime.batch import Batch
from artipg_dsl.validity.bodies import gather

STEPS = 300  # of a joint's way, on which the nearest place is looked for
SWEEPS = 12  # over the joints of a chain
TURN = np.pi  # no hand turns a hinge further by leading a point straight on


@dataclass(frozen=True)
class Scene:
    """One object, a batch of its own, with the joints at ``state`` (J,); ``rubs`` (J,) newton metres or newton that hold each, ``weighs``
    (J,) that pull it back from greater values; ``stiff``: newton per metre that the hand is behind."""

    batch: Batch
    state: np.ndarray
    rubs: np.ndarray
    weighs: np.ndarray
    stiff: float


@dataclass(frozen=True)
class Paths:
    """Of (T,) trials and the (D,) joints that drive the link: ``row`` of the joint table, -1 for none, how far each goes
    ``gone`` (radian, metre), and the ``way`` (T, 3) of the point."""

    row: np.ndarray
    gone: np.ndarray
    way: np.ndarray


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
    rubs, weighs = scene.rubs[driver] / scene.stiff, scene.weighs[driver] / scene.stiff
    gone, steps = np.zeros(driver.shape), np.zeros((*driver.shape, 3))
    for _ in range(SWEEPS if driver.shape[1] > 1 else 1):
        for d in range(driver.shape[1]):
            rest = lead - steps.sum(axis=1) + steps[:, d]
            there = (driver[:, d] >= 0).astype(float)
            room = below[:, d] * there, above[:, d] * there
            gone[:, d], steps[:, d] = _nearest(turn[:, d], speed[:, d], *room, rest, rubs[:, d], weighs[:, d])
    return Paths(driver, np.abs(gone), steps.sum(axis=1))


def _nearest(
    turn: np.ndarray,
    speed: np.ndarray,
    below: np.ndarray,
    above: np.ndarray,
    lead: np.ndarray,
    rubs: np.ndarray,
    weighs: np.ndarray,
) -> tuple[np.ndarray, np.ndarray]:
    """How far (T,) one joint goes, and the way (T, 3) of the point, to the first place on its path where the hand, by what it
    is still behind, no longer overcomes what ``rubs`` and ``weighs`` (T,), in metres of the hand times metres of the point per unit."""
    rate, size, far = (np.sqrt((v**2).sum(axis=-1)) for v in (turn, speed, lead))
    way = np.sign((speed * lead).sum(axis=-1))
    reach = np.where(rate > 0, TURN, far / np.maximum(size, 1e-9))
    end = np.where(size > 1e-9, np.minimum(np.where(way > 0, above, below), reach), 0.0)
    step = (way * end)[:, None] * np.linspace(0, 1, STEPS + 1)
    safe = np.where(rate > 0, rate, 1.0)[:, None]
    along = np.where(rate[:, None] > 0, np.sin(safe * step) / safe, step)
    across = np.where(rate[:, None] > 0, (1 - np.cos(safe * step)) / safe**2, 0.0)
    moved = along[..., None] * speed[:, None] + across[..., None] * np.cross(turn, speed)[:, None]
    gained = -np.diff(((moved - lead[:, None]) ** 2).sum(axis=-1) / 2, axis=-1)
    held = np.maximum(rubs + way * weighs, 0.0)
    ends = gained < held[:, None] * (end / STEPS)[:, None]
    best = np.where(ends.any(axis=-1), ends.argmax(axis=-1), STEPS)
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
    way = follow(scene, link, point, press + lead).way
    rise = _dot(lead - way, normal)
    out = _dot(way, normal) / np.maximum(_size(way), 1e-12)
    grip = friction * np.sqrt(np.clip(1 - out**2, 0, 1)) - out  # force along the way per force that presses
    needed = _dot(press + lead - way, way) / np.maximum(_size(way), 1e-12)
    ahead -= np.clip(needed, 0, None) / np.maximum(grip, 1e-9)
    late = np.clip(-ahead / np.clip(-_dot(lead, normal), 1e-12, None), 0.0, 1.0)
    share = np.where(rise > 0, np.clip(ahead / np.where(rise > 0, rise, 1.0), 0.0, 1.0), 1.0 - late)
    found = follow(scene, link, point, press + share[:, None] * lead)
    return Paths(found.row, np.where((grip <= 0)[:, None], 0.0, found.gone), found.way)


def shove(
    scene: Scene, link: np.ndarray, point: np.ndarray, normal: np.ndarray, lead: np.ndarray, friction: float
) -> Paths:
    """As ``follow``, of a finger that slips along the surface: it pushes by what it goes in, and friction draws as it slips."""
    deep = np.minimum(_dot(lead, normal), 0.0)[:, None] * normal
    found = follow(scene, link, point, deep)
    slip = lead - found.way
    slip -= _dot(slip, normal)[:, None] * normal
    slip /= np.maximum(_size(slip), 1e-12)[:, None]
    jams = _dot(friction * slip - normal, found.way) <= 0
    return Paths(found.row, np.where(jams[:, None], 0.0, found.gone), found.way)


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
