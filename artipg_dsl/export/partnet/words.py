"""The words of PartNet-Mobility: names of categories, of joints and of links."""

from __future__ import annotations

import re

# as the data set spells them; a category of another name keeps its own
CATEGORIES = (
    "Bottle",
    "Box",
    "Bucket",
    "Camera",
    "Cart",
    "Chair",
    "Clock",
    "CoffeeMachine",
    "Dishwasher",
    "Dispenser",
    "Display",
    "Door",
    "Eyeglasses",
    "Fan",
    "Faucet",
    "FoldingChair",
    "Globe",
    "Kettle",
    "Keyboard",
    "KitchenPot",
    "Knife",
    "Lamp",
    "Laptop",
    "Lighter",
    "Microwave",
    "Mouse",
    "Oven",
    "Pen",
    "Phone",
    "Pliers",
    "Printer",
    "Refrigerator",
    "Remote",
    "Safe",
    "Scissors",
    "Stapler",
    "StorageFurniture",
    "Suitcase",
    "Switch",
    "Table",
    "Toaster",
    "Toilet",
    "TrashCan",
    "USB",
    "WashingMachine",
    "Window",
)
# kind of our joint: (word of semantics.txt and mobility_v2.json, type in mobility.urdf)
JOINTS = {
    "revolute": ("hinge", "revolute"),
    "continuous": ("hinge", "continuous"),
    "prismatic": ("slider", "prismatic"),
    "screw": ("slider+", "prismatic"),  # what turns as it slides; a URDF drops the turning
    "fixed": ("static", "fixed"),
    "ball": ("static", "fixed"),  # there is no word for it
}
LIFTED = 5.0  # kg: a root part below this is `free` (one takes the object in the hand), above it `heavy`
_FURNITURE = ("StorageFurniture", "Table")  # whose doors are told apart by how they move


def spell_category(name: str) -> str:
    """The data set's spelling of a category."""
    return {known.lower(): known for known in CATEGORIES}.get(name.replace("_", "").lower(), name)


def to_snake_case(name: str) -> str:
    """``StorageFurniture`` as ``storage_furniture``, ``pad.row[1].key`` as ``pad_row_1_key``: one token."""
    words = re.sub(r"(?<=[a-z0-9])(?=[A-Z])", "_", name)
    return re.sub(r"\W+", "_", words).strip("_").lower() or "part"


def root_label(name: str) -> str:
    """What the data set calls the root part: ``furniture_body``, ``oven_body``."""
    return "furniture_body" if spell_category(name) in _FURNITURE else f"{to_snake_case(name)}_body"


def link_label(category_name: str, word: str, kind: str) -> str:
    """What it calls a moving part: ours, but furniture has ``rotation_door`` and ``translation_door``."""
    label = to_snake_case(word)
    if label == "door" and spell_category(category_name) in _FURNITURE and kind != "fixed":
        return f"{'translation' if kind == 'prismatic' else 'rotation'}_door"
    return label
