"""Points on surfaces, drawn by compiled code: what ``geometry.points``, ``geometry.cover`` and ``geometry.hidden`` compute."""

from __future__ import annotations

import ctypes
from collections.abc import Sequence
from typing import TYPE_CHECKING

import numpy as np

from .calls import address, call

if TYPE_CHECKING:
    from .backend import Machine

_ROOM = 8  # rows that meet a row, for which there is room at first
Three = tuple[np.ndarray, np.ndarray, np.ndarray]


class _Pairs(ctypes.Structure):
    _fields_ = [(name, ctypes.c_void_p) for name in ("quad", "least", "most", "planar")]


class _Rows(ctypes.Structure):
    _fields_ = [(name, ctypes.c_void_p) for name in ("rotation", "translation", "mirror", "low", "high")]


class _Surfaces(ctypes.Structure):
    _fields_ = [
        (name, ctypes.c_void_p)
        for name in ("origin", "a", "b", "c", "normal", "shape", "row", "patch", "site", "table_row")
    ]


class _Bent(ctypes.Structure):
    _fields_ = [(name, ctypes.c_void_p) for name in ("at", "place", "normal")]


class _Places(ctypes.Structure):
    _fields_ = [(name, ctypes.c_void_p) for name in ("site", "row", "patch", "u", "v", "position", "normal")]


class _Frames(ctypes.Structure):
    _fields_ = [(name, ctypes.c_void_p) for name in ("turn", "shift", "mirror", "center")]


