"""What is known of the state before saves work and changes no answer."""

from __future__ import annotations

import numpy as np

from artipg_dsl.session import Session
from artipg_dsl.validity.bodies import gather
from artipg_dsl.validity.parting import Parting
from artipg_dsl.validity.tree import Tree
from artipg_dsl.validity.validate import posed


def test_states_in_any_order_meet_as_they_do_alone() -> None:
    tree = Tree(Session.of("door").sampler.batch(np.arange(6), 2))
    body = gather(tree.batch, tree.first, tree.turn, tree.shift)
    parting, met, lot = Parting(), 0, np.random.default_rng(3)
    for _ in range(12):
        wide = tree.high - tree.low
        states = tree.low - wide + 3.0 * wide * lot.uniform(size=len(wide))  # far past their limits: some collide
        alone, known = posed(tree, body, states), posed(tree, body, states, parting)
        assert [side.tolist() for side in alone] == [side.tolist() for side in known]
        met += len(alone[0])
    assert met > 0 and len(parting.code) > 0
