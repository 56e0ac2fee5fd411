"""MJCF and URDF read by MuJoCo, PyBullet and SAPIEN."""

from __future__ import annotations

from pathlib import Path

import numpy as np

from artipg_dsl.export.mjcf import qpos
from artipg_dsl.robot.model import Robot

from .reading import Body, Matrix, Reading, Values, from_quaternion, matrix, principal_to_full


def mujoco_mjcf(folder: Path, robot: Robot) -> Reading:
    return _mujoco(folder / "object.xml", robot)


def mujoco_urdf(folder: Path, robot: Robot) -> Reading:
    return _mujoco(folder / "object.urdf", robot)


def _mujoco(path: Path, robot: Robot) -> Reading:
    import mujoco

    model = mujoco.MjModel.from_xml_path(str(path))
    data = mujoco.MjData(model)
    names = [model.joint(i).name for i in range(model.njnt)]

    def poses(values: Values) -> dict[str, Matrix]:
        data.qpos[:] = qpos(robot, values, names) if path.suffix == ".xml" else [values[name] for name in names]
        mujoco.mj_kinematics(model, data)
        bodies = [data.body(i) for i in range(1, model.nbody)]
        return {body.name: matrix(body.xmat.reshape(3, 3), body.xpos) for body in bodies}

    bodies = {}
    for i in range(1, model.nbody):
        body = model.body(i)
        inertia = principal_to_full(body.inertia, from_quaternion(*body.iquat))
        solid = (model.geom_bodyid == i) & (model.geom_contype != 0)
        bodies[body.name] = Body(float(body.mass[0]), body.ipos, inertia, int(solid.sum()))
    joints = {}
    for i, name in enumerate(names):
        limited = model.jnt_limited[i] and model.jnt_type[i] != mujoco.mjtJoint.mjJNT_BALL
        joints[name] = tuple(model.jnt_range[i]) if limited else None
    zero = {joint.name: 0.0 for joint in robot.joints}
    poses(zero)
    corners = []
    for i in np.flatnonzero((model.geom_contype == 0) & (model.geom_type == mujoco.mjtGeom.mjGEOM_MESH)):
        mesh = model.geom_dataid[i]
        first, count = model.mesh_vertadr[mesh], model.mesh_vertnum[mesh]
        faces = model.mesh_face[model.mesh_faceadr[mesh] :][: model.mesh_facenum[mesh]]
        assert np.array_equal(np.unique(faces), np.arange(count)), "faces are lost: MuJoCo reads the first `o` alone"
        corners.append(model.mesh_vert[first : first + count] @ data.geom_xmat[i].reshape(3, 3).T + data.geom_xpos[i])
    every = np.concatenate(corners)
    return Reading(bodies, joints, poses, np.stack([every.min(axis=0), every.max(axis=0)]), zero)


def pybullet_urdf(folder: Path, robot: Robot) -> Reading:
    import pybullet

    client = pybullet.connect(pybullet.DIRECT)
    given = {"physicsClientId": client}
    flags = pybullet.URDF_USE_INERTIA_FROM_FILE
    body = pybullet.loadURDF(str(folder / "object.urdf"), useFixedBase=True, flags=flags, **given)
    info = [pybullet.getJointInfo(body, k, **given) for k in range(pybullet.getNumJoints(body, **given))]
    index = {pybullet.getBodyInfo(body, **given)[0].decode(): -1} | {row[12].decode(): row[0] for row in info}

    def frame(k: int) -> tuple[np.ndarray, np.ndarray]:
        """Of the inertia, in the link's frame."""
        data = pybullet.getDynamicsInfo(body, k, **given)
        return np.array(data[3]), from_quaternion(*np.array(data[4])[[3, 0, 1, 2]])

    def poses(values: Values) -> dict[str, Matrix]:
        for row in info:
            if row[2] != pybullet.JOINT_FIXED:
                pybullet.resetJointState(body, row[0], values[row[1].decode()], **given)
        found = {}
        for name, k in index.items():
            if k < 0:
                place, turn = pybullet.getBasePositionAndOrientation(body, **given)
                center, axes = frame(-1)
                whole = matrix(from_quaternion(*np.array(turn)[[3, 0, 1, 2]]), np.array(place))
                found[name] = whole @ np.linalg.inv(matrix(axes, center))
            else:
                state = pybullet.getLinkState(body, k, computeForwardKinematics=1, **given)
                found[name] = matrix(from_quaternion(*np.array(state[5])[[3, 0, 1, 2]]), np.array(state[4]))
        return found

    bodies = {}
    for name, k in index.items():
        data = pybullet.getDynamicsInfo(body, k, **given)
        center, axes = frame(k)
        count = len(pybullet.getCollisionShapeData(body, k, **given))
        # the mass of a fixed base reads 0
        mass = None if k < 0 else data[0]
        bodies[name] = Body(mass, center, None if k < 0 else principal_to_full(np.array(data[2]), axes), count)
    moving = [row for row in info if row[2] != pybullet.JOINT_FIXED]
    limits = {row[1].decode(): (row[8], row[9]) if row[8] <= row[9] else None for row in moving}
    return Reading(bodies, limits, poses)


def sapien_urdf(folder: Path, robot: Robot) -> Reading:
    import sapien
    from sapien import physx

    scene = sapien.Scene([physx.PhysxCpuSystem()])
    loader = scene.create_urdf_loader()
    loader.fix_root_link = True
    articulation = loader.load(str(folder / "object_physics.urdf"))
    parts, active = {link.name: link for link in articulation.links}, articulation.active_joints
    order = [joint.name for joint in active]

    def poses(values: Values) -> dict[str, Matrix]:
        if order:
            articulation.set_qpos([values[name] for name in order])
        return {name: link.entity.pose.to_transformation_matrix() for name, link in parts.items()}

    bodies = {}
    for name, link in parts.items():
        place = link.cmass_local_pose
        inertia = principal_to_full(np.asarray(link.inertia, np.float64), from_quaternion(*map(float, place.q)))
        bodies[name] = Body(float(link.mass), np.asarray(place.p), inertia, len(link.collision_shapes))
    limits = {}
    for joint in active:
        low, high = map(float, joint.limits[0])
        limits[joint.name] = (low, high) if np.isfinite([low, high]).all() else None
    return Reading(bodies, limits, poses, source=scene)
