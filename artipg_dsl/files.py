"""Files that anyone may have written, read as plain data: text, JSON, archives of arrays. What is wrong with one is told with its place."""

from __future__ import annotations

import json
from collections.abc import Callable
from pathlib import Path
from typing import TYPE_CHECKING, Any, BinaryIO

from .errors import UserError

if TYPE_CHECKING:
    import numpy as np


def read_text(path: str | Path) -> str:
    """The text of a file. Raises FileNotFoundError, and UserError for one that cannot be read."""
    try:
        return Path(path).read_text(encoding="utf-8-sig")
    except FileNotFoundError:
        raise
    except (OSError, ValueError) as wrong:  # no path has a zero byte in it
        reason = "it is not text" if isinstance(wrong, UnicodeDecodeError) else getattr(wrong, "strerror", None)
        raise UserError(f"{path} cannot be read: {reason or wrong}") from None


def read_json(path: str | Path, form: str) -> Any:
    """What a JSON file says; ``form`` tells what it should. Raises FileNotFoundError, UserError."""
    return parse_json(read_text(path), str(path), form)


def parse_json(text: str, name: str, form: str, line: int = 1) -> Any:
    """The same of a text of that name, which begins in a ``line`` of it. Raises UserError, also for a name that is given twice in one
    object."""
    try:
        return json.loads(text, object_pairs_hook=_once)
    except json.JSONDecodeError as wrong:
        raise UserError(f"{name}:{line + wrong.lineno - 1}:{wrong.colno}: it is not JSON: {wrong.msg}", form) from None
    except _Twice as twice:
        raise UserError(f"{name}: {twice}", "leave one of them out") from None
    except (ValueError, RecursionError) as wrong:  # numbers of thousands of digits, thousands of lists
        raise UserError(f"{name} cannot be read: {wrong}", form) from None


class _Twice(ValueError):
    """It would not be told which value counts."""


def _once(pairs: list[tuple[str, Any]]) -> dict[str, Any]:
    found = dict(pairs)
    if len(found) < len(pairs):
        names = [name for name, _ in pairs]
        twice = next(name for k, name in enumerate(names) if name in names[:k])
        raise _Twice(f"`{twice}` is given twice in one object")
    return found


def read_arrays(source: BinaryIO, wanted: Callable[[str], bool] = lambda name: True) -> dict[str, np.ndarray]:
    """The ``wanted`` arrays of an ``.npz``, by name. Raises OSError, and ValueError for what is no archive of arrays."""
    from zipfile import is_zipfile  # start-up: as below

    import numpy as np  # start-up: most commands that read JSON read no arrays

    if not is_zipfile(source):  # NumPy would take it for pickled data, and advise to load it unsafely
        raise ValueError("it is no archive of arrays")
    source.seek(0)
    try:
        with np.load(source, allow_pickle=False) as held:
            return {name: held[name] for name in held.files if wanted(name)}
    except OSError:
        raise
    except Exception as wrong:  # a spoilt byte makes the libraries raise whatever they please
        raise ValueError(str(wrong) or type(wrong).__name__) from None
