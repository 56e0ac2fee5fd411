"""Where the links and joints of real objects are known, they tell what their surfaces do not."""

from __future__ import annotations

import re
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

import artipg_dsl as apg
from artipg_dsl.fit.bodies import alike, twists
from artipg_dsl.fit.compare import Candidates
from artipg_dsl.fit.decide import decide
from artipg_dsl.fit.evidence import Clouds, weigh
from artipg_dsl.fit.fitting import usual_size
from artipg_dsl.fit.joint_map import Real, map_joints
from artipg_dsl.fit.links import Held, Moving, Points
from artipg_dsl.fit.model import Changes, Model, Placed
from artipg_dsl.fit.pose import Frame, Posed, pose, targets, turn
from artipg_dsl.fit.reading import read_cloud
from artipg_dsl.fit.search import Effort
from artipg_dsl.runtime.batch import Batch
from artipg_dsl.session import Session

CHEST = """apg 1
use primitives { Cuboid }
category Chest {
  param wide : length in 40cm .. 60cm = 50cm
  param deep : length in 25cm .. 35cm = 30cm
  param high : length in 20cm .. 30cm = 25cm
  param opens : choice drawer | on_left | on_right | still = drawer
  root part tub : Cuboid(size = [deep, wide, high])
  part panel : Cuboid(size = [2cm, wide, high])
  align panel.back = tub.front
  when opens == drawer { joint pull : prismatic tub -> panel along +x range 0cm .. 15cm }
  when opens == on_left { joint turn : revolute tub -> panel about panel.back.left range -90deg .. 0deg }
  when opens == on_right { joint swing : revolute tub -> panel about panel.back.right range -90deg .. 0deg }
  when opens == still { connect panel.back on tub.front fit left, bottom }
}
"""
ROBOT = """<robot name="r">
<link name="world"/>
<link name="case"><visual><geometry><box size="0.4 0.5 0.3"/></geometry></visual></link>
<link name="door"><visual><geometry><box size="0.02 0.5 0.3"/></geometry></visual></link>
<link name="pane"><visual><geometry><box size="0.01 0.3 0.2"/></geometry></visual></link>
<link name="knob"><visual><geometry><sphere radius="0.02"/></geometry></visual></link>
<link name="tray"><visual><geometry><box size="0.3 0.4 0.02"/></geometry></visual></link>
<link name="puck"><visual><geometry><box size="0.1 0.1 0.05"/></geometry></visual></link>
<joint name="a" type="fixed"><parent link="world"/><child link="case"/><origin xyz="0 0 1"/></joint>
<joint name="b" type="revolute"><parent link="case"/><child link="door"/><origin xyz="0.2 0.25 0" rpy="0 0 1.5707963267948966"/>
<axis xyz="0 0 2"/></joint>
<joint name="c" type="fixed"><parent link="door"/><child link="pane"/></joint>
<joint name="d" type="continuous"><parent link="door"/><child link="knob"/><axis xyz="1 0 0"/></joint>
<joint name="e" type="prismatic"><parent link="case"/><child link="tray"/></joint>
<joint name="f" type="floating"><parent link="case"/><child link="puck"/><axis xyz="0 0 1"/></joint>
</robot>"""


@pytest.fixture(scope="module")
def model() -> Model:
    return Model(Session.of_text(CHEST).sampler, jointed=True)


@pytest.fixture(scope="module")
def chests(model: Model, tmp_path_factory: pytest.TempPathFactory) -> tuple[Batch, list[Posed]]:
    """One chest of each kind, in the order of the kinds, and what their own URDFs show."""
    samples = apg.load(CHEST, n=5, seed=0)
    paths = samples.to_urdf(tmp_path_factory.mktemp("chests"))
    kinds = ["drawer", "on_left", "on_right"]  # a URDF without joints says nothing of them
    first = np.array([list(samples["opens"]).index(kind) for kind in kinds])
    posed = [pose(read_cloud(paths[k]), Frame(front="x"), ".urdf", usual_size(model)) for k in first]
    return model.assembled([(samples.batch, first)]), posed


def still(count: int) -> Placed:
    return Placed(np.ones(count), np.zeros((count, 3)))


def test_the_bodies_of_a_robot(tmp_path: Path) -> None:
    (tmp_path / "robot.urdf").write_text(ROBOT)
    cloud = read_cloud(tmp_path / "robot.urdf")
    assert cloud.bodies is not None and cloud.names == ("case", "door", "pane", "knob", "tray", "puck")
    assert cloud.bodies.of.tolist() == [0, 1, 1, 1, 2, 3]  # a pane and a knob go with their door
    hinge = [0, 0, 1, 0.25, -0.2, 0]
    assert np.allclose(cloud.bodies.twist[:3], [[0] * 6, hinge, [0, 0, 0, 1, 0, 0]])
    assert np.isnan(cloud.bodies.twist[3]).all()
    turned = cloud.bodies.scaled(0.01).turned(turn("z", "y")).twist
    assert np.allclose(turned[1], [0, 0, 1, -0.002, -0.0025, 0]) and np.allclose(turned[2], [0, 0, 0, 0, -0.01, 0])
    (tmp_path / "rigid.urdf").write_text(re.sub('type="[a-z]+"', 'type="fixed"', ROBOT))
    assert read_cloud(tmp_path / "rigid.urdf").bodies is None


