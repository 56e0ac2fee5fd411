"""What collides: few pieces, round ones as what they are, open cavities, and no link that meets another."""

from __future__ import annotations

from xml.etree import ElementTree

import numpy as np
import pytest

from artipg_dsl.export.mjcf import mjcf_files
from artipg_dsl.export.urdf import urdf_files
from artipg_dsl.export.usd import usd_files
from artipg_dsl.geometry import merge
from artipg_dsl.geometry.merge import cluster_units, clusters, cut, gap, gather_clusters, halves
from artipg_dsl.geometry.stock import Stock
from artipg_dsl.robot.hulls import STEPS, Gathered
from artipg_dsl.robot.model import Robot
from artipg_dsl.robot.robots import Robots
from artipg_dsl.robot.solids import match_round, planes_of
from artipg_dsl.session import Session

BOX = np.array([(x, y, z) for x in (-0.5, 0.5) for y in (-0.5, 0.5) for z in (-0.5, 0.5)])


Piece = tuple[np.ndarray, int, int, int]  # corners, unit, name, index


def stock(pieces: list[Piece]) -> Stock:
    from scipy.spatial import ConvexHull

    hulls = [ConvexHull(points) for points, *_ in pieces]
    equations = np.concatenate([hull.equations for hull in hulls])
    point_start, face_start = (
        np.cumsum([0, *counts]) for counts in ([len(p) for p, *_ in pieces], [len(h.equations) for h in hulls])
    )
    triangles = np.concatenate([hull.simplices for hull in hulls]).astype(np.int64)
    points, places = np.concatenate([p for p, *_ in pieces]), np.array([piece[1:] for piece in pieces]).T.copy()
    normals, offsets = equations[:, :3].copy(), -equations[:, 3].copy()
    return Stock(points, point_start, triangles, normals, offsets, face_start, *places)


def convex(points: np.ndarray, unit: int = 0, name: int = 0, index: int = 0) -> Piece:
    return points, unit, name, index


def ring(count: int, radius: float = 1.0, bore: float = 0.9, level: float = 0.0, name: int = 0) -> list[Piece]:
    found = []
    for i in range(count):
        ends = 2 * np.pi * np.array([i, i + 1]) / count
        corners = [
            (r * np.cos(a), r * np.sin(a), h) for a in ends for r in (radius, bore) for h in (level, level + 0.3)
        ]
        found.append(convex(np.array(corners), name=name, index=i))
    return found


def all_of(held: Stock) -> np.ndarray:
    return np.arange(len(held.unit))


def test_a_hull_that_adds_nothing_has_no_gap() -> None:
    whole = stock([convex(BOX), convex(BOX + [1.0, 0, 0])])
    assert gap(whole, all_of(whole)) == pytest.approx(0.0, abs=1e-9)
    apart = stock([convex(BOX), convex(BOX + [1.2, 0, 0])])
    assert gap(apart, all_of(apart)) == pytest.approx(0.1, abs=0.02)  # half of what is between


def test_a_ring_becomes_staves_and_keeps_its_hole() -> None:
    held = stock(ring(24))
    assert len(clusters(held, all_of(held), 1e-9)) == 24
    staves = clusters(held, all_of(held), 0.08)
    assert 5 <= len(staves) <= 8 and sorted(p for c in staves for p in c) == list(range(24))
    for stave in staves:  # the chord of a stave of 1 / n turn bulges into the bore by 1 - cos(pi / n)
        assert gap(held, stave) == pytest.approx(0.9 * (1 - np.cos(np.pi / len(staves))), abs=0.02)
    assert gap(held, all_of(held)) > 0.5  # one hull would fill the hole


def test_of_many_pieces_few_points_are_asked_about_and_the_gap_is_the_same(monkeypatch: pytest.MonkeyPatch) -> None:
    tube = stock([piece for k in range(5) for piece in ring(16, 1.0 + 0.05 * k, 0.9, level=0.3 * k, name=k)])
    asked = []
    beyond = merge._beyond
    monkeypatch.setattr(merge, "_beyond", lambda n, o, p: asked.append(len(n) * len(p)) or beyond(n, o, p))
    pruned = merge._deepest(tube, all_of(tube))
    few = sum(asked)
    asked.clear()
    monkeypatch.setattr(merge, "_MANY", len(tube.unit))
    assert merge._deepest(tube, all_of(tube)) == pruned and few < sum(asked) / 5


