"""Parts that float for certain, by the boxes of their primitives: what can be asked of a few objects at once, for `check`.

What hangs together by boxes may float all the same, which the solids tell (``floating``); what does not, floats.
"""

from __future__ import annotations

import numpy as np

from ..geometry.runs import distinct
from ..runtime.batch import Batch
from .floating import ROUND, TOUCH, find_loose, find_neighbours, join_groups


def find_adrift(batch: Batch) -> dict[str, tuple[int, int]]:
    """For parts, by their path: in how many objects one hangs together with the first part of its link by no chain of
    boxes, at joint values 0, and how many objects have it. Parts that do so in none are left out."""
    tables = batch.sites()
    if not tables:
        return {}
    first = np.searchsorted(batch.links().owner, np.arange(len(batch)))
    link = np.concatenate([first[table.owner] + table.link for table in tables])
    low, high = np.concatenate([table.boxes() for table in tables], axis=1)
    margin = TOUCH + ROUND * np.sort(high - low, axis=1)[:, 1]
    pairs = find_neighbours(link, low, high, margin)
    floats = np.split(
        find_loose(batch, link, join_groups(np.arange(len(link)), *pairs)), np.cumsum([len(t) for t in tables])[:-1]
    )
    found: dict[str, tuple[int, int]] = {}
    for table, wrong in zip(tables, floats, strict=True):
        if wrong.any():
            path = batch.program.parts[batch.program.sites[table.number].part].path
            found[path] = len(distinct(table.owner[wrong])), len(distinct(table.owner))
    return found
