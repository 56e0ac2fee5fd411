"""How far hulls reach from their pieces, by compiled code: what ``geometry.merge`` computes, with the same bits.

``places`` are the addresses of what a stock of pieces holds: corners, where those of each begin, outward normals and offsets of its
faces, where those of each begin. ``ways`` (w, 3), up to 64: what extreme points are extreme along. Pieces are told by their numbers.
"""

from __future__ import annotations

import ctypes
from typing import TYPE_CHECKING

import numpy as np

from .calls import address

if TYPE_CHECKING:
    from .backend import Machine

Places = tuple[int, int, int, int, int]


def deepest(machine: Machine, places: Places, pieces: np.ndarray, ways: np.ndarray) -> tuple[float, int]:
    """How far the hull of pieces (n,) reaches where it does most, and the nearest face there, counted over them."""
    depth, pieces = ctypes.c_double(), np.ascontiguousarray(pieces)
    face = machine.deepest(*places, len(ways), address(ways), address(pieces), len(pieces), ctypes.byref(depth))
    return depth.value, face


def cluster(
    machine: Machine,
    places: Places,
    pieces: np.ndarray,
    unit: np.ndarray,
    name: np.ndarray,
    sectors: np.ndarray,
    ways: np.ndarray,
    tolerance: float,
) -> np.ndarray:
    """Which cluster (n,) each of ``pieces`` (n,) is of, which are in order of ``unit``, ``name`` (n,) and index; ``sectors`` (k,) is how
    many there may be around an axis, ascending."""
    pieces, unit, name = (np.ascontiguousarray(column) for column in (pieces, unit, name))
    count = len(pieces)
    room, found = np.empty(6 * count + 1, dtype=np.int64), np.empty(count, dtype=np.int64)
    units = count, address(unit), address(name), len(sectors), address(sectors)
    given = (*places, len(ways), address(ways), tolerance, address(pieces))
    machine.cluster(*given, *units, address(room), address(found))
    return found


def chain(
    machine: Machine,
    places: Places,
    pieces: np.ndarray,
    begin: np.ndarray,
    end: np.ndarray,
    ways: np.ndarray,
    tolerance: float,
) -> np.ndarray:
    """Which cluster (k,) each part is of: parts one after the other, put together as long as the hull of all reaches no farther."""
    pieces, begin, end = (np.ascontiguousarray(column) for column in (pieces, begin, end))
    found, row = np.empty(len(begin), dtype=np.int64), np.empty(int((end - begin).sum()), dtype=np.int64)
    parts = address(pieces), len(begin), address(begin), address(end)
    machine.chain(*places, len(ways), address(ways), tolerance, *parts, address(row), address(found))
    return found
