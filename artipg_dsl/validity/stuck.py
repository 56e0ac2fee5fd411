"""Links that overlap where nothing has moved yet, and what else no object examined is free of: what can be asked of a few objects
at once, for `check`."""

from __future__ import annotations

import numpy as np

from ..geometry.runs import distinct
from ..records import dataclass
from .apart import find_too_near
from .bodies import Pieces
from .contact import describe_contact
from .fault import Fault
from .floating import Solids, find_inverted
from .loops import find_open
from .tree import Tree
from .validate import find_collisions_at_rest


@dataclass(frozen=True, slots=True)
class Stuck:
    """Two links, by path, and the parts of them that overlap, by name (`leg[0].rod`), in the order of their links."""

    links: tuple[str, str]
    parts: tuple[str, str]


def find_stuck(tree: Tree, body: Pieces) -> list[Stuck]:
    """The pairs of links that overlap with all joints at rest in each of the objects that have both, without those that the text
    allows to; the parts are those of the first object."""
    found, links = find_collisions_at_rest(tree, body), tree.links
    start = tree.first[found.owner]
    pairs = np.sort(np.stack([links.definition[start + side] for side in (found.first, found.second)], axis=1), axis=1)
    there = np.zeros((len(tree.first), len(tree.batch.program.links)), dtype=bool)
    there[links.owner, links.definition] = True
    stuck = []
    for one, other in sorted(set(map(tuple, pairs.tolist()))):
        rows = np.flatnonzero((pairs == (one, other)).all(axis=1))
        if len(distinct(found.owner[rows])) == int((there[:, one] & there[:, other]).sum()):
            first, second = sorted(tree.batch.program.links[link].path for link in (one, other))
            stuck.append(Stuck((first, second), describe_contact(tree, body, found, int(rows[0])).parts))
    return stuck


def find_never(solids: Solids) -> list[Fault]:
    """What is wrong with each of the objects: no surface at all, solids without thickness, links that nothing holds, loops that
    do not close, parts that come too near one another, and joints that rest outside their range. Parts that float are told apart."""
    tree, body = solids.tree, solids.body
    wrong = (
        *solids.missing(),
        *solids.degenerate(),
        *solids.find_unheld(),
        *find_open(tree),
        *find_too_near(tree, body),
        *find_inverted(tree),
    )
    return [fault for fault in wrong if len(fault.objects) == len(tree.first)]
