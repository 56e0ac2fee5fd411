"""The tree of semantic parts, and which way affordances move."""

from __future__ import annotations

import os

import numpy as np
import pytest

from artipg_dsl.annotate.annotation import annotate
from artipg_dsl.annotate.cloud import sample_points
from artipg_dsl.annotate.interactions import directions_of, find_interactions
from artipg_dsl.annotate.rebind import rebind
from artipg_dsl.annotate.sampling import Sampling
from artipg_dsl.annotate.states import joint_twist, joint_values, open_values, read_states
from artipg_dsl.errors import UsageError
from artipg_dsl.export.shards import point_arrays
from artipg_dsl.runtime.batch import Batch
from artipg_dsl.session import Session, categories
from artipg_dsl.source import Source

EVERY = os.environ.get("ARTIPG_EVERY") == "1"  # all categories, not only a few


@pytest.fixture(scope="module")
def batch() -> Batch:
    return Session.of("Microwave").sampler.batch(np.arange(12), seed=1)


def test_the_handle_of_the_door_of_the_microwave(batch: Batch) -> None:
    lineages = set()
    for annotation in annotate(batch):
        parts = annotation["parts"]
        for part in parts:
            assert (part["lineage"] is None) == (part["semantic"] is None)
            if part["lineage"] is None:
                continue
            lineages.add(part["lineage"])
            above = "Microwave" if part["of"] is None else parts[part["of"]]["lineage"]
            assert part["lineage"] == f"{above}/{part['semantic']}"
    assert {
        "Microwave/body",
        "Microwave/body/cavity",
        "Microwave/door",
        "Microwave/door/window",
        "Microwave/door/handle",
        "Microwave/tray",
        "Microwave/body/control_panel/button",
    } <= lineages
    assert not any(name.endswith(("body/door", "body/handle")) for name in lineages)


def test_a_handle_in_a_template_is_of_what_carries_it() -> None:
    batch = Session.of("StorageFurniture").sampler.batch(np.arange(4), seed=1)
    handles = [p["lineage"] for a in annotate(batch, gripper=None) for p in a["parts"] if p["semantic"] == "handle"]
    assert handles and all("/drawer/handle" in name or "/door/handle" in name for name in handles)


def test_directions_are_those_of_the_joint(batch: Batch) -> None:
    found = find_interactions(batch)
    assert (np.diff(found.owner) >= 0).all() and {"affordance.pull", "affordance.press"} <= set(found.name)
    values = batch.rest()
    step = 1e-6
    turn, shift = batch.pose(values)
    place = np.einsum("kij,kj->ki", turn[found.link], found.point) + shift[found.link]
    direction, speed = directions_of(joint_twist(batch, values), found.joint, place)
    for row, joint in enumerate(found.joint):
        nudged = values.copy()
        nudged[joint] += step
        turned, shifted = (array[found.link[row]] for array in batch.pose(nudged))
        moved = (turned @ found.point[row] + shifted - place[row]) / step
        assert moved == pytest.approx(np.nan_to_num(direction[row]) * speed[row], abs=1e-5)


@pytest.mark.parametrize("category", sorted(categories()) if EVERY else ["Faucet", "Foldingrack", "Window"])
def test_one_can_act_on_all_that_moves(category: str) -> None:
    """Every moving link bears an affordance, or carries one that does, or goes with another: bolts with the wheel that draws them."""
    idle = set()
    for annotation in annotate(Session.of(category).sampler.batch(np.arange(12), seed=5), gripper=None):
        above = {joint["child"]: joint["parent"] for joint in annotation["joints"]}
        follows = {joint["child"] for joint in annotation["joints"] if joint["mimic"] or joint["type"] == "fixed"}
        reached = set()
        for link in {entry["link"] for entry in annotation["interactions"]}:
            while link in above:
                reached.add(link)
                link = above[link]
        idle |= set(above) - reached - follows
    assert not idle


