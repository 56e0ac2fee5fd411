"""OpenUSD as text (.usda) with an articulation of UsdPhysics: bodies, joints, colliders, materials.

Z up, metres, kilograms; the bodies lie side by side below one Xform, which is the articulation's root, as they are at
rest. USD counts angles of joints in degrees. Nothing but text is written, so no package is needed to write it.
"""

from __future__ import annotations

import re
from collections.abc import Iterator
from functools import lru_cache
from itertools import accumulate
from typing import Any

import numpy as np

from ..annotate.frames import quaternion
from ..native.digits import print_blocks, print_rows
from ..records import dataclass
from ..robot.adjacent import find_adjacent
from ..robot.materials import to_linear
from ..robot.model import Robot, RobotClosure, RobotJoint
from ..robot.pose import rest_poses
from ..robot.primitives import Collider, Visual
from ..robot.robots import Robots
from .decimals import numbers
from .lacking import refuse_joints
from .template import find_template

_TYPES = {
    "revolute": "PhysicsRevoluteJoint",
    "continuous": "PhysicsRevoluteJoint",
    "prismatic": "PhysicsPrismaticJoint",
    "screw": "PhysicsRevoluteJoint",  # there is no screw: it turns, and says how far it would advance
    "ball": "PhysicsSphericalJoint",
    "fixed": "PhysicsFixedJoint",
}
_NO_WORD = re.compile(r"\W", re.ASCII)
_DEGREES = float(np.degrees(1.0))
_POINT, _INDEX = ("(", ", ", ", ", ")\n"), ("", ", ")


class Names:
    """Names of prims: letters, digits and underscores, each once below one prim."""

    def __init__(self, *taken: str):
        self.taken = set(taken)

    def __call__(self, name: str) -> str:
        plain = _NO_WORD.sub("_", name)
        plain = plain if not plain[:1].isdigit() else f"_{plain}"
        found, count = plain, 1
        while found in self.taken:
            count += 1
            found = f"{plain}_{count}"
        self.taken.add(found)
        return found


def usd_files(robots: Robots, i: int) -> dict[str, bytes]:
    """``object.usda`` of object ``i``. Raises ExportError for joints that UsdPhysics cannot state."""
    robot = robots.robot(i)
    refuse_joints(robot, _TYPES, "UsdPhysics", "usd")
    words = robots.batch.program.vocabularies.get("semantic", ())
    name, bodies = Names()(robot.name), Names("Looks", "joints")
    link_names = [bodies(link.name) for link in robot.links]
    named = robots.batch.link_words[int(robots.link_start[i]) :]
    told = _Told.of(robot)
    own_links = slice(*robots.link_start[i : i + 2].tolist())
    moments, axes = (column[own_links] for column in robots.principal)
    turns, shifts = (np.stack(column) for column in zip(*rest_poses(robot), strict=True))
    columns = {
        "center": _tuples(np.stack([link.center for link in robot.links])),
        # a button's moments are tiny: significant digits, not decimals
        "moments": ["({:.9g}, {:.9g}, {:.9g})".format(*own) for own in moments.tolist()],
        "axes": _tuples(quaternion(axes)),
        "turn": _tuples(quaternion(turns)),
        "shift": _tuples(shifts),
        "name": link_names,
    }
    links = [
        _link(robot, k, words, named[k], told) | {key: column[k] for key, column in columns.items()}
        for k in range(len(robot.links))
    ]
    for link, filtered in zip(links, _filtered(robot), strict=True):
        link["filtered"] = ", ".join(f"</{name}/{link_names[other]}>" for other in filtered)
    own = Names()
    paths = {joint.name: own(joint.name) for joint in robot.joints}
    joints = [_joint(robot, joint, name, link_names, paths) for joint in robot.joints]
    joints += [
        _closure(closure, name, link_names) | {"name": own(f"closure_{n}")} for n, closure in enumerate(robot.closures)
    ]
    text = find_template("object.usda.j2").render(name=name, looks=_looks(robot), links=links, joints=joints)
    return {"object.usda": (text + "\n").encode("utf-8")}


