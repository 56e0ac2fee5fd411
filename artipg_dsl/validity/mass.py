"""Mass, centre and inertia of every link of a batch."""

from __future__ import annotations

from dataclasses import fields
from functools import cached_property
from itertools import pairwise
from typing import TYPE_CHECKING

import numpy as np

from ..geometry.block import block_of
from ..geometry.box import bounds
from ..geometry.errors import PrimitiveError
from ..geometry.overlap import Touching
from ..geometry.runs import distinct
from ..geometry.sites import weigh
from ..records import dataclass
from ..runtime.motion import apply, multiply
from .fault import Fault, list_faults
from .materials import draw_property, list_materials, material_rows

if TYPE_CHECKING:
    from ..geometry.sites import SiteTable
    from ..runtime.batch import Batch


_INVERTED = 1e-6  # of the box: more than rounding
_ROUNDING = 1e-9  # of the moments of a primitive
SAMPLED = 0.02  # of a box: more than points in it are wrong by
_LEAST = 1e-9  # kg: what weighs less is no body


@dataclass(frozen=True, slots=True)
class Mass:
    """Per link of the batch: mass (L,) kg, centre (L, 3) and inertia about it (L, 3, 3), axes of the object."""

    mass: np.ndarray
    center: np.ndarray
    inertia: np.ndarray


def masses(batch: Batch) -> Mass:
    """The mass of every link of a batch, in the object's frame at joint values 0; worked out once for a batch."""
    if "masses" not in batch.known:
        batch.known["masses"] = link_mass(*_weighing_of(batch))
    return batch.known["masses"]


def weighing(batch: Batch) -> Weighing:
    """The primitives of a batch and bounds of what they weigh, without inertia; worked out once for a batch."""
    if "weighing" not in batch.known:
        batch.known["weighing"] = Weighing(*_weighing_of(batch))
    return batch.known["weighing"]


def heavier(batch: Batch, limit: float) -> np.ndarray:
    """Which objects (B,) weigh more than ``limit`` kg; worked out once for a batch. Overlaps are measured where their bounds do not tell."""
    name = f"heavier than {limit!r} kg"
    if name not in batch.known:
        batch.known[name] = _heavier(batch, limit)
    return batch.known[name]


def _heavier(batch: Batch, limit: float) -> np.ndarray:
    owner, known = batch.links().owner, weighing(batch)
    rough = known.rough
    most = np.bincount(owner, rough.mass, len(batch))
    taken = rough.taken(rough.most, np.ones(len(rough.link)))
    found = most > limit
    asked = found & ~(most - np.bincount(owner[rough.link], taken, len(batch)) > limit)
    if asked.any():
        found[asked] = np.bincount(owner, known.masses(asked).mass, len(batch))[asked] > limit
    return found


def _weighing_of(batch: Batch) -> tuple[list[SiteTable], list[np.ndarray], np.ndarray, int, np.ndarray]:
    """What ``link_mass`` is told of a batch."""
    links, tables = batch.links(), batch.sites()
    start = np.searchsorted(links.owner, np.arange(len(batch)))
    density = np.stack([draw_property(batch, material, "density") for material in list_materials(batch)])
    densities = [density[material_rows(batch, table), table.owner] for table in tables]
    return tables, densities, start, len(links.owner), _welded(batch, start)


def find_weightless(batch: Batch) -> list[Fault]:
    """Links that weigh nothing.

    The densest primitive of a body loses nothing to others, and none is without thickness: only a link that is fixed to
    others can lose all it has to them. Bounds tell most links that keep some of it; overlaps are measured for the others alone.
    """
    if batch.joints().that().all():
        return []
    links, rough = batch.links(), weighing(batch).rough
    most = np.bincount(rough.link, rough.taken(rough.most, np.ones(len(rough.link))), len(rough.mass))
    asked = ~(rough.mass - most > np.maximum(_LEAST, rough.mass / 10))
    if not asked.any():
        return []
    found = masses(batch)
    trace = found.inertia[:, 0, 0] + found.inertia[:, 1, 1] + found.inertia[:, 2, 2]
    rows = np.flatnonzero(asked & ~((found.mass > _LEAST) & (trace > 0.0))).tolist()
    wrong = ((batch.program.links[links.definition[row]].path, int(links.owner[row])) for row in rows)
    words = "the link `{}` has no mass of its own: denser parts fill all of it"
    return list_faults(((words.format(path), None, path), owner) for path, owner in wrong)


