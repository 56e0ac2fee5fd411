"""CAGE and SINGAPO: the tree of the links that move, each with its box, its joint and its mesh.

As these have made it of PartNet-Mobility: all joints at the end where the object is shut, ranges from 0 on, in the raw frame (y up, z to
the front, the half diagonal 1). Handles on what moves are nodes of their own; other fixed parts belong to what carries them.
"""

from __future__ import annotations

import hashlib
import json
from collections.abc import Iterator, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from ..errors import UserError
from ..export.partnet.frame import DatasetFrame
from ..records import dataclass
from ..robot.model import RobotJoint
from ..robot.primitives import Shape
from ..robot.robots import Robots
from .clouds import partnet_axes
from .entry import SPLITS, Entry
from .findings import Findings
from .pieces import Pieces, Shut
from .ply import ply_bytes, read_ply
from .words import Term

if TYPE_CHECKING:
    from ..runtime.batch import Batch

_PARTS = ("door", "drawer", "base", "handle", "wheel", "knob", "shelf", "tray")
MOST = 32  # nodes: CAGE's loader fails at more, SINGAPO's leaves such objects out
_STILL: dict[str, Any] = {"type": "fixed", "range": [0.0, 0.0], "axis": {"origin": [0.0] * 3, "direction": [0.0] * 3}}


def _shut_values(robots: Robots) -> np.ndarray:
    """Values (J,) of all joints of a batch with which objects are shut."""
    rows = [joint for i in range(len(robots.batch)) for joint in robots.robot(i).joints]
    return np.array([Shut.of(joint).value for joint in rows])


@dataclass(slots=True)
class Node:
    """``shapes`` are in the raw frame."""

    name: str
    parent: int
    joint: dict[str, Any]
    shapes: list[Shape]


def nodes(batch: Batch, term: Term) -> Iterator[list[Node]]:
    """The tree of each object, the base first, then what moves, then handles."""
    robots = Robots(batch, physics=False)
    turn, shift = batch.pose(_shut_values(robots))
    for i in range(len(batch)):
        own = slice(int(robots.link_start[i]), int(robots.link_start[i + 1]))
        yield _Tree(Pieces(robots, i, term), turn[own], shift[own]).nodes()


class _Tree:
    """An object whose links stand with turns (L, 3, 3) and shifts (L, 3) as where it is shut."""

    def __init__(self, pieces: Pieces, turn: np.ndarray, shift: np.ndarray):
        self.pieces, self.turn, self.shift = pieces, turn, shift
        seen = [self.place(shape.vertices, link) for link in range(len(turn)) for _, shape in pieces.of(link)]
        corners = np.concatenate(seen)
        self.frame = DatasetFrame.around(corners.min(axis=0), corners.max(axis=0))

    def place(self, points: np.ndarray, link: int) -> np.ndarray:
        return points @ self.turn[link].T + self.shift[link]

    def raw(self, shape: Shape, link: int) -> Shape:
        return Shape(shape.name, self.frame.points(self.place(shape.vertices, link)), shape.faces)

    def nodes(self) -> list[Node]:
        pieces, made, at = self.pieces, list[Node](), dict[int, int]()
        joints, moving = {joint.child: joint for joint in pieces.robot.joints}, pieces.moving()
        handles = []
        for link in _downwards(len(pieces.robot.links), joints):
            joint = joints.get(link)
            if joint is None or link in moving:
                at[link] = len(made)
                parent = -1 if joint is None else at[joint.parent]
                made.append(Node(moving.get(link, "base"), parent, self._joint(joint), []))
            else:
                at[link] = at[joint.parent]
            apart = pieces.apart(link) if at[link] else []
            for k in apart:
                shapes = [self.raw(shape, link) for own, shape in pieces.of(link) if own == k]
                handles.append(Node(pieces.term.parts[pieces.word(k)], at[link], _STILL, shapes))
            made[at[link]].shapes += [self.raw(shape, link) for own, shape in pieces.of(link) if own not in apart]
        return made + handles

    def _joint(self, joint: RobotJoint | None) -> dict[str, Any]:
        if joint is None or not joint.traits.axis:
            return _STILL
        shut, turn = Shut.of(joint), self.turn[joint.parent]
        kind, advance = joint.hinge, joint.advance
        reach = np.degrees(shut.reach) if advance is None else shut.reach * abs(advance) / self.frame.unit
        sign = shut.sign * np.copysign(1.0, advance or 1.0)  # a left-handed screw goes against its axis
        whole = joint.origin + self.pieces.robot.links[joint.parent].origin
        return {
            "type": kind,
            "range": [0.0, 0.0 if kind == "continuous" else _short(np.array(reach))],
            "axis": {
                "origin": _short(self.frame.points(self.place(whole, joint.parent))),
                "direction": _short(partnet_axes(turn @ joint.axis * sign)),
            },
        }


