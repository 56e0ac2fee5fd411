"""The folder of an object as PartNet-Mobility has it, file for file.

Frames: the data set's own is right-handed with x to the left of the object, y up, z to the front; the rest box is
centred and its half diagonal is 1. Every mesh, axis and point is in that frame, with the joints at 0; ``meta.json``
tells how many metres its unit is. The root part has the last id and is fixed to ``base``, z up and front to -x.
"""

from __future__ import annotations

import json
from functools import lru_cache
from typing import TYPE_CHECKING, Any
from weakref import WeakKeyDictionary

import numpy as np

from ...annotate.cloud import Surface, sample_surface
from ...annotate.sampling import Sampling
from ...records import dataclass
from ...robot.primitives import Shape
from ...validity.mass import heavier
from ..decimals import numbers, told, told_twice
from ..mesh_obj import move_points, mtl_text, obj_texts
from ..template import find_template
from ..write import ExportError
from .frame import DatasetFrame, to_dataset_axes
from .tree import CategoryWords, FolderLink, Leaf, build_tree, said_of, to_entry, words_of
from .words import JOINTS, LIFTED, link_label, root_label, spell_category, to_snake_case

if TYPE_CHECKING:
    from ...robot.model import Robot, RobotJoint, RobotLink
    from ...robot.primitives import Collider, SeenMaterial, Visual
    from ...robot.robots import Robots

_POINTS = 10000
_URDFS = ("mobility.urdf", "mobility_vhacd.urdf", "mobility_cvx.urdf")  # one text under the names that readers ask for
_CORNERS = np.array([[x, y, z] for x in (-0.5, 0.5) for y in (-0.5, 0.5) for z in (-0.5, 0.5)])
_BOX_FACES = np.array(
    [
        [0, 1, 3],
        [0, 3, 2],
        [4, 6, 7],
        [4, 7, 5],
        [0, 4, 5],
        [0, 5, 1],
        [2, 3, 7],
        [2, 7, 6],
        [0, 2, 6],
        [0, 6, 4],
        [1, 5, 7],
        [1, 7, 3],
    ]
)


def partnet_files(robots: Robots, i: int, points: bool = True) -> dict[str, bytes]:
    """The files of object ``i`` by path relative to its folder, with or without ``points``. Raises ExportError for joints without a
    word."""
    folder = _Folder.of(robots, i)
    files: dict[str, bytes] = {}
    drawn = _meshes(folder.robot, folder.members, folder.frame, files)
    urdf = folder.urdf(drawn)
    return files | dict.fromkeys(_URDFS, urdf) | folder.described({}) | (folder.points() if points else {})


def bare_files(robots: Robots, i: int) -> dict[str, bytes]:
    """The same without meshes, in a fraction of the time: links show nothing and collide with nothing, leaves name no files, and
    ``meta.json`` says so. There is one URDF: the others differ by what collides. Raises ExportError."""
    folder = _Folder.of(robots, i)
    urdf = folder.urdf({member.id: ([], []) for member in folder.members})
    return {_URDFS[0]: urdf} | folder.described({"meshes": "none"}) | folder.points()


@dataclass(frozen=True, slots=True)
class _Folder:
    """What the files of an object are made of."""

    robots: Robots
    i: int
    robot: Robot
    everything: np.ndarray
    frame: DatasetFrame
    words: CategoryWords | None
    members: list[FolderLink]

    @staticmethod
    def of(robots: Robots, i: int) -> _Folder:
        robot = robots.robot(i)
        everything = _everything(robot)
        frame = DatasetFrame.around(everything.min(axis=0), everything.max(axis=0))
        own = slice(int(robots.part_start[i]), int(np.searchsorted(robots.parts.owner, i, side="right")))
        said = said_of(robots.batch, i, robots.parts.semantic[own])
        words = words_of(spell_category(robots.batch.program.name), said)
        return _Folder(robots, i, robot, everything, frame, words, _members(robots, i, robot, frame, words))

    @property
    def model(self) -> str:
        """The name of the object."""
        return f"{self.robots.batch.program.name}-{self.robots.batch.seed}-{self.robot.number}"

    def urdf(self, drawn: dict[int, Any]) -> bytes:
        links = [_urdf_link(member, self.members, drawn) for member in self.members]
        return (find_template("mobility.urdf.j2").render(model=self.model, links=links) + "\n").encode()

    def described(self, more: dict[str, str]) -> dict[str, bytes]:
        """The files that tell of links, parts and the whole; ``more``: of the whole."""
        name, members = self.robots.batch.program.name, self.members
        raw = self.frame.points(self.everything)
        meta = {
            "model_id": self.model,
            "anno_id": f"{self.robot.number:06d}",
            "user_id": "artipg_dsl",
            "time_in_sec": "0",
            "version": "1",
            "model_cat": spell_category(name),
            "metres_per_unit": self.frame.unit,
        }
        return {
            "mobility_v2.json": _json([_mobility(member, members, self.frame) for member in members]),
            "semantics.txt": "".join(f"link_{m.id} {m.word} {m.label}\n" for m in members).encode(),
            "result.json": _json([_tree(name, members, self.words)]),
            "bounding_box.json": _json({"min": _short(raw.min(axis=0)), "max": _short(raw.max(axis=0))}),
            "meta.json": _json(meta | more),
        }

    def points(self) -> dict[str, bytes]:
        return _samples(self.robots, self.i, self.members, self.frame)


