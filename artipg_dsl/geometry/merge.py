"""Fewer convex pieces: the hulls of neighbours in place of the pieces, where hardly more than the pieces fill them.

How much a hull adds is told by how far points of it lie from the nearest piece: points half way between corners that
reach far in some direction. So the walls of a vessel become staves of few sides, while a hole stays a hole. Pieces know
where they stand: which primitive they belong to, which step around or along it (``index``), which of its names.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import lru_cache
from typing import Any

import numpy as np

SECTORS = (1, 2, 3, 4, 5, 6, 8, 10, 12, 16, 20, 24, 32, 40, 48, 60)
_WAYS = np.array(
    [(x, y, z) for x in (-1, 0, 1) for y in (-1, 0, 1) for z in (-1, 0, 1) if (x, y, z) != (0, 0, 0)], float
)
_SKEW = np.array([0.011, 0.007, 0.003])  # so that no two corners of a box tie


@dataclass(frozen=True, slots=True, eq=False)
class Convex:
    """A convex piece: corners (P, 3), planes of its faces (outward normals (F, 3), offsets (F,)).

    ``unit`` numbers its primitive within the body, ``name`` the piece within the primitive, ``index`` the step.
    ``source`` is what a caller knows it by.
    """

    points: np.ndarray
    normals: np.ndarray
    offsets: np.ndarray
    unit: int
    name: int
    index: int
    source: Any = None


Cluster = tuple[Convex, ...]


def gap(pieces: Sequence[Convex]) -> float:
    """How far the hull of pieces reaches from them, at the points looked at; metres."""
    return 0.0 if len(pieces) == 1 else _gap(tuple(pieces))


@lru_cache(maxsize=1024)  # several tolerances ask for the same
def _gap(pieces: Cluster) -> float:
    points = _extreme(np.concatenate([piece.points for piece in pieces]))
    i, j = _pairs(len(points))
    x, y, z = ((points[i] + points[j]) / 2).T
    normals = np.concatenate([piece.normals for piece in pieces])
    offsets = np.concatenate([piece.offsets for piece in pieces])
    away = normals[:, 0, None] * x + normals[:, 1, None] * y + normals[:, 2, None] * z - offsets[:, None]
    start = np.cumsum([0, *(len(piece.offsets) for piece in pieces[:-1])])
    return float(np.maximum.reduceat(away, start, axis=0).min(axis=0).max())


@lru_cache(maxsize=64)
def _pairs(count: int) -> tuple[np.ndarray, np.ndarray]:
    """All pairs of numbers below ``count``."""
    first, second = np.triu_indices(count, 1)
    return first, second


def _extreme(points: np.ndarray) -> np.ndarray:
    """The points (n, 3) that reach farthest in some direction, by the extents of all of them."""
    low = points.min(axis=0)
    scaled = (points - low) / np.maximum(points.max(axis=0) - low, 1e-12)
    ways = _WAYS + _SKEW
    reach = scaled[:, 0, None] * ways[:, 0] + scaled[:, 1, None] * ways[:, 1] + scaled[:, 2, None] * ways[:, 2]
    return points[np.unique(np.argmax(reach, axis=0))]


def clusters(pieces: Sequence[Convex], tolerance: float) -> list[Cluster]:
    """The pieces of one primitive, in order of name and index, put together where hulls add less than ``tolerance``."""
    names: dict[int, list[Convex]] = {}
    for piece in pieces:
        names.setdefault(piece.name, []).append(piece)
    found: list[Cluster] = []
    runs: list[list[list[Convex]]] = []
    for steps in names.values():  # names of one step and names of several do not mix
        if runs and (len(runs[-1][0]) > 1) == (len(steps) > 1):
            runs[-1].append(steps)
        else:
            runs.append([steps])
    for run in runs:
        found += _chained([tuple(steps) for steps in run], tolerance) if len(run[0]) == 1 else _grid(run, tolerance)
    return found


def _grid(run: list[list[Convex]], tolerance: float) -> list[Cluster]:
    """Names with several steps each: as few sectors of steps as do, then names in a row put together in all sectors alike."""
    most = max(len(steps) for steps in run)
    for count in (*(c for c in SECTORS if c < most), most):
        sectors = [_sectors(steps, count) for steps in run]
        looked_at = range(count) if len(run) == 1 else (0, count // 4)  # steps around an axis are alike
        if count == most or all(gap(parts[k]) <= tolerance for parts in sectors for k in looked_at if parts[k]):
            break
    if len(run) == 1:
        return [part for part in sectors[0] if part]
    first = _chained([parts[0] for parts in sectors], tolerance)
    lengths, at, found = [], 0, []
    for merged in first:
        stop = at
        while at < len(run) and {p.name for p in sectors[at][0]} <= {p.name for p in merged}:
            at += 1
        lengths.append((stop, at))
    for k in range(count):
        found += [sum((parts[k] for parts in sectors[a:b]), ()) for a, b in lengths]
    return [cluster for cluster in found if cluster]


def _sectors(steps: list[Convex], count: int) -> list[Cluster]:
    edges = [-(-len(steps) * k // count) for k in range(count + 1)]
    return [tuple(steps[a:b]) for a, b in zip(edges, edges[1:], strict=False)]


def _chained(parts: list[Cluster], tolerance: float) -> list[Cluster]:
    """Clusters one after the other, put together as long as the hull of all adds less than ``tolerance``."""
    found: list[Cluster] = []
    for part in parts:
        if found and gap(found[-1] + part) <= tolerance:
            found[-1] = found[-1] + part
        else:
            found.append(part)
    return found


def gathered(parts: list[Cluster], tolerance: float) -> list[Cluster]:
    """Clusters of several primitives in a row, such as the keys of a keyboard: rows first, then rows of rows."""
    while True:
        fewer = _chained(parts, tolerance)
        if len(fewer) == len(parts):
            return parts
        parts = fewer


def halves(cluster: Cluster) -> tuple[Cluster, Cluster]:
    """A cluster of several pieces in two: of primitives, else of steps, else of names."""
    for key in ("unit", "index", "name"):
        values = sorted({getattr(piece, key) for piece in cluster})
        if len(values) > 1:
            middle = values[len(values) // 2]
            return (
                tuple(p for p in cluster if getattr(p, key) < middle),
                tuple(p for p in cluster if getattr(p, key) >= middle),
            )
    raise ValueError("a single piece")
