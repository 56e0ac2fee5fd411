"""URDF read by yourdfpy, USD by usd-core, GLB, OBJ and PartNet-Mobility by trimesh and yourdfpy."""

from __future__ import annotations

import json
import struct
from pathlib import Path

import numpy as np
import trimesh

from artipg_dsl.annotate.frames import axis_angle
from artipg_dsl.robot.model import Robot
from artipg_dsl.robot.pose import rest_values

from .reading import (
    Body,
    Matrix,
    Reading,
    Values,
    from_quaternion,
    from_the_root,
    matrix,
    model_bounds,
    principal_to_full,
)

TO_Z_UP = np.array([[0.0, 0, 1], [1, 0, 0], [0, 1, 0]])  # x right, y up, z front to x front, y left, z up


def yourdfpy_urdf(folder: Path, robot: Robot) -> Reading:
    import yourdfpy

    urdf = yourdfpy.URDF.load(str(folder / "object.urdf"))

    def poses(values: Values) -> dict[str, Matrix]:
        urdf.update_cfg({name: values[name] for name in urdf.actuated_joint_names})
        return {name: urdf.get_transform(name, urdf.base_link) for name in urdf.link_map}

    bodies = {}
    for name, link in urdf.link_map.items():
        inertial = link.inertial
        assert np.allclose(inertial.origin[:3, :3], np.eye(3))
        bodies[name] = Body(inertial.mass, inertial.origin[:3, 3], inertial.inertia, len(link.collisions))
    joints = {}
    for name, joint in urdf.joint_map.items():
        if joint.type != "fixed":
            joints[name] = (joint.limit.lower, joint.limit.upper) if joint.type != "continuous" else None
    zero = {joint.name: 0.0 for joint in robot.joints}
    poses(zero)
    return Reading(bodies, joints, poses, urdf.scene.bounds, follow_zero(urdf, robot))


def follow_zero(urdf, robot: Robot) -> Values:  # type: ignore[no-untyped-def]
    """The values that a reader has that moves followers with their leaders, the leaders at 0."""
    offset = {name: joint.mimic.offset or 0.0 for name, joint in urdf.joint_map.items() if joint.mimic}
    return {joint.name: offset.get(joint.name, 0.0) for joint in robot.joints}