def folder_frame(robot: Robot) -> DatasetFrame:
    """The frame that the folder of an object is in. Raises ExportError for one that has nothing to see."""
    everything = _everything(robot)
    return DatasetFrame.around(everything.min(axis=0), everything.max(axis=0))


def folder_order(robot: Robot) -> list[int]:
    """Our numbers of the links by the folder's ids: those that move, then the root."""
    moving = {joint.child for joint in robot.joints}
    count = range(len(robot.links))
    return [k for k in count if k in moving] + [k for k in count if k not in moving]


def _everything(robot: Robot) -> np.ndarray:
    points = [visual.shape.vertices + link.origin for link in robot.links for visual in link.visuals]
    if not points:
        raise ExportError(f"{robot.name} has nothing visible", "leave partnet-mobility out of --format")
    return np.concatenate(points)


def _members(
    robots: Robots, i: int, robot: Robot, frame: DatasetFrame, words: CategoryWords | None
) -> list[FolderLink]:
    """The links by id: those that move in our order, then the root."""
    above = {joint.child: joint for joint in robot.joints}
    order = folder_order(robot)
    ids = {k: n for n, k in enumerate(order)}
    program, first = robots.batch.program, int(robots.link_start[i])
    heavy = bool(heavier(robots.batch, LIFTED)[i])
    members = []
    node = 1  # 0 is the object's own
    for k in order:
        joint, link = above.get(k), program.links[int(robots.links.definition[first + k])]
        if joint is None:
            word, kind, label = ("heavy" if heavy else "free"), "fixed", root_label(program.name)
        else:
            word, kind = _words(robot, joint)
            label = link_label(program.name, robots.link_word(i, k) or link.path.split(".")[-1], joint.kind)
        pivot = np.zeros(3) if joint is None else frame.points(robot.links[k].origin)
        parent = None if joint is None else ids[joint.parent]
        limit = None if joint is None else _limit(joint, frame)
        member = FolderLink(ids[k], k, word, kind, label, node, pivot, joint, limit, parent, {})
        node += 1
        instances = dict.fromkeys(int(v.item.group.table.instance[v.item.row]) for v in robot.links[k].visuals)
        for instance in instances:
            name, text = _leaf_name(robots, i, instance)
            path = name if words is None else words.path(name, label.rpartition("_")[2] if joint else "", text)
            name = path.replace("|", "/").rpartition("/")[2]
            member.leaves[instance] = Leaf(node, name, text, [], path)
            node += 1
        members.append(member)
    return members


def _words(robot: Robot, joint: RobotJoint) -> tuple[str, str]:
    """The word and the URDF type of a joint."""
    if joint.kind not in JOINTS or (joint.advance is not None and not joint.limited):
        what = f"a {joint.kind} joint{'' if joint.kind not in JOINTS else ' without limits'}"
        raise ExportError(
            f"{robot.name}: joint {joint.name} is {what}, which PartNet-Mobility cannot express",
            "it has hinges and sliders; leave partnet-mobility out of --format",
        )
    return JOINTS[joint.hinge]


def folder_value(joint: RobotJoint, frame: DatasetFrame) -> float:
    """What a value of 1 of a joint (radians, metres; of a screw radians) is in the folder: radians, or the frame's unit."""
    return 1.0 if joint.advance is None else joint.advance / frame.unit


def _limit(joint: RobotJoint, frame: DatasetFrame) -> tuple[float, float] | None:
    if joint.low is None or joint.high is None:
        return None
    share = folder_value(joint, frame)
    low, high = sorted((joint.low * share, joint.high * share))  # a left-handed screw goes against its axis
    return low, high


