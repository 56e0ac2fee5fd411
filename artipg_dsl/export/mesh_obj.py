"""Wavefront OBJ text: one object per primitive, 9 significant digits, metres, z up."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np


@dataclass(frozen=True, slots=True)
class Shape:
    """A closed triangle mesh: ``vertices`` (V, 3) metres, ``faces`` (F, 3) turning outwards."""

    name: str
    vertices: np.ndarray
    faces: np.ndarray


def obj_text(shapes: Sequence[Shape]) -> str:
    """The shapes one after the other, each as an ``o`` of its own (each closed by itself, none shares a vertex)."""
    parts: list[str] = []
    first = 1  # OBJ counts vertices of the whole file from 1
    for shape in shapes:
        vertices = np.asarray(shape.vertices, dtype=np.float64) + 0.0  # + 0.0: no "-0"
        indices = np.asarray(shape.faces, dtype=np.int64) + first
        parts.append(f"o {shape.name}\n")
        parts.append("v %.9g %.9g %.9g\n" * len(vertices) % tuple(vertices.ravel().tolist()))
        parts.append("f %d %d %d\n" * len(indices) % tuple(indices.ravel().tolist()))
        first += len(vertices)
    return "".join(parts)


def obj_bytes(shapes: Sequence[Shape]) -> bytes:
    return obj_text(shapes).encode("utf-8")
