"""What is wrong with some objects beyond their requirements, where in the text, and in words."""

from __future__ import annotations

from collections.abc import Iterable

import numpy as np

from ..geometry.runs import distinct
from ..graph.program import Where
from ..records import dataclass


@dataclass(frozen=True, slots=True)
class Fault:
    """``what`` is wrong, in words without its place, and the indices of the ``objects`` that have it, each once, ascending.

    ``where`` is the place of the statement that does not hold, and ``part`` the path of the part or of the link at fault; None
    where there is none. ``example`` tells in words of one of these objects, with its numbers; nothing where there are none.
    """

    what: str
    objects: np.ndarray
    where: Where | None = None
    part: str | None = None
    example: str = ""

    @property
    def words(self) -> str:
        """With its place, as statistics and reports list it."""
        return self.what if self.where is None else f"{self.where}: {self.what}"


Key = tuple[str, Where | None, str | None]
"""What is wrong, where, and with which part."""


def list_faults(found: Iterable[tuple[Key, int | list[int] | np.ndarray]]) -> list[Fault]:
    """A fault for each key, in the order in which they come first, with all of its objects."""
    objects: dict[Key, list[np.ndarray]] = {}
    for key, some in found:
        objects.setdefault(key, []).append(np.atleast_1d(np.asarray(some, dtype=np.int64)))
    faults = ((key, distinct(np.concatenate(parts))) for key, parts in objects.items())
    return [Fault(what, rows, where, part) for (what, where, part), rows in faults]