def _leaf_name(robots: Robots, i: int, instance: int) -> tuple[str, str]:
    """The name of a leaf (its class, else its own name) and its name in our tables."""
    row = int(robots.part_start[i]) + instance
    semantic, text = int(robots.parts.semantic[row]), robots.parts.name[row]
    words = robots.batch.program.vocabularies.get("semantic", ())
    return to_snake_case(words[semantic] if semantic else text.split(".")[-1]), text


def _meshes(
    robot: Robot, members: list[FolderLink], frame: DatasetFrame, files: dict[str, bytes]
) -> dict[int, tuple[list[dict[str, str]], list[str]]]:
    """Write the meshes; for each member's id, its visuals (name and file) and the files of its colliders.

    One OBJ for each material of a leaf; what collides are the convex pieces, equal ones in one file.
    """
    shown: list[tuple[str, SeenMaterial, list[Shape]]] = []
    visuals: dict[int, list[dict[str, str]]] = {}
    for member in members:
        link = robot.links[member.number]
        own: dict[tuple[int, SeenMaterial], list[Visual]] = {}
        for visual in link.visuals:
            instance = int(visual.item.group.table.instance[visual.item.row])
            own.setdefault((instance, visual.look), []).append(visual)
        visuals[member.id] = []
        rank = {instance: k for k, instance in enumerate(member.leaves)}
        for instance, look in sorted(own, key=lambda key: rank[key[0]]):
            stem, leaf = f"original-{len(shown) + 1}", member.leaves[instance]
            shown.append((stem, look, [_seen(v, link.origin) for v in own[instance, look]]))
            leaf.stems.append(stem)
            visuals[member.id].append({"name": f"{leaf.name}-{leaf.id}", "file": f"textured_objs/{stem}.obj"})
    met = [
        (member.id, _hull(c, robot.links[member.number]))
        for member in members
        for c in robot.links[member.number].colliders
    ]
    given = [(shapes, [look.name] * len(shapes)) for _, look, shapes in shown] + [([shape], []) for _, shape in met]
    names = [stem for stem, _, _ in shown] + [shape.name for _, shape in met]
    texts = obj_texts(given, frame.points, to_dataset_axes, names)
    for (stem, look, _), text in zip(shown, texts, strict=False):
        files[f"textured_objs/{stem}.obj"] = f"mtllib {stem}.mtl\n{text}".encode()
        files[f"textured_objs/{stem}.mtl"] = _material(look)
    colliders: dict[int, list[str]] = {member.id: [] for member in members}
    pieces: dict[str, str] = {}
    for (number, _), text in zip(met, texts[len(shown) :], strict=True):
        file = pieces.setdefault(text, f"textured_objs/convex-{len(pieces) + 1}.obj")
        files[file] = text.encode()
        colliders[number].append(file)
    return {member.id: (visuals[member.id], colliders[member.id]) for member in members}


def _seen(visual: Visual, origin: np.ndarray) -> Shape:
    """A visual in the object's frame."""
    shading, shape = visual.item.group.shading, visual.shape
    return Shape(visual.name, shape.vertices + origin, shape.faces, (shading.normals[visual.item.k], shading.faces))


@lru_cache(maxsize=256)
def _material(look: SeenMaterial) -> bytes:
    """The library of one material, which many files of an object repeat."""
    return mtl_text([look]).encode()


def _hull(collider: Collider, link: RobotLink) -> Shape:
    """A collider as a mesh in the object's frame."""
    if collider.hull is not None:
        return Shape("piece", collider.hull.vertices + link.origin, collider.hull.faces)
    corners = move_points(_CORNERS * np.array(collider.size), collider.rotation, collider.center)
    return Shape("piece", corners + link.origin, _BOX_FACES)


def _urdf_link(member: FolderLink, members: list[FolderLink], drawn: dict[int, Any]) -> dict[str, Any]:
    joint, visuals = member.joint, drawn[member.id]
    found: dict[str, Any] = {"id": member.id, "parent": member.parent, "type": member.type, "axis": "", "limit": None}
    found |= {"visuals": visuals[0], "colliders": visuals[1], "back": numbers(-member.pivot)}
    if joint is not None:
        found["origin"] = numbers(member.pivot - members[member.parent or 0].pivot)
    if joint is not None and member.word != "static":
        found["axis"] = numbers(to_dataset_axes(joint.axis))
        if member.type != "continuous" and member.limit is not None:
            found["limit"] = [numbers([value]) for value in member.limit]
    return found


