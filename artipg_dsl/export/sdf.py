"""SDFormat 1.11 with OBJ meshes, as Gazebo and Drake read it: every kind of joint as it is, followers and loops too."""

from __future__ import annotations

from typing import Any

import numpy as np

from ..annotate.frames import euler
from ..records import dataclass
from ..robot.model import Robot, RobotJoint, RobotLink
from ..robot.pose import link_poses
from ..robot.primitives import Collider
from .decimals import numbers, rows
from .lacking import refuse_coupled_balls, refuse_joints
from .mesh_obj import Mesh, link_meshes, piece_meshes
from .template import find_template
from .write import ExportError

_KINDS = ("revolute", "continuous", "prismatic", "screw", "ball", "fixed")
_DIGITS = 10  # significant ones
_APART = 1e-6  # metres: points of a loop that are farther apart do not meet


def sdf_files(robot: Robot) -> dict[str, bytes]:
    """``model.sdf``, ``model.config`` (which Gazebo finds models by) and the meshes of both in ``meshes/``.

    Raises ExportError for a joint that SDFormat does not have, for a ball that follows or is followed, and for loops that are
    not closed with all joints at 0, where SDFormat has its joints begin.
    """
    refuse_joints(robot, _KINDS, "SDFormat", "sdf")
    refuse_coupled_balls(robot, "SDFormat", "sdf")
    files: dict[str, bytes] = {}
    pieces: dict[bytes, str] = {}
    told = _Told.of(robot)
    links = [_link(link, told, files, pieces) for link in robot.links]
    joints = [*(_joint(joint, robot) for joint in robot.joints), *_closures(robot)]
    text = find_template("model.sdf.j2").render(name=robot.name, links=links, joints=joints)
    files["model.sdf"] = (text + "\n").encode("utf-8")
    files["model.config"] = (find_template("model.config.j2").render(name=robot.name) + "\n").encode("utf-8")
    return files


@dataclass(frozen=True, slots=True)
class _Told:
    """What is written of all links at once: meshes to be seen by the link, by the collider its mesh and where it stands."""

    seen: dict[str, list[Mesh]]
    met: dict[str, bytes]
    poses: dict[str, str]

    @staticmethod
    def of(robot: Robot) -> _Told:
        every = [collider for link in robot.links for collider in link.colliders]
        center = np.array([collider.center for collider in every]).reshape(-1, 3)
        turn = euler(np.array([collider.rotation for collider in every]).reshape(-1, 3, 3))
        poses = rows(np.concatenate([center, turn], axis=1), _DIGITS)
        plain = piece_meshes(robot, lambda collider: collider.size is not None or collider.bar is not None)
        return _Told(link_meshes(robot), plain, dict(zip((c.full for c in every), poses, strict=True)))


def _link(link: RobotLink, told: _Told, files: dict[str, bytes], pieces: dict[bytes, str]) -> dict[str, Any]:
    visuals = []
    for name, look, data in told.seen[link.name]:
        files[f"meshes/{name}.obj"] = data
        entry = {"name": name, "file": f"meshes/{name}.obj", "colour": _numbers([*look.colour, look.opacity])}
        entry |= {"metalness": f"{look.metalness:.6g}", "roughness": f"{look.roughness:.6g}"}
        visuals.append(entry | {"transparency": f"{1.0 - look.opacity:.6g}"})
    cells = [("ixx", 0, 0), ("ixy", 0, 1), ("ixz", 0, 2), ("iyy", 1, 1), ("iyz", 1, 2), ("izz", 2, 2)]
    return {
        "name": link.name,
        "pose": _numbers(link.origin),
        "center": _numbers(link.center),
        "mass": f"{link.mass:.9g}",
        "inertia": {name: f"{link.inertia[i, j]:.9g}" for name, i, j in cells},
        "visuals": visuals,
        "colliders": [_collider(c, told, files, pieces) for c in link.colliders],
    }


def _collider(collider: Collider, told: _Told, files: dict[str, bytes], pieces: dict[bytes, str]) -> dict[str, Any]:
    material, name = collider.material, collider.full
    entry: dict[str, Any] = {
        "name": f"{name}_collision",
        "pose": told.poses[name],
        "friction": f"{sum(material.friction_dynamic) / 2:.6g}",
        "restitution": f"{sum(material.restitution) / 2:.6g}",
    }
    if collider.size is not None:
        return entry | {"shape": "box", "sizes": {"size": _numbers(collider.size)}}
    if collider.bar is not None:
        sizes = {"radius": _numbers([collider.bar.radius])}
        if collider.bar.kind != "sphere":
            sizes["length"] = _numbers([collider.bar.length])
        return entry | {"shape": collider.bar.kind, "sizes": sizes}
    mesh = told.met[name]
    file = pieces.setdefault(mesh, f"meshes/{name}.collision.obj")  # equal pieces share a file
    files[file] = mesh
    return entry | {"pose": "0 0 0 0 0 0", "shape": "mesh", "sizes": {"uri": file}}


def _joint(joint: RobotJoint, robot: Robot) -> dict[str, Any]:
    """A joint; its frame is that of its child, whose axes are those of the object with all joints at 0."""
    kind = joint.hinge
    entry: dict[str, Any] = {
        "name": joint.name,
        "kind": kind,
        "parent": robot.links[joint.parent].name,
        "child": robot.links[joint.child].name,
        "pose": "",
        "pitch": f"{joint.pitch:.9g}" if joint.traits.advances else "",
        "axis": None,
    }
    if not joint.traits.axis:
        return entry
    limit = {"effort": f"{joint.effort:.9g}", "velocity": f"{joint.velocity:.9g}"}
    if joint.limited and kind != "continuous":
        limit = {"lower": f"{joint.low:.9g}", "upper": f"{joint.high:.9g}"} | limit
    dynamics = {"damping": f"{joint.damping:.9g}", "friction": f"{joint.friction:.9g}"}
    if joint.stiffness:
        dynamics |= {"spring_reference": f"{joint.rest:.9g}", "spring_stiffness": f"{joint.stiffness:.9g}"}
    mimic = None
    if joint.mimic is not None:  # q = multiplier * (q of the leader - reference) + offset
        leader, multiplier, offset = joint.mimic
        mimic = {"joint": leader, "multiplier": f"{multiplier:.9g}", "offset": f"{offset:.9g}"}
    return entry | {"axis": {"xyz": _numbers(joint.axis), "limit": limit, "dynamics": dynamics, "mimic": mimic}}


def _closures(robot: Robot) -> list[dict[str, Any]]:
    """A ball joint where a loop closes, at its point of the second link."""
    poses = link_poses(robot, {joint.name: 0.0 for joint in robot.joints}) if robot.closures else []
    found = []
    for n, closure in enumerate(robot.closures):
        one, other = (poses[k][1] + point for k, point in zip(closure.links, closure.points, strict=True))
        if np.abs(one - other).max() > _APART:
            raise ExportError(
                f"{robot.name}: a loop through {robot.links[closure.links[0]].name} is open with all joints at 0",
                "SDFormat starts its joints there: close the loop at 0, or leave sdf out of --format",
            )
        ends = {key: robot.links[k].name for key, k in zip(("parent", "child"), closure.links, strict=True)}
        entry: dict[str, Any] = {
            "name": f"closure_{n}",
            "kind": "ball",
            "pose": _numbers(closure.points[1]),
            "pitch": "",
            "axis": None,
        }
        found.append(entry | ends)
    return found


def _numbers(values: Any) -> str:
    """Numbers with ten significant digits and a blank between."""
    return numbers(values, _DIGITS)
