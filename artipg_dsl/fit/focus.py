"""Where candidates differ from what they were made of: their rows there, and points that lie mostly there."""

from __future__ import annotations

import numpy as np

from .. import random
from ..geometry import points as geometry
from ..geometry.pointset import PointSet, Pools
from ..geometry.runs import runs
from ..geometry.sites import SiteTable
from ..records import dataclass
from ..runtime.batch import Batch
from .links import Moving, links_of_rows
from .states import is_jointed, tables

_MANY = 1 << 32  # more than rows of a site in an object
_STILL = 1e-9  # metres: what is moved by less was not
_ALIKE = 1e-7  # metres, to which rows of different names are equal
_NONE = np.zeros(0, dtype=np.int64)
_SMALL = 0.1  # of the surface of all boxes: that of the small primitives together


@dataclass(frozen=True, slots=True, eq=False)
class Rows:
    """Primitives of candidates by name: for each site its rows as ``owner`` and rank, in one number, ascending."""

    named: dict[int, np.ndarray]

    @staticmethod
    def of(sites: list[SiteTable], marked: list[np.ndarray]) -> Rows:
        return Rows({table.number: _names(table)[one] for table, one in zip(sites, marked, strict=True)})

    def among(self, sites: list[SiteTable]) -> list[np.ndarray]:
        """For each table which of its rows these are."""
        return [_among(_names(table), self.named.get(table.number, _NONE)) for table in sites]


def _among(names: np.ndarray, some: np.ndarray) -> np.ndarray:
    """Which names are among ``some``, which ascend."""
    if not len(some):
        return np.zeros(len(names), dtype=bool)
    return np.asarray(some[np.minimum(np.searchsorted(some, names), len(some) - 1)] == names)


def _names(table: SiteTable) -> np.ndarray:
    return np.asarray(table.owner * _MANY + table.rank)


def small(batch: Batch) -> Rows:
    """The smallest primitives of each candidate, by the surface of their boxes, which together have a tenth of it."""
    sites = tables(batch)
    surface, owner = [np.zeros(0)], [np.zeros(0, dtype=np.int64)]
    for table in sites:
        low, high = table.boxes()
        x, y, z = np.moveaxis(high - low, -1, 0)
        surface.append(x * y + y * z + z * x)
        owner.append(table.owner)
    size, own = np.concatenate(surface), np.concatenate(owner)
    order = np.lexsort((size, own))
    running = np.cumsum(size[order])
    begin = np.searchsorted(own[order], own[order])
    running -= np.concatenate([[0.0], running])[begin]
    whole = np.bincount(own, size, minlength=len(batch))
    found = np.zeros(len(own), dtype=bool)
    found[order] = running <= _SMALL * whole[own[order]]
    return Rows.of(sites, np.split(found, np.cumsum([len(table) for table in sites])[:-1]))


