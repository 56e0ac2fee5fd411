"""Points drawn as a sampling wants them: which of them are on what, in which order, and what they stand for."""

from __future__ import annotations

from collections.abc import Callable
from typing import TYPE_CHECKING

import numpy as np

from .. import random
from ..diagnostics.suggest import did_you_mean
from ..errors import UsageError
from ..geometry import blue
from ..geometry import points as geometry
from ..geometry.pointset import PointSet, Pools
from ..geometry.runs import absent, runs
from ..geometry.sites import SiteTable
from ..records import dataclass
from .sampling import Sampling

if TYPE_CHECKING:
    from ..runtime.batch import Batch


@dataclass(frozen=True, slots=True)
class DrawnPoints:
    """Points (P, n), the objects (P,) that they are on, and how much surface each stands for (P, n), square metres."""

    points: PointSet
    owner: np.ndarray
    area: np.ndarray


Weigh = Callable[[Pools], np.ndarray]  # (P,): what each pool weighs
_ORDER = 0xFFFFFFFF  # the attempt whose stream orders points: no draw comes so far


def draw_points(
    sites: list[SiteTable], n_objects: int, how: Sampling, key: random.Key, address: np.ndarray, weigh: Weigh
) -> DrawnPoints:
    """Points in a random order. Raises PointsError for objects without such surface."""
    outside, n = how.surface == "outside", int(how.count)
    times = blue.TIMES if how.spread == "blue" else 1
    labels = [_labels(table, how.balance or how.per) for table in sites]
    if how.balance:
        return _balanced(sites, labels, n_objects, how, key, address, weigh)

    def shuffled(pools: Pools) -> np.ndarray:
        return _shuffle(key, random.mix(address[pools.owner], pools.label), n)

    order = shuffled if times == 1 else None  # else they are thinned first
    found, pools, area = geometry.sample_pools(
        sites, labels, n_objects, n * times, key, address, outside=outside, order=order
    )
    bare = absent(n_objects, pools.owner)
    if len(bare):
        raise geometry.PointsError(bare.tolist())
    if times > 1:
        thinned = found.take(_places(blue.thin(found.position, found.normal, area, n)))
        found = thinned.take(_places(shuffled(pools)))
    return DrawnPoints(found, pools.owner, np.repeat(area[:, None] / n, n, axis=1))


def _balanced(
    sites: list[SiteTable],
    labels: list[np.ndarray],
    n_objects: int,
    how: Sampling,
    key: random.Key,
    address: np.ndarray,
    weigh: Weigh,
) -> DrawnPoints:
    """The points of each object shared out over its pools by weight; what shows no surface leaves its own to others."""
    n, times = int(how.count), blue.TIMES if how.spread == "blue" else 1
    pools = Pools.of(sites, labels, n_objects)
    weight, area = weigh(pools), np.zeros(len(pools.owner))
    counts, open_ = np.zeros(len(pools.owner), dtype=np.int64), np.ones(len(pools.owner), dtype=bool)
    parts: list[tuple[np.ndarray, PointSet]] = []  # rows of pools, and their points
    while open_.any():  # the pools of objects that are not settled yet
        wanted = np.where(open_, share_out(pools.owner, np.where(open_, weight, 0.0), n), 0)
        found, full, shown = geometry.sample_counts(
            sites, pools, wanted * times, key, address, outside=how.surface == "outside"
        )
        again = np.isin(pools.owner, pools.owner[open_ & ~full])
        done = np.flatnonzero(open_ & ~again & (wanted > 0))
        counts[done], area[done] = wanted[done], shown[done]
        parts.append((done, found.take(done)))
        weight = np.where(full, weight, 0.0)
        open_ = again & (weight > 0)
    bare = absent(n_objects, pools.owner[counts > 0])
    if len(bare):
        raise geometry.PointsError(bare.tolist())
    row = np.concatenate([np.repeat(rows, counts[rows]) for rows, _ in parts])
    made = [_first_of(found, counts[rows], area[rows], times) for rows, found in parts]
    order = np.argsort(pools.owner[row], kind="stable")
    flat = PointSet(*(np.concatenate([getattr(one, name) for one in made])[order] for name in PointSet.__slots__))
    whole = flat.shaped(n_objects, n)
    share = (area[row] / counts[row])[order].reshape(n_objects, n)
    mixed = _places(_shuffle(key, address, n))
    return DrawnPoints(whole.take(mixed), np.arange(n_objects), share[mixed])