def test_joints_are_mapped(model: Model, chests: tuple[Batch, list[Posed]]) -> None:
    """Those of a file in centimetres, of a chest that is half as large again, whose joints move the other way."""
    batch, states = chests[0], np.array([0.1, 0.0, 0.0])
    ours = ["pull", "turn", "swing"]
    for row, (posed, joint) in enumerate(zip(chests[1], ours, strict=True)):
        assert posed.bodies is not None
        larger = replace(posed.bodies.scaled(1.5), twist=-posed.bodies.scaled(1.5).twist)
        shift = np.array([0.2, -0.3, 0.4])
        lifted = np.concatenate(
            [larger.twist[:, :3], larger.twist[:, 3:] + np.cross(shift, larger.twist[:, :3])], axis=1
        )
        bodies = replace(larger, twist=lifted * [1, 1, 1, 0.01, 0.01, 0.01]).scaled(100.0).placed(1.5, shift)
        body = bodies.of[posed.label]
        found = map_joints(batch, np.zeros(3), row, Real(posed.points, posed.normals, body, bodies))
        assert found == {joint: {"joint": joint, "at": 0.0, "by": -1.0}}
        rigid = Real(posed.points, posed.normals, np.where(body < 0, body, 0), bodies)
        assert map_joints(batch, np.zeros(3), row, rigid) == {joint: None}  # of what cannot be seen nothing is known
    pulled = replace(chests[1][0].bodies, twist=0.01 * chests[1][0].bodies.twist)
    posed = chests[1][0]
    points = posed.points + np.where((posed.label == 1)[:, None], [0.1, 0.0, 0.0], 0.0)
    found = map_joints(batch, states, 0, Real(points, posed.normals, pulled.of[posed.label], pulled))
    assert found == {"pull": {"joint": "pull", "at": 0.1, "by": 0.01}}


def test_which_motions_are_alike() -> None:
    way = np.array(["slides", "turns", "turns", "turns", "tilts", ""])
    axis = np.array([[1, 0, 0], [0, 0, 1], [0, 0, -1], [0, 0, 1], [0, 0, 1], [0, 0, 0]], dtype=np.float64)
    origin = np.array([[0, 5, 0], [0.3, 0, 0], [0.3, 0, 7], [0.3, 0.2, 0], [0, 0, 0], [0, 0, 0]], dtype=np.float64)
    told = twists(way, axis, origin)
    found = alike(told[:, None], told[None], np.ones((6, 6)))
    apart = {(0, 1), (0, 2), (0, 3), (1, 3), (2, 3)}  # whatever cannot be told, or stays, may be anything
    assert {(a, b) for a, b in np.argwhere(~found).tolist() if a < b} == apart and (found == found.T).all()
    assert alike(told[1], told[3], np.array(5.0)) and alike(told[0], 3.0 * told[0], np.array(1.0))


def test_points_are_strange_whose_links_do_not_belong_together() -> None:
    """One drawer, or two, where there are two."""
    slide = np.array([0.0, 0.0, 0.0, 1.0, 0.0, 0.0])
    real = np.array([[np.zeros(6), slide, slide]])
    theirs = np.repeat([[0, 1, 2, -1]], [30, 20, 15, 5], axis=1)
    two = Moving(np.array([[7, 8, 9]]), np.array([[0, 1, 2]]), real)
    one = Moving(np.array([[7, 8]]), np.array([[0, 1]]), real[:, :2])
    whole = [
        Held.of(moving, mine, theirs, real, np.ones(1))
        for moving, mine in ((two, np.maximum(theirs, 0)), (one, np.clip(theirs, 0, 1)))
    ]
    assert (whole[0].strange == 0.0).all()
    assert (whole[1].strange[0] > 0.0).tolist() == (theirs[0] == 2).tolist()  # on the drawer that mostly is the other
    asked = np.arange(30, 70)[None]  # of the case nothing
    after = np.clip(theirs[:, 30:], 0, 1)
    points = Points(whole[0].mine[:, 30:], after, theirs[:, 30:], np.ones(1))
    assert (whole[0].otherwise(one, points, real, np.ones(1)) == whole[1].strange[0, asked]).all()
    turns = replace(two, twist=np.array([[np.zeros(6), [0, 0, 1, 0, 0, 0], slide]]))
    found = Held.of(turns, np.maximum(theirs, 0), theirs, real, np.ones(1))
    assert (found.strange[0] > 0.0).tolist() == (theirs[0] == 1).tolist()  # a door is no drawer
    rigid = Held.of(two, np.maximum(theirs, 0), np.minimum(theirs, 0), real, np.ones(1))
    assert (rigid.strange == 0.0).all()  # what was left rigid may move


def opening(model: Model, of: Batch, kind: np.ndarray) -> Batch:
    """A chest of each of some kinds, made of those of a batch in turn."""
    number = next(k for k in model.discrete if model.program.draws[k].column.name == "opens")
    copies = np.arange(len(kind))
    every = copies // (len(kind) // len(of))
    return model.altered(of, every, Changes(copies, np.full(len(kind), number), every, kind.astype(np.float64)))


def test_clouds_tell_how_links_move(model: Model, chests: tuple[Batch, list[Posed]]) -> None:
    """Every chest is likeliest for its own cloud as it opens, though all surfaces are the same."""
    each = opening(model, chests[0], np.tile(np.arange(4), 3))
    told = weigh(each, np.repeat(np.arange(3), 4), still(12), Clouds(targets(chests[1]))).total.reshape(3, 4)
    assert told.argmin(axis=1).tolist() == [0, 1, 2] and (np.sort(told, axis=1)[:, 1] > told.min(axis=1) + 100.0).all()


def test_how_an_object_opens_is_decided(model: Model, chests: tuple[Batch, list[Posed]]) -> None:
    wrong = opening(model, chests[0], np.array([3, 2, 0]))
    found = decide(
        model,
        targets(chests[1]),
        Candidates(wrong, np.arange(3), still(3), np.zeros(3)),
        Effort(rounds=1, tried=3, lanes=1),
    )
    assert found.batch.state.values[model.discrete[-1]].tolist() == [0.0, 1.0, 2.0]
