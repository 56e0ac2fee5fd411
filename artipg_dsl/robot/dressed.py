"""Meshes in the details of real surfaces: refined until they can follow these, then moved. What collides and weighs is the structure."""

from __future__ import annotations

from dataclasses import replace
from typing import TYPE_CHECKING

import numpy as np

from ..geometry import mesh
from ..geometry.resolution import STANDARD, Resolution, measure_spans, within_budget
from ..geometry.sites import object_boxes
from ..geometry.topology import topology
from .solids import SolidGroup, build_meshes

if TYPE_CHECKING:
    from ..details.dressing import Dressing
    from ..geometry.sites import SiteTable
    from ..runtime.batch import Batch

_EDGE = 0.01  # diagonals of an object: no step of a mesh that is to follow details is longer
NOTE = "the surface in details of real objects; colliders and masses are those of the structure"

BARE = "the structure, without the details that points wear"


def build_dressed(batch: Batch, tables: list[SiteTable], resolution: Resolution, details: Dressing) -> list[SolidGroup]:
    """Meshes of all instances of all sites of a batch, closed, in details; those that wear some are refined, as far as ``triangles``
    of a resolution allows. Raises UserError where the details are not those of the objects."""
    from ..details.store import dress_meshes  # start-up: most objects wear none, and k-d trees load slowly

    dress = dress_meshes(batch, details)
    scale, worn = _diagonals(tables, len(batch)), [dress.wears(table) for table in tables]
    edge = _EDGE * scale
    if resolution.triangles is not None:
        edge = _within(tables, worn, resolution.triangles, edge)
    steps = min(resolution.steps, STANDARD.steps)  # rods of many slivers fold, and look no rounder
    edges = [np.where(wears, edge[table.owner], np.inf) for table, wears in zip(tables, worn, strict=True)]
    groups = build_meshes(tables, Resolution(steps, resolution.tolerance), edges)
    if not groups:
        return groups
    moved = dress.displaced(groups, scale)
    return [replace(group, vertices=vertices) for group, vertices in zip(groups, moved, strict=True)]


def _diagonals(tables: list[SiteTable], objects: int) -> np.ndarray:
    """(objects,) the diagonals of the boxes of the objects, metres."""
    low, high = object_boxes(tables, objects)
    size = np.where(low <= high, high - low, 1.0)
    return np.sqrt(size[:, 0] ** 2 + size[:, 1] ** 2 + size[:, 2] ** 2)


def _within(tables: list[SiteTable], worn: list[np.ndarray], triangles: int, edge: np.ndarray) -> np.ndarray:
    """(objects,) the shortest edge from ``edge`` on at which an object keeps to its triangles; instances that are not ``worn`` (k,)
    take the same at any edge."""
    parts = []
    for table, wears in zip(tables, worn, strict=True):
        for variant, rows in mesh.group_rows(table.primitive, table.params) if len(table) else ():
            found = topology(table.primitive, variant)
            least = np.repeat(np.where(found.closed, 3, 1)[None], len(rows), axis=0)
            spans = measure_spans(table.primitive, found, mesh.take(table.params, rows), least)
            parts.append((replace(spans, longest=spans.longest * wears[rows, None]), table.owner[rows]))
    return within_budget(parts, len(edge), triangles, edge)
