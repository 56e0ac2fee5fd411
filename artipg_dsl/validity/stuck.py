"""Links that overlap where nothing has moved yet: what can be asked of a few objects at once, for `check`."""

from __future__ import annotations

from collections import Counter

import numpy as np

from ..runtime.batch import Batch
from .bodies import gather
from .tree import Tree
from .validate import find_meetings_at_rest


def find_stuck(batch: Batch) -> dict[tuple[str, str], tuple[int, int]]:
    """For pairs of links, by their paths: in how many objects some of their instances overlap with all joints at rest, and how many
    objects have both. Pairs that overlap in none, or that the text allows to, are left out."""
    tree = Tree(batch)
    rows = find_meetings_at_rest(tree, gather(batch, tree.first, tree.turn, tree.shift))
    first, second = rows[:, 0].astype(np.int64), rows[:, 1].astype(np.int64)
    keep = ~tree.permitted(first, second)
    links = tree.links
    met = {
        (int(owner), *sorted((int(one), int(other))))
        for owner, one, other in zip(
            links.owner[first[keep]], links.definition[first[keep]], links.definition[second[keep]], strict=True
        )
    }
    there = np.zeros((len(batch), len(batch.program.links)), dtype=bool)
    there[links.owner, links.definition] = True
    path = [link.path for link in batch.program.links]
    return {
        (path[one], path[other]): (count, int((there[:, one] & there[:, other]).sum()))
        for (one, other), count in sorted(Counter((one, other) for _, one, other in met).items())
    }
