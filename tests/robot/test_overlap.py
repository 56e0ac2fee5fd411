"""Mass where primitives overlap: against closed forms, and against booleans of the meshes of shipped objects."""

from __future__ import annotations

import numpy as np
import pytest
import trimesh

from artipg_dsl.geometry.overlap import sequence
from artipg_dsl.geometry.resolution import Resolution
from artipg_dsl.robot.model import RobotLink
from artipg_dsl.robot.robots import Robots
from artipg_dsl.session import Session

HEAD = """apg 1
use primitives { Cuboid, Cylinder }
material light { density 100kg/m3 }
material heavy { density 1000kg/m3 }
"""
BAR = """
  root part body : Cuboid(size = [10cm, 10cm, 10cm])
  part bar : Cuboid(size = [20cm, 4cm, 4cm])         # half of it in the body, half before its front
  align bar.center = body.center + [5cm, 0, 0]
  connect bar to body
"""
WHOLE, SUNK = 0.1**3, 0.1 * 0.04 * 0.04


def links(body: str) -> tuple[RobotLink, ...]:
    session = Session.of_text(f"{HEAD}category Thing {{\n{body}\n}}\n")
    return Robots(session.sampler.batch(np.arange(1), 0)).robot(0).links


def test_boxes_share_their_overlap_exactly() -> None:
    (link,) = links(BAR + "material light on body, bar")
    assert link.mass == pytest.approx(100 * (WHOLE + SUNK), rel=1e-12)
    assert link.center == pytest.approx([SUNK * 0.1 / (WHOLE + SUNK), 0, 0.05], abs=1e-12)
    stub = trimesh.creation.box([0.1, 0.04, 0.04], trimesh.transformations.translation_matrix([0.1, 0, 0]))
    union = trimesh.util.concatenate([trimesh.creation.box([0.1, 0.1, 0.1]), stub])
    union.density = 100
    assert link.inertia == pytest.approx(union.moment_inertia, rel=1e-5, abs=1e-9)


@pytest.mark.parametrize(
    "body, bar, mass",
    [("light", "heavy", 100 * (WHOLE - SUNK) + 1000 * 2 * SUNK), ("heavy", "light", 1000 * WHOLE + 100 * SUNK)],
)
def test_what_is_shared_weighs_as_the_denser_of_the_two(body: str, bar: str, mass: float) -> None:
    (link,) = links(BAR + f"material {body} on body\nmaterial {bar} on bar")
    assert link.mass == pytest.approx(mass, rel=1e-12)


def test_what_three_share_counts_once() -> None:
    third = (
        "\n  part third : Cuboid(size = [4cm, 4cm, 4cm])\n  align third.center = body.center\n  connect third to body\n"
    )
    (link,) = links(BAR + third + "material light on body, bar, third")
    assert link.mass == pytest.approx(100 * (WHOLE + SUNK), rel=1e-12)
    (link,) = links(BAR + third + "material light on body, bar\nmaterial heavy on third")
    assert link.mass == pytest.approx(100 * (WHOLE + SUNK) + 900 * 0.04**3, rel=1e-4)


def test_a_turned_and_a_round_one_come_near_their_closed_forms() -> None:
    box, light = "Cuboid(size = [20cm, 4cm, 4cm])", "material light on body, bar"
    (link,) = links(BAR.replace(box, f"{box} turned 30deg about y").replace("[5cm, 0, 0]", "[0, 0, 0]") + light)
    sunk = 0.04 * 0.04 * 0.1 / np.cos(np.pi / 6)  # slanting ends have the volume of square ones
    assert link.mass == pytest.approx(100 * (WHOLE + 0.2 * 0.04 * 0.04 - sunk), rel=5e-4)
    (link,) = links(BAR.replace(box, "Cylinder(radius = 2cm, height = 20cm) along x") + light)
    assert link.mass == pytest.approx(100 * (WHOLE + np.pi * 0.02**2 * 0.1), rel=3e-3)  # meshes have 24 sides


