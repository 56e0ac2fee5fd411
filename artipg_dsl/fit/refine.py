"""The numbers of all candidates moved together: damped least squares on the gaps both ways (Levenberg and Marquardt).

Derivatives are forward differences: each candidate stands once more in a batch for each of its numbers, moved a little
towards the side where there is room. A point's place is asked again only where its primitive has changed. What a requirement
leaves no room for is clipped by the evaluation itself, so that every step ends at an object that the text allows.
"""

from __future__ import annotations

import numpy as np

from ..geometry import points as geometry
from ..geometry.runs import runs
from ..geometry.sites import SiteTable
from ..geometry.vectors import dot
from ..records import dataclass
from ..runtime.batch import Batch
from .compare import Candidates, Compared, Targets, chosen, compare, starts
from .focus import Rows
from .match import Gaps
from .model import Changes, Freedoms, Model, Placed
from .products import crossed
from .states import tables

_STEP = 2e-3  # of a difference, in ranges
_LEAST_ROOM = 1e-7  # in ranges: a number with less on both sides stays
_LONGEST = 0.35  # a number moves so far at a time, in ranges
_WEAK = 1e-6  # what holds numbers that nothing depends on where they are
_DAMPING = 1e-2
_OPPOSED = 0.1  # what a pair counts whose normals disagree
_NOISY = 2.0  # times the noise of a cloud: gaps within count whole, since none of them is told from another
PLACE = 4  # how a candidate is placed: a shift along three axes and a scale, before its numbers


@dataclass(frozen=True, slots=True)
class Schedule:
    """``steps`` with ``points`` of each candidate; gaps count little beyond ``width`` (diagonals), the first and the last, or beyond the
    noise of the cloud where that is wider."""

    steps: int
    points: int
    width: tuple[float, float]


def refine(
    model: Model, targets: Targets, found: Candidates, schedule: Schedule, marked: Rows | None = None
) -> Candidates:
    """The candidates after some steps; none is worse than it was. ``marked``: only what moves these rows alone is moved."""
    damping = np.full(len(found), _DAMPING)
    batch, target, placed = found.batch, found.target, found.placed
    now = compare(batch, target, placed, targets, schedule.points, marked)
    (first, last), noise = schedule.width, _NOISY * targets.noise[target]
    held = None if marked is None else _held(model, batch, marked)
    ways, better = np.zeros((len(found), 0, 3, now.position.shape[1])), np.ones(len(found), dtype=bool)
    for step in range(schedule.steps):
        width = np.maximum(first * (last / first) ** (step / max(schedule.steps - 1, 1)), noise)
        free = model.freedoms(batch)
        free = free if held is None else free.take(np.flatnonzero(~np.isin(free.names, held)))
        ways = derivatives(model, batch, now, free, ways, better)
        moved, there = _step(model, targets, batch, target, placed, now, free, ways, damping, width, held is not None)
        then = compare(moved, target, there, targets, schedule.points, marked)
        better = (then.score < now.score) & ~moved.state.failed
        damping = np.where(better, np.maximum(damping * 0.3, 1e-5), np.minimum(damping * 6.0, 1e3))
        if better.any():
            batch, placed, now = _chosen(model, better, (batch, placed, now), (moved, there, then))
    return Candidates(batch, target, placed, now.score)


def _chosen(
    model: Model, better: np.ndarray, old: tuple[Batch, Placed, Compared], new: tuple[Batch, Placed, Compared]
) -> tuple[Batch, Placed, Compared]:
    """The new ones where they are better."""
    if better.all():
        return new
    rest, some = np.flatnonzero(~better), np.flatnonzero(better)
    batch = model.assembled([(old[0], rest), (new[0], some)], [rest, some])
    placed = Placed(np.where(better, new[1].scale, old[1].scale), np.where(better[:, None], new[1].shift, old[1].shift))
    return batch, placed, chosen(better, new[2], old[2])


def _step(
    model: Model,
    targets: Targets,
    batch: Batch,
    target: np.ndarray,
    placed: Placed,
    now: Compared,
    free: Freedoms,
    ways: np.ndarray,
    damping: np.ndarray,
    width: np.ndarray,
    fixed: bool,
) -> tuple[Batch, Placed]:
    """Each candidate after one damped step towards smaller gaps; ``ways`` are the derivatives of its points. Its place stays if it is
    ``fixed``."""
    matrix, slope = equations(targets, target, placed, now, free, ways, width)
    return _solved(model, batch, placed, free, matrix, slope, damping, targets.diagonal[target], fixed)