def test_rings_one_above_the_other_become_long_staves() -> None:
    tube, one = stock([piece for k in range(6) for piece in ring(24, level=0.3 * k, name=k)]), stock(ring(24))
    assert len(clusters(tube, all_of(tube), 0.08)) == len(clusters(one, all_of(one), 0.08))


def test_the_keys_of_a_keyboard_become_one_slab_and_far_ones_do_not() -> None:
    keys = [convex(BOX * [1, 1, 0.2] + [1.1 * c, 1.1 * r, 0], unit=10 * r + c) for r in range(4) for c in range(10)]
    near, far = stock(keys), stock(keys[::2])
    assert gather_clusters(near, all_of(near), np.arange(40), 0.12).tolist() == [0]
    assert gather_clusters(far, all_of(far), np.arange(20), 0.12).tolist() == list(range(20))
    assert cluster_units(near, all_of(near), 0.12).tolist() == list(range(40))  # primitives stay apart


def test_halves_are_of_primitives_then_steps_then_names() -> None:
    tube = stock([piece for k in range(2) for piece in ring(4, name=k)])
    one, other = halves(tube, all_of(tube))
    assert set(tube.index[one]) == {0, 1} and set(tube.index[other]) == {2, 3}
    assert set(tube.name[halves(tube, np.flatnonzero(tube.index == 0))[0]]) == {0}
    with pytest.raises(ValueError):
        halves(tube, np.arange(1))


def test_cylinders_balls_and_capsules_are_known() -> None:
    turn = np.arange(24) * np.pi / 12
    circle = np.stack([0.02 * np.cos(turn), 0.02 * np.sin(turn), 0 * turn], axis=-1)
    cylinder = np.concatenate([circle - [0, 0, 0.05], circle + [0, 0, 0.05]])
    cone = np.concatenate([circle - [0, 0, 0.05], 0.9 * circle + [0, 0, 0.05]])
    assert match_round(np.stack([cylinder, cone])).tolist() == [[pytest.approx(0.02), pytest.approx(0.1), 0], [0, 0, 0]]
    tilt = np.linspace(-np.pi / 2, np.pi / 2, 9)
    ball = np.stack(
        np.broadcast_arrays(
            np.cos(tilt)[:, None] * np.cos(turn), np.cos(tilt)[:, None] * np.sin(turn), np.sin(tilt)[:, None]
        ),
        -1,
    )
    ball = 0.03 * ball.reshape(-1, 3)
    capsule = ball + np.sign(ball[:, 2:]) * [0, 0, 0.04]
    assert match_round(np.stack([ball, capsule])).tolist() == [
        [pytest.approx(0.03), 0, 1],
        [pytest.approx(0.03), pytest.approx(0.08), 1],
    ]
    assert not match_round(np.stack([ball * [1, 1, 1.1], ball * [1, 0.9, 1]])).any()


def test_prisms_of_few_sides_are_no_cylinders() -> None:
    """One of eight sides has its corners on two circles, as a cylinder does, which would reach 8 % of the radius beyond its sides."""
    eight, twelve, cut = (
        np.array(angles) * np.pi / 180 for angles in (range(0, 360, 45), range(0, 360, 30), range(60, 361, 10))
    )
    for angles, radius in (
        (eight, 0.0),
        (twelve, 0.02),
        (cut[cut != np.pi / 2], 0.0),
        (np.arange(24) * np.pi / 12, 0.02),
    ):
        circle = 0.02 * np.stack([np.cos(angles), np.sin(angles), 0 * angles], axis=-1)
        assert match_round(np.concatenate([circle - [0, 0, 0.05], circle + [0, 0, 0.05]])[None])[0, 0] == pytest.approx(
            radius
        )


def prism(sides: int) -> str:
    """A primitive of so many flat sides, with corners on the axes."""
    turn = 2 * np.pi * np.arange(sides) / sides
    corners = ", ".join(f"[r * {x:.15f}, r * {y:.15f}]" for x, y in zip(np.cos(turn), np.sin(turn), strict=True))
    return (
        f"primitive Prism{sides} {{\n  param r : length > 0  test 1cm .. 50cm\n  param h : length > 0  test 1cm .. 1m\n"
        f"  curve edge = polygon({corners})\n  solid = extrude(edge) along z from -h / 2 to h / 2\n}}\n"
    )


