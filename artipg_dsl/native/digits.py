"""Rows of numbers as text, by compiled code where that is there: the bytes of Python's ``%``."""

from __future__ import annotations

from collections.abc import Sequence
from functools import lru_cache

import numpy as np

from . import backend
from .calls import call

_WIDTH = 24  # more than a number takes
_FEW = 12  # numbers below which Python is as fast
_FORMS = {"d": 0, "g": 1, "f": 2}


def print_rows(values: np.ndarray, form: str, marks: Sequence[str]) -> str:
    """Rows of numbers (n, k), each in the ``form`` ``%d``, ``%.9g`` or ``%.6f``; ``marks`` (k + 1,) is what stands before each
    column and after the last, ASCII."""
    found = _printed(values, form, tuple(marks)) if values.size >= _FEW else None
    if found is not None:
        return found.decode("ascii")
    plain = [mark.replace("%", "%%") for mark in marks]
    return (form.join(plain)) * len(values) % tuple(values.ravel().tolist())


def _printed(values: np.ndarray, form: str, marks: tuple[str, ...]) -> bytes | None:
    """The same by the machine; None where there is none, or where it leaves a number to Python."""
    machine = backend.machine()
    if machine is None:
        return None
    number, digits, text, ends = _row(form, marks)
    values = np.ascontiguousarray(values, dtype=np.float64 if number else np.int64)
    out = np.empty(len(values) * (len(text) + _WIDTH * values.shape[1]), dtype=np.uint8)
    length = call(machine.library.print_rows, *values.shape, number, digits, values, text, ends, out)
    return None if length < 0 else out[:length].tobytes()


@lru_cache(maxsize=64)
def _row(form: str, marks: tuple[str, ...]) -> tuple[int, int, bytes, np.ndarray]:
    """A form by its number and digits, the marks as one text, and where each ends."""
    text = [mark.encode("ascii") for mark in marks]
    digits = int(form[2:-1]) if form[1] == "." else 0
    return _FORMS[form[-1]], digits, b"".join(text), np.cumsum([len(part) for part in text], dtype=np.int64)