def _filtered(robot: Robot) -> list[list[int]]:
    """For each link, those with which it is not to collide, of pairs that no joint of the file holds: those do not by themselves."""
    number = {link.name: k for k, link in enumerate(robot.links)}
    held = {frozenset((joint.parent, joint.child)) for joint in robot.joints}
    held |= {frozenset(closure.links) for closure in robot.closures}
    found: list[list[int]] = [[] for _ in robot.links]
    for names in find_adjacent(robot):
        one, other = (number[name] for name in names)
        if frozenset((one, other)) not in held:
            found[one].append(other)
    return found


def _looks(robot: Robot) -> list[dict[str, str]]:
    """The materials in use: how they look, and how they touch."""
    looks = {v.look.name: v.look for link in robot.links for v in link.visuals}
    physical = {c.material.name: c.material for link in robot.links for c in link.colliders}
    found = []
    for name, look in looks.items():
        material = physical.get(name)
        entry = {"name": _identifier(name), "colour": _vector(np.round(to_linear(np.array(look.colour)), 6))}
        entry |= {
            "metalness": f"{look.metalness:.6g}",
            "roughness": f"{look.roughness:.6g}",
            "opacity": f"{look.opacity:.6g}",
        }
        for key, pair in {
            "density": material.density if material else (0.0, 0.0),
            "static": material.friction_static if material else (0.5, 0.5),
            "dynamic": material.friction_dynamic if material else (0.4, 0.4),
            "restitution": material.restitution if material else (0.1, 0.1),
        }.items():
            entry[key] = f"{(pair[0] + pair[1]) / 2:.6g}"
        found.append(entry)
    return found


def _link(robot: Robot, k: int, words: tuple[str, ...], named: str, told: _Told) -> dict[str, Any]:
    """A body. Its class is the word of the part that it is, else that of the first mesh that has one."""
    link, names = robot.links[k], Names("colliders")
    pieces = Names()
    meshes = [_mesh(v, words) | next(told.seen) | {"name": names(v.name)} for v in link.visuals]
    labels = [label for label in (named, *(mesh["label"] for mesh in meshes)) if label]
    return {
        "title": link.name,
        "label": labels[0] if labels else "",
        "mass": f"{link.mass:.9g}",
        "meshes": meshes,
        "pieces": [_piece(collider, told) | {"name": pieces(collider.name)} for collider in link.colliders],
    }


def _mesh(visual: Visual, words: tuple[str, ...]) -> dict[str, str]:
    semantic = int(visual.item.group.table.semantic[visual.item.row])
    return {"title": visual.name, "look": _identifier(visual.look.name), "label": words[semantic] if semantic else ""}


def _piece(collider: Collider, told: _Told) -> dict[str, Any]:
    look = {"look": _identifier(collider.material.name)}
    if collider.size is not None:
        return look | next(told.placed) | {"type": "Cube", "scale": next(told.scales)}
    if collider.bar is not None:
        bar, reach = collider.bar, collider.bar.length / 2 + collider.bar.radius * collider.bar.capped
        corner = np.array([bar.radius, bar.radius, reach])
        (ends,) = _vectors([np.stack([-corner, corner])])
        lines = [f"float3[] extent = {ends}", f"double radius = {bar.radius:.9g}"]
        if bar.kind != "sphere":
            lines += ['uniform token axis = "Z"', f"double height = {bar.length:.9g}"]
        return look | next(told.placed) | {"type": bar.kind.capitalize(), "lines": lines}
    return look | {"type": "Mesh"} | next(told.met)


