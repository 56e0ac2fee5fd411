"""Which point of a real surface belongs to which point of a structure.

``nearest`` is Eq. 2 of the paper: each point x of the structure takes the nearest y of the cloud. On edges and beside what stands out many
x take the same y, and other y are never taken. ``aware`` compares normals as well. ``project`` goes the other way: each y takes the
nearest x, so that all of the cloud is there, but not all of the structure is covered; ``both`` fills its gaps by ``aware``;
``mutual`` leaves out those pairs of it of which either has another partner much nearer, as where a wall stands for the cavity behind it.
``transport`` lets each y be taken once: the least sum of squared distances over all pairs, with a price for each x that stays alone
(unbalanced optimal transport, on blocks); what is alone afterwards, on either side, takes its nearest.
"""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
from scipy.sparse import csr_matrix
from scipy.sparse.csgraph import min_weight_full_bipartite_matching
from scipy.spatial import cKDTree

TURN = 0.06  # what two normals of opposite direction add to a distance, half of it, in diagonals
_FAR = 0.08  # diagonals: farther off nothing belongs together
_PARTNERS = 16  # of each point that are considered
_PRICE = 4.0  # of staying alone, in distances between points, beyond the distance of the nearest
_BARE = 4.0  # times as far from any bound point as from the next point: nothing came to lie there
_FARTHER = 1.5  # times as far as the nearest, and a distance between points more, is what a mutual partner may be
_BLOCK = 2048  # points of the structure that are assigned together, at most
_COARSE = 1e-7  # prices are whole multiples of this: sums of them are then the same in any order

Pairs = tuple[np.ndarray, np.ndarray]


def features(points: np.ndarray, normals: np.ndarray, diagonal: float, turn: float = TURN) -> np.ndarray:
    """(n, 6) places and normals in diagonals."""
    return np.concatenate([points / diagonal, turn * normals], axis=1)


def nearest(x: np.ndarray, y: np.ndarray) -> Pairs:
    """Pairs (k,) of features of the structure and of the cloud: the paper's correspondence, by places alone."""
    apart, there = cKDTree(y[:, :3]).query(x[:, :3])
    own = np.flatnonzero(apart < _FAR)
    return own, there[own]


def aware(x: np.ndarray, y: np.ndarray) -> Pairs:
    """The same by places and normals."""
    apart, there = cKDTree(y).query(x)
    own = np.flatnonzero(apart < _FAR)
    return own, there[own]


def project(x: np.ndarray, y: np.ndarray) -> Pairs:
    """Each point of the cloud at the place of the structure that is nearest to it, by places and normals."""
    apart, there = cKDTree(x).query(y)
    own = np.flatnonzero(apart < _FAR)
    return there[own], own


def both(x: np.ndarray, y: np.ndarray) -> Pairs:
    """``project``, and where nothing of the cloud came to lie on the structure, ``aware``."""
    here, there = project(x, y)
    own, partner = aware(x, y)
    if not len(here):
        return own, partner
    bare = cKDTree(x[here]).query(x[own])[0] > _BARE * float(np.median(cKDTree(x).query(x, k=2)[0][:, 1]))
    return np.concatenate([here, own[bare]]), np.concatenate([there, partner[bare]])


def mutual(x: np.ndarray, y: np.ndarray) -> Pairs:
    """Those pairs of ``both`` that either end would take: one hardly farther off than its own nearest."""
    here, there = both(x, y)
    way = x[here] - y[there]
    apart, known = np.sqrt((way * way).sum(axis=1)), cKDTree(x)
    least = np.minimum(cKDTree(y).query(x)[0][here], known.query(y)[0][there])
    good = apart <= _FARTHER * least + 2.0 * float(np.median(known.query(x, k=2)[0][:, 1]))
    return here[good], there[good]


def transport(x: np.ndarray, y: np.ndarray) -> Pairs:
    """One to one as far as that pays, the rest as by ``aware`` and ``project``."""
    tree = cKDTree(y)
    apart, there = tree.query(x, k=min(_PARTNERS, len(y)))
    apart, there = apart.reshape(len(x), -1), there.reshape(len(x), -1)
    price = _PRICE * float(np.median(apart[:, 0]))
    partner = np.full(len(x), -1)
    for block in _blocks(x[:, :3]):
        partner[block] = _matched(apart[block], there[block], price)
    alone = np.flatnonzero((partner < 0) & (apart[:, 0] < _FAR))
    partner[alone] = there[alone, 0]
    partner[apart[:, 0] >= _FAR] = -1
    own = np.flatnonzero(partner >= 0)
    taken = np.zeros(len(y), dtype=bool)
    taken[partner[own]] = True
    left = np.flatnonzero(~taken)
    more, which = project(x, y[left])
    return np.concatenate([own, more]), np.concatenate([partner[own], left[which]])


def _matched(apart: np.ndarray, there: np.ndarray, price: float) -> np.ndarray:
    """The partner of each point, -1 for those that stay alone: each has a stand-in of its own beside its candidates."""
    count, several = apart.shape
    known, column = np.unique(there, return_inverse=True)
    column = np.concatenate([column.reshape(there.shape), len(known) + np.arange(count)[:, None]], axis=1)
    cost = np.concatenate([apart**2, (apart[:, :1] + price) ** 2], axis=1)
    cost = np.round(cost / _COARSE) * _COARSE + 1e-6  # of sparse matrices, what is 0 is absent
    shape = count, len(known) + count
    begin = np.arange(count + 1) * (several + 1)
    _, chosen = min_weight_full_bipartite_matching(csr_matrix((cost.ravel(), column.ravel(), begin), shape=shape))
    return np.where(chosen < len(known), known[np.minimum(chosen, len(known) - 1)], -1)


def _blocks(points: np.ndarray) -> list[np.ndarray]:
    """Points in groups of neighbours, halved across their longest side until each is small enough."""
    waiting, found = [np.arange(len(points))], []
    while waiting:
        some = waiting.pop()
        if len(some) <= _BLOCK:
            found.append(np.sort(some))
            continue
        axis = int(np.argmax(np.ptp(points[some], axis=0)))
        order = some[np.argsort(points[some, axis], kind="stable")]
        waiting += [order[: len(order) // 2], order[len(order) // 2 :]]
    return found


ASSIGNMENTS: dict[str, Callable[[np.ndarray, np.ndarray], Pairs]] = {
    "mutual": mutual,
    "both": both,
    "project": project,
    "aware": aware,
    "transport": transport,
    "nearest": nearest,
}
"""By name; the first is the default."""
CHECKED = ("mutual",)  # accidents among their pairs are refused
# their x are where points of the cloud happened to find the nearest of a sample
REFINED = (*CHECKED, "both", "project")
