"""The levels, the same in every simulator.

*loads*: parses, with every link and joint there, by name. *step*: the first step is finite. *rest*: a second with a fixed
base drifts by less than 1 mm and 0.1 degree. *driven*: every joint, under gravity, within its effort, comes to both ends
within 2 % of its range, in three seconds; what it waits for is open meanwhile. *stands*: on a floor with a free base, a second and a
half later it has neither tilted by two degrees nor walked by a centimetre (objects that stand by themselves).
"""

from __future__ import annotations

from typing import Protocol

import numpy as np

from artipg_dsl.robot.model import RobotJoint

from .subject import Subject

LEVELS = ("loads", "step", "rest", "driven", "stands")
DRIVE_SECONDS, STEADY_SECONDS, STAND_SECONDS = 3.0, 0.2, 1.5
Poses = dict[str, tuple[np.ndarray, np.ndarray]]  # by link: place (3,), rotation as w, x, y, z


class Simulation(Protocol):
    """An object in a simulator; ``forms`` are the formats that the simulator reads."""

    name: str
    forms: tuple[str, ...]
    step_time: float
    follows: bool  # whether it moves what mimics another joint by itself

    def __init__(self, subject: Subject, free: bool = False): ...
    def links(self) -> set[str]: ...
    def joints(self) -> set[str]: ...
    def place(self, values: dict[str, float]) -> None:
        """Put the joints at these values, at rest, and take back all drives."""

    def drive(self, targets: dict[str, float]) -> None:
        """From now on drive joints to these values within their effort."""

    def step(self) -> None: ...
    def value(self, joint: str) -> float: ...
    def poses(self) -> Poses: ...
    def close(self) -> None: ...


def climb(simulation: type[Simulation], subject: Subject, most: int = 6, stands: bool = False) -> dict[str, str]:
    """What failed at each level, empty text where nothing did; ``most`` driven joints, spread over the object."""
    try:
        world = simulation(subject)
    except Exception as error:  # a simulator's own kind, whichever it is
        return dict.fromkeys(LEVELS if stands else LEVELS[:-1], f"{type(error).__name__}: {error}")
    try:
        missing = {link.name for link in subject.robot.links} - world.links()
        missing |= {joint.name for joint in subject.moving} - world.joints()
        found = {"loads": f"without {', '.join(sorted(missing))}" if missing else ""}
        world.place(subject.rest)
        before = world.poses()
        world.step()
        found["step"] = "" if finite(world.poses()) else "not finite"
        world.place(subject.rest)
        for _ in range(round(1.0 / world.step_time)):
            world.step()
        found["rest"] = drift(before, world.poses(), 1e-3, 0.1)
        limited = [j for j in subject.moving if None not in (j.low, j.high) and j.kind != "ball" and j.mimic is None]
        limited = [j for j in limited if j.name not in subject.bound]
        chosen = limited[:: max(1, -(-len(limited) // most))]
        found["driven"] = "; ".join(text for joint in chosen if (text := driven(world, subject, joint.name)))
    finally:
        world.close()
    if stands:
        found["stands"] = stand(simulation, subject)
    return found


def driven(world: Simulation, subject: Subject, name: str) -> str:
    """Which ends a joint did not come to."""
    joint = next(j for j in subject.moving if j.name == name)
    assert joint.low is not None and joint.high is not None
    missed, ahead = [], opened(subject, joint)
    ahead = {k: v for k, v in subject.values(ahead).items() if v != subject.rest[k]}  # with what follows it
    for end in (joint.high, joint.low):
        world.place(subject.rest | ahead)
        targets = ahead | {name: end}
        if not world.follows:  # then a user has to move the followers along
            targets |= {k: v for k, v in subject.values({name: end}).items() if v != subject.rest[k]}
        near, steady, steps = 0.02 * (joint.high - joint.low), 0, round(DRIVE_SECONDS / world.step_time)
        for stage in subject.ways.get((name, end), []):
            world.drive(stage)
            for _ in range(steps // 2 // len(subject.ways[name, end])):
                world.step()
        world.drive(subject.ways[name, end][-1] if (name, end) in subject.ways else targets)
        for _ in range(steps):
            world.step()
            steady = steady + 1 if abs(world.value(name) - end) <= near / 2 else 0
            if steady * world.step_time > STEADY_SECONDS:
                break
        if not abs(world.value(name) - end) <= near:
            missed.append(f"{name} at {world.value(name):.4g} of {end:.4g}")
    return ", ".join(missed)


def opened(subject: Subject, joint: RobotJoint) -> dict[str, float]:
    """The joints that a joint waits for, as far open as they go, and those that these wait for: simulators know of none."""
    found: dict[str, float] = {}
    for name, low, _ in joint.gates:
        gate = next(j for j in subject.moving if j.name == name)
        end = gate.high if np.isfinite(low) else gate.low
        assert end is not None
        found |= opened(subject, gate) | {name: end}
    return found


def stand(simulation: type[Simulation], subject: Subject) -> str:
    world = simulation(subject, free=True)
    try:
        world.place(subject.rest)
        root = subject.robot.links[0].name
        before = {root: world.poses()[root]}
        for _ in range(round(STAND_SECONDS / world.step_time)):
            world.step()
        return drift(before, world.poses(), 1e-2, 2.0)
    finally:
        world.close()


def finite(poses: Poses) -> bool:
    return all(np.isfinite(place).all() and np.isfinite(turn).all() for place, turn in poses.values())


def drift(before: Poses, after: Poses, length: float, degrees: float) -> str:
    """By how much the worst link is off, empty where within both bounds."""
    if not finite(after):
        return "not finite"
    worst = max(before, key=lambda name: np.linalg.norm(after[name][0] - before[name][0]))
    shift = float(np.linalg.norm(after[worst][0] - before[worst][0]))
    angles = {name: turned(before[name][1], after[name][1]) for name in before}
    most = max(angles, key=lambda name: angles[name])
    if shift < length and angles[most] < degrees:
        return ""
    return f"{worst} {1000 * shift:.1f} mm, {most} {angles[most]:.2f} degrees"


def turned(one: np.ndarray, other: np.ndarray) -> float:
    """Degrees between two rotations given as unit quaternions."""
    flat = float(np.linalg.norm(one - other * np.sign(one @ other)))  # exact for small angles, where arccos is not
    return float(np.degrees(4 * np.arcsin(min(1.0, flat / 2))))
