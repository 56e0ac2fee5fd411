"""Trials of Where2Act by physics, in SAPIEN on the CPU: a hand comes to a point of a link and is led one way.

After Mo et al., Where2Act, ICCV 2021. The unit of length is theirs: half the diagonal of the object's box. A trial succeeds where a
joint that carries the point moves by more than 0.01 (rad, unit) or half of its range, the finger first meets that link, and,
but for plain pushes, the point goes within 60 degrees of where it was led. What differs from theirs: the hand. A push is
made by one round finger that is led 0.05 beyond the point, as their other motions are (their fingertips go 0.012 beyond,
less than a wide door needs to turn by 0.01), and before it goes sideways it comes on until it meets something; a pull is made by a
point that holds fast, like a sucker. Either hand is a spring, which pulls the harder the further it is behind.

Objects stand in SAPIEN in that unit, as Where2Act's do: PhysX leaves out corners of a hull that lie within 0.7 mm of the others,
and of the key of a phone in metres it leaves five.
"""

from __future__ import annotations

import warnings
from collections.abc import Callable, Iterator, Mapping
from dataclasses import replace
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any

import numpy as np

from ...export.urdf import urdf_files
from ...records import dataclass
from ...robot.model import Robot, RobotJoint
from ...robot.substitute import simple_joints
from .scaled import resistance_scale, scaled, value_scale

PRIMITIVES = ("pushing", "pushing-up", "pushing-left", "pulling", "pulling-up", "pulling-left")
PLAIN = ("revolute", "continuous", "prismatic")  # joints along which a hand is led
MISSED, BEGUN, FINGER = "met nothing", "starts in contact", "where2act finger"
MOVED, SHARE, ALONG = 0.01, 0.5, 0.5  # rad or unit; of the range; cosine
FAR = 0.05  # units that a hand is led
START = 0.038  # units before the point that a finger starts
PRESS = 0.0024  # units that a finger is pressed in before it goes sideways
RADIUS, LENGTH = 0.01, 0.15  # units of a finger
_MASS = 0.2  # kg of a finger
_CALMED = 4.0  # N s/m that a hand damps what it holds
# kg m2 or kg that joints have besides what they move, at most, and by which what follows is drawn
_ROTOR = (1e-3, 0.05)
GRIP = 4.0  # friction of finger and object
STIFF = 4000.0  # newton per metre of a hand
_DEEP = 0.02  # units that a finger comes on to meet what it is to go along
STEP = 1 / 500  # s
_SPEED = 0.1  # units per second
_WAIT = 0.4  # s at the end, unless all stands still before
STILL, CALM = 1e-4, 1.5  # rad or m in a tenth of a second; s that an object is given to come to rest
_IMPULSE = 1e-4  # N s above which a contact counts: 0.05 N over a step
_TOWED = 8e4  # 1/s2: how stiffly a follower is drawn after its leader, by its rotor
_LATCHED = 1e-4  # rad or m from rest within which a latch catches
NEAR = 1e-3  # m at which shapes are looked at for contact; SAPIEN's 1 cm takes every key of a keyboard for a neighbour of many
_LITTLE = 1e-4  # rad or m of a leader, over which is seen how fast others follow it
_BRISTLE = 1e-4  # rad or m by which a joint gives before its friction slips: P. R. Dahl, A Solid Friction Model, 1968


@dataclass(frozen=True)
class Trial:
    """``link`` (its number), ``point`` and ``normal`` with all joints at 0, in the object's frame; ``toward`` and ``lead``: the
    ways the finger comes and the hand is led, unit vectors in the object's frame as it stands."""

    primitive: str
    link: int
    point: np.ndarray
    normal: np.ndarray
    toward: np.ndarray
    lead: np.ndarray


@dataclass(frozen=True)
class Outcome:
    """``fault``: "" or what is wrong with how the finger met the object; ``values`` of the joints at the end, by name; ``start``
    and ``end`` (3,) of the point, in the object's frame."""

    fault: str
    values: dict[str, float]
    start: np.ndarray
    end: np.ndarray


def _sapien() -> Any:
    """The extra ``sim``, without its words about renderers: none is needed."""
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        import sapien
        import sapien.physx
    return sapien