@dataclass(frozen=True, slots=True)
class _Told:
    """What the file says of the visuals, of the colliders that are meshes, of where the others are, and of how large boxes are, in the
    order of links: numbers of all are printed at once."""

    seen: Iterator[dict[str, str]]
    met: Iterator[dict[str, str]]
    placed: Iterator[dict[str, str]]
    scales: Iterator[str]

    @staticmethod
    def of(robot: Robot) -> _Told:
        seen = [(visual.item, link.origin) for link in robot.links for visual in link.visuals]
        plain = [collider for link in robot.links for collider in link.colliders if not _is_mesh(collider)]
        hulls = [c.hull for link in robot.links for c in link.colliders if _is_mesh(c) and c.hull is not None]
        shadings = [item.group.shading for item, _ in seen]
        points = [item.group.vertices[item.k][item.group.shading.source] - origin for item, origin in seen]
        faces = [shading.faces for shading in shadings] + [hull.faces for hull in hulls]
        told = _polygons(points + [hull.vertices for hull in hulls], faces)
        normals = [shading.normals[item.k] for (item, _), shading in zip(seen, shadings, strict=True)]
        shaded = _vectors(normals, 5)
        pairs = zip(told, shaded, strict=False)
        turns, shifts = (_tuples(np.array([getattr(c, name) for c in plain])) for name in ("turn", "center"))
        return _Told(
            iter([mesh | {"normals": normal} for mesh, normal in pairs]),
            iter(told[len(seen) :]),
            ({"turn": turn, "shift": shift} for turn, shift in zip(turns, shifts, strict=True)),
            iter(_tuples(np.array([c.size for c in plain if c.size is not None]))),
        )


def _is_mesh(collider: Collider) -> bool:
    return collider.size is None and collider.bar is None


def _polygons(points: list[np.ndarray], faces: list[np.ndarray]) -> list[dict[str, str]]:
    """Meshes with points (V, 3) and triangles (F, 3) each."""
    if not points:
        return []
    rows, starts = np.concatenate(points), np.cumsum([0, *map(len, points[:-1])])
    ends = np.stack([np.minimum.reduceat(rows, starts), np.maximum.reduceat(rows, starts)], axis=1)
    told = zip(_vectors(points), _vectors(list(ends)), faces, strict=True)
    return [_triangles(own.astype(np.int32).tobytes()) | {"extent": box, "points": text} for text, box, own in told]


