"""Tuples of arrays in the older form of ``torch.save``, which ``torch.load`` reads, written without torch.

Such a file is five pickles in a row: a number that marks it, the version of the form, sizes of the machine's numbers, what was saved,
and the keys of its tensors. Arrays are pickled by the name ``numpy.ndarray`` alone: what NumPy pickles by itself names ``numpy._core``
from version 2 on, which readers under NumPy 1 do not have.
"""

from __future__ import annotations

import io
import pickle
from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np

from ..errors import UserError

_MARK, _VERSION = 0x1950A86A20F9469CFC6C, 1001
_SYSTEM = {"protocol_version": _VERSION, "little_endian": True, "type_sizes": {"short": 2, "int": 4, "long": 4}}
_KNOWN = {("numpy", "ndarray"): np.ndarray, ("builtins", "bytearray"): bytearray}


class _Pickler(pickle.Pickler):
    def reducer_override(self, value: Any) -> Any:
        if isinstance(value, np.ndarray):
            return np.ndarray, (value.shape, value.dtype.str, bytearray(value.tobytes()))
        return NotImplemented


class _Unpickler(pickle.Unpickler):
    """Reads arrays and plain data, and nothing that runs code."""

    def find_class(self, module: str, name: str) -> Any:
        if (module, name) not in _KNOWN:
            raise pickle.UnpicklingError(f"it names {module}.{name}")
        return _KNOWN[module, name]


def plain_pickle(value: Any) -> bytes:
    """A pickle of plain data and arrays that readers under any version of NumPy load."""
    stream = io.BytesIO()
    _Pickler(stream, 3).dump(value)
    return stream.getvalue()


def read_plain_pickle(path: Path) -> Any:
    """What a file of ``plain_pickle`` holds. Raises UserError for one that names more than arrays."""
    with open(path, "rb") as stream:
        try:
            return _Unpickler(stream).load()
        except (pickle.UnpicklingError, EOFError, TypeError, ValueError, AttributeError) as wrong:
            raise UserError(f"{path} is not plain data: {wrong}", "write the folder again with --force") from None


def pth_bytes(arrays: Sequence[np.ndarray]) -> bytes:
    """The bytes of a file that holds a tuple of arrays."""
    stream = io.BytesIO()
    parts: list[Any] = [_MARK, _VERSION, _SYSTEM, tuple(np.ascontiguousarray(array) for array in arrays), []]
    for part in parts:
        _Pickler(stream, 3).dump(part)
    return stream.getvalue()


def read_pth(path: Path) -> tuple[np.ndarray, ...]:
    """The arrays of a file. Raises UserError for one that names more than arrays."""
    with open(path, "rb") as stream:
        try:
            mark, version, _, held, _ = (_Unpickler(stream).load() for _ in range(5))
        except (pickle.UnpicklingError, EOFError, TypeError, ValueError, AttributeError) as wrong:
            raise UserError(f"{path} is not a file of arrays: {wrong}", "write the folder again with --force") from None
    if (mark, version) != (_MARK, _VERSION) or not isinstance(held, tuple):
        raise UserError(f"{path} is not a file of arrays", "write the folder again with --force")
    return held
