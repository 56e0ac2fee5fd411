"""Links in motion: rigid, about the right axis, children with their parents."""

import numpy as np
import pytest

from artipg_dsl.runtime.motion import apply, link_motion, multiply, rotation_about


def states_at(batch, **values):
    joints = batch.joints()
    states = batch.rest().copy()
    for k, name in enumerate(joints.name):
        if name in values:
            states[k] = values[name]
    return states


def test_rest_moves_nothing(microwave):
    batch = microwave.batch(np.arange(20), seed=1)
    turn, shift = batch.pose()
    assert np.array_equal(turn, np.tile(np.eye(3), (len(turn), 1, 1)))
    assert not shift.any()


def test_door_turns_about_its_edge_and_takes_the_handle_along(microwave):
    batch = microwave.batch(np.arange(40), seed=1)
    turn, shift = batch.pose(states_at(batch, open=np.pi / 2))
    links, joints = batch.links(), batch.joints()
    hinge = {
        int(o): (joints.origin[k], joints.axis[k][2]) for k, o in enumerate(joints.owner) if joints.name[k] == "open"
    }
    first = np.searchsorted(links.owner, np.arange(len(batch)))
    checked = 0
    for table in batch.sites():
        if not table.path.startswith(("door.", "handle.")):
            continue
        for row in range(len(table)):
            owner = int(table.owner[row])
            at = first[owner] + table.link[row]
            assert links.name[at] == "door"
            before = table.translation[row]
            after = turn[at] @ before + shift[at]
            about, sign = hinge[owner]
            offset = before - about
            # a quarter turn about the vertical hinge takes what lies beside it to the front of it
            assert after - about == pytest.approx([-sign * offset[1], sign * offset[0], offset[2]], abs=1e-12)
            assert after[0] > before[0] - 0.05
            checked += 1
    assert checked > 80


def test_motion_is_rigid(microwave):
    batch = microwave.batch(np.arange(30), seed=2)
    joints = batch.joints()
    share = (np.arange(len(joints.owner)) * 0.37) % 1.0
    low, high = np.nan_to_num(joints.low, nan=-3.0), np.nan_to_num(joints.high, nan=3.0)
    turn, _ = link_motion(batch.links(), joints, low + share * (high - low))
    assert multiply(turn, np.swapaxes(turn, 1, 2)) == pytest.approx(np.tile(np.eye(3), (len(turn), 1, 1)), abs=1e-12)
    assert np.linalg.det(turn) == pytest.approx(np.ones(len(turn)))


def test_rotation_about_an_axis():
    axis = np.array([[0.0, 0.0, 1.0], [1.0, 0.0, 0.0]])
    turned = apply(rotation_about(axis, np.array([np.pi / 2, np.pi / 2])), np.array([[1.0, 0.0, 0.0], [0.0, 1.0, 0.0]]))
    assert turned == pytest.approx(np.array([[0.0, 1.0, 0.0], [0.0, 0.0, 1.0]]), abs=1e-15)


KINDS = """apg 1
use primitives { Cuboid, Cylinder }
category Chain {
  root part base : Cuboid(size = [20cm, 20cm, 4cm])
  part post : Cuboid(size = [2cm, 2cm, 20cm])
  joint turn : revolute base -> post.bottom on base.top at center gap 1mm about post.bottom.front range 0deg .. 80deg
  part nut : Cylinder(radius = 2cm, height = 1cm)
  joint screw : screw post -> nut about line(at = [0, 6cm, 10cm], along = z) range 0turn .. 3turn pitch 4mm
  part cup : Cuboid(size = [3cm, 3cm, 3cm])
  joint ball : ball nut.top -> cup.bottom at center gap 1mm range 0deg .. 30deg
  align nut.center = [0, 6cm, 10cm]
}
"""


def test_a_screw_advances_and_a_ball_tilts():
    from scipy.spatial.transform import Rotation

    from artipg_dsl.session import Session
    from artipg_dsl.source import Source

    batch = Session(Source("chain.apg", KINDS), None).sampler.batch(np.arange(3), seed=0)
    joints, links = batch.joints(), batch.links()
    values = np.random.default_rng(0).uniform(0.1, 1.2, len(joints.owner))
    turn, shift = batch.pose(values)
    for owner in range(3):
        pose = {0: np.eye(4)}
        for k in np.flatnonzero(joints.owner == owner):
            axis, value, moved = joints.axis[k], values[k], np.eye(4)
            if joints.kind[k] == "ball":
                farthest = np.eye(3)[np.argmin(np.abs(axis))]
                axis = farthest - axis * (axis @ farthest)
                axis = axis / np.linalg.norm(axis)
            moved[:3, :3] = Rotation.from_rotvec(axis * value).as_matrix()
            moved[:3, 3] = joints.origin[k] - moved[:3, :3] @ joints.origin[k]
            if joints.kind[k] == "screw":
                assert joints.pitch[k] == 0.004
                moved[:3, 3] += axis * 0.004 * value / (2 * np.pi)
            pose[joints.child[k]] = pose[joints.parent[k]] @ moved
        for link, expected in pose.items():
            row = np.flatnonzero((links.owner == owner) & (links.number == link))[0]
            np.testing.assert_allclose(turn[row], expected[:3, :3], atol=1e-12)
            np.testing.assert_allclose(shift[row], expected[:3, 3], atol=1e-12)


def test_a_chain_of_mimics_of_any_length():
    from types import SimpleNamespace

    from artipg_dsl.runtime.motion import follow

    count = 8
    chain = SimpleNamespace(
        owner=np.zeros(count, dtype=int),
        mimic=np.array([1, 2, 3, 4, 5, 6, 7, -1]),
        multiplier=np.full(count, 2.0),
        offset=np.full(count, 0.5),
        curves=(),
    )
    expected = [1.0]
    for _ in range(count - 1):
        expected.append(2.0 * expected[-1] + 0.5)
    values = np.zeros(count)
    values[-1] = 1.0
    assert follow(chain, values).tolist() == expected[::-1]