@lru_cache(maxsize=512)
def _triangles(faces: bytes) -> dict[str, str]:
    """Those of a primitive are alike in all objects."""
    corners = np.frombuffer(faces, dtype=np.int32).astype(np.int64)
    return {
        "counts": "[" + ", ".join(["3"] * (len(corners) // 3)) + "]",
        "indices": f"[{print_rows(corners[:, None], '%d', _INDEX)[:-2]}]",
    }


def _joint(robot: Robot, joint: RobotJoint, name: str, links: list[str], paths: dict[str, str]) -> dict[str, Any]:
    """A joint's type, applied schemas and properties. Its frames are turned so that one of their axes is the joint's."""
    letter, turn = frame_of(joint.axis)
    lines = [
        f"rel physics:body0 = </{name}/{links[joint.parent]}>",
        f"rel physics:body1 = </{name}/{links[joint.child]}>",
        f"point3f physics:localPos0 = {_vector(joint.origin)}",
        "point3f physics:localPos1 = (0, 0, 0)",
        f"quatf physics:localRot0 = {_quat(turn)}",
        f"quatf physics:localRot1 = {_quat(turn)}",
    ]
    schemas: list[str] = []
    if joint.traits.tilts:
        lines.append(f'uniform token physics:axis = "{letter}"')
        if joint.high is not None:
            cone = max(abs(joint.low or 0.0), abs(joint.high)) * _DEGREES
            lines += [f"float physics:coneAngle{k}Limit = {cone:.9g}" for k in (0, 1)]
    elif joint.traits.moves:
        degree = "linear" if joint.traits.slides else "angular"
        lines.append(f'uniform token physics:axis = "{letter}"')
        lines += _drive(joint, degree, 1.0 if joint.traits.slides else _DEGREES)
        schemas = [f"PhysicsDriveAPI:{degree}", "PhysxJointAPI", f"PhysxJointAxisAPI:{degree}", "NewtonJointAPI"]
        if joint.traits.advances:
            lines.append(f"custom double artipg:screw:pitch = {joint.pitch:.17g}")
        if joint.positions:
            lines.append(f"custom int artipg:positions = {joint.positions}")
    lines += _mimic(robot, joint, name, letter, paths, schemas)
    lines += _gates(joint, name, paths)
    quoted = ", ".join(f'"{schema}"' for schema in schemas)
    return {
        "type": _TYPES[joint.kind],
        "name": paths[joint.name],
        "title": joint.name,
        "schemas": quoted,
        "lines": lines,
    }


def _drive(joint: RobotJoint, degree: str, unit: float) -> list[str]:
    """How a joint with one degree of freedom, "linear" or "angular", is limited and driven; ``unit``: degrees or metres in one of ours."""
    drive, physx = f"drive:{degree}:physics", f"physxJointAxis:{degree}"
    armature, velocity = f"{joint.armature:.9g}", f"{joint.velocity * unit:.9g}"
    ends = zip(("lower", "upper"), _limits(joint) or (), strict=False)
    return [
        *(f"float physics:{word}Limit = {end * unit:.9g}" for word, end in ends),
        f'uniform token {drive}:type = "force"',
        f"float {drive}:damping = {joint.damping / unit:.9g}",
        f"float {drive}:maxForce = {joint.effort:.9g}",
        f"float {drive}:stiffness = {joint.stiffness / unit:.9g}",
        *([f"float {drive}:targetPosition = {joint.rest * unit:.9g}"] if joint.stiffness else []),
        f"float physxJoint:armature = {armature}",
        f"float physxJoint:maxJointVelocity = {velocity}",
        # the axis has precedence where it is read, so it says all; physxJoint:jointFriction is no force but a coefficient
        f"float {physx}:armature = {armature}",
        f"float {physx}:dynamicFrictionEffort = {joint.friction:.9g}",
        f"float {physx}:maxJointVelocity = {velocity}",
        f"float {physx}:staticFrictionEffort = {joint.friction:.9g}",
        # Newton reads these of its own alone; the damping is the drive's
        f"float newton:armature = {armature}",
        f"float newton:friction = {joint.friction:.9g}",
        f"float newton:velocityLimit = {velocity}",
    ]


def _limits(joint: RobotJoint) -> tuple[float, float] | None:
    """The ends of what is not endless, in radians or metres."""
    if joint.traits.endless or joint.low is None or joint.high is None:
        return None
    return joint.low, joint.high


def _closure(closure: RobotClosure, name: str, links: list[str]) -> dict[str, Any]:
    """Where a loop closes: two points that stay together, outside the articulation's tree."""
    lines = [
        *(f"rel physics:body{n} = </{name}/{links[k]}>" for n, k in enumerate(closure.links)),
        *(f"point3f physics:localPos{n} = {_vector(point)}" for n, point in enumerate(closure.points)),
        "bool physics:excludeFromArticulation = 1",
    ]
    return {"type": _TYPES["ball"], "title": "closure", "schemas": "", "lines": lines}


def _mimic(
    robot: Robot, joint: RobotJoint, name: str, letter: str, paths: dict[str, str], schemas: list[str]
) -> list[str]:
    """What a joint follows: in our own words, and, of what has an axis, as Newton has it (q = coef0 + coef1 * q of the leader) and as
    PhysX has it (q + gearing * q of the leader + offset = 0)."""
    led = robot.leader(joint)
    if joint.mimic is None or led is None:
        return []
    _, multiplier, offset = joint.mimic
    leader = f"</{name}/joints/{paths[led.name]}>"
    curve = () if joint.curve is None else zip(("leader", "value"), joint.curve, strict=True)
    told = [
        *(
            f"custom double[] artipg:mimic:{word} = [{', '.join(f'{v:.17g}' for v in values)}]"
            for word, values in curve
        ),
        f"custom rel artipg:mimic:joint = {leader}",
        f"custom double artipg:mimic:multiplier = {multiplier:.17g}",
        f"custom double artipg:mimic:offset = {offset:.17g}",
    ]
    if joint.traits.tilts or led.traits.tilts:
        return told
    own, other = (1.0 if j.traits.slides else _DEGREES for j in (joint, led))
    schemas.append("NewtonMimicAPI")
    told += [  # the factor is of radians and metres, where one turns and the other slides, too
        f"float newton:mimicCoef0 = {offset * own:.9g}",
        f"float newton:mimicCoef1 = {multiplier:.9g}",
        f"rel newton:mimicJoint = {leader}",
    ]
    if not all(j.traits.slides or _limits(j) for j in (joint, led)):
        return told  # PhysX couples slides, and hinges with limits
    schemas.append(f"PhysxMimicJointAPI:rot{letter}")  # slides, too: other instances are not read
    physx = f"physxMimicJoint:rot{letter}"
    return [
        *told,
        f"float {physx}:gearing = {-multiplier * own / other:.9g}",
        f"float {physx}:offset = {-offset * own:.9g}",
        f"rel {physx}:referenceJoint = {leader}",
        f'uniform token {physx}:referenceJointAxis = "rot{frame_of(led.axis)[0]}"',
    ]


def _gates(joint: RobotJoint, name: str, paths: dict[str, str]) -> Iterator[str]:
    """What a joint waits for, in our own words: there is no schema for it, and nothing acts on it."""
    if joint.gates:
        yield (
            "custom rel artipg:when:joints = ["
            + ", ".join(f"</{name}/joints/{paths[g[0]]}>" for g in joint.gates)
            + "]"
        )
        for k, word in ((1, "from"), (2, "to")):
            yield f"custom double[] artipg:when:{word} = [" + ", ".join(f"{gate[k]:.17g}" for gate in joint.gates) + "]"


def frame_of(axis: np.ndarray) -> tuple[str, np.ndarray]:
    """The letter of a frame's axis, and the quaternion w x y z that turns the frame so that it points along ``axis``.

    The letter is that of the largest component: a frame for an axis along x, y or z is not turned at all.
    """
    k = int(np.argmax(np.abs(axis)))
    own = np.eye(3)[k]
    if axis[k] < 0:  # half a turn about the next axis first, so that what is left is less than a quarter
        half = np.zeros(4)
        half[1 + (k + 1) % 3] = 1.0
        return "XYZ"[k], _times(between(-own, axis), half)
    return "XYZ"[k], between(own, axis)


def between(a: np.ndarray, b: np.ndarray) -> np.ndarray:
    """The quaternion w x y z of the shortest turn from one unit vector to another, which is not its opposite."""
    cross = np.array([a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]])
    q = np.array([1.0 + a[0] * b[0] + a[1] * b[1] + a[2] * b[2], *cross])
    return q / np.sqrt(q[0] * q[0] + q[1] * q[1] + q[2] * q[2] + q[3] * q[3])


def _times(p: np.ndarray, q: np.ndarray) -> np.ndarray:
    """The product of two quaternions w x y z: first ``q``, then ``p``."""
    a, b, c, d = p.tolist()
    e, f, g, h = q.tolist()
    return np.array(
        [
            a * e - b * f - c * g - d * h,
            a * f + b * e + c * h - d * g,
            a * g - b * h + c * e + d * f,
            a * h + b * g - c * f + d * e,
        ]
    )


@lru_cache(maxsize=512)
def _identifier(name: str) -> str:
    return Names()(name)


def _vector(values: np.ndarray) -> str:
    return f"({numbers(values).replace(' ', ', ')})"


def _quat(values: np.ndarray) -> str:
    """A quaternion w x y z."""
    return _vector(np.asarray(values, dtype=np.float64).reshape(4))


def _tuples(rows: np.ndarray) -> list[str]:
    """Each of several vectors or quaternions (n, k) as ``_vector`` has it."""
    if not len(rows):
        return []
    ends = ("(", *[", "] * (rows.shape[1] - 1), ")\n")
    return print_rows(np.round(rows, 12) + 0.0, "%.9g", ends)[:-1].split("\n")


def _vectors(blocks: list[np.ndarray], decimals: int = 12) -> list[str]:
    """Each of several blocks of points (n, 3), rounded, as an array of tuples."""
    if not blocks:
        return []
    rows = np.round(np.concatenate(blocks), decimals) + 0.0
    lines = print_blocks(rows, [0, *accumulate(map(len, blocks))], "%.9g", _POINT)
    return [f"[{text[:-1]}]".replace("\n", ", ") for text in lines]
