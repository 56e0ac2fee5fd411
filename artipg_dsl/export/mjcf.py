"""MJCF for MuJoCo 3.3.3 and later: the object fixed to the world, the same free to move, and a scene with a floor for each.

What is seen are OBJ meshes, what collides are boxes, round bars and convex hulls given by their points. A screw is a hinge and
a slide on one axis, tied by an equality; a joint that follows another is tied in the same way, and so is a loop where it closes.
"""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.polynomial import Polynomial

from ..native.digits import print_blocks
from ..robot.adjacent import find_adjacent
from ..robot.model import Robot, RobotJoint
from ..robot.naming import Names
from ..robot.pose import link_poses, rest_values
from ..robot.primitives import Collider
from ..runtime.motion import perpendicular_to
from . import decimals
from .decimals import rows
from .lacking import refuse_coupled_balls, refuse_joints
from .mesh_obj import link_meshes
from .template import find_template

_TYPES = {
    "revolute": "hinge",
    "continuous": "hinge",
    "screw": "hinge",
    "prismatic": "slide",
    "ball": "ball",
    "fixed": "",
}
_DIGITS = 10  # significant ones
_ADVANCE = "_advance"  # a screw's slide is named after the screw


def mjcf_files(robot: Robot) -> dict[str, bytes]:
    """``object.xml`` (fixed base), ``object_free.xml`` and a scene with a floor for each, with meshes in ``meshes/``.

    Raises ExportError for a kind of joint that MuJoCo does not have, and for a ball that follows or is followed.
    """
    model = _Model(robot)
    files = dict(model.files)
    low, high = _bounds(robot)
    center, extent = (low + high) / 2, float(np.max(high - low))
    write: Any = find_template("object.mjcf.j2").module
    shared = {
        "assets": write.assets(**model.assets),
        "inside": write.inside(model.root),
        "rules": write.rules(**model.rules),
    }
    for end, base in (("", ""), ("_free", model.base)):
        text = write.model(robot.name, robot.note, root=model.root, free=base, rest=model.rest(bool(base)), **shared)
        files[f"object{end}.xml"] = (text + "\n").encode("utf-8")
        scene = find_template("scene.mjcf.j2").render(
            name=robot.name,
            file=f"object{end}.xml",
            center=numbers(center),
            extent=f"{max(extent, 0.01):.6g}",
            lamp=numbers(center + 2 * extent * np.array([0.4, 0.3, 0.87])),
        )
        files[f"scene{end}.xml"] = (scene + "\n").encode("utf-8")
    return files