def find_crossed(batch: Batch) -> list[Fault]:
    """Primitives whose surfaces cross, so that no body has their moments.

    Within the ranges that a primitive is tested for it is sound; those beyond them are asked one by one, and all of a
    program that anyone may have edited.
    """
    asked = []
    for table in batch.sites():
        rows = np.arange(len(table)) if batch.program.foreign else np.flatnonzero(_untested(table))
        if len(rows):
            asked.append((table, rows))
    if not asked:
        return []
    weigh([table for table, _ in asked])  # all rows: annotations need them, too
    volume = np.concatenate([table.moments[0][rows] for table, rows in asked])
    inertia = np.concatenate([table.moments[2][rows] for table, rows in asked])
    trace = inertia[:, 0, 0] + inertia[:, 1, 1] + inertia[:, 2, 2]
    second = trace[:, None, None] / 2 * np.eye(3) - inertia  # of a body: no less than none along any direction
    wrong = ~(_definite(inertia, 0.0) & _definite(second, _ROUNDING * trace))
    found, start = [], 0
    for table, rows in asked if wrong.any() else ():
        part = slice(start, start + len(rows))
        start = part.stop
        path, inverted = batch.program.parts[batch.program.sites[table.number].part].path, volume[part] < 0.0
        for which, what in ((wrong[part] & inverted, "are inside out"), (wrong[part] & ~inverted, "cross one another")):
            if which.any():
                objects = distinct(table.owner[rows[which]])
                found.append(Fault(f"the surfaces of `{path}` {what}", objects, part=path))
    return found


def _untested(table: SiteTable) -> np.ndarray:
    """Which rows (k,) have a parameter outside the range that the primitive is tested for."""
    beyond = np.zeros(len(table), dtype=bool)
    for name, (low, high) in zip(table.primitive.parameters, table.primitive.test, strict=True):
        beyond |= (table.params[name] < low) | (table.params[name] > high)
    return beyond


def _definite(matrix: np.ndarray, slack: np.ndarray | float) -> np.ndarray:
    """Which symmetric matrices (k, 3, 3), plus ``slack`` times one, are positive definite, by their minors."""
    m = matrix + np.multiply.outer(np.broadcast_to(slack, len(matrix)), np.eye(3))
    plane = m[:, 0, 0] * m[:, 1, 1] - m[:, 0, 1] ** 2
    by_last = (
        m[:, 0, 2] * (m[:, 0, 1] * m[:, 1, 2] - m[:, 1, 1] * m[:, 0, 2])
        - m[:, 1, 2] * (m[:, 0, 0] * m[:, 1, 2] - m[:, 0, 1] * m[:, 0, 2])
        + m[:, 2, 2] * plane
    )
    return (m[:, 0, 0] > 0) & (plane > 0) & (by_last > 0)


def _welded(batch: Batch, start: np.ndarray) -> np.ndarray:
    """(L,) the first link (a row of the table) of those that fixed joints hold together."""
    joints = batch.joints()
    holder = np.arange(len(batch.links().owner))
    fixed = ~joints.that()
    first = start[joints.owner]
    holder[(first + joints.child)[fixed]] = (first + joints.parent)[fixed]
    while not np.array_equal(holder, holder[holder]):
        holder = holder[holder]
    return holder


def link_mass(
    tables: list[SiteTable], densities: list[np.ndarray], link_start: np.ndarray, n_links: int, body: np.ndarray
) -> Mass:
    """Mass of every link. Where primitives of one body overlap, as a post sunk in a wall does, the denser one counts.

    ``densities`` one array (k,) kg/m3 per table; ``link_start`` (B,) the first link row of each object; ``body`` (L,)
    the same number for links that do not move against one another. Of equally dense ones the first in the text counts.
    """
    return Weighing(tables, densities, link_start, n_links, body, inertia=True).masses()


