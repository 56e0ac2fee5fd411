"""The inner loops of NumPy's functions, read from its function objects, and how an array lies in memory.

Both are public and stable parts of NumPy's C interface (``ndarraytypes.h``, ``ufuncobject.h``). Still, what is read is compared
with what Python knows of the same objects before any of it is used.
"""

from __future__ import annotations

import ctypes
from collections.abc import Mapping
from functools import cache

import numpy as np

HEADER = object.__basicsize__  # bytes of a Python object before its own fields


class Unreadable(Exception):
    """This NumPy is laid out in another way."""


class _Function(ctypes.Structure):
    _fields_ = [
        ("inputs", ctypes.c_int),
        ("outputs", ctypes.c_int),
        ("arguments", ctypes.c_int),
        ("identity", ctypes.c_int),
        ("functions", ctypes.POINTER(ctypes.c_void_p)),
        ("data", ctypes.POINTER(ctypes.c_void_p)),
        ("count", ctypes.c_int),
        ("reserved", ctypes.c_int),
        ("name", ctypes.c_char_p),
        ("types", ctypes.POINTER(ctypes.c_char)),
    ]


# what each operation is called in NumPy; ``where`` is none of its functions and comes with the machine
FUNCTIONS: Mapping[str, np.ufunc] = {
    "add": np.add,
    "sub": np.subtract,
    "mul": np.multiply,
    "div": np.divide,
    "neg": np.negative,
    "pow": np.power,
    "abs": np.absolute,
    "sqrt": np.sqrt,
    "sin": np.sin,
    "cos": np.cos,
    "tan": np.tan,
    "asin": np.arcsin,
    "acos": np.arccos,
    "atan": np.arctan,
    "atan2": np.arctan2,
    "hypot": np.hypot,
    "exp": np.exp,
    "log": np.log,
    "floor": np.floor,
    "ceil": np.ceil,
    "sign": np.sign,
    "min": np.minimum,
    "max": np.maximum,
    "mod": np.remainder,
    "lt": np.less,
    "le": np.less_equal,
    "eq": np.equal,
    "ne": np.not_equal,
    "and": np.logical_and,
    "or": np.logical_or,
    "not": np.logical_not,
}


@cache
def loop(function: np.ufunc, kinds: str) -> tuple[int, int]:
    """The addresses of the loop of a function for the types ``kinds``, such as ``dd->d``, and of what it is given.
    Raises Unreadable."""
    seen = _Function.from_address(id(function) + HEADER)
    stated = (function.nin, function.nout, function.nargs, function.ntypes)
    if (seen.inputs, seen.outputs, seen.arguments, seen.count) != stated or kinds not in function.types:
        raise Unreadable(function.__name__)
    codes = ctypes.string_at(seen.types, function.ntypes * function.nargs)
    for number in range(function.ntypes):
        mine = codes[number * function.nargs : (number + 1) * function.nargs]
        if bytes(np.dtype(c).num for c in kinds.replace("->", "")) == mine:
            data = seen.data[number] if seen.data else None
            address = seen.functions[number]
            if address:
                return address, data or 0
    raise Unreadable(function.__name__)
