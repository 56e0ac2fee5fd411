"""Elements of repeats put together anew: how many there are, where they end, and what is in each.

A count is seldom right alone: with three rows instead of one all that the rows hold is new, and drawn at random it is hardly ever right in
every one of them. But elements stand apart from one another, and each can be judged by the points where it stands. So copies are drawn whose
elements end where the cloud has planes across them, in all ways in which few planes part the room; of the elements between the same planes
the likeliest is kept, and of the ways those whose elements are likeliest together. The noise is taken for large meanwhile, so that what is
right, but a little off, is likelier than nothing. What elements hold that repeats in turn is put together after them.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from itertools import combinations

import numpy as np

from ..geometry.hidden import runs
from ..records import dataclass
from ..runtime.batch import Batch
from ..sampling.search import domain_ends
from .compare import Candidates, Targets
from .develop import apart, copied, developed
from .evidence import Asked, Change, Clouds, Copies, Evidence, weigh, weigh_elements
from .model import Model
from .repeats import Layout, Places, Repeat, boxes_of_elements, contents_of, find_repeats, relaid
from .search import Effort, best_of, taken, united

_WIDE = 8e-3  # diagonals: the noise meanwhile
_PROBES = 8  # copies that tell along which axis elements stand, and in which box
# ways of laying out elements that are looked into: where these hold repeats in turn, and where not
_OUTER, _INNER = 2, 3
_PLANES = 7  # of a cloud, across a row of elements, at which these may end
_BINS = 128  # of the extent of a row, where planes are looked for,
_ENDS = 5  # of which so many on each end are no planes between elements,
_NEXT = 2  # and two planes lie farther apart
_FEW = 4  # points that are no plane yet
_ACROSS = 0.9  # of a normal, along the axis, of a point of such a plane
_AROUND = 0.02  # metres beyond the box of a row where its points may lie
_SLACK = 1.05  # in the ratio of weights, which do not tell the room of elements exactly
_BLOCK = 96  # copies at a time
_LANE = 1000  # the first that contents are drawn by: other copies have smaller numbers


def rearranged(model: Model, own: Targets, found: Candidates, clouds: Clouds, effort: Effort) -> Candidates:
    """Those of the candidates that become likelier with the elements of their repeats put together anew, with these."""
    repeats, nothing = find_repeats(model), taken(model, found, np.zeros(0, dtype=np.int64))
    if not repeats:
        return nothing
    wide = Clouds(replace(own, noise=np.maximum(own.noise, _WIDE)))
    first = weigh(found.batch, found.target, found.placed, wide)
    now, told, origin = found, first, np.arange(len(found))
    made: list[tuple[Candidates, np.ndarray]] = []
    for place, one in enumerate(repeats):
        inner = any(one.holds(other) for other in repeats[place + 1 :])
        new, of = _composed(model, own, now, wide, told, one, effort.copies, _OUTER if inner else _INNER)
        made.append((new, origin[of]))
        if inner and len(new):
            now, origin = united(model, [now, new]), np.concatenate([origin, origin[of]])
            told = weigh(now.batch, now.target, now.placed, wide)
    made = [(new, of) for new, of in made if len(new)]
    if not made:
        return nothing
    every, of = united(model, [new for new, _ in made]), np.concatenate([of for _, of in made])
    loss = weigh(every.batch, every.target, every.placed, wide).total - first.total[of]
    at = best_of(model.structures(every.batch), of, loss, effort.developed)
    copies = Copies(model.assembled([(every.batch, at)]), of[at], every.target[at], every.placed.take(at))
    return developed(model, own, found, clouds, copies, Change(loss[at], np.ones(len(at)), Asked.none()), effort)


def _composed(
    model: Model, own: Targets, found: Candidates, clouds: Clouds, base: Evidence, one: Repeat, copies: int, best: int
) -> tuple[Candidates, np.ndarray]:
    """Candidates with the elements of a repeat put together of many ``copies`` of each, in the ``best`` ways; and of which each was made."""
    places, none = Places.of(found.batch, one), np.zeros(0, dtype=np.int64)
    if not len(places.owner):
        return taken(model, found, none), none
    rooms = _rooms(model, found, one, places)
    ways = _ways(own, found, one, places, rooms)
    if not len(ways.place):
        return taken(model, found, none), none
    batch, pairs = _drawn(model, found, one, places, ways, copies)
    if not (pairs.way >= 0).any():
        return taken(model, found, none), none
    cost = _costs(model, own, found, clouds, base, one, places, rooms, ways, batch, pairs)
    return _assembled(model, found, one, places, ways, batch, pairs, cost, best)


@dataclass(frozen=True, slots=True, eq=False)
class _Rooms:
    """Of each of the places: the ``axis`` that elements follow one another along, upwards or downwards (``sign``), and the box ``low`` ..
    ``high`` (n, 3) of all of them, in the frames of candidates; inf and -inf where there are none."""

    axis: np.ndarray
    sign: np.ndarray
    low: np.ndarray
    high: np.ndarray

    def along(self, points: np.ndarray, place: np.ndarray) -> np.ndarray:
        """(...) how far along the room of its ``place`` (...) each of some points (..., 3) lies: 0 where the first element begins, 1 where the
        last one ends."""
        axis = self.axis[place][..., None]
        at, low, high = (
            np.take_along_axis(one, axis, axis=-1)[..., 0] for one in (points, self.low[place], self.high[place])
        )
        share = (at - low) / np.maximum(high - low, 1e-9)
        return np.where(self.sign[place] > 0.0, share, 1.0 - share)


def _rooms(model: Model, found: Candidates, one: Repeat, places: Places) -> _Rooms:
    """By some copies with other counts."""
    of = np.repeat(np.arange(len(found)), _PROBES)
    turn = np.tile(np.arange(_PROBES), len(found))
    place, copy = _pairs(places, of)
    span = places.most - places.least + 1
    many = places.least[place] + (turn[copy] + 1) % span[place]
    layout = Layout(place, copy, many, np.ones((len(place), 0)))
    probes = relaid(
        model, found.batch, of, turn, replace(one, inside=one.inside + _weights(one), weight=-1), places, layout
    )
    rows = probes.rowmap.rows(one.scope)
    low, high, _ = boxes_of_elements(probes, one)
    there = np.isfinite(low).all(axis=1)
    centre = (np.where(there[:, None], low, 0.0) + np.where(there[:, None], high, 0.0)) / 2.0
    follows = np.flatnonzero(np.diff(rows.parent) == 0)
    follows = follows[there[follows] & there[follows + 1]]
    size = len(places.owner)
    step = _sums(centre[follows + 1] - centre[follows], place[rows.parent[follows]], size)
    axis = np.abs(step).argmax(axis=1)
    lows, highs = np.full((len(place), 3), np.inf), np.full((len(place), 3), -np.inf)
    np.minimum.at(lows, rows.parent, low)
    np.maximum.at(highs, rows.parent, high)
    full = np.isfinite(lows).all(axis=1)
    ends = [np.full((size, 3), np.inf), np.full((size, 3), -np.inf)]
    for each in np.unique(place[full]).tolist():  # a few of each candidate
        mine = full & (place == each)
        ends[0][each], ends[1][each] = np.median(lows[mine], axis=0), np.median(highs[mine], axis=0)
    return _Rooms(axis, np.where(step[np.arange(size), axis] < 0.0, -1.0, 1.0), *ends)


def _weights(one: Repeat) -> tuple[int, ...]:
    return (one.weight,) if one.weight >= 0 else ()


def _sums(values: np.ndarray, of: np.ndarray, size: int) -> np.ndarray:
    found = np.zeros((size, values.shape[1]))
    np.add.at(found, of, values)
    return found


def _pairs(places: Places, of: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """The places of copies ``of`` candidates, and of which copy each is: in the order in which a batch of these has them."""
    many = places.many[of]
    return runs(places.first[of], many), np.repeat(np.arange(len(of)), many)


@dataclass(frozen=True, slots=True, eq=False)
class _Ways:
    """Ways of laying out elements (W,): of which ``place``, how ``many`` elements, their ``ends`` (W, most + 1) from 0 to 1, inf beyond, and
    the ``slot`` (W, most) that each takes, -1 beyond: elements of one slot are between the same ends. ``begin`` (n,), ``count`` (n,): those of
    each place. ``ratio``: between which numbers weights lie."""

    place: np.ndarray
    many: np.ndarray
    ends: np.ndarray
    slot: np.ndarray
    begin: np.ndarray
    count: np.ndarray
    ratio: tuple[float, float]

    def layout(self, way: np.ndarray, copy: np.ndarray) -> Layout:
        """Some of them in copies."""
        with np.errstate(invalid="ignore"):
            room = np.diff(self.ends[way], axis=1)
        room = np.where(self.slot[way] >= 0, room, np.nan)
        least, most = np.nanmin(room, axis=1), np.nanmax(room, axis=1)
        low, high = self.ratio
        weight = np.clip(room * np.sqrt(low / least * high / most)[:, None], low, high)
        return Layout(self.place[way], copy, self.many[way], np.where(np.isnan(weight), low, weight))


def _ways(own: Targets, found: Candidates, one: Repeat, places: Places, rooms: _Rooms) -> _Ways:
    """All ways in which planes of the clouds can part rooms, as far as weights allow; equal parts where there are no weights."""
    ratio = _range_of_weights(found.batch, one)
    place, many, ends = [], [], []
    for each in np.flatnonzero(np.isfinite(rooms.low).all(axis=1)).tolist():  # a few of each candidate
        least, most = max(int(places.least[each]), 1), int(places.most[each])
        for parted in _parted(own, found, rooms, each, places, least, most, ratio if one.weight >= 0 else None):
            place.append(each)
            many.append(len(parted) - 1)
            ends.append(parted)
    wide = max(many, default=1)
    padded = np.full((len(ends), wide + 1), np.inf)
    for row, parted in enumerate(ends):
        padded[row, : len(parted)] = parted
    of, number = np.array(place, dtype=np.int64), np.array(many, dtype=np.int64)
    there = np.arange(wide) < number[:, None]
    way, rank = np.nonzero(there)
    if one.weight >= 0:
        said = np.stack([of[way], padded[way, rank], padded[way, rank + 1]])
    else:
        said = np.stack([of[way], number[way], rank])
    slot = np.full(there.shape, -1)
    if len(of):
        slot[there] = np.unique(said, axis=1, return_inverse=True)[1].ravel()
    begin, end = (np.searchsorted(of, np.arange(len(places.owner)), side=side) for side in ("left", "right"))
    return _Ways(of, number, padded, slot, begin, end - begin, ratio)


def _range_of_weights(batch: Batch, one: Repeat) -> tuple[float, float]:
    """Between which numbers the weights of elements may lie."""
    if one.weight < 0:
        return 1.0, 1.0
    low, high = domain_ends(batch, one.weight)
    return max(float(low.max(initial=0.0)), 1e-6), max(float(high.min(initial=np.inf)), 1e-6)


def _parted(
    own: Targets,
    found: Candidates,
    rooms: _Rooms,
    place: int,
    places: Places,
    least: int,
    most: int,
    ratio: tuple[float, float] | None,
) -> list[tuple[float, ...]]:
    if ratio is None:
        return [tuple(np.linspace(0.0, 1.0, n + 1).tolist()) for n in range(least, most + 1)]
    planes = _planes(own, found, rooms, place, int(places.owner[place]))
    made = []
    for n in range(least, most + 1):
        for between in combinations(planes, n - 1):
            ends = (0.0, *between, 1.0)
            room = np.diff(ends)
            if room.max() * ratio[0] <= room.min() * ratio[1] * _SLACK:
                made.append(ends)
    return made


def _planes(own: Targets, found: Candidates, rooms: _Rooms, place: int, owner: int) -> Sequence[float]:
    """Where the cloud of a candidate has its largest planes across a room, ascending, 0 to 1."""
    target, placed, axis = found.target[owner], found.placed, rooms.axis[place]
    count = int(own.count[target])
    points = (own.points[target, :count] - placed.shift[owner]) / placed.scale[owner]
    there = ((points > rooms.low[place] - _AROUND) & (points < rooms.high[place] + _AROUND)).all(axis=1)
    there &= np.abs(own.normals[target, :count, axis]) > _ACROSS
    at = rooms.along(points[there], np.full(int(there.sum()), place))
    bins = np.bincount(np.clip((at * _BINS).astype(np.int64), 0, _BINS - 1), minlength=_BINS).astype(np.float64)
    rest = np.convolve(bins, [0.5, 1.0, 0.5], "same")
    rest[:_ENDS] = rest[-_ENDS:] = 0.0
    found_at = []
    for _ in range(_PLANES):
        top = int(np.argmax(rest))
        if rest[top] < _FEW:
            break
        near = slice(max(top - 1, 0), top + 2)
        found_at.append(float((bins[near] * (np.arange(_BINS)[near] + 0.5)).sum() / bins[near].sum() / _BINS))
        rest[max(top - _NEXT, 0) : top + _NEXT + 1] = 0.0
    return sorted(found_at)


@dataclass(frozen=True, slots=True, eq=False)
class _Pairs:
    """Of each place of each copy the ``way`` in which it is laid out, -1 for none; ``of`` (K,): the candidate that a copy was made of."""

    way: np.ndarray
    of: np.ndarray


def _drawn(
    model: Model, found: Candidates, one: Repeat, places: Places, ways: _Ways, copies: int
) -> tuple[Batch, _Pairs]:
    """As many ``copies`` of each candidate, whose places take all their ways in turn."""
    some = np.flatnonzero(np.bincount(places.owner, ways.count, minlength=len(found)) > 0)
    of, turn = np.repeat(some, copies), np.tile(np.arange(copies), len(some))
    place, copy = _pairs(places, of)
    nth = place - places.first[of[copy]]
    many = ways.count[place]
    step = 2 * nth + 1  # so that places do not go through their ways side by side
    way = np.where(many > 0, ways.begin[place] + (turn[copy] * step + nth) % np.maximum(many, 1), -1)
    laid = np.flatnonzero(way >= 0)
    made = relaid(model, found.batch, of, _LANE + turn, one, places, ways.layout(way[laid], copy[laid]))
    good = np.flatnonzero(~made.state.failed)
    batch, way = model.assembled([(made, good)]), way[np.isin(copy, good)]
    as_asked = batch.rowmap.rows(one.scope).count == ways.many[way]  # a count may have no room
    return batch, _Pairs(np.where(as_asked, way, -1), of[good])


def _costs(
    model: Model,
    own: Targets,
    found: Candidates,
    clouds: Clouds,
    base: Evidence,
    one: Repeat,
    places: Places,
    rooms: _Rooms,
    ways: _Ways,
    batch: Batch,
    pairs: _Pairs,
) -> np.ndarray:
    """(n,) what the clouds say of each element of all copies: what is less is likelier."""
    costs: list[np.ndarray] = [np.zeros(0)]
    copy = np.repeat(np.arange(len(batch)), places.many[pairs.of])
    for start in range(0, len(batch), _BLOCK):
        at = np.arange(start, min(start + _BLOCK, len(batch)))
        part = model.assembled([(batch, at)])
        copies = copied(found, part, pairs.of[at])
        told, cloud, surface, on = weigh_elements(copies, clouds, base, apart(found, copies))
        element = boxes_of_elements(part, one)[2][on]
        rows, mine = part.rowmap.rows(one.scope), pairs.way[np.isin(copy, at)]
        cost = np.bincount(element[element >= 0], surface[element >= 0], minlength=rows.size)
        own_copy, column = np.nonzero(told.asked)
        points = own.points[copies.target[own_copy], told.some[own_copy, column]]
        points = (points - copies.placed.shift[own_copy]) / copies.placed.scale[own_copy, None]
        nth = _nearest(rooms, places, copies.of[own_copy], points)
        many = places.many[copies.of]
        pair = (np.cumsum(many) - many)[own_copy] + nth
        place = places.first[copies.of[own_copy]] + nth
        laid = np.flatnonzero((mine[pair] >= 0) & (rows.count[pair] > 0))
        pair, place = pair[laid], place[laid]
        share = rooms.along(points[laid], place)
        rank = (share[:, None] >= ways.ends[mine[pair], 1:]).sum(axis=1)
        row = rows.start[pair] + np.minimum(rank, rows.count[pair] - 1)
        cost += np.bincount(row, cloud[own_copy[laid], column[laid]], minlength=rows.size)
        costs.append(cost)
    return np.concatenate(costs)


def _nearest(rooms: _Rooms, places: Places, of: np.ndarray, points: np.ndarray) -> np.ndarray:
    """(m,) which of the places of its candidate ``of`` (m,) each of some points (m, 3) is nearest to."""
    least, found = np.full(len(points), np.inf), np.zeros(len(points), dtype=np.int64)
    for nth in range(int(places.many.max(initial=0))):
        has = places.many[of] > nth
        place = np.where(has, places.first[of] + nth, 0)
        off = np.maximum(np.maximum(rooms.low[place] - points, points - rooms.high[place]), 0.0).sum(axis=1)
        nearer = has & (off < least)
        found, least = np.where(nearer, nth, found), np.where(nearer, off, least)
    return found


def _assembled(
    model: Model,
    found: Candidates,
    one: Repeat,
    places: Places,
    ways: _Ways,
    batch: Batch,
    pairs: _Pairs,
    cost: np.ndarray,
    best: int,
) -> tuple[Candidates, np.ndarray]:
    """The likeliest ways of each place, of the likeliest elements of each slot."""
    rows = batch.rowmap.rows(one.scope)
    way = pairs.way[rows.parent]
    element = np.flatnonzero(way >= 0)
    slot = ways.slot[way[element], rows.rank[element]]
    order = np.lexsort((cost[element], slot))
    taken_by, first = np.unique(slot[order], return_index=True)
    size = int(ways.slot.max(initial=-1)) + 1
    likeliest, least = np.full(size + 1, -1), np.append(np.full(size, np.inf), 0.0)
    likeliest[taken_by] = element[order[first]]
    least[taken_by] = cost[likeliest[taken_by]]
    total = least[ways.slot].sum(axis=1)
    ranked = np.lexsort((total, ways.place))  # of each place, the likeliest first
    known = np.bincount(ways.place, np.isfinite(total), minlength=len(places.owner)).astype(np.int64)
    new, of = [], [np.zeros(0, dtype=np.int64)]
    for nth in range(best):
        owners = np.unique(places.owner[known > nth])
        if not len(owners):
            break
        place, copy = _pairs(places, owners)
        laid = np.flatnonzero(known[place] > 0)
        place, copy = place[laid], copy[laid]
        chosen = ranked[ways.begin[place] + np.where(known[place] > nth, nth, 0)]
        which, rank = np.nonzero(ways.slot[chosen] >= 0)
        contents = contents_of(model, batch, one, likeliest[ways.slot[chosen[which], rank]], copy[which], rank)
        lane = np.zeros(len(owners), dtype=np.int64)
        made = relaid(model, found.batch, owners, lane, one, places, ways.layout(chosen, copy), contents)
        good = np.flatnonzero(~made.state.failed)
        new.append((made, good))
        of.append(owners[good])
    which = np.concatenate(of)
    copies = copied(found, model.assembled(new), which)
    return Candidates(copies.batch, copies.target, copies.placed, np.zeros(len(which))), which
