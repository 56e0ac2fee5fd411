"""Rows of numbers as text, by compiled code where that is there: the bytes of Python's ``%`` and of its JSON."""

from __future__ import annotations

from collections.abc import Sequence
from functools import lru_cache
from itertools import pairwise
from typing import NamedTuple

import numpy as np

from . import backend
from .calls import address, call

_WIDTH = 24  # more than a number takes
_LINE = ord("\n")
_FEW = 12  # numbers below which Python is as fast
_FORMS = {"d": 0, "g": 1, "f": 2}
_WORD, _WHOLE = 0, 1  # columns of records; then numbers, by their dimensions


def print_rows(values: np.ndarray, form: str, marks: Sequence[str]) -> str:
    """Rows of numbers (n, k), each in the ``form`` ``%d``, ``%.9g`` or ``%.6f``; ``marks`` (k + 1,) is what stands before each
    column and after the last, ASCII."""
    found = _printed(values, form, tuple(marks)) if values.size >= _FEW else None
    if found is not None:
        return found.decode("ascii")
    plain = [mark.replace("%", "%%") for mark in marks]
    return (form.join(plain)) * len(values) % tuple(values.ravel().tolist())


def print_blocks(whole: np.ndarray, start: Sequence[int], form: str, marks: Sequence[str]) -> list[str]:
    """``print_rows`` of blocks of rows (N, k), block i from ``start[i]`` to ``start[i + 1]``; a row is a line: of ``marks``, the last
    alone ends one."""
    found = _printed(whole, form, tuple(marks)) if whole.size >= _FEW else None
    if found is None:
        return [print_rows(whole[a:b], form, marks) for a, b in pairwise(start)]
    lines = np.flatnonzero(np.frombuffer(found, dtype=np.uint8) == _LINE) + 1
    ends = np.concatenate([[0], lines])[start].tolist()
    text = found.decode("ascii")
    return [text[a:b] for a, b in pairwise(ends)]


def print_told(
    values: np.ndarray, words: Sequence[str], which: np.ndarray, lead: int = 0
) -> tuple[bytes, bytes] | None:
    """Rows of numbers (n, k) as ``%.6f`` has them, blanks between, then the word of each row by its number in ``which`` (n,), if there are
    words, ASCII; and rows of the first ``lead`` numbers alone. None where there is no machine, or where it leaves a number to Python."""
    machine = backend.machine()
    if machine is None:
        return None
    values, which = np.ascontiguousarray(values, dtype=np.float64), np.ascontiguousarray(which, dtype=np.int64)
    said = [word.encode("ascii") for word in words]
    ends = np.cumsum([0, *map(len, said)], dtype=np.int64)
    room = _WIDTH * values.shape[1] + max(map(len, said), default=0) + 1
    out = np.empty(len(values) * room, dtype=np.uint8)
    head, end = np.empty(len(values) * (_WIDTH * lead + 1), dtype=np.uint8), np.zeros(1, dtype=np.int64)
    text = b"".join(said) if said else None
    length = call(machine.library.print_told, *values.shape, values, which, text, ends, out, lead, head, end)
    return None if length < 0 else (out[:length].tobytes(), head[: end[0]].tobytes())


def _printed(values: np.ndarray, form: str, marks: tuple[str, ...]) -> bytes | None:
    """The same by the machine; None where there is none, or where it leaves a number to Python."""
    machine = backend.machine()
    if machine is None:
        return None
    row = _row(form, marks)
    values = np.ascontiguousarray(values, dtype=row.kind)
    rows, columns = values.shape
    out = np.empty(rows * (len(row.text) + _WIDTH * columns), dtype=np.uint8)
    length = machine.print_rows(
        rows, columns, row.form, row.digits, address(values), row.text, address(row.ends), address(out)
    )
    return None if length < 0 else out[:length].tobytes()


class Words(NamedTuple):
    """A column of words: what they are, and which of them stands in each row (n,)."""

    said: Sequence[str]
    which: np.ndarray


class Numbers(NamedTuple):
    """A column of whole numbers (n,), of others (n,), nan where there is none, or of rows (n, k), of which some may be ``absent`` (n,)."""

    values: np.ndarray
    absent: np.ndarray | None = None


def print_records(columns: Sequence[Words | Numbers], marks: Sequence[str]) -> tuple[bytes, np.ndarray] | None:
    """Rows of columns as JSON has them, and where the text of each row ends (n,); ``marks`` (columns + 1,) is what stands before each
    column and after the last. Numbers but whole ones are rounded to billionths as NumPy rounds, and written as Python writes them; what
    there is not is null, rows are lists. None where there is no machine, or where it leaves a number to Python."""
    machine = backend.machine()
    if machine is None:
        return None
    rows = len(columns[0].which if isinstance(columns[0], Words) else columns[0].values)
    told = np.zeros((len(columns), 4), dtype=np.int64)  # form, width, addresses: of numbers, of which rows are absent
    held: list[np.ndarray] = []  # what lies there
    words: list[bytes] = []
    room = 0
    for own, column in zip(told, columns, strict=True):
        form, width, absent = _WORD, 1, None
        if isinstance(column, Words):
            said = [word.encode() for word in column.said]
            values = np.asarray(column.which, dtype=np.int64) + len(words)
            words += said
            room += int(np.array(list(map(len, said)), dtype=np.int64)[column.which].sum())
        else:
            values, absent = column
            form = values.ndim + 1 if values.dtype.kind == "f" else _WHOLE
            values = np.ascontiguousarray(values, dtype=np.int64 if form == _WHOLE else np.float64)
            width = values[0].size if rows else 1
            room += rows * ((_WIDTH + 1) * width + 2)
        own[:3], held = (form, width, address(values)), [*held, values]
        if absent is not None:
            held.append(np.ascontiguousarray(absent, dtype=np.bool_))
            own[3] = address(held[-1])
    between = [mark.encode() for mark in marks]
    out, done = np.empty(room + rows * sum(map(len, between)), dtype=np.uint8), np.empty(rows, dtype=np.int64)
    ends, word_ends = (np.cumsum([0, *map(len, texts)]) for texts in (between, words))
    given = (told, b"".join(between), ends[1:], b"".join(words), word_ends, out, done)
    length = call(machine.library.print_records, rows, len(columns), *given)
    return None if length < 0 else (out[:length].tobytes(), done)


class _Row(NamedTuple):
    """How rows are printed: a form by its number and its digits, the marks as one text, and where each ends."""

    kind: type
    form: int
    digits: int
    text: bytes
    ends: np.ndarray


@lru_cache(maxsize=64)
def _row(form: str, marks: tuple[str, ...]) -> _Row:
    text = [mark.encode("ascii") for mark in marks]
    number, digits = _FORMS[form[-1]], int(form[2:-1]) if form[1] == "." else 0
    ends = np.cumsum([len(part) for part in text], dtype=np.int64)
    return _Row(np.float64 if number else np.int64, number, digits, b"".join(text), ends)
