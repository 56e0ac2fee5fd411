"""Which semantic part belongs to which: the handle of the door of the microwave."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

if TYPE_CHECKING:
    from ..runtime.tables import PartTable


def find_semantic_parents(parts: PartTable) -> np.ndarray:
    """For each part (P,) the number of the semantic part that it belongs to, -1: the object itself.

    That is the innermost one around it; for a part in none, that of the part it is rigidly connected to, or of what
    carries the part around it. What a joint holds belongs to no other for that.
    """
    count = len(parts.owner)
    first = np.searchsorted(parts.owner, parts.owner)
    around = np.append(np.where(parts.parent >= 0, first + parts.parent, count), count)
    carrier = np.append(np.where(parts.holder >= 0, first + parts.holder, around[:count]), count)
    own = np.append(np.where(parts.semantic > 0, np.arange(count), -1), count)
    inside = _climb(around, own)  # the innermost at or around each part, `count` where there is none
    within = inside[around[:count]]
    settled = np.where(inside < count, inside, -1)
    settled[count] = count
    carried = _climb(carrier, settled)[carrier[:count]]
    found = np.where(within < count, within, carried)
    return np.where(found < count, np.append(parts.number, -1)[found], -1)


def _climb(up: np.ndarray, known: np.ndarray) -> np.ndarray:
    """The first known value on the way up from each row; -1 is unknown, the last row is the top and known."""
    at = np.arange(len(up))
    for _ in range(len(up)):
        going = known[at] < 0
        if not going.any():
            break
        at = np.where(going, up[at], at)
    return known[at]


def lineages_of(parts: PartTable, of: np.ndarray, words: tuple[str, ...], category: str) -> list[str | None]:
    """``Microwave/door/handle`` for each part that has a semantic word of its own, None for the others."""
    above = np.where(of < 0, -1, np.searchsorted(parts.owner, parts.owner) + of).tolist()
    semantic = np.asarray(parts.semantic).tolist()
    found: list[str | None] = []
    for row, word in enumerate(semantic):
        names, at = [], row
        while at >= 0:
            names.append(words[semantic[at]])
            at = above[at]
        found.append("/".join([category, *reversed(names)]) if word else None)
    return found
