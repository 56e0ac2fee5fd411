"""Pictures of objects, and which rays leave them, by compiled code: what ``geometry.outside`` computes, with the same bits."""

from __future__ import annotations

import ctypes
from typing import TYPE_CHECKING

import numpy as np

from .calls import address, call

if TYPE_CHECKING:
    from .backend import Machine


class _Triangles(ctypes.Structure):
    _fields_ = [*((name, ctypes.c_void_p) for name in ("face", "cell", "ends", "normal")), ("count", ctypes.c_int64)]


class _Picture(ctypes.Structure):
    _fields_ = [
        *((name, ctypes.c_void_p) for name in ("vertex", "flat", "bins", "frame", "scale")),
        *((name, ctypes.c_int64) for name in ("vertices", "objects", "wide")),
    ]


class _Rays(ctypes.Structure):
    _fields_ = [*((name, ctypes.c_void_p) for name in ("point", "bin", "own")), ("count", ctypes.c_int64)]


def free(
    machine: Machine,
    triangles: tuple[np.ndarray, np.ndarray, np.ndarray, np.ndarray],
    picture: tuple[np.ndarray, np.ndarray, np.ndarray, np.ndarray, np.ndarray],
    wide: int,
    rays: tuple[np.ndarray, np.ndarray, np.ndarray | None],
    there: np.ndarray,
    edge: float,
) -> np.ndarray:
    """(m,) bool: whether rays enter none of T triangles; of points with cells, whether they leave none from behind but those of their own.

    ``triangles``: face (3, T), cell (T,), where those of each object end (objects + 1,), normal (3, T). ``picture``: vertex (3, V), flat
    (2, V), bins (2, V) int16 of ``wide`` each way, frame (3, 3), scale (2, objects). ``rays``: points by the axes of the frame (3, m), the
    bins of all objects in which they lie (m,), their cells (m,) or None. ``there`` (objects,): which objects have rays.
    """
    (point, place, own), (objects, m) = rays, (len(there), len(rays[1]))
    out = np.ones(m, dtype=bool)
    begin, order = np.zeros(objects * wide * wide + 1, dtype=np.int64), np.empty(m, dtype=np.int64)
    held = [*triangles, *picture, point, place]  # until the call is over
    if not all(array.flags.c_contiguous for array in held):
        raise TypeError("compiled code takes arrays row by row")
    some = _Triangles(*(address(array) for array in triangles), triangles[0].shape[1])
    seen = _Picture(*(address(array) for array in picture), picture[0].shape[1], objects, wide)
    told = _Rays(address(point), address(place), None if own is None else address(own), m)
    call(machine.library.leave, some, seen, told, there, edge, begin, order, out)
    return out


def lay_flat(
    machine: Machine,
    vertex: np.ndarray,
    many: np.ndarray,
    there: np.ndarray,
    axes: np.ndarray,
    origin: np.ndarray,
    scale: np.ndarray,
    wide: int,
    flat: np.ndarray,
    bins: np.ndarray,
) -> None:
    """Write where vertices (3, V) lie by two ``axes`` (2, 3), ``flat`` (2, V), and their bins (2, V) int16, of ``wide`` each way.

    Pictures of objects, which have ``many`` (objects,) vertices each, begin at ``origin`` (2, objects), with ``scale`` (2, objects) bins a
    metre. Of objects that are not ``there`` (objects,) nothing is written."""
    pictures = len(many), there, axes, origin, scale, wide
    call(machine.library.lay_flat, vertex, vertex.shape[1], many, *pictures, flat, bins)
