"""The surface of a real object, bound to the object of a program that was fitted to it."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np
from scipy.spatial import cKDTree

from .. import random
from ..geometry import points as geometry
from ..geometry.vectors import dot
from ..records import dataclass
from .assign import ASSIGNMENTS, CHECKED, REFINED, features
from .completion import complete
from .elements import Elements, Solids, elements_of
from .record import DIRECT, Details
from .refuse import find_details

if TYPE_CHECKING:
    from ..runtime.batch import Batch

_REACH = 1.0  # distances between points: so far aside a point of a cloud stands for the surface around it
_STEPS = 3
POINTS = 8192  # of a structure and of a cloud that are assigned to one another


@dataclass(frozen=True, slots=True, eq=False)
class Real:
    """The outer surface of a real object, in the frame of the object fitted to it: ``points`` (n, 3) metres in random order, unit ``normals``
    (n, 3), ``label`` (n,) indexing ``labels``, -1 for none."""

    name: str
    points: np.ndarray
    normals: np.ndarray
    label: np.ndarray
    labels: tuple[str, ...]

    @property
    def diagonal(self) -> float:
        size = np.ptp(self.points, axis=0)
        return float(np.sqrt((size * size).sum()))


def bind(
    batch: Batch, real: Real, count: int = POINTS, assignment: str = "transport", completed: bool = False
) -> Details:
    """The details of the one object of a batch: ``count`` points on what can be seen of its structure and as many of the real surface,
    assigned by one of ``ASSIGNMENTS``. Where nothing of the cloud is near, no point is bound. ``completed``: what cannot be seen is
    bound as well, as far as symmetries tell of it, and so is what had only accidents."""
    address = np.asarray(batch.numbers).astype(np.uint64)
    made = geometry.sample(batch.sites(), 1, count, random.key(batch.seed, "details"), address, outside=True)
    place, outward = made.position[0], made.normal[0]
    cloud, facing = real.points[:count], real.normals[:count]
    diagonal = real.diagonal
    own, there = ASSIGNMENTS[assignment](features(place, outward, diagonal), features(cloud, facing, diagonal))
    order = np.lexsort((there, own))
    own, there = own[order], there[order]
    elements, solids = elements_of(batch), Solids.of(batch.sites())
    tables = batch.sites()
    site = made.site[0].astype(np.int64)
    begin = np.cumsum([0, *(len(table) for table in tables)])
    rank = np.concatenate([table.rank for table in tables])[begin[site] + made.row[0]]
    every = elements.find(np.zeros(count, dtype=np.int64), site, rank)
    element = every[own]
    patch, u, v = made.patch[0][own].astype(np.int64), made.u[0][own], made.v[0][own]
    if assignment in REFINED:
        u, v = _refined(elements, solids, (element, patch, u, v), cloud[there], _REACH * _spacing(place))
    u, v = (x.astype(np.float32).astype(np.float64) for x in (u, v))
    _, first = np.unique(np.stack([element, patch, u, v]), axis=1, return_index=True)
    first.sort()  # of several at one place none but the first can be found again
    element, patch, u, v, there = (x[first] for x in (element, patch, u, v, there))
    frames = solids.frames(elements, element, patch, u, v)
    at = elements.placed(element, frames.place)
    partner = _settled(at, cloud[there], facing[there], _REACH * _spacing(cloud))
    offset = frames.into(elements.local(element, partner - at))
    turned = frames.into(elements.local(element, facing[there]))
    length = np.sqrt(dot(turned, turned))
    details = Details(
        elements,
        element,
        patch,
        u,
        v,
        offset,
        turned / np.maximum(length, 1e-12)[:, None],
        real.label[:count][there],
        np.full(len(there), DIRECT),
        (real.name,),
        real.labels,
        np.array([diagonal]),
    )
    seen = every, made.patch[0].astype(np.int64), made.u[0], made.v[0]
    if assignment in CHECKED:
        good = find_details(details, solids, seen[:2], len(cloud) / count)
        refused = np.setdiff1d(own[first], own[first[good]])
        known = np.setdiff1d(np.arange(count), refused)
        details, seen = details.take(good), tuple(column[known] for column in seen)
    return complete(details, solids, seen, _spacing(place)) if completed else details


def _refined(
    elements: Elements,
    solids: Solids,
    bound: tuple[np.ndarray, np.ndarray, np.ndarray, np.ndarray],
    target: np.ndarray,
    reach: float,
) -> tuple[np.ndarray, np.ndarray]:
    """Fractions (m,) of the place of the surface that is nearest to ``target`` (m, 3), about ``reach`` at most from where (element, patch,
    u, v) are: steps along the tangents, kept where they bring it nearer."""
    element, patch, u, v = bound
    for _ in range(_STEPS):
        frames = solids.frames(elements, element, patch, u, v)
        way = elements.local(element, target - elements.placed(element, frames.place))
        aside = np.clip(frames.into(way)[:, 1:], -reach / _STEPS, reach / _STEPS) / frames.speed
        moved = np.clip(u + aside[:, 0], 0.0, 1.0), np.clip(v + aside[:, 1], 0.0, 1.0)
        new = solids.frames(elements, element, patch, *moved)
        left = elements.local(element, target - elements.placed(element, new.place))
        nearer = dot(left, left) < dot(way, way)
        u, v = np.where(nearer, moved[0], u), np.where(nearer, moved[1], v)
    return u, v


def _settled(at: np.ndarray, partner: np.ndarray, facing: np.ndarray, reach: float) -> np.ndarray:
    """Partners (m, 3) moved aside within their surface towards the points ``at``, as far as they stand for it: that they do not lie right
    across is chance as long as they are no farther off than points lie apart."""
    way = at - partner
    aside = way - dot(way, facing)[:, None] * facing
    length = np.sqrt(dot(aside, aside))
    return partner + aside * np.minimum(1.0, reach / np.maximum(length, 1e-12))[:, None]


def _spacing(points: np.ndarray) -> float:
    """How far points of a surface lie apart: of random ones the nearest is half as far on average."""
    return 2.0 * float(np.median(cKDTree(points).query(points[:2000], k=2)[0][:, 1]))
