"""The words of PartNet-Mobility: of categories, of links and of the parts in the tree."""

from __future__ import annotations

import json
import os
import re
from pathlib import Path
from xml.etree import ElementTree

import pytest

from artipg_dsl import load, sample
from artipg_dsl.export.partnet.mobility import partnet_files
from artipg_dsl.export.partnet.words import CATEGORIES, link_label, spell_category, to_snake_case
from artipg_dsl.export.registry import FORMATS
from artipg_dsl.robot.robots import Robots

EVERY = os.environ.get("ARTIPG_EVERY") == "1"
PARTNET = {
    "StorageFurniture": """storage_furniture storage_furniture/cabinet countertop shelf cabinet_frame cabinet_frame/vertical_divider_panel
        cabinet_frame/frame_vertical_bar cabinet_frame/frame_horizontal_bar
        cabinet_base cabinet_base/foot_base cabinet_base/foot_base/foot cabinet_base/foot_base/caster cabinet_base/foot_base/caster/wheel
        cabinet_base/foot_base/caster/caster_yoke drawer drawer/drawer_box drawer/handle cabinet_door cabinet_door/cabinet_door_surface
        cabinet_door/glass cabinet_door/handle""",
    "Chair": """chair chair chair_seat chair_seat/seat_surface chair_back chair_back/back_surface chair_back/back_connector chair_arm chair_base
        chair_base/regular_leg_base chair_base/regular_leg_base/leg chair_base/regular_leg_base/foot
        chair_base/regular_leg_base/bar_stretcher chair_base/regular_leg_base/seat_connector chair_base/star_leg_base
        chair_base/star_leg_base/central_support
        chair_base/star_leg_base/seat_connector chair_base/star_leg_base/star_leg_set chair_base/star_leg_base/star_leg_set/leg
        chair_base/star_leg_base/star_leg_set/foot chair_base/star_leg_base/star_leg_set/caster
        chair_base/star_leg_base/star_leg_set/caster/caster_yoke chair_base/star_leg_base/star_leg_set/caster/wheel chair_base/pedestal_base
        chair_base/pedestal_base/central_support chair_base/pedestal_base/pedestal chair_base/pedestal_base/seat_connector""",
    "Microwave": """microwave microwave body body/frame body/body_interior body/body_interior/tray body/door body/door/door_frame
        body/door/glass body/door/handle body/side_controls body/side_controls/control_button body/side_controls/display_panel base
        base/foot_base base/foot_base/foot""",
    "Door": """door_set door_set outside_frame hinge door door/door_body door/door_body/surface_board door/door_body/glass
        door/door_body/complex_decoration door/handle door/handle/fixed_part door/handle/movable_part""",
}


@pytest.mark.parametrize("name", sorted(PARTNET) if EVERY else sorted(PARTNET)[::2])
def test_the_part_tree_is_in_the_words_of_partnet(name: str) -> None:
    """Walked as the data set's merging does: the names from the top down are a path of the vocabulary at every node."""
    top, root, *below = PARTNET[name].split()
    known = {top, root, *(f"{root}/{path}" for path in below)}
    batch = sample(name, 5, seed=7, checked=False).batch
    for i in range(5):
        files = partnet_files(Robots(batch), i)
        (tree,) = json.loads(files["result.json"])
        ids, met, stems = [], set(), []

        def walk(node: dict, above: str) -> None:
            path = f"{above}/{node['name']}" if above else node["name"]
            assert path in known, path
            met.add(path)  # noqa: B023
            ids.append(node["id"])  # noqa: B023
            stems.extend(node.get("objs", []))  # noqa: B023
            assert ("objs" in node) != bool(node.get("children"))
            for child in node.get("children", []):
                walk(child, path)

        walk(tree, "")
        assert len(ids) == len(set(ids)) and len(met) > 4 and len(stems) == len(set(stems))
        doors = [m for m in json.loads(files["mobility_v2.json"]) if m["name"].endswith(("door", "drawer"))]
        if name == "StorageFurniture":  # one node for each that moves
            text = json.dumps(tree)
            assert text.count('"name": "cabinet_door"') + text.count('"name": "drawer"') == len(doors)


@pytest.mark.parametrize(
    ("name", "labels"), [("Faucet", {"switch", "spout", "outlet", "knob"}), ("Oven", {"door", "dial", "tray"})]
)
def test_a_link_without_a_class_has_that_of_what_is_on_it(name: str, labels: set[str]) -> None:
    """Hubs and grips of levers, racks: readers look for the words of the category."""
    batch = sample(name, 4, seed=7, checked=False).batch
    for i in range(4):
        rows = partnet_files(Robots(batch), i, points=False)["semantics.txt"].decode().splitlines()[:-1]
        assert {row.split()[2] for row in rows} <= labels | {"drawer", "button"}, rows


def test_handles_are_found_by_name(tmp_path: Path) -> None:
    (path,) = sample("StorageFurniture", numbers=[0], seed=7).export(tmp_path, "partnet-mobility")
    urdf = ElementTree.parse(path / "mobility.urdf").getroot()
    mobility = json.loads((path / "mobility_v2.json").read_text())
    held = [
        link.attrib["name"]
        for link in urdf.findall("link")
        if any("handle" in v.attrib["name"] for v in link.iter("visual"))
    ]
    moving = [f"link_{e['id']}" for e in mobility if e["name"] in ("drawer", "rotation_door")]
    assert moving and set(moving) & set(held)


def test_words() -> None:
    assert spell_category("Trashcan") == "TrashCan" and spell_category("washing_machine") == "WashingMachine"
    assert spell_category("Foldingrack") == "Foldingrack" and len(CATEGORIES) == 46
    assert (
        to_snake_case("pad.row[1].key") == "pad_row_1_key" and to_snake_case("StorageFurniture") == "storage_furniture"
    )
    assert link_label("StorageFurniture", "door", "revolute") == "rotation_door"
    assert link_label("Microwave", "door", "revolute") == "door"
    assert FORMATS["partnet-mobility"].file == "mobility.urdf"


WORDS_BY_OBJECT = """apg 1
use primitives { Cuboid }
use vocabularies { semantic }
template Door {
  part leaf : Cuboid(size = [1cm, 20cm, 20cm])
  part pin : Cuboid(size = [1cm, 1cm, 20cm])
  align pin.right = leaf.left
  label semantic.hinge on leaf
}
category Words {
  param k : choice a | b
  root part body : Cuboid(size = [20cm, 60cm, 30cm])
  part door : Door
  joint open : revolute body.front -> door.back gap 1mm at center about door.leaf.left.back range 0deg .. 90deg
  label semantic.body on body
  when k == a { label semantic.door on door } else { label semantic.lid on door }
}
"""


@pytest.mark.parametrize(("k", "word"), [("a", "door"), ("b", "lid")])
def test_a_link_has_the_word_of_its_part_in_this_object(k: str, word: str, tmp_path: Path) -> None:
    """Not that of another branch of a `when`, nor that of the first mesh on it."""
    made = load(WORDS_BY_OBJECT, set={"k": k}, checked=False)
    (folder,) = made.export(tmp_path, "partnet-mobility,usd")
    assert (folder / "semantics.txt").read_text().splitlines()[0] == f"link_0 hinge {word}"
    link = (folder / "object.usda").read_text().partition('def Xform "door"')[2]
    assert re.findall("semantics:labels:class = (.*)", link)[:2] == [f'["{word}"]', '["hinge"]']
