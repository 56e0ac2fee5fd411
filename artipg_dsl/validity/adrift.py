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
