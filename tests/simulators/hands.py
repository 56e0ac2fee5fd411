"""Whether a hand moves what a label says it moves: a bounded force on labelled points of exported objects, in MuJoCo.

The label says where, the word which way: a push along the inward normal, a pull along the outward one, what is held along its own
motion. It counts as moved where a joint that carries the point goes on by 0.01 (rad, m) or half of its range more than it does by itself,
and, but for pushes, the point goes where it is led. Opening, pulling, turning begin at rest; closing with the joint half way
open; pushing and pressing at either.
"""

from __future__ import annotations

from collections import Counter
from dataclasses import dataclass
from pathlib import Path

import mujoco
import numpy as np

from artipg_dsl.annotate.cloud import Points, sample_points
from artipg_dsl.annotate.sampling import Sampling
from artipg_dsl.annotate.states import Twist, own_joints, twist
from artipg_dsl.robot.model import Robot
from artipg_dsl.robot.robots import Robots
from artipg_dsl.runtime.batch import Batch

from .subject import written

WORDS: dict[str, tuple[tuple[str, ...], tuple[str, ...]]] = {
    "push": (("push",), ("rest", "half")),
    "press": (("push",), ("rest", "half")),
    "pull": (("pull",), ("rest",)),
    "open": (("pull", "push"), ("rest",)),
    "close": (("push", "pull"), ("half",)),
    "lift": (("hold",), ("rest",)),
    "turn": (("hold",), ("rest",)),
    "slide": (("hold",), ("rest",)),
    "roll": (("hold",), ("rest",)),
}
"""By word: how the hand acts, any of which will do, and in which states."""
LED = ("pull", "open", "close")  # what a hand that grips also does by going along
FORCE = 50.0  # newton
TIME = 0.5  # seconds
ALIKE = 4  # links of one object that are moved by joints of one declaration, such as keys
ENOUGH, SHARE, ALONG = 0.01, 0.5, 0.5  # rad or m; of the range; cosine of motion and force


@dataclass(frozen=True)
class Trial:
    """One point: where it lies, whether the word is on it, whether the hand moved it."""

    object: int
    word: str
    link: str
    labelled: bool
    moved: bool
    place: list[float]
    normal: list[float]


class Bench:
    """One object in MuJoCo, its base held."""

    def __init__(self, batch: Batch, i: int, robot: Robot, folder: Path):
        self.model = mujoco.MjModel.from_xml_path(str(folder / "object.xml"))
        self.data = mujoco.MjData(self.model)
        self.batch, self.robot = batch, robot
        self.rows = np.flatnonzero(batch.joints().owner == i)
        self.names = [batch.joints().name[k] for k in self.rows]
        self.first = int(np.searchsorted(batch.links().owner, i))
        self.own = own_joints(batch)
        self.steps = int(TIME / self.model.opt.timestep)
        self.alone: dict[bytes, np.ndarray] = {}

    def chain(self, link: int) -> list[int]:
        """The moving joints (rows of the table) between a link of the object and its root."""
        joints, found, at = self.batch.joints(), [], link
        by_child = {int(joints.child[k]): int(k) for k in self.rows}
        while at in by_child:
            row = by_child[at]
            if joints.kind[row] != "fixed":
                found.append(row)
            at = int(joints.parent[row])
        return found

    def states(self, name: str, chain: list[int]) -> list[np.ndarray]:
        """All joint values (J,) to begin with: at rest, or with one of the joints half way to the farther end; what they wait
        for has come."""
        rest, joints, gates = self.batch.rest(), self.batch.joints(), self.batch.gates
        if gates is not None:
            rest = gates.open(rest, np.isin(np.arange(len(rest)), chain), joints.low, joints.high)
        rest = self.batch.settle(rest)
        if name == "rest":
            return [rest]
        found, first = [], int(self.rows[0])
        for row in chain:
            while joints.mimic[row] >= 0:  # goes with another
                row = first + int(joints.mimic[row])
            low, high = float(joints.low[row]), float(joints.high[row])
            if joints.kind[row] in ("continuous", "ball") or np.isnan(low) or np.isnan(high):
                continue
            end = high if high - rest[row] >= rest[row] - low else low
            state = rest.copy()
            state[row] = (rest[row] + end) / 2
            found.append(self.batch.settle(state))
        return found

    def place(self, values: np.ndarray) -> None:
        mujoco.mj_resetData(self.model, self.data)
        for row, name in zip(self.rows, self.names, strict=True):
            kind = self.batch.joints().kind[row]
            if kind in ("fixed", "ball"):
                continue
            self.data.joint(name).qpos[0] = values[row]
            if kind == "screw":
                pitch = next(j.pitch for j in self.robot.joints if j.name == name)
                self.data.joint(f"{name}_advance").qpos[0] = values[row] * pitch / (2 * np.pi)
        mujoco.mj_forward(self.model, self.data)

    def read(self, chain: list[int]) -> np.ndarray:
        out = []
        for row in chain:
            found = self.data.joint(self.batch.joints().name[row]).qpos
            out.append(2 * np.arccos(min(abs(found[0]), 1.0)) if len(found) == 4 else found[0])
        return np.array(out)

    def by_itself(self, values: np.ndarray, chain: list[int]) -> np.ndarray:
        """What the joints of a chain do without a hand, step by step."""
        key = values.tobytes() + np.array(chain).tobytes()
        if key not in self.alone:
            self.place(values)
            told = []
            for _ in range(self.steps):
                mujoco.mj_step(self.model, self.data)
                told.append(self.read(chain))
            self.alone[key] = np.array(told)
        return self.alone[key]

    def strength(self, word: str, link: int) -> float:
        """Newtons. What is lifted off may need both hands: they give what its joint says it takes, 260 N for a full bottle of water."""
        joints = self.batch.joints()
        lifts = [joints.effort[row] for row in self.chain(link) if word == "lift" and joints.kind[row] == "prismatic"]
        return float(np.nanmax([FORCE, *lifts]))

    def act(self, values: np.ndarray, link: int, local: np.ndarray, force: np.ndarray, follow: bool) -> bool:
        """Whether a force (newton) at a point moves it, both in the frame of its link; ``follow``: it has to go along."""
        chain = self.chain(link)
        alone = self.by_itself(values, chain)
        limits = np.array([self.span(row) for row in chain])
        self.place(values)
        body = self.data.body(self.robot.links[link].name)
        start = body.xpos + body.xmat.reshape(3, 3) @ local
        led = body.xmat.reshape(3, 3) @ force
        for step in range(self.steps):
            turn = body.xmat.reshape(3, 3)
            at = body.xpos + turn @ local
            self.data.qfrc_applied[:] = 0
            mujoco.mj_applyFT(self.model, self.data, turn @ force, np.zeros(3), at, body.id, self.data.qfrc_applied)
            mujoco.mj_step(self.model, self.data)
            gone = np.abs(self.read(chain) - alone[step])
            if (gone > np.minimum(ENOUGH, SHARE * limits)).any():
                mujoco.mj_kinematics(self.model, self.data)
                way = body.xpos + body.xmat.reshape(3, 3) @ local - start
                if not follow or way @ led > ALONG * np.sqrt((way @ way) * (led @ led)):
                    return True
        return False

    def span(self, row: int) -> float:
        joints = self.batch.joints()
        low, high = float(joints.low[row]), float(joints.high[row])
        return np.inf if np.isnan(low) or np.isnan(high) or joints.kind[row] == "continuous" else high - low

    def frame(self, values: np.ndarray, link: int) -> tuple[np.ndarray, np.ndarray]:
        self.place(values)
        body = self.data.body(self.robot.links[link].name)
        return body.xmat.reshape(3, 3).copy(), body.xpos.copy()


