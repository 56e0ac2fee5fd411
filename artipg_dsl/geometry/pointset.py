"""Points bound to surfaces, and the pools of rows that they are drawn from."""

from __future__ import annotations

import numpy as np

from ..records import dataclass
from .sites import SiteTable


@dataclass(frozen=True, slots=True, eq=False)
class PointSet:
    """n points for each of B objects; metres, in the frames of the objects.

    The binding is (``site`` number, ``row`` of that site's table, ``patch`` number, fractions ``u``, ``v``).
    """

    site: np.ndarray  # (B, n) int32
    row: np.ndarray  # (B, n) int32
    patch: np.ndarray  # (B, n) int16
    u: np.ndarray  # (B, n)
    v: np.ndarray  # (B, n)
    position: np.ndarray  # (B, n, 3)
    normal: np.ndarray  # (B, n, 3)

    @staticmethod
    def empty(rows: int, n: int) -> PointSet:
        """Room for ``n`` points of each of ``rows``, all zeros."""
        shape = rows, n
        return PointSet(
            np.zeros(shape, np.int32),
            np.zeros(shape, np.int32),
            np.zeros(shape, np.int16),
            np.zeros(shape),
            np.zeros(shape),
            np.zeros((*shape, 3)),
            np.zeros((*shape, 3)),
        )

    def take(self, at: np.ndarray | tuple[np.ndarray, np.ndarray]) -> PointSet:
        """Those of some rows, or at some rows and columns."""
        if not isinstance(at, tuple):
            return PointSet(*(getattr(self, name)[at] for name in PointSet.__slots__))
        place = at[0] * self.u.shape[1] + at[1]
        taken = PointSet(*(_rows_at(getattr(self, name), place.ravel()) for name in PointSet.__slots__))
        return taken.shaped(*place.shape)

    def shaped(self, *shape: int) -> PointSet:
        """The same points in rows of another length."""
        arrays = (getattr(self, name) for name in PointSet.__slots__)
        normals = ("position", "normal")
        return PointSet(
            *(
                a.reshape(*shape, 3) if n in normals else a.reshape(shape)
                for n, a in zip(PointSet.__slots__, arrays, strict=True)
            )
        )


def _rows_at(array: np.ndarray, flat: np.ndarray) -> np.ndarray:
    return np.take(array.reshape(-1, *array.shape[2:]), flat, axis=0)


@dataclass(frozen=True, slots=True, eq=False)
class Pools:
    """P pools, sorted: of objects ``owner`` (P,), with ``label`` (P,). ``rows``: for each site table, of which pool
    its rows are (k,)."""

    owner: np.ndarray
    label: np.ndarray
    rows: list[np.ndarray]

    @staticmethod
    def of(sites: list[SiteTable], labels: list[np.ndarray], n_objects: int) -> Pools:
        """Of the rows that bear the same label in one object. Without labels but 0, each object is one, rows or no."""
        if not any(label.any() for label in labels):
            every = np.arange(n_objects)
            return Pools(every, np.zeros_like(every), [site.owner for site in sites])
        pairs = np.concatenate([np.stack([s.owner, label]) for s, label in zip(sites, labels, strict=True)], axis=1)
        found, which = np.unique(pairs, axis=1, return_inverse=True)
        ends = np.cumsum([len(site) for site in sites])[:-1]
        return Pools(found[0], found[1], np.split(which.reshape(-1), ends))