_Portion = tuple[np.ndarray, np.ndarray, np.ndarray, np.ndarray]  # link, mass, centre, inertia about it, of k bodies


@dataclass(frozen=True, slots=True)
class Rough:
    """Per link its mass (L,) kg and centre (L, 3) as if no primitives overlapped; and what overlaps may take away: at most
    ``most`` (n,) kg of the link ``link`` (n,), no farther than ``radius`` (n,) from ``place`` (n, 3), in boxes that reach
    ``half`` (n, 3) and would hold ``full`` (n,) kg. Those of one primitive follow one another and have the same ``row`` (n,);
    together they take no more than it weighs, ``own`` (n,) kg. Axes of the object."""

    mass: np.ndarray
    center: np.ndarray
    row: np.ndarray
    own: np.ndarray
    link: np.ndarray
    most: np.ndarray
    place: np.ndarray
    radius: np.ndarray
    half: np.ndarray
    full: np.ndarray

    def at(self, chosen: np.ndarray) -> Rough:
        """With some of what may be taken away."""
        rest = (getattr(self, f.name)[chosen] for f in fields(self) if f.name not in ("mass", "center"))
        return Rough(self.mass, self.center, *rest)

    def taken(self, lost: np.ndarray, reach: np.ndarray) -> np.ndarray:
        """(n,) what primitives lose at most, each at the first of its overlaps and noughts at the others.

        ``lost`` (n,) is what single overlaps take, of whatever counts ``reach`` (n,) per kg where it counts most.
        """
        begin = np.flatnonzero(np.diff(self.row, prepend=-1))
        which = np.repeat(np.arange(len(begin)), np.diff(begin, append=len(self.row)))
        found = np.zeros(len(self.row))
        if len(begin):
            summed, far = np.bincount(which, lost), np.maximum.reduceat(reach, begin)
            found[begin] = np.minimum(summed, self.own[begin] * far)
        return found


class Weighing:
    """The primitives of links, weighed one by one, and which of them may overlap. Arguments as of ``link_mass``."""

    def __init__(
        self,
        tables: list[SiteTable],
        densities: list[np.ndarray],
        link_start: np.ndarray,
        n_links: int,
        body: np.ndarray,
        inertia: bool = False,
    ):
        self.count, self.inertia = n_links, inertia
        weigh(tables, inertia)
        self.own = _whole(tables, densities, link_start, inertia)
        rows = block_of(tables, 0, len(link_start))
        self.owner = rows.owner
        if not len(self.owner):
            return
        start = np.cumsum([0, *(len(table) for table in tables)])
        places = dict(zip((table.number for table in tables), start.tolist(), strict=False))
        at = np.array([places[number] for number in rows.site.tolist()]) + rows.row
        self.place = at  # of each primitive in the tables, one after the other
        self.density = np.concatenate(densities)[at]
        self.link, self.mass = (np.concatenate([part[k] for part in self.own])[at] for k in (0, 1))
        order = np.empty(len(at), dtype=np.int64)
        order[np.lexsort((rows.rank, -self.density))] = np.arange(len(at))
        worth = self.density / np.bincount(self.link, self.mass, len(body))[self.link]
        self.touching = Touching(rows, body[self.link], order, worth)

    def masses(self, asked: np.ndarray | None = None) -> Mass:
        """Of all links; right for the objects ``asked`` (B,) bool alone, by default for all."""
        rows = [*self.own, *self._shared(asked)]
        total, middle = _summed(rows, self.count)
        summed = np.zeros((self.count, 3, 3))
        for link, mass, center, inertia in rows if self.inertia else ():
            about = inertia + _parallel_axis(mass, center - middle[link])
            for i in range(3):
                for j in range(3):
                    summed[:, i, j] += np.bincount(link, about[:, i, j], self.count)
        return Mass(total, middle, summed)

    @cached_property
    def rough(self) -> Rough:
        """Bounds of the masses from boxes alone."""
        mass, center = _summed(self.own, self.count)
        if not len(self.owner):
            none, nowhere = np.zeros(0), np.zeros((0, 3))
            number = none.astype(np.int64)
            return Rough(mass, center, number, none, number, none, nowhere, none, nowhere, none)
        found = self.touching.regions()
        volume = self.mass / self.density
        # a shell shares no more than it has, though its box is large; what is measured in points may err by a little
        most = np.minimum(found.volume, volume[found.first] + SAMPLED * found.volume)
        density = self.density[found.row]
        own, full = self.mass[found.row], found.volume * density
        most, link = np.minimum(most * density, own), self.link[found.row]
        return Rough(mass, center, found.row, own, link, most, found.center, found.radius, found.half, full)

    def _shared(self, asked: np.ndarray | None) -> list[_Portion]:
        """What primitives lose to denser ones that they overlap: portions of negative mass."""
        if not len(self.owner):
            return []
        found = self.touching.measured(None if asked is None else asked[self.owner], self.inertia)
        lost = found.volume * self.density[found.row]
        # measured in points: a primitive that lies in others altogether loses what it has, and no more
        most = self.mass / np.maximum(np.bincount(found.row, lost, len(self.mass)), 1e-300)
        share = np.minimum(most, 1.0)[found.row]
        inertia = found.inertia * (self.density[found.row] * share)[:, None, None]
        return [(self.link[found.row], -lost * share, found.center, -inertia)]


