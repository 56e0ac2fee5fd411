"""What objects stand on: compiled code says what NumPy says of it, to the last bit."""

import numpy as np
import pytest

from artipg_dsl.session import Session
from artipg_dsl.validity.bodies import gather
from artipg_dsl.validity.hull import hulls
from artipg_dsl.validity.mass import weighing
from artipg_dsl.validity.stance import Stance
from artipg_dsl.validity.tree import Tree

from .machine import needs_compiler

pytestmark = needs_compiler


def test_outlines(using):
    """Of round feet, of points on lines and twice in one place, of few points, of many, and of none."""
    lots = np.random.Generator(np.random.PCG64(5))
    turn = lots.integers(0, 24, (40, 60)) * np.pi / 12
    feet = 0.02 * np.stack([np.cos(turn), np.sin(turn)], axis=-1) + 0.3 * lots.integers(0, 2, (40, 60, 2))
    sets = [
        feet,
        np.round(feet, 2),
        np.round(feet) + 1e-12 * lots.normal(size=feet.shape),
        lots.normal(size=feet.shape),
    ]
    for points in [own[:, :many] for own in sets for many in (1, 4, 30, 60)]:
        valid = lots.uniform(size=points.shape[:2]) < lots.uniform(size=(40, 1))
        found = []
        for name in ("numpy", "c"):
            using(name)
            found.append(hulls(points, valid))
        assert found[0].shape == found[1].shape and np.array_equal(*found, equal_nan=True)


@pytest.mark.parametrize("whatever", [False, True])
def test_edges(using, whatever):
    """Of lamps, some of which tip over, others of which are beyond doubt."""
    batch = Session.of("Lamp").sampler.batch(np.arange(24), 3)
    tree, known = Tree(batch), weighing(batch).rough
    stance = Stance(tree, gather(batch, tree.first, tree.turn, tree.shift), known)
    center, asked = stance.centers(tree.turn, tree.shift), np.arange(24) % 5 > 0
    found = []
    for name in ("numpy", "c"):
        using(name)
        found.append([own & asked for own in stance._over_edges(center, known, known.place, whatever, asked)])
    assert np.array_equal(*found) and found[0][0].any() and 0 < found[0][1].sum() < asked.sum()
