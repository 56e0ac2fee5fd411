"""How points are to be taken from surfaces: how many of what, from which surface, how spread."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np

from ..errors import UsageError
from ..geometry import blue
from ..geometry import points as geometry
from ..geometry.sites import SiteTable
from ..graph import random

SURFACES = {
    "boundary": "of the union of all primitives, also where only an opened door would show it",
    "outside": "what of it can be seen from without, with all joints at 0",
}
SPREADS = {"random": "each point for itself", "blue": "points keep their distance from one another"}
POOLS = {
    "object": "the object",
    "semantic": "each class of parts",
    "instance": "each part instance",
    "link": "each link",
    "primitive": "each primitive",
}
MOST = 1_000_000
_ORDER = 0xFFFFFFFF  # the attempt whose stream orders points: no draw comes so far


@dataclass(frozen=True, slots=True)
class Sampling:
    """``count`` points per ``per`` (of ``POOLS``) on the ``surface`` (of ``SURFACES``), ``spread`` as of ``SPREADS``.

    Raises UsageError.
    """

    count: int = 2048
    surface: str = "boundary"
    spread: str = "random"
    per: str = "object"

    def __post_init__(self) -> None:
        if isinstance(self.count, bool) or not isinstance(self.count, int | np.integer):
            raise UsageError(f"the number of points is {self.count!r}: a whole number is needed", "for example 2048")
        if not 1 <= self.count <= MOST:
            raise UsageError(f"the number of points is {self.count}", f"give a number from 1 to {MOST}")
        for name, known in (("surface", SURFACES), ("spread", SPREADS), ("per", POOLS)):
            value = getattr(self, name)
            if value not in known:
                raise UsageError(f"{name} is {value!r}", f"it may be {', '.join(known)}")

    def plain(self) -> dict[str, Any]:
        return {"points": int(self.count), "surface": self.surface, "spread": self.spread, "per": self.per}


def draw(
    sites: list[SiteTable], n_objects: int, how: Sampling, key: random.Key, address: np.ndarray
) -> tuple[geometry.PointSet, np.ndarray]:
    """Points (P, n) and the objects (P,) that they are on, in a random order. Raises PointsError for objects without
    such surface."""
    outside, n = how.surface == "outside", int(how.count)
    if how.per == "object" and how.spread == "random":
        whole = geometry.sample(sites, n_objects, n, key, address, outside=outside)
        return shuffled(whole, key, address), np.arange(n_objects)
    times = blue.TIMES if how.spread == "blue" else 1
    found, pools, area = geometry.sample_pools(
        sites, [_labels(table, how.per) for table in sites], n_objects, n * times, key, address, outside=outside
    )
    bare = np.setdiff1d(np.arange(n_objects), pools.owner)
    if len(bare):
        raise geometry.PointsError(bare.tolist())
    made = found if times == 1 else thinned(found, area, n)
    return shuffled(made, key, random.mix(address[pools.owner], pools.label)), pools.owner


def shuffled(found: geometry.PointSet, key: random.Key, address: np.ndarray) -> geometry.PointSet:
    """The points of each pool in an order that its address draws: the first of them are a sample of it, too."""
    order = random.orders(random.streams(key, address, _ORDER), found.u.shape[1])
    order += np.arange(len(order))[:, None] * order.shape[1]
    flat, shape = order.ravel(), order.shape
    return geometry.PointSet(
        *(np.take(array.reshape(-1, *array.shape[2:]), flat, axis=0).reshape(*shape, *array.shape[2:])
          for array in (getattr(found, name) for name in geometry.PointSet.__slots__))
    )  # fmt: skip


def thinned(found: geometry.PointSet, area: np.ndarray, n: int) -> geometry.PointSet:
    """The n points of each pool that keep their distance."""
    kept = blue.thin(found.position, found.normal, area, n)
    place = np.arange(len(kept))[:, None], kept
    return found.take(place)


def _labels(table: SiteTable, per: str) -> np.ndarray:
    """Which pool of its object each row of a site belongs to."""
    if per == "object":
        return np.zeros(len(table), dtype=np.int64)
    if per == "primitive":
        return np.int64(table.number + 1) << 32 | table.rank
    return getattr(table, per)
