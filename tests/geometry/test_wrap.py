"""Convex hulls of many sets of points: closed, outwards, of the corners alone, and the same whoever is in the batch."""

import numpy as np
import pytest
from scipy.spatial import ConvexHull

from artipg_dsl.geometry.wrap import wrap_all

BOX = np.array([(x, y, z) for x in (0.0, 3.0) for y in (0.0, 2.0) for z in (0.0, 1.0)])


def stave(count: int, begin: float = 0.3) -> np.ndarray:
    """A part of a wall: rings of corners that neighbours share, some of which coincide but for rounding."""
    found = []
    for k in range(count):
        turn = begin + 0.1 * np.array([k, k + 1])
        for height in (0.0, 0.5, 0.8, 1.0):
            for radius in (0.9, 1.0):
                found += [(radius * np.cos(a) * (1 + 1e-16 * k), radius * np.sin(a), height) for a in turn]
    return np.array(found)


def sets() -> list[np.ndarray]:
    lots = np.random.Generator(np.random.PCG64(5))
    clouds = [lots.normal(size=(n, 3)) * (1, 0.01, 30) + 7 for n in (4, 9, 60, 300)]
    middles = (BOX[:, None] + BOX).reshape(-1, 3) / 2  # on its edges and faces, and within
    return [*clouds, np.concatenate([BOX, middles]), *(stave(n) for n in (1, 3, 12))]


@pytest.mark.parametrize("points", sets())
def test_a_hull_holds_its_points_and_is_closed(points: np.ndarray) -> None:
    ((used, faces),) = wrap_all([points])
    corners = points[used]
    extent = np.ptp(points, axis=0)
    a, b, c = (corners[faces[:, n]] / extent for n in range(3))
    normal = np.cross(b - a, c - a)
    normal /= np.linalg.norm(normal, axis=1)[:, None]
    assert (normal @ (points / extent).T - np.sum(normal * a, axis=1)[:, None]).max() < 1e-5
    edges = {(i, j) for face in faces.tolist() for i, j in zip(face, face[1:] + face[:1], strict=True)}
    assert len(edges) == 3 * len(faces) == 3 * (2 * len(used) - 4) and {(j, i) for i, j in edges} == edges
    assert ConvexHull(corners).volume == pytest.approx(ConvexHull(points).volume, rel=1e-5)


def test_what_lies_on_edges_and_faces_or_twice_in_one_place_is_no_corner() -> None:
    ((used, faces),) = wrap_all([np.concatenate([BOX, (BOX[:, None] + BOX).reshape(-1, 3) / 2, BOX * (1 + 1e-15)])])
    assert used.tolist() == list(range(8)) and len(faces) == 12
    ((used, _),) = wrap_all([stave(3)])
    assert len(used) == 12  # at either end four without and two within


def test_a_set_has_one_hull_in_any_batch() -> None:
    every = sets()
    for k, (used, faces) in enumerate(wrap_all(every)):
        ((own, alone),) = wrap_all([every[k]])
        assert own.tolist() == used.tolist() and alone.tolist() == faces.tolist()
    assert wrap_all([]) == []


def test_where_there_is_doubt_the_points_are_looked_at_as_they_are() -> None:
    """Corners nearer than a hundred-thousandth: what is moved says nothing of them."""
    turn = 2 * np.pi * np.arange(60) / 60
    needle = np.concatenate(
        [np.stack([2e-5 * np.cos(turn), 2e-5 * np.sin(turn), np.full(60, z)], axis=1) for z in (0.0, 1.0)]
        + [np.array([[1.0, 0.0, 0.5], [0.0, 1.0, 0.5]])]
    )
    ((used, faces),) = wrap_all([needle])
    assert len(faces) == 2 * len(used) - 4
    assert ConvexHull(needle[used]).volume == pytest.approx(ConvexHull(needle).volume, rel=1e-6)
