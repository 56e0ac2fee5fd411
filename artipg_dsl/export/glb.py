"""Binary glTF 2.0: a node per link and per primitive, named, with materials, and an animation that opens every joint.

glTF is y up with z to the front; a node on top, ``<object>``, turns the object (z up, x front) into that frame, all
nodes below are in the object's own axes. The joint that moves a link is in the node's ``extras``.
"""

from __future__ import annotations

import json
import struct
from collections.abc import Iterator, Sequence
from itertools import accumulate, pairwise
from typing import Any

import numpy as np

from ..robot.materials import to_linear
from ..robot.model import Robot, RobotJoint
from ..robot.naming import Names
from ..robot.pose import open_values, rest_values
from ..robot.primitives import SeenMaterial
from ..robot.solids import SolidGroup
from ..runtime.motion import perpendicular_to

FLOAT, UNSIGNED_SHORT, UNSIGNED_INT = 5126, 5123, 5125
VERTICES, INDICES = 34962, 34963
_ROW = 12  # bytes of three float32
_Bounds = tuple[list[float], list[float]]
_OPENING = 3.0  # seconds: to the other end and back
_STEP = 1.6  # radians between two keys at most: viewers take the shorter way round
_PATHS = {  # what moves when a joint does
    "revolute": ("rotation",),
    "continuous": ("rotation",),
    "ball": ("rotation",),
    "prismatic": ("translation",),
    "screw": ("rotation", "translation"),
}
# the object's x (front) becomes z, y (left) becomes x, z (up) becomes y
_Z_UP_TO_Y_UP = [-0.5, -0.5, -0.5, 0.5]  # quaternion x y z w


class _Buffer:
    """The binary chunk, views of it, each on a multiple of 4 bytes, and accessors into these."""

    def __init__(self) -> None:
        self.chunks: list[bytes] = []
        self.length = 0
        self.views: list[dict[str, int]] = []
        self.accessors: list[dict[str, Any]] = []

    def view(self, array: np.ndarray, target: int | None = None, stride: int | None = None) -> int:
        """The number of a new view of what ``array`` holds."""
        data = array.tobytes()
        view = {"buffer": 0, "byteOffset": self.length, "byteLength": len(data)}
        if stride is not None:
            view["byteStride"] = stride
        if target is not None:
            view["target"] = target
        self.views.append(view)
        self.chunks.append(data + b"\0" * (-len(data) % 4))
        self.length += len(self.chunks[-1])
        return len(self.views) - 1

    def access(
        self, view: int, offset: int, count: int, kind: str, component: int = FLOAT, bounds: _Bounds | None = None
    ) -> int:
        """The number of a new accessor of ``count`` values from a byte of a view on, of which ``bounds`` are the least and the most."""
        found = {"bufferView": view, "byteOffset": offset, "componentType": component, "count": count, "type": kind}
        if bounds is not None:
            found |= {"min": bounds[0], "max": bounds[1]}
        self.accessors.append(found)
        return len(self.accessors) - 1


def glb_bytes(robot: Robot) -> bytes:
    """The whole .glb file of one object."""
    buffer = _Buffer()
    looks: dict[SeenMaterial, int] = {}
    meshes: list[dict[str, Any]] = []
    top: dict[str, Any] = {
        "name": robot.name,
        "rotation": _Z_UP_TO_Y_UP,
        "children": [1],
        "extras": {"frame": "x front, y left, z up"},
    }
    if robot.note:
        top["extras"] |= {"surface": robot.note}
    # node 0 turns the axes, node 1 + k is link k, primitives follow
    nodes: list[dict[str, Any]] = [top, *({"name": link.name} for link in robot.links)]
    links = {node["name"] for node in nodes}
    named = Names(links)
    shapes = _shapes(robot, buffer)
    for k, link in enumerate(robot.links):
        children = nodes[1 + k].setdefault("children", [])
        for visual in link.visuals:
            # the link keeps the plain name, and of several primitives of a part the first
            name = named(f"{visual.name}.solid" if visual.name in links else visual.name)
            meshes.append(
                {"name": name, "primitives": [next(shapes) | {"material": looks.setdefault(visual.look, len(looks))}]}
            )
            nodes.append({"name": name, "mesh": len(meshes) - 1, "extras": {"part": visual.name}})
            children.append(len(nodes) - 1)
    values = rest_values(robot)
    for joint in robot.joints:
        node = nodes[1 + joint.child]
        nodes[1 + joint.parent].setdefault("children", []).append(1 + joint.child)
        node |= _placement(joint, values[joint.name])
        node["extras"] = {"joint": _describe(joint)}
    for node in nodes:
        if not node.get("children", True):
            del node["children"]
    document: dict[str, Any] = {
        "asset": {"version": "2.0", "generator": "artipg_dsl"},
        "scene": 0,
        "scenes": [{"name": robot.name, "nodes": [0]}],
        "nodes": nodes,
        "meshes": meshes,
        "materials": [_material(look) for look in looks],
    }
    animation = _animation(robot, values, buffer)
    if animation["channels"]:
        document["animations"] = [animation]
    document |= {"accessors": buffer.accessors, "bufferViews": buffer.views, "buffers": [{"byteLength": buffer.length}]}
    document = {key: value for key, value in document.items() if value != []}
    return _pack(document, b"".join(buffer.chunks))