GUARDED = """apg 1
use primitives   { Cuboid, Cylinder }
use vocabularies { semantic, affordance }
template Knob {
  part stem : Cylinder(radius = 5mm, height = 2cm)
  part head : Cylinder(radius = 2cm, height = 2cm)
  connect head.bottom on stem.top
  label affordance.turn on head
}
category Chest {
  root part body : Cuboid(size = [20cm, 40cm, 20cm])
  part lid : Cuboid(size = [20cm, 40cm, 2cm])
  joint open : revolute body.top -> lid.bottom gap 1mm about lid.back.bottom range 0deg .. 90deg
  param kind : choice plain | knobbed
  part knob : Knob
  connect knob.bottom on lid.top
  part core : Cuboid(size = [2cm, 2cm, 1cm])
  align core.center = lid.center
  connect core to lid
  label affordance.grasp on core                       # within the lid: no hand comes there
  label affordance.open on knob                        # its head says `turn`, its stem keeps this
  label affordance.press on knob.head                  # holds beside `turn`, of the same depth
  label affordance.push on lid where p.z > size.z      # nowhere
  label affordance.pull on lid where p.x > 0.499 * size.x and p.y > 0
  when kind == plain {
    label affordance.lift on lid
    label semantic.lid on lid
  } else {
    label semantic.top on lid
  }
}
"""


def test_interactions_are_what_the_surface_bears() -> None:
    batch = Session(Source("chest.apg", GUARDED), None).sampler.batch(np.arange(8), seed=1)
    plain = [batch.drawn(k)["kind"] == "plain" for k in range(8)]
    assert len(set(plain)) == 2
    for annotation, lifted in zip(annotate(batch), plain, strict=True):
        told = sorted(entry["affordance"].split(".")[1] for entry in annotation["interactions"])
        assert told == ["lift"] * lifted + ["open", "press", "pull", "turn"]
        words = {part["path"]: part["semantic"] for part in annotation["parts"]}
        assert words["lid"] == ("lid" if lifted else "top"), "a guarded label is the part's word where it holds"


def test_a_label_for_a_joint_holds_where_that_joint_is() -> None:
    head, tail = (
        GUARDED.rstrip().removesuffix("}"),
        """
  part dial : Cylinder(radius = 2cm, height = 1cm)
  align dial.bottom = lid.top + 1mm
  align dial.center.y = lid.left - 5cm
  when kind == plain {
    joint twist : continuous lid -> dial about dial.axis
  } else {
    connect dial to lid
    allow floating dial because "glued"
  }
  label affordance.turn for twist on dial
}
""",
    )
    batch = Session(Source("chest.apg", head + tail), None).sampler.batch(np.arange(8), seed=1)
    for k, annotation in enumerate(annotate(batch)):
        turned = [entry["link"] for entry in annotation["interactions"] if entry["affordance"] == "affordance.turn"]
        twists = batch.drawn(k)["kind"] == "plain"
        assert sorted(turned) == ["dial"] * twists + ["lid"], "the knob; the lid's joint does not turn the dial"


@pytest.mark.parametrize("category", sorted(categories()) if EVERY else ["Door", "Window", "USB"])
def test_shipped_interactions_are_found_on_points(category: str) -> None:
    """On each link that moves, the affordances of the annotation are those of its points, both ways."""
    batch = Session.of(category).sampler.batch(np.arange(10), seed=4)
    points = sample_points(batch, Sampling(3000, per="link"))
    names = batch.links().name
    first = np.searchsorted(batch.links().owner, np.arange(len(batch)))
    for k, annotation in enumerate(annotate(batch, gripper=None)):
        moving = {joint["child"] for joint in annotation["joints"] if joint["type"] != "fixed"}
        told = {(entry["link"], entry["affordance"]) for entry in annotation["interactions"]}
        rows = np.flatnonzero(points.object == k)
        link = [names[first[k] + points.link[row, 0]] for row in rows]
        found = {
            (name, word)
            for name, row in zip(link, rows, strict=True)
            for word, values in points.labels.items()
            if word.split(".")[0] != "field" and (values[row] > 0).any() and name in moving
        }
        shown = {entry for entry in told if entry[0] in link}  # a link may show too little to have points
        assert shown == found