def test_prisms_are_cylinders_from_24_sides_on() -> None:
    """Then they are off by no more than the mesh of a cylinder. Of fewer corners, only what is round is one, as a bar of 12."""
    parts = {"Prism12": "", "Prism16": "", "Prism24": "cylinder", "Prism32": "cylinder", "Tube": "cylinder"}
    body = "root part body : Cuboid(size = [1cm, 1cm, 1cm])\n"
    for number, name in enumerate(parts):
        body += f"part p{number} : {name}(r = 20cm, h = 1cm)\nconnect p{number}.bottom on body.top\n"
    round_bar = (
        "primitive Tube {\n  param r : length > 0  test 1cm .. 50cm\n  param h : length > 0  test 1cm .. 1m\n"
        "  curve path = from([0, 0, 0], z) line(h)\n  solid = sweep(circle(r)) along path up y\n}\n"
    )
    text = "apg 1\nuse primitives { Cuboid }\n" + "".join(map(prism, (12, 16, 24, 32))) + round_bar
    batch = Session.of_text(f"{text}category C {{\n{body}}}\n").sampler.batch(np.arange(1), 0)
    found = Robots(batch).robot(0).links[0].colliders
    assert [c.bar.kind if c.bar else "" for c in found[1:]] == list(parts.values())


TEXT = """apg 1
use primitives { Cuboid, Cylinder }
use rounds { Capsule }
use globes { Ball }
category Rounds {
  root part body : Cuboid(size = [30cm, 5cm, 1cm])
  part bar : Cylinder(radius = 1cm, height = 6cm) along y
  part ball : Ball(radius = 2cm)
  part pill : Capsule(radius = 1cm, height = 5cm)
  connect bar.bottom on body.top
  connect ball.bottom on body.top
  connect pill.bottom on body.top
  align bar.center.x = body.center.x
  align ball.center.x = body.center.x + 8cm
  align pill.center.x = body.center.x - 8cm
}
"""


@pytest.fixture(scope="module")
def rounds() -> Robots:
    return Robots(Session.of_text(TEXT).sampler.batch(np.arange(1), 0))


def test_round_pieces_are_written_as_what_they_are(rounds: Robots) -> None:
    robot = rounds.robot(0)
    assert [c.bar.kind if c.bar else "box" for c in robot.links[0].colliders] == [
        "box",
        "cylinder",
        "sphere",
        "capsule",
    ]
    urdf = ElementTree.fromstring(urdf_files(robot)["object.urdf"])
    assert [next(iter(g)).tag for g in urdf.findall("link/collision/geometry")] == ["box", "cylinder", "sphere", "mesh"]
    mjcf = ElementTree.fromstring(mjcf_files(robot)["object.xml"])
    assert [g.get("type") for g in mjcf.iter("geom") if g.get("class") == "collision"] == [
        "box",
        "cylinder",
        "sphere",
        "capsule",
    ]
    usd = usd_files(rounds, 0)["object.usda"].decode()
    assert [usd.count(f"def {kind} ") for kind in ("Cube", "Cylinder", "Sphere", "Capsule")] == [1, 1, 1, 1]


def test_readers_place_round_pieces_alike(rounds: Robots) -> None:
    mujoco = pytest.importorskip("mujoco")
    files = {name: data for name, data in urdf_files(rounds.robot(0)).items()}
    assets = {name: data for name, data in files.items() if name.endswith(".obj")}
    one = mujoco.MjModel.from_xml_string(files["object.urdf"].decode(), assets)
    files = mjcf_files(rounds.robot(0))
    two = mujoco.MjModel.from_xml_string(
        files["object.xml"].decode(), {k: v for k, v in files.items() if k.endswith(".obj")}
    )
    found = []
    for model in (one, two):
        data = mujoco.MjData(model)
        mujoco.mj_forward(model, data)
        kept = [g for g in range(model.ngeom) if model.geom_contype[g] and model.geom_type[g] in (2, 5)]
        axes = data.geom_xmat.reshape(-1, 3, 3)[kept, :, 2]
        found.append((model.geom_size[kept], data.geom_xpos[kept] - data.body("body").xpos, np.abs(axes) > 0.5))
    assert len(found[0][0]) == 2
    assert found[0][0] == pytest.approx(found[1][0], abs=1e-9) and found[0][1] == pytest.approx(found[1][1], abs=1e-9)
    assert found[0][2][0].tolist() == found[1][2][0].tolist() == [False, True, False]