def glb_files(robot: Robot) -> dict[str, bytes]:
    """The file of one object, by its path in the object's folder."""
    return {"object.glb": glb_bytes(robot)}


def _pack(document: dict[str, Any], binary: bytes) -> bytes:
    """The container: header, JSON chunk padded with blanks, binary chunk."""
    text = json.dumps(document, separators=(",", ":"), ensure_ascii=False).encode("utf-8")
    text += b" " * (-len(text) % 4)
    chunks = struct.pack("<II", len(text), 0x4E4F534A) + text
    if binary:
        chunks += struct.pack("<II", len(binary), 0x004E4942) + binary
    return struct.pack("<III", 0x46546C67, 2, 12 + len(chunks)) + chunks


def _shapes(robot: Robot, buffer: _Buffer) -> Iterator[dict[str, Any]]:
    """What is seen, in the order of links, as primitives without a material. Corners, normals and faces of all lie together; faces that are
    the same are there once."""
    seen = [(visual.item.group, visual.item.k, link.origin) for link in robot.links for visual in link.visuals]
    if not seen:
        return
    points = [group.vertices[k][group.shading.source] - origin for group, k, origin in seen]
    position = np.concatenate(points).astype("<f4")
    normal = np.concatenate([group.shading.normals[k] for group, k, _ in seen]).astype("<f4") + np.float32(0.0)
    start = [0, *accumulate(map(len, points))]
    low, high = (best.reduceat(position, start[:-1]).tolist() for best in (np.minimum, np.maximum))
    corners, normals = (buffer.view(array, VERTICES, _ROW) for array in (position, normal))
    indices = _indices([group for group, _, _ in seen], buffer)
    for k, (begin, end) in enumerate(pairwise(start)):
        place = _ROW * begin, end - begin, "VEC3"
        attributes = {
            "POSITION": buffer.access(corners, *place, bounds=(low[k], high[k])),
            "NORMAL": buffer.access(normals, *place),
        }
        yield {"attributes": attributes, "indices": indices[id(seen[k][0])]}


def _indices(groups: Sequence[SolidGroup], buffer: _Buffer) -> dict[int, int]:
    """The accessor of the faces of each group, by its id."""
    found = {}
    distinct = {id(group): group for group in groups}
    for component, kind in ((UNSIGNED_SHORT, np.dtype("<u2")), (UNSIGNED_INT, np.dtype("<u4"))):
        own = [
            (key, group.shading.faces.ravel())
            for key, group in distinct.items()
            if (len(group.shading.source) < 0xFFFF) == (component == UNSIGNED_SHORT)
        ]
        if own:
            view = buffer.view(np.concatenate([faces for _, faces in own]).astype(kind), INDICES)
            ends = accumulate(len(faces) for _, faces in own)
            for (key, faces), end in zip(own, ends, strict=True):
                begin = kind.itemsize * (end - len(faces))
                found[key] = buffer.access(view, begin, len(faces), "SCALAR", component)
    return found


def _material(look: SeenMaterial) -> dict[str, Any]:
    colour = np.round(to_linear(np.array(look.colour)), 6).tolist()
    material: dict[str, Any] = {
        "name": look.name,
        "pbrMetallicRoughness": {
            "baseColorFactor": [*colour, round(look.opacity, 6)],
            "metallicFactor": look.metalness,
            "roughnessFactor": look.roughness,
        },
    }
    if look.opacity < 1.0:
        material |= {"alphaMode": "BLEND", "doubleSided": True}
    return material


