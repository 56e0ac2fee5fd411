"""Links in motion: rigid, about the right axis, children with their parents."""

import numpy as np
import pytest

from artipg_dsl.runtime.motion import apply, link_motion, product, rotation_about


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
    hinge = {int(o): (joints.origin[k], joints.axis[k][2]) for k, o in enumerate(joints.owner) if joints.name[k] == "open"}
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
    assert product(turn, np.swapaxes(turn, 1, 2)) == pytest.approx(np.tile(np.eye(3), (len(turn), 1, 1)), abs=1e-12)
    assert np.linalg.det(turn) == pytest.approx(np.ones(len(turn)))


def test_rotation_about_an_axis():
    axis = np.array([[0.0, 0.0, 1.0], [1.0, 0.0, 0.0]])
    turned = apply(rotation_about(axis, np.array([np.pi / 2, np.pi / 2])), np.array([[1.0, 0.0, 0.0], [0.0, 1.0, 0.0]]))
    assert turned == pytest.approx(np.array([[0.0, 1.0, 0.0], [0.0, 0.0, 1.0]]), abs=1e-15)
