"""Robots (URDF) as real objects: their visible meshes, each by the name of its link, and how their links move."""

from __future__ import annotations

import math
from pathlib import Path
from typing import Any
from xml.etree import ElementTree

import numpy as np

from ..errors import UserError
from ..records import dataclass
from .bodies import Bodies, twists
from .meshes import load_meshes

_MOVES = {"revolute": "turns", "continuous": "turns", "prismatic": "slides"}  # others have no axis of their own


@dataclass(frozen=True, slots=True, eq=False)
class Robot:
    """The visible ``meshes`` of a URDF with its joints at 0, each by the name of its link. ``body``: of the links that move on the way from the
    root to the one of a name the first, or nothing, ``twist`` (6,) how that moves, by name, and ``joint`` the name of what moves it."""

    meshes: list[tuple[str, Any]]
    body: dict[str, str]
    twist: dict[str, np.ndarray]
    joint: dict[str, str]

    def bodies(self, names: tuple[str, ...]) -> Bodies | None:
        """What links of some names belong to; None if none of them moves."""
        every = list(dict.fromkeys(self.body[name] for name in names))
        twist = np.array([self.twist[body] for body in every]).reshape(-1, 6)
        of = np.array([every.index(self.body[name]) for name in names])
        return Bodies(of, twist, tuple(self.joint[body] for body in every)) if twist.any() else None


def read_robot(path: Path) -> Robot:
    """The meshes and the motion of a URDF. Raises UserError where it has nothing to see."""
    import trimesh  # start-up: what reads no meshes starts without it

    root = ElementTree.parse(path).getroot()
    above: dict[str, ElementTree.Element] = {}
    for joint in root.iter("joint"):
        child = joint.find("child")
        if child is not None:
            above[child.get("link", "")] = joint
    found = Robot([], {}, {}, {})
    for link in root.iter("link"):
        name, matrix, body, twist, mover = link.get("name", ""), np.eye(4), "", np.zeros(6), ""
        for below, joint in _chain(name, above):
            matrix = matrix @ _origin(joint)
            if not body and joint.get("type", "fixed") != "fixed":
                body, twist, mover = below, _twist(joint, matrix), joint.get("name", "")
        found.body[name], found.twist[body], found.joint[body] = body, twist, mover
        for visual in link.iter("visual"):
            for mesh in _shapes(visual, path, trimesh):
                mesh.apply_transform(matrix @ _origin(visual))
                found.meshes.append((name, mesh))
    if not found.meshes:
        raise UserError(
            f"{path.name} has no visible shapes", "a <visual> with a mesh, box, cylinder or sphere is needed"
        )
    return found


def _chain(name: str, above: dict[str, ElementTree.Element]) -> list[tuple[str, ElementTree.Element]]:
    """The joints between the root and a link, each with the link below it."""
    found: list[tuple[str, ElementTree.Element]] = []
    at: str | None = name
    while at is not None and at in above and all(at != below for below, _ in found):
        found.append((at, above[at]))
        parent = above[at].find("parent")
        at = None if parent is None else parent.get("link")
    return found[::-1]


def _twist(joint: ElementTree.Element, matrix: np.ndarray) -> np.ndarray:
    """(6,) of a joint whose frame ``matrix`` is."""
    of = joint.find("axis")
    axis = matrix[:3, :3] @ np.array((1.0, 0.0, 0.0) if of is None else _numbers(of, "xyz", 3))
    length = float(np.sqrt((axis**2).sum()))
    moves = _MOVES.get(joint.get("type", ""), "tilts") if length > 0.0 else "tilts"
    return twists(np.array([moves]), axis[None] / (length or 1.0), matrix[None, :3, 3])[0]


def mesh_of(mesh: ElementTree.Element, path: Path) -> tuple[str, Path]:
    """What a <mesh> of a URDF names, and where it is, if it is there."""
    name = mesh.get("filename", "").split("://")[-1]
    places = (path.parent / name, *(above / name for above in path.parents))
    return name, next((place for place in places if place.is_file()), places[0])


def _shapes(visual: ElementTree.Element, path: Path, trimesh: Any) -> list[Any]:
    shape = visual.find("geometry")
    found = []
    for one in [] if shape is None else list(shape):
        if one.tag == "mesh":
            name, file = mesh_of(one, path)
            if not file.is_file():
                raise UserError(
                    f"{path.name} names a mesh that is not there: {name or 'without a name'}",
                    "it is looked for from the folder of the file, and from those above",
                )
            scale = _numbers(one, "scale", 3, (1.0, 1.0, 1.0))
            for _, mesh in load_meshes(file):
                mesh.apply_transform(np.diag([*scale, 1.0]))
                found.append(mesh)
        elif one.tag == "box":
            found.append(trimesh.creation.box(_numbers(one, "size", 3)))
        elif one.tag == "cylinder":
            (radius,), (length,) = _numbers(one, "radius", 1), _numbers(one, "length", 1)
            found.append(trimesh.creation.cylinder(radius, length))
        elif one.tag == "sphere":
            found.append(trimesh.creation.icosphere(radius=_numbers(one, "radius", 1)[0]))
        else:
            raise UserError(
                f"{path.name} has a visible <{one.tag}>, which is no shape of a URDF",
                "a mesh, box, cylinder or sphere is one",
            )
    return found


def _numbers(
    of: ElementTree.Element, name: str, count: int, missing: tuple[float, ...] | None = None
) -> tuple[float, ...]:
    """The numbers of an attribute. Raises ValueError where there are not so many."""
    text = of.get(name)
    if text is None and missing is not None:
        return missing
    try:
        found = tuple(float(x) for x in (text or "").split())
    except ValueError:
        found = ()
    if len(found) != count or not all(map(math.isfinite, found)):
        said = "is missing" if text is None else f"is `{text}`"
        raise ValueError(
            f"`{name}` of a <{of.tag}> {said}: {'a number is' if count == 1 else f'{count} numbers are'} needed"
        )
    return found


def _origin(of: ElementTree.Element) -> np.ndarray:
    origin, matrix = of.find("origin"), np.eye(4)
    if origin is None:
        return matrix
    r, p, y = _numbers(origin, "rpy", 3, (0.0, 0.0, 0.0))
    (cr, sr), (cp, sp), (cy, sy) = ((math.cos(a), math.sin(a)) for a in (r, p, y))
    matrix[:3, :3] = [
        [cy * cp, cy * sp * sr - sy * cr, cy * sp * cr + sy * sr],
        [sy * cp, sy * sp * sr + cy * cr, sy * sp * cr - cy * sr],
        [-sp, cp * sr, cp * cr],
    ]
    matrix[:3, 3] = _numbers(origin, "xyz", 3, (0.0, 0.0, 0.0))
    return matrix
