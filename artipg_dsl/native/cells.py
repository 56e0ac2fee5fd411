"""Two pieces and intervals of several joints, looked at by compiled code: what ``validity.together`` computes, with the same bits."""

from __future__ import annotations

import ctypes
from collections.abc import Sequence
from typing import TYPE_CHECKING

import numpy as np

from ..records import dataclass
from .calls import address, call
from .narrow import Side, told

if TYPE_CHECKING:
    from .backend import Machine

PLACES = 8  # of one joint, at most


@dataclass(frozen=True, slots=True, eq=False)
class Axes:
    """Joints (J,) at rest: unit axes (J, 3) and points on them (J, 3), metres for a radian, and which turn and which slide."""

    axis: np.ndarray
    origin: np.ndarray
    advance: np.ndarray
    turns: np.ndarray
    slides: np.ndarray


@dataclass(frozen=True, slots=True, eq=False)
class Intervals:
    """Cells (k,) with joints (k, C), -1 for none, those of the first piece in the first half of the columns: the middle of the interval
    of each and half of it, how far a corner moves for one unit; the pieces (k,), and boxes (N, 3) of all pieces at rest."""

    joint: np.ndarray
    middle: np.ndarray
    wide: np.ndarray
    radius: np.ndarray
    piece: np.ndarray
    other: np.ndarray
    low: np.ndarray
    high: np.ndarray


@dataclass(frozen=True, slots=True, eq=False)
class Examined:
    """Whether the pieces of cells (k,) meet in the middle; the unit direction (k, 3) that parts them there, its length before, and how far
    it parts them; how far each joint alone takes them towards one another (k, C), all those of either side at most (2, k), how far the
    piece of that side reaches that way (2, k), and of which side several joints move."""

    hit: np.ndarray
    away: np.ndarray
    length: np.ndarray
    between: np.ndarray
    loss: np.ndarray
    bounds: np.ndarray
    least: np.ndarray
    many: np.ndarray


class _Pointers(ctypes.Structure):
    _fields_ = [(f"at{place}", ctypes.c_void_p) for place in range(12)]


def _pointers(columns: Sequence[np.ndarray], *kinds: type) -> tuple[_Pointers, list[np.ndarray]]:
    """The addresses of some arrays, and these."""
    given: list[np.ndarray] = [np.ascontiguousarray(a, dtype=kind) for a, kind in zip(columns, kinds, strict=True)]
    return _Pointers(*[address(array) for array in given]), given


def _axes(axes: Axes) -> tuple[_Pointers, list[np.ndarray]]:
    columns = (axes.axis, axes.origin, axes.advance, axes.turns, axes.slides)
    return _pointers(columns, *[np.float64] * 3, *[np.bool_] * 2)


def examine(
    machine: Machine, first: Side, second: Side, axes: Axes, cells: Intervals, near: float, steps: int
) -> Examined | None:
    """What can be told of cells in their middle; None where there are more joints than the compiled code has room for."""
    count, columns = cells.joint.shape
    turns = (cells.joint >= 0) & np.append(axes.turns, False)[cells.joint]
    middle, wide = np.where(turns, cells.middle, 0.0), np.where(turns, np.minimum(cells.wide, np.pi), 0.0)
    places = (cells.joint, cells.piece, cells.other)
    angles = (cells.middle, cells.wide, np.cos(middle), np.sin(middle), np.cos(wide), np.sin(wide))
    sizes = (cells.radius, cells.low, cells.high)
    told_cells, held = _pointers((*places, *angles, *sizes), *[np.int64] * 3, *[np.float64] * 9)
    found = Examined(
        hit=np.empty(count, dtype=np.bool_),
        away=np.empty((count, 3)),
        length=np.empty(count),
        between=np.empty(count),
        loss=np.empty((count, columns)),
        bounds=np.empty((2, count)),
        least=np.empty((2, count)),
        many=np.empty((2, count), dtype=np.bool_),
    )
    (one, kept), (two, more), (told_axes, others) = told(first), told(second), _axes(axes)
    every = [getattr(found, name) for name in Examined.__slots__]
    examined = machine.library.examine_cells
    done = call(examined, count, columns, one, two, told_axes, told_cells, float(near), steps, *every)
    del held, kept, more, others  # were to live until here
    return found if done else None


def reach(
    machine: Machine,
    body: Side,
    axes: Axes,
    joint: np.ndarray,
    count: np.ndarray,
    angle: np.ndarray,
    wider: np.ndarray,
    slide: np.ndarray,
    ahead: np.ndarray,
) -> np.ndarray | None:
    """How far (k,) pieces reach along ``ahead`` (k, 3) when each of their joints (k, c) is at each of its ``count`` (k, c) places: turned
    by an ``angle``, put ``wider`` times as far out, and ``slide`` along the axis, (k, c, 8) each. None as of ``examine``."""
    found = np.empty(len(joint))
    one, held = told(body)
    told_axes, others = _axes(axes)
    numbers = (np.cos(angle), np.sin(angle), wider, slide, ahead)
    given = [np.ascontiguousarray(column, dtype=np.int64) for column in (joint, count)]
    given += [np.ascontiguousarray(column, dtype=np.float64) for column in numbers]
    done = call(machine.library.reach_of_cells, *joint.shape, one, told_axes, *given, found)
    del held, others  # were to live until here
    return found if done else None
