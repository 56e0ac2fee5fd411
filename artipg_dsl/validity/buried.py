"""Parts inside another part of their link, where nothing of them is seen: what can be asked of a few objects at once, for `check`."""

from __future__ import annotations

from itertools import product

import numpy as np

from ..geometry.box import bounds
from ..geometry.patches import inside_split
from ..geometry.runs import distinct
from ..geometry.sites import SiteTable
from ..runtime.batch import Batch
from .neighbours import find_neighbours

_FLUSH = 1e-7  # metres: what lies flush with a surface is hidden, too
# of a box, at which it is asked: in a frame only its corners lie inside
_SHARES = np.array(list(product((0.0, 0.5, 1.0), repeat=3)))


def find_buried(batch: Batch) -> dict[str, tuple[str, np.ndarray]]:
    """The paths of primitives of which, in each object that has some, one at least lies wholly inside another one: the path of
    that, and which rows of the site do (k,)."""
    tables = batch.sites()
    if not tables:
        return {}
    boxes = [table.boxes() for table in tables]
    low, high = (np.concatenate(ends) for ends in zip(*boxes, strict=True))
    owner, link = (np.concatenate([getattr(t, name) for t in tables]) for name in ("owner", "link"))
    site = np.repeat(np.arange(len(tables)), [len(table) for table in tables])
    _, body = np.unique(np.stack([owner, link]), axis=1, return_inverse=True)
    pairs = np.stack(find_neighbours(body.reshape(-1), low, high, np.full(len(owner), _FLUSH)))
    inner, outer = np.concatenate([pairs, pairs[::-1]], axis=1)
    within = (low[inner] >= low[outer] - _FLUSH).all(axis=1) & (high[inner] <= high[outer] + _FLUSH).all(axis=1)
    inner, outer = inner[within], outer[within]
    found: dict[str, tuple[str, np.ndarray]] = {}
    start = np.searchsorted(site, np.arange(len(tables)))
    for number, table in enumerate(tables):
        own = np.flatnonzero((site[inner] == number) & (site[outer] != number))
        row, other = inner[own] - start[number], outer[own]
        hidden, by = np.zeros(len(table), dtype=bool), ""
        for around in distinct(site[other]).tolist():
            mine = site[other] == around
            deep = _lies_inside(table, row[mine], tables[around], other[mine] - start[around])
            hidden[row[mine][deep]] = True
            by = by or (tables[around].path if deep.any() else "")
        if by and set(table.owner[hidden].tolist()) == set(table.owner.tolist()):
            found[table.path] = by, hidden
    return found


def _lies_inside(table: SiteTable, rows: np.ndarray, around: SiteTable, others: np.ndarray) -> np.ndarray:
    """Whether the boxes of rows lie inside the solids of other rows (k,)."""
    low, high = (end[rows] for end in bounds(table.primitive, table.params))
    at = low[:, None] + (high - low)[:, None] * _SHARES  # (k, 27, 3)
    at[..., 1] *= table.mirror[rows, None]
    at = np.einsum("kij,kcj->kci", table.rotation[rows], at) + table.translation[rows, None]
    at = np.einsum("kji,kcj->kci", around.rotation[others], at - around.translation[others, None])
    at[..., 1] *= around.mirror[others, None]
    split = inside_split(around.primitive)
    values = [value[np.repeat(others, len(_SHARES))] for value in split.rows(around.params)]
    (depth,) = split.points(values, *at.reshape(-1, 3).T)
    return np.asarray((depth.reshape(len(rows), -1) <= _FLUSH).all(axis=1))