class _Model:
    """What the template is filled with."""

    def __init__(self, robot: Robot):
        self.robot = robot
        self.files: dict[str, bytes] = {}
        self.meshes: dict[str, str] = {}
        self.hulls: dict[str, str] = {}
        self._same_hull: dict[str, str] = {}
        self.couplings: list[dict[str, str]] = []
        refuse_joints(robot, _TYPES, "MuJoCo", "mjcf")
        refuse_coupled_balls(robot, "MuJoCo", "mjcf")
        below: dict[int, list[RobotJoint]] = {}
        for joint in robot.joints:
            below.setdefault(joint.parent, []).append(joint)
        self.advances = {screw: slide for slide, screw in advances(robot).items()}
        looks = {visual.look.name: visual.look for link in robot.links for visual in link.visuals}
        self._seen, self._points = link_meshes(robot), _hull_points(robot)
        every = [collider for link in robot.links for collider in link.colliders]
        center = rows(np.array([collider.center for collider in every]).reshape(-1, 3), _DIGITS)
        turn = rows(np.array([collider.turn for collider in every]).reshape(-1, 4), _DIGITS)
        self._places = {c.full: {"pos": pos, "quat": quat} for c, pos, quat in zip(every, center, turn, strict=True)}
        self.root = self._body(0, None, below)
        self.order = self._joint_order(self.root)
        self.base = Names(self.order)(f"{robot.links[0].name}_free")  # the joint of a base that is free to move
        self.assets: dict[str, Any] = {
            "looks": [
                {
                    "name": name,
                    "rgba": numbers([*look.colour, look.opacity]),
                    "metallic": f"{look.metalness:.6g}",
                    "roughness": f"{look.roughness:.6g}",
                }
                for name, look in looks.items()
            ],
            "meshes": self.meshes,
            "hulls": self.hulls,
        }
        self.rules: dict[str, Any] = {
            "excludes": find_adjacent(robot),
            "couplings": self.couplings,
            "gates": [
                {"name": f"when_{joint.name}", "data": "; ".join(_waiting(*gate) for gate in joint.gates)}
                for joint in robot.joints
                if joint.gates
            ],
            "positions": [
                {"name": f"positions_{joint.name}", "data": joint.positions}
                for joint in robot.joints
                if joint.positions
            ],
            "closures": [
                {"name": f"closure_{n}", "site1": f"closure_{n}_a", "site2": f"closure_{n}_b"}
                for n in range(len(robot.closures))
            ],
        }

    def _body(self, k: int, above: RobotJoint | None, below: dict[int, list[RobotJoint]]) -> dict[str, Any]:
        link = self.robot.links[k]
        visuals = []
        for name, look, data in self._seen[link.name]:
            file = f"meshes/{name}.obj"
            self.files[file], self.meshes[name] = data, file
            visuals.append({"name": name, "material": look.name})
        i = link.inertia
        return {
            "name": link.name,
            "pos": numbers(link.origin if above is None else above.origin),
            "center": numbers(link.center),
            "mass": f"{link.mass:.9g}",
            "inertia": " ".join(f"{v:.9g}" for v in (i[0, 0], i[1, 1], i[2, 2], i[0, 1], i[0, 2], i[1, 2])),
            "joints": [] if above is None else self._joints(above),
            "visuals": visuals,
            "sites": [
                {"name": f"closure_{n}_{side}", "pos": numbers(point)}
                for n, closure in enumerate(self.robot.closures)
                for side, at, point in zip("ab", closure.links, closure.points, strict=True)
                if at == k
            ],
            "pieces": [self._piece(collider) for collider in link.colliders],
            "children": [self._body(joint.child, joint, below) for joint in below.get(k, [])],
        }

    def _joints(self, joint: RobotJoint) -> list[dict[str, str]]:
        kind = _TYPES[joint.kind]
        if not kind:
            return []
        entry = {"name": joint.name, "type": kind}
        if kind != "ball":
            entry["axis"] = numbers(joint.axis)
            if joint.limited and not joint.traits.endless:
                entry["range"] = numbers([joint.low, joint.high])
            entry["actuatorfrcrange"] = numbers([-joint.effort, joint.effort])
        elif joint.high is not None and joint.high > 0:
            entry["range"] = numbers([0.0, joint.high])
        entry |= {
            "damping": f"{joint.damping:.9g}",
            "frictionloss": f"{joint.friction:.9g}",
            "armature": f"{joint.armature:.9g}",
        }
        if joint.stiffness:
            entry |= {"stiffness": f"{joint.stiffness:.9g}", "springref": f"{joint.rest:.9g}"}
        made = [entry]
        if joint.traits.advances:
            slide = self.advances[joint.name]
            made.append({"name": slide, "type": "slide", "axis": numbers(joint.axis)})
            self._couple(slide, joint.name, 0.0, joint.pitch / (2 * np.pi))
        if joint.mimic is not None:
            leader, multiplier, offset = joint.mimic
            coefficients = [offset, multiplier]
            if joint.curve is not None:  # MuJoCo couples joints by a polynomial of the fourth degree
                coefficients = Polynomial.fit(*joint.curve, 4).convert().coef.astype(np.float64).tolist()
            self._couple(joint.name, leader, *coefficients)
        return made

    def _couple(self, follower: str, leader: str, *coefficients: float) -> None:
        """The follower is at a polynomial of its leader's value: offset, multiplier and what else there is of five coefficients."""
        given = " ".join(f"{c:.9g}" for c in (*coefficients, *[0.0] * (5 - len(coefficients))))
        self.couplings.append({"name": follower, "joint1": follower, "joint2": leader, "polycoef": given})

    def _piece(self, collider: Collider) -> dict[str, str]:
        name = collider.full
        dynamic = sum(collider.material.friction_dynamic) / 2
        entry = {"name": f"{name}_collision", "class": "collision", "friction": f"{dynamic:.6g} 0.005 0.0001"}
        placed = self._places[name]
        if collider.size is not None:
            return entry | {"type": "box", "size": numbers(np.array(collider.size) / 2)} | placed
        if collider.bar is not None:
            sizes = [collider.bar.radius, *([collider.bar.length / 2] if collider.bar.kind != "sphere" else [])]
            return entry | {"type": collider.bar.kind, "size": numbers(sizes)} | placed
        middle, points = self._points[name]
        mesh = self._same_hull.setdefault(points, f"{name}_hull")
        self.hulls[mesh] = points
        return entry | {"type": "mesh", "mesh": mesh, "pos": middle}

    def _joint_order(self, body: dict[str, Any]) -> list[str]:
        """Names of joints as MuJoCo orders them: depth first."""
        return [j["name"] for j in body["joints"]] + [n for child in body["children"] for n in self._joint_order(child)]

    def rest(self, free: bool) -> str:
        """``qpos`` with every joint at rest: numbers in MuJoCo's order, a ball's as a quaternion, the free base's first."""
        values: list[float] = [*self.robot.links[0].origin.tolist(), 1.0, 0.0, 0.0, 0.0] if free else []
        return numbers([*values, *qpos(self.robot, rest_values(self.robot), self.order)]) if self.order or free else ""


