"""URDF with OBJ meshes: one mesh per link and material to be seen, convex pieces to collide."""

from __future__ import annotations

from typing import Any

import numpy as np

from ..annotate.frames import euler
from ..records import dataclass
from ..robot.adjacent import find_adjacent
from ..robot.model import Robot, RobotJoint, RobotLink
from ..robot.primitives import Collider
from ..robot.substitute import simple_joints
from .decimals import numbers, rows
from .lacking import refuse_joints
from .mesh_obj import Mesh, link_meshes, piece_meshes
from .template import find_template

_APART = "Default"  # the word of an SRDF for pairs that no joint holds, and the only one that SAPIEN heeds
_KINDS = ("revolute", "continuous", "prismatic", "fixed")
_MOST_PAIRS = 31  # SAPIEN has a bit for each that are not parent and child
FIRST_BIT, LAST_BIT = 6, 30  # of Bullet's 32 for groups: it uses the lower ones itself


def urdf_files(robot: Robot) -> dict[str, bytes]:
    """The files of a robot by path relative to its folder: ``object.urdf``, ``object_fixed.urdf`` (on a link ``world``),
    ``object_physics.urdf`` (without what is to be seen, which SAPIEN reads only where it can render),
    ``object_independent.urdf`` (without followers, where there are any), what they refer to in ``meshes/``, and beside
    each an ``.srdf``, which says which links do not collide."""
    whole, robot = robot, simple_joints(robot)
    refuse_joints(robot, _KINDS, "URDF", "urdf")
    files: dict[str, bytes] = {}
    looks: dict[str, str] = {}
    pieces: dict[bytes, str] = {}
    pairs = _pairs(whole, robot)
    groups = _groups([(one, other) for one, other, reason in pairs if reason == _APART])
    told = _Told.of(robot)
    links = [_link(link, told, files, looks, pieces) | {"group": groups.get(link.name)} for link in robot.links]
    joints = [_joint(joint, robot) for joint in robot.joints]
    materials = [{"name": name, "rgba": rgba} for name, rgba in looks.items()]
    known = find_template("robot.srdf.j2").render(name=robot.name, pairs=pairs) + "\n"
    write: Any = find_template("robot.urdf.j2").module
    looks_of, solid = [], []
    for link in links:
        inertial, collisions = write.inertial(link), write.collisions(link)
        solid.append(write.link(link["name"], inertial + collisions))
        looks_of.append(write.link(link["name"], inertial + write.visuals(link) + collisions))
    note = [write.note(robot.note)] if robot.note else []
    seen = [*note, *map(write.material, materials)]
    fixed = [write.fixed(_unused("world", robot), links[0]["name"])]
    linked = [write.joint(joint, True) for joint in joints]
    texts = {
        "object": [*seen, *looks_of, *linked],
        "object_fixed": [*seen, *fixed, *looks_of, *linked],
        "object_physics": [*solid, *linked],
    }
    if any(joint["mimic"] for joint in joints):
        texts["object_independent"] = [*seen, *looks_of, *(write.joint(joint, False) for joint in joints)]
    for file, pieces_of in texts.items():
        files[f"{file}.urdf"] = f"{write.robot(robot.name, pieces_of)}\n".encode()
        files[f"{file}.srdf"] = known.encode()
    return files


def _unused(name: str, robot: Robot) -> str:
    """A name that no link has."""
    taken = {link.name for link in robot.links}
    while name in taken:
        name += "_"
    return name


def _pairs(whole: Robot, robot: Robot) -> list[tuple[str, str, str]]:
    """Pairs of links that do not collide, and why: parent and child in the URDF, or held together through links between."""
    held = {frozenset((robot.links[joint.parent].name, robot.links[joint.child].name)) for joint in robot.joints}
    pairs = find_adjacent(whole)
    other = [pair for pair in pairs if frozenset(pair) not in held][:_MOST_PAIRS]
    return [(*pair, "Adjacent") for pair in pairs if frozenset(pair) in held] + [(*pair, _APART) for pair in other]


def _groups(pairs: list[tuple[str, str]]) -> dict[str, dict[str, int]]:
    """Bullet's group of each link in pairs that are not to collide, and the mask of what it does collide with: PyBullet reads
    no SRDF, but these as attributes of a ``collision``. As many pairs as there are bits for their links."""
    bits: dict[str, int] = {}
    masks: dict[str, int] = {}
    for pair in pairs:
        new = [link for link in pair if link not in bits]
        if len(bits) + len(new) > LAST_BIT - FIRST_BIT + 1:
            continue
        bits |= {link: 1 << (FIRST_BIT + len(bits) + k) for k, link in enumerate(new)}
        for link, other in (pair, pair[::-1]):
            masks[link] = masks.get(link, -1) & ~bits[other]
    return {link: {"group": bits[link], "mask": masks[link]} for link in bits}