def _untied(robot: Robot) -> Robot:
    """The same robot without joints that mimic others by another ratio than 1 or -1: SAPIEN 3.0.3 inverts it, which holds both fast."""
    simple = simple_joints(robot)
    return replace(
        simple, joints=tuple(replace(joint, mimic=joint.mimic if _ties(joint) else None) for joint in simple.joints)
    )


def _ties(joint: RobotJoint) -> bool:
    """Whether SAPIEN couples a joint as it should."""
    return joint.mimic is not None and abs(joint.mimic[1]) == 1.0


def sprung(simple: Robot, robot: Robot) -> Robot:
    """``simple_joints`` of a robot with the springs that URDF has no place for, and the friction and the damping beside them."""
    given = {joint.name: joint for joint in robot.joints if joint.stiffness}
    fields = ("stiffness", "friction", "damping")
    joints = (
        replace(joint, **{name: getattr(given[joint.name], name) for name in fields}) if joint.name in given else joint
        for joint in simple.joints
    )
    return replace(simple, joints=tuple(joints))


def _rotor(joint: RobotJoint) -> float:
    """The armature that MJCF and USD state, and URDF has no place for: without it a gram goes through the ends of its joint. kg m2
    or kg, and no more than a hand does not feel, but beside a spring, which it makes slow enough for a step."""
    return joint.armature if joint.stiffness else min(joint.armature, _ROTOR[joint.kind == "prismatic"])


@dataclass(eq=False)
class Latch:
    """Holds a ``joint`` of SAPIEN (number ``k``) where it rests while what it waits for is not there: ``gates`` are numbers of joints, from
    and to. Elsewhere it goes between its ``ends`` (1, 2). Within ``near`` of rest it catches."""

    joint: Any
    k: int
    rest: float
    near: float
    ends: np.ndarray
    gates: list[tuple[int, float, float]]
    shut: bool = False

    def free(self) -> None:
        self.shut = False
        self.joint.set_limits(self.ends)

    def turn(self, now: np.ndarray) -> None:
        """Shut or open it, with the joints at ``now``. What is latched stays so until it may go."""
        waits = any(not low <= now[gate] <= high for gate, low, high in self.gates)
        if self.shut and not waits:
            self.free()
        elif waits and not self.shut and abs(now[self.k] - self.rest) < self.near:
            self.shut = True
            self.joint.set_limits(np.array([[self.rest - self.near, self.rest + self.near]], dtype=np.float32))


def _scene(sapien: Any, per: float) -> Any:
    """One where a metre is ``per`` long, and gravity with it. SAPIEN keeps one setting for all scenes to come, which is put back."""
    given, config = (sapien.physx.get_scene_config() for _ in range(2))
    config.gravity = given.gravity * per
    sapien.physx.set_scene_config(config)
    try:
        scene = sapien.Scene([sapien.physx.PhysxCpuSystem()])
    finally:
        sapien.physx.set_scene_config(given)
    scene.set_timestep(STEP)
    return scene


