"""Arguments of the Python interface: whole numbers, numbers in a range, yes or no; of Python's types or of NumPy's."""

from __future__ import annotations

from numbers import Integral, Real
from typing import Any

import numpy as np

from .errors import UsageError


def read_whole(name: str, value: Any, least: int | None = None) -> int:
    """A whole number, from ``least`` on where that is given. Raises UsageError."""
    if not isinstance(value, Integral) or isinstance(value, bool):
        raise UsageError(f"{name} is {value!r}: a whole number is needed")
    number = int(value)
    if least is not None and number < least:
        raise UsageError(f"{name} is {number}", f"give a whole number from {least}")
    return number


def read_amount(name: str, value: Any, least: float = 0.0, most: float = np.inf) -> float:
    """A finite number from ``least`` to ``most``. Raises UsageError."""
    if not isinstance(value, Real) or isinstance(value, bool):
        raise UsageError(f"{name} is {value!r}: a number is needed")
    number = float(value)
    if not (least <= number <= most and np.isfinite(number)):
        low = f" from {least:g}" if least > -np.inf else ""
        high = f" to {most:g}" if most < np.inf else ""
        raise UsageError(f"{name} is {value}", f"give a number{low}{high}" if low or high else "give a finite number")
    return number


def read_flag(name: str, value: Any) -> bool:
    """Yes or no: text is neither, whatever it says. Raises UsageError."""
    if not isinstance(value, bool | np.bool_):
        raise UsageError(f"{name} is {value!r}", "give True or False")
    return bool(value)