def _gate(name: str, low: float, high: float, members: list[FolderLink], frame: DatasetFrame) -> dict[str, Any]:
    """What a joint waits for: the entry of another, and the ends between which it is open, in the unit of its limits."""
    member, joint = next((m, m.joint) for m in members if m.joint is not None and m.joint.name == name)
    unit = np.degrees(1.0) if member.word == "hinge" else folder_value(joint, frame)
    ends = zip(("from", "to"), sorted((low * unit, high * unit)), strict=True)
    return {"id": member.id} | {word: _short(np.array(end)) for word, end in ends if np.isfinite(end)}


def _mobility(member: FolderLink, members: list[FolderLink], frame: DatasetFrame) -> dict[str, Any]:
    """An entry of ``mobility_v2.json``: hinges in degrees, the rest in the data set's frame."""
    joint = member.joint
    data: dict[str, Any] = {}
    if joint is not None and member.word != "static":
        free = member.type == "continuous" or member.limit is None
        ends = np.array((-np.pi, np.pi) if free else member.limit)
        ends = np.degrees(ends) if member.word == "hinge" else ends
        data = {
            "axis": {"origin": _short(member.pivot), "direction": _short(to_dataset_axes(joint.axis))},
            "limit": {"a": _short(ends)[0], "b": _short(ends)[1], "noLimit": free},
        }
        if member.word == "slider+":
            assert joint.low is not None and joint.high is not None
            turn = _short(np.degrees(np.array(joint.high - joint.low)))
            data["limit"] |= {"rotates": True, "noRotationLimit": False, "rotationLimit": turn}
    if data and joint is not None and joint.positions:
        data["positions"] = joint.positions
    if data and joint is not None and joint.gates:
        data["enabled_when"] = [_gate(*gate, members, frame) for gate in joint.gates]
    parts = [{"id": leaf.id, "name": leaf.name, "children": []} for leaf in member.leaves.values()]
    parent = -1 if member.parent is None else member.parent
    return {
        "id": member.id,
        "parent": parent,
        "joint": member.word,
        "name": member.label,
        "parts": parts,
        "jointData": data,
    }


def _tree(name: str, members: list[FolderLink], words: CategoryWords | None) -> dict[str, Any]:
    """The part tree: that of PartNet, or the object, its links, and the leaves with their meshes."""
    if words is not None:
        return build_tree(
            words, members, 1 + max(n for m in members for n in (m.node, *(leaf.id for leaf in m.leaves.values())))
        )
    links = []
    for member in members:
        leaves = [to_entry(leaf) for leaf in member.leaves.values()]
        links.append({"id": member.node, "name": member.label, "text": member.label, "children": leaves})
    return {"id": 0, "name": to_snake_case(name), "text": name, "children": links}


def _samples(robots: Robots, i: int, members: list[FolderLink], frame: DatasetFrame) -> dict[str, bytes]:
    """``point_sample/``: points of the visible surface with normal, colour and leaf."""
    points = _points(robots)
    ids = {(m.number, instance): leaf.id for m in members for instance, leaf in m.leaves.items()}
    many = int(points.instance[i].max()) + 1
    pair = points.link[i] * many + points.instance[i]
    known = np.flatnonzero(np.bincount(pair))
    names = [str(ids[divmod(k, many)]) for k in known.tolist()]
    leaf = np.zeros(known[-1] + 1, dtype=np.int64)
    leaf[known] = np.arange(len(known))
    colours, material = np.array([look[i].colour for look in robots.looks]), points.material[i] + 1
    seen = [f"{r:.0f} {g:.0f} {b:.0f} 1" for r, g, b in np.round(255 * colours).tolist()]
    positions = frame.points(points.position[i])
    both = np.concatenate([positions, to_dataset_axes(points.normal[i])], axis=1)
    label = told(positions[:, :0], names, leaf[pair])
    everything, places = told_twice(both, 3, seen, material)
    return {
        "point_sample/pts-10000.txt": places,
        "point_sample/label-10000.txt": label,
        "point_sample/sample-points-all-pts-nor-rgba-10000.txt": everything,
        "point_sample/sample-points-all-label-10000.txt": label,
    }


_drawn: WeakKeyDictionary[Robots, Surface] = WeakKeyDictionary()


def _points(robots: Robots) -> Surface:
    """The points of all objects of a batch, drawn together, with the joints at 0."""
    found = _drawn.get(robots)
    if found is None:
        still = np.zeros(len(robots.joints.owner))
        found = _drawn[robots] = sample_surface(robots.batch, Sampling(_POINTS), still)
    return found


def _short(values: np.ndarray) -> Any:
    """Numbers with nine decimals, as plain data."""
    return (np.round(values, 9) + 0.0).tolist()


def _json(data: Any) -> bytes:
    return (json.dumps(data, separators=(", ", ": ")) + "\n").encode()
