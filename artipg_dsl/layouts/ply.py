"""Meshes in the binary form of PLY."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

import numpy as np

from ..errors import UserError
from ..robot.primitives import Shape

_FACE = np.dtype([("count", "u1"), ("corners", "<i4", 3)])
_HEAD = (
    "ply\nformat binary_little_endian 1.0\nelement vertex {vertices}\nproperty float x\nproperty float y\nproperty float z\n"
    "element face {faces}\nproperty list uchar int vertex_indices\nend_header\n"
)


def ply_bytes(shapes: Sequence[Shape]) -> bytes:
    """Several meshes as one."""
    starts = np.cumsum([0, *(len(shape.vertices) for shape in shapes)])
    corners = [np.asarray(shape.faces) + start for shape, start in zip(shapes, starts, strict=False)]
    faces = np.zeros(sum(map(len, corners)), dtype=_FACE)
    faces["count"], faces["corners"] = 3, np.concatenate([np.zeros((0, 3), np.int64), *corners])
    vertices = np.concatenate([np.zeros((0, 3)), *(shape.vertices for shape in shapes)]).astype("<f4")
    return _HEAD.format(vertices=len(vertices), faces=len(faces)).encode() + vertices.tobytes() + faces.tobytes()


def read_ply(path: Path) -> np.ndarray:
    """The vertices (n, 3) of a file that ``ply_bytes`` has made. Raises UserError."""
    head, mark, body = path.read_bytes().partition(b"end_header\n")
    counts = [
        int(line.rsplit(" ", 1)[1])
        for line in head.decode("ascii", "replace").splitlines()
        if line.startswith("element")
    ]
    if not mark or len(counts) != 2 or len(body) != 12 * counts[0] + _FACE.itemsize * counts[1]:
        raise UserError(f"{path} is not a binary PLY file of triangles", "write the folder again with --force")
    return np.frombuffer(body, "<f4", 3 * counts[0]).reshape(-1, 3)
