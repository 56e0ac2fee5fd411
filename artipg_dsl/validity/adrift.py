"""Parts that float for certain, by the boxes of their primitives: what can be asked of a few objects at once, for `check`.

What hangs together by boxes may float all the same, which the solids tell (``floating``); what does not, floats.
"""

from __future__ import annotations

import numpy as np

from ..geometry.runs import distinct
from ..runtime.batch import Batch
from .floating import ROUND, TOUCH, find_loose, find_neighbours, join_groups


def find_adrift(batch: Batch) -> dict[str, str]:
    """Parts that in all objects that have them hang together with the first part of their link by no chain of boxes, at
    joint values 0: the link, by its path, for the path of each."""
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
    program, kind, found = batch.program, batch.links().definition, {}
    for table, wrong in zip(tables, floats, strict=True):
        if wrong.any() and len(distinct(table.owner[wrong])) == len(distinct(table.owner)):
            some = int(np.flatnonzero(wrong)[0])
            on = kind[first[table.owner[some]] + table.link[some]]
            found[program.parts[program.sites[table.number].part].path] = program.links[on].path
    return found
