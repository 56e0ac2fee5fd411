"""Many states of joints that others follow, looked at together: what single states show."""

from __future__ import annotations

from unittest import mock

import numpy as np
import pytest

from artipg_dsl.geometry.collide import overlap
from artipg_dsl.runtime.batch import Batch
from artipg_dsl.session import Session
from artipg_dsl.validity import tree as trees
from artipg_dsl.validity.bodies import Placed, gather
from artipg_dsl.validity.following import meet_in_states
from artipg_dsl.validity.tree import Tree
from artipg_dsl.validity.validate import find_collisions


@pytest.fixture(scope="module")
def shaken() -> Batch:
    """Racks of which some rods are out of place, so that much meets."""
    batch = Session.of("Foldingrack").sampler.batch(np.arange(5), seed=2)
    lot = np.random.default_rng(4)
    for table in batch.sites():
        moved = lot.random(len(table)) < 0.1
        table.translation[moved] += 0.03 * lot.standard_normal((int(moved.sum()), 3))
    return batch


def test_states_together_show_what_each_shows_alone(shaken: Batch) -> None:
    tree, count = Tree(shaken), 0
    body = gather(shaken, tree.first, tree.turn, tree.shift)
    lead, states = tree.following
    together = list(meet_in_states(tree, body, states, lead >= 0))
    assert [found.number for found in together] == list(range(len(states)))
    for found in together:
        (alone,) = meet_in_states(tree, body, states[found.number][None], lead[found.number][None] >= 0)
        one, two = (sorted(zip(*(side.tolist() for side in met.pieces), strict=True)) for met in (found, alone))
        assert one == two
        count += len(one)
    assert count > 100


def test_boxes_and_directions_leave_out_nothing_that_meets() -> None:
    """Every pair of pieces of different links asked by itself, doors opened far past their limits."""
    tree, count, lot = Tree(Session.of("door").sampler.batch(np.arange(3), 2)), 0, np.random.default_rng(3)
    body = gather(tree.batch, tree.first, tree.turn, tree.shift)
    wide = tree.high - tree.low
    states = tree.low - wide + 3.0 * wide * lot.uniform(size=(8, len(wide)))
    i, j = (side.ravel() for side in np.meshgrid(np.arange(len(body)), np.arange(len(body)), indexing="ij"))
    asked = (body.owner[i] == body.owner[j]) & (body.link[i] < body.link[j])
    i, j = i[asked], j[asked]
    i, j = (side[~tree.permitted(body.link[i], body.link[j])] for side in (i, j))
    body.ready(i, j)
    for found in meet_in_states(tree, body, states):
        turn, shift, _ = tree.at(states[found.number])
        placed = [Placed(body, side, turn[body.link[side]], shift[body.link[side]]) for side in (i, j)]
        hit = overlap(*placed)
        one, two = (sorted(zip(*(s.tolist() for s in p), strict=True)) for p in (found.pieces, (i[hit], j[hit])))
        assert one == two
        count += len(one)
    assert count > 20


@pytest.mark.slow
def test_loops_are_settled_for_all_states_at_once(shaken: Batch) -> None:
    loops = shaken.loops
    assert loops is not None
    states = Tree(shaken).following[1]
    assert loops.settle(states).tobytes() == np.stack([loops.settle(state) for state in states]).tobytes()
    with mock.patch("artipg_dsl.runtime.loops._BLOCK", 1):  # whatever fits into memory at a time
        assert loops.settle(states).tobytes() == loops.settle(states[::-1])[::-1].tobytes()


def test_a_check_settles_loops_a_few_times(shaken: Batch) -> None:
    """At rest, and in all states together, not state by state."""
    kind = type(shaken.loops)
    with mock.patch.object(kind, "_settle_states", autospec=True, side_effect=kind._settle_states) as calls:
        find_collisions(shaken)
    assert calls.call_count <= 3


@pytest.mark.slow
def test_poses_of_more_states_than_fit_are_worked_out_anew(shaken: Batch) -> None:
    one = find_collisions(shaken)
    with mock.patch.object(trees, "_KEPT", 1), mock.patch("artipg_dsl.validity.following._BLOCK", 1):
        two = find_collisions(shaken)
    assert one.value.tobytes() == two.value.tobytes() and one.pieces.tobytes() == two.pieces.tobytes()


def test_objects_without_a_joint_have_no_states_to_look_at() -> None:
    text = "apg 1\nuse primitives { Cuboid }\ncategory Box {\n  root part body : Cuboid(size = [1m, 1m, 1m])\n}\n"
    batch = Session.of_text(text).sampler.batch(np.arange(2), seed=0, checked=True)
    tree = Tree(batch)
    lead, states = tree.following
    assert states.shape == (len(lead), 0)
    assert not len(find_collisions(batch, tree, gather(batch, tree.first, tree.turn, tree.shift)).objects())
