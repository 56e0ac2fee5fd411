"""The elements of repeats put together anew: how many there are, where they end, and what each of them holds.

A count is seldom right on its own. With three rows instead of one, everything in the rows is new, and contents drawn at random are hardly ever
right in every row. But elements stand beside one another, so each can be judged by the points near it. This is done in four steps:

1. ``_rooms``: the box that a row of elements has, and the axis along which they follow one another.
2. ``_ways``: every way to divide that box where the cloud has planes across it; for scans, also into equal parts.
3. ``_drawn`` and ``_costs``: copies in all these ways with random contents, and how likely the cloud makes each element of each copy.
4. ``_assembled``: for each way, the likeliest element between the same two planes; of all ways, the likeliest.

Meanwhile the noise of the cloud is taken to be large, so that an element that is right but a little off is likelier than none. Repeats within
elements are put together after the elements.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from ..geometry.runs import runs
from ..records import dataclass
from ..runtime.batch import Batch
from ..sampling.search import domain_ends
from .compare import Candidates, Targets
from .develop import apart, copied, developed
from .evidence import Clouds, Evidence, weigh, weigh_elements
from .model import Model
from .repeats import Layout, Places, Repeat, boxes_of_elements, contents_of, find_repeats, relaid
from .search import Effort, best_of, taken, united

_WIDE = 8e-3  # diagonals: the noise is taken to be at least this
_PROBES = 8  # copies of each candidate from which the rooms are read off
# how many of the likeliest ways are kept: for a repeat that holds others, and for one that does not
_OUTER, _INNER = 2, 3
_PLANES = 7  # planes of the cloud across a row that are considered: 2 ** 7 ways at most to divide it
_BINS = 128  # in which the points of a row are counted along its axis
_ENDS = 5  # bins at either end of a row: planes there are its own sides
_NEXT = 2  # bins: planes as near to each other as this count as one
_FEW = 4  # points: with fewer, a bin holds no plane
_ACROSS = 0.9  # how far the normal of a point of such a plane reaches along the axis, at least
_AROUND = 0.02  # metres: points that lie this far outside the box of a row still belong to it
_SLACK = 1.05  # factor: elements may differ in size by so much more than their weights, as gaps and walls count as well
_BLOCK = 96  # copies that are weighed at a time
_LANE = 1000  # contents are drawn by lanes from here on: the lanes of other copies are smaller


def rearranged(model: Model, own: Targets, found: Candidates, clouds: Clouds, effort: Effort) -> Candidates:
    """The candidates that become likelier when the elements of their repeats are put together anew, in their new form."""
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
    return developed(model, own, found, clouds, taken(model, every, at), effort)


def _composed(
    model: Model, own: Targets, found: Candidates, clouds: Clouds, base: Evidence, one: Repeat, copies: int, best: int
) -> tuple[Candidates, np.ndarray]:
    """Each candidate with the elements of one repeat put together anew from many ``copies`` of it, in the ``best`` ways; and for each of these
    the candidate that it was made of."""
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
    """Where the elements of each of n places stand: the ``axis`` (n,) along which they follow one another, in its direction or against it
    (``sign`` (n,), 1 or -1), and the box of all of them, ``low`` and ``high`` (n, 3) in metres, in the frames of the candidates; inf and -inf
    for a place that never has elements."""

    axis: np.ndarray
    sign: np.ndarray
    low: np.ndarray
    high: np.ndarray

    def along(self, points: np.ndarray, place: np.ndarray) -> np.ndarray:
        """How far along the room of its ``place`` (...) each of the ``points`` (..., 3) lies: 0 where the first element begins, 1 where the
        last one ends."""
        axis = self.axis[place][..., None]
        at, low, high = (
            np.take_along_axis(one, axis, axis=-1)[..., 0] for one in (points, self.low[place], self.high[place])
        )
        share = (at - low) / np.maximum(high - low, 1e-9)
        return np.where(self.sign[place] > 0.0, share, 1.0 - share)


def _rooms(model: Model, found: Candidates, one: Repeat, places: Places) -> _Rooms:
    """Read off a few copies of each candidate that have various numbers of elements."""
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
    ends = _medians(lows[full], place[full], size, np.inf), _medians(highs[full], place[full], size, -np.inf)
    return _Rooms(axis, np.where(step[np.arange(size), axis] < 0.0, -1.0, 1.0), *ends)


def _medians(values: np.ndarray, of: np.ndarray, size: int, other: float) -> np.ndarray:
    """(size, 3) the medians of ``values`` (n, 3) that belong to each of ``size`` groups, ``other`` for a group without any."""
    many = np.bincount(of, minlength=size)
    start, some = np.cumsum(many) - many, np.flatnonzero(many)
    low, high = (start + (many - 1) // 2)[some], (start + many // 2)[some]
    found = np.full((size, 3), other)
    for axis in range(3):
        ascending = values[np.lexsort((values[:, axis], of)), axis]
        found[some, axis] = (ascending[low] + ascending[high]) / 2.0
    return found


def _weights(one: Repeat) -> tuple[int, ...]:
    return (one.weight,) if one.weight >= 0 else ()


def _sums(values: np.ndarray, of: np.ndarray, size: int) -> np.ndarray:
    found = np.zeros((size, values.shape[1]))
    np.add.at(found, of, values)
    return found


def _pairs(places: Places, of: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """For copies made ``of`` (K,) candidates: all their places, in the order in which a batch of these copies has them, and the copy that each
    of these places is in."""
    many = places.many[of]
    return runs(places.first[of], many), np.repeat(np.arange(len(of)), many)


@dataclass(frozen=True, slots=True, eq=False)
class _Ways:
    """W ways to lay out elements, ordered by place. For each the ``place`` (W,), how ``many`` (W,) elements it has, their ``ends``
    (W, most + 1) from 0 to 1, inf beyond the last one, and the ``slot`` (W, most) of each element, -1 beyond: elements that lie between the
    same two ends share a slot. The ways of place k are the ``count[k]`` ones from ``begin[k]`` on. ``ratio``: the least and the largest weight
    that an element may have."""

    place: np.ndarray
    many: np.ndarray
    ends: np.ndarray
    slot: np.ndarray
    begin: np.ndarray
    count: np.ndarray
    ratio: tuple[float, float]

    def layout(self, way: np.ndarray, copy: np.ndarray) -> Layout:
        """The ways ``way`` (m,), each in one of the copies ``copy`` (m,)."""
        with np.errstate(invalid="ignore"):
            room = np.diff(self.ends[way], axis=1)
        room = np.where(self.slot[way] >= 0, room, np.nan)
        least, most = np.nanmin(room, axis=1), np.nanmax(room, axis=1)
        low, high = self.ratio
        weight = np.clip(room * np.sqrt(low / least * high / most)[:, None], low, high)
        return Layout(self.place[way], copy, self.many[way], np.where(np.isnan(weight), low, weight))


def _ways(own: Targets, found: Candidates, one: Repeat, places: Places, rooms: _Rooms) -> _Ways:
    """All the ways in which planes of the clouds can divide the rooms, as far as the weights allow; if there are no weights, each number of
    equal elements."""
    ratio = _range_of_weights(found.batch, one)
    most = int(places.most.max(initial=1))
    ends, many = _divided(own, found, places, rooms, most) if one.weight >= 0 else _equal(most)
    room = np.diff(np.where(np.isfinite(ends), ends, np.nan), axis=2)
    with np.errstate(invalid="ignore"):
        least, most = (f(room, axis=2, initial=end) for f, end in ((np.fmin.reduce, np.inf), (np.fmax.reduce, 0.0)))
    good = (many >= np.maximum(places.least, 1)[:, None]) & (many <= places.most[:, None])
    good &= np.isfinite(rooms.low).all(axis=1)[:, None] & ~np.isnan(ends).any(axis=2)
    if one.weight >= 0:
        good &= most * ratio[0] <= least * ratio[1] * _SLACK
    of, way = np.nonzero(good)
    number = many[way]
    wide = int(number.max(initial=1))
    chosen = np.broadcast_to(ends, (len(places.owner), *ends.shape[1:]))[of, way, : wide + 1]
    there = np.arange(wide) < number[:, None]
    row, rank = np.nonzero(there)
    if one.weight >= 0:
        said = np.stack([of[row], chosen[row, rank], chosen[row, rank + 1]])
    else:
        said = np.stack([of[row], number[row], rank])
    slot = np.full(there.shape, -1)
    if len(of):
        slot[there] = np.unique(said, axis=1, return_inverse=True)[1].ravel()
    begin, end = (np.searchsorted(of, np.arange(len(places.owner)), side=side) for side in ("left", "right"))
    return _Ways(of, number, chosen, slot, begin, end - begin, ratio)


def _equal(most: int) -> tuple[np.ndarray, np.ndarray]:
    """The ends (1, most, most + 1) of 1 to ``most`` equal elements, inf beyond the last one; and how many elements these are (most,)."""
    many, rank = np.arange(1, most + 1), np.arange(most + 1)
    return np.where(rank <= many[:, None], rank / many[:, None], np.inf)[None], many


def _divided(
    own: Targets, found: Candidates, places: Places, rooms: _Rooms, most: int
) -> tuple[np.ndarray, np.ndarray]:
    """The ends (n, W, P + 2) of elements that share n rooms by their weights, inf beyond the last one, and how many elements these are (W,):
    where the clouds have planes, and in scans, whose noise hides these, also in up to ``most`` equal parts. A room that cannot be divided so
    has an end that is nan."""
    ends, many = _parted(own, found, places, rooms)
    scanned = own.scanned[found.target[places.owner]]
    if not scanned.any():
        return ends, many
    equal, count = _equal(min(most, _PLANES + 1))
    beyond = np.full((len(count), ends.shape[2] - equal.shape[2]), np.inf)
    equal = np.where(scanned[:, None, None], np.concatenate([equal[0], beyond], axis=1), np.nan)
    one, rest = slice(1), slice(1, None)  # one element is the first way of both
    return np.concatenate([ends[:, one], equal[:, rest], ends[:, rest]], axis=1), np.concatenate(
        [many[one], count[rest], many[rest]]
    )


def _parted(own: Targets, found: Candidates, places: Places, rooms: _Rooms) -> tuple[np.ndarray, np.ndarray]:
    """The ends (n, W, P + 2) of elements for each of the W = 2^P choices among the P planes across each of n rooms, inf beyond the last one;
    and how many elements a choice makes (W,). A choice with a plane that a room does not have has an end that is nan."""
    number = np.arange(1 << _PLANES)
    chosen = (number[:, None] >> np.arange(_PLANES)[::-1]) % 2 == 1
    size = chosen.sum(axis=1)
    order = np.lexsort((-number, size))  # few planes first
    chosen, size = chosen[order], size[order]
    planes = np.where(chosen, _planes(own, found, places, rooms)[:, None], np.inf)
    planes = np.sort(planes, axis=2)  # what is not chosen comes last, and so does nan
    ends = np.concatenate([np.zeros((*planes.shape[:2], 1)), planes, np.full((*planes.shape[:2], 1), np.inf)], axis=2)
    ends[:, np.arange(len(size)), size + 1] = 1.0
    return ends, size + 1


def _range_of_weights(batch: Batch, one: Repeat) -> tuple[float, float]:
    """The least and the largest weight that an element may have."""
    if one.weight < 0:
        return 1.0, 1.0
    low, high = domain_ends(batch, one.weight)
    return max(float(low.max(initial=0.0)), 1e-6), max(float(high.min(initial=np.inf)), 1e-6)


def _planes(own: Targets, found: Candidates, places: Places, rooms: _Rooms) -> np.ndarray:
    """(n, P) where the cloud has its largest planes across each of n rooms, ascending from 0 to 1; nan where there are fewer."""
    owner, size = places.owner, len(places.owner)
    target, every = found.target[owner], np.arange(size)
    shift, scale = found.placed.shift[owner], found.placed.scale[owner, None]
    there = np.arange(own.points.shape[1]) < own.count[target, None]
    for axis in range(3):
        at = (own.points[target, :, axis] - shift[:, axis, None]) / scale
        there &= (at > rooms.low[:, axis, None] - _AROUND) & (at < rooms.high[:, axis, None] + _AROUND)
    there &= np.abs(own.normals[target, :, rooms.axis]) > _ACROSS
    place, point = np.nonzero(there)
    at = rooms.along((own.points[target[place], point] - shift[place]) / scale[place], place)
    bin_ = np.clip((at * _BINS).astype(np.int64), 0, _BINS - 1)
    bins = np.bincount(place * _BINS + bin_, minlength=size * _BINS).reshape(size, _BINS).astype(np.float64)
    rest = bins.copy()
    rest[:, 1:] += 0.5 * bins[:, :-1]
    rest[:, :-1] += 0.5 * bins[:, 1:]
    rest[:, :_ENDS] = rest[:, -_ENDS:] = 0.0
    planes = np.full((size, _PLANES), np.nan)
    for nth in range(_PLANES):
        top = rest.argmax(axis=1)
        good = np.flatnonzero(rest[every, top] >= _FEW)
        near = top[good, None] + np.arange(-1, 2)
        weight = bins[good[:, None], near]
        planes[good, nth] = (weight * (near + 0.5)).sum(axis=1) / weight.sum(axis=1) / _BINS
        rest[np.abs(np.arange(_BINS) - top[:, None]) <= _NEXT] = 0.0
    return np.sort(planes, axis=1)


@dataclass(frozen=True, slots=True, eq=False)
class _Pairs:
    """For each place of each copy, one after the other, the ``way`` in which it is laid out, -1 for none; ``of`` (K,): the candidate that each
    copy was made of."""

    way: np.ndarray
    of: np.ndarray


def _drawn(
    model: Model, found: Candidates, one: Repeat, places: Places, ways: _Ways, copies: int
) -> tuple[Batch, _Pairs]:
    """So many ``copies`` of each candidate, in which each place goes through all its ways in turn, with contents drawn at random."""
    some = np.flatnonzero(np.bincount(places.owner, ways.count, minlength=len(found)) > 0)
    of, turn = np.repeat(some, copies), np.tile(np.arange(copies), len(some))
    place, copy = _pairs(places, of)
    nth = place - places.first[of[copy]]
    many = ways.count[place]
    step = 2 * nth + 1  # other steps for other places, so that their ways are combined freely
    way = np.where(many > 0, ways.begin[place] + (turn[copy] * step + nth) % np.maximum(many, 1), -1)
    laid = np.flatnonzero(way >= 0)
    made = relaid(model, found.batch, of, _LANE + turn, one, places, ways.layout(way[laid], copy[laid]))
    good = np.flatnonzero(~made.state.failed)
    batch, way = model.assembled([(made, good)]), way[np.isin(copy, good)]
    as_asked = batch.rowmap.rows(one.scope).count == ways.many[way]  # the program may have lowered a count
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
    """How unlikely the clouds make each element of all copies (n,), in natural logarithms: by the points of its own surface, and by those of
    the cloud within its ends."""
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
    """For points (m, 3) of the candidates ``of`` (m,): the nearest room, as the number (m,) of its place among those of the candidate."""
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
    """Candidates in the ``best`` likeliest ways of their places, each slot taken by its likeliest element; and what each was made of."""
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
