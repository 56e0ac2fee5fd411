"""How far hulls reach from their pieces, by compiled code: what ``geometry.merge`` computes, with the same bits."""

from __future__ import annotations

import ctypes
from collections.abc import Sequence
from itertools import chain
from typing import TYPE_CHECKING

import numpy as np

from .calls import call

if TYPE_CHECKING:
    from .backend import Machine


class Stock:
    """Convex pieces one after the other: corners (P, 3) of each, outward normals (F, 3) and offsets (F,) of its faces."""

    def __init__(self, points: Sequence[np.ndarray], normals: Sequence[np.ndarray], offsets: Sequence[np.ndarray]):
        arrays = [np.ascontiguousarray(np.concatenate(a), dtype=np.float64) for a in (points, normals, offsets)]
        starts = [np.cumsum([0, *map(len, some)], dtype=np.int64) for some in (points, offsets)]
        self._kept = (arrays[0], starts[0], arrays[1], arrays[2], starts[1])
        self.known: dict[tuple[int, ...], tuple[float, int]] = {}  # what was asked about them
        self.places = [ctypes.c_void_p(a.ctypes.data) for a in self._kept]


def deepest(
    machine: Machine, stock: Stock, clusters: Sequence[Sequence[int]], ways: np.ndarray
) -> list[tuple[float, int]]:
    """How far the hulls of clusters of pieces, told by their numbers, reach where they do most, and the nearest face there, counted
    over the pieces of a cluster. ``ways`` (w, 3), up to 64: what extreme points are extreme along."""
    start = np.cumsum([0, *map(len, clusters)], dtype=np.int64)
    pieces = np.fromiter(chain.from_iterable(clusters), np.int64, int(start[-1]))
    depth, face = np.empty(len(clusters)), np.empty(len(clusters), dtype=np.int64)
    call(machine.library.deepest, len(clusters), start, pieces, *stock.places, len(ways), ways, depth, face)
    return list(zip(depth.tolist(), face.tolist(), strict=True))
