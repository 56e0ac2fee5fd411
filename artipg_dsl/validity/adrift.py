"""Parts that float in every object that has them: what can be asked of a few objects at once, for `check`."""

from __future__ import annotations

import numpy as np

from ..geometry.runs import distinct
from .floating import Solids


def find_adrift(solids: Solids) -> dict[str, str]:
    """Parts that in all objects that have them touch nothing of their link, or nothing that touches its first part by a
    chain of others: the link, by its path, for the path of each."""
    loose, found = solids.loose(), {}
    for site in distinct(solids.site[loose]).tolist():
        there = solids.site == site
        wrong = there & loose
        if len(distinct(solids.owner[wrong])) == len(distinct(solids.owner[there])):
            some = int(np.flatnonzero(wrong)[0])
            found[solids.path(some)] = solids.carrier(some)
    return found


def find_gaps(solids: Solids, part: str, carrier: str) -> np.ndarray | None:
    """How far the box of a part that floats and that of another, by their paths, are apart along x, y and z (3,) in metres, negative
    where they overlap: of the two primitives that are nearest to one another in the first object with both on one link; None where
    there is none. Elements of a repeat that are held say nothing of those that float."""
    inside, other = (
        np.array([f"{path}.".startswith(f"{one}.") for path in solids.paths()], dtype=bool)[solids.site]
        for one in (part, carrier)
    )
    adrift = inside & solids.loose()
    for link in distinct(solids.link[adrift]).tolist():
        ours, theirs = (np.flatnonzero((solids.link == link) & mine) for mine in (adrift, other & ~inside))
        if len(ours) and len(theirs):
            i, j = np.repeat(ours, len(theirs)), np.tile(theirs, len(ours))
            gaps = np.maximum(solids.low[i] - solids.high[j], solids.low[j] - solids.high[i])
            return gaps[np.argmin((np.maximum(gaps, 0.0) ** 2).sum(axis=1))]
    return None
