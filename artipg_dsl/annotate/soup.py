"""The triangles of some objects in one array, each with its place on the surface that it stands for."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from ..geometry import mesh
from ..geometry.block import Block, block_of
from ..records import dataclass
from .frames import place

if TYPE_CHECKING:
    from ..runtime.batch import Batch

_STEPS = 48  # per full turn


@dataclass(frozen=True, slots=True)
class Soup:
    """T triangles sorted by object (``start`` (objects + 1,)), at joint values 0, wound outwards.

    ``corner`` (T, 3, 3) metres; ``row`` (T,) into ``rows``, ``patch`` (T,), ``uv`` (T, 3, 2) fractions of the corners;
    ``link`` and ``part`` (T,) rows of the batch's tables.
    """

    rows: Block
    start: np.ndarray
    corner: np.ndarray
    row: np.ndarray
    patch: np.ndarray
    uv: np.ndarray
    link: np.ndarray
    part: np.ndarray


def make_soup(batch: Batch, first: int, stop: int) -> Soup:
    """The triangles of the objects ``first .. stop - 1`` of a batch."""
    tables = batch.sites()
    rows = block_of(tables, first, stop)
    rotation, translation = rows.rotation.T.reshape(-1, 3, 3), rows.translation.T
    corners, fractions = [np.empty((0, 3, 3))], [np.empty((0, 3, 2))]
    owners, patches = [np.empty(0, np.int64)], [np.empty(0, np.int64)]
    for shelf in rows.shelves:
        for made in mesh.build(shelf.primitive, shelf.params, _STEPS):
            own = shelf.start + made.rows
            vertices = place(rotation[own], translation[own], made.vertices, rows.mirror[own])
            corner, uv = vertices[:, made.faces], np.broadcast_to(made.face_uv, (len(own), *made.face_uv.shape))
            inverted = (rows.mirror[own] < 0)[:, None, None, None]  # a mirror turns triangles inside out
            corners.append(np.where(inverted, corner[:, :, ::-1], corner).reshape(-1, 3, 3))
            fractions.append(np.where(inverted, uv[:, :, ::-1], uv).reshape(-1, 3, 2))
            owners.append(np.repeat(own, len(made.faces)))
            patches.append(np.tile(made.face_patch.astype(np.int64), len(own)))
    row = np.concatenate(owners)
    order = np.argsort(rows.rank[row], kind="stable")  # by object, then by site: whatever else is in the batch
    row = row[order]
    owner = rows.owner[row]
    begins = np.zeros(len(batch.program.sites), dtype=np.int64)
    begins[[table.number for table in tables]] = np.cumsum([0, *(len(table.owner) for table in tables[:-1])])
    at = (begins[rows.site] + rows.row)[row]
    link, part = (np.concatenate([getattr(table, name) for table in tables])[at] for name in ("link", "instance"))
    return Soup(
        rows,
        np.searchsorted(owner, np.arange(stop - first + 1)),
        np.concatenate(corners)[order],
        row,
        np.concatenate(patches)[order],
        np.concatenate(fractions)[order],
        np.searchsorted(batch.links().owner, np.arange(first, stop))[owner] + link,
        np.searchsorted(batch.parts().owner, np.arange(first, stop))[owner] + part,
    )
