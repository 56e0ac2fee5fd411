"""Where clouds have been seen: what surfaces that are not in question say of those that are.

A scan has holes, and what lies in one is not known to be absent. Whether a place was seen is told by the surface beside it which two
candidates share: where this has points of the cloud, what only one of the candidates has would have some too. Beside means by place and
normal, so that the front of a sheet tells nothing of its back.
"""

from __future__ import annotations

import numpy as np

from ..geometry.nearest import Nearest
from ..records import dataclass
from .match import REACH
from .words import SETS_APART

_SEEN = 0.04  # diagonals: where the nearest point of the cloud, by place and normal, lies nearer, a surface was seen
_BESIDE = 12  # points of a surface that tell of a place
# of them: a place was not seen if no more than the first were, and was if the second were: rims and noise are between
_SHARES = 0.25, 0.75


class Sight:
    """Clouds whose ``points`` (n, 6), by place and normal in diagonals, are told apart by sets, and lie ``apart`` (T,)."""

    def __init__(self, points: Nearest, apart: np.ndarray):
        self._points, self._reach = points, _SEEN + REACH * apart

    def at(self, places: np.ndarray, target: np.ndarray) -> np.ndarray:
        """(m,) bool: which places (m, 6) the clouds ``target`` (m,) have points near."""
        within = self._reach[target].max(initial=0.0)
        return self.near(self._points.find(places, target, within)[0], target)

    def near(self, far: np.ndarray, target: np.ndarray) -> np.ndarray:
        """(m,) bool: the same of places whose nearest points are known to be so ``far`` (m,)."""
        return np.asarray(far < self._reach[target])


@dataclass(frozen=True, slots=True, eq=False)
class Coverage:
    """Points of K surfaces, ``count`` (K,) of each, and which of them were ``seen``; ``whole`` (K,): of a surface too few were not seen
    to matter anywhere."""

    tree: Nearest | None
    count: np.ndarray
    seen: np.ndarray
    whole: np.ndarray

    @staticmethod
    def of(places: np.ndarray, shared: np.ndarray, seen: np.ndarray) -> Coverage:
        """Of those of ``places`` (K, n, 6) that are ``shared`` (K, n); ``seen`` (K, n) of these."""
        count = shared.sum(axis=1)
        whole = (shared & ~seen).sum(axis=1) <= (1.0 - _SHARES[1]) * np.minimum(count, _BESIDE)
        own, point = np.nonzero(shared & ~whole[:, None])
        tree = Nearest(places[own, point], own, SETS_APART) if len(own) else None
        return Coverage(tree, count, np.append(seen[own, point], False), whole)

    def at(self, places: np.ndarray, of: np.ndarray) -> np.ndarray:
        """(m,) how far places (m, 6) were seen, by what was of the surfaces ``of`` (m,) beside them: 0 to 1, and 1 where a surface has no
        points."""
        found = np.ones(len(places))
        doubtful = np.flatnonzero(~self.whole[of])
        if self.tree is None or not len(doubtful):
            return found
        own = of[doubtful]
        many = np.minimum(self.count[own], _BESIDE)
        near = self.tree.several(places[doubtful], own, _BESIDE)
        seen = (self.seen[near] & (np.arange(_BESIDE) < many[:, None])).sum(axis=1)
        low, high = _SHARES
        found[doubtful] = np.clip((seen / many - low) / (high - low), 0.0, 1.0)
        return found