def _short(values: np.ndarray) -> Any:
    return (np.round(values, 9) + 0.0).tolist()


def _downwards(count: int, joints: dict[int, RobotJoint]) -> list[int]:
    """Links, each after the one that carries it."""

    def depth(link: int) -> int:
        return 0 if link not in joints else 1 + depth(joints[link].parent)

    return sorted(range(count), key=lambda link: (depth(link), link))


def tree_hash(parents: Sequence[int]) -> str:
    """The hash of a tree's form by Weisfeiler and Lehman: equal for trees that differ in the numbers of their nodes alone."""
    count = np.bincount([p for p in parents if p >= 0], minlength=len(parents)) + np.array([p >= 0 for p in parents])
    labels, seen = [str(k) for k in count.tolist()], []
    for _ in range(3):
        labels = [_digest(label + (labels[p] if p >= 0 else "")) for label, p in zip(labels, parents, strict=True)]
        tally = {label: labels.count(label) for label in sorted(set(labels))}
        seen.extend(sorted(tally.items()))
    return _digest(str(tuple(seen)))


def _digest(text: str) -> str:
    return hashlib.blake2b(text.encode("ascii"), digest_size=16).hexdigest()


def _described(made: Sequence[Node], category: str) -> dict[str, Any]:
    """What ``train.json`` says of an object."""
    tree = []
    for k, node in enumerate(made):
        corners = np.concatenate([np.zeros((0, 3)), *(shape.vertices for shape in node.shapes)])
        low, high = (corners.min(axis=0), corners.max(axis=0)) if len(corners) else (np.zeros(3), np.zeros(3))
        tree.append(
            {
                "id": k,
                "parent": node.parent,
                "name": node.name,
                "children": [c for c, other in enumerate(made) if other.parent == k],
                "joint": node.joint,
                "aabb": {"center": _short((low + high) / 2), "size": _short(high - low)},
                "objs": [f"plys/node-{k}.ply"],  # as CAGE calls them
                "plys": [f"plys/node-{k}.ply"],  # as SINGAPO does
            }
        )
    return {"meta": {"obj_cat": category, "tree_hash": tree_hash([node.parent for node in made])}, "diffuse_tree": tree}


def _fits(made: Sequence[Node]) -> bool:
    """Whether anything moves, as in all objects of the data set (metrics take the mean over what does), and loaders take the nodes."""
    return 1 < len(made) <= MOST


def files(batch: Batch, entry: Entry, shard: int) -> Iterator[tuple[str, bytes]]:
    """``<category>/<object>/train.json``, ``object.json``, which is the same, and ``plys/`` of the objects that fit."""
    assert entry.term is not None
    for number, made in zip(batch.numbers.tolist(), nodes(batch, entry.term), strict=True):
        if not _fits(made):
            continue
        root = f"{entry.term.name}/{entry.token(number)}"
        text = (json.dumps(_described(made, entry.term.name), indent=1) + "\n").encode()
        yield f"{root}/train.json", text
        yield f"{root}/object.json", text
        for k, node in enumerate(made):
            yield f"{root}/plys/node-{k}.ply", ply_bytes(node.shapes)