def usd(folder: Path, robot: Robot) -> Reading:
    from pxr import Usd, UsdGeom, UsdPhysics

    stage = Usd.Stage.Open(str(folder / "object.usda"))
    root = stage.GetDefaultPrim()
    prims = {p.GetDisplayName(): p for p in root.GetChildren() if p.HasAPI(UsdPhysics.RigidBodyAPI)}
    by_path = {prim.GetPath(): name for name, prim in prims.items()}
    every = [UsdPhysics.Joint(prim) for prim in stage.Traverse() if prim.IsA(UsdPhysics.Joint)]
    tree = [joint for joint in every if not joint.GetExcludeFromArticulationAttr().Get()]
    assert len(every) - len(tree) == len(robot.closures)  # what closes loops
    found = {joint.GetPrim().GetDisplayName() or joint.GetPrim().GetName(): joint for joint in tree}

    def turn(q) -> np.ndarray:  # type: ignore[no-untyped-def]
        return from_quaternion(q.GetReal(), *q.GetImaginary())

    def poses(values: Values) -> dict[str, Matrix]:
        """From the frames of the joints alone."""
        places = {robot.links[0].name: matrix(np.eye(3), robot.links[0].origin)}
        for name in [joint.name for joint in from_the_root(robot)]:
            joint, prim = found[name], found[name].GetPrim()
            parent, child = (by_path[r.GetTargets()[0]] for r in (joint.GetBody0Rel(), joint.GetBody1Rel()))
            first = matrix(turn(joint.GetLocalRot0Attr().Get()), joint.GetLocalPos0Attr().Get())
            second = matrix(turn(joint.GetLocalRot1Attr().Get()), joint.GetLocalPos1Attr().Get())
            motion, value = np.eye(4), values[name]
            if not prim.IsA(UsdPhysics.FixedJoint):
                axis = np.eye(3)["XYZ".index(prim.GetAttribute("physics:axis").Get())]
                if prim.IsA(UsdPhysics.PrismaticJoint):
                    motion[:3, 3] = axis * value
                elif prim.IsA(
                    UsdPhysics.SphericalJoint
                ):  # any direction will do for the reader: ours is the model's tilt
                    motion = np.linalg.inv(first) @ _tilt(robot, name, value) @ first
                    motion[:3, 3] = 0.0
                else:
                    motion[:3, :3] = axis_angle(axis, np.float64(value))
                    pitch = (
                        prim.GetAttribute("artipg:screw:pitch").Get()
                        if prim.HasAttribute("artipg:screw:pitch")
                        else 0.0
                    )
                    motion[:3, 3] = axis * value * pitch / (2 * np.pi)
            places[child] = places[parent] @ first @ motion @ np.linalg.inv(second)
        return places

    bodies = {}
    for name, prim in prims.items():
        mass = UsdPhysics.MassAPI(prim)
        moments = np.array(mass.GetDiagonalInertiaAttr().Get(), dtype=np.float64)
        inertia = principal_to_full(moments, turn(mass.GetPrincipalAxesAttr().Get()))
        count = sum(p.HasAPI(UsdPhysics.CollisionAPI) for p in Usd.PrimRange(prim))
        bodies[name] = Body(mass.GetMassAttr().Get(), np.array(mass.GetCenterOfMassAttr().Get()), inertia, count)
    limits: dict[str, tuple[float, float] | None] = {}
    for name, joint in found.items():
        prim = joint.GetPrim()
        low, high = (prim.GetAttribute(f"physics:{end}Limit") for end in ("lower", "upper"))
        if prim.IsA(UsdPhysics.FixedJoint):
            continue
        unit = 1.0 if prim.IsA(UsdPhysics.PrismaticJoint) else np.pi / 180
        limited = low and low.HasAuthoredValue()
        limits[name] = (low.Get() * unit, high.Get() * unit) if limited else None
    box = (
        UsdGeom.BBoxCache(Usd.TimeCode.Default(), [UsdGeom.Tokens.default_])
        .ComputeWorldBound(root)
        .ComputeAlignedRange()
    )
    # its boxes are those of turned boxes: compare where nothing is turned
    straight = all(np.allclose(pose[:3, :3], np.eye(3)) for pose in poses(rest_values(robot)).values())
    bounds = np.array([box.GetMin(), box.GetMax()]) if straight else None
    return Reading(bodies, limits, poses, bounds, rest_values(robot), stage)


def _tilt(robot: Robot, name: str, value: float) -> Matrix:
    from artipg_dsl.runtime.motion import perpendicular_to

    joint = next(j for j in robot.joints if j.name == name)
    return matrix(axis_angle(perpendicular_to(joint.axis[None])[0], np.float64(value)), np.zeros(3))


def glb(folder: Path, robot: Robot) -> Reading:
    """Nodes and their joints from the JSON, meshes by trimesh."""
    data = (folder / "object.glb").read_bytes()
    size = struct.unpack("<I", data[12:16])[0]
    document = json.loads(data[20 : 20 + size])
    nodes = document["nodes"]
    links = {node["name"]: node for node in nodes[1 : 1 + len(robot.links)]}
    joints = {
        n["extras"]["joint"]["name"]: n["extras"]["joint"] for n in links.values() if "joint" in n.get("extras", {})
    }
    above = {nodes[child]["name"]: node["name"] for node in nodes[1:] for child in node.get("children", [])}

    def poses(values: Values) -> dict[str, Matrix]:
        """From what the nodes say about their joints."""
        places: dict[str, Matrix] = {}
        for link in [robot.links[0], *(robot.links[joint.child] for joint in from_the_root(robot))]:
            node = links[link.name]
            joint = node.get("extras", {}).get("joint")
            if joint is None:
                places[link.name] = matrix(np.eye(3), np.array(node.get("translation", [0.0, 0, 0])))
                continue
            value, axis = values[joint["name"]], np.array(joint["axis"])
            advance = {"prismatic": 1.0, "screw": joint.get("pitch", 0.0) / (2 * np.pi)}.get(joint["type"], 0.0)
            own = np.eye(3) if joint["type"] in ("prismatic", "fixed") else axis_angle(axis, np.float64(value))
            if joint["type"] == "ball":
                own = _tilt(robot, joint["name"], value)[:3, :3]
            step = matrix(own, np.array(joint["origin"]) + advance * value * axis)
            places[link.name] = places[above[link.name]] @ step
        return places

    scene = trimesh.load(folder / "object.glb")
    corners = np.array(list(np.ndindex(2, 2, 2)))
    box = np.stack([scene.bounds[corners[:, k], k] for k in range(3)], axis=1) @ TO_Z_UP.T
    moving = {name: joint for name, joint in joints.items() if joint["type"] != "fixed"}
    limits = {name: tuple(j["limits"]) if j["limits"] and j["type"] != "ball" else None for name, j in moving.items()}
    bounds = np.stack([box.min(axis=0), box.max(axis=0)])
    return Reading({name: Body() for name in links}, limits, poses, bounds, rest_values(robot))