@dataclass(frozen=True, slots=True)
class _Told:
    """What is written of all links at once: meshes to be seen by the link, by the collider its mesh and where it stands."""

    seen: dict[str, list[Mesh]]
    met: dict[str, bytes]
    places: dict[str, dict[str, str]]

    @staticmethod
    def of(robot: Robot) -> _Told:
        every = [collider for link in robot.links for collider in link.colliders]
        center = rows(np.array([collider.center for collider in every]).reshape(-1, 3))
        turn = rows(euler(np.array([collider.rotation for collider in every]).reshape(-1, 3, 3)))
        places = {c.full: {"xyz": xyz, "rpy": rpy} for c, xyz, rpy in zip(every, center, turn, strict=True)}
        return _Told(link_meshes(robot), piece_meshes(robot, _is_plain), places)


def _is_plain(collider: Collider) -> bool:
    """Whether URDF has a word for its shape."""
    return collider.size is not None or (collider.bar is not None and collider.bar.kind != "capsule")


def _link(
    link: RobotLink, told: _Told, files: dict[str, bytes], looks: dict[str, str], pieces: dict[bytes, str]
) -> dict[str, Any]:
    visuals = []
    for name, look, data in told.seen[link.name]:
        looks.setdefault(look.name, numbers([*look.colour, look.opacity]))
        file = f"meshes/{name}.obj"
        files[file] = data
        visuals.append({"name": name, "file": file, "material": look.name})
    inertia = {
        name: f"{link.inertia[i, j]:.9g}"
        for name, i, j in [("ixx", 0, 0), ("ixy", 0, 1), ("ixz", 0, 2), ("iyy", 1, 1), ("iyz", 1, 2), ("izz", 2, 2)]
    }
    return {
        "name": link.name,
        "center": numbers(link.center),
        "mass": f"{link.mass:.9g}",
        "inertia": inertia,
        "visuals": visuals,
        "colliders": [_collider(c, told, files, pieces) for c in link.colliders],
    }


def _collider(collider: Collider, told: _Told, files: dict[str, bytes], pieces: dict[bytes, str]) -> dict[str, Any]:
    name = collider.full
    placed = {"name": name, **told.places[name]}
    if collider.size is not None:
        return placed | {"shape": {"kind": "box", "sizes": {"size": numbers(collider.size)}}}
    if collider.bar is not None and _is_plain(collider):
        sizes = {"radius": numbers([collider.bar.radius])}
        if not collider.bar.capped:
            sizes["length"] = numbers([collider.bar.length])
        return placed | {"shape": {"kind": collider.bar.kind, "sizes": sizes}}
    mesh = told.met[name]
    file = pieces.setdefault(mesh, f"meshes/{name}.collision.obj")  # equal pieces (the keys of a pad) share a file
    files[file] = mesh
    return {"name": name, "xyz": "0 0 0", "rpy": "0 0 0", "shape": None, "file": file}


def _joint(joint: RobotJoint, robot: Robot) -> dict[str, Any]:
    kind = joint.hinge
    limit = {"effort": f"{joint.effort:.9g}", "velocity": f"{joint.velocity:.9g}"}
    if kind != "continuous" and joint.low is not None and joint.high is not None:
        limit = {"lower": numbers([joint.low]), "upper": numbers([joint.high])} | limit
    mimic = None
    if joint.mimic is not None:
        leader, multiplier, offset = _led(joint, robot)
        mimic = {"joint": leader, "multiplier": f"{multiplier:.9g}", "offset": f"{offset:.9g}"}
    return {
        "name": joint.name,
        "kind": kind,
        "parent": robot.links[joint.parent].name,
        "child": robot.links[joint.child].name,
        "origin": numbers(joint.origin),
        "axis": numbers(joint.axis),
        "limit": limit,
        "damping": f"{joint.damping:.9g}",
        "friction": f"{joint.friction:.9g}",
        "mimic": mimic,
    }


def _led(joint: RobotJoint, robot: Robot) -> tuple[str, float, float]:
    """What a joint follows in the end: some readers do not move what follows a follower, as the slide of a screw that follows does."""
    assert joint.mimic is not None
    name, multiplier, offset = joint.mimic
    above = robot.leader(joint)
    if above is None or above.mimic is None:
        return name, multiplier, offset
    name, own, start = _led(above, robot)
    return name, multiplier * own, multiplier * start + offset