def coarse(machine: Machine, stream: np.ndarray, lane: np.ndarray, count: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Two numbers for each lane: of streams (n,) uint64 ``count`` (n,) from ``lane`` (n,) on."""
    u, v = np.empty((2, int(count.sum())))
    given = [np.ascontiguousarray(lane, dtype=np.int64), np.ascontiguousarray(count, dtype=np.int64)]
    call(machine.library.coarse, len(stream), np.ascontiguousarray(stream, dtype=np.uint64), *given, u, v)
    return u, v


def near_rows(
    machine: Machine,
    start: np.ndarray,
    count: np.ndarray,
    order: np.ndarray,
    low: np.ndarray,
    high: np.ndarray,
    asked: np.ndarray,
) -> tuple[np.ndarray, np.ndarray]:
    """Pairs of different rows whose boxes ``low`` .. ``high`` (R, 3) meet, of which the first is ``asked`` (R,) bool: those of the objects,
    which have ``count`` (B,) of the rows in their ``order`` (R,) from ``start`` (B,) on."""
    given = [np.ascontiguousarray(array, dtype=np.int64) for array in (start, count, order)]
    boxes = [np.ascontiguousarray(end) for end in (low, high)]
    asked, room = np.ascontiguousarray(asked, dtype=np.bool_), _ROOM * len(order)
    while True:
        found = np.empty((2, room), dtype=np.int64)
        known = call(machine.library.near_rows, len(start), *given, *boxes, asked, room, found[0], found[1])
        if known <= room:
            return found[0, :known], found[1, :known]
        room = known


def near_flat(
    machine: Machine,
    asked: np.ndarray,
    start: np.ndarray,
    count: np.ndarray,
    candidates: Three,
    quad: np.ndarray,
    ends: tuple[np.ndarray, np.ndarray],
    planar: np.ndarray,
) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Of pairs (n,), each with a run of candidates, told by fractions and these packed (m,): which pair and which candidate (k,) are
    within the packed ``ends`` (P,) of the pair, and where its ``quad`` (4, 3, P) has them (3, k)."""
    room = int(count.sum())
    pair, point = np.empty((2, room), dtype=np.int64)
    local = np.empty((3, room))
    told = _Pairs(address(quad), *(address(end) for end in ends), address(planar))
    runs = (np.ascontiguousarray(array, dtype=np.int64) for array in (asked, start, count))
    found = call(machine.library.near_flat, len(asked), *runs, *candidates, len(planar), told, room, pair, point, local)
    return pair[:found], point[:found], local[:, :found]


def near_loose(
    machine: Machine,
    asked: np.ndarray,
    start: np.ndarray,
    count: np.ndarray,
    others: np.ndarray,
    place: np.ndarray,
    poses: Three,
    boxes: tuple[np.ndarray, np.ndarray],
) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Of points (n,), those of ``place`` (3, m) that are ``asked``, each with a run of ``others``: rows and points (k,) that lie in the
    boxes (3, R) of the rows, and where in their frames (3, k)."""
    room = int(count.sum())
    other, point = np.empty((2, room), dtype=np.int64)
    local = np.empty((3, room))
    told = _Rows(*(address(array) for array in (*poses, *boxes)))
    runs = [np.ascontiguousarray(array, dtype=np.int64) for array in (asked, start, count, others)]
    sizes = (place.shape[1], place, len(poses[2]), told, room)
    found = call(machine.library.near_loose, len(asked), *runs, *sizes, other, point, local)
    return other[:found], point[:found], local[:, :found]


def keep(
    machine: Machine,
    pools: Sequence[np.ndarray],
    candidates: Three,
    begin: int,
    count: np.ndarray,
    surfaces: Sequence[np.ndarray],
    flat: int,
    loose: Three,
    place: np.ndarray | None,
    out: Sequence[np.ndarray],
) -> None:
    """Write those candidates that are seen, thinned evenly where there are more than there is room for.

    ``pools`` (n,): how many candidates each has, how many of them are seen, how many there is room for, the shift of the thinning, and
    where the first one goes. ``candidates`` (m,): whether they are hidden, and their fractions, in the order of their cells, of which
    each from the cell ``begin`` on has ``count``. ``surfaces``: quads and normals (3, C) of cells, their shapes, of which one, ``flat``,
    has a last vector, their rows and patches (C,), and sites and table rows of the rows. ``loose``: which candidates (k,) are not on
    the quads of their cells, and their places and normals (3, k). ``out``: site, row, patch, u, v, position and normal of points, which go one
    after the other, or where ``place`` has these places.
    """
    numbers = [np.ascontiguousarray(array, dtype=np.int64) for array in (*pools, count)]
    bent = [np.ascontiguousarray(array) for array in loose]
    cells = _Surfaces(*(address(array) for array in surfaces))
    others, into = (kind(*(address(array) for array in arrays)) for kind, arrays in ((_Bent, bent), (_Places, out)))
    each, size = numbers.pop(), surfaces[0].shape[1]
    given = (*candidates, begin, each, size, flat, cells, len(bent[0]), others, place, into)
    call(machine.library.keep_points, len(numbers[0]), *numbers, *given)


def in_frames(
    machine: Machine,
    vectors: np.ndarray,
    at: np.ndarray,
    row: np.ndarray,
    frames: tuple[np.ndarray, np.ndarray | None, np.ndarray, np.ndarray | None],
    axes: Sequence[int],
) -> list[np.ndarray]:
    """Of vectors (m, 3) those ``at`` (n,), each in the frame of its ``row`` (n,): the coordinates along ``axes``, (n,) each.
    Frames by turns (9, R), which carry them to the object, shifts (3, R), mirrors (R,) and centres (3, R), which are taken off there."""
    out = [np.empty(len(at)) for _ in axes]  # small ones, for which there is memory at hand
    places = np.array([address(array) for array in out], dtype=np.int64)
    arrays = [None if array is None else np.ascontiguousarray(array, dtype=np.float64) for array in frames]
    told = _Frames(*(None if array is None else address(array) for array in arrays))
    where = (np.ascontiguousarray(array, dtype=np.int64) for array in (at, row))
    chosen = np.array(axes, dtype=np.int64)
    given = np.ascontiguousarray(vectors, dtype=np.float64)
    call(machine.library.in_frames, len(at), *where, given, len(frames[2]), told, len(axes), chosen, places)
    return out
