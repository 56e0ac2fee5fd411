"""How far hulls reach from their pieces, by compiled code: what ``geometry.merge`` computes, with the same bits."""

from __future__ import annotations

import ctypes
from array import array
from collections.abc import Sequence
from typing import TYPE_CHECKING

import numpy as np

if TYPE_CHECKING:
    from .backend import Machine


class Stock:
    """Convex pieces one after the other: corners (P, 3) of each, outward normals (F, 3) and offsets (F,) of its faces."""

    def __init__(self, points: Sequence[np.ndarray], normals: Sequence[np.ndarray], offsets: Sequence[np.ndarray]):
        arrays = [np.ascontiguousarray(np.concatenate(a), dtype=np.float64) for a in (points, normals, offsets)]
        starts = [np.cumsum([0, *map(len, some)], dtype=np.int64) for some in (points, offsets)]
        self._kept = (arrays[0], starts[0], arrays[1], arrays[2], starts[1])
        self.known: dict[tuple[int, ...], tuple[float, int]] = {}  # what was asked about some of them
        self.places = [a.ctypes.data for a in self._kept]


def deepest(machine: Machine, stock: Stock, pieces: Sequence[int], ways: np.ndarray) -> tuple[float, int]:
    """How far the hull of pieces, told by their numbers, reaches where it does most, and the nearest face there, counted
    over them. ``ways`` (w, 3), up to 64: what extreme points are extreme along."""
    numbers, depth = array("q", pieces), ctypes.c_double()
    place, _ = numbers.buffer_info()
    face = machine.deepest(len(pieces), place, *stock.places, len(ways), ways.ctypes.data, ctypes.byref(depth))
    return depth.value, face