class Standing:
    """One object in SAPIEN, its base held, with the friction and the damping that its file states. Joint values are by name,
    those of ``order``, in radians and metres. A joint that waits for others is latched while it rests and they are not there yet, and a
    spring draws its joint back: URDF has neither. What follows another joint is drawn after it, and what it rubs and weighs its leader
    feels.

    ``unit``: metres of what is 1 in the scene; ``per`` metre it has kilograms by the third power, newton by the fourth. ``long`` and ``heavy``
    (joints): what 1 of a joint's value is there, and 1 of what resists it."""

    def __init__(self, robot: Robot, unit: float = 1.0):
        sapien = _sapien()
        self.unit, self.per, simple = unit, 1.0 / unit, sprung(simple_joints(robot), robot)
        self.robot, self.scene = scaled(simple, unit), _scene(sapien, self.per)
        loader = self.scene.create_urdf_loader()
        loader.fix_root_link = True
        with TemporaryDirectory() as place:
            for name, data in urdf_files(_untied(self.robot)).items():
                (Path(place) / name).parent.mkdir(parents=True, exist_ok=True)
                (Path(place) / name).write_bytes(data)
            self.body = loader.load(str(Path(place) / "object_physics.urdf"))
        curves = {joint.name: joint.curve for joint in robot.joints}
        simple = replace(simple, joints=tuple(replace(j, curve=curves.get(j.name)) for j in simple.joints))
        stated = {joint.name: joint for joint in scaled(simple, unit).joints}
        self.active = self.body.active_joints
        self.order = [joint.name for joint in self.active]
        plain = {joint.name: joint for joint in simple.joints}
        self.long = np.array([value_scale(plain[name], unit) for name in self.order])
        self.heavy = np.array([resistance_scale(plain[name], unit) for name in self.order])
        self.bristle = _BRISTLE * self.long
        self.rubs = np.array([stated[name].friction for name in self.order])
        self.stiffness = np.array([stated[name].stiffness for name in self.order])
        self.rest = np.array([stated[name].rest for name in self.order])
        damping = np.array([stated[name].damping for name in self.order])
        self.fading = np.where(self.stiffness > 0, damping, 0.0)  # beside a spring, whatever rubs
        self.damping = damping - self.fading
        bodies = {link.name: link for link in self.body.links}
        self.links = [bodies[link.name] for link in robot.links]
        self.latches = list(self._latches(stated))
        for joint, name, heavy in zip(self.active, self.order, self.heavy, strict=True):
            joint.set_armature(np.array([_rotor(plain[name]) * heavy]))
        self.towed = list(self._towed(stated))

    def _latches(self, stated: Mapping[str, RobotJoint]) -> Iterator[Latch]:
        at = {name: k for k, name in enumerate(self.order)}
        for k, (name, joint) in enumerate(zip(self.order, self.active, strict=True)):
            gates = [(at[gate], low, high) for gate, low, high in stated[name].gates if gate in at]
            if gates:
                yield Latch(joint, k, stated[name].rest, _LATCHED * float(self.long[k]), joint.get_limits(), gates)

    def _towed(self, stated: Mapping[str, RobotJoint]) -> Iterator[tuple[int, int, RobotJoint, float]]:
        """Followers: their number, that of their leader, and how stiffly they are drawn. Leaders feel what they rub."""
        for k, name in enumerate(self.order):
            mimic = stated[name].mimic
            if mimic is None or mimic[0] not in self.order or _ties(stated[name]):
                continue
            stiff = _TOWED * _ROTOR[stated[name].kind == "prismatic"] * float(self.heavy[k])
            yield k, self.order.index(mimic[0]), stated[name], stiff
            ratio = 1.0
            while mimic is not None and mimic[0] in self.order:  # up to the one that leads all
                ratio, leader = ratio * mimic[1], self.order.index(mimic[0])
                mimic = stated[mimic[0]].mimic
            self.rubs[leader] += abs(ratio) * stated[name].friction
            self.rubs[k] = 0.0

    def _draw(self, now: np.ndarray) -> None:
        """Let springs draw, and leaders feel what follows them."""
        if not self.towed and not self.stiffness.any():
            return
        speed = np.asarray(self.body.get_qvel(), dtype=np.float64)
        self.body.set_qf(-self._tow(now) - self.stiffness * (now - self.rest) - self.fading * speed)

    def _tow(self, now: np.ndarray) -> np.ndarray:
        """Draw what follows. What its leaders (joints) feel of its weight: the drive of a follower does not reach them."""
        if not self.towed:
            return np.zeros(len(now))
        weighs, felt = np.asarray(self.body.compute_passive_force(True, False), dtype=np.float64), np.zeros(len(now))
        for k, leader, joint, _ in reversed(self.towed):
            little = _LITTLE * float(self.long[leader])
            here, beyond = (float(joint.following(now[leader] + more)) for more in (0.0, little))
            self.active[k].set_drive_target(here)
            felt[leader] += (beyond - here) / little * (felt[k] + weighs[k])
        return felt

    def place(self, values: Mapping[str, float]) -> None:
        """Put the joints there, at a standstill."""
        for latch in self.latches:
            latch.free()
        self.body.set_qpos(np.array([values[name] for name in self.order]) * self.long)
        self.body.set_qvel(np.zeros(len(self.order)))
        self.held = self.now()
        known = zip(self.active, self.rubs, self.damping, self.held, self.bristle, strict=True)
        for joint, rubs, damping, at, bristle in known:
            joint.set_friction(0.0)
            stiff = rubs / bristle  # a drive that holds the joint where it is, with no more force than its friction
            limit = {"force_limit": rubs} if rubs > 0 else {}
            joint.set_drive_properties(stiff, stiff * STEP if rubs > 0 else damping, mode="force", **limit)
            joint.set_drive_target(at)
        for k, _, _, stiff in self.towed:
            damping = 2 * np.sqrt(_TOWED) / _TOWED * stiff
            self.active[k].set_drive_properties(stiff, damping, mode="force")
        self._draw(self.held)

    def now(self) -> np.ndarray:
        """Values in the scene."""
        return np.asarray(self.body.get_qpos(), dtype=np.float64)

    def values(self) -> dict[str, float]:
        return dict(zip(self.order, (self.now() / self.long).tolist(), strict=True))

    def step(self) -> None:
        now = self.now()
        for latch in self.latches:
            latch.turn(now)
        self._draw(now)
        off = self.held - now
        slips = (np.abs(off) > self.bristle) & (self.rubs > 0)
        for k in np.flatnonzero(slips):  # what slips is held where it has come to
            self.held[k] = now[k] + np.copysign(self.bristle[k], off[k])
            self.active[k].set_drive_target(self.held[k])
        self.scene.step()

    def settle(self, values: Mapping[str, float]) -> dict[str, float] | None:
        """Where the joints come to rest from there by themselves; None if they do not in ``CALM`` seconds."""
        self.place(values)
        return self.values() if self._calm(CALM, self.step) else None

    def _calm(self, seconds: float, step: Callable[[], None]) -> bool:
        """Step until the joints have stood still for a tenth of a second; whether they do within so many."""
        before, tenth = self.now(), round(0.1 / STEP)
        for _ in range(round(seconds / STEP / tenth)):
            for _ in range(tenth):
                step()
            now = self.now()
            if (np.abs(now - before) / self.long).max(initial=0.0) < STILL:
                return True
            before = now
        return False

    def frame(self, link: int) -> tuple[np.ndarray, np.ndarray]:
        """Where a link stands in the scene: rotation (3, 3) and origin (3,)."""
        pose = self.links[link].entity_pose
        return pose.to_transformation_matrix()[:3, :3].astype(float), np.asarray(pose.p, float)


