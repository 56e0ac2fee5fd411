"""How far hulls reach from their pieces: compiled code says what NumPy says, to the last bit."""

import numpy as np
from scipy.spatial import ConvexHull

from artipg_dsl.geometry import merge
from artipg_dsl.geometry.merge import Convex
from artipg_dsl.native import gaps
from artipg_dsl.native.gaps import Stock

from .machine import needs_compiler


def pieces(count, near, plain):
    """Convex pieces side by side, ``plain``: boxes that are alike, so that much ties."""
    lots = np.random.Generator(np.random.PCG64(6))
    cube = np.array([[x, y, z] for x in (-0.5, 0.5) for y in (-0.5, 0.5) for z in (-0.5, 0.5)])
    found = []
    for k in range(count):
        points = (cube if plain else lots.normal(size=(12, 3))) + near * np.array([k % 4, k // 4, 0.0])
        hull = ConvexHull(points)
        found.append((points[hull.vertices], hull.equations[:, :3].copy(), -hull.equations[:, 3]))
    stock = Stock(*zip(*found, strict=True))
    return [Convex(*shape, 0, 0, k, None, stock, k) for k, shape in enumerate(found)]


@needs_compiler
def test_gaps_of_clusters(machine):
    for near in (0.5, 1.0, 1.5, 3.0):
        for plain in (False, True):
            every = pieces(70, near, plain)
            for some in map(tuple, (every[:2], every[3:9], every[::7], every)):
                numbers = [piece.number for piece in some]
                assert gaps.deepest(machine, some[0].stock, numbers, merge._TURNED) == merge._deepest(some)


def test_what_was_asked_is_kept(using):
    using("numpy")
    every = pieces(4, 1.5, False)
    assert merge.gap(every) == merge._deepest(tuple(every))[0] and list(every[0].stock.known) == [(0, 1, 2, 3)]
