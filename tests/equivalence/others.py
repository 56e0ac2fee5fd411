"""SDF and URDF read by Drake, URDF by Pinocchio, USD and URDF by Newton: `pip install 'artipg_dsl[readers]'`."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from artipg_dsl.annotate.frames import quaternion
from artipg_dsl.export.usd import Names, frame_of
from artipg_dsl.robot.model import Robot
from artipg_dsl.runtime.motion import perpendicular_to

from .reading import Body, Matrix, Reading, Values, from_quaternion, matrix


def drake_sdf(folder: Path, robot: Robot) -> Reading:
    if robot.closures:
        pytest.skip("Drake reads no loops")
    return _drake(folder / "model.sdf", robot)


def drake_urdf(folder: Path, robot: Robot) -> Reading:
    return _drake(folder / "object.urdf", robot)


def _drake(path: Path, robot: Robot) -> Reading:
    from pydrake.math import RollPitchYaw, RotationMatrix
    from pydrake.multibody.parsing import Parser
    from pydrake.multibody.plant import AddMultibodyPlantSceneGraph
    from pydrake.systems.framework import DiagramBuilder

    builder = DiagramBuilder()
    plant, _ = AddMultibodyPlantSceneGraph(builder, time_step=0.001)
    (model,) = Parser(plant).AddModels(str(path))
    parts = {plant.get_body(k).name(): plant.get_body(k) for k in plant.GetBodyIndices(model)}
    joints = {plant.get_joint(k).name(): plant.get_joint(k) for k in plant.GetJointIndices(model)}
    plant.WeldFrames(plant.world_frame(), parts[robot.links[0].name].body_frame())
    plant.Finalize()
    diagram = builder.Build()
    context = plant.GetMyContextFromRoot(diagram.CreateDefaultContext())
    origin, balls = matrix(np.eye(3), robot.links[0].origin), {j.name: j for j in robot.joints if j.traits.tilts}

    def poses(values: Values) -> dict[str, Matrix]:
        state = plant.GetPositions(context)
        for name, value in values.items():
            start, count = joints[name].position_start(), joints[name].num_positions()
            if count == 3:
                turn = _tilted(balls[name].axis, value)
                state[start : start + 3] = RollPitchYaw(RotationMatrix(turn)).vector()
            elif count:
                state[start] = value
        plant.SetPositions(context, state)
        return {name: origin @ part.EvalPoseInWorld(context).GetAsMatrix4() for name, part in parts.items()}

    bodies = {}
    for name, part in parts.items():
        inertia = part.CalcSpatialInertiaInBodyFrame(context)
        center = inertia.get_com()
        about = inertia.Shift(center).CalcRotationalInertia().CopyToFullMatrix3()
        count = len(plant.GetCollisionGeometriesForBody(part))
        bodies[name] = Body(inertia.get_mass(), center, about, count)
    limits = {}
    screws = {joint.name: joint for joint in robot.joints if joint.traits.advances}
    for name, joint in joints.items():
        if name in screws:  # Drake reads no limits of screws
            limits[name] = (screws[name].low, screws[name].high) if screws[name].limited else None
        elif joint.num_positions():
            low, high = joint.position_lower_limits(), joint.position_upper_limits()
            limits[name] = (low[0], high[0]) if len(low) == 1 and np.isfinite([low, high]).all() else None
    return Reading(bodies, limits, poses, source=(diagram, context))


def pinocchio_urdf(folder: Path, robot: Robot) -> Reading:
    import pinocchio

    model = pinocchio.buildModelFromUrdf(str(folder / "object.urdf"))
    data = model.createData()
    frames = {f.name: k for k, f in enumerate(model.frames) if f.type == pinocchio.FrameType.BODY and k}
    origin = matrix(np.eye(3), robot.links[0].origin)

    def poses(values: Values) -> dict[str, Matrix]:
        state = pinocchio.neutral(model)
        for name in [joint.name for joint in robot.joints if model.existJointName(joint.name)]:
            joint = model.joints[model.getJointId(name)]
            turns = joint.nq == 2  # without limits: cosine and sine
            state[joint.idx_q : joint.idx_q + joint.nq] = (
                [np.cos(values[name]), np.sin(values[name])] if turns else values[name]
            )
        pinocchio.framesForwardKinematics(model, data, state)
        return {name: origin @ data.oMf[k].homogeneous for name, k in frames.items()}

    bodies = {}
    held = [model.frames[k].parentJoint for k in frames.values()]
    for name, k in frames.items():
        own = model.inertias[model.frames[k].parentJoint]  # of all links that are fixed to one another
        alone = held.count(model.frames[k].parentJoint) == 1
        bodies[name] = Body(own.mass, own.lever, own.inertia) if alone else Body()
    limits = {}
    for name in list(model.names)[1:]:
        joint = model.joints[model.getJointId(name)]
        low, high = model.lowerPositionLimit[joint.idx_q], model.upperPositionLimit[joint.idx_q]
        limits[name] = (low, high) if joint.nq == 1 else None
    return Reading(bodies, limits, poses)


def newton_usd(folder: Path, robot: Robot) -> Reading:
    if any(joint.traits.advances for joint in robot.joints):
        pytest.skip("UsdPhysics has no screws")
    builder = _newton()
    builder.add_usd(str(folder / "object.usda"))
    links, joints = Names("Looks", "joints"), Names()
    found = _read_newton(
        builder, robot, {links(link.name): link.name for link in robot.links}, {joints(j.name): j for j in robot.joints}
    )
    moving = {j.name: k for k, j in found.source[1].items() if j.traits.moves and not j.traits.tilts}
    own = {joint.name: joint for joint in robot.joints}
    for name, k in moving.items():  # of these Newton reads its own attributes alone
        for values, value in (
            (builder.joint_friction, own[name].friction),
            (builder.joint_armature, own[name].armature),
            (builder.joint_velocity_limit, own[name].velocity),
        ):
            assert values[builder.joint_qd_start[k]] == pytest.approx(value, rel=1e-5)
    of = found.source[1]
    leaders = zip(builder.joint_mimic_joint, builder.joint_mimic_coeffs, strict=True)
    follows = {of[k].name: (of[led].name, factor, off) for k, (led, (off, factor)) in enumerate(leaders) if led >= 0}
    assert set(follows) == {joint.name for joint in robot.joints if joint.mimic}
    for name, (leader, factor, offset) in follows.items():
        mimic = own[name].mimic
        assert mimic is not None and leader == mimic[0]
        assert [factor, offset] == pytest.approx(mimic[1:], rel=1e-6, abs=1e-7)
    return found


def newton_urdf(folder: Path, robot: Robot) -> Reading:
    builder = _newton()
    builder.add_urdf(str(folder / "object.urdf"), floating=False)
    joints = {joint.name: joint for joint in robot.joints}
    return _read_newton(builder, robot, {link.name: link.name for link in robot.links}, joints)


def _newton():  # type: ignore[no-untyped-def]
    import newton
    import warp

    warp.config.quiet = True
    return newton.ModelBuilder()


def _read_newton(builder, robot: Robot, links: dict[str, str], joints: dict) -> Reading:  # type: ignore[no-untyped-def,type-arg]
    import newton

    names = [links[label.rsplit("/", 1)[-1]] for label in builder.body_label]
    told = {k: joints.get(label.rsplit("/", 1)[-1]) for k, label in enumerate(builder.joint_label)}
    of = {k: joint for k, joint in told.items() if joint is not None}  # but for what holds the base
    solid = [
        sum(
            bool(flags & newton.ShapeFlags.COLLIDE_SHAPES) and at == k
            for flags, at in zip(builder.shape_flags, builder.shape_body, strict=True)
        )
        for k in range(len(names))
    ]
    bodies = {
        name: Body(
            builder.body_mass[k],
            np.array(builder.body_com[k]),
            np.array(builder.body_inertia[k]).reshape(3, 3),
            solid[k],
        )
        for k, name in enumerate(names)
    }
    limits = {}
    for k, joint in of.items():
        if joint.traits.moves:
            at = builder.joint_qd_start[k]
            ends = builder.joint_limit_lower[at], builder.joint_limit_upper[at]
            limits[joint.name] = (
                ends if joint.limited and not joint.traits.tilts and max(map(abs, ends)) < 1e9 else None
            )
    model = builder.finalize(device="cpu")
    state, start = model.state(), model.joint_q.numpy()

    def poses(values: Values) -> dict[str, Matrix]:
        numbers = start.copy()
        for k, joint in of.items():
            at = builder.joint_q_start[k]
            if joint.traits.tilts:
                _, frame = frame_of(joint.axis)
                own = from_quaternion(*frame)
                turn = own.T @ _tilted(joint.axis, values[joint.name]) @ own
                numbers[at : at + 4] = quaternion(turn[None])[0][[1, 2, 3, 0]]
            elif joint.traits.moves:
                numbers[at] = values[joint.name]
        model.joint_q.assign(numbers)
        newton.eval_fk(model, model.joint_q, model.joint_qd, state)
        found = {}
        for name, (x, y, z, *turn) in zip(names, state.body_q.numpy().astype(np.float64), strict=True):
            found[name] = matrix(from_quaternion(*np.array(turn)[[3, 0, 1, 2]]), np.array([x, y, z]))
        return found

    return Reading(bodies, limits, poses, source=(model, of))


def _tilted(axis: np.ndarray, value: float) -> np.ndarray:
    """(3, 3) the tilt that the value of a ball is."""
    from artipg_dsl.annotate.frames import axis_angle

    return axis_angle(perpendicular_to(axis[None])[0], np.float64(value))
