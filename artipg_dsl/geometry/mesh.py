"""Watertight triangle meshes of many instances at once, with volume and inertia.

The combinatorics are those of the welding plan, found when the primitive is compiled; only coordinates are computed
here. Lengths in metres, in the primitive's own frame, unmirrored.
"""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from ..graph.primitive import Primitive
from ..records import dataclass
from .patches import find_existing, position_split
from .resolution import measure_bends, measure_spans
from .split import Params, rows_of
from .topology import Topology, topology
from .vectors import extent
from .weld import WeldPlan, plan_weld, step_counts

_TRIANGLES = 100_000  # summed at a time, so that the terms stay in the caches


@dataclass(frozen=True, slots=True, eq=False)
class MeshGroup:
    """Meshes of one make: instances ``rows`` (k',), ``vertices`` (k', V, 3); ``faces`` (F, 3), ``face_patch`` (F,).

    ``face_uv`` (F, 3, 2): the fractions of the corners of each face on its patch.
    """

    rows: np.ndarray
    vertices: np.ndarray
    faces: np.ndarray
    face_patch: np.ndarray
    face_uv: np.ndarray


def take(params: Params, rows: np.ndarray) -> Params:
    """The parameters of some instances."""
    return {name: value[rows] for name, value in params.items()}


def group_rows(primitive: Primitive, params: Params) -> list[tuple[tuple[bool, ...], np.ndarray]]:
    """Instances that have the same patches: (which patches, rows), in a fixed order."""
    there = find_existing(primitive, params)
    if len(there) and (there == there[0]).all():
        return [(tuple(there[0].tolist()), np.arange(len(there)))]
    makes, which = np.unique(there, axis=0, return_inverse=True)
    which = which.reshape(-1)
    return [(tuple(make.tolist()), np.flatnonzero(which == n)) for n, make in enumerate(makes)]


def build(
    primitive: Primitive, params: Params, steps: int | np.ndarray = 24, edge: np.ndarray | None = None
) -> list[MeshGroup]:
    """Meshes of ``k`` instances, grouped by which patches exist and how many steps they take.

    ``steps``: segments per full turn, or how far chords may lie off the surface, metres (k,). ``edge`` (k,): the longest step along
    u or v, metres, where that is bounded. Faces wind outwards. Raises PrimitiveError when the declaration of the primitive does not
    close.
    """
    groups = []
    for found, rows, counts in _stepped(primitive, params, steps, edge):
        welded = plan_weld(found, counts)
        vertices = _vertices(primitive, welded, take(params, rows))
        groups.append(MeshGroup(rows, vertices, welded.faces, welded.face_patch, welded.face_uv))
    return groups


def _stepped(
    primitive: Primitive, params: Params, steps: int | np.ndarray, edge: np.ndarray | None = None
) -> Iterator[tuple[Topology, np.ndarray, tuple[int, ...]]]:
    """Instances of one topology and the same steps: (topology, rows, steps of its classes), in a fixed order."""
    for variant, rows in group_rows(primitive, params):
        found = topology(primitive, variant)
        if isinstance(steps, np.ndarray):
            counts = measure_bends(primitive, found, take(params, rows)).steps(steps[rows])
        elif edge is not None:
            counts = np.repeat(step_counts(found, steps)[None], len(rows), axis=0)
        else:
            yield found, rows, tuple(step_counts(found, steps).tolist())
            continue
        if edge is not None:
            counts = measure_spans(primitive, found, take(params, rows), counts).steps(edge[rows])
        makes, which = np.unique(counts, axis=0, return_inverse=True)
        which = which.reshape(-1)
        for n, make in enumerate(makes.tolist()):
            yield found, rows[which == n], tuple(make)


def _vertices(primitive: Primitive, welded: WeldPlan, params: Params) -> np.ndarray:
    out = np.empty((3, rows_of(params), welded.count))
    for patch, vertex, u, v in zip(welded.patches, welded.vertex, welded.u, welded.v, strict=True):
        if len(vertex) == 0:
            continue
        split = position_split(primitive, patch)
        values = split.points([r[:, None] for r in split.rows(params)], u[None], v[None])
        for axis, value in enumerate(values):
            out[axis][:, vertex] = value
    return np.moveaxis(out, 0, -1)


def moments(vertices: np.ndarray, faces: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Volume (k,), centre of mass (k, 3) and inertia about it for unit density (k, 3, 3) of closed meshes (k, V, 3).

    Sums over signed tetrahedra with the apex in the centre of the box, in an order that the batch does not change.
    """
    low, high = extent(vertices)
    middle = (low + high) / 2
    a, b, c = (
        [vertices[:, faces[:, corner], axis] - middle[:, axis, None] for axis in range(3)] for corner in range(3)
    )
    six = a[0] * (b[1] * c[2] - b[2] * c[1]) + a[1] * (b[2] * c[0] - b[0] * c[2]) + a[2] * (b[0] * c[1] - b[1] * c[0])
    volume = _total(six) / 6
    centre = np.stack([_total(six * (a[i] + b[i] + c[i])) / 24 / volume for i in range(3)], axis=-1)
    second = np.empty((len(vertices), 3, 3))
    for i in range(3):
        for j in range(i, 3):
            total = a[i] * a[j] + b[i] * b[j] + c[i] * c[j] + (a[i] + b[i] + c[i]) * (a[j] + b[j] + c[j])
            second[:, i, j] = second[:, j, i] = _total(six * total) / 120 - volume * centre[:, i] * centre[:, j]
    inertia = -second
    for i in range(3):
        inertia[:, i, i] = second[:, (i + 1) % 3, (i + 1) % 3] + second[:, (i + 2) % 3, (i + 2) % 3]
    return volume, centre + middle, inertia


def _total(values: np.ndarray) -> np.ndarray:
    """Row sums (k,) of (k, F); contiguous rows, so that the order of summation depends on F alone."""
    return np.add.reduce(np.ascontiguousarray(values), axis=1)


def volume_inertia(primitive: Primitive, params: Params, steps: int = 24) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Volume (k,) m3, centre (k, 3) m, inertia about the centre per unit density (k, 3, 3) m5 of the meshes."""
    count = rows_of(params)
    volume, centre, inertia = np.empty(count), np.empty((count, 3)), np.empty((count, 3, 3))
    for found, rows, counts in _stepped(primitive, params, steps):
        welded = plan_weld(found, counts)
        at_once = max(1, _TRIANGLES // len(welded.faces))
        for start in range(0, len(rows), at_once):
            part = rows[start : start + at_once]
            vertices = _vertices(primitive, welded, take(params, part))
            volume[part], centre[part], inertia[part] = moments(vertices, welded.faces)
    return volume, centre, inertia