def inside(robot: Robot, point: np.ndarray) -> bool:
    """Whether a point of the object at zero pose lies in a collider."""
    for link in robot.links:
        for c in link.colliders:
            local = point - link.origin
            if c.size is not None:
                hit = (np.abs(c.rotation.T @ (local - c.center)) < np.array(c.size) / 2).all()
            else:
                assert c.hull is not None
                normals, offsets = planes_of(c.hull.vertices[None], c.hull.faces)
                hit = (normals[0] @ local < offsets[0]).all()
            if hit:
                return True
    return False


def test_a_stave_is_cut_off_where_it_would_fill_the_bore() -> None:
    held = stock(ring(24))
    for stave in clusters(held, all_of(held), 0.08):
        plane = cut(held, stave, 0.25, 0.0)
        assert plane is not None
        normal, offset = plane
        bore = np.cos(np.pi / 24) * 0.9  # of the polygon that the pieces leave open
        assert offset == pytest.approx(-bore) and abs(normal[2]) < 1e-9  # a tangent: none of the bore lies behind it
        assert cut(held, stave, 0.01, 0.0) is None  # the pieces at the ends would fall short by more than this
    quarter, half = np.arange(6), np.arange(12)
    assert cut(held, quarter, 2.0, 0.0) is None
    assert cut(held, quarter, 2.0, 5.0) is not None  # of small rings few pieces may be lost
    assert (
        cut(held, half, 2.0, 5.0) is None and cut(held, all_of(held), 2.0, 5.0) is None
    )  # of which one stave would be left
    assert cut(stock(ring(24, radius=9.0, bore=0.9)), quarter, 0.4, 0.0) is not None  # thick walls lose none
    two = stock([convex(BOX), convex(BOX + [1.2, 0, 0], unit=1)])
    assert cut(two, all_of(two), 1.0, 9.0) is None  # between primitives there is nothing to keep open


def test_halves_part_where_the_hull_is_hollow() -> None:
    held = stock(ring(24, 1.0, 0.9) + ring(24, 0.5, 0.4, level=0.3, name=1))
    stave = np.flatnonzero(held.index < 4)
    assert set(held.name[halves(held, stave)[0]]) == {0}
    assert set(held.index[halves(held, np.arange(12))[0]]) == set(range(6))


# category, about how many colliders an object has at most, where its cavity is as shares of its box
CASES = [
    ("Microwave", 90, (0.4, 0.6, 0.55)),
    ("Kettle", 75, (0.5, 0.5, 0.4)),
    ("WashingMachine", 75, (0.5, 0.5, 0.5)),
    ("Bottle", 75, (0.5, 0.5, 0.4)),
    ("Laptop", 60, None),
    ("Scissors", 62, None),
    ("Foldingrack", 75, None),
]


@pytest.mark.parametrize("name, most, cavity", CASES)
def test_shipped_objects_have_few_colliders_and_open_cavities(
    name: str, most: int, cavity: tuple[float, ...] | None
) -> None:
    robots = Robots(Session.of(name).sampler.batch(np.arange(40, 42), 5))
    counts = []
    for i in range(2):
        robot = robots.robot(i)
        counts.append(sum(len(link.colliders) for link in robot.links))
        points = np.concatenate([v.shape.vertices + link.origin for link in robot.links[:1] for v in link.visuals])
        low, high = points.min(axis=0), points.max(axis=0)
        if cavity is not None:
            assert not inside(robot, low + (high - low) * np.array(cavity)), (name, i)
    assert max(counts) <= most


