"""The welding plan: which grid points of which patches are one vertex, and the faces between them, by index."""

from __future__ import annotations

import math
from functools import lru_cache

import numpy as np

from ..records import dataclass
from .errors import PrimitiveError
from .patches import surfaces
from .topology import Topology

_EIGHTH = math.pi / 4


@dataclass(frozen=True, slots=True, eq=False)
class WeldPlan:
    """``faces`` (F, 3) int32 wind outwards and index the vertices; ``face_patch`` (F,) int32 gives patch numbers;
    ``face_uv`` (F, 3, 2) the fractions of the corners on that patch.

    Per patch of ``patches`` the vertices that it represents: ``vertex`` (numbers), ``u``, ``v`` (fractions).
    """

    count: int
    faces: np.ndarray
    face_patch: np.ndarray
    face_uv: np.ndarray
    patches: tuple[int, ...]
    vertex: tuple[np.ndarray, ...]
    u: tuple[np.ndarray, ...]
    v: tuple[np.ndarray, ...]


def step_counts(topology: Topology, steps: int) -> np.ndarray:
    """(classes,): steps of each class for ``steps`` per full turn; 1 where nothing bends, at least 3 around."""
    eighths = np.ceil(topology.turn / _EIGHTH - 1e-6)
    return np.maximum(np.ceil(steps * eighths / 8 - 1e-6), np.where(topology.closed, 3, 1)).astype(np.int64)


@lru_cache(maxsize=1024)
def plan_weld(topology: Topology, steps: tuple[int, ...]) -> WeldPlan:
    """The plan for the ``steps`` of each class of directions; raises PrimitiveError when the surfaces do not close."""
    counts = np.array(steps, dtype=np.int64)[topology.step_class]
    sizes = (counts[:, 0] + 1) * (counts[:, 1] + 1)
    offsets = np.concatenate([[0], np.cumsum(sizes)])
    grids = {
        patch: np.arange(offsets[n], offsets[n + 1]).reshape(counts[n, 0] + 1, counts[n, 1] + 1)
        for n, patch in enumerate(topology.patches)
    }
    pairs = [np.empty((2, 0), dtype=np.int64)]
    for a, edge_a, b, edge_b, turned in topology.matches:
        first, second = _edge(grids[a], edge_a), _edge(grids[b], edge_b)
        pairs.append(np.stack([first, second[::-1] if turned else second]))
    for patch, edge in topology.collapsed:
        line = _edge(grids[patch], edge)
        pairs.append(np.stack([line[1:], line[:-1]]))
    label = _components(int(offsets[-1]), np.concatenate(pairs, axis=1))
    representatives, number = np.unique(label, return_inverse=True)
    vertex, us, vs, faces, owners, fractions = [], [], [], [], [], []
    for n, patch in enumerate(topology.patches):
        nodes = grids[patch]
        own = representatives[(representatives >= offsets[n]) & (representatives < offsets[n + 1])]
        i, j = np.divmod(own - offsets[n], nodes.shape[1])
        vertex.append(number[own])
        us.append(i / counts[n, 0])
        vs.append(j / counts[n, 1])
        corners = _triangles(nodes, topology.orientation[n])
        triangles = number[corners]
        kept = _three_corners(triangles)
        triangles = triangles[kept]
        faces.append(triangles)
        i, j = np.divmod(corners[kept] - offsets[n], nodes.shape[1])
        fractions.append(np.stack([i / counts[n, 0], j / counts[n, 1]], axis=-1))
        owners.append(np.full(len(triangles), patch))
    every, owner = np.concatenate(faces), np.concatenate(owners)
    _check_closed(topology, every, owner)
    return WeldPlan(
        len(representatives),
        every.astype(np.int32),
        owner.astype(np.int32),
        np.concatenate(fractions),
        topology.patches,
        tuple(vertex),
        tuple(us),
        tuple(vs),
    )


def _edge(nodes: np.ndarray, edge: int) -> np.ndarray:
    return (nodes[0], nodes[-1], nodes[:, 0], nodes[:, -1])[edge]


def _components(count: int, pairs: np.ndarray) -> np.ndarray:
    """(count,): the smallest node that each node is connected with."""
    label = np.arange(count)
    while True:
        low = np.minimum(label[pairs[0]], label[pairs[1]])
        new = label.copy()
        np.minimum.at(new, pairs[0], low)
        np.minimum.at(new, pairs[1], low)
        new = new[new]
        if np.array_equal(new, label):
            return label
        label = new


def _triangles(nodes: np.ndarray, orientation: int) -> np.ndarray:
    a, b, c, d = (q.ravel() for q in (nodes[:-1, :-1], nodes[1:, :-1], nodes[1:, 1:], nodes[:-1, 1:]))
    if orientation < 0:
        b, d = d, b
    return np.stack([np.stack([a, b, c], axis=-1), np.stack([a, c, d], axis=-1)], axis=1).reshape(-1, 3)


def _three_corners(triangles: np.ndarray) -> np.ndarray:
    """Which triangles are any: a quad with a collapsed side keeps the one that is left, whichever diagonal cuts it."""
    p, q, r = triangles.T
    return (p != q) & (q != r) & (r != p)


def _check_closed(topology: Topology, faces: np.ndarray, owner: np.ndarray) -> None:
    """Every directed edge occurs once and its opposite too."""
    if not len(faces):
        raise PrimitiveError(
            topology.primitive, None, "it has no face: each of its surfaces collapses to a line or a point"
        )
    start, end = faces.ravel(), np.roll(faces, -1, axis=1).ravel()
    count = int(faces.max()) + 1
    forward, back = start * count + end, end * count + start
    unique, which, times = np.unique(forward, return_inverse=True, return_counts=True)
    at = np.minimum(np.searchsorted(unique, back), len(unique) - 1)
    bad = (times[which] > 1) | (unique[at] != back)
    if bad.any():
        names = sorted({surfaces(topology.primitive)[p].name for p in owner[np.flatnonzero(bad) // 3]})
        message = f"surfaces {', '.join(names)} disagree about which side is outside along their common edges"
        raise PrimitiveError(topology.primitive, names[0], message)
