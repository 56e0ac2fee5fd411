"""Labels, part poses and grasps follow any rigid motion: they are formulas in the frames of what they lie on."""

from dataclasses import replace

import numpy as np
import pytest

from artipg_dsl.annotate.points import label_points
from artipg_dsl.annotate.poses import part_poses
from artipg_dsl.geometry import points
from artipg_dsl.graph import expr as E
from artipg_dsl.graph import random
from artipg_dsl.graph.program import Pose, Program
from artipg_dsl.lower.values import compose, direct, place, product, rotation_about
from artipg_dsl.runtime.sample import Sampler
from artipg_dsl.session import Session

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
    made.labels = [
        replace(label, targets=tuple(replace(t, frame=compose(motion, t.frame)) for t in label.targets)) for label in program.labels
    ]
    return made


@pytest.fixture(scope="module")
def program():
    return Session.of("Microwave").lowering.program


@pytest.mark.parametrize("angle, shift", [(0.7, (0.3, -0.2, 1.5)), (2.9, (-4.0, 2.0, 0.1))])
def test_labels_and_poses_move_with_the_object(program, angle, shift):
    motion = rigid(angle, shift)
    numbers, key = np.arange(24), random.key(5, "points")
    here, there = (Sampler(p).batch(numbers, 5) for p in (program, moved(program, motion)))
    turn = np.array([[c.constant for c in row] for row in motion.rotation])

    sets = [points.sample(b.sites(), len(b), 600, key, b.numbers.astype(np.uint64)) for b in (here, there)]
    same = (sets[0].site == sets[1].site) & (sets[0].row == sets[1].row) & (np.abs(sets[0].u - sets[1].u) < 1e-12)
    assert same.mean() > 0.995  # a probe that grazes a face may fall on its other side
    assert sets[1].position[same] == pytest.approx(sets[0].position[same] @ turn.T + np.array(shift), abs=1e-9)
    assert sets[1].normal[same] == pytest.approx(sets[0].normal[same] @ turn.T, abs=1e-9)

    first, second = (label_points(b, b.sites(), s) for b, s in zip((here, there), sets, strict=True))
    assert np.array_equal(first.semantic[same], second.semantic[same])
    assert set(first.fields) == set(second.fields) and first.fields
    for name, values in first.fields.items():
        assert values.any(), name
        assert (values[same] == second.fields[name][same]).mean() == 1.0, name

    a, b = part_poses(here), part_poses(there)
    assert b.center == pytest.approx(a.center @ turn.T + np.array(shift), abs=1e-9)
    assert b.size == pytest.approx(a.size, abs=1e-12)
    assert b.rotation == pytest.approx(np.einsum("ij,pjk->pik", turn, a.rotation), abs=1e-9)
