"""OpenUSD read back with usd-core: kinematics from the joints' frames alone, limits, mass, bounds, colliders."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from artipg_dsl import sample
from artipg_dsl.annotate.frames import axis_angle
from artipg_dsl.export.usd import Names, between, frame_of, usd_files
from artipg_dsl.export.write import ExportError
from artipg_dsl.language.kinds import JOINTS, Kind
from artipg_dsl.robot.model import Robot
from artipg_dsl.robot.pose import link_poses, rest_poses
from artipg_dsl.robot.principal import find_principal
from artipg_dsl.robot.robots import Robots

from .fake_batch import FakeBatch

pytest.importorskip("pxr", reason="usd-core is not installed")
from pxr import Gf, Usd, UsdGeom, UsdPhysics, UsdShade  # noqa: E402

OURS = ["Microwave", "StorageFurniture", "Chair", "Door"]


class Opened:
    def __init__(self, robots: Robots, i: int):
        self.robot = robots.robot(i)
        self.files = usd_files(robots, i)
        self.stage = Usd.Stage.CreateInMemory("object.usda")
        assert self.stage.GetRootLayer().ImportFromString(self.files["object.usda"].decode())
        self.root = self.stage.GetDefaultPrim()
        bodies = [p for p in self.root.GetChildren() if p.HasAPI(UsdPhysics.RigidBodyAPI)]
        self.bodies = {prim.GetDisplayName(): prim for prim in bodies}
        self.joints = {p.GetDisplayName() or p.GetName(): p for p in self.stage.Traverse() if p.IsA(UsdPhysics.Joint)}


@pytest.fixture(scope="module", params=OURS)
def opened(request: pytest.FixtureRequest) -> Opened:
    return Opened(Robots(sample(request.param, numbers=[1], seed=7).batch), 0)


def quat(q) -> np.ndarray:  # type: ignore[no-untyped-def]
    """The rotation matrix of a quaternion of USD."""
    w, (x, y, z) = q.GetReal(), q.GetImaginary()
    return np.array(
        [
            [1 - 2 * (y * y + z * z), 2 * (x * y - w * z), 2 * (x * z + w * y)],
            [2 * (x * y + w * z), 1 - 2 * (x * x + z * z), 2 * (y * z - w * x)],
            [2 * (x * z - w * y), 2 * (y * z + w * x), 1 - 2 * (x * x + y * y)],
        ]
    )


def matrix(rotation: np.ndarray, shift) -> np.ndarray:  # type: ignore[no-untyped-def]
    found = np.eye(4)
    found[:3, :3], found[:3, 3] = rotation, np.array(shift)
    return found


def poses_from_joints(opened: Opened, values: dict[str, float]) -> dict[str, np.ndarray]:
    """Where the bodies are at joint values: parent, its joint frame, the motion, the child's joint frame undone."""
    by_path = {prim.GetPath(): name for name, prim in opened.bodies.items()}
    found = {opened.robot.links[0].name: np.eye(4)}
    waiting = dict(opened.joints)
    while waiting:
        for name, prim in list(waiting.items()):
            joint = UsdPhysics.Joint(prim)
            parent, child = (by_path[rel.GetTargets()[0]] for rel in (joint.GetBody0Rel(), joint.GetBody1Rel()))
            if parent not in found:
                continue
            first = matrix(quat(joint.GetLocalRot0Attr().Get()), joint.GetLocalPos0Attr().Get())
            second = matrix(quat(joint.GetLocalRot1Attr().Get()), joint.GetLocalPos1Attr().Get())
            motion = np.eye(4)
            if prim.IsA(UsdPhysics.RevoluteJoint):
                axis = np.eye(3)["XYZ".index(UsdPhysics.RevoluteJoint(prim).GetAxisAttr().Get())]
                motion[:3, :3] = axis_angle(axis, np.float64(values[name]))
            elif prim.IsA(UsdPhysics.PrismaticJoint):
                axis = np.eye(3)["XYZ".index(UsdPhysics.PrismaticJoint(prim).GetAxisAttr().Get())]
                motion[:3, 3] = axis * values[name]
            found[child] = found[parent] @ first @ motion @ np.linalg.inv(second)
            del waiting[name]
    return found


