"""Sums of quadrature by compiled code: what ``geometry.quadrature`` adds up, with the same bits."""

from __future__ import annotations

import ctypes
from collections.abc import Sequence
from typing import TYPE_CHECKING

import numpy as np

from . import loops
from .calls import address, call, integers

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
    strides = integers(12)(*[step for array in arrays for step in _strides(array)])
    places = integers(6)(*[address(array) for array in arrays])
    add, data = loops.loop(np.add, _ADD)
    weight, rows = np.ascontiguousarray(weight), np.ascontiguousarray(rows, dtype=np.int64)
    middle = np.ascontiguousarray(middle)
    adding = ctypes.c_void_p(add), ctypes.c_void_p(data), np.empty(7 * many)
    given = (places, strides, weight, rows, middle)
    call(machine.library.add_moments, count, many, inertia, *given, *adding, *moments)


def _strides(array: np.ndarray) -> tuple[int, int]:
    """Bytes from row to row and from place to place of what broadcasts to rows by places."""
    shape, strides = (1, 1, *array.shape)[-2:], (0, 0, *array.strides)[-2:]
    return strides[0] if shape[0] > 1 else 0, strides[1] if shape[1] > 1 else 0


def row_sums(machine: Machine, values: np.ndarray) -> np.ndarray:
    """Sums (k,) of rows (k, n), as the quadrature makes them."""
    found = np.empty(len(values))
    add, data = loops.loop(np.add, _ADD)
    adding = ctypes.c_void_p(add), ctypes.c_void_p(data)
    call(machine.library.row_sums, *values.shape, *adding, values, found)
    return found
