"""What entries of a manifest may hold, beyond their types, and what messages call them."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Sequence
from contextlib import contextmanager
from typing import Annotated, Any, get_args, get_origin

import numpy as np

from ..errors import UserError
from ..records import dataclass
from ..shapes import Misfit, Rule, hints

MOST = 100_000_000  # objects
LARGEST = 2**63 - 1  # numbers of objects are below: runs of them end one behind the last

Runs = tuple[tuple[int, int], ...]
"""Numbers of objects as runs ``(first, last)``, ascending."""


@dataclass(frozen=True, slots=True)
class Title:
    """What messages call an entry of the manifest."""

    words: str


def read_titles(record: Any) -> dict[str, str]:
    """The titles of the entries of a ``TypedDict``, by key; an entry without one is left out."""
    return {key: note.words for key, kind in hints(record).items() for note in _notes(kind) if isinstance(note, Title)}


def _notes(kind: Any) -> Iterator[Any]:
    if get_origin(kind) is Annotated:
        yield from get_args(kind)[1:]
    elif get_origin(kind) is not None:
        yield from _notes(get_args(kind)[0])  # NotRequired[Annotated[...]]


def one_of(known: Iterable[str]) -> Rule:
    names = list(known)
    return Rule(f"one of {', '.join(names)}", lambda value: value in names)


def within(least: float, most: float) -> Rule:
    noun = "a whole number" if isinstance(least, int) else "a number"
    return Rule(f"{noun} from {least:g} to {most:g}", lambda value: least <= value <= most)


def _is_ordered(value: Sequence[Sequence[int]]) -> bool:
    """Whether runs ``[first, last]`` ascend, do not meet, and hold no more objects than a folder may."""
    ends = [end for run in value for end in run]
    ascending = all(a <= b if k % 2 == 0 else a < b for k, (a, b) in enumerate(zip(ends, ends[1:], strict=False)))
    bounded = not ends or 0 <= ends[0] and ends[-1] < LARGEST
    return ascending and bounded and count_numbers(value) <= MOST


Count = Annotated[int, Rule("a whole number from 0 on", lambda value: 0 <= value < LARGEST)]
FirstAndLast = Annotated[list[int], Rule("a first and a last number", lambda value: len(value) == 2)]
RUNS = Rule("runs of object numbers [first, last], ascending", _is_ordered)


def to_runs(numbers: Sequence[int] | np.ndarray) -> Runs:
    """Ascending numbers of objects as runs."""
    numbers = np.asarray(numbers, dtype=np.int64)
    if not len(numbers):
        return ()
    breaks = np.flatnonzero(np.diff(numbers) != 1) + 1
    return tuple((int(run[0]), int(run[-1])) for run in np.split(numbers, breaks))


def expand(found: Sequence[Sequence[int]]) -> np.ndarray:
    """The numbers that runs stand for."""
    pieces = [np.arange(first, last + 1) for first, last in found]
    return np.concatenate(pieces) if pieces else np.zeros(0, dtype=np.int64)


def count_numbers(found: Sequence[Sequence[int]]) -> int:
    """How many numbers runs stand for."""
    return sum(last - first + 1 for first, last in found)


@contextmanager
def at_entry(at: str, expected: str) -> Iterator[None]:
    """What is refused inside is a fault of the entry ``at``. Raises Misfit."""
    try:
        yield
    except UserError as error:
        raise Misfit(at, expected, error.message) from None