TWO = """apg 1
use primitives   { Cuboid, Cylinder }
use vocabularies { semantic, affordance }
category Jar {
  root part body : Cylinder(radius = 5cm, height = 10cm)
  part stem : Cylinder(radius = 1cm, height = 3cm)
  joint raise : prismatic body.top -> stem.bottom gap 1mm along z range 0 .. 5cm
  part lid : Cuboid(size = [10cm, 10cm, 1cm])
  joint swing : revolute stem.top -> lid.bottom gap 1mm range 0deg .. 90deg
  part knob : Cylinder(radius = 5mm, height = 1cm)
  connect knob.bottom on lid.top at center
  label affordance.lift on lid
  label affordance.turn on lid
  label affordance.push for raise on lid
  label affordance.close for swing on lid
  label affordance.pull on lid where pulls(raise)
  label affordance.press on lid.bottom where pushes(raise)
  label affordance.grasp on lid
  label affordance.roll on stem
}
"""


def test_a_label_is_for_a_joint_of_several_in_a_row() -> None:
    batch = Session(Source("jar.apg", TWO), None).sampler.batch(np.arange(2), seed=0)
    up = [0.0, 0.0, 1.0]
    wanted = {
        "lift": ("raise", up),
        "turn": ("swing", None),
        "push": ("raise", up),
        "close": ("swing", None),
        "pull": ("raise", up),
        "press": ("raise", up),
        "grasp": ("swing", None),
        "roll": ("raise", up),
    }
    for annotation in annotate(batch):
        told = {e["affordance"].split(".")[1]: (e["joint"], e["direction"]) for e in annotation["interactions"]}
        assert told == wanted
    points = sample_points(batch, 400, motion=True)
    numbers = {name: k for k, name in enumerate(["raise", "swing"])}
    assert points.acting is not None and points.drivers is not None and points.velocities is not None
    for word, (joint, _) in wanted.items():
        holds, found = points.labels[f"affordance.{word}"] > 0, points.acting[f"affordance.{word}"]
        assert holds.any() and np.array_equal(found, np.where(holds, numbers[joint], -1)), word
    lifted = points.acting["affordance.lift"] == 0
    column = np.argmax(points.drivers[lifted] == 0, axis=1)
    assert points.velocities[lifted][np.arange(len(column)), column] == pytest.approx(np.tile(up, (len(column), 1)))
    arrays = point_arrays(batch, 100, motion=True)
    assert arrays["affordance.lift.joint"].dtype == np.uint16 and set(np.unique(arrays["affordance.lift.joint"])) == {
        0,
        65535,
    }
    back = rebind(batch, points, motion=True)
    assert back.acting is not None and all(np.array_equal(back.acting[n], points.acting[n]) for n in points.acting)


def test_what_a_formula_asks_about_is_what_a_door_is_pushed_by() -> None:
    """A handle of a door turns on it: it is the door that is pushed, by the handle or not."""
    batch = Session.of("Door").sampler.batch(np.arange(12), seed=3)
    joints = {
        (entry["affordance"], entry["joint"].split(".")[-1])
        for annotation in annotate(batch, gripper=None)
        for entry in annotation["interactions"]
        if ".letters" not in entry["joint"]
    }
    assert {joint for word, joint in joints if word in ("affordance.push", "affordance.close")} == {"open"}


def test_a_shut_door_is_pulled_and_an_open_one_pushed(batch: Batch) -> None:
    told = annotate(batch, np.stack([batch.rest(), open_values(batch, 1.0)]))
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
    farthest = joint_values(batch, read_states("open=120deg"))[0][named == "open"]  # of any object: clipped in most
    assert farthest == pytest.approx(joints.high[named == "open"])
    for text in ("opem=45deg", "open=45cm"):
        with pytest.raises(UsageError) as caught:
            joint_values(batch, read_states(text))
        assert "open" in (caught.value.hint or "")
