"""Pieces in many states: compiled code finds what NumPy finds, in the same order."""

import numpy as np
import pytest

from artipg_dsl.geometry import collide
from artipg_dsl.native import backend, narrow, states
from artipg_dsl.session import Session
from artipg_dsl.validity import following
from artipg_dsl.validity.bodies import Placed, gather
from artipg_dsl.validity.evidence import random_states
from artipg_dsl.validity.tree import Tree

from .machine import needs_compiler

pytestmark = needs_compiler


@pytest.fixture(scope="module")
def racks():
    """Two racks beyond their ranges, so that pieces meet, in 12 random states."""
    batch = Session.of("Foldingrack").sampler.batch(np.arange(2), 3)
    tree = Tree(batch)
    values = np.array([random_states(batch, number) for number in range(12)])
    return tree, gather(batch, tree.first, tree.turn, tree.shift), 1.8 * values


def test_the_same_pairs_are_near_and_meet(using, racks):
    tree, body, values = racks
    asked = np.ones((len(values), 2), dtype=bool)
    asked[3, 0] = asked[5, 1] = False
    found, pairs = [], []
    for name in ("numpy", "c"):
        using(name)
        own, (turn, shift, _, _) = body.fresh(), tree.poses(values)
        all_pairs = following._pairs(tree, own, asked.any(axis=0))
        pairs.append(following._near(own, turn, shift, all_pairs, asked, tree.links.owner))
        met = following.meet_in_states(tree, own, values, asked)
        found.append([(one.number, one.pieces[0].tolist(), one.pieces[1].tolist()) for one in met])
    assert len(pairs[0][0]) > 1000 and all(np.array_equal(a, b) for a, b in zip(*pairs, strict=True))
    assert found[0] == found[1] and sum(len(first) for _, first, _ in found[0]) > 20


def test_each_pair_is_told_as_if_it_were_alone(using, racks):
    """Directions that parted the same two pieces in other states save work, and change no answer."""
    using("c")
    tree, body, values = racks
    turn, shift, _, _ = tree.poses(values)
    machine, links = backend.machine(), turn.shape[1]
    lots = np.random.Generator(np.random.PCG64(3))
    pairs = tuple(lots.integers(0, len(body), (2, 40))[:, lots.integers(0, 40, 3000)])
    state = lots.integers(0, len(values), 3000)
    sides, placed = [], []
    for piece in pairs:
        pose = state * links + body.link[piece]
        sides.append(narrow.Side(body.corners, body.kind[piece], body.slot[piece], turn, shift, pose=pose))
        at = state, body.link[piece]
        placed.append(Placed(body, piece, turn[at], shift[at]))
    hit = states.meet_in_states(machine, *sides, pairs, (body.low, body.high), 1e-8, collide.MOST_STEPS)
    assert np.array_equal(hit, collide.overlap(*placed)) and 0 < hit.mean() < 0.5
