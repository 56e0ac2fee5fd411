"""The tree of semantic parts, and which way affordances move."""

from __future__ import annotations

import os

import numpy as np
import pytest

from artipg_dsl.annotate.annotation import describe
from artipg_dsl.annotate.interactions import directions, interactions
from artipg_dsl.annotate.states import joint_values, opened, read_states, twist
from artipg_dsl.errors import UsageError
from artipg_dsl.runtime.batch import Batch
from artipg_dsl.session import Session, categories

EVERY = os.environ.get("ARTIPG_EVERY") == "1"  # all categories, not only a few


@pytest.fixture(scope="module")
def batch() -> Batch:
    return Session.of("Microwave").sampler.batch(np.arange(12), seed=1)


def test_the_handle_of_the_door_of_the_microwave(batch: Batch) -> None:
    lineages = set()
    for annotation in describe(batch):
        parts = annotation["parts"]
        for part in parts:
            assert (part["lineage"] is None) == (part["semantic"] is None)
            if part["lineage"] is None:
                continue
            lineages.add(part["lineage"])
            above = "Microwave" if part["of"] is None else parts[part["of"]]["lineage"]
            assert part["lineage"] == f"{above}/{part['semantic']}"
    assert {
        "Microwave/body", "Microwave/body/cavity", "Microwave/door", "Microwave/door/window", "Microwave/door/handle",
        "Microwave/tray", "Microwave/body/control_panel/button",
    } <= lineages  # fmt: skip
    assert not any(name.endswith(("body/door", "body/handle")) for name in lineages)


def test_a_handle_in_a_template_is_of_what_carries_it() -> None:
    batch = Session.of("StorageFurniture").sampler.batch(np.arange(4), seed=1)
    handles = [p["lineage"] for a in describe(batch, gripper=None) for p in a["parts"] if p["semantic"] == "handle"]
    assert handles and all("/drawer/handle" in name or "/door/handle" in name for name in handles)


def test_directions_are_those_of_the_joint(batch: Batch) -> None:
    found = interactions(batch)
    assert (np.diff(found.owner) >= 0).all() and {"affordance.pull", "affordance.press"} <= set(found.name)
    values = batch.rest()
    step = 1e-6
    turn, shift = batch.pose(values)
    place = np.einsum("kij,kj->ki", turn[found.link], found.point) + shift[found.link]
    direction, speed = directions(twist(batch, values), found.link, place)
    for row, joint in enumerate(found.joint):
        nudged = values.copy()
        nudged[joint] += step
        turned, shifted = (array[found.link[row]] for array in batch.pose(nudged))
        moved = (turned @ found.point[row] + shifted - place[row]) / step
        assert moved == pytest.approx(np.nan_to_num(direction[row]) * speed[row], abs=1e-5)


@pytest.mark.parametrize("category", sorted(categories()) if EVERY else ["Faucet", "Foldingrack", "Window"])
def test_one_can_act_on_all_that_moves(category: str) -> None:
    """Every moving link bears an affordance, or carries one that does."""
    idle = set()
    for annotation in describe(Session.of(category).sampler.batch(np.arange(12), seed=5), gripper=None):
        above = {joint["child"]: joint["parent"] for joint in annotation["joints"]}
        reached = set()
        for link in {entry["link"] for entry in annotation["interactions"]}:
            while link in above:
                reached.add(link)
                link = above[link]
        idle |= set(above) - reached
    assert not idle


def test_a_shut_door_is_pulled_and_an_open_one_pushed(batch: Batch) -> None:
    told = describe(batch, np.stack([batch.rest(), opened(batch, 1.0)]))
    seen = 0
    for annotation in told:
        for k, entry in enumerate(annotation["interactions"]):
            shut, open_ = (state["interactions"][k] for state in annotation["states"])
            assert entry["travel"] == shut["travel"] and entry["direction"] == shut["direction"]
            if entry["affordance"] == "affordance.pull":
                seen += 1
                assert entry["joint"] == "open" and entry["direction"][0] > 0.9  # to the front
                assert shut["travel"][0] == 0 and shut["travel"][1] > 1.5 and open_["travel"][1] == 0
            if entry["affordance"] == "affordance.turn":
                assert entry["direction"] is None and entry["speed"] == 0
            if entry["affordance"] == "affordance.press":
                assert entry["direction"] == [-1, 0, 0] and entry["speed"] == 1
    assert seen > 6


def test_states_are_chosen_by_the_names_of_joints(batch: Batch) -> None:
    joints = batch.joints()
    values = joint_values(batch, read_states("rest,open=45deg+spin=0.25turn,open=50%"))
    named = np.array([name for name in joints.name])
    assert values[1][named == "open"] == pytest.approx(np.pi / 4)
    assert values[1][named == "spin"] == pytest.approx(np.pi / 2)
    assert values[2][named == "open"] == pytest.approx(joints.high[named == "open"] / 2)
    other = ~np.isin(named, ["open", "spin"])
    assert (values[1][other] == values[0][other]).all()
    assert joint_values(batch, read_states("open=300deg"))[0][named == "open"] == pytest.approx(
        joints.high[named == "open"]
    )
    for text in ("opem=45deg", "open=45cm"):
        with pytest.raises(UsageError) as caught:
            joint_values(batch, read_states(text))
        assert "open" in (caught.value.hint or "")
