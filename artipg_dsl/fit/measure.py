"""How far a fitted object and its cloud are apart, both ways, as shares of the diagonal; and which labels agree."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import numpy as np
from scipy.spatial import cKDTree

from .. import random
from ..annotate.points import label_points
from ..geometry import points as geometry
from ..geometry.pointset import PointSet
from ..geometry.sites import SiteTable
from ..records import dataclass
from ..runtime.batch import Batch
from .match import features
from .outer import outer, spacing

_POINTS = 16384  # of a structure: its whole boundary
_OUTSIDE = 4096  # what of it can be seen from without
NEAR, FAR = 0.025, 0.05  # of the diagonal: up to here a category fits, beyond it does not


@dataclass(frozen=True, slots=True, eq=False)
class Surface:
    """Points (n, 3) on the surface of one object, in the frame of its cloud; ``word`` (n,) of ``semantic``."""

    points: np.ndarray
    normals: np.ndarray
    word: np.ndarray


def surfaces(
    batch: Batch, sites: list[SiteTable], scale: np.ndarray, shift: np.ndarray
) -> tuple[list[Surface], list[Surface]]:
    """Of each object the whole boundary, and what can be seen from outside; ``sites``: its primitives, where its joints lead them."""
    found = []
    address = batch.state.objects.astype(np.uint64)
    for count, outside in ((_POINTS, False), (_OUTSIDE, True)):
        made = geometry.sample(sites, len(batch), count, random.key(0, "fitted"), address, outside=outside)
        labels = [label for label in batch.program.labels if label.vocabulary == "semantic"]
        word = label_points(batch, batch.sites(), _at_rest(batch, sites, made), labels).semantic
        at = made.position * scale[:, None, None] + shift[:, None, :]
        found.append([Surface(*columns) for columns in zip(at, made.normal, word, strict=True)])
    return found[0], found[1]


def roughly(
    batch: Batch, sites: list[SiteTable], scale: np.ndarray, shift: np.ndarray
) -> tuple[list[Surface], list[Surface]]:
    """The same without words, and with depth pictures that tell what can be seen: rays take up to a fifth of a fit."""
    address = batch.state.objects.astype(np.uint64)
    made = geometry.sample(sites, len(batch), _POINTS, random.key(0, "fitted"), address)
    at = made.position * scale[:, None, None] + shift[:, None, :]
    whole = [Surface(*columns) for columns in zip(at, made.normal, np.zeros(at.shape[:2], dtype=np.int64), strict=True)]
    seen = [np.flatnonzero(one)[:: _POINTS // _OUTSIDE] for one in outer(at)]
    outside = [Surface(one.points[k], one.normals[k], one.word[k]) for one, k in zip(whole, seen, strict=True)]
    return whole, outside


def _at_rest(batch: Batch, sites: list[SiteTable], points: PointSet) -> PointSet:
    """Points where they are with all joints at rest, as formulas of labels take them."""
    if sites is batch.sites():
        return points
    owner = np.repeat(np.arange(len(batch)), points.site.shape[1])
    bound = (getattr(points, name).ravel() for name in ("site", "row", "patch", "u", "v"))
    position, normal, _ = geometry.evaluate_flat(batch.sites(), owner, *bound)
    shape = points.position.shape
    return replace(points, position=position.reshape(shape), normal=normal.reshape(shape))


def distances(cloud: np.ndarray, normals: np.ndarray, whole: Surface, outside: Surface) -> dict[str, Any]:
    """Of each point of the cloud from the surface, and of the surface seen from outside from the cloud: mean, median and 95th
    percentile in percent of the cloud's diagonal. ``both`` is the mean of the two means."""
    diagonal = float(np.sqrt((np.ptp(cloud, axis=0) ** 2).sum()))
    forth = apart(cloud, whole.points, whole.normals) / diagonal
    back = apart(outside.points, cloud, normals) / diagonal
    found: dict[str, Any] = {
        name: {
            "mean": _percent(way.mean()),
            "median": _percent(np.median(way)),
            "p95": _percent(np.quantile(way, 0.95)),
        }
        for name, way in (("cloud_to_structure", forth), ("structure_to_cloud", back))
    }
    return found | {"both": _percent((forth.mean() + back.mean()) / 2)}


def apart(points: np.ndarray, others: np.ndarray, normals: np.ndarray) -> np.ndarray:
    """(n,) how far points lie from a surface of which others are known: along the normal of the nearest one, and aside as far as they
    lie beyond the distance between these."""
    spaced = float(spacing(others[None])[0])
    whole, at = cKDTree(others).query(points)
    way = points - others[at]
    along = np.abs((way * normals[at]).sum(axis=1))
    aside = np.maximum(np.sqrt(np.maximum(whole**2 - along**2, 0.0)) - spaced, 0.0)
    found: np.ndarray = np.sqrt(along**2 + aside**2)
    return found


def agreement(
    cloud: np.ndarray, normals: np.ndarray, words: np.ndarray, whole: Surface, meant: np.ndarray, names: tuple[str, ...]
) -> dict[str, float]:
    """For each word that the cloud or its nearest surface bears (``words`` (n,), 0 for none, as places in ``names``): the intersection
    over the union of both. Nearest is by place and normal: of two parts that touch, each is told. Points whose nearest surface bears a
    word that is none of those ``meant`` say nothing, as in the search."""
    said = np.flatnonzero(words > 0)
    if not len(said):
        return {}
    diagonal = np.sqrt((np.ptp(cloud, axis=0) ** 2).sum())
    mine, asked = (
        features(*sides, diagonal) for sides in ((whole.points, whole.normals), (cloud[said], normals[said]))
    )
    ours, theirs = whole.word[cKDTree(mine).query(asked)[1]], words[said]
    known = (ours == 0) | np.isin(ours, meant)
    ours, theirs = ours[known], theirs[known]
    present = np.unique(np.concatenate([ours, theirs]))
    return {
        names[k]: round(float(((ours == k) & (theirs == k)).sum() / ((ours == k) | (theirs == k)).sum()), 4)
        for k in present.tolist()
        if k > 0
    }


def verdict(both: float) -> str:
    """What a distance (in percent) says of the category."""
    return "fits" if both <= 100 * NEAR else "rough" if both <= 100 * FAR else "does not fit"


def _percent(share: float) -> float:
    return round(100.0 * float(share), 4)