def _placement(joint: RobotJoint, value: float) -> dict[str, Any]:
    """Translation and rotation of the child link's node in its parent's, at a joint value."""
    values = np.array([value])
    place: dict[str, Any] = {"translation": _short(_translations(joint, values)[0])}
    if not joint.traits.slides and value != 0.0:
        place["rotation"] = _short(_turns(joint, values)[0])
    return place


def _translations(joint: RobotJoint, values: np.ndarray) -> np.ndarray:
    """Origins (n, 3) of the child link in the parent's frame."""
    if joint.advance is None:
        return np.broadcast_to(joint.origin, (len(values), 3))
    return joint.origin + joint.advance * values[:, None] * joint.axis


def _turns(joint: RobotJoint, values: np.ndarray) -> np.ndarray:
    """Quaternions (n, 4), x y z w, of the child link in the parent's frame."""
    half = values / 2
    axis = perpendicular_to(joint.axis[None])[0] if joint.traits.tilts else joint.axis  # a ball's value is its tilt
    return np.concatenate([np.sin(half)[:, None] * axis, np.cos(half)[:, None]], axis=1)


def _short(values: np.ndarray) -> list[float]:
    return [round(value * 1e9) / 1e9 for value in values.tolist()]  # as NumPy rounds


def _describe(joint: RobotJoint) -> dict[str, Any]:
    described: dict[str, Any] = {
        "name": joint.name,
        "type": joint.kind,
        "axis": _short(joint.axis),
        "origin": _short(joint.origin),
        "limits": None if joint.low is None or joint.high is None else _short(np.array([joint.low, joint.high])),
        "rest": round(joint.rest, 9),
    }
    if joint.traits.advances:
        described["pitch"] = round(joint.pitch, 9)  # metres per turn
    if joint.positions:
        described["positions"] = joint.positions
    if joint.mimic is not None:
        described["mimic"] = {"joint": joint.mimic[0], "multiplier": joint.mimic[1], "offset": joint.mimic[2]}
        if joint.curve is not None:
            described["mimic"]["curve"] = dict(zip(("lead", "value"), map(_short, joint.curve), strict=True))
    if joint.gates:
        described["when"] = [
            {"joint": name, "from": low if np.isfinite(low) else None, "to": high if np.isfinite(high) else None}
            for name, low, high in joint.gates
        ]
    return described


def _course(joint: RobotJoint, start: float, end: float, endless: bool) -> np.ndarray:
    """The values of a joint at the keys of the animation, evenly apart in time: there and, unless it goes on, back."""
    steps = 4 if joint.traits.slides else max(4, int(np.ceil(abs(end - start) / _STEP)))
    there = np.arange(steps + 1) / steps
    if endless:
        share = np.arange(2 * steps + 1) / (2 * steps)
    else:
        share = np.concatenate([there, there[-2::-1]])
    return start + (end - start) * share


def _animation(robot: Robot, rest: dict[str, float], buffer: _Buffer) -> dict[str, Any]:
    """Every joint from rest to its other end and back; a continuous one by a full turn."""
    samplers: list[dict[str, Any]] = []
    channels: list[dict[str, Any]] = []
    ends, by_name = open_values(robot), {joint.name: joint for joint in robot.joints}
    clocks: dict[int, int] = {}
    for joint in robot.joints:
        if joint.kind not in _PATHS:
            continue
        lead = joint if joint.mimic is None else by_name[joint.mimic[0]]  # what follows goes on and back as that does
        moved = joint if joint.curve is None else lead
        values = _course(moved, rest[moved.name], ends[moved.name], lead.traits.endless)
        if joint.curve is not None:
            values = joint.following(values)
        if len(values) not in clocks:
            times = np.arange(len(values)) * (_OPENING / (len(values) - 1))
            clock = times.astype("<f4")
            span = [float(clock.min())], [float(clock.max())]
            clocks[len(values)] = buffer.access(buffer.view(clock), 0, len(clock), "SCALAR", bounds=span)
        for path in _PATHS[joint.kind]:
            keys, kind = (_translations, "VEC3") if path == "translation" else (_turns, "VEC4")
            way = buffer.view(keys(joint, values).astype("<f4"))
            output = buffer.access(way, 0, len(values), kind)
            samplers.append({"input": clocks[len(values)], "interpolation": "LINEAR", "output": output})
            channels.append({"sampler": len(samplers) - 1, "target": {"node": 1 + joint.child, "path": path}})
    return {"name": "open", "samplers": samplers, "channels": channels}
