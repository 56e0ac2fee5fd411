"""Sums of quadrature by compiled code: what ``geometry.quadrature`` adds up, with the same bits."""

from __future__ import annotations

import ctypes
from collections.abc import Sequence
from typing import TYPE_CHECKING

import numpy as np

from . import loops
from .narrow import address

if TYPE_CHECKING:
    from .backend import Machine

_ADD = "dd->d"


def add_moments(
    machine: Machine,
    terms: Sequence[np.ndarray | float],
    weight: np.ndarray,
    rows: np.ndarray,
    middle: np.ndarray,
    moments: tuple[np.ndarray, np.ndarray, np.ndarray],
    inertia: bool,
) -> None:
    """Add to volume (K,), first (K, 3) and, for ``inertia``, second moments (K, 3, 3) of the instances ``rows`` (k,) about ``middle``
    (K, 3) what a patch gives at n places: ``terms``, position and du x dv, of shapes that broadcast to (k, n), by ``weight`` (n,)."""
    count, many = len(rows), len(weight)
    arrays = [np.asarray(term, dtype=np.float64) for term in terms]
    strides = (ctypes.c_int64 * 12)(*[step for array in arrays for step in _strides(array)])
    places = (ctypes.c_void_p * 6)(*[array.ctypes.data for array in arrays])
    add, data = loops.loop(np.add, _ADD)
    weight, rows = np.ascontiguousarray(weight), np.ascontiguousarray(rows, dtype=np.int64)
    middle = np.ascontiguousarray(middle)
    room, long = np.empty(7 * many), ctypes.c_int64
    machine.library.add_moments(
        long(count), long(many), long(inertia), places, strides, address(weight), address(rows), address(middle),
        ctypes.c_void_p(add), ctypes.c_void_p(data), address(room), *[address(column) for column in moments],
    )  # fmt: skip


def _strides(array: np.ndarray) -> tuple[int, int]:
    """Bytes from row to row and from place to place of what broadcasts to rows by places."""
    shape, strides = (1, 1, *array.shape)[-2:], (0, 0, *array.strides)[-2:]
    return strides[0] if shape[0] > 1 else 0, strides[1] if shape[1] > 1 else 0


def row_sums(machine: Machine, values: np.ndarray) -> np.ndarray:
    """Sums (k,) of rows (k, n), as the quadrature makes them."""
    found = np.empty(len(values))
    add, data = loops.loop(np.add, _ADD)
    machine.library.row_sums(
        ctypes.c_int64(len(values)), ctypes.c_int64(values.shape[1]), ctypes.c_void_p(add), ctypes.c_void_p(data),
        address(values), address(found),
    )  # fmt: skip
    return found
