"""Binary glTF 2.0: a node per link and per primitive, named, with materials, and an animation that opens every joint.

glTF is y up with z to the front; a node on top, ``<object>``, turns the object (z up, x front) into that frame, all
nodes below are in the object's own axes. The joint that moves a link is in the node's ``extras``.
"""

from __future__ import annotations

import json
import struct
from collections.abc import Iterator
from itertools import accumulate, pairwise
from typing import Any

import numpy as np

from ..records import dataclass
from ..runtime.motion import perpendicular_to
from .materials import to_linear
from .naming import Names
from .pose import open_values, rest_values
from .primitives import SeenMaterial, Visual
from .robot import Robot, RobotJoint

FLOAT, UNSIGNED_SHORT, UNSIGNED_INT = 5126, 5123, 5125
VERTICES, INDICES = 34962, 34963
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
    """The binary chunk and the accessors into it. Arrays are packed by kind, each view on a multiple of 4 bytes."""

    def __init__(self) -> None:
        self.chunks: list[bytes] = []
        self.length = 0
        self.views: list[dict[str, Any]] = []
        self.accessors: list[dict[str, Any]] = []

    def add(
        self,
        array: np.ndarray,
        kind: str,
        component: int,
        target: int | None = None,
        bounds: tuple[list[float], list[float]] | None = None,
    ) -> int:
        """The number of a new accessor over ``array``, of which ``bounds`` are the least and the most."""
        data = np.ascontiguousarray(array).tobytes()
        view = {"buffer": 0, "byteOffset": self.length, "byteLength": len(data)}
        if target is not None:
            view["target"] = target
        self.views.append(view)
        self.chunks.append(data + b"\0" * (-len(data) % 4))
        self.length += len(self.chunks[-1])
        count = array.size if kind == "SCALAR" else len(array)
        accessor = {"bufferView": len(self.views) - 1, "componentType": component, "count": count, "type": kind}
        if bounds is not None:
            accessor |= {"min": bounds[0], "max": bounds[1]}
        self.accessors.append(accessor)
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
    shapes = _shapes(robot)
    for k, link in enumerate(robot.links):
        children = nodes[1 + k].setdefault("children", [])
        for visual in link.visuals:
            # the link keeps the plain name, and of several primitives of a part the first
            name = named(f"{visual.name}.solid" if visual.name in links else visual.name)
            meshes.append(_mesh(visual, name, next(shapes), buffer, looks))
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


@dataclass(frozen=True, slots=True)
class _Shape:
    """Corners (n, 3), the least and the most of them, and their normals (n, 3), as float32."""

    position: np.ndarray
    bounds: tuple[list[float], list[float]]
    normal: np.ndarray


def _shapes(robot: Robot) -> Iterator[_Shape]:
    """What is seen, in the order of links; all of an object are made together."""
    seen = [(visual.item.group, visual.item.k, link.origin) for link in robot.links for visual in link.visuals]
    if not seen:
        return
    points = [group.vertices[k][group.shading.source] - origin for group, k, origin in seen]
    position = np.concatenate(points).astype("<f4")
    normal = np.concatenate([group.shading.normals[k] for group, k, _ in seen]).astype("<f4") + np.float32(0.0)
    start = [0, *accumulate(map(len, points))]
    low, high = (best.reduceat(position, start[:-1]).tolist() for best in (np.minimum, np.maximum))
    for k, (begin, end) in enumerate(pairwise(start)):
        yield _Shape(position[begin:end], (low[k], high[k]), normal[begin:end])


def _mesh(visual: Visual, name: str, shape: _Shape, buffer: _Buffer, looks: dict[SeenMaterial, int]) -> dict[str, Any]:
    small = len(shape.position) < 0xFFFF
    index = visual.item.group.shading.faces.astype("<u2" if small else "<u4").ravel()
    primitive = {
        "attributes": {
            "POSITION": buffer.add(shape.position, "VEC3", FLOAT, VERTICES, shape.bounds),
            "NORMAL": buffer.add(shape.normal, "VEC3", FLOAT, VERTICES),
        },
        "indices": buffer.add(index, "SCALAR", UNSIGNED_SHORT if small else UNSIGNED_INT, INDICES),
        "material": looks.setdefault(visual.look, len(looks)),
    }
    return {"name": name, "primitives": [primitive]}


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
            clocks[len(values)] = buffer.add(clock, "SCALAR", FLOAT, bounds=span)
        for path in _PATHS[joint.kind]:
            keys, kind = (_translations, "VEC3") if path == "translation" else (_turns, "VEC4")
            output = buffer.add(keys(joint, values).astype("<f4"), kind, FLOAT)
            samplers.append({"input": clocks[len(values)], "interpolation": "LINEAR", "output": output})
            channels.append({"sampler": len(samplers) - 1, "target": {"node": 1 + joint.child, "path": path}})
    return {"name": "open", "samplers": samplers, "channels": channels}
