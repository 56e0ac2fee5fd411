"""A parallel gripper, and which grasps it can make: the fingers open far enough, hit nothing, and have something between.

The hand is five boxes in the frame of a grasp (z approach, y closing): two fingers, the palm behind them, and the space
between the pads, which has to hold a piece of what is grasped. What they are tested against are the convex pieces of
the whole object, those that collisions are tested with.
"""

from __future__ import annotations

import re
from dataclasses import asdict, fields
from typing import TYPE_CHECKING

import numpy as np

from ..errors import UsageError
from ..geometry.collide import DEPTH, Corners, overlap
from ..graph.program import MEASURES
from ..records import dataclass
from ..validity.bodies import Pieces, Placed, boxes_meet, enumerate_ranges, gather
from .frames import rotate

if TYPE_CHECKING:
    from ..runtime.batch import Batch
    from .grasps import GraspTable

REASONS = ("reachable", "wide", "blocked", "empty")
"""What can become of a grasp, by number: made; opened wider than the stroke; fingers or palm hit something; nothing held."""
_UNITS = {"m": 1.0, "cm": 0.01, "mm": 0.001}
_PAIRS = 2_000_000  # of a hand and a piece, at a time
_ROOM = 1e-3  # about the palm: pieces of what is bent lie within its surface by as much
_CORNERS = np.array([[i, j, k] for i in (0, 1) for j in (0, 1) for k in (0, 1)])