def equations(
    targets: Targets,
    target: np.ndarray,
    placed: Placed,
    now: Compared,
    free: Freedoms,
    ways: np.ndarray,
    width: np.ndarray,
) -> tuple[np.ndarray, np.ndarray]:
    """The normal equations of candidates: matrix (K, P, P) and slope (K, P), of a shift along three axes (metres), a scale, and the
    numbers of each (in ranges). Gaps count little beyond the ``width`` (K,) of each."""
    diagonal, every = targets.diagonal[target], np.arange(len(target))[:, None]
    many = np.bincount(free.owner, minlength=len(target))
    matrix = np.zeros((len(target), PLACE + free.most, PLACE + free.most))
    slope = np.zeros(matrix.shape[:2])
    local = now.position - placed.shift[:, None, :]  # what a scale carries outwards
    grown = np.where(targets.known[target], 0.0, 1.0)
    seen = [np.ones(now.there.shape), np.where(now.hidden, 0.0, 1.0)]
    index = [now.there, None]
    pairs = zip((now.to_surface, now.to_cloud), now.agree, now.unlike, seen, index, strict=True)
    for gap, agree, unlike, weight, at in pairs:
        weight = weight * _trust(gap, width) * np.where(unlike, 0.0, np.maximum(agree, _OPPOSED))
        weight = weight / np.maximum(_count(weight), 1.0)[:, None]
        out = local if at is None else local[every, at]
        outwards = grown[:, None] * dot(out, gap.way)
        for k in range(len(target)):  # one at a time, since its numbers stay in the cache
            moved = ways[k, : many[k]]
            moved = moved if at is None else np.take(moved, at[k], axis=2)
            x, y, z = way = np.ascontiguousarray(gap.way[k].T)
            along = placed.scale[k] * (moved[:, 0] * x + moved[:, 1] * y + moved[:, 2] * z)
            columns = np.concatenate([way, outwards[k : k + 1], along]) / diagonal[k]
            leaned = columns * weight[k]
            size = len(columns)
            matrix[k, :size, :size] += crossed(leaned, columns)
            slope[k, :size] += (leaned * gap.value[k]).sum(axis=1)
    return matrix, slope


def _count(weight: np.ndarray) -> np.ndarray:
    return np.asarray((weight > 0.0).sum(axis=1))


def _trust(gap: Gaps, width: np.ndarray) -> np.ndarray:
    """What gaps (K, n) count: whole ones within ``width`` (K,), little beyond (Geman and McClure)."""
    return np.asarray(1.0 / (1.0 + (gap.value / width[:, None]) ** 2) ** 2)


def _solved(
    model: Model,
    batch: Batch,
    placed: Placed,
    free: Freedoms,
    matrix: np.ndarray,
    slope: np.ndarray,
    damping: np.ndarray,
    diagonal: np.ndarray,
    fixed: bool,
) -> tuple[Batch, Placed]:
    """The damped equations solved; numbers that would leave their range stay where they are, and the place if it is ``fixed``."""
    room = _LEAST_ROOM * free.width
    number = free.owner, PLACE + free.place
    pressed = np.zeros(slope.shape, dtype=bool)
    pressed[number] = np.where(slope[number] < 0, free.high - free.value < room, free.value - free.low < room)
    pressed[:, :PLACE] = fixed
    matrix = np.where(pressed[:, :, None] | pressed[:, None, :], 0.0, matrix)
    slope = np.where(pressed, 0.0, slope)
    own = np.einsum("kii->ki", matrix)
    total = matrix + np.eye(matrix.shape[1]) * (own * damping[:, None] + _WEAK)[:, :, None]
    way = -_roots(total, slope, PLACE + np.bincount(free.owner, minlength=len(batch)))
    numbers = np.clip(way[number], -_LONGEST, _LONGEST)
    value = np.clip(free.value + numbers * free.width, free.low, free.high)
    copies = np.arange(len(batch))
    moved = model.altered(batch, copies, Changes(free.owner, free.draw, free.row, value))
    shift = np.clip(way[:, : PLACE - 1], -_LONGEST * diagonal[:, None], _LONGEST * diagonal[:, None])
    grown = np.clip(way[:, PLACE - 1], -_LONGEST, _LONGEST)
    return moved, Placed(placed.scale * np.exp(grown), placed.shift + shift)


def _roots(matrix: np.ndarray, slope: np.ndarray, many: np.ndarray) -> np.ndarray:
    """(K, P) the roots of equations (K, P, P), the first ``many`` (K,) of each, 0 beyond. Those of one size are solved together: filled up
    to the largest they would be rounded otherwise, and a fit would depend on what is fitted beside it."""
    found = np.zeros(slope.shape)
    for size in np.unique(many):
        at = np.flatnonzero(many == size)
        found[at, :size] = np.linalg.solve(matrix[at, :size, :size], slope[at, :size, None])[:, :, 0]
    return found


# ---------------------------------------------------------------- derivatives


