"""Pairs of convex bodies, looked at by compiled code: what ``geometry.collide`` computes, with the same bits."""

from __future__ import annotations

import ctypes
from collections.abc import Sequence
from typing import TYPE_CHECKING

import numpy as np

from ..records import dataclass
from .calls import address, call

if TYPE_CHECKING:
    from .backend import Machine


@dataclass(frozen=True, slots=True, eq=False)
class Side:
    """One body of each of k pairs, as the compiled code reads it: the array ``kind`` (k,) of ``corners`` (n, P, 3) that its own lie in,
    and its ``slot`` (k,) there; turn (k, 3, 3) and shift (k, 3) from rest, or two shifts between which it is swept. With ``pose`` (k,)
    these are the turns and shifts of poses, and it tells which is whose."""

    corners: Sequence[np.ndarray]
    kind: np.ndarray
    slot: np.ndarray
    turn: np.ndarray | None = None
    shift: np.ndarray | None = None
    ends: tuple[np.ndarray, np.ndarray] | None = None
    pose: np.ndarray | None = None


class _Side(ctypes.Structure):
    _fields_ = [(name, ctypes.c_void_p) for name in ("corners", "count", "pose", "turn", "shift", "first", "last")]


def separate(
    machine: Machine, first: Side, second: Side, near: float, steps: int, direction: np.ndarray
) -> tuple[np.ndarray, np.ndarray]:
    """Which pairs overlap (k,), and directions (k, 3) that separate the others; ``direction`` (k, 3) leads from body to body."""
    nearest = np.array(direction, dtype=np.float64, order="C")
    hit = np.empty(len(nearest), dtype=np.bool_)
    (one, held), (two, kept) = (told(side) for side in (first, second))
    call(machine.library.separate, len(nearest), one, two, float(near), steps, nearest, hit)
    del held, kept  # were to live until here
    return hit, nearest


def closest(machine: Machine, simplex: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """The points (k, 3) of tetrahedra (k, 4, 3) nearest the origin, and their weights (k, 4)."""
    simplex = np.ascontiguousarray(simplex, dtype=np.float64)
    value, weight = np.empty((len(simplex), 3)), np.empty((len(simplex), 4))
    call(machine.library.closest, len(simplex), simplex, value, weight)
    return value, weight


def inset(machine: Machine, points: np.ndarray, first: np.ndarray, faces: np.ndarray, margin: float) -> np.ndarray:
    """Corners (N, 3) of bodies, those of each from ``first`` (k,) on, with the planes of their faces (F, 3) moved inwards by ``margin``."""
    points = np.ascontiguousarray(points, dtype=np.float64)
    first, faces = (np.ascontiguousarray(column, dtype=np.int64) for column in (first, faces))
    room = [np.empty(9 * len(points)), np.empty(3 * len(faces)), np.empty(4 * len(first))]
    owner, out = np.empty(len(points), dtype=np.int64), np.empty(points.shape)
    sizes = (len(first), first, len(points), points, len(faces), faces)
    call(machine.library.inset, *sizes, float(margin), *room, owner, out)
    return out


def told(side: Side) -> tuple[_Side, list[np.ndarray]]:
    """A side by the addresses of its arrays, and these arrays."""
    corners = [np.ascontiguousarray(array, dtype=np.float64) for array in side.corners]
    many = np.array([array.shape[1] for array in corners], dtype=np.int64)
    start = np.array([address(array) for array in corners], dtype=np.int64)
    count = many[side.kind]
    place = start[side.kind] + side.slot * (24 * count)
    ends = (None, None) if side.ends is None else side.ends
    columns = [
        None if array is None else np.ascontiguousarray(array, dtype=np.float64)
        for array in (side.turn, side.shift, *ends)
    ]
    pose = None if side.pose is None else np.ascontiguousarray(side.pose, dtype=np.int64)
    every = [place, count, pose, *columns]
    found = _Side(*[None if array is None else address(array) for array in every])
    return found, [*corners, *(array for array in every if array is not None)]
