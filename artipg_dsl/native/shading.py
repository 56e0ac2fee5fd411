"""Normals for pictures by compiled code: what ``robot.shading`` computes, with the same bits."""

from __future__ import annotations

import ctypes
from typing import TYPE_CHECKING

import numpy as np

from . import loops
from .calls import call

if TYPE_CHECKING:
    from .backend import Machine


def shade_faces(machine: Machine, vertices: np.ndarray, faces: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Of meshes (k, V, 3) with triangles ``faces`` (F, 3): unit normals (k, F, 3), and the cosines (k, F, 3) of their corners."""
    normal, cosine = (np.empty((len(vertices), len(faces), 3)) for _ in range(2))
    given = np.ascontiguousarray(vertices), np.ascontiguousarray(faces, dtype=np.int64)
    call(machine.library.shade_faces, *vertices.shape[:2], len(faces), *given, normal, cosine)
    return normal, cosine


def shade_vertices(
    machine: Machine,
    normal: np.ndarray,
    angle: np.ndarray,
    corner: np.ndarray,
    start: np.ndarray,
    source: np.ndarray,
    sharp: float,
) -> np.ndarray:
    """Unit normals (k, W, 3) of vertices, of whose corners v has those from ``start[v]`` to ``start[v + 1]`` in ``corner`` (3 F,), each with
    the normal (k, F, 3) of its face by its angle (k, F, 3); those of one ``source`` (W,) are added up where they differ by less than
    the angle of the cosine ``sharp``."""
    k, f = normal.shape[:2]
    w = len(source)
    out, room = np.empty((k, w, 3)), np.empty(3 * f + 6 * w)
    add, data = loops.loop(np.add, "dd->d")
    adding = ctypes.c_void_p(add), ctypes.c_void_p(data)
    meeting = np.argsort(source, kind="stable"), source, int(np.bincount(source).max())
    call(
        machine.library.shade_vertices,
        k,
        f,
        w,
        normal,
        angle,
        corner,
        start,
        *meeting,
        float(sharp),
        *adding,
        room,
        out,
    )
    return out