def _held(model: Model, batch: Batch, marked: Rows) -> np.ndarray:
    """The names of the numbers of candidates that move rows which are not ``marked``."""
    free = model.freedoms(batch)
    moved, _ = _moved(model, batch, free)
    sites = tables(batch)
    copy, _, base = _changed(sites, tables(moved), free.owner, starts(sites))
    others = ~np.concatenate([np.zeros(0, dtype=bool), *marked.among(sites)])
    found: np.ndarray = free.names[np.unique(copy[others[base]])]
    return found


def _moved(model: Model, batch: Batch, free: Freedoms) -> tuple[Batch, np.ndarray]:
    """A copy of its candidate for each number, in which this is moved a little, and by how much."""
    upward = free.high - free.value >= free.value - free.low
    reach = np.minimum(_STEP * free.width, np.maximum(free.high - free.value, free.value - free.low))
    reach = np.where(upward, reach, -reach)
    changes = Changes(np.arange(len(free)), free.draw, free.row, free.value + reach)
    return model.altered(batch, free.owner, changes), reach


def derivatives(
    model: Model, batch: Batch, now: Compared, free: Freedoms, before: np.ndarray, changed: np.ndarray
) -> np.ndarray:
    """(K, P, 3, n): how the points of each candidate move as each of its numbers grows by the width of its range. They are those ``before``
    (K, Q, 3, n) for candidates that have not ``changed`` (K,) since."""
    count, n = now.position.shape[:2]
    out = np.zeros((count, free.most, 3, n))
    many = min(free.most, before.shape[1])  # numbers that a candidate does not have are 0
    out[~changed, :many] = before[~changed, :many]
    free = free.take(np.flatnonzero(changed[free.owner]))
    if not len(free):
        return out
    moved, reach = _moved(model, batch, free)
    sites, others = tables(batch), tables(moved)
    begin = starts(sites)
    copy, there, base = _changed(sites, others, free.owner, begin)
    first = np.zeros((len(begin), count), dtype=np.int64)
    for table in sites:
        first[table.number] = begin[table.number] + np.searchsorted(table.owner, np.arange(count))
    stands = first[now.points.site, np.arange(count)[:, None]] + now.element  # of each point, among all rows
    stands = stands.ravel()
    order = np.argsort(stands, kind="stable")
    count_of = np.bincount(stands, minlength=begin[-1])
    low = np.cumsum(count_of) - count_of
    asked = np.flatnonzero(count_of[base])
    copy, there, base = copy[asked], there[asked], base[asked]
    others, there = _taken(others, np.searchsorted(begin, base, side="right") - 1, there)
    many = count_of[base]
    point = order[runs(low[base], many)]
    copy, there = np.repeat(copy, many), np.repeat(there, many)
    own, point = point // n, point % n
    site, patch, u, v = (getattr(now.points, name)[own, point] for name in ("site", "patch", "u", "v"))
    place, _, exists = geometry.evaluate_flat(others, copy, site, there, patch, u, v)
    way = (place - now.points.position[own, point]) * (free.width / np.where(reach == 0.0, np.inf, reach))[copy, None]
    out[own, free.place[copy], :, point] = np.where(exists[:, None], way, 0.0)
    return out


def _taken(tables: list[SiteTable], site: np.ndarray, row: np.ndarray) -> tuple[list[SiteTable], np.ndarray]:
    """The tables with the rows ``row`` (n,) alone of the sites ``site`` (n,), which are in order, and where these are now (n,)."""
    found, now = [], np.empty_like(row)
    for table in tables:
        mine = np.flatnonzero(site == table.number)
        found.append(table.take(row[mine]))
        now[mine] = np.arange(len(mine))
    return found, now


def _changed(
    sites: list[SiteTable], moved: list[SiteTable], owner: np.ndarray, begin: np.ndarray
) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Rows of the primitives of copies that are not what they are in the candidate ``owner`` (copies,) they were made from: the copy,
    the row of its table, and that of the candidate among all rows; ordered by copy."""
    found: list[list[np.ndarray]] = [[], [], []]
    for table, other in zip(sites, moved, strict=True):
        if not len(table) or not len(other):
            continue
        candidate = owner[other.owner]
        first, last = (np.searchsorted(table.owner, candidate, side=side) for side in ("left", "right"))
        there = np.flatnonzero(first + other.rank < last)
        base = (first + other.rank)[there]
        differs = (table.rotation[base] != other.rotation[there]).any(axis=(1, 2))
        differs |= (table.translation[base] != other.translation[there]).any(axis=1)
        for name, value in table.params.items():
            differs |= value[base] != other.params[name][there]
        told = other.owner[there], there, begin[table.number] + base
        for column, one in zip(found, told, strict=True):
            column.append(one[differs])
    copy, row, base = (np.concatenate([np.zeros(0, dtype=np.int64), *column]) for column in found)
    order = np.argsort(copy, kind="stable")
    return copy[order], row[order], base[order]
