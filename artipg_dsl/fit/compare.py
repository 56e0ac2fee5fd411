"""Candidates beside what they are fitted to: points of both, matched both ways, and one figure of how far apart they are."""

from __future__ import annotations

from dataclasses import fields, replace
from typing import Any

import numpy as np

from .. import random
from ..geometry import points as geometry
from ..geometry.pointset import PointSet
from ..geometry.sites import SiteTable
from ..geometry.vectors import dot
from ..records import dataclass
from ..runtime.batch import Batch
from .focus import Rows, spread
from .match import Gaps, features, gaps, nearest
from .model import Placed
from .outer import outer, spacing
from .states import tables
from .words import unlike, words_of_rows

FARTHEST = 0.08  # diagonals: what lies farther off counts as lying so far, and what is another thing by its label
_SHOWN = 0.02  # diagonals: the same of the points of a candidate, if its cloud is a scan, as they may lie in a hole
_SCAN = 2.5e-3  # diagonals: a cloud with more noise than this is a scan


@dataclass(frozen=True, slots=True, eq=False)
class Targets:
    """Clouds of the outer surface of T objects, each in one pose: ``points``, ``normals`` (T, M, 3), ``diagonal`` (T,) of the box
    ``low`` .. ``high`` (T, 3), ``apart`` (T, M) how far each lies from others, ``noise`` (T,) across the surface, in diagonals.
    ``of`` (T,): which object it is; ``known`` (T,): whether its scale is. ``count`` (T,): how many points there are; others
    are the same again. The first points of a cloud are a sample of it. ``word`` (T, M) of ``semantic``, 0 where nothing is said; ``meant``
    (W,): which words may be. ``link`` (T, M): which link of the object a point lies on, where that is known, and ``twist`` (T, R, 6) how
    its R links move; R is 0 where it is not."""

    points: np.ndarray
    normals: np.ndarray
    diagonal: np.ndarray
    apart: np.ndarray
    low: np.ndarray
    high: np.ndarray
    of: np.ndarray
    known: np.ndarray
    noise: np.ndarray
    count: np.ndarray
    word: np.ndarray
    meant: np.ndarray
    link: np.ndarray
    twist: np.ndarray

    def __len__(self) -> int:
        return len(self.of)

    @property
    def size(self) -> np.ndarray:
        return self.high - self.low

    @property
    def scanned(self) -> np.ndarray:
        """(T,) bool: whether their noise is that of scans, which have holes."""
        return self.noise > _SCAN

    @property
    def jointed(self) -> bool:
        """Whether links are known of some of them."""
        return self.twist.shape[1] > 0

    def take(self, at: np.ndarray) -> Targets:
        """Some of them."""
        each = {field.name: getattr(self, field.name)[at] for field in fields(self) if field.name != "meant"}
        return replace(self, **each)

    def first(self, count: int) -> Targets:
        """With ``count`` points at most."""
        fewer = np.minimum(self.count, count)
        apart = self.apart[:, :count] * np.sqrt(self.count / fewer)[:, None]
        columns = {name: getattr(self, name)[:, :count] for name in ("points", "normals", "word", "link")}
        return replace(self, apart=apart, count=fewer, **columns)


@dataclass(frozen=True, slots=True, eq=False)
class Candidates:
    """K objects of a program, each for the target of number ``target``, placed in its frame; ``score`` is how far apart they are."""

    batch: Batch
    target: np.ndarray
    placed: Placed
    score: np.ndarray

    def __len__(self) -> int:
        return len(self.target)


@dataclass(frozen=True, slots=True, eq=False)
class Compared:
    """Points of candidates (K, n), each bound to (site, ``element`` of the candidate's primitives of that site, patch, u, v), and their
    ``position`` in the frames of the targets, with ``gaps`` from the targets' points (K, m) and
    their own (K, n), ``hidden`` (K, n) those inside; the pairs: ``there`` (K, m) and ``here`` (K, n); how much normals of
    pairs agree, and whether words do not."""

    points: PointSet
    element: np.ndarray
    position: np.ndarray
    hidden: np.ndarray
    there: np.ndarray
    here: np.ndarray
    to_surface: Gaps
    to_cloud: Gaps
    agree: tuple[np.ndarray, np.ndarray]
    unlike: tuple[np.ndarray, np.ndarray]
    score: np.ndarray

    def within(self, share: float) -> np.ndarray:
        """(K,) how far apart a ``share`` of the points lie at most, in diagonals: the mean of both ways."""
        theirs, own = _off(self.to_surface, self.unlike[0]), _off(self.to_cloud, self.unlike[1])
        return 0.5 * (_least(theirs, np.zeros(theirs.shape, dtype=bool), share) + _least(own, self.hidden, share))


