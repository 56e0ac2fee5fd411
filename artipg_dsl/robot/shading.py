"""Normals for pictures: smooth over a curved patch and across tangent patches, sharp at edges."""

from __future__ import annotations

import numpy as np

from ..geometry.vectors import cross, dot
from ..native import backend
from ..native import shading as native
from ..records import dataclass

_SHARP = float(np.cos(np.radians(35.0)))  # patches that meet at a smaller angle than this look like one smooth surface


@dataclass(frozen=True, slots=True)
class Shading:
    """``source`` (W,) the welded vertex of each split one; ``faces`` (F, 3) of split ones; ``normals`` (k, W, 3)."""

    source: np.ndarray
    faces: np.ndarray
    normals: np.ndarray


def shade(vertices: np.ndarray, faces: np.ndarray, face_patch: np.ndarray) -> Shading:
    """Split the vertices of k meshes of one topology, (k, V, 3), at patch borders, and give them unit normals."""
    n_vertices = vertices.shape[1]
    corner = (face_patch.astype(np.int64)[:, None] * n_vertices + faces).ravel()
    keys, split = np.unique(corner, return_inverse=True)
    source = keys % n_vertices
    split = split.ravel()

    order = np.argsort(split, kind="stable")
    starts = np.searchsorted(split[order], np.arange(len(keys) + 1))
    machine = backend.machine()
    normal, cosine = _of_faces(vertices, faces) if machine is None else native.shade_faces(machine, vertices, faces)
    angle = np.arccos(cosine)  # the corner's angle: fans and quads weigh the same
    if machine is not None:
        normals = native.shade_vertices(machine, normal, angle, order, starts, source, _SHARP)
    else:
        weighted = (normal[:, :, None] * angle[..., None]).reshape(len(vertices), -1, 3)
        normals = _blend(np.add.reduceat(weighted[:, order], starts[:-1], axis=1), source)
    return Shading(source, split.reshape(faces.shape).astype(np.int32), normals)


def _of_faces(vertices: np.ndarray, faces: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Unit normals (k, F, 3) and the cosines (k, F, 3) of corners."""
    corners = vertices[:, faces]  # (k, F, 3, 3)
    edges = np.roll(corners, -1, axis=2) - corners
    normal = cross(edges[:, :, 0], edges[:, :, 1])  # twice the area times the unit normal
    length = np.sqrt(dot(edges, edges))
    before = np.roll(length, 1, axis=2)
    cosine = -dot(edges, np.roll(edges, 1, axis=2)) / np.where(length * before > 0, length * before, 1.0)
    return _unit(normal), np.clip(cosine, -1.0, 1.0)


def _blend(summed: np.ndarray, source: np.ndarray) -> np.ndarray:
    """Add up the normals (k, W, 3) of split vertices of one source where they differ by less than the sharp angle."""
    own = _unit(summed)
    order = np.argsort(source, kind="stable")
    ranked = source[order]
    result = summed.copy()
    for shift in range(1, int(np.bincount(source).max())):  # the other patches that meet at a vertex, a handful
        pairs = np.flatnonzero(ranked[shift:] == ranked[:-shift])
        a, b = order[pairs], order[pairs + shift]
        near = (dot(own[:, a], own[:, b]) > _SHARP)[..., None]
        result[:, a] += np.where(near, summed[:, b], 0.0)
        result[:, b] += np.where(near, summed[:, a], 0.0)
    return _unit(result)


def _unit(vectors: np.ndarray) -> np.ndarray:
    """Vectors of length 1; where there is no direction, up."""
    length = np.sqrt(dot(vectors, vectors))[..., None]
    return np.where(length > 0, vectors / np.where(length > 0, length, 1.0), np.array([0.0, 0.0, 1.0]))
