"""Labels, part poses, grasps and keypoints of shipped categories follow any rigid motion, in random joint states.

Every category with ``ARTIPG_EVERY=1 pytest tests/annotate/test_equivariance.py``.
"""

import os
from dataclasses import replace

import numpy as np
import pytest

from artipg_dsl import random
from artipg_dsl.annotate.grasps import sample_grasps, sample_keypoints
from artipg_dsl.annotate.points import label_points
from artipg_dsl.annotate.poses import part_poses
from artipg_dsl.annotate.states import joint_values, read_states
from artipg_dsl.geometry import points
from artipg_dsl.graph import expr as E
from artipg_dsl.graph.program import Pose, Program
from artipg_dsl.lower.values.vectors import compose, direct, place, product, rotation_about
from artipg_dsl.sampling.sample import Sampler
from artipg_dsl.session import Session, categories

AXIS = np.array([0.36, 0.48, 0.8])


def rigid(angle: float, shift: tuple[float, float, float]) -> Pose:
    turn = rotation_about(tuple(E.const(a) for a in AXIS), E.const(angle))
    tilt = rotation_about((E.ONE, E.ZERO, E.ZERO), E.const(0.3))
    return Pose(product(turn, tilt), tuple(E.const(s) for s in shift), E.ONE)


def moved(program: Program, motion: Pose) -> Program:
    """The same program with every pose of the object carried by a rigid motion."""
    made = replace(program)
    made.sites = [replace(s, pose=compose(motion, s.pose)) for s in program.sites]
    made.parts = [replace(p, pose=compose(motion, p.pose)) for p in program.parts]
    made.joints = [replace(j, origin=place(motion, j.origin), axis=direct(motion, j.axis)) for j in program.joints]
    made.closures = [replace(c, points=tuple(place(motion, point) for point in c.points)) for c in program.closures]
    made.grasps = [replace(g, frame=compose(motion, g.frame)) for g in program.grasps]
    made.keypoints = [replace(k, point=place(motion, k.point)) for k in program.keypoints]
    made.labels = [
        replace(label, targets=tuple(replace(t, frame=compose(motion, t.frame)) for t in label.targets))
        for label in program.labels
    ]
    return made


def carries(category, angle, shift, count):
    program, motion = Session.of(category).lowering.program, rigid(angle, shift)
    numbers, key = np.arange(count), random.key(5, "points")
    here, there = (Sampler(p).batch(numbers, 5) for p in (program, moved(program, motion)))
    turn = np.array([[c.constant for c in row] for row in motion.rotation])

    made = points.sample(here.sites(), len(here), 600, key, here.numbers.astype(np.uint64))
    position, normal = points.evaluate(there.sites(), made)  # the same places on the primitives, wherever these are now
    assert position == pytest.approx(made.position @ turn.T + np.array(shift), abs=1e-9)
    assert normal == pytest.approx(made.normal @ turn.T, abs=1e-9)
    sets = [made, replace(made, position=position, normal=normal)]

    first, second = (label_points(b, b.sites(), s) for b, s in zip((here, there), sets, strict=True))
    assert np.array_equal(first.semantic, second.semantic)
    assert set(first.fields) == set(second.fields) and first.fields
    for name, values in first.fields.items():
        if values.dtype == bool:
            assert np.array_equal(values, second.fields[name]), name
        elif values.ndim == 2:
            assert second.fields[name] == pytest.approx(values, abs=1e-6, nan_ok=True), name
        else:
            assert second.fields[name] == pytest.approx(values @ turn.T, abs=1e-6, nan_ok=True), name

    grasps, keys = ([make(b) for b in (here, there)] for make in (sample_grasps, sample_keypoints))
    starts = np.searchsorted(here.links().owner, numbers)
    for values in joint_values(here, read_states("rest,random:2")):
        a, b = part_poses(here, values), part_poses(there, values)
        assert b.center == pytest.approx(a.center @ turn.T + np.array(shift), abs=1e-9)
        assert b.size == pytest.approx(a.size, abs=1e-12)
        assert b.rotation == pytest.approx(np.einsum("ij,pjk->pik", turn, a.rotation), abs=1e-9)
        moves = [batch.pose(values) for batch in (here, there)]
        one, two = (g.moved(starts, *m) for g, m in zip(grasps, moves, strict=True))
        assert two[0] == pytest.approx(one[0] @ turn.T + np.array(shift), abs=1e-9)
        assert two[1] == pytest.approx(np.einsum("ij,pjk->pik", turn, one[1]), abs=1e-9)
        link = starts[keys[0].owner] + keys[0].link
        tips = [np.einsum("kij,kj->ki", m[0][link], k.point) + m[1][link] for k, m in zip(keys, moves, strict=True)]
        assert tips[1] == pytest.approx(tips[0] @ turn.T + np.array(shift), abs=1e-9)


@pytest.mark.some
@pytest.mark.parametrize("angle, shift", [(0.7, (0.3, -0.2, 1.5)), (2.9, (-4.0, 2.0, 0.1))])
def test_labels_and_poses_move_with_the_object(angle, shift):
    carries("Microwave", angle, shift, 24)


@pytest.mark.parametrize("category", sorted(categories()) if os.environ.get("ARTIPG_EVERY") == "1" else ["Faucet"])
def test_they_do_so_in_other_categories(category):
    carries(category, 2.2, (-1.0, 0.4, 0.6), 6)
