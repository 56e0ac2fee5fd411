"""What whole clouds say of candidates: how likely their points are for a surface, and the points of the surface for the cloud.

The mean distance hardly sees a hinge, since it averages over a door. Here each point of the cloud is a witness of its own: it is as likely
as its distance from the surface is for the noise of the cloud, with a long tail (Cauchy), so that a part that is missing, or one too many,
tells by all points that it has.

``weigh`` says so of whole candidates; ``weigh_change`` of copies that differ in a part from what they were made of, by the points
that lie there alone, so that hundreds can be asked about. Points of the surface count as far as the cloud was seen where they lie.
"""

from __future__ import annotations

from dataclasses import fields

import numpy as np

from ..geometry.vectors import corners
from ..records import dataclass
from ..runtime.batch import Batch
from .compare import FARTHEST, Targets, starts, words_of
from .coverage import Coverage, Sight
from .focus import Differing, Rows, small, spread
from .links import Held, Moving, Points, links_of_rows
from .match import REACH, Gaps, features, gaps
from .model import Placed
from .outer import Screens
from .states import tables
from .words import Twofold, unlike

_POINTS = 3072, 2048  # of a candidate: of its large primitives and of the small ones
_AROUND, _NEAR = 512, 320  # of a copy: of what it shares with its origin, and of what is new
LARGE = _NEAR / sum(_POINTS)  # of a surface: of more than this whole candidates have more points than copies
_WITNESSES = 8192  # what a cloud counts for at most, in points: more of them, beside one another, say the same
_ASKED = 512  # points of a cloud that are asked about a copy
_ROUGHLY = 384, 320, 512  # the same three where elements are put together
_MARGIN = 0.02  # diagonals around what is new
_MANY = 1 << 20  # more than rows of a site in an object, or sites
_ODD = 1.0  # a point that is less likely than this, in logarithms, may belong to something else
_LEAST_SEEN = 0.1  # of a surface: what less was seen of is no surface of this cloud
_ROUNDED = 1.0 + 1e-9  # what is so much farther off is farther off, however it was rounded
_LEAST_NOISE = 1.5e-3  # diagonals: by so much described surfaces differ from real ones in any case,
_CLOSE_NOISE = 1e-3  # and by so much once all numbers are refined


@dataclass(frozen=True, slots=True, eq=False)
class Evidence:
    """How unlikely points are, in natural logarithms, 0 where a point lies on the other surface: ``cloud`` (K, M) of the targets', each
    of which counts ``weight`` (K,), ``count`` (K,) in all; ``surface`` (K, n) of the candidates', each times the points of the cloud that it
    ``stands`` for (K, n), 0 where it is hidden; ``seen`` (K, n): whether the cloud has points there. ``of`` (K, M): the row of the candidate,
    among those of all tables, that is nearest to a point of the cloud; ``on`` (K, n): that a point of its own lies on, ``named`` (K, n) by
    site and rank; ``places`` (K, n, 6) where these are, with their normals, in diagonals."""

    cloud: np.ndarray
    surface: np.ndarray
    weight: np.ndarray
    count: np.ndarray
    stands: np.ndarray
    seen: np.ndarray
    named: np.ndarray
    of: np.ndarray
    on: np.ndarray
    places: np.ndarray
    links: Held

    def take(self, at: np.ndarray | slice) -> Evidence:
        """Of some of the candidates."""
        return Evidence(*(getattr(self, field.name)[at] for field in fields(self)))

    @property
    def total(self) -> np.ndarray:
        """(K,) of each candidate; less is better."""
        return np.asarray(self.weight * (self.cloud + self.links.strange).sum(axis=1) + self.surface.sum(axis=1))


@dataclass(frozen=True, slots=True, eq=False)
class Copies:
    """Candidates made of others, ``of`` which (K,), each for its target."""

    batch: Batch
    of: np.ndarray
    target: np.ndarray
    placed: Placed


