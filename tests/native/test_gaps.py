"""How far hulls reach from their pieces, and what is put together: compiled code says what NumPy says, to the last bit."""

import numpy as np
import pytest
from scipy.spatial import ConvexHull

from artipg_dsl.geometry import merge
from artipg_dsl.geometry.stock import Stock
from artipg_dsl.native import gaps
from artipg_dsl.robot.hulls import Gathered
from artipg_dsl.robot.robots import Robots
from artipg_dsl.session import Session

from .machine import needs_compiler


def pieces(count, near, plain):
    """Convex pieces side by side, ``plain``: boxes that are alike, so that much ties."""
    lots = np.random.Generator(np.random.PCG64(6))
    cube = np.array([[x, y, z] for x in (-0.5, 0.5) for y in (-0.5, 0.5) for z in (-0.5, 0.5)])
    points, normals, offsets = [], [], []
    for k in range(count):
        corners = (cube if plain else lots.normal(size=(12, 3))) + near * np.array([k % 4, k // 4, 0.0])
        hull = ConvexHull(corners)
        points.append(corners[hull.vertices])
        normals.append(hull.equations[:, :3])
        offsets.append(-hull.equations[:, 3])
    starts = (np.cumsum([0, *map(len, columns)]) for columns in (points, offsets))
    point_start, face_start = starts
    none, columns = np.zeros(count, dtype=np.int64), map(np.concatenate, (points, normals, offsets))
    corners, normal, offset = columns
    triangles = np.zeros((len(offset), 3), dtype=np.int64)
    return Stock(corners, point_start, triangles, normal, offset, face_start, none, none, np.arange(count))


@needs_compiler
def test_gaps_of_clusters(machine):
    for near in (0.5, 1.0, 1.5, 3.0):
        for plain in (False, True):
            held, every = pieces(70, near, plain), np.arange(70)
            for some in (every[:2], every[3:9], every[::7], every):
                assert gaps.deepest(machine, held.places, some, merge._TURNED) == merge._deepest(held, some)


@needs_compiler
def test_pieces_that_are_no_numbers_have_no_extreme_points(machine):
    held, every = pieces(5, 1.0, True), np.arange(5)
    held.points[:] = np.nan
    ends = np.arange(6)
    made = gaps.chain(machine, held.places, every, ends[:-1], ends[1:], merge._TURNED, 0.01)
    assert made.tolist() == [0] * 5, "nothing reaches from them"


@pytest.mark.some
@needs_compiler
@pytest.mark.parametrize("name, objects", [("Keyboard", 3), ("Kettle", 1), ("Foldingrack", 3)])
def test_what_is_put_together(name, objects, using):
    robots = Robots(Session.of(name).sampler.batch(np.arange(objects), 5))
    gathered = Gathered(robots.pieces, objects, robots.material_rows)
    found = {}
    for backend in ("numpy", "c"):
        using(backend)
        found[backend] = []
        for first, last in zip(gathered.first[:-1], gathered.first[1:], strict=True):
            own = np.arange(first, last)
            for tolerance in (1e-9, 0.002, 0.01, 0.05):
                cluster = merge.cluster_units(gathered.stock, own, tolerance)
                start = merge.gather_clusters(gathered.stock, own, np.arange(0, len(own), 2), tolerance)
                found[backend].append((cluster.tolist(), start.tolist()))
        gathered.stock.known.clear()
    assert found["numpy"] == found["c"]
    assert len({(len(set(cluster)), len(start)) for cluster, start in found["c"]}) > 3


def test_what_was_asked_is_kept(using):
    using("numpy")
    held, every = pieces(4, 1.5, False), np.arange(4)
    assert merge.gap(held, every) == merge._deepest(held, every)[0] and list(held.known) == [every.tobytes()]
