"""Bodies that turn, looked at by compiled code: what ``validity.validate`` and ``validity.bodies`` compute, with the same bits."""

from __future__ import annotations

import ctypes
from typing import TYPE_CHECKING

import numpy as np

from ..records import dataclass
from .calls import address, call
from .narrow import Side, told

if TYPE_CHECKING:
    from .backend import Machine


@dataclass(frozen=True, slots=True, eq=False)
class Intervals:
    """Intervals of angles of k pairs of pieces: unit axes and origins (k, 3), the angle in the middle and half the interval (k,), radians,
    metres along the axis for a radian (k,), a gap (k,) or None; which pieces (k,) of those with boxes (N, 3) at rest."""

    axis: np.ndarray
    origin: np.ndarray
    middle: np.ndarray
    half: np.ndarray
    advance: np.ndarray
    gap: np.ndarray | None
    piece: np.ndarray
    other: np.ndarray
    low: np.ndarray
    high: np.ndarray


@dataclass(frozen=True, slots=True, eq=False)
class Scene:
    """Boxes (L, 3) of links, boxes (N, 3) of pieces, sorted by link, and ``begin`` and ``end`` (L,) of those of each link."""

    lows: np.ndarray
    highs: np.ndarray
    low: np.ndarray
    high: np.ndarray
    begin: np.ndarray
    end: np.ndarray


class _Scene(ctypes.Structure):
    _fields_ = [(name, ctypes.c_void_p) for name in Scene.__slots__]


def near_pieces(
    machine: Machine,
    links: tuple[np.ndarray, np.ndarray],
    boxes: tuple[np.ndarray, np.ndarray],
    child: np.ndarray | None,
    chain: np.ndarray,
    scene: Scene,
) -> tuple[np.ndarray, np.ndarray]:
    """(box, piece): of boxes (n, 3) the pieces that they overlap, of ``links`` from the first (n,) to before the last (n,), but those that
    hang on the link ``child`` (n,), as ``chain`` (L, depth) tells."""
    first, stop, chain = (np.ascontiguousarray(column, dtype=np.int64) for column in (*links, chain))
    low, high = (np.ascontiguousarray(end, dtype=np.float64) for end in boxes)
    moved = None if child is None else np.ascontiguousarray(child, dtype=np.int64)
    columns = [
        np.ascontiguousarray(getattr(scene, name), dtype=np.int64 if name in ("begin", "end") else np.float64)
        for name in Scene.__slots__
    ]
    held, room = _Scene(*[address(column) for column in columns]), _ROOM * len(low)
    while True:
        found = np.empty((2, room), dtype=np.int64)
        given = (first, stop, low, high, moved, chain.shape[1], chain, held, room)
        known = call(machine.library.near_pieces, len(low), *given, found[0], found[1])
        if known <= room:
            return found[0, :known], found[1, :known]
        room = known


_ROOM = 16  # pieces near another, for which there is room at first
_ANGLES = ("middle", "half", "cos_middle", "sin_middle", "cos_half", "sin_half")
_NUMBERS = ("axis", "origin", *_ANGLES, "advance", "gap", "low", "high")


class _Turns(ctypes.Structure):
    _fields_ = [(name, ctypes.c_void_p) for name in (*_NUMBERS, "piece", "other")]


def examine(
    machine: Machine, moved: Side, still: Side, turns: Intervals, near: float, steps: int
) -> tuple[np.ndarray, np.ndarray]:
    """Which pairs (k,) meet in the middle of their intervals, and which are proved to stay apart in all of them."""
    hit, apart = np.empty((2, len(turns.piece)), dtype=np.bool_)
    least = np.minimum(turns.half, np.pi)
    angles = (turns.middle, turns.half, np.cos(turns.middle), np.sin(turns.middle), np.cos(least), np.sin(least))
    columns = (turns.axis, turns.origin, *angles, turns.advance, turns.gap, turns.low, turns.high)
    given = [None if column is None else np.ascontiguousarray(column, dtype=np.float64) for column in columns]
    given += [np.ascontiguousarray(column, dtype=np.int64) for column in (turns.piece, turns.other)]
    all_of = _Turns(*[None if array is None else address(array) for array in given])
    (one, held), (two, more) = (told(side) for side in (moved, still))
    call(machine.library.examine, len(hit), one, two, all_of, float(near), steps, hit, apart)
    del held, more  # were to live until here
    return hit, apart


def sweep(
    machine: Machine, moved: Side, axis: np.ndarray, origin: np.ndarray, half: np.ndarray, direction: np.ndarray
) -> np.ndarray:
    """How far (k,) bodies, turned and shifted, reach along ``direction`` (k, 3) while they turn about axes (k, 3) through origins
    (k, 3) by up to ``half`` (k,) either way."""
    found = np.empty(len(half))
    columns = (axis, origin, np.cos(half), np.sin(half), direction)
    given = [np.ascontiguousarray(column, dtype=np.float64) for column in columns]
    one, held = told(moved)
    call(machine.library.sweep, len(half), one, *given, found)
    del held  # was to live until here
    return found


def turn_points(machine: Machine, turn: np.ndarray, points: np.ndarray, shift: np.ndarray | None) -> np.ndarray:
    """Points (k, P, 3) by matrices (k, 3, 3), and shifts (k, 3) after them unless there are none."""
    given = [
        None if array is None else np.ascontiguousarray(array, dtype=np.float64) for array in (turn, points, shift)
    ]
    out = np.empty(points.shape)
    call(machine.library.turn_points, *points.shape[:2], *given, out)
    return out
