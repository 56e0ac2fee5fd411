"""Exported objects under controllers of people who know nothing of this project: joints come to both ends, what follows follows.

What docs/formats.md promises, on one object of a few categories; ``ARTIPG_EVERY=1`` takes all of them. ``benchmarks/drive.py`` takes
more, and prints the table that is there.
"""

from __future__ import annotations

import ast
import os
from collections.abc import Iterator
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from export.fake_batch import FakeBatch

from artipg_dsl.export.mjcf import mjcf_files
from artipg_dsl.export.urdf import urdf_files
from artipg_dsl.robot.model import Robot
from artipg_dsl.robot.robots import Robots
from artipg_dsl.session import Session, categories

from .matrix import ROOT
from .strangers import __file__ as strangers
from .strangers.moves import Move, some
from .strangers.ways import WAYS, Way

# drawers, what leans, a key of a third of a millimetre, two that follow one another, loops, a screw
FEW = ["StorageFurniture", "Chair", "Laptop", "Scissors", "Foldingrack", "Bottle"]
MOST = {"Keyboard": 1}  # of its keys: all of them take an hour
PAGE = ROOT / "docs" / "formats.md"


def table() -> dict[str, list[int]]:
    """How many of three objects each of the ways brings to both ends of all joints, as the page says: by category, and of all at the end."""
    after = PAGE.read_text().partition(f"| category | {' | '.join(WAYS)} |\n")[2].partition("\n\n")[0]
    rows = ([cell.strip() for cell in row.split("|")[1:-1]] for row in after.splitlines()[1:])
    return {name: [int(count) for count in counts] for name, *counts in rows}


def told(category: str) -> list[int]:
    """Left out are categories of which all pass."""
    return table().get(category, [3] * len(WAYS))


def robot(category: str) -> Robot:
    """The first of the three that has a joint to drive."""
    robots = Robots(Session.of(category).sampler.batch(np.arange(3), 11))
    return next(one for one in map(robots.robot, range(3)) if any(j.limited and j.mimic is None for j in one.joints))


def driven(robot: Robot, way: Way, folder: Path, most: int | None = None) -> list[Move]:
    if not way.there:
        pytest.skip(f"{way.package} is not installed: pip install 'artipg_dsl[sim]'")
    for name, data in (mjcf_files if way.file.endswith(".xml") else urdf_files)(robot).items():
        (folder / name).parent.mkdir(parents=True, exist_ok=True)
        (folder / name).write_bytes(data)
    return way.drive(folder, most)


def cases() -> Iterator[tuple[str, str]]:
    for category in categories() if os.environ.get("ARTIPG_EVERY") else FEW:
        yield from ((category, way) for way, count in zip(WAYS, told(category), strict=True) if count == 3)


@pytest.mark.parametrize(("category", "way"), list(cases()))
@pytest.mark.some
def test_a_stranger_brings_joints_to_both_ends(category: str, way: str, tmp_path: Path) -> None:
    """Where the table tells so of all three objects."""
    moves = driven(robot(category), WAYS[way], tmp_path, MOST.get(category))
    assert moves
    assert not [str(move) for move in moves if not (move.reached and move.followed)]


def test_the_table_adds_up() -> None:
    *rows, (last, sums) = table().items()
    assert {name for name, _ in rows} < set(categories()) and last == f"all, of {3 * len(categories())}"
    assert sums == np.sum([told(category) for category in categories()], axis=0).tolist()


@pytest.mark.parametrize("way", WAYS)
def test_an_object_of_one_link_loads_as_any_other(way: str, tmp_path: Path) -> None:
    """SAPIEN's ``load`` takes no file without a joint."""
    whole = Robots(FakeBatch(1)).robot(0)
    assert driven(replace(whole, links=whole.links[:1], joints=()), WAYS[way], tmp_path) == []


def test_strangers_know_nothing_of_us() -> None:
    """Their modules import neither the package nor the adapters beside them."""
    for path in Path(strangers).parent.glob("*.py"):
        for node in ast.walk(ast.parse(path.read_text())):
            if isinstance(node, ast.ImportFrom):
                assert node.level <= 1 and not (node.module or "").startswith("artipg_dsl"), path
            elif isinstance(node, ast.Import):
                assert not any(name.name.startswith("artipg_dsl") for name in node.names), path


def test_a_driver_reports_what_does_not_come_to_its_end(tmp_path: Path) -> None:
    """A hinge whose friction is more than its effort does not move, and the driver says so."""
    whole = Robots(FakeBatch(1)).robot(0)
    stuck = replace(whole.joints[0], friction=10.0, effort=5.0, axis=np.array([0.0, 0.0, 1.0]))
    moves = driven(replace(whole, joints=(stuck, *whole.joints[1:])), WAYS["mujoco"], tmp_path)
    assert any(move.joint == stuck.name and not move.reached for move in moves)


@pytest.mark.parametrize("way", ["mujoco", "pybullet", "sapien"])
def test_a_driver_takes_some_of_the_joints_in_their_order(way: str, tmp_path: Path) -> None:
    whole = robot("StorageFurniture")
    free = [joint.name for joint in whole.joints if joint.limited and joint.mimic is None]
    moves = driven(whole, WAYS[way], tmp_path, most=1)
    assert [move.joint for move in moves] == 2 * some(free, 1) and len(free) > 1
    assert some(list("abcdefgh"), 2) == ["c", "g"] and some(list("ab"), 3) == ["a", "b"] == some(list("ab"), None)