@dataclass(frozen=True, slots=True)
class Gripper:
    """Sizes in metres, of the order of common two-finger hands. Raises UsageError for one that is not above 0.

    ``stroke``: the widest opening; ``length``, ``width``, ``thickness`` of a finger along z, x and y; ``pad``: how far
    fingertips reach beyond the point of a grasp; ``palm``, ``palm_width``, ``palm_depth``: the hand along y, x and z.
    """

    stroke: float = 0.08
    length: float = 0.045
    width: float = 0.02
    thickness: float = 0.01
    pad: float = 0.008
    palm: float = 0.14
    palm_width: float = 0.06
    palm_depth: float = 0.07

    def __post_init__(self) -> None:
        for name, value in asdict(self).items():
            if isinstance(value, bool) or not isinstance(value, int | float) or not 0 < value < 10:
                raise UsageError(f"the gripper's {name} is {value!r}", "give a length in metres, above 0 and below 10")

    def measures(self, stated: np.ndarray) -> np.ndarray:
        """(G, 8) measures in the order of ``MEASURES``: this gripper's, or, of the standard one, those that grasps state
        (G, 8), nan where they state none."""
        own = np.array([getattr(self, name) for name in MEASURES])
        return np.where(np.isnan(stated) | (self != STANDARD), own, stated)

    @staticmethod
    def boxes(opening: np.ndarray, measures: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Low and high corners (G, 4, 3) of left and right finger, palm, and the space between the pads of grippers of
        the ``measures`` (G, 8)."""
        _, length, width, thickness, tip, palm, flat, depth = measures.T
        half, wide, palm, flat = opening / 2, width / 2, palm / 2 + _ROOM, flat / 2 + _ROOM
        back = tip - length
        low = [
            [-wide, half, back],
            [-wide, -half - thickness, back],
            [-flat, -palm, back - depth - _ROOM],
            [-wide, -half, -tip],
        ]
        high = [[wide, half + thickness, tip], [wide, -half, tip], [flat, palm, back + _ROOM], [wide, half, tip]]
        made = (np.stack([np.stack(row, axis=-1) for row in rows], axis=1) for rows in (low, high))
        least, most = made
        return least + DEPTH / 2, most - DEPTH / 2  # what touches does not hit

    def plain(self) -> dict[str, float]:
        return asdict(self)


STANDARD = Gripper()


def read_gripper(text: str | Gripper) -> Gripper | None:
    """``stroke=10cm,width=15mm``: the standard gripper but for these; ``standard``; ``any`` is None: no hand is minded.

    A gripper stays as it is. Raises UsageError.
    """
    if isinstance(text, Gripper):
        return text
    if not isinstance(text, str):
        raise UsageError(f"a gripper is text or a Gripper, not {text!r}", "such as stroke=8cm,width=2cm, or any")
    if text.strip() in ("any", "standard"):
        return STANDARD if text.strip() == "standard" else None
    names, found = [f.name for f in fields(Gripper)], {}
    for piece in (p.strip() for p in text.split(",")):
        match = re.fullmatch(r"(\w+)\s*=\s*(\d+\.?\d*|\.\d+)(m|cm|mm)", piece)
        if match is None and re.fullmatch(r"\w+\s*=\s*[.\d]+", piece):
            raise UsageError(f"`{piece}` has no unit", f"write mm, cm or m after the number: {piece}mm")
        if match is not None and match[1] in found:
            raise UsageError(f"the gripper's {match[1]} is given twice")
        if match is None or match[1] not in names:
            hint = f"write `standard`, `any`, or lengths such as stroke=8cm,width=2cm; there are {', '.join(names)}"
            raise UsageError(f"`{piece}` is not a measure of a gripper", hint)
        found[match[1]] = float(match[2]) * _UNITS[match[3]]
    return Gripper(**found)


def judge(batch: Batch, grasps: GraspTable, gripper: Gripper, states: np.ndarray | None = None) -> np.ndarray:
    """What becomes of each grasp with the joints at ``states`` (J,), rest by default: (G,) numbers of ``REASONS``.

    The standard gripper gives way to the measures that a grasp states; any other is the same for all grasps.
    """
    verdict = np.zeros(len(grasps.owner), dtype=np.int64)
    if not len(verdict):
        return verdict
    first = np.searchsorted(batch.links().owner, np.arange(len(batch)))
    turn, shift = batch.pose(states)
    body = gather(batch, first, turn, shift)
    point, rotation, _ = grasps.moved(first, turn, shift)
    measures = gripper.measures(grasps.hand)
    hit = meet_pieces(body, grasps.owner, point, rotation, *gripper.boxes(grasps.opening, measures))
    verdict[~hit[:, 3]] = REASONS.index("empty")
    verdict[hit[:, :3].any(axis=1)] = REASONS.index("blocked")
    verdict[grasps.opening > measures[:, MEASURES.index("stroke")] * (1 + 1e-9)] = REASONS.index("wide")
    return verdict


def find_wide(grasps: GraspTable) -> list[tuple[int, float, float]]:
    """The families of which every grasp opens wider than the hand that it is meant for, or the standard one: (its number, the least
    opening, the largest stroke), metres."""
    stroke = STANDARD.measures(grasps.hand)[:, MEASURES.index("stroke")]
    found = []
    for family in sorted(set(grasps.family.tolist())):
        mine = grasps.family == family
        if (grasps.opening[mine] > stroke[mine] * (1 + 1e-9)).all():
            found.append((int(family), float(grasps.opening[mine].min()), float(stroke[mine].max())))
    return found


def meet_pieces(
    body: Pieces, owner: np.ndarray, point: np.ndarray, rotation: np.ndarray, low: np.ndarray, high: np.ndarray
) -> np.ndarray:
    """Which boxes (G, S) in the frames of grasps overlap a piece of their object."""
    ends = np.stack([low, high], axis=2)  # (G, S, 2, 3)
    local = np.stack([ends[:, :, _CORNERS[:, axis], axis] for axis in range(3)], axis=-1)
    corners = rotate(rotation[:, None, None], local) + point[:, None, None]  # (G, S, 8, 3)
    shapes = corners.shape[1]
    least, most = corners.min(axis=2), corners.max(axis=2)
    hand = least.min(axis=1), most.max(axis=1)
    corners, least, most = corners.reshape(-1, 8, 3), least.reshape(-1, 3), most.reshape(-1, 3)
    start = np.searchsorted(body.owner, owner)
    count = np.searchsorted(body.owner, owner, side="right") - start
    found = np.zeros(len(corners), dtype=bool)
    block = np.cumsum(count) // _PAIRS
    for number in range(int(block[-1]) + 1):
        rows = np.flatnonzero(block == number)
        grasp, piece = enumerate_ranges(start[rows], count[rows])
        at = boxes_meet(rows[grasp], piece, *hand, body.low, body.high)  # the hand as a whole first
        box = (shapes * rows[grasp[at]][:, None] + np.arange(shapes)).ravel()
        piece = np.repeat(piece[at], shapes)
        at = boxes_meet(box, piece, least, most, body.low, body.high)
        box, piece = box[at], piece[at]
        body.ready(piece)
        found[box[overlap(Corners(corners[box]), Placed(body, piece))]] = True
    return found.reshape(-1, shapes)