def _hull_points(robot: Robot) -> dict[str, tuple[str, str]]:
    """By the collider that is a hull, its middle and the points about it: equal ones (the keys of a pad) share a mesh."""
    met = {c.full: c.hull for link in robot.links for c in link.colliders if c.size is None and c.bar is None}
    points = [hull.vertices for hull in met.values() if hull is not None]
    if not points:
        return {}
    every, counts = np.concatenate(points), np.array(list(map(len, points)))
    start = np.cumsum([0, *counts])
    low, high = (best.reduceat(every, start[:-1]) for best in (np.minimum, np.maximum))
    middle = np.round((low + high) / 2, 9)
    about = np.round(every - middle.repeat(counts, axis=0), 9)
    lines = print_blocks(np.round(about, 12) + 0.0, start.tolist(), f"%.{_DIGITS}g", ("", " ", " ", "\n"))
    texts = [text[:-1].replace("\n", " ") for text in lines]
    return dict(zip(met, zip(rows(middle, _DIGITS), texts, strict=True), strict=True))


def _waiting(name: str, low: float, high: float) -> str:
    """What a joint waits for, in words: MuJoCo keeps them and acts on none."""
    ends = [f"{sign} {end:.9g}" for sign, end in ((">=", low), ("<=", high)) if np.isfinite(end)]
    return " and ".join(f"{name} {end}" for end in ends)


def advances(robot: Robot) -> dict[str, str]:
    """The slides of screws by name, each with its screw's: a joint of the object may have the first name that comes to mind."""
    names = Names(joint.name for joint in robot.joints)
    return {names(joint.name + _ADVANCE): joint.name for joint in robot.joints if joint.traits.advances}


def qpos(robot: Robot, values: dict[str, float], order: list[str]) -> list[float]:
    """What MuJoCo calls a state: the numbers of the joints ``order`` at the joint ``values``."""
    joints, slides = {joint.name: joint for joint in robot.joints}, advances(robot)
    numbers: list[float] = []
    for name in order:
        joint = joints.get(name)
        if joint is None:  # a screw's slide
            screw = joints[slides[name]]
            numbers.append(values[screw.name] * screw.pitch / (2 * np.pi))
        elif joint.traits.tilts:
            half = values[name] / 2
            numbers += [float(np.cos(half)), *(np.sin(half) * perpendicular_to(joint.axis[None])[0]).tolist()]
        else:
            numbers.append(values[name])
    return numbers


def _bounds(robot: Robot) -> tuple[np.ndarray, np.ndarray]:
    """The box (3,), (3,) of what is seen, with the joints at 0."""
    poses = link_poses(robot, {joint.name: 0.0 for joint in robot.joints})
    seen = [(visual, pose[1]) for link, pose in zip(robot.links, poses, strict=True) for visual in link.visuals]
    if not seen:
        return np.zeros(3), np.zeros(3)
    ends = np.array([[end[v.item.k] for end in v.item.group.ends] for v, _ in seen])  # (n, 2, 3)
    ends = ends - np.array([v.origin for v, _ in seen])[:, None] + np.array([shift for _, shift in seen])[:, None]
    return ends[:, 0].min(axis=0), ends[:, 1].max(axis=0)


def numbers(values: Any) -> str:
    """Numbers with ten significant digits and a blank between."""
    return decimals.numbers(values, _DIGITS)