def _summed(rows: list[_Portion], n_links: int) -> tuple[np.ndarray, np.ndarray]:
    """Mass (L,) and centre (L, 3) of links."""
    total, first = np.zeros(n_links), np.zeros((n_links, 3))
    for link, mass, center, _ in rows:
        total += np.bincount(link, mass, n_links)
        first += np.stack([np.bincount(link, mass * center[:, i], n_links) for i in range(3)], axis=1)
    return total, first / np.where(total > 0, total, 1.0)[:, None]


def _whole(
    tables: list[SiteTable], densities: list[np.ndarray], link_start: np.ndarray, inertia: bool
) -> list[_Portion]:
    """The primitives of each site that has some; what they weigh is turned for all sites at once."""
    there = [(table, density) for table, density in zip(tables, densities, strict=True) if len(table)]
    if not there:
        return []
    weights = [table.weights if not inertia else table.moments for table, _ in there]
    for (table, _), (volume, *_) in zip(there, weights, strict=True):
        if (volume < 0.0).any():
            low, high = bounds(table.primitive, table.params)
            if (
                volume < -_INVERTED * np.prod(high - low, axis=1)
            ).any():  # one that was edited: the check of a program finds it
                raise PrimitiveError(table.primitive, None, "its surfaces are inside out")
    volume, center, *second = (np.concatenate(column) for column in zip(*weights, strict=True))
    density = np.concatenate([density for _, density in there])
    mirror, rotation, translation = (
        np.concatenate([getattr(table, name) for table, _ in there]) for name in ("mirror", "rotation", "translation")
    )
    sign = np.stack([np.ones_like(mirror), mirror, np.ones_like(mirror)], axis=-1)
    center = apply(rotation, center * sign) + translation
    about = np.zeros((len(mirror), 3, 3))
    if second:
        turned = second[0] * density[:, None, None] * sign[:, :, None] * sign[:, None, :]
        about = multiply(multiply(rotation, turned), rotation.transpose(0, 2, 1))
    link = np.concatenate([link_start[table.owner] + table.link for table, _ in there])
    ends = np.cumsum([0, *(len(table) for table, _ in there)]).tolist()
    mass = np.abs(volume) * density
    return [(link[a:b], mass[a:b], center[a:b], about[a:b]) for a, b in pairwise(ends)]


def _parallel_axis(mass: np.ndarray, offset: np.ndarray) -> np.ndarray:
    """What a mass (k,) at ``offset`` (k, 3) adds to the inertia: m (|d|^2 1 - d d^T)."""
    x, y, z = offset[:, 0], offset[:, 1], offset[:, 2]
    square = x * x + y * y + z * z
    outer = offset[:, :, None] * offset[:, None, :]
    return mass[:, None, None] * (square[:, None, None] * np.eye(3) - outer)