def test_links_that_are_fixed_together_share_as_one_link_does_and_moving_ones_do_not() -> None:
    def mass(joint: str) -> float:
        return sum(
            link.mass for link in links(BAR.replace("connect bar to body", joint) + "material light on body, bar")
        )

    assert mass("joint held : fixed body -> bar") == pytest.approx(100 * (WHOLE + SUNK), rel=1e-9)
    moved = "joint slide : prismatic body -> bar along x range 0 .. 1cm"
    assert mass(moved) == pytest.approx(100 * (WHOLE + 2 * SUNK), rel=1e-9)


def test_points_fill_a_box_evenly() -> None:
    points = sequence(512)
    assert points.shape == (3, 512) and (points > 0).all() and (points < 1).all()
    cells = np.floor(points * 4).astype(int)
    counts = np.bincount(cells[0] + 4 * cells[1] + 16 * cells[2], minlength=64)
    assert counts.min() >= 5 and counts.max() <= 11  # 8 on average


@pytest.mark.slow
@pytest.mark.parametrize("name", ["Chair", "USB", "Laptop", "Globe", "Microwave", "Faucet"])
def test_shipped_objects_weigh_what_booleans_of_their_meshes_say(name: str) -> None:
    """Mass within 1 % of every link and 0.4 % of every object, centres within 0.2 % of the size, inertia within 1 %.

    What differs is mostly that meshes cut the corners that inside functions round.
    """
    manifold = pytest.importorskip("manifold3d")
    batch = Session.of(name).sampler.batch(np.arange(4), 5)
    robots, double = Robots(batch, resolution=Resolution(96)), 0.0  # meshes near the true shapes
    for i in range(len(batch)):
        robot, totals = robots.robot(i), np.zeros(3)
        for link in robot.links:
            density = np.array([robots.materials[robots.material(v.item)][i].density[0] for v in link.visuals])
            taken, parts, raw = manifold.Manifold(), [], 0.0
            for k in np.lexsort((np.arange(len(density)), -density)).tolist():
                shape = link.visuals[k].shape
                solid = manifold.Manifold(manifold.Mesh64(shape.vertices, shape.faces.astype(np.uint64)))
                raw += density[k] * solid.volume()
                left = (solid - taken).to_mesh64()
                taken = taken + solid
                if len(left.tri_verts):
                    own = trimesh.Trimesh(left.vert_properties[:, :3], left.tri_verts, process=False)
                    parts.append((density[k] * own.volume, own.center_mass, density[k] * own.moment_inertia))
            mass = sum(m for m, _, _ in parts)
            center = sum(m * c for m, c, _ in parts) / mass
            inertia = sum(
                j + m * ((c - center) @ (c - center) * np.eye(3) - np.outer(c - center, c - center))
                for m, c, j in parts
            )
            assert link.mass == pytest.approx(mass, rel=0.01), link.name
            points = np.concatenate([v.shape.vertices for v in link.visuals])
            size = float(np.ptp(points, axis=0).max())
            assert link.center == pytest.approx(center, abs=0.002 * size), link.name
            assert link.inertia == pytest.approx(inertia, abs=0.01 * float(np.trace(inertia)) + 1e-11), link.name
            totals += link.mass, mass, raw
        assert totals[0] == pytest.approx(totals[1], rel=0.004)
        double = max(double, totals[2] / totals[1] - 1.0)
    assert double > 0.004  # there is something to see


def test_masses_are_the_same_alone_and_in_a_batch() -> None:
    sampler = Session.of("USB").sampler
    many, one = Robots(sampler.batch(np.arange(6), 5)), Robots(sampler.batch(np.array([4]), 5))
    for a, b in zip(many.robot(4).links, one.robot(0).links, strict=True):
        assert a.mass == b.mass and (a.center == b.center).all() and (a.inertia == b.inertia).all()