def random_values(robot: Robot, seed: int) -> dict[str, float]:
    rng = np.random.default_rng(seed)
    return {j.name: rng.uniform(-3 if j.low is None else j.low, 3 if j.high is None else j.high) for j in robot.joints}


def test_the_stage_is_valid_and_complete(opened: Opened) -> None:
    assert UsdGeom.GetStageUpAxis(opened.stage) == "Z" and UsdGeom.GetStageMetersPerUnit(opened.stage) == 1
    assert UsdPhysics.GetStageKilogramsPerUnit(opened.stage) == 1
    assert opened.root.HasAPI(UsdPhysics.ArticulationRootAPI)
    assert list(opened.bodies) == [link.name for link in opened.robot.links]
    assert list(opened.joints) == [joint.name for joint in opened.robot.joints]
    validation = pytest.importorskip("pxr.UsdValidation", reason="this usd-core has no validators")
    context = validation.ValidationContext(validation.ValidationRegistry().GetOrLoadAllValidators())
    assert [error.GetMessage() for error in context.Validate(opened.stage)] == []


def test_usd_finds_one_articulation(opened: Opened) -> None:
    load = getattr(UsdPhysics, "UsdPhysicsLoadStageFromPrimRange", None) or UsdPhysics.LoadUsdPhysicsFromRange
    try:
        found = load(Usd.PrimRange(opened.stage.GetPseudoRoot()))
    except TypeError:
        found = load(opened.stage, ["/"])
    counts = {str(kind).split(".")[-1]: len(entries[0]) for kind, entries in found.items()}
    moving = [joint.kind for joint in opened.robot.joints]
    assert counts["Articulation"] == 1 and counts["RigidBody"] == len(opened.robot.links)
    assert counts.get("PrismaticJoint", 0) == moving.count("prismatic")
    assert counts.get("RevoluteJoint", 0) == moving.count("revolute") + moving.count("continuous")
    pieces = [collider for link in opened.robot.links for collider in link.colliders]
    kinds = ["cube" if p.size is not None else p.bar.kind if p.bar is not None else "mesh" for p in pieces]
    for kind in ("cube", "cylinder", "sphere", "capsule", "mesh"):
        assert counts.get(f"{kind.capitalize()}Shape", 0) == kinds.count(kind)


@pytest.mark.parametrize("seed", [1, 2])
def test_joint_frames_move_the_bodies_as_the_model_does(opened: Opened, seed: int) -> None:
    values = random_values(opened.robot, seed)
    found = poses_from_joints(opened, values)
    probe = np.array([[0.2, -0.1, 0.3], [-0.3, 0.2, 0.1]])
    for link, (turn, shift) in zip(opened.robot.links, link_poses(opened.robot, values), strict=True):
        expected = probe @ turn.T + shift
        assert probe @ found[link.name][:3, :3].T + found[link.name][:3, 3] == pytest.approx(expected, abs=1e-6)


def test_bodies_lie_as_they_rest(opened: Opened) -> None:
    cache = UsdGeom.XformCache()
    for link, (turn, shift) in zip(opened.robot.links, rest_poses(opened.robot), strict=True):
        world = np.array(cache.GetLocalToWorldTransform(opened.bodies[link.name])).T
        assert world[:3, :3] == pytest.approx(turn, abs=1e-8) and world[:3, 3] == pytest.approx(shift, abs=1e-8)


