"""Arguments of the Python interface: whole numbers, numbers in a range, yes or no, paths; of Python's types or of NumPy's."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from numbers import Integral, Real
from pathlib import Path
from typing import Any

import numpy as np

from .errors import UsageError


def read_whole(name: str, value: Any, least: int | None = None, most: int | None = None) -> int:
    """A whole number, from ``least`` on and up to ``most`` where these are given. Raises UsageError."""
    if not isinstance(value, Integral) or isinstance(value, bool):
        raise UsageError(f"{name} is {value!r}: a whole number is needed")
    number = int(value)
    if least is not None and number < least:
        raise UsageError(f"{name} is {number}", f"give a whole number from {least}")
    if most is not None and number > most:
        raise UsageError(f"{name} is {number}", f"give a whole number up to {most:,}")
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


def read_path(what: str, value: Any, example: str) -> Path:
    """A path of this machine, or of another as its address says. Raises UsageError for what no file or folder can be called."""
    if not isinstance(value, str | Path):
        raise UsageError(f"{what} is named by a text or a Path, not {value!r}", f"for example {example}")
    if isinstance(value, str) and not value.strip():
        raise UsageError(f"the name of {what} is empty text", f'for example {example}; "." is the current folder')
    if "\0" in str(value):
        raise UsageError(f"the name of {what} has a zero byte in it: {str(value)!r}", f"for example {example}")
    return Path(value)


def to_plain(given: Any) -> Any:
    """What Python gives as JSON has it: arrays and tuples are lists, numbers of NumPy's are those of Python's."""
    if isinstance(given, Mapping):
        return {str(key): to_plain(value) for key, value in given.items()}
    if isinstance(given, np.ndarray | np.generic):
        return given.tolist()
    if isinstance(given, Sequence) and not isinstance(given, str | bytes):
        return [to_plain(item) for item in given]
    return given


def read_paths(name: str, value: Any, example: str) -> list[str]:
    """Names of files or folders, as one or as several. Raises UsageError."""
    if isinstance(value, str | Path):
        return [str(value)]
    found = list(value) if isinstance(value, Iterable) else [value]
    if not all(isinstance(one, str | Path) for one in found):
        raise UsageError(f"{name} is {value!r}", f"give a name, or a list of names: {example}")
    return [str(one) for one in found]
