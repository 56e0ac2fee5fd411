"""Numbers as text: a few at a time, and rows of them all at once.

``told`` makes the bytes of Python's ``%.6f`` by compiled code, else ``fixed`` does, of tables of digits: a number is rounded to a whole
number of millionths, which is split into groups of three digits. Where rounding is not clear, as the millionths are half way between
two within the error of the multiplication, Python tells.
"""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from functools import lru_cache

import numpy as np

from ..native.digits import print_rows, print_told

_PLACES, _MOST = 6, 1000.0
_UNIT = 10**_PLACES
_TRIPLES = np.array([list(f"{k:03d}".encode()) for k in range(1000)], dtype=np.uint8)
_WIDTH = 11  # sign, three digits, point, six digits
_NOISE = 1e12  # its inverse is dropped, metres
_MANY = 24  # numbers from which on arrays are faster
_CLOSE = 1e-6  # of a millionth: a thousand times the error of a product below 1e9


def numbers(values: Iterable[float] | np.ndarray, digits: int = 9) -> str:
    """Numbers (n,) with so many significant digits and a blank between, rounding noise below 1e-12 dropped."""
    few = values.tolist() if isinstance(values, np.ndarray) else [*values]
    if len(few) >= _MANY:
        return print_rows((np.round(np.array(few), 12) + 0.0)[:, None], f"%.{digits}g", ("", " "))[:-1]
    try:
        rounded = [round(value * _NOISE) / _NOISE for value in few]  # as NumPy rounds
    except (OverflowError, ValueError):  # no number has no whole one beside it
        rounded = (np.round(np.array(few), 12) + 0.0).tolist()
    return _form(digits, len(few)) % tuple(rounded)


def rows(values: np.ndarray, digits: int = 9) -> list[str]:
    """What ``numbers`` makes of each of several rows (n, k)."""
    if not len(values):
        return []
    ends = ("", *[" "] * (values.shape[1] - 1), "\n")
    return print_rows(np.round(values, 12) + 0.0, f"%.{digits}g", ends)[:-1].split("\n")


@lru_cache(maxsize=64)
def _form(digits: int, count: int) -> str:
    return " ".join([f"%.{digits}g"] * count)


class Rows:
    """Rows of text of which some characters are left out: ``text`` (n, w) uint8, ``kept`` (n, w) bool."""

    def __init__(self, text: np.ndarray, kept: np.ndarray):
        self.text, self.kept = text, kept

    def __bytes__(self) -> bytes:
        return self.text[self.kept].tobytes()

    @staticmethod
    def of(strings: Sequence[str], which: np.ndarray) -> Rows:
        """For each row the string of that number."""
        width = max(map(len, strings), default=0)
        text = np.array([list(s.ljust(width).encode("ascii")) for s in strings], dtype=np.uint8).reshape(-1, width)
        kept = np.arange(width) < np.array([len(s) for s in strings])[:, None]
        return Rows(text[which], kept[which])

    @staticmethod
    def joined(parts: Sequence[Rows], between: str = " ", last: str = "\n") -> Rows:
        """Rows of several columns, with a character between and one at the end."""
        count = len(parts[0].text)
        ends = [*(between for _ in parts[1:]), last]
        marks = [np.full((count, 1), ord(end), dtype=np.uint8) for end in ends]
        texts = [array for part, mark in zip(parts, marks, strict=True) for array in (part.text, mark)]
        always = np.ones((count, 1), dtype=bool)
        return Rows(np.concatenate(texts, axis=1), np.concatenate([a for p in parts for a in (p.kept, always)], axis=1))


def told(values: np.ndarray, words: Sequence[str] = (), which: np.ndarray | None = None) -> bytes:
    """Rows of numbers (n, k) as ``%.6f`` has them, no nought with a sign, k possibly 0, each followed by its word, if there are any: that
    of its number in ``which`` (n,)."""
    values = values + 0.0
    chosen = np.zeros(len(values), dtype=np.int64) if which is None else which
    found = print_told(values, words, chosen)
    if found is not None:
        return found[0]
    parts = [fixed(values)] if values.shape[1] else []
    return bytes(Rows.joined([*parts, Rows.of(words, chosen)] if words else parts))


def told_twice(values: np.ndarray, lead: int, words: Sequence[str], which: np.ndarray) -> tuple[bytes, bytes]:
    """What ``told`` says of all columns, and of the first ``lead`` of them without words, printed once."""
    found = print_told(values + 0.0, words, which, lead)
    return (told(values, words, which), told(values[:, :lead])) if found is None else found


def fixed(values: np.ndarray) -> Rows:
    """Rows of numbers (n, k) as ``%.6f`` has them, blanks between, without an end."""
    flat = np.ascontiguousarray(values, dtype=np.float64).ravel()
    size = np.abs(flat)
    if not (size < _MOST).all():  # also what is no number
        strings = [" ".join(f"{number:.6f}" for number in row) for row in np.asarray(values, dtype=float).tolist()]
        return Rows.of(strings, np.arange(len(strings)))
    scaled = size * _UNIT
    whole = np.floor(scaled)
    unclear = np.flatnonzero(np.abs(scaled - whole - 0.5) < _CLOSE)
    millionths = np.rint(scaled).astype(np.int64)
    for k in unclear.tolist():
        millionths[k] = int(f"{size[k]:.6f}".replace(".", ""))
    front, back = np.divmod(millionths, _UNIT)
    text = np.empty((len(flat), _WIDTH + 1), dtype=np.uint8)
    text[:, 0], text[:, 4], text[:, _WIDTH] = ord("-"), ord("."), ord(" ")
    text[:, 1:4] = _TRIPLES[front]
    text[:, 5:8], text[:, 8:11] = _TRIPLES[back // 1000], _TRIPLES[back % 1000]
    kept = np.ones(text.shape, dtype=bool)
    kept[:, 0], kept[:, 1], kept[:, 2] = flat < 0, front >= 100, front >= 10
    rows = len(values)
    return Rows(text.reshape(rows, -1)[:, :-1], kept.reshape(rows, -1)[:, :-1])