def test_limits_are_degrees_and_drives_know_their_bounds(opened: Opened) -> None:
    for joint in opened.robot.joints:
        prim = opened.joints[joint.name]
        angular = joint.kind != "prismatic"
        unit = 180 / np.pi if angular else 1.0
        typed = (UsdPhysics.RevoluteJoint if angular else UsdPhysics.PrismaticJoint)(prim)
        low, high = typed.GetLowerLimitAttr().Get(), typed.GetUpperLimitAttr().Get()
        if joint.kind == "continuous":
            assert low == -np.inf and high == np.inf
        else:
            assert [low, high] == pytest.approx([joint.low * unit, joint.high * unit], rel=1e-6, abs=1e-9)  # type: ignore[operator]
        drive = UsdPhysics.DriveAPI(prim, "angular" if angular else "linear")
        assert drive.GetMaxForceAttr().Get() == pytest.approx(joint.effort)
        assert drive.GetDampingAttr().Get() * unit == pytest.approx(joint.damping)
        axis = f"physxJointAxis:{'angular' if angular else 'linear'}"
        assert f"PhysxJointAxisAPI:{axis.split(':')[1]}" in prim.GetPrimTypeInfo().GetAppliedAPISchemas()
        told = {"armature": joint.armature, "maxJointVelocity": joint.velocity * unit}
        for word, value in told.items():
            for place in ("physxJoint", axis):
                assert prim.GetAttribute(f"{place}:{word}").Get() == pytest.approx(value)
        assert not prim.HasAttribute("physxJoint:jointFriction")  # a coefficient, not a force
        for word in ("staticFrictionEffort", "dynamicFrictionEffort"):
            assert prim.GetAttribute(f"{axis}:{word}").Get() == pytest.approx(joint.friction)
        assert "NewtonJointAPI" in prim.GetPrimTypeInfo().GetAppliedAPISchemas()
        newton = {"armature": joint.armature, "friction": joint.friction, "velocityLimit": joint.velocity * unit}
        for word, value in newton.items():
            assert prim.GetAttribute(f"newton:{word}").Get() == pytest.approx(value)
        assert not prim.HasAttribute("newton:damping")  # the drive has it, and Newton reads that, too


def test_mass_center_and_inertia(opened: Opened) -> None:
    for link in opened.robot.links:
        mass = UsdPhysics.MassAPI(opened.bodies[link.name])
        assert mass.GetMassAttr().Get() == pytest.approx(link.mass, rel=1e-6)
        assert np.array(mass.GetCenterOfMassAttr().Get()) == pytest.approx(link.center, abs=1e-6)
        axes, moments = quat(mass.GetPrincipalAxesAttr().Get()), np.array(mass.GetDiagonalInertiaAttr().Get())
        scale = np.abs(link.inertia).max()
        assert axes @ np.diag(moments) @ axes.T == pytest.approx(link.inertia, abs=1e-6 * scale)


def test_bounds_looks_and_colliders(opened: Opened) -> None:
    cache = UsdGeom.BBoxCache(Usd.TimeCode.Default(), [UsdGeom.Tokens.default_])
    box = cache.ComputeWorldBound(opened.root).ComputeAlignedRange()
    points = []
    for link, (turn, shift) in zip(opened.robot.links, rest_poses(opened.robot), strict=True):
        points += [visual.shape.vertices @ turn.T + shift for visual in link.visuals]
    seen = np.concatenate(points)
    low, high = np.array(box.GetMin()), np.array(box.GetMax())
    assert (low <= seen.min(axis=0) + 1e-6).all() and (high >= seen.max(axis=0) - 1e-6).all()
    still = [np.allclose(turn, np.eye(3)) for turn, _ in rest_poses(opened.robot)]
    if all(still):  # the box of a turned box is larger
        assert [low, high] == [pytest.approx(seen.min(axis=0), abs=1e-6), pytest.approx(seen.max(axis=0), abs=1e-6)]
    for prim in opened.stage.Traverse():
        if prim.HasAPI(UsdPhysics.CollisionAPI):
            material, _ = UsdShade.MaterialBindingAPI(prim).ComputeBoundMaterial("physics")
            physics = UsdPhysics.MaterialAPI(material.GetPrim())
            assert 0 < physics.GetDynamicFrictionAttr().Get() <= physics.GetStaticFrictionAttr().Get() < 2
            assert 50 < physics.GetDensityAttr().Get() < 20000
            assert UsdGeom.Imageable(prim).ComputePurpose() == "guide"
            if prim.IsA(UsdGeom.Mesh):
                assert UsdPhysics.MeshCollisionAPI(prim).GetApproximationAttr().Get() == "convexHull"
        elif prim.IsA(UsdGeom.Mesh):
            mesh = UsdGeom.Mesh(prim)
            material, _ = UsdShade.MaterialBindingAPI(prim).ComputeBoundMaterial()
            assert material and len(mesh.GetNormalsAttr().Get()) == len(mesh.GetPointsAttr().Get())
            assert len(mesh.GetFaceVertexIndicesAttr().Get()) == 3 * len(mesh.GetFaceVertexCountsAttr().Get())


