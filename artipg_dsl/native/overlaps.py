"""Points of boxes in which primitives may overlap, by compiled code: what ``geometry.overlap`` computes, with the same bits."""

from __future__ import annotations

import ctypes
from typing import TYPE_CHECKING

import numpy as np

from . import loops
from .calls import call

if TYPE_CHECKING:
    from .backend import Machine

_ADD = "dd->d"
# of R rows by columns: rotation (9, R), translation (3, R), mirror (R,)
_Poses = tuple[np.ndarray, np.ndarray, np.ndarray]
_Points = tuple[np.ndarray, np.ndarray, np.ndarray]  # (n, count) each


def place_shares(
    machine: Machine, poses: _Poses, frame: np.ndarray, low: np.ndarray, size: np.ndarray, share: np.ndarray
) -> _Points:
    """Fractions (3, count) of boxes ``low``, ``size`` (3, n) in the frames (n,) of rows, as points (n, count) of the object."""
    n, count = len(frame), share.shape[1]
    out = np.empty((3, n, count))
    given = (np.ascontiguousarray(array) for array in (share, low, size, frame))
    call(machine.library.place_shares, n, count, len(poses[2]), *given, *poses, out)
    return out[0], out[1], out[2]


def local_points(
    machine: Machine, poses: _Poses, points: _Points, asked: np.ndarray, at: np.ndarray, frame: np.ndarray, width: int
) -> tuple[_Points, np.ndarray]:
    """The points of the pairs ``at`` (k,) that are ``asked`` (n, count), at least one of each and at most ``width``, in the frames (k,)
    of rows, (k, width) each, and which they are (k, width); where a pair has fewer, the last comes again, and where ``width`` is all,
    all are there."""
    out, picked = np.empty((3, len(at), width)), np.empty((len(at), width), dtype=np.int64)
    given = (*points, asked, np.ascontiguousarray(at), np.ascontiguousarray(frame))
    call(machine.library.local_points, len(at), asked.shape[1], width, len(poses[2]), *given, *poses, out, picked)
    return (out[0], out[1], out[2]), picked


def held_moments(
    machine: Machine, held: np.ndarray, points: _Points, inertia: bool
) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Of points (n, count) that are ``held``: how many there are (n,), their mean (n, 3) and, for ``inertia``, the means of the products of
    any two coordinates from there (n, 3, 3), noughts where all are held, or none."""
    n, count = held.shape
    many, mean, spread = np.empty(n, dtype=np.int64), np.zeros((n, 3)), np.zeros((n, 3, 3))
    add, data = loops.loop(np.add, _ADD)
    adding = ctypes.c_void_p(add), ctypes.c_void_p(data), np.empty(4 * count)
    call(machine.library.held_moments, n, count, inertia, held, *points, *adding, many, mean, spread)
    return many, mean, spread
