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
    """Convex pieces one after the other: corners (P, 3) of each, outward normals (F, 3) and offsets (F,) of its faces.

    ``enough``: how far a hull reaches that reaches too far whatever is asked, metres.
    """

    def __init__(
        self,
        points: Sequence[np.ndarray],
        normals: Sequence[np.ndarray],
        offsets: Sequence[np.ndarray],
        enough: float = np.inf,
    ):
        arrays = [np.ascontiguousarray(np.concatenate(a), dtype=np.float64) for a in (points, normals, offsets)]
        starts = [np.cumsum([0, *map(len, some)], dtype=np.int64) for some in (points, offsets)]
        self._kept = (arrays[0], starts[0], arrays[1], arrays[2], starts[1])
        self.enough = enough
        self.known: dict[tuple[int, ...], tuple[float, int]] = {}  # what was asked about some of them
        self.bounded: dict[tuple[int, ...], float] = {}  # and of which no more is known than that it is enough
        self.places = [a.ctypes.data for a in self._kept]


def deepest(
    machine: Machine, stock: Stock, pieces: Sequence[int], ways: np.ndarray, enough: float = np.inf
) -> tuple[float, int]:
    """How far the hull of pieces, told by their numbers, reaches where it does most, and the nearest face there, counted
    over them. ``ways`` (w, 3), up to 64: what extreme points are extreme along. Where it reaches farther than ``enough``, so it is told."""
    numbers, depth = array("q", pieces), ctypes.c_double()
    place, _ = numbers.buffer_info()
    way, _ = ways.__array_interface__["data"]
    face = machine.deepest(len(pieces), place, *stock.places, len(ways), way, enough, ctypes.byref(depth))
    return depth.value, face
