"""How different the kinematic graphs of a category are: the mean normalised edit distance between pairs of objects.

The edit distance of unordered trees is NP-hard; this is the constrained one, in which separate subtrees go to separate
subtrees (Zhang, "A constrained edit distance between unordered labeled trees", Algorithmica 15, 1996): an upper bound,
and equal to it on nearly all trees as shallow as these. Relabelling, adding and removing a node cost 1 each. It is
divided by the number of nodes of the larger tree.
"""

from __future__ import annotations

import numpy as np
from scipy.optimize import linear_sum_assignment

from ..random import key, uniform
from .graphs import Graphs

_EXACT = 24  # distinct graphs up to which all pairs are compared
_PAIRS = 400  # of objects, drawn when there are more


class Distance:
    """Distances between subtrees of one set of graphs, by their codes; what was computed is kept."""

    def __init__(self, graphs: Graphs):
        self.nodes = graphs.nodes
        self.size: list[int] = []
        for node in self.nodes:
            self.size.append(1 + sum(self.size[c] for c in node.children))
        self._trees: dict[tuple[int, int], int] = {}
        self._forests: dict[tuple[int, int], int] = {}

    def normalised(self, a: int, b: int) -> float:
        return self.tree(a, b) / max(self.size[a], self.size[b])

    def tree(self, a: int, b: int) -> int:
        """The distance between two subtrees."""
        if a == b:
            return 0
        if a > b:
            a, b = b, a  # it is symmetric
        found = self._trees.get((a, b))
        if found is None:
            first, second = self.nodes[a], self.nodes[b]
            size = self.size
            relabel = int((first.joint, first.part) != (second.joint, second.part))
            ways = [relabel + self.forest(a, b)]
            ways += [size[b] - size[c] + self.tree(a, c) for c in set(second.children)]
            ways += [size[a] - size[c] + self.tree(c, b) for c in set(first.children)]
            found = self._trees[a, b] = min(ways)
        return found

    def forest(self, a: int, b: int) -> int:
        """The distance between the children of two nodes."""
        if a > b:
            a, b = b, a
        found = self._forests.get((a, b))
        if found is None:
            first, second = self.nodes[a].children, self.nodes[b].children
            size = self.size
            ways = [self._matching(first, second)]
            ways += [size[b] - size[c] + self.forest(a, c) for c in set(second)]
            ways += [size[a] - size[c] + self.forest(c, b) for c in set(first)]
            found = self._forests[a, b] = min(ways)
        return found

    def _matching(self, first: tuple[int, ...], second: tuple[int, ...]) -> int:
        """The cheapest way to give each subtree of two forests a partner, or to add or remove it."""
        one, two = _without(first, second), _without(second, first)  # equal subtrees are partners
        if not one or not two:
            return sum(self.size[c] for c in (*one, *two))
        n, m = len(one), len(two)
        cost = np.zeros((n + m, n + m))
        cost[:n, :m] = [[self.tree(x, y) for y in two] for x in one]
        cost[:n, m:] = np.array([self.size[x] for x in one])[:, None]
        cost[n:, :m] = np.array([self.size[y] for y in two])
        rows, columns = linear_sum_assignment(cost)
        return int(cost[rows, columns].sum())


def _without(children: tuple[int, ...], others: tuple[int, ...]) -> list[int]:
    """The children left when each that has an equal among the others is paired with it."""
    left, found = list(others), []
    for child in children:
        if child in left:
            left.remove(child)
        else:
            found.append(child)
    return found


def measure_distance(graphs: Graphs) -> tuple[float, int]:
    """The mean normalised distance between two different objects, and from how many pairs: all, or a sample of them."""
    distance = Distance(graphs)
    kind, count = graphs.kinds
    objects = int(count.sum())
    if objects < 2:
        return 0.0, 0
    if len(kind) <= _EXACT:
        total = 0.0
        for i in range(len(kind)):
            for j in range(i):
                total += 2.0 * int(count[i]) * int(count[j]) * distance.normalised(int(kind[i]), int(kind[j]))
        return total / (objects * (objects - 1)), objects * (objects - 1) // 2
    index = np.arange(_PAIRS)
    first = (uniform(key(0, "pair of graphs", "first"), index) * objects).astype(np.int64)
    second = (uniform(key(0, "pair of graphs", "second"), index) * (objects - 1)).astype(np.int64)
    second += second >= first  # another object
    code = graphs.code
    pairs = zip(code[first].tolist(), code[second].tolist(), strict=True)
    return sum(distance.normalised(a, b) for a, b in pairs) / _PAIRS, _PAIRS
