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
from artipg_dsl.lower.vectors import compose, direct, place, product, rotation_about
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

    made = points.sample(here.sites(), len(here), 600, key, here.numbers.astype(np.uint64))
    position, normal = points.evaluate(there.sites(), made)  # the same places on the primitives, wherever these are now
    assert position == pytest.approx(made.position @ turn.T + np.array(shift), abs=1e-9)
    assert normal == pytest.approx(made.normal @ turn.T, abs=1e-9)
    sets = [made, replace(made, position=position, normal=normal)]

    first, second = (label_points(b, b.sites(), s) for b, s in zip((here, there), sets, strict=True))
    assert np.array_equal(first.semantic, second.semantic)
    assert set(first.fields) == set(second.fields) and first.fields
    for name, values in first.fields.items():
        assert values.any(), name
        assert np.array_equal(values, second.fields[name]), name

    a, b = part_poses(here), part_poses(there)
    assert b.center == pytest.approx(a.center @ turn.T + np.array(shift), abs=1e-9)
    assert b.size == pytest.approx(a.size, abs=1e-12)
    assert b.rotation == pytest.approx(np.einsum("ij,pjk->pik", turn, a.rotation), abs=1e-9)
