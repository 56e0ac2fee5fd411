"""What of the boundary can be seen from without: against rays cast one by one, and on boxes whose answer is known."""

from __future__ import annotations

import numpy as np

from artipg_dsl import random
from artipg_dsl.annotate.cloud import sample_points
from artipg_dsl.annotate.sampling import Sampling
from artipg_dsl.geometry import outside, points
from artipg_dsl.geometry.block import block_of
from artipg_dsl.geometry.cells import Cells
from artipg_dsl.geometry.cover import scales
from artipg_dsl.session import Session

from . import scenes, shapes

KEY = random.key(7, "points")
BOX = shapes.cuboid()
PRIMITIVES = [BOX, shapes.rounded_cuboid(), shapes.cylinder()]


def walls(lid: bool) -> list:
    """A box of 30 cm with walls of 1 cm, its top open or closed."""
    t, a = 0.01, 0.15
    plates = [
        ((0.3, 0.3, t), (0, 0, -a + t / 2)),
        ((0.3, 0.3, t), (0, 0, a - t / 2)),
        ((t, 0.3, 0.3 - 2 * t), (a - t / 2, 0, 0)),
        ((t, 0.3, 0.3 - 2 * t), (t / 2 - a, 0, 0)),
        ((0.3 - 2 * t, t, 0.3 - 2 * t), (0, a - t / 2, 0)),
        ((0.3 - 2 * t, t, 0.3 - 2 * t), (0, t / 2 - a, 0)),
    ]
    kept = [0, 2, 3, 4, 5] + ([1] if lid else [])
    return [
        scenes.table(n, BOX, dict(zip(("size.x", "size.y", "size.z"), plates[k][0], strict=True)), [0], [plates[k][1]])
        for n, k in enumerate(kept)
    ]


def test_the_inside_of_a_closed_box_is_not_seen() -> None:
    one = np.zeros(1, dtype=np.uint64)
    boundary, seen = (points.sample(walls(True), 1, 3000, KEY, one, outside=o) for o in (False, True))

    def within(found: points.PointSet) -> float:
        return float((np.abs(found.position[0]).max(axis=1) < 0.1401).mean())

    inner, outer = 0.28**2, 0.3**2
    assert abs(within(boundary) - inner / (inner + outer)) < 0.01
    assert within(seen) == 0.0 and seen.position.shape == (1, 3000, 3)
    counts = np.array([(np.abs(seen.position[0] @ way - 0.15) < 1e-9).sum() for way in (*np.eye(3), *-np.eye(3))])
    assert counts.sum() == 3000 and ((counts - 500) ** 2 / 500).sum() < 3  # of white noise: 5 or so, up to 15


def test_the_inside_of_an_open_box_is_seen() -> None:
    one = np.zeros(1, dtype=np.uint64)
    boundary, seen = (points.sample(walls(False), 1, 3000, KEY, one, outside=o) for o in (False, True))
    share = [(np.abs(f.position[0][:, 2] + 0.14) < 1e-9).mean() for f in (boundary, seen)]
    assert share[0] > 0.08 and abs(share[0] - share[1]) < 0.005


DOME = """apg 1
use cookware { LidShell }
use primitives { Cylinder }
category Closed {
  root part plate : Cylinder(radius = 12cm, height = 1cm)
  part lid : LidShell(radius = 11cm, edge = 2mm, brim = 6mm, rise = 3cm, wall = 1.5mm)
  connect lid.bottom to plate.top gap 0.2mm
}
"""


def test_the_hollow_of_a_thin_dome_is_not_seen() -> None:
    """The chords of its mesh lie further in than the points, so that flat rays begin between them and the skin."""
    batch = Session.of_text(DOME).sampler.batch(np.arange(1), 0)

    def hollow(surface: str) -> float:
        points = sample_points(batch, Sampling(2000, surface=surface))
        return float(((points.normal[0][:, 2] < -0.1) & (points.position[0][:, 2] > 0.0079)).mean())

    assert hollow("boundary") > 0.2 and hollow("outside") == 0.0


def test_the_grid_gives_what_rays_give_one_by_one() -> None:
    address = np.arange(3, dtype=np.uint64)
    sites = scenes.cluttered(PRIMITIVES, address, 14)
    found = points.sample(sites, 3, 200, KEY, address)
    rows = block_of(sites, 0, 3)
    cells = Cells(rows)
    outlook = outside.Outlook(cells, scales(rows), np.zeros(len(cells.area), dtype=bool))
    own = points._rows(sites, rows, found.site.ravel(), found.row.ravel())
    cell = cells.first[own] + found.patch.ravel()
    position, normal = found.position.reshape(-1, 3), found.normal.reshape(-1, 3)
    seen = outlook.sees(cell, position.T, normal.T)
    assert 0.5 < seen.mean() < 1.0
    start = position + outlook.off[cells.owner[cell], None] * normal
    expected = np.array(
        [plain(outlook, int(o), p, n) for o, p, n in zip(cells.owner[cell], start, normal, strict=True)]
    )
    assert (seen == expected).all()


def plain(outlook: outside.Outlook, owner: int, start: np.ndarray, normal: np.ndarray) -> bool:
    """Whether one of the rays from a point leaves: every ray with every triangle (Moeller and Trumbore's test)."""
    faces = np.concatenate([triangles.face[:, triangles.owner == owner] for triangles in outlook.asked], axis=1)
    mine = outlook.vertex[:, faces].transpose(2, 1, 0)  # (T, corner, axis)
    a, e, f = mine[:, 0], mine[:, 1] - mine[:, 0], mine[:, 2] - mine[:, 0]
    for way in outside.spread_directions():
        if way @ normal <= 0.02:
            continue
        p = np.cross(way, f)
        along = (e * p).sum(axis=1)
        s = start - a
        q = np.cross(s, e)
        u, v, t = (s * p).sum(axis=1), q @ way, (f * q).sum(axis=1)  # all times `along`, which is above 0 at entries
        hit = (along > 0) & (u >= 0) & (v >= 0) & (u + v <= along) & (t > 0)
        if not hit.any():
            return True
    return False


def test_directions_are_even() -> None:
    ways = outside.spread_directions()
    assert np.abs((ways**2).sum(axis=1) - 1).max() < 1e-12
    angle = np.degrees(np.arccos(np.clip(ways @ ways.T - 2 * np.eye(len(ways)), -1, 1)))
    assert 13 < angle.min(axis=1).min() and angle.min(axis=1).max() < 17.5
    assert np.abs(ways.sum(axis=0)).max() < 0.1
