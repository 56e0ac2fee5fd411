"""On what objects stand, by compiled code: what ``validity.hull`` and ``validity.stance`` compute, with the same bits."""

from __future__ import annotations

import ctypes
from typing import TYPE_CHECKING

import numpy as np

from ..records import dataclass
from . import loops
from .calls import address, call

if TYPE_CHECKING:
    from .backend import Machine


def outlines(
    machine: Machine, points: np.ndarray, valid: np.ndarray, few: int, ways: np.ndarray, near: float, well: float
) -> tuple[np.ndarray, np.ndarray]:
    """Corners (n, 2) of the hulls of points (M, K, 2) where ``valid`` (M, K), one hull after the other, and how many each has (M,): nan for
    a set without points. Of more than ``few`` points what lies ``well`` inside those outermost along ``ways`` (w, 2) is left out first."""
    sets, each = valid.shape
    count, room = np.empty(sets, dtype=np.int64), np.empty(6 * each)
    found = np.empty((int(np.count_nonzero(valid)) + 2 * sets, 2))
    angle, data = loops.loop(np.arctan2, "dd->d")
    given = np.ascontiguousarray(points), np.ascontiguousarray(valid), few, len(ways), ways, near, well
    call(
        machine.library.outlines, sets, each, *given, ctypes.c_void_p(angle), ctypes.c_void_p(data), room, count, found
    )
    return found[: int(count.sum())], count


@dataclass(frozen=True, slots=True, eq=False)
class Standing:
    """Objects (B,): centre (B, 3), floor, mass and what nested joints may move of it, kg m; joints in the order of their objects, ``owner``
    (J,) each, and what each moves the centre by in some states (J, S, 3)."""

    center: np.ndarray
    floor: np.ndarray
    total: np.ndarray
    spare: np.ndarray
    owner: np.ndarray
    values: np.ndarray


@dataclass(frozen=True, slots=True, eq=False)
class Overlaps:
    """Overlaps (n,) of objects ``owner``: of which primitive each is and what that weighs; the box at rest, middle and half of it (n, 3), the
    ball about what moves, middle (n, 3) and radius, and whether it rests; what may be lost at most, and what the box would hold, kg."""

    owner: np.ndarray
    row: np.ndarray
    own: np.ndarray
    place: np.ndarray
    half: np.ndarray
    ball: np.ndarray
    radius: np.ndarray
    rests: np.ndarray
    most: np.ndarray
    full: np.ndarray


class _Standing(ctypes.Structure):
    _names = ("center", "floor", "total", "spare", "begin", "order", "first", "turn", "steps", "values")
    _fields_ = [(name, ctypes.c_int64 if name == "steps" else ctypes.c_void_p) for name in _names]


class _Overlaps(ctypes.Structure):
    _fields_ = [(name, ctypes.c_void_p) for name in Overlaps.__slots__[1:]]


def over_edges(
    machine: Machine,
    edges: tuple[np.ndarray, np.ndarray, np.ndarray],
    them: Standing,
    over: Overlaps,
    numbers: tuple[float, float, float, float],
    found: tuple[np.ndarray, np.ndarray],
) -> None:
    """Of edges, their objects (n,), a place on each and the way inwards (n, 2): enter into ``found`` (B,) bool, (B,) bool which objects do not
    stand for certain, and which tip over. ``numbers``: the tangent of the tilt and what ``validity.stance`` calls steep, sampled, rounding."""
    count = len(them.total)
    own = [np.ascontiguousarray(getattr(over, name)) for name in Overlaps.__slots__]
    objects = [np.ascontiguousarray(getattr(them, name)) for name in Standing.__slots__]
    order, turn = np.argsort(over.owner, kind="stable"), np.argsort(them.owner, kind="stable")
    begin, first = (np.cumsum([0, *np.bincount(column, minlength=count)]) for column in (over.owner, them.owner))
    columns = [*objects[:4], begin, order, first, turn]
    told = _Standing(*(address(column) for column in columns), them.values.shape[1], address(objects[5]))
    where = (np.ascontiguousarray(column) for column in edges)
    call(
        machine.library.over_edges,
        len(edges[0]),
        *where,
        told,
        _Overlaps(*(address(o) for o in own[1:])),
        *numbers,
        *found,
    )
