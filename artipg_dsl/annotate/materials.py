"""Which material each primitive of a batch is made of."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

if TYPE_CHECKING:
    from ..geometry.sites import SiteTable
    from ..runtime.batch import Batch


def material_rows(batch: Batch, table: SiteTable) -> np.ndarray:
    """(k,) for each instance of a site, 1 + the index of its material in the program, the last whose predicate holds.

    0 where nothing is said.
    """
    names = list(batch.program.materials)
    site = batch.program.sites[table.number]
    chosen = np.zeros(len(table.owner), dtype=np.int64)
    for (name, _), holds in zip(site.materials, _applies(batch, table), strict=True):
        chosen = np.where(holds, 1 + names.index(name), chosen)
    return chosen


def _applies(batch: Batch, table: SiteTable) -> list[np.ndarray]:
    """Whether each of a site's materials applies, (k,) bool each."""
    site = batch.program.sites[table.number]
    if all(predicate.op == "const" for _, predicate in site.materials):
        return [np.full(len(table.owner), bool(predicate.value)) for _, predicate in site.materials]
    return [np.asarray(v, dtype=bool) for v in batch.read([p for _, p in site.materials], site.scope)]
