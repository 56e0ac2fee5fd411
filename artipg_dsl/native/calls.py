"""Calls of compiled code: what is handed over, as C takes it."""

from __future__ import annotations

import ctypes
from collections.abc import Callable
from functools import lru_cache
from typing import Any

import numpy as np

from .loops import HEADER

_POINTER = ctypes.c_ssize_t.from_address


def address(array: np.ndarray) -> int:
    """Where the numbers of an array lie, which ``array.ctypes.data`` takes ten times as long to say. It is the first field of an array:
    there is no machine where that is not so (see ``backend``)."""
    return _POINTER(id(array) + HEADER).value


def call(function: Callable[..., Any], *values: object) -> Any:
    """What ``function`` of a loaded library returns for ``values``: integers of 64 bits, doubles, arrays and structures by their
    addresses; what ctypes knows already, and text, as it is. The arrays lie in memory row by row, with the types that the code expects;
    for others, of which it would read what is beside them, TypeError."""
    return function(*[_passed(value) for value in values])  # of a map, tuples are left over for each call


@lru_cache(maxsize=256)
def integers(count: int) -> type[ctypes.Array[ctypes.c_int64]]:
    """The type of so many integers of 64 bits. ctypes makes it anew, and leaves it to the garbage, where nobody holds it."""
    return ctypes.c_int64 * count


def _passed(value: object) -> object:
    match value:
        case np.ndarray():
            if value.dtype.char in "fe" or not value.flags.c_contiguous:
                raise TypeError(
                    f"compiled code takes float64 row by row, not {value.dtype} with strides {value.strides}"
                )
            return ctypes.c_void_p(address(value))
        case bool() | int():
            return ctypes.c_int64(value)
        case float():
            return ctypes.c_double(value)
        case ctypes.Structure():
            return ctypes.byref(value)
    return value