def starts(sites: list[SiteTable]) -> np.ndarray:
    """Where the rows of each site begin, by its number, in the tables put together."""
    found = np.zeros(max((table.number for table in sites), default=0) + 2, dtype=np.int64)
    found[[table.number + 1 for table in sites]] = [len(table) for table in sites]
    return np.cumsum(found)


def chosen(better: np.ndarray, new: Compared, old: Compared) -> Compared:
    """The new ones where they are better."""

    def one(a: Any, b: Any) -> Any:
        if isinstance(a, np.ndarray):
            return np.where(better.reshape(-1, *[1] * (a.ndim - 1)), a, b)
        if isinstance(a, tuple):
            return tuple(one(*pair) for pair in zip(a, b, strict=True))
        return type(a)(*(one(getattr(a, field.name), getattr(b, field.name)) for field in fields(a)))

    made: Compared = one(new, old)
    return made


def clouds(batch: Batch, n: int, seed: int = 0) -> PointSet:
    """n points of the surfaces of candidates; those of one number fall on the same places of the same surface."""
    return geometry.sample(tables(batch), len(batch), n, random.key(seed, "fit"), batch.state.objects.astype(np.uint64))


def compare(
    batch: Batch, target: np.ndarray, placed: Placed, targets: Targets, n: int, marked: Rows | None = None
) -> Compared:
    """Candidates beside their targets, by n points of theirs; a third of these on rows that are ``marked``."""
    if marked is None:
        points = clouds(batch, n)
        position = placed.of(points.position)
        lying = spacing(position)
        hidden, apart = ~outer(position, lying), np.broadcast_to(lying[:, None], position.shape[:2])
    else:
        laid = spread(batch, marked, n - n // 3, n // 3)
        points = laid.points
        position, apart = placed.of(points.position), laid.apart * placed.scale[:, None]
        hidden = ~outer(position)
    diagonal = targets.diagonal[target][:, None]
    cloud, facing = targets.points[target], targets.normals[target]
    word, theirs = words_of(batch, points, targets.meant), targets.word[target]
    ours, asked = features(position, points.normal, diagonal, hidden), features(cloud, facing, diagonal)
    there, here = nearest(ours, asked, (word, theirs), targets.meant)
    every = np.arange(len(target))[:, None]
    near, outward = position[every, there], points.normal[every, there]
    found, back = cloud[every, here], facing[every, here]
    to_surface = gaps(near, cloud, outward, apart[every, there], diagonal)
    to_cloud = gaps(position, found, back, targets.apart[target[:, None], here], diagonal)
    agree = dot(outward, facing), dot(points.normal, back)
    others = unlike(word[every, there], theirs), unlike(word, theirs[every, here])
    most = np.where(targets.scanned[target], _SHOWN, FARTHEST)[:, None]
    own = np.where(hidden, 0.0, _off(to_cloud, others[1], most)).sum(axis=1)
    own /= np.maximum((~hidden).sum(axis=1), 1)
    score = 0.5 * (_off(to_surface, others[0]).mean(axis=1) + own)
    sites = tables(batch)
    rank = np.concatenate([table.rank for table in sites])
    element = rank[starts(sites)[points.site] + points.row]
    return Compared(points, element, position, hidden, there, here, to_surface, to_cloud, agree, others, score)


def words_of(batch: Batch, points: PointSet, meant: np.ndarray) -> np.ndarray:
    """(K, n) the words of points of candidates, as ``Targets.word`` has them."""
    if not len(meant):
        return np.zeros(points.site.shape, dtype=np.int64)
    return np.asarray(words_of_rows(batch, meant)[starts(tables(batch))[points.site] + points.row])


def _off(gap: Gaps, unlike: np.ndarray, most: np.ndarray | float = FARTHEST) -> np.ndarray:
    """What gaps count, in diagonals: so much at ``most``."""
    return np.where(unlike, FARTHEST, np.minimum(np.abs(gap.value), most))


def _least(off: np.ndarray, left_out: np.ndarray, share: float) -> np.ndarray:
    """(K,) what a ``share`` of the distances (K, n) is not above, but for those ``left_out`` (K, n)."""
    ascending = np.sort(np.where(left_out, np.inf, off), axis=1)
    last = np.maximum((~left_out).sum(axis=1) - 1, 0)
    return np.asarray(ascending[np.arange(len(off)), (share * last).astype(np.int64)])
