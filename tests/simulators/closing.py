"""Whether a gripper that closes on a grasp holds what it grips, in SAPIEN on the CPU: two fingers on exported objects.

The fingers are boxes of the size that the grasp states, opened as it says, on a carrier that is moved. They close with ``FORCE``
each, then the carrier goes as the joint of the gripped link would carry the hand: by ``WAY`` metres or ``TURN`` radians, or
as far as the joint has room, whichever is least, away from rest. The grasp holds where the link goes with it, by ``KEPT`` of the way, and has
not slipped out of the fingers by more than ``SLIP``, and both fingers still press on it. Object and gripper stand in the object's own unit,
as they do for trials (``artipg_dsl/layouts/where2act/hand.py``).
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import Any

import numpy as np
import sapien
from sapien import physx

from artipg_dsl.annotate.annotation import annotate
from artipg_dsl.annotate.states import joint_twist, own_joints
from artipg_dsl.export.partnet.mobility import folder_frame
from artipg_dsl.layouts.where2act.hand import GRIP, NEAR, STEP, Standing
from artipg_dsl.robot.pose import rest_values
from artipg_dsl.robot.robots import Robots
from artipg_dsl.robot.substitute import simple_joints
from artipg_dsl.runtime.batch import Batch

from .fingers import Hand, turned

FORCE = 60.0  # newton, of each finger; a Panda's hold with up to 70
FRICTION = GRIP  # Where2Act's; rubber has 0.8 to 1, with which round knobs slip out
CLOSES, MOVES, RESTS = 0.4, 0.8, 0.2  # s
WAY, TURN = 0.05, 0.5  # m, rad
KEPT, SLIP = 0.8, 0.01  # of the way; m
SOFT = 0.0005  # m that a finger is behind where it presses with all of its force
MASS, INERTIA = 0.1, 1e-3  # kg and kg m2 of a finger
UPRIGHT = 1e3  # Nm/rad that keep a finger from tilting: the limits of a drive give way
ITERATIONS = 60  # of the solver: with 25, fingers creep on what is round or conical
ROLLING = ("drum", "disc", "fork", "pedal")


@dataclass(frozen=True)
class Grip:
    """A grasp and what came of it: ``fault`` is "" where it held."""

    object: int
    name: str
    link: str
    joint: str
    fault: str


class Gripper:
    """Two fingers on a carrier in the scene of an object. A ``hand`` and poses are in the units of the scene, where a metre is ``per`` long."""

    def __init__(self, stands: Standing, hand: Hand):
        self.stands, self.hand, self.per = stands, hand, stands.per
        scene, skin, per = stands.scene, physx.PhysxMaterial(FRICTION, FRICTION, 0.0), stands.per
        builder = scene.create_actor_builder()
        builder.set_physx_body_type("kinematic")
        self.carrier = builder.build("carrier")
        self.body = self.carrier.find_component_by_type(physx.PhysxRigidDynamicComponent)
        pose = self.pose(hand.point, hand.frame)
        self.carrier.set_pose(pose)
        self.fingers, self.drives = [], []
        mass, stiff = MASS * per**3, FORCE / SOFT * per**3
        for name, side in (("left", 1.0), ("right", -1.0)):
            builder = scene.create_actor_builder()
            center = sapien.Pose([0, side * hand.thickness / 2, hand.pad - hand.length / 2])
            builder.add_box_collision(center, [hand.width / 2, hand.thickness / 2, hand.length / 2], material=skin)
            finger = builder.build(name)
            at = sapien.Pose([0, side * hand.opening / 2, 0])
            finger.set_pose(pose * at)
            body = finger.find_component_by_type(physx.PhysxRigidDynamicComponent)
            body.disable_gravity = True
            body.set_mass(mass)
            body.set_inertia([INERTIA * per**5] * 3)
            body.set_solver_position_iterations(ITERATIONS)
            touch([body], per)
            drive = scene.create_drive(self.carrier, sapien.Pose(), finger, sapien.Pose())
            drive.set_limit_x(0, 0)
            drive.set_limit_z(0, 0)
            drive.set_limit_twist(0, 0)
            drive.set_limit_cone(0, 0)
            drive.set_drive_property_y(stiff, 2 * np.sqrt(mass * stiff), 1e6 * per**4, "force")
            drive.set_drive_property_slerp(
                UPRIGHT * per**5, 2 * np.sqrt(UPRIGHT * INERTIA) * per**5, 1e6 * per**5, "force"
            )
            drive.set_drive_target(at)
            self.fingers.append(finger)
            self.drives.append(drive)

    @staticmethod
    def pose(point: np.ndarray, frame: np.ndarray) -> sapien.Pose:
        whole = np.eye(4)
        whole[:3, :3], whole[:3, 3] = frame, point
        return sapien.Pose(whole)

    def close(self) -> None:
        """Each finger comes on until it is ``SOFT`` behind, which is where it presses with ``FORCE``."""
        steps, soft = round(CLOSES / STEP), SOFT * self.per
        at = [self.hand.opening / 2] * 2
        for _ in range(steps):
            inward = self.carrier.get_pose().inv()
            for k, side in enumerate((1.0, -1.0)):
                y = side * float((inward * self.fingers[k].get_pose()).p[1])
                if y - at[k] < soft:
                    at[k] -= (self.hand.opening / 2 + 4e-3 * self.per) / steps
                    self.drives[k].set_drive_target(sapien.Pose([0, side * at[k], 0]))
            self.stands.step()

    def move(self, poses: list[sapien.Pose]) -> None:
        for pose in poses:
            self.body.set_kinematic_target(pose)
            self.stands.step()

    def presses(self, link: sapien.Entity) -> bool:
        """Whether both fingers press on a link."""
        found = set()
        for contact in self.stands.scene.get_contacts():
            pair = [body.entity for body in contact.bodies]
            if link in pair and any(p.impulse @ p.impulse > 0 for p in contact.points):
                found |= {entity.name for entity in pair if entity in self.fingers}
        return len(found) == 2

    def remove(self) -> None:
        for entity in (*self.fingers, self.carrier):
            self.stands.scene.remove_entity(entity)


def grips(batch: Batch) -> list[Grip]:
    """What becomes of every grasp that a hand can make at rest on a link that a joint moves and nothing holds shut."""
    robots, own, told = Robots(batch), own_joints(batch), annotate(batch)
    motion, rest = joint_twist(batch), batch.settle(batch.rest())
    first, joints, found = np.searchsorted(batch.links().owner, np.arange(len(batch))), batch.joints(), []
    held = np.zeros(len(joints.owner), dtype=bool)
    if batch.gates is not None:
        held[batch.gates.joint[batch.gates.held(rest)]] = True
    held |= np.asarray(joints.mimic) >= 0
    for i, one in enumerate(told):
        names = [link["name"] for link in one["links"]]
        chosen = []
        for grasp in one["grasps"]:
            joint = int(own[first[i] + names.index(grasp["link"])])
            path = batch.program.links[batch.links().definition[first[i] + names.index(grasp["link"])]].path
            if joint < 0 or held[joint] or not grasp["reachable"] or any(w in path.split(".") for w in ROLLING):
                continue
            if joints.kind[joint] in ("revolute", "continuous", "prismatic"):
                chosen.append((grasp, joint, path))
        if not chosen:
            continue
        robot = robots.robot(i)
        stands = Standing(robot, folder_frame(robot).unit)
        stands.body.set_solver_position_iterations(ITERATIONS)
        touch(stands.links, stands.per)
        values = rest_values(simple_joints(robot))
        for grasp, joint, path in chosen:
            low, high = (rest[joint] if np.isnan(e) else float(e) for e in (joints.low[joint], joints.high[joint]))
            sign = 1.0 if high - rest[joint] >= rest[joint] - low else -1.0
            endless = joints.kind[joint] == "continuous" or high == low
            room = np.inf if endless else abs((high if sign > 0 else low) - rest[joint])
            twist = motion.turn[joint], motion.shift[joint]
            stands.place(values)
            fault = hold(stands, hand_of(grasp), stands.links[names.index(grasp["link"])].entity, *twist, sign, room)
            found.append(Grip(i, grasp["name"], path, joints.name[joint], fault))
    return found


def touch(bodies: list[Any], per: float) -> None:
    """Give their shapes the friction of the fingers, and look for contacts within a millimetre."""
    skin = physx.PhysxMaterial(FRICTION, FRICTION, 0.0)
    for shape in (shape for body in bodies for shape in body.collision_shapes):
        shape.physical_material, shape.contact_offset = skin, NEAR * per


def hand_of(grasp: dict[str, Any]) -> Hand:
    return Hand(np.array(grasp["point"]), turned(grasp["quaternion"]), grasp["opening"], **(grasp["gripper"] or {}))


def hold(
    stands: Standing, hand: Hand, link: sapien.Entity, turn: np.ndarray, shift: np.ndarray, sign: float, room: float
) -> str:
    """One grasp: closed, led along the twist ``turn x p + shift`` of a joint, ``room`` radians or metres at most."""
    per, rate = stands.per, float(np.sqrt(turn @ turn))
    hand = replace(
        hand,
        **{name: getattr(hand, name) * per for name in ("point", "opening", "width", "length", "thickness", "pad")},
    )
    if rate > 0:  # radians stay
        shift = shift * per
    else:
        room = room * per
    start = link.get_pose()
    gripper = Gripper(stands, hand)
    gripper.close()
    if not gripper.presses(link):
        gripper.remove()
        return "closes on nothing"
    place = np.cross(turn, hand.point) + shift
    speed = float(np.sqrt(place @ place))
    far = min(0.9 * room, WAY * per / max(speed, 1e-9), TURN if rate > 0 else np.inf)
    inverse = link.get_pose().inv() * sapien.Pose(hand.point)
    steps = round(MOVES / STEP)
    poses = [screw(hand, turn, shift, sign * far * k / steps) for k in range(1, steps + 1)]
    gripper.move(poses + [poses[-1]] * round(RESTS / STEP))
    gone, pressed = sign * along(link.get_pose(), start, turn, shift), gripper.presses(link)
    apart = poses[-1].p - (link.get_pose() * inverse).p
    gripper.remove()
    if gone < KEPT * far:
        return f"goes {gone / far:.0%} of the way"
    if not pressed:
        return "comes loose"
    return "" if float(np.sqrt(apart @ apart)) <= SLIP * per else "slips"


def along(now: sapien.Pose, start: sapien.Pose, turn: np.ndarray, shift: np.ndarray) -> float:
    """How far a link has come by a joint's twist, as far as that joint alone would have to go: in a chain, others may go, too."""
    rate = float(np.sqrt(turn @ turn))
    if rate == 0:
        return float((now.p - start.p) @ shift / (shift @ shift))
    w, *way = (now * start.inv()).q
    about = np.array(way) @ turn / rate
    return 2 * float(np.arctan2(about if w >= 0 else -about, abs(w))) / rate  # q and -q are one turn


def screw(hand: Hand, turn: np.ndarray, shift: np.ndarray, amount: float) -> sapien.Pose:
    """The hand carried by a joint's twist so far."""
    rate = float(np.sqrt(turn @ turn))
    if rate == 0:
        return Gripper.pose(hand.point + amount * shift, hand.frame)
    axis, angle = turn / rate, amount * rate
    x, y, z = axis
    cross = np.array([[0, -z, y], [z, 0, -x], [-y, x, 0]])
    rotation = np.eye(3) + np.sin(angle) * cross + (1 - np.cos(angle)) * cross @ cross
    origin = np.cross(turn, shift) / rate**2
    return Gripper.pose(rotation @ (hand.point - origin) + origin, rotation @ hand.frame)