def make_weigher(batch: Batch, how: Sampling) -> Weigh:
    """What the pools of a sampling weigh. Raises UsageError for weights of what the program does not have."""
    program = batch.program
    known: list[str] = {
        "": [],
        "semantic": list(program.vocabularies.get("semantic", ())),
        "instance": [part.path for part in program.parts],
        "link": [link.path for link in program.links],
        "primitive": [site.path for site in program.sites],
    }[how.balance]
    said = {label.name for label in program.labels if label.vocabulary == "semantic"}
    usable = [name for name in known if how.balance != "semantic" or name in said]
    for name, _ in how.weights:
        if name not in usable:
            raise UsageError(
                f"{program.name} has no {how.balance} `{name}` to weigh",
                did_you_mean(name, usable) or f"it has {', '.join(dict.fromkeys(usable))}",
            )
    weights = dict(how.weights)
    value = np.array([weights.get(name, 1.0) for name in known])

    def weigh(pools: Pools) -> np.ndarray:
        if how.balance == "semantic":
            return value[pools.label]
        if how.balance == "primitive":
            return value[(pools.label >> 32) - 1]
        table = batch.links() if how.balance == "link" else batch.parts()
        return value[table.definition[np.searchsorted(table.owner, pools.owner) + pools.label]]

    return weigh


def share_out(owner: np.ndarray, weight: np.ndarray, n: int) -> np.ndarray:
    """Whole numbers (P,), n for each owner in all, in the proportion of the weights as near as can be."""
    total = np.bincount(owner, weight)[owner]
    exact = np.where(weight > 0, n * weight / np.where(total > 0, total, 1.0), 0.0)
    found = np.floor(exact + 1e-9).astype(np.int64)
    missing = n - np.bincount(owner, found).astype(np.int64)
    left = np.where(weight > 0, np.round(exact - found, 9), -1.0)
    order = np.lexsort((np.arange(len(owner)), -left, owner))
    rank = np.arange(len(owner)) - np.searchsorted(owner[order], owner[order])
    found[order] += (rank < missing[owner[order]]) & (weight[order] > 0)
    return found


def _first_of(found: PointSet, counts: np.ndarray, area: np.ndarray, times: int) -> PointSet:
    """The first ``counts`` (P,) points of each pool, in one row; of ``times`` as many those that keep their distance."""
    if times > 1:
        kept = np.zeros(found.u.shape, dtype=np.int64)
        for count in np.unique(counts).tolist():
            rows = np.flatnonzero(counts == count)
            many = found.take((rows[:, None], np.arange(count * times)))
            kept[rows, :count] = blue.thin(many.position, many.normal, area[rows], count)
        found = found.take(_places(kept))
    row = np.repeat(np.arange(len(counts)), counts)
    return found.take((row, runs(np.zeros_like(counts), counts)))


def _shuffle(key: random.Key, address: np.ndarray, n: int) -> np.ndarray:
    """(P, n): an order of the points of each pool that its address draws: the first of them are a sample of it, too."""
    return random.orders(random.streams(key, address, _ORDER), n)


def _places(column: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """The rows and columns of some columns (P, n) of each row."""
    return np.arange(len(column))[:, None], column


def _labels(table: SiteTable, per: str) -> np.ndarray:
    """Which pool of its object each row of a site belongs to."""
    if per == "object":
        return np.zeros(len(table), dtype=np.int64)
    if per == "primitive":
        return np.int64(table.number + 1) << 32 | table.rank
    return getattr(table, per)
