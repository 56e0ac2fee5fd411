"""Which material each primitive of a batch is made of, and what of a material's ranges is drawn in each object."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from ..graph.program import Material
from ..random import key, uniform

if TYPE_CHECKING:
    from ..geometry.sites import SiteTable
    from ..runtime.batch import Batch

_PLAIN = Material("plain")


def list_materials(batch: Batch) -> list[Material]:
    """Materials by index; what has none is plain: 700 kg/m3, light grey."""
    return [_PLAIN, *batch.program.materials.values()]


RANGES = {  # property: what its draw is named after; the two frictions share one, so that the static one stays larger
    "density": "density",
    "friction_static": "friction",
    "friction_dynamic": "friction",
    "restitution": "restitution",
    "metalness": "metalness",
    "roughness": "roughness",
    "transparency": "transparency",
}


def draw_property(batch: Batch, material: Material, name: str) -> np.ndarray:
    """A property (B,) of a material in each object, uniform in its range: addressed by seed, object and names alone.

    A mutant has the values of the object that it was made from.
    """
    low, high = getattr(material, name)
    if low == high:
        return np.full(len(batch), low)
    share = uniform(key(batch.seed, "material", material.name, RANGES[name]), batch.state.objects)
    return low + (high - low) * share


def material_rows(batch: Batch, table: SiteTable) -> np.ndarray:
    """(k,) for each row of a table, 1 + the index of its material in the program, the last whose predicate holds.

    0 where nothing is said.
    """
    return np.concatenate([_site_rows(batch, own) for own in table.singles()])


def _site_rows(batch: Batch, table: SiteTable) -> np.ndarray:
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
