"""Elements of repeats that stand in the same place and are alike, in every object that has several: what can be asked of a few
objects at once, for `check`."""

from __future__ import annotations

import numpy as np

from ..geometry.runs import distinct
from ..geometry.sites import SiteTable
from ..runtime.batch import Batch

_STEP = 1e-6  # metres: places are compared in such steps
_LIKE = 1e-6  # of the inertia: solids that differ by less are alike


def find_twins(batch: Batch) -> list[str]:
    """The paths of primitives of which, in each object that has several, at least two fill the same space."""
    return [table.path for table in batch.sites() if _has_twins(table)]


def _has_twins(table: SiteTable) -> bool:
    several = np.bincount(table.owner) > 1
    if not several.any():
        return False
    low, high = table.boxes()
    key = np.column_stack([table.owner, np.round((low + high) / (2 * _STEP))])
    order = np.lexsort(key.T[::-1])
    next_to = (key[order][1:] == key[order][:-1]).all(axis=1)
    met = np.bincount(table.owner[order][1:][next_to], minlength=len(several)) > 0
    if not met[several].all():
        return False  # most are told apart by their places alone
    first, second = order[:-1][next_to], order[1:][next_to]
    asked = distinct(np.concatenate([first, second]))
    inertia = _inertia(table.take(asked))
    one, other = (inertia[np.searchsorted(asked, rows)] for rows in (first, second))
    alike = np.abs(one - other).max(axis=(1, 2)) <= _LIKE * np.abs(one).max(axis=(1, 2))
    twins = np.bincount(table.owner[first[alike]], minlength=len(several)) > 0
    return bool(twins[several].all())


def _inertia(table: SiteTable) -> np.ndarray:
    """The inertia (k, 3, 3) of the rows about their centres, along the axes of the object: it does not tell how a round solid
    is turned about its own axis."""
    turn = table.rotation.copy()
    turn[:, :, 1] *= table.mirror[:, None]
    return turn @ table.moments[2] @ turn.transpose(0, 2, 1)
