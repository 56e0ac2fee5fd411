"""Links that overlap where nothing has moved yet, and what else no object examined is free of: what can be asked of a few objects
at once, for `check`."""

from __future__ import annotations

import numpy as np

from ..geometry.runs import distinct
from ..records import dataclass
from ..runtime.tables import plain_name
from .apart import find_too_near
from .bodies import Pieces
from .contact import describe_contact, meeting_parts
from .fault import Fault
from .floating import Solids, find_inverted
from .loops import find_open
from .tree import Tree
from .validate import Collisions, find_collisions_at_rest


@dataclass(frozen=True, slots=True)
class Stuck:
    """Two links, by path, and the parts of them that overlap, by name (`leg[0].rod`), in the order of their links."""

    links: tuple[str, str]
    parts: tuple[str, str]


def find_stuck(tree: Tree, body: Pieces) -> list[Stuck]:
    """The pairs of links that overlap with all joints at rest in each of the objects that have both, without those that the text
    allows to; the parts are those of the first object. Of links that overlap in some objects, the pairs of parts that overlap in
    each that has both: a part of a link may be absent where the link is not."""
    found, links = find_collisions_at_rest(tree, body), tree.links
    start = tree.first[found.owner]
    pairs = np.sort(np.stack([links.definition[start + side] for side in (found.first, found.second)], axis=1), axis=1)
    there = np.zeros((len(tree.first), len(tree.batch.program.links)), dtype=bool)
    there[links.owner, links.definition] = True
    stuck = []
    for one, other in sorted(set(map(tuple, pairs.tolist()))):
        rows = np.flatnonzero((pairs == (one, other)).all(axis=1))
        first, second = sorted(tree.batch.program.links[link].path for link in (one, other))
        if len(distinct(found.owner[rows])) == int((there[:, one] & there[:, other]).sum()):
            stuck.append(Stuck((first, second), describe_contact(tree, body, found, int(rows[0])).parts))
        else:
            stuck += [Stuck((first, second), parts) for parts in _always(tree, body, found, rows.tolist())]
    return stuck


def _always(tree: Tree, body: Pieces, found: Collisions, rows: list[int]) -> list[tuple[str, str]]:
    """The parts, by name, of the first of those rows of one pair of links that are of the same two parts, where each object that has
    both parts has such a row."""
    parts = tree.batch.parts()
    paths = np.array([plain_name(name) for name in parts.name], dtype=object)
    met: dict[tuple[str, ...], list[tuple[tuple[str, str], int]]] = {}
    for row in rows:
        names = meeting_parts(tree, body, found, row)
        met.setdefault(tuple(plain_name(name) for name in names), []).append((names, int(found.owner[row])))
    always = []
    for key, told in met.items():
        having = [set(parts.owner[paths == path].tolist()) for path in key]
        both = set.intersection(*having)
        if len(both) > 1 and both == {owner for _, owner in told}:  # one alone may be bad luck
            always.append(told[0][0])
    return always


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