@dataclass(frozen=True, slots=True, eq=False)
class Differing:
    """``new``: rows of the copies that stand otherwise than in their origin, or not at all there. ``gone``: those of the origins that are
    changed or gone, by the copy and their rank; ``old``: the same as pairs of a copy and a row among those of all tables of the origins."""

    new: Rows
    gone: Rows
    old: tuple[np.ndarray, np.ndarray]

    def anywhere(self, count: int) -> np.ndarray:
        """(K,) bool for the ``count`` copies: whether they differ at all."""
        found = np.zeros(count, dtype=bool)
        found[self.old[0]] = True
        for names in self.new.named.values():
            found[names // _MANY] = True
        return found


def differing(
    origins: Batch, copies: Batch, of: np.ndarray, lifted: np.ndarray | None = None, within: np.ndarray | None = None
) -> Differing:
    """The primitives of ``copies`` that are not those of the ``origins`` they were made of (``of`` (K,), places among them), by which
    the copies are ``lifted`` (K, 3). Those that differ ``within`` (K,) metres are the same, if that is given."""
    lifted = np.zeros((len(of), 3)) if lifted is None else lifted
    pairs = list(zip(tables(origins), tables(copies), strict=True))
    new: list[np.ndarray] = []
    gone: list[tuple[np.ndarray, np.ndarray]] = []  # of each table the copies that have lost a row, and its row
    motion = (_moves(origins), _moves(copies, lifted)) if is_jointed(copies.program) else None
    for number, (table, other) in enumerate(pairs):
        origin = of[other.owner]
        first, last = (np.searchsorted(table.owner, origin, side=side) for side in ("left", "right"))
        base = first + other.rank
        there = base < last
        own = np.minimum(base, max(len(table) - 1, 0))
        close = None if within is None else within[other.owner]
        same = there & (_same(table, other, own, close) if len(table) else False)
        if len(table):
            room = _STILL if close is None else close[:, None]
            off = table.translation[own] - other.translation - lifted[other.owner]
            same &= (np.abs(off) < room).all(axis=1)
            if motion:
                same &= (np.abs(motion[0][number][own] - motion[1][number]) < room).all(axis=1)
        new.append(~same)
        low, high = (np.searchsorted(table.owner, of, side=side) for side in ("left", "right"))
        many = high - low
        rows, start = runs(low, many), np.cumsum(many) - many  # of each copy those of its origin
        kept = np.zeros(len(rows), dtype=bool)
        kept[(start[other.owner] + other.rank)[same]] = True
        gone.append((np.repeat(np.arange(len(of)), many)[~kept], rows[~kept]))
    gone = _without_equals(pairs, new, gone, lifted, motion)
    begin = np.cumsum([0, *(len(table) for table, _ in pairs)])
    lost = {
        table.number: owner * _MANY + table.rank[rows] for (table, _), (owner, rows) in zip(pairs, gone, strict=True)
    }
    copy, row = (np.concatenate([np.zeros(0, dtype=np.int64), *column]) for column in zip(*gone, strict=True))
    begins = np.repeat(begin[:-1], [len(rows) for _, rows in gone])
    return Differing(Rows.of(tables(copies), new), Rows(lost), (copy, row + begins))


_Motion = list[np.ndarray]  # of each table how its rows move (n, 6)


def _moves(batch: Batch, lifted: np.ndarray | None = None) -> _Motion:
    """How the rows of all tables move where the joints of what is fitted are known, of candidates that are ``lifted`` (K, 3)."""
    twist = np.nan_to_num(Moving.of(batch).twist)
    if lifted is not None:
        twist[..., 3:] += np.cross(lifted[:, None], twist[..., :3])
    return [twist[table.owner, link] for table, link in zip(tables(batch), links_of_rows(batch), strict=True)]


def _without_equals(
    pairs: list[tuple[SiteTable, SiteTable]],
    new: list[np.ndarray],
    gone: list[tuple[np.ndarray, np.ndarray]],
    lifted: np.ndarray,
    motion: tuple[_Motion, _Motion] | None,
) -> list[tuple[np.ndarray, np.ndarray]]:
    """What is ``gone`` of tables without those rows in whose place an equal one of another name is new, which is none of the ``new`` ones then:
    of two equal sashes that change sides, neither is moved."""
    kept = [np.ones(len(rows), dtype=bool) for _, rows in gone]
    alike: dict[int, list[int]] = {}
    for k, (table, _) in enumerate(pairs):
        if new[k].any() or len(gone[k][1]):
            alike.setdefault(id(table.primitive), []).append(k)
    for several in alike.values():
        made = [(k, pairs[k][1], at, pairs[k][1].owner[at]) for k in several if len(at := np.flatnonzero(new[k]))]
        lost = [(k, pairs[k][0], rows, owner) for k in several for owner, rows in (gone[k],) if len(rows)]
        if not made or not lost:
            continue
        own = np.concatenate([owner for *_, owner in lost])
        before, after = motion or (None, None)
        ours, theirs = _addresses(made, np.zeros((1, 3)), after), _addresses(lost, lifted[own], before)
        both = np.intersect1d(ours, theirs)
        if not len(both):
            continue
        for (k, _, at, _), equal in zip(made, _parted(np.isin(ours, both), made), strict=True):
            new[k][at[equal]] = False
        for (k, *_), equal in zip(lost, _parted(np.isin(theirs, both), lost), strict=True):
            kept[k] &= ~equal
    return [(owner[one], rows[one]) for (owner, rows), one in zip(gone, kept, strict=True)]


# of some sites of one primitive: the place of each, its table, rows of this, and the copies that these are of
_Some = list[tuple[int, SiteTable, np.ndarray, np.ndarray]]


def _parted(of: np.ndarray, some: _Some) -> list[np.ndarray]:
    """What is told of the rows of all sites, site by site."""
    return np.split(of, np.cumsum([len(rows) for _, _, rows, _ in some])[:-1])


def _addresses(some: _Some, moved: np.ndarray, motion: _Motion | None) -> np.ndarray:
    """(n,) uint64 for the rows of some sites, one site after the other, that are the same for rows of the same shape, place, word and
    ``motion`` in the same copy, once ``moved`` (n, 3) back."""
    placed, turned, mirror, word = (
        np.concatenate([getattr(table, name)[rows] for _, table, rows, _ in some])
        for name in ("translation", "rotation", "mirror", "semantic")
    )
    names = sorted(some[0][1].params)
    shape = (np.concatenate([table.params[name][rows] for _, table, rows, _ in some]) for name in names)
    moves = () if motion is None else np.concatenate([motion[k][rows] for k, _, rows, _ in some]).T
    every = *(placed - moved).T, *turned.reshape(-1, 9).T, mirror, word, *shape, *moves
    found = np.concatenate([owner for *_, owner in some]).astype(np.uint64)
    for value in every:
        found = random.mix(found, np.rint(value / _ALIKE).astype(np.int64).view(np.uint64))
    return found


def lifted(origins: Batch, copies: Batch, of: np.ndarray) -> np.ndarray:
    """(K, 3) by how much copies have to be moved so that most of what they share with their origins stands where it stood there: the median
    of primitives, by the surface of their boxes."""
    owner, off, size = [np.zeros(0, dtype=np.int64)], [np.zeros((0, 3))], [np.zeros(0)]
    for table, other in zip(tables(origins), tables(copies), strict=True):
        if not len(table) or not len(other):
            continue
        first, last = (np.searchsorted(table.owner, of[other.owner], side=side) for side in ("left", "right"))
        base = first + other.rank
        own = np.minimum(base, len(table) - 1)
        at = np.flatnonzero((base < last) & _same(table, other, own))
        low, high = other.boxes()
        x, y, z = np.moveaxis((high - low)[at], -1, 0)
        owner.append(other.owner[at])
        off.append(table.translation[own[at]] - other.translation[at])
        size.append(x * y + y * z + z * x)
    of_copy, away, weight = np.concatenate(owner), np.concatenate(off), np.concatenate(size)
    found = np.zeros((len(of), 3))
    for axis in range(3):
        order = np.lexsort((away[:, axis], of_copy))
        running = np.cumsum(weight[order])
        begin = np.searchsorted(of_copy[order], np.arange(len(of)))
        end = np.searchsorted(of_copy[order], np.arange(len(of)), side="right")
        running = np.concatenate([[0.0], running])
        middle = np.searchsorted(running[1:], 0.5 * (running[begin] + running[end]))
        some = end > begin
        found[some, axis] = away[order[middle[some]], axis]
    return np.where(np.abs(found) < _STILL, 0.0, found)


def _same(table: SiteTable, other: SiteTable, own: np.ndarray, close: np.ndarray | None = None) -> np.ndarray:
    """(n,) bool for rows of ``other``: whether those ``own`` (n,) of a table have the same shape and are turned likewise; exactly, or to what
    is ``close`` (n,): metres, and as much a metre away."""
    same = table.mirror[own] == other.mirror
    if close is None:
        same &= (table.rotation[own] == other.rotation).all(axis=(1, 2))
        for name, value in table.params.items():
            same &= value[own] == other.params[name]
        return np.asarray(same)
    same &= (np.abs(table.rotation[own] - other.rotation) < close[:, None, None]).all(axis=(1, 2))
    for name, value in table.params.items():
        same &= np.abs(value[own] - other.params[name]) < close
    return np.asarray(same)


@dataclass(frozen=True, slots=True, eq=False)
class Spread:
    """Points (K, n) of candidates, those on marked rows last; how far each lies ``apart`` from others (K, n), in metres; the
    visible surface ``area`` (K, 2) of other rows and of these, in square metres."""

    points: PointSet
    apart: np.ndarray
    area: np.ndarray


def spread(batch: Batch, marked: Rows, around: int, near: int) -> Spread:
    """``near`` points of the rows that are ``marked``, ``around`` of all others; of these alone where there are no others."""
    sites = tables(batch)
    labels = [one.astype(np.int64) for one in marked.among(sites)]
    pools = Pools.of(sites, labels, len(batch))
    wanted = np.where(pools.label == 1, near, around)
    one = np.bincount(pools.owner, minlength=len(batch))[pools.owner] == 1
    wanted = np.where(one, around + near, wanted)
    key, address = random.key(0, "spread"), batch.state.objects.astype(np.uint64)
    found, full, area = geometry.sample_counts(sites, pools, wanted, key, address)
    held = np.zeros((len(batch), 2), dtype=np.int64) - 1  # the pool of each
    held[pools.owner[full], pools.label[full]] = np.flatnonzero(full)
    held = np.where(held < 0, held[:, ::-1], held)
    column = np.arange(around + near)
    pool = np.where(column < around, held[:, :1], held[:, 1:])
    alone = held[:, :1] == held[:, 1:]
    lies = np.where(alone | (column < around), column, column - around) % wanted[pool]
    visible = np.zeros((len(batch), 2))
    visible[pools.owner[full], pools.label[full]] = area[full]
    apart = np.sqrt(np.maximum(area, 1e-12) / wanted)[pool]
    return Spread(found.take((pool, lies)), apart, visible)
