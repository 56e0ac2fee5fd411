"""Which simulators are installed, which objects go in, and what came out."""

from __future__ import annotations

from dataclasses import dataclass
from importlib import import_module
from importlib.util import find_spec
from pathlib import Path

import numpy as np

from artipg_dsl.robot.model import Robot
from artipg_dsl.robot.robots import Robots
from artipg_dsl.runtime.batch import Batch
from artipg_dsl.session import Session

from .levels import Simulation

ROOT = Path(__file__).parents[2]
SHIPPED = sorted(path.stem for path in (ROOT / "categories").glob("*.apg"))
# categories that do not `require stable` and whose objects lie on a table as they are
LYING = {"eyeglasses", "keyboard", "phone", "remote", "stapler"}
STAGES = 12  # on the way of a loop
SIMULATORS = {"mujoco": "mujoco_sim:MujocoSim", "pybullet": "bullet_sim:BulletSim", "sapien": "sapien_sim:SapienSim"}


def simulator(package: str) -> type[Simulation] | None:
    """The adapter of a simulator; None where its package is not installed."""
    if find_spec(package) is None:
        return None
    module, name = SIMULATORS[package].split(":")
    return getattr(import_module(f".{module}", __package__), name)


@dataclass(frozen=True)
class Object:
    """A robot, and for the joints of closed loops the values of all joints on the way to both ends: what a user of a
    format without loops has to move along. ``bound`` are the joints that the loops determine. ``stands``: by itself, as
    against what a wall, a worktop or a hand holds: its category requires it to be stable, or to lie."""

    robot: Robot
    ways: dict[tuple[str, float], list[dict[str, float]]]
    bound: frozenset[str]
    stands: bool


def objects(category: str, count: int, seed: int) -> list[Object]:
    """Objects of a shipped category."""
    batch = Session.of(str(ROOT / "categories" / f"{category}.apg")).sampler.batch(np.arange(count), seed)
    made, stands = Robots(batch), np.full(count, category in LYING)
    for statement in batch.program.stable:
        stands[batch.owner(statement.scope)] = True
    return [Object(made.robot(i), *_loops(batch, i), bool(stands[i])) for i in range(count)]


def _loops(batch: Batch, i: int) -> tuple[dict[tuple[str, float], list[dict[str, float]]], frozenset[str]]:
    if batch.loops is None:
        return {}, frozenset()
    joints, rest = batch.joints(), batch.settle(batch.rest())
    rows = np.flatnonzero(joints.owner == i)
    led = batch.loops.driven(np.arange(len(joints.owner)))
    bound = {joints.name[k] for k in rows if led[k] != k}
    ways: dict[tuple[str, float], list[dict[str, float]]] = {}
    for k in rows:
        if led[k] == k and (led[rows] == k).sum() > 1:
            for end in (float(joints.high[k]), float(joints.low[k])):
                ways[joints.name[k], end] = []
                for share in np.linspace(0, 1, STAGES + 1)[1:]:
                    states = rest.copy()
                    states[k] = rest[k] + share * (end - rest[k])
                    settled = batch.settle(states)
                    ways[joints.name[k], end].append({joints.name[m]: float(settled[m]) for m in rows if led[m] == k})
    return ways, frozenset(bound)