def trials(batch: Batch, points: int = 400, each: int = 3, others: bool = True) -> list[Trial]:
    """Of every word on every link that moves, up to ``each`` labelled points, and as many ``others`` of the same link."""
    cloud = sample_points(batch, Sampling(points, per="link"))
    robots, motion, found = Robots(batch), twist(batch), []
    for i in range(len(batch)):
        with written(robots.robot(i), "mjcf") as subject:
            bench = Bench(batch, i, subject.robot, subject.folder)
            kinds: Counter[int] = Counter()
            for row in np.flatnonzero(cloud.object == i):
                link = int(cloud.link[row, 0])
                chain = bench.chain(link)
                if not chain:
                    continue
                kind = int(batch.joints().definition[chain[0]])
                kinds[kind] += 1
                if kinds[kind] <= ALIKE:
                    found += on_link(bench, i, cloud, int(row), link, motion, each, others)
    return found


def on_link(
    bench: Bench, i: int, cloud: Points, row: int, link: int, motion: Twist, each: int, others: bool
) -> list[Trial]:
    rest = bench.batch.settle(bench.batch.rest())
    turn, shift = bench.frame(rest, link)
    gripped = cloud.labels.get("affordance.grasp")
    found = []
    for word in WORDS:
        label = cloud.labels.get(f"affordance.{word}")
        if label is None or not (label[row] > 0).any():
            continue
        strength = bench.strength(word, link)
        for value in (True, False)[: 1 + others]:
            for k in spread(np.flatnonzero((label[row] > 0) == value), each):
                p, n = cloud.position[row, k], cloud.normal[row, k]
                v = motion.at(np.array(bench.first + link), p)
                speed = np.sqrt(v @ v)
                v = v / speed if speed > 1e-9 else n
                moved = False
                held = word in LED and gripped is not None and gripped[row, k] > 0
                for act in (*WORDS[word][0], *(("hold",) if held else ())):
                    forces = {"push": (-n,), "pull": (n,), "hold": (v, -v)}[act]
                    for force in forces:
                        for state in WORDS[word][1]:
                            for values in bench.states(state, bench.chain(link)):
                                moved = moved or bench.act(
                                    values, link, turn.T @ (p - shift), strength * (turn.T @ force), act != "push"
                                )
                name = bench.robot.links[link].name
                found.append(Trial(i, word, name, value, moved, p.round(4).tolist(), n.round(3).tolist()))
    return found


def spread(at: np.ndarray, count: int) -> np.ndarray:
    """Up to ``count`` of some points, evenly among them: neighbours lie on one primitive."""
    return at[np.unique(np.linspace(0, len(at) - 1, count).astype(int))] if len(at) else at
