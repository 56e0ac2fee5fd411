"""What a folder in a layout holds of one category: which objects, under which names, in which split."""

from __future__ import annotations

import re
import zlib
from collections.abc import Mapping
from dataclasses import field
from typing import Any

import numpy as np

from ..errors import UsageError
from ..records import dataclass
from .words import Term

SPLITS = ("train", "val", "test")
Shares = tuple[int, int, int]
USUAL: Shares = (8, 1, 1)


def read_shares(text: str) -> Shares:
    """How many of every few objects go into train, val and test: ``8,1,1``. Raises UsageError."""
    words = text.split(",") if isinstance(text, str) else []
    if len(words) != 3 or not all(re.fullmatch(r"\s*[0-9]{1,4}\s*", word) for word in words) or not int("".join(words)):
        raise UsageError(f"{text!r} is not a split", "it is three whole numbers for train, val and test, such as 8,1,1")
    train, val, test = map(int, words)
    return train, val, test


@dataclass(frozen=True, slots=True)
class Entry:
    """``numbers`` (N,) of the objects, ascending; ``term``: what the layout's vocabulary calls the category (None where
    it has no vocabulary); ``words``: the names of parts that an open vocabulary takes from the program."""

    category: str
    seed: int
    numbers: np.ndarray
    shares: Shares = USUAL
    term: Term | None = None
    words: Mapping[str, Any] = field(default_factory=dict)
    chunk: int = 64  # objects that are made together

    def token(self, number: int) -> str:
        """The name of an object, letters and digits alone, unlike that of any other category's or seed's."""
        return f"{self.category}{self.seed}n{number:06d}".replace("-", "m").replace("_", "")

    def id(self, number: int) -> int:
        """The name of an object where that has to be a number: five digits of the category's name, six of its own."""
        return (10000 + zlib.crc32(self.category.encode()) % 90000) * 1000000 + number

    def split(self, number: int) -> str:
        """By the number alone, so that an object stays where it is when others are added."""
        place, ends = number % sum(self.shares), np.cumsum(self.shares)
        return SPLITS[int(np.searchsorted(ends, place, side="right"))]

    def splits(self, numbers: np.ndarray | None = None) -> dict[str, np.ndarray]:
        """The places of objects among ``numbers`` (all of them by default), by split."""
        numbers = self.numbers if numbers is None else numbers
        named = np.array([self.split(n) for n in numbers.tolist()], dtype="U5")
        return {split: np.flatnonzero(named == split) for split in SPLITS}

    def tokens(self, split: str) -> list[str]:
        """The names of the objects of a split."""
        return [self.token(n) for n in self.numbers[self.splits()[split]].tolist()]

    def chunks(self) -> list[np.ndarray]:
        """The numbers of objects that are made together."""
        return [self.numbers[at : at + self.chunk] for at in range(0, len(self.numbers), self.chunk)]
