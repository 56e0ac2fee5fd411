"""How the objects of a category compare with real ones: their sizes, their shapes by chamfer distances both ways, their labels.

Shapes are compared as outer surfaces, each moved to the middle of its box and scaled to a diagonal of 1. Coverage and minimum matching
distance are those of Achlioptas et al., "Learning representations and generative models for 3D point clouds" (ICML 2018).
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence

import numpy as np
from scipy.spatial import cKDTree

from ..annotate.cloud import sample_points
from ..geometry.nearest import Nearest
from ..quality.sizes import measure_extents
from ..records import dataclass
from ..runtime.batch import Batch
from .outer import outer
from .pose import Posed, turn

_POINTS = 2048  # of each object: two samplings of one surface are then about 1.8 % apart
_TRIED = 48  # of our objects that tell how a real one stands
_FAR = 1.5  # a real object is far from all of ours if it is so many times as far as real ones are from each other
_APART = 16.0  # diagonals between clouds that are searched together
_AXES = ("width", "depth", "height")
_RATIOS = ("width/height", "depth/height")


@dataclass(frozen=True, slots=True)
class Range:
    """5th percentile, median and 95th percentile of ``name`` of ours and of the real ones, metres or ratios; ``within``: the share of
    the real ones that lie between our percentiles."""

    name: str
    ours: tuple[float, float, float]
    real: tuple[float, float, float]
    within: float


@dataclass(frozen=True, slots=True)
class Word:
    """The share of the surface that has a label and bears this ``word``, over the objects that bear it, and in what share of the objects
    it occurs."""

    word: str
    share: tuple[float, float]
    present: tuple[float, float]


@dataclass(frozen=True, slots=True)
class Likeness:
    """``nearest`` (R,): from each real object to the nearest of ours, chamfer distance in percent of the diagonal; ``which`` (R,) the
    number of that one, ``front`` (R,) the axis that was found to face the front. ``matching`` is the mean of ``nearest`` (MMD),
    ``back`` the mean from ours to the nearest real one, ``between`` that from each real one to the nearest other (None for one
    alone). ``coverage``: the share of the real ones that are the nearest of some of ours; ``far``: which real ones no object of ours
    comes near. Sizes are missing where the files have no scale, ratios are not; words where no map names any."""

    objects: int
    nearest: np.ndarray
    which: np.ndarray
    front: list[str]
    matching: float
    back: float
    between: float | None
    coverage: float
    far: list[int]
    ranges: list[Range]
    words: list[Word]


def measure_likeness(
    batch: Batch,
    real: Sequence[Posed],
    words: Mapping[str, str] | None = None,
    progress: Callable[[int, int], None] | None = None,
) -> Likeness:
    """The objects of a batch beside real ones. ``words``: which word of the vocabulary ``semantic`` a name of a label means."""
    drawn = sample_points(batch, _POINTS)
    seen = outer(drawn.position)
    owner = np.repeat(np.arange(len(batch)), seen.sum(axis=1))
    ours = _Clouds(_normalised(drawn.position[seen], owner, len(batch)), owner, len(batch))
    few = ours.first(min(_TRIED, len(batch)))
    clouds, fronts, sizes, far = [], [], [], []
    for number, posed in enumerate(real):
        stands = [posed.points[:_POINTS] @ turn(up, front).T for up, front in posed.turns]
        tried = [few.distances(_normalised(one)).min() for one in stands] if len(stands) > 1 else [0.0]
        best = int(np.argmin(tried))
        clouds.append(_normalised(stands[best]))
        fronts.append(posed.turns[best][1])
        sizes.append(np.ptp(posed.points @ turn(*posed.turns[best]).T, axis=0))
        far.append(ours.distances(clouds[-1]))
        if progress:
            progress(number + 1, len(real))
    apart = np.stack(far)  # (R, B)
    between = _between(clouds) if len(clouds) > 1 else None
    nearest = apart.min(axis=1)
    limit = np.inf if between is None else _FAR * float(np.median(between))
    return Likeness(
        objects=len(batch),
        nearest=100 * nearest,
        which=np.asarray(batch.numbers)[apart.argmin(axis=1)],
        front=fronts,
        matching=100 * float(nearest.mean()),
        back=100 * float(apart.min(axis=0).mean()),
        between=None if between is None else 100 * float(between.mean()),
        coverage=len(np.unique(apart.argmin(axis=0))) / len(real),
        far=np.flatnonzero(nearest > limit).tolist(),
        ranges=_ranges(measure_extents(batch), np.stack(sizes), np.array([posed.known for posed in real])),
        words=_compare_words(batch, drawn.semantic, real, words or {}),
    )


def _normalised(points: np.ndarray, owner: np.ndarray | None = None, count: int = 1) -> np.ndarray:
    """Points (n, 3) of one cloud, or of ``count`` with their ``owner`` (n,), in the middle and with a diagonal of 1."""
    owner = np.zeros(len(points), np.int64) if owner is None else owner
    low, high = np.full((count, 3), np.inf), np.full((count, 3), -np.inf)
    np.minimum.at(low, owner, points)
    np.maximum.at(high, owner, points)
    across = np.sqrt(((high - low) ** 2).sum(axis=1))
    return np.asarray((points - ((low + high) / 2)[owner]) / across[owner, None])


class _Clouds:
    """Many clouds, normalised, that are searched together."""

    def __init__(self, points: np.ndarray, owner: np.ndarray, count: int):
        self.points, self.owner, self.count = points, owner, count
        self.size = np.bincount(owner, minlength=count)
        self.tree = Nearest(points, owner, _APART)

    def first(self, count: int) -> _Clouds:
        mine = self.owner < count
        return _Clouds(self.points[mine], self.owner[mine], count)

    def distances(self, cloud: np.ndarray) -> np.ndarray:
        """(count,): the mean of both mean distances of nearest points between ``cloud`` (n, 3) and each of these."""
        there = cKDTree(cloud).query(self.points)[0]
        to_cloud = np.bincount(self.owner, there, minlength=self.count) / self.size
        asked = np.tile(cloud, (self.count, 1)), np.repeat(np.arange(self.count), len(cloud))
        back = self.tree.find(*asked)[0].reshape(self.count, len(cloud)).mean(axis=1)
        return np.asarray((to_cloud + back) / 2)


def _between(clouds: Sequence[np.ndarray]) -> np.ndarray:
    """(R,): from each cloud to the nearest other."""
    owner = np.repeat(np.arange(len(clouds)), [len(cloud) for cloud in clouds])
    every = _Clouds(np.concatenate(clouds), owner, len(clouds))
    apart = np.stack([every.distances(cloud) for cloud in clouds])
    np.fill_diagonal(apart, np.inf)
    return np.asarray(apart.min(axis=1))


def _ranges(ours: np.ndarray, real: np.ndarray, scaled: np.ndarray) -> list[Range]:
    """Sizes (B, 3) and (R, 3) along x, y, z, of real ones that are ``scaled`` (R,); and ratios, which need no scale."""
    mine, theirs = ours[:, [1, 0, 2]], real[:, [1, 0, 2]]
    found = [_range(name, mine[:, k], theirs[scaled, k]) for k, name in enumerate(_AXES) if scaled.any()]
    deep, high = mine[:, 2] > 0, theirs[:, 2] > 0
    for k, name in enumerate(_RATIOS):
        found.append(_range(name, mine[deep, k] / mine[deep, 2], theirs[high, k] / theirs[high, 2]))
    return found


def _range(name: str, ours: np.ndarray, real: np.ndarray) -> Range:
    low, middle, high = (float(v) for v in np.percentile(ours, (5, 50, 95)))
    least, usual, most = (float(v) for v in np.percentile(real, (5, 50, 95)))
    within = float(((real >= low) & (real <= high)).mean())
    return Range(name, (low, middle, high), (least, usual, most), within)


def _compare_words(batch: Batch, semantic: np.ndarray, real: Sequence[Posed], words: Mapping[str, str]) -> list[Word]:
    """Labels of ours (B, n) and of the real ones, for the words that ``words`` speaks of."""
    names = batch.program.vocabularies.get("semantic", ())
    asked = [k for k, name in enumerate(names) if name in set(words.values())]
    if not asked:
        return []
    mine = np.stack([(semantic == k).mean(axis=1) for k in asked], axis=1)
    theirs = np.stack([_shares(posed, [names[k] for k in asked], words) for posed in real])
    theirs = theirs[theirs.sum(axis=1) > 0]
    if not len(theirs):
        return []
    told = []
    for column, k in enumerate(asked):
        (share, present), (real_share, real_present) = (_spread(of, column) for of in (mine, theirs))
        told.append(Word(names[k], (share, real_share), (present, real_present)))
    return told


def _spread(shares: np.ndarray, column: int) -> tuple[float, float]:
    """Of shares (n, words): the mean share of a word where it occurs, and how often it does."""
    one = shares[:, column] / np.maximum(shares.sum(axis=1), 1e-12)
    there = one > 0
    return float(one[there].mean()) if there.any() else 0.0, float(there.mean())


def _shares(posed: Posed, names: Sequence[str], words: Mapping[str, str]) -> np.ndarray:
    """The share of a real object's points that each word covers."""
    meaning = [words.get(name) for name in posed.names]
    says = [[k for k, meant in enumerate(meaning) if meant == name] for name in names]
    return np.array([np.isin(posed.label, labels).mean() for labels in says])