class Clouds:
    """The clouds of targets, each asked for the nearest of its points. ``closely``: a point belongs to what it is likeliest for, be that large
    or small; else to what has the nearest point, which mostly is small, as small primitives have more points."""

    def __init__(self, targets: Targets, *, closely: bool = False):
        self.targets, self.closely, few = targets, closely, targets.first(_WITNESSES)
        own = np.repeat(np.arange(len(targets)), targets.points.shape[1])
        theirs = features(targets.points, targets.normals, targets.diagonal[:, None]).reshape(-1, 6)
        word = targets.word.ravel()
        self._points = Twofold(theirs, own, word, targets.meant)
        self.screens = Screens(few.points, few.apart[:, 0])
        self._sight = Sight(self._points.both.every, targets.apart[:, 0] / targets.diagonal)

    def unlikely(self, laid: _Laid, target: np.ndarray, asked: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """(K, n) how unlikely the points of candidates that are ``asked`` (K, n) are for the cloud of each, the ``target`` (K,); and (K, n)
        whether they are ``seen``."""
        own, point = np.nonzero(asked)
        targets, of = self.targets, target[own]
        places, position, word = laid.places[own, point], laid.position[own, point], laid.word[own, point]
        found, both = [], self._points.find(places, of, word)
        for nearest, _ in both:
            at = of, nearest - of * targets.points.shape[1]
            off = gaps(position, targets.points[at], targets.normals[at], targets.apart[at], targets.diagonal[of])
            found.append(_unlikely(off, unlike(word, targets.word[at]), self.noise(of)))
        told, seen = np.zeros(asked.shape), np.zeros(asked.shape, dtype=bool)
        told[own, point], seen[own, point] = np.minimum(*found), self._sight.near(both[0][1], of)
        return told, seen

    def seen(self, laid: _Laid, target: np.ndarray, asked: np.ndarray) -> np.ndarray:
        """(K, n) bool: whether there are points of the cloud where those of candidates lie that are ``asked`` (K, n)."""
        own, point = np.nonzero(asked)
        told = np.zeros(asked.shape, dtype=bool)
        told[own, point] = self._sight.at(laid.places[own, point], target[own])
        return told

    def count(self, target: np.ndarray) -> np.ndarray:
        """(K,) how many points clouds count for."""
        return np.minimum(self.targets.count[target], _WITNESSES)

    def noise(self, target: np.ndarray) -> np.ndarray:
        return np.maximum(self.targets.noise[target], _CLOSE_NOISE if self.closely else _LEAST_NOISE)


@dataclass(frozen=True, slots=True, eq=False)
class _Laid:
    """Points of candidates in the frames of their clouds (K, n), the first ``around`` on rows that are not marked; their ``places`` (K, n, 6)
    in diagonals, with normals, how far each lies ``apart`` from others, which are ``hidden`` from without; those on marked rows are
    ``fresh`` if there are any, the others are ``shared`` likewise; the visible surface ``area`` (K, 2) of the other rows and of these;
    ``on``: the row, among those of all tables, on which a point lies, and the number of its ``site``; ``word``: what it is."""

    around: int
    position: np.ndarray
    normal: np.ndarray
    places: np.ndarray
    apart: np.ndarray
    hidden: np.ndarray
    fresh: np.ndarray
    shared: np.ndarray
    area: np.ndarray
    on: np.ndarray
    site: np.ndarray
    word: np.ndarray
    link: np.ndarray
    moving: Moving | None

    @property
    def marked(self) -> np.ndarray:
        """(K,) the share of the visible surface that is marked."""
        return np.asarray(self.area[:, 1] / np.maximum(self.area.sum(axis=1), 1e-12))

    def unlikely(
        self,
        clouds: Clouds,
        target: np.ndarray,
        some: np.ndarray,
        asked: np.ndarray,
        taken: np.ndarray,
        known: np.ndarray | None = None,
    ) -> tuple[np.ndarray, np.ndarray]:
        """(K, m) how unlikely the points ``some`` (K, m) of clouds that are ``asked`` (K, m) are for those ``taken`` (K, n) of these, inf where
        there are none, and which of these is nearest. What is no likelier than is ``known`` (K, m) need not be told."""
        targets = clouds.targets
        apart, near = np.full(asked.shape, np.inf), np.zeros(asked.shape, dtype=np.int64)
        own, column = np.nonzero(asked & taken.any(axis=1, keepdims=True))
        if not len(own):
            return apart, near
        of = target[own]
        at = of, some[own, column]
        points, word, diagonal = targets.points[at], targets.word[at], targets.diagonal[of]
        theirs = features(points, targets.normals[at], diagonal)
        large = np.arange(taken.shape[1]) < self.around
        least, which = np.full(len(own), np.inf), np.zeros(len(own), dtype=np.int64)
        for pool in (taken & large, taken & ~large) if clouds.closely else (taken,):
            mine, place = np.nonzero(pool)
            some = np.flatnonzero(np.asarray(pool.any(axis=1))[own])
            if not len(some):
                continue
            points_of = Twofold(self.places[mine, place], mine, self.word[mine, place], targets.meant)
            told = least if known is None else np.minimum(least, known[own, column])
            aside = REACH * np.where(pool, self.apart, 0.0).max(axis=1)  # as far as it does not count
            reach = _gap(told, clouds.noise(of)) + aside[own] / diagonal
            some = some[points_of.within(theirs[some], own[some], reach[some])]
            for nearest, _ in points_of.find(theirs[some], own[some], word[some]):
                there = own[some], place[nearest]
                off = gaps(self.position[there], points[some], self.normal[there], self.apart[there], diagonal[some])
                told = _unlikely(off, unlike(self.word[there], word[some]), clouds.noise(of[some]))
                which[some] = np.where(told < least[some], there[1], which[some])
                least[some] = np.minimum(told, least[some])
        apart[own, column], near[own, column] = least, which
        return apart, near


def _lay(
    batch: Batch, marked: Rows, placed: Placed, around: int, near: int, clouds: Clouds, target: np.ndarray
) -> _Laid:
    targets = clouds.targets
    laid = spread(batch, marked, around, near)
    position = placed.of(laid.points.position)
    last = np.arange(position.shape[1]) >= around
    fresh, shared = last & (laid.area[:, 1:] > 0.0), ~last & (laid.area[:, :1] > 0.0)
    apart = laid.apart * placed.scale[:, None]
    on = starts(tables(batch))[laid.points.site] + laid.points.row
    word = words_of(batch, laid.points, targets.meant)
    places = features(position, laid.points.normal, targets.diagonal[target][:, None])
    return _Laid(
        around,
        position,
        laid.points.normal,
        places,
        apart,
        ~clouds.screens.outer(position, target),
        fresh,
        shared,
        laid.area,
        on,
        laid.points.site,
        word,
        np.concatenate(links_of_rows(batch))[on] if targets.jointed else np.zeros(on.shape, dtype=np.int64),
        Moving.of(batch).placed(placed) if targets.jointed else None,
    )


def weigh(batch: Batch, target: np.ndarray, placed: Placed, clouds: Clouds) -> Evidence:
    """What the clouds say of candidates, each of its target."""
    targets = clouds.targets
    laid = _lay(batch, small(batch), placed, *_POINTS, clouds, target)
    every = np.broadcast_to(np.arange(targets.points.shape[1]), (len(target), targets.points.shape[1]))
    cloud, there = laid.unlikely(clouds, target, every, np.ones(every.shape, dtype=bool), ~laid.hidden)
    count, stands = clouds.count(target), np.where(laid.hidden, 0.0, laid.apart**2)
    unlikely, seen = clouds.unlikely(laid, target, ~laid.hidden)
    known = np.where(seen, stands, 0.0)
    stands *= (count / _known(known.sum(axis=1), stands.sum(axis=1)))[:, None]
    surface = unlikely * stands
    of = laid.on[np.arange(len(batch))[:, None], there]
    rank = np.concatenate([table.rank for table in tables(batch)])
    named = laid.site * _MANY + rank[laid.on]
    links = Held.none(cloud.shape)
    if laid.moving is not None:
        mine = laid.link[np.arange(len(batch))[:, None], there]
        links = Held.of(laid.moving, mine, targets.link[target], targets.twist[target], targets.diagonal[target])
    return Evidence(cloud, surface, count / cloud.shape[1], count, stands, seen, named, of, laid.on, laid.places, links)


def beside(one: Evidence, other: Evidence, at: np.ndarray) -> np.ndarray:
    """(K,) by how much whole candidates are less likely than others, those ``at`` (K,) of them. Their surfaces count as far as the cloud
    was seen, as what both have tells."""
    every = np.arange(len(at))[:, None] * _MANY * _MANY
    shared = np.isin(every + other.named[at], every + one.named) & (other.stands[at] > 0.0)
    coverage = Coverage.of(other.places[at], shared, other.seen[at] & shared)
    found = []
    for mine, row in ((one, np.arange(len(at))), (other, at)):
        own, point = np.nonzero(mine.stands[row] > 0.0)
        share = np.zeros(mine.stands[row].shape)
        share[own, point] = coverage.at(mine.places[row][own, point], own)
        known = _known((share * mine.stands[row]).sum(axis=1), mine.stands[row].sum(axis=1))
        surface = (share * mine.surface[row]).sum(axis=1) * mine.count[row] / known
        found.append(mine.weight[row] * (mine.cloud[row] + mine.links.strange[row]).sum(axis=1) + surface)
    return np.asarray(found[0] - found[1])


def _known(seen: np.ndarray, whole: np.ndarray) -> np.ndarray:
    """The surface that the points of a cloud are shared among."""
    return np.asarray(np.maximum(np.maximum(seen, _LEAST_SEEN * whole), 1e-12))


@dataclass(frozen=True, slots=True, eq=False)
class Asked:
    """Points of clouds that tell of copies: places ``some`` (K, m), the first of which ``asked`` (K, m) are meant, of ``many`` (K,) there
    are; ``owned`` (K, m): those that are nearest to what is gone; ``before`` (K, m): how unlikely they are for the origin."""

    some: np.ndarray
    asked: np.ndarray
    many: np.ndarray
    owned: np.ndarray
    before: np.ndarray
    strange: np.ndarray

    @staticmethod
    def none() -> Asked:
        """Of no copies."""
        points, flags = np.zeros((0, _ASKED), dtype=np.int64), np.zeros((0, _ASKED), dtype=bool)
        return Asked(points, flags, np.zeros(0, dtype=np.int64), flags, np.zeros((0, _ASKED)), np.zeros((0, _ASKED)))

    @staticmethod
    def joined(several: list[Asked]) -> Asked:
        """Of all copies of several sets."""
        return Asked(*(np.concatenate([getattr(one, field.name) for one in several]) for field in fields(Asked)))

    def take(self, at: np.ndarray) -> Asked:
        """Of some of them."""
        return Asked(*(getattr(self, field.name)[at] for field in fields(self)))


@dataclass(frozen=True, slots=True, eq=False)
class Change:
    """``loss`` (K,): by how much copies are less likely than their origins; ``share`` (K,) of their surface that differs; by what points
    of the clouds that is told."""

    loss: np.ndarray
    share: np.ndarray
    told: Asked


def weigh_change(copies: Copies, clouds: Clouds, base: Evidence, change: Differing) -> Change:
    """What clouds say of copies beside the candidates they were made of, of which ``base`` tells; ``change``: how they differ. Of the
    origins, what is gone is asked about as coarsely as all else."""
    of = copies.of
    gone = _gone(base, change, len(of))
    laid = _lay(copies.batch, change.new, copies.placed, _AROUND, _NEAR, clouds, copies.target)
    told = _ask(copies, clouds, base, gone, laid)
    cloud, there, new, coverage = _told(laid, copies, clouds, told)
    cloud = cloud + _strange(laid, copies, clouds, base, told, there)
    surface = new.sum(axis=1)
    own, point = np.nonzero(gone[np.arange(len(of))[:, None], base.on[of]] & (base.surface[of] > 0.0))
    lost = of[own], point
    was = np.bincount(own, base.surface[lost] * coverage.at(base.places[lost], own), minlength=len(of))
    more = np.where(told.asked, cloud - told.before - told.strange, 0.0).sum(axis=1) * _each(told)
    return Change(base.weight[of] * more + surface - was, laid.marked, told)


def weigh_again(copies: Copies, origins: Copies, clouds: Clouds, base: Evidence, change: Differing) -> Change:
    """The same with as many points on what is gone as on what is new: ``origins`` are the candidates that ``copies.of`` names."""
    of = copies.of
    laid, was = (
        _lay(one.batch, rows, one.placed, _AROUND, _NEAR, clouds, copies.target)
        for one, rows in ((copies, change.new), (origins, change.gone))
    )
    told = _ask(copies, clouds, base, _gone(base, change, len(of)), laid)
    found = []
    for one in (laid, was):
        cloud, there, new, _ = _told(one, copies, clouds, told)
        cloud = np.where(told.asked, cloud + _strange(one, copies, clouds, base, told, there), 0.0)
        found.append((cloud, new.sum(axis=1)))
    (cloud, surface), (cloud_was, surface_was) = found
    more = (cloud - cloud_was).sum(axis=1) * _each(told)
    return Change(base.weight[of] * more + surface - surface_was, np.maximum(laid.marked, was.marked), told)


def weigh_elements(
    copies: Copies, clouds: Clouds, base: Evidence, change: Differing
) -> tuple[Asked, np.ndarray, np.ndarray, np.ndarray]:
    """What clouds say of each point of copies, by their places alone: what was asked about, how unlikely those points are (K, m), each for
    as many as it stands for; and the points of what is new (K, n), on which row, among those of all tables, each of these lies (K, n)."""
    of = copies.of
    around, near, asked = _ROUGHLY
    laid = _lay(copies.batch, change.new, copies.placed, around, near, clouds, copies.target)
    told = _ask(copies, clouds, base, _gone(base, change, len(of)), laid, asked)
    cloud, _, surface, _ = _told(laid, copies, clouds, told)
    more = np.where(told.asked, cloud - told.before, 0.0) * (base.weight[of] * _each(told))[:, None]
    return told, more, surface, laid.on[:, around:]


def _each(told: Asked) -> np.ndarray:
    return np.asarray(told.many / np.maximum(told.asked.sum(axis=1), 1))


def _gone(base: Evidence, change: Differing, count: int) -> np.ndarray:
    """(K, rows) bool of the rows of origins."""
    rows = int(max(one.max(initial=0) for one in (base.on, base.of, change.old[1]))) + 1
    found = np.zeros((count, rows), dtype=bool)
    found[change.old] = True
    return found


def _ask(copies: Copies, clouds: Clouds, base: Evidence, gone: np.ndarray, laid: _Laid, most: int = _ASKED) -> Asked:
    """Of the cloud ``most`` points, those that are nearest to what is gone, and those that nothing explains where something is new."""
    targets, of, target = clouds.targets, copies.of, copies.target
    owned, asked = (np.zeros((len(of), base.cloud.shape[1]), dtype=bool) for _ in range(2))
    low, high = corners(laid.position[:, laid.around :])
    margin = _MARGIN * targets.diagonal[target][:, None]
    low, high, fresh = low - margin, high + margin, laid.fresh[:, -1]
    odd = {k: np.flatnonzero(base.cloud[k] > _ODD) for k in np.unique(of).tolist()}
    for k, origin in enumerate(of.tolist()):  # one at a time: few points of a cloud are asked about a copy
        gone[k].take(base.of[origin], out=owned[k])
        if fresh[k]:
            points = targets.points[target[k], odd[origin]]
            x, y, z = ((points > low[k]) & (points < high[k])).T
            asked[k, odd[origin][x & y & z]] = True
    asked |= owned
    many = asked.sum(axis=1)
    own, point = np.nonzero(asked)
    rank = np.arange(len(own)) - (np.cumsum(many) - many)[own]
    first = np.flatnonzero(rank < most)
    some = np.zeros((len(of), min(most, asked.shape[1])), dtype=np.int64)
    some[own[first], rank[first]] = point[first]
    told = np.arange(some.shape[1]) < many[:, None]
    before, strange = (one[of[:, None], some] for one in (base.cloud, base.links.strange))
    return Asked(some, told, many, told & np.take_along_axis(owned, some, axis=1), before, strange)


def _told(
    laid: _Laid, copies: Copies, clouds: Clouds, told: Asked
) -> tuple[np.ndarray, np.ndarray, np.ndarray, Coverage]:
    """How unlikely the points asked are (K, m), and which of those laid each lies on, -1 where that is none of them; how unlikely the points
    of what is marked are (K, n), as far as they lie where the cloud was seen; and where that is."""
    target, shown = copies.target, ~laid.hidden
    every, there = laid.unlikely(clouds, target, told.some, told.owned, shown)
    known = np.where(told.owned, every, told.before)
    fresh, new_there = laid.unlikely(clouds, target, told.some, told.asked, laid.fresh & shown, known)
    cloud, there = np.minimum(fresh, known), np.where(fresh < known, new_there, np.where(told.owned, there, -1))
    shared = laid.shared & shown
    seen = clouds.seen(laid, target, shared)
    coverage = Coverage.of(laid.places, shared, seen)
    share = np.where(seen, 1.0, 0.0)
    own, point = np.nonzero(laid.fresh & shown)
    share[own, point] = coverage.at(laid.places[own, point], own)
    expected = clouds.count(target) * laid.area[:, 1] / _known(_surface(laid, share), _surface(laid, shown))
    unlikely, _ = clouds.unlikely(laid, target, laid.fresh & shown & (share > 0.0))
    new = (share * unlikely)[:, laid.around :]
    return cloud, there, expected[:, None] * new / new.shape[1], coverage


def _strange(
    laid: _Laid, copies: Copies, clouds: Clouds, base: Evidence, told: Asked, there: np.ndarray
) -> np.ndarray | float:
    """(K, m) how unlikely the links of the points asked make them; ``there`` (K, m) as ``_told`` has it."""
    if laid.moving is None:
        return 0.0
    targets, target, of = clouds.targets, copies.target, copies.of
    theirs = np.where(told.asked, targets.link[target[:, None], told.some], -1)
    before = base.links.mine[of[:, None], told.some]
    after = np.where(there < 0, -1, laid.link[np.arange(len(of))[:, None], there])
    points = Points(before, after, theirs, _each(told))
    return base.links[of].otherwise(laid.moving, points, targets.twist[target], targets.diagonal[target])


def _surface(laid: _Laid, share: np.ndarray) -> np.ndarray:
    """(K,) square metres of which a ``share`` (K, n) is meant."""
    parts = share[:, : laid.around].mean(axis=1), share[:, laid.around :].mean(axis=1)
    return np.asarray((np.stack(parts, axis=1) * laid.area).sum(axis=1))


def _unlikely(off: Gaps, unlike: np.ndarray, noise: np.ndarray) -> np.ndarray:
    """(m,) of distances, in logarithms: Cauchy's, which is 0 at none. Points of different words lie far apart."""
    gap = np.where(unlike, np.maximum(np.abs(off.value), FARTHEST), off.value)
    return np.asarray(np.log1p(0.5 * (gap / noise) ** 2))


def _gap(told: np.ndarray, noise: np.ndarray) -> np.ndarray:
    """(m,) the distances in diagonals that are so unlikely (m,), and no less."""
    return np.asarray(_ROUNDED * noise * np.sqrt(2.0 * np.expm1(told)))