def obj(folder: Path, robot: Robot) -> Reading:
    """A file per link, in the object's frame at rest."""
    paths = sorted((folder / "obj").glob("*.obj"))
    bounds = np.stack([trimesh.load(path, process=False).bounds for path in paths])
    box = np.stack([bounds[:, 0].min(axis=0), bounds[:, 1].max(axis=0)])
    return Reading({path.stem: Body() for path in paths}, None, None, box, rest_values(robot))


def partnet(folder: Path, robot: Robot) -> Reading:
    """Links and joints under our names; screws and balls, which the data set has no word for, are left out of the poses."""
    import yourdfpy

    urdf = yourdfpy.URDF.load(str(folder / "mobility.urdf"))
    unit = json.loads((folder / "meta.json").read_text())["metres_per_unit"]
    moving = [joint.child for joint in robot.joints]
    order = [k for k in range(len(robot.links)) if k in moving] + [0]  # ours by the folder's number
    zero = {joint.name: 0.0 for joint in robot.joints}
    center = model_bounds(robot, zero).mean(axis=0)
    base = np.diag([-1.0, -1.0, 1.0])  # its front is -x
    by_child = {joint.child: joint for joint in robot.joints}
    names = {robot.links[k].name: f"link_{number}" for number, k in enumerate(order)}

    def poses(values: Values) -> dict[str, Matrix]:
        cfg = {}
        for number, k in enumerate(order[:-1]):
            joint = by_child[k]
            if urdf.joint_map[f"joint_{number}"].type != "fixed":
                cfg[f"joint_{number}"] = values[joint.name] / (unit if joint.kind == "prismatic" else 1.0)
        urdf.update_cfg(cfg)
        places = {}
        for name, link in names.items():
            found = urdf.get_transform(link, "base")
            # a raw frame's axes are x right, y up, z front
            turn = base @ found[:3, :3] @ (base @ TO_RAW).T
            places[name] = matrix(turn, base @ found[:3, 3] * unit + center)
        root = robot.links[0].name  # whose raw origin is the centre of the box
        places[root][:3, 3] += places[root][:3, :3] @ (robot.links[0].origin - center)
        return places

    limits: dict[str, tuple[float, float] | None] = {}
    for number, k in enumerate(order[:-1]):
        joint, read = by_child[k], urdf.joint_map[f"joint_{number}"]
        per = unit if joint.kind == "prismatic" else 1.0
        if joint.kind in ("revolute", "prismatic"):
            limits[joint.name] = (read.limit.lower * per, read.limit.upper * per)
        elif joint.kind == "continuous":
            limits[joint.name] = None
    bodies = {name: Body(colliders=len(urdf.link_map[link].collisions)) for name, link in names.items()}
    urdf.update_cfg({name: 0.0 for name in urdf.actuated_joint_names})
    corners = urdf.scene.bounds @ base * unit + center
    return Reading(bodies, limits, poses, np.stack([corners.min(axis=0), corners.max(axis=0)]), zero)


TO_RAW = np.array([[0.0, 0, -1], [-1, 0, 0], [0, 1, 0]])  # of the folder's base from its raw axes