def test_box_colliders_lie_where_the_model_has_them(opened: Opened) -> None:
    cache = UsdGeom.XformCache()
    cubes = [prim for prim in opened.stage.Traverse() if prim.IsA(UsdGeom.Cube)]
    boxes = [(k, c) for k, link in enumerate(opened.robot.links) for c in link.colliders if c.size is not None]
    poses = rest_poses(opened.robot)
    corner = np.array([0.5, -0.5, 0.5])
    for prim, (k, box) in zip(cubes, boxes, strict=True):
        turn, shift = poses[k]
        expected = turn @ (box.rotation @ (np.array(box.size) * corner) + box.center) + shift
        world = np.array(cache.GetLocalToWorldTransform(prim)).T
        assert world[:3, :3] @ corner + world[:3, 3] == pytest.approx(expected, abs=1e-6)


def test_colours_are_linear_and_glass_is_clear() -> None:
    opened = Opened(Robots(FakeBatch(2)), 1)
    surface = UsdShade.Shader(opened.stage.GetPrimAtPath(f"{opened.root.GetPath()}/Looks/glass/Surface"))
    assert surface.GetIdAttr().Get() == "UsdPreviewSurface"
    assert np.array(surface.GetInput("diffuseColor").Get())[0] == pytest.approx(
        ((0.6 + 0.055) / 1.055) ** 2.4, abs=1e-5
    )
    assert surface.GetInput("opacity").Get() == pytest.approx(0.4)


def test_a_follower_names_its_leader() -> None:
    opened = Opened(Robots(FakeBatch(1, mimic=True)), 0)
    (joint,) = [joint for joint in opened.robot.joints if joint.mimic]
    leader, multiplier, offset = joint.mimic  # type: ignore[misc]
    prim = opened.joints[joint.name]
    assert prim.GetRelationship("artipg:mimic:joint").GetTargets() == [opened.joints[leader].GetPath()]
    assert prim.GetAttribute("artipg:mimic:multiplier").Get() == multiplier
    assert prim.GetAttribute("artipg:mimic:offset").Get() == offset
    (schema,) = [s for s in prim.GetPrimTypeInfo().GetAppliedAPISchemas() if s.startswith("PhysxMimicJointAPI")]
    assert joint.kind == "prismatic" and schema[-4:] in ("rotX", "rotY", "rotZ")  # of slides, too
    physx = f"physxMimicJoint:{schema.split(':')[1]}"
    assert prim.GetAttribute(f"{physx}:referenceJointAxis").Get() in ("rotX", "rotY", "rotZ")
    led = next(other for other in opened.robot.joints if other.name == leader)
    own, other = (180 / np.pi if j.kind != "prismatic" else 1.0 for j in (joint, led))
    value = 0.3  # of the leader, in its unit: the constraint of PhysX holds where the follower is
    follower = (multiplier * value + offset) * own
    gearing, shift = (prim.GetAttribute(f"{physx}:{word}").Get() for word in ("gearing", "offset"))
    assert follower + gearing * value * other + shift == pytest.approx(0, abs=1e-5)
    assert "NewtonMimicAPI" in prim.GetPrimTypeInfo().GetAppliedAPISchemas()
    assert prim.GetRelationship("newton:mimicJoint").GetTargets() == [opened.joints[leader].GetPath()]
    assert prim.GetAttribute("newton:mimicCoef0").Get() == pytest.approx(offset * own)
    assert prim.GetAttribute("newton:mimicCoef1").Get() == pytest.approx(multiplier)


def test_physx_is_told_of_no_follower_of_what_has_no_limits(monkeypatch: pytest.MonkeyPatch) -> None:
    robots = Robots(FakeBatch(1, mimic=True))
    robot = robots.robot(0)
    leader = next(joint.mimic[0] for joint in robot.joints if joint.mimic)
    joints = tuple(replace(j, kind="continuous", low=None, high=None) if j.name == leader else j for j in robot.joints)
    monkeypatch.setattr(robots, "robot", lambda _: replace(robot, joints=joints))
    text = usd_files(robots, 0)["object.usda"].decode()
    assert "artipg:mimic:joint" in text and "NewtonMimicAPI" in text and "PhysxMimicJointAPI" not in text