@pytest.mark.parametrize("name", ["WashingMachine", "Foldingrack"])
def test_hulls_reach_hardly_farther_than_the_pieces_and_hold_them(name: str) -> None:
    robots = Robots(Session.of(name).sampler.batch(np.arange(2), 5))
    held = Gathered(robots.pieces, 2, robots.material_rows).stock
    for i, hulls in enumerate(robots.colliders):
        points = np.concatenate([v.shape.vertices + k.origin for k in robots.robot(i).links for v in k.visuals])
        tolerance = STEPS[-1] * np.sqrt((np.ptp(points, axis=0) ** 2).sum())
        kept = sum(len(hull.pieces) for hull in hulls)
        assert kept == sum(len(group.rows[group.table.owner[group.rows] == i]) for group in robots.pieces)
        for hull in hulls:
            normals, offsets = planes_of(hull.vertices[None], hull.faces)
            short = float((held.corners(hull.pieces) @ normals[0].T - offsets[0]).max())
            assert short <= (tolerance if hull.cut else 1e-9)
            assert gap(held, hull.pieces) <= 2 * tolerance
    assert any(hull.cut for hulls in robots.colliders for hull in hulls) == (name == "Foldingrack")


def test_a_small_ring_about_a_tube_is_left_on_all_sides() -> None:
    """The shoe of a rack: what fills its bore is cut off, and a hand that closes on it meets the ring, not the tube within."""
    robots, looked_at = Robots(Session.of("Foldingrack").sampler.batch(np.arange(12, 14), 0)), 0
    held = Gathered(robots.pieces, 2, robots.material_rows).stock
    for hulls in robots.colliders:
        items = [(hull, hull.item.group.table.site[hull.item.row]) for hull in hulls]
        rings = [hull for hull, site in items if robots.batch.program.sites[site].path == "shoe.ring"]
        planes = [planes_of(hull.vertices[None], hull.faces) for hull in rings]
        assert rings and all(hull.cut for hull in rings)
        for piece in (hull.pieces[k : k + 1] for hull in rings for k in range(len(hull.pieces))):
            middle = held.corners(piece).mean(axis=0)
            assert min((normals[0] @ middle - offsets[0]).max() for normals, offsets in planes) < 0.005, held.index[
                piece
            ]
            looked_at += 1
    assert looked_at == 50


@pytest.mark.parametrize("name", ["Bottle", "Microwave", "Foldingrack"])
def test_hulls_of_different_links_stay_apart(name: str) -> None:
    manifold = pytest.importorskip("manifold3d")
    from artipg_dsl.robot.pose import follow_leaders, link_poses, rest_values

    batch = Session.of(name).sampler.batch(np.arange(40, 42), 5)
    robots = Robots(batch)
    for i in range(len(batch)):
        robot, checked = robots.robot(i), 0
        states = [rest_values(robot)]
        for joint in robot.joints:
            if joint.low is not None and joint.high is not None and joint.mimic is None:
                states += [
                    rest_values(robot) | {joint.name: joint.low + t * (joint.high - joint.low)} for t in (0.5, 1.0)
                ]
        for values in states:
            shapes = []
            for number, (link, (turn, shift)) in enumerate(
                zip(robot.links, link_poses(robot, follow_leaders(robot, values)), strict=True)
            ):
                for c in link.colliders:
                    points = (
                        c.hull.vertices if c.hull is not None else (BOX * np.array(c.size)) @ c.rotation.T + c.center
                    )
                    shapes.append((number, manifold.Manifold.hull_points(points @ turn.T + shift)))
            boxes = np.array([s.bounding_box() for _, s in shapes])
            for a in range(len(shapes)):
                near = ((boxes[a, :3] < boxes[:, 3:] + 0.005) & (boxes[:, :3] < boxes[a, 3:] + 0.005)).all(axis=1)
                for b in np.flatnonzero(near).tolist():
                    if b > a and shapes[a][0] != shapes[b][0]:
                        checked += 1
                        shared = shapes[a][1] ^ shapes[b][1]
                        assert shared.volume() < 1e-9, (
                            robot.links[shapes[a][0]].name,
                            robot.links[shapes[b][0]].name,
                            values,
                        )
        assert checked > 0


def test_colliders_are_the_same_alone_and_in_a_batch() -> None:
    sampler = Session.of("WashingMachine").sampler
    many, one = Robots(sampler.batch(np.arange(2), 5)), Robots(sampler.batch(np.array([1]), 5))
    assert urdf_files(many.robot(1)) == urdf_files(one.robot(0))
