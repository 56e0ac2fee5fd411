"""Normals for pictures: compiled code gives the bits of NumPy."""

import numpy as np
import pytest

from artipg_dsl.robot import shading
from artipg_dsl.robot.solids import build_meshes
from artipg_dsl.session import Session

from .machine import bits, needs_compiler

pytestmark = needs_compiler


def both(using, *given):
    found = []
    for backend in ("numpy", "c"):
        using(backend)
        found.append(shading.shade(*given))
    plain, compiled = found
    for name in ("source", "faces", "normals"):
        one, other = getattr(plain, name), getattr(compiled, name)
        assert one.dtype == other.dtype and bits(one) == bits(other), name
    return plain.normals


@pytest.mark.some
@pytest.mark.parametrize("category", ["Kettle", "Microwave", "Bottle"])
def test_the_same_normals_of_objects(using, category):
    groups = build_meshes(Session.of(category).sampler.batch(np.arange(3), 5).sites())
    assert max(group.vertices.shape[1] for group in groups) > 100
    for group in groups:
        normals = both(using, group.vertices, group.faces, group.face_patch)
        assert np.allclose(np.linalg.norm(normals, axis=-1), 1.0)


def test_faces_without_area_and_many_at_a_corner(using):
    """Fans of 3 to 100 triangles, whose normals NumPy adds up in an order of its own; one is flat, and one point is a line."""
    for count in (3, 8, 9, 30, 100):
        turn = 2 * np.pi * np.arange(count) / count
        rim = np.stack([np.cos(turn), np.sin(turn), 0.3 * np.sin(5 * turn)], axis=1)
        fan = np.concatenate([[[0.1, 0.2, 1.0]], rim, rim[:1]])
        faces = np.stack([np.zeros(count, dtype=np.int64), 1 + np.arange(count), 2 + np.arange(count)], axis=1)
        patch = np.arange(count) // max(count // 3, 1)
        meshes = np.stack([fan, fan * (1, 1, 0), fan * 0, -fan])
        both(using, meshes, faces.astype(np.int32), patch)