def test_joints_of_other_kinds(monkeypatch: pytest.MonkeyPatch) -> None:
    robots = Robots(FakeBatch(1))
    robot = robots.robot(0)

    def with_kind(kind: str) -> Robots:
        changed = replace(robot, joints=(replace(robot.joints[0], kind=kind), *robot.joints[1:]))
        monkeypatch.setattr(robots, "robot", lambda _: changed)
        return robots

    name, high = robot.joints[0].name, robot.joints[0].high
    opened = Opened(with_kind("ball"), 0)  # a prim lives as long as its stage
    ball = UsdPhysics.SphericalJoint(opened.joints[name])
    assert ball.GetConeAngle0LimitAttr().Get() == pytest.approx(np.degrees(high))
    opened = Opened(with_kind("fixed"), 0)
    assert opened.joints[name].IsA(UsdPhysics.FixedJoint)
    opened = Opened(with_kind("screw"), 0)
    screw = opened.joints[name]
    assert (
        screw.IsA(UsdPhysics.RevoluteJoint) and screw.GetAttribute("artipg:screw:pitch").Get() == robot.joints[0].pitch
    )
    monkeypatch.setitem(JOINTS, "gear", Kind("gear"))  # a kind that the language might gain
    with pytest.raises(ExportError, match="gear joint, which UsdPhysics cannot express"):
        usd_files(with_kind("gear"), 0)


def test_frames_for_any_axis() -> None:
    rng = np.random.default_rng(5)
    axes = [*np.eye(3), *-np.eye(3), *rng.normal(size=(200, 3))]
    for axis in axes:
        axis = axis / np.linalg.norm(axis)
        letter, (w, x, y, z) = frame_of(axis)
        turn = quat(Gf.Quatd(float(w), float(x), float(y), float(z)))
        assert turn @ np.eye(3)["XYZ".index(letter)] == pytest.approx(axis, abs=1e-12)
    assert between(np.eye(3)[0], np.eye(3)[0]).tolist() == [1, 0, 0, 0]


def test_principal_axes_of_any_tensor() -> None:
    rng = np.random.default_rng(6)
    points = rng.normal(size=(300, 5, 3)) * rng.uniform(1e-4, 1, (300, 1, 3))
    tensors = np.einsum("nki,nkj->nij", points, points)
    tensors = np.concatenate([tensors, np.eye(3)[None], np.diag([3.0, 1.0, 2.0])[None], np.zeros((1, 3, 3))])
    moments, axes = find_principal(tensors)
    scale = np.abs(tensors).max(axis=(1, 2), keepdims=True) + 1e-30
    again = np.einsum("nij,nj,nkj->nik", axes, moments, axes)
    assert (np.abs(again - tensors) <= 1e-13 * scale).all()
    assert np.linalg.det(axes) == pytest.approx(1, abs=1e-12)
    assert np.sort(moments, axis=1) == pytest.approx(np.linalg.eigvalsh(tensors), abs=1e-12)


def test_bytes_do_not_depend_on_the_batch() -> None:
    assert usd_files(Robots(FakeBatch(5)), 3) == usd_files(Robots(FakeBatch(1, first=3)), 0)
    names = Names("joints")
    assert [names(n) for n in ("a.b", "a_b", "joints", "1st", "ü")] == ["a_b", "a_b_2", "joints_2", "_1st", "_"]


def test_balls_tell_what_they_follow_and_wait_for(monkeypatch: pytest.MonkeyPatch) -> None:
    robots = Robots(FakeBatch(1))
    robot = robots.robot(0)
    door, button = robot.joints
    ball = replace(button, kind="ball", mimic=(door.name, 0.1, 0.2), gates=((door.name, 1.0, np.inf),))
    monkeypatch.setattr(robots, "robot", lambda _: replace(robot, joints=(door, ball)))
    opened = Opened(robots, 0)
    prim, leader = opened.joints[button.name], opened.joints[door.name].GetPath()
    assert prim.GetRelationship("artipg:mimic:joint").GetTargets() == [leader]
    assert prim.GetAttribute("artipg:mimic:multiplier").Get() == 0.1
    assert prim.GetRelationship("artipg:when:joints").GetTargets() == [leader]
    assert not [s for s in prim.GetPrimTypeInfo().GetAppliedAPISchemas() if s.startswith("Physx")]