def index(entries: Sequence[Entry], folder: Path) -> dict[str, bytes]:
    """``data_split.json``, the objects of each split, and ``hash_table.json``, by class and form of the tree. Raises UserError where
    no object of a category is fit."""
    listed: dict[str, list[str]] = {split: [] for split in SPLITS}
    forms: dict[str, dict[str, list[str]]] = {}
    for entry in entries:
        assert entry.term is not None
        own = forms.setdefault(entry.term.name, {})
        before = sum(map(len, listed.values()))
        for split in SPLITS:
            for name in (f"{entry.term.name}/{token}" for token in entry.tokens(split)):
                path = folder / name / "train.json"
                if path.exists():
                    listed[split].append(name)
                    own.setdefault(json.loads(path.read_bytes())["meta"]["tree_hash"], []).append(name)
        if sum(map(len, listed.values())) == before:
            raise UserError(
                f"no object of {entry.category} has 2 to {MOST} nodes: a base and what moves",
                "more objects (-n), or a --map with other parts",
            )
    tables = {"data_split.json": listed, "hash_table.json": forms}
    return {name: (json.dumps(table, indent=1) + "\n").encode() for name, table in tables.items()}


def check_term(term: Term) -> str | None:
    """What is wrong with a map, if anything: it names no part, or one that there is not."""
    if not term.parts:
        return "no word of it is a part"
    unknown = [part for part in term.parts.values() if part not in _PARTS]
    return f"there is no part `{unknown[0]}`: the parts are {', '.join(_PARTS)}" if unknown else None


# ---------------------------------------------------------------- reading back


def check(folder: Path, entry: Entry, batch: Batch, shard: int, found: Findings) -> None:
    """Read as loaders do, and compare with the model."""
    assert entry.term is not None
    listed, forms = (json.loads((folder / f"{name}.json").read_text("utf-8")) for name in ("data_split", "hash_table"))
    for number, made in zip(batch.numbers.tolist(), nodes(batch, entry.term), strict=True):
        name = f"{entry.term.name}/{entry.token(number)}"
        if not _fits(made):
            found.of(
                name, name not in listed[entry.split(number)], f"in a list, with {len(made)} nodes, not 2 to {MOST}"
            )
            continue
        found.of(name, name in listed[entry.split(number)], "not in the list of its split")
        form = tree_hash([node.parent for node in made])
        found.of(name, name in forms[entry.term.name].get(form, ()), "not in the table by the form of its tree")
        read = json.loads((folder / name / "train.json").read_text("utf-8"))
        found.of(
            name, read["meta"] == _described(made, entry.term.name)["meta"], "another category or form of the tree"
        )
        tree = read["diffuse_tree"]
        found.of(name, len(tree) == len(made), f"{len(tree)} nodes, not {len(made)}")
        for k, (node, ours) in enumerate(zip(tree, made, strict=False)):
            _check_node(f"{name} node {k}", folder / name, node, k, ours, found)


def _check_node(name: str, folder: Path, node: dict[str, Any], k: int, ours: Node, found: Findings) -> None:
    found.of(name, (node["id"], node["parent"]) == (k, ours.parent), "its number or its parent is another")
    found.of(name, node["name"] in _PARTS and node["name"] == ours.name, f"{node['name']} instead of {ours.name}")
    joint = node["joint"]
    found.of(name, joint["type"] == ours.joint["type"], f"{joint['type']} instead of {ours.joint['type']}")
    found.of(name, joint["range"][0] == 0, "its range does not begin at 0")
    for what in ("origin", "direction"):
        found.near(name, what, np.array(joint["axis"][what]), np.array(ours.joint["axis"][what]), 1e-6)
    found.near(name, "range", np.array(joint["range"]), np.array(ours.joint["range"]), 1e-6)
    found.of(name, node["plys"] == node["objs"], "other meshes for SINGAPO")
    corners = np.concatenate([read_ply(folder / obj) for obj in node["objs"]])
    center, size = np.array(node["aabb"]["center"]), np.array(node["aabb"]["size"])
    found.of(name, float(np.abs(center).max() + size.max() / 2) < 2.1, "beyond the raw frame")
    if len(corners):
        box, ends = (
            np.stack([center - size / 2, center + size / 2]),
            np.stack([corners.min(axis=0), corners.max(axis=0)]),
        )
        found.near(name, "box of its mesh", ends, box, 1e-5)
        found.near(name, "mesh", corners, np.concatenate([shape.vertices for shape in ours.shapes]), 1e-5)