class Arena(Standing):
    """An object and a finger in a scene in its units. ``groups`` (links): links of one number move as one."""

    def __init__(self, robot: Robot, unit: float, groups: np.ndarray):
        super().__init__(robot, unit)
        sapien = _sapien()
        self.groups, self.pose, heavy = groups, sapien.Pose, self.per**3
        self.number = {link.entity.name: k for k, link in enumerate(self.links)}
        skin = sapien.physx.PhysxMaterial(GRIP, GRIP, 0.01)
        builder, half = self.scene.create_actor_builder(), LENGTH / 2
        builder.add_capsule_collision(sapien.Pose([-half, 0, 0]), RADIUS, half, material=skin)
        self.finger = builder.build(FINGER)
        self.mass = self.finger.find_component_by_type(sapien.physx.PhysxRigidDynamicComponent)
        self.mass.disable_gravity = True
        self.mass.set_locked_motion_axes([False] * 3 + [True] * 3)
        self.mass.set_mass(_MASS * heavy)
        self.mass.set_inertia([1e-2 * heavy] * 3)
        for shape in (shape for body in (*self.links, self.mass) for shape in body.collision_shapes):
            shape.physical_material, shape.contact_offset = skin, NEAR * self.per
        self.drive = self.scene.create_drive(None, sapien.Pose(), self.finger, sapien.Pose())
        for axis in "xyz":
            draws = heavy * STIFF, heavy * 2 * np.sqrt(STIFF * _MASS), 1e6 * heavy * self.per
            getattr(self.drive, f"set_drive_property_{axis}")(*draws, "force")

    def place(self, values: Mapping[str, float]) -> None:
        self._finger(np.array([0.0, 0.0, -20.0]), np.array([1.0, 0, 0]))
        super().place(values)

    def _finger(self, place: np.ndarray, along: np.ndarray) -> None:
        self.finger.set_pose(self.pose(place, turned(along)))
        self.mass.set_linear_velocity([0, 0, 0])
        self.mass.set_angular_velocity([0, 0, 0])
        self.drive.set_drive_target(self.pose(place))

    def _lead(self, path: np.ndarray) -> Iterator[np.ndarray]:
        """Move the finger along places (k, 3), one a step."""
        for at in path:
            self.drive.set_drive_target(self.pose(at))
            self.step()
            yield at

    def run(self, trial: Trial, values: Mapping[str, float]) -> Outcome:
        """One trial from these joint values, at which the object is still."""
        self.place(values)
        turn, shift = self.frame(trial.link)
        local = trial.point * self.per - self.robot.links[trial.link].origin
        start, normal = turn @ local + shift, turn @ trial.normal
        if trial.primitive.startswith("pushing"):
            fault = self._push(trial, start, normal)
        else:
            self._hold(trial, local, start)
            fault = ""
        turn, shift = self.frame(trial.link)
        return Outcome(fault, self.values(), start * self.unit, (turn @ local + shift) * self.unit)

    def _push(self, trial: Trial, point: np.ndarray, normal: np.ndarray) -> str:
        touch, sideways = point + normal * RADIUS, trial.primitive != "pushing"
        begin = touch - trial.toward * START
        self._finger(begin, trial.toward)
        self.links[0].put_to_sleep()  # it stands: what touches it wakes it
        self.step()
        if self._met() is not None:
            return BEGUN
        met, at = None, begin
        path = line(begin, touch + trial.toward * (_DEEP if sideways else FAR))
        for now in self._lead(path):
            at = now
            if met is None:
                met = self._met()
                if met is not None and self.groups[met] != self.groups[trial.link]:
                    return f"met {self.robot.links[met].name}"
            if sideways and met is not None:
                break
        if met is None:
            return MISSED
        if sideways:
            pressed = at + trial.toward * PRESS
            aside = line(pressed, pressed + trial.lead * FAR)
            for _ in self._lead(np.concatenate([line(at, pressed), aside])):
                pass
        self._calm(_WAIT, self.step)
        return ""

    def _met(self) -> int | None:
        """The link that the finger presses, of several the one that is pressed most."""
        found, most = None, _IMPULSE * self.per**4
        for contact in self.scene.get_contacts():
            names = [body.entity.name for body in contact.bodies]
            if FINGER not in names:
                continue
            size = max((float(np.sqrt(p.impulse @ p.impulse)) for p in contact.points), default=0.0)
            if size > most:
                found, most = self.number[names[1 - names.index(FINGER)]], size
        return found

    def _hold(self, trial: Trial, local: np.ndarray, point: np.ndarray) -> None:
        """By forces at the point: a spring between hand and link would draw light links on against what their joints rub."""
        link, path = self.links[trial.link], line(point, point + trial.lead * FAR)
        here, before, heavy = self.pose(local), point, self.per**3

        def draw(at: np.ndarray) -> None:
            nonlocal before
            now = (link.entity_pose * here).p
            link.add_force_at_point(heavy * (STIFF * (at - now) - _CALMED / STEP * (now - before)), now)
            before = now
            self.step()

        for at in path:
            draw(at)
        self._calm(_WAIT, lambda: draw(path[-1]))


def line(begin: np.ndarray, end: np.ndarray) -> np.ndarray:
    """Places (k, 3) of a hand on its way, one a step."""
    far = np.sqrt(((end - begin) ** 2).sum())
    steps = max(1, round(far / _SPEED / STEP))
    return begin + np.linspace(0, 1, steps + 1)[1:, None] * (end - begin)


def turned(along: np.ndarray) -> np.ndarray:
    """A quaternion w x y z that turns x to ``along``."""
    w = 1 + along[0]
    if w < 1e-6:
        return np.array([0.0, 0, 0, 1])
    made = np.array([w, 0.0, -along[2], along[1]])
    return made / np.sqrt(made @ made)


def succeeds(
    primitive: str, fault: str, gone: np.ndarray, span: np.ndarray, slides: np.ndarray, unit: float, cosine: float
) -> bool:
    """Where2Act's rule for joints that have ``gone`` (k,) of their ``span``; ``slides`` those in metres."""
    if fault:
        return False
    moved = (gone > np.where(slides, MOVED * unit, MOVED)) | (gone > SHARE * span)
    return bool(moved.any()) and (primitive == "pushing" or cosine > ALONG)
