"""Which trials are made of an object, what its annotations say of each, and what came of it.

Random ones: a joint's declaration at random, one of its links, a point of its surface that can be seen from outside, a
direction at random in the half of the sphere that meets the surface, and a primitive. Ones of a word: a labelled point that can be
seen as things stand, led as the word says, where its joint has room for that (a push along the inward normal, a pull along the outward
one, what is held along its own motion), and for comparison any point of the same link in any direction by the same primitive. The
joints are at rest, or each of them with even odds at rest or anywhere, or what others wait for is open; as things come to stand by
themselves.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np
import trimesh

from artipg_dsl.annotate.cloud import sample_points
from artipg_dsl.annotate.sampling import Sampling
from artipg_dsl.annotate.states import draw_values, joint_twist, own_joints
from artipg_dsl.export.partnet.mobility import folder_frame
from artipg_dsl.geometry.outside import spread_directions
from artipg_dsl.layouts.where2act.files import led_links
from artipg_dsl.layouts.where2act.forecast import BLOCKED, Scene, foretell
from artipg_dsl.layouts.where2act.hand import Arena, Trial, succeeds
from artipg_dsl.robot.model import Robot
from artipg_dsl.robot.robots import Robots
from artipg_dsl.runtime.batch import Batch

PRIMITIVES = ("pushing", "pushing-left", "pulling", "pulling-left")  # -up is -left turned about the approach
STATES = 3  # of an object: at rest, and at random
POINTS = 64  # of a link
TILT, HELD = 15.0, 30.0  # degrees about the normal, or about the motion of what is held, that a hand comes or goes by
WORDS = ("push", "press", "pull", "open", "close", "lift", "turn", "slide")
ABOVE, GRAZING = 1e-6, 0.02  # metres over a point that rays begin at; sine of the least angle they leave it by
TRIES = 12  # of a word on a link at points that a finger may get to
ROOM = 0.02  # rad or units that a joint needs for a trial of a word, or half of its range


@dataclass(frozen=True)
class Attempt:
    """``word``: "" of a random trial; ``labelled``: whether the point bears it."""

    object: int
    trial: Trial
    link: str
    joint: str
    word: str
    labelled: bool
    foretold: bool
    came: bool
    fault: str
    note: str


class Case:
    """One object: a batch of its own, its robot, its arena, where screws have links of their own, the states it is tried in, its points."""

    def __init__(self, batch: Batch, robot: Robot, arena: Arena, names: list[str], seed: int):
        self.batch, self.robot, self.arena, self.unit = batch, robot, arena, arena.unit
        self.names, self.joints = names, batch.joints()
        self.seed = [seed, int(batch.numbers[0])]
        self.draw = np.random.default_rng(self.seed)
        self.cloud = sample_points(
            batch, Sampling(POINTS, per="link", surface="outside"), np.zeros(len(names)), motion=True
        )
        self.own = own_joints(batch)
        self.chains = [self._chain(k) for k in range(len(self.own))]
        led = led_links(batch, arena.order)
        self.rows = [r for r in range(len(self.cloud.link)) if led[self.cloud.link[r, 0]]]
        self.states = list(self._states())
        self.tried = len(self.states)  # the next is for what no finger gets to in these
        self.states += self._settled(self._opened())

    def _chain(self, link: int) -> list[int]:
        by_child = {int(child): k for k, child in enumerate(self.joints.child)}
        found: list[int] = []
        while link in by_child:
            row = by_child[link]
            if self.joints.kind[row] != "fixed":
                found.append(row)
            link = int(self.joints.parent[row])
        return found

    def _states(self) -> Iterator[tuple[dict[str, float], np.ndarray]]:
        rest = self.batch.rest()
        for k in range(STATES):
            drawn = np.where(self.draw.random(len(rest)) < 0.5, rest, draw_values(self.batch, k)) if k else rest
            if k == STATES - 1 and self.batch.gates is not None:  # what waits may go, and stands where it rests
                every = np.ones(len(rest), dtype=bool)
                drawn = self.batch.gates.open(rest, every, self.joints.low, self.joints.high)
            yield from self._settled(drawn)

    def _opened(self) -> np.ndarray:
        """Joint values with all open that has the word, and at rest what has not."""
        assert self.cloud.acting is not None
        known = self.cloud.acting.get("affordance.open", np.full(self.cloud.link.shape, -1))
        opens = np.isin(np.asarray(self.joints.number), known[known >= 0])
        values = self.batch.rest().copy()
        values[opens] += [self.far(joint) for joint in np.flatnonzero(opens)]
        if self.batch.gates is not None:
            values = self.batch.gates.open(values, opens, self.joints.low, self.joints.high)
        return values

    def _settled(self, values: np.ndarray) -> list[tuple[dict[str, float], np.ndarray]]:
        """The one state that joints at ``values`` come to by themselves, or none."""
        state = self.batch.settle(values)
        known = dict(zip(self.names, state, strict=True))
        settled = self.arena.settle({name: known.get(name, 0.0) for name in self.arena.order})
        if settled is None:
            return []
        return [(settled, np.array([settled.get(name, state[row]) for row, name in enumerate(self.names)]))]

    def random(self, count: int) -> Iterator[tuple[Trial, int, str, bool]]:
        """Trials, with the state they start from."""
        kinds = sorted({int(self.joints.definition[self.chains[int(self.cloud.link[r, 0])][0]]) for r in self.rows})
        for t in range(count):
            kind = kinds[self.draw.integers(len(kinds))]
            rows = [r for r in self.rows if self.joints.definition[self.chains[int(self.cloud.link[r, 0])][0]] == kind]
            row = rows[self.draw.integers(len(rows))]
            point, state = int(self.draw.integers(POINTS)), int(self.draw.integers(self.tried))
            yield self.make(PRIMITIVES[t % len(PRIMITIVES)], row, point, state), state, "", False

    def make(self, primitive: str, row: int, point: int, state: int, lead: np.ndarray | None = None) -> Trial:
        link = int(self.cloud.link[row, point])
        turn, _ = self.batch.pose(self.states[state][1])
        normal = turn[link] @ self.cloud.normal[row, point]
        toward = self.sphere()
        toward *= -np.sign(toward @ normal) or 1.0
        if lead is None:
            lead = toward if primitive == "pushing" else -toward
            if primitive.endswith("left"):
                lead = np.cross(toward, self.sphere())
                lead /= np.sqrt(lead @ lead)
        elif primitive == "pushing":
            toward = lead
        return Trial(
            primitive,
            link,
            self.cloud.position[row, point].astype(float),
            self.cloud.normal[row, point].astype(float),
            toward,
            lead,
        )

    def sphere(self) -> np.ndarray:
        made = self.draw.normal(size=3)
        return made / np.sqrt(made @ made)

    def tilted(self, way: np.ndarray, degrees: float) -> np.ndarray:
        """A direction within so many degrees of a way."""
        cosine = 1 - self.draw.random() * (1 - np.cos(np.deg2rad(degrees)))
        side = np.cross(way, self.sphere())
        side /= np.sqrt(side @ side)
        return cosine * way + np.sqrt(1 - cosine**2) * side

    def worded(self, each: int) -> Iterator[tuple[Trial, int, str, bool]]:
        """Of every word on every link, up to ``each`` trials of labelled points, and as many of other points of it."""
        seen: dict[tuple[str, int], int] = {}
        shown = np.stack([self.seen(values) for _, values in self.states])
        self.draw = np.random.default_rng([*self.seed, 1])  # the same however many random ones there are
        for row in self.rows:
            link = int(self.cloud.link[row, 0])
            kind = int(self.joints.definition[self.chains[link][0]])
            for word in WORDS:
                label = self.cloud.labels.get(f"affordance.{word}")
                if label is None or not (label[row] > 0).any() or seen.get((word, kind), 0) >= 2 * each:
                    continue
                for _ in range(each):
                    found = self.one(word, row, shown[:, row] & (label[row] > 0))
                    if found is not None:
                        seen[word, kind] = seen.get((word, kind), 0) + 1
                        trial, state = found
                        yield trial, state, word, True
                        point = int(self.draw.integers(POINTS))
                        yield self.make(trial.primitive, row, point, state), state, word, False

    def one(self, word: str, row: int, fit: np.ndarray) -> tuple[Trial, int] | None:
        """A trial of a word at one of the points that are ``fit`` (states, POINTS), in a state in which its joint has room and, if it is
        pressed, a finger gets to it: a key under a shut lid waits until the lid is open. None where there is none; where no finger gets to
        any point in a few tries, in these states or with all open that opens, the first of them stands, and fails."""
        kept = None
        for k in range(TRIES):
            made = self._one(word, row, fit[: self.tried] if k == 0 else fit)
            if made is None:
                break
            if made[0].primitive != "pushing" or self.reaches(*made):
                return made
            kept = kept or made
        return kept

    def reaches(self, trial: Trial, state: int) -> bool:
        """Whether the finger of a push gets to its point in a state: nothing lies on its way."""
        scene = Scene.of(self.batch, self.robot, self.states[state][1])
        return bool(foretell(scene, [trial], self.unit, self.arena.groups).why[0] != BLOCKED)

    def _one(self, word: str, row: int, fit: np.ndarray) -> tuple[Trial, int] | None:
        """As ``one``, by a finger that may be blocked."""
        assert self.cloud.acting is not None
        gripped = self.cloud.labels.get("affordance.grasp")
        for k in self.draw.permutation(len(fit)):
            values = self.states[k][1]
            points = np.flatnonzero(fit[k])
            if not len(points):
                continue
            point = int(points[self.draw.integers(len(points))])
            link = int(self.cloud.link[row, point])
            turn, shift = self.batch.pose(values)
            place = turn[link] @ self.cloud.position[row, point] + shift[link]
            normal = turn[link] @ self.cloud.normal[row, point]
            number = int(self.cloud.acting[f"affordance.{word}"][row, point])
            if number < 0:
                continue
            joint = int(np.flatnonzero(np.asarray(self.joints.number) == number)[0])
            motion = joint_twist(self.batch, values).at(np.array(joint), place)
            size = float(np.sqrt(motion @ motion))
            held = word == "pull" and gripped is not None and bool(gripped[row, point] > 0)  # goes with the hand
            base, tilt, primitive = -normal, TILT, "pushing"
            if word == "pull" and not held:
                base, primitive = normal, "pulling"
            elif word not in ("push", "press"):
                away = np.sign(self.far(joint)) or 1.0
                signs = {"open": [away], "pull": [away], "close": [-away]}.get(word, [1.0, -1.0])
                signs = [s for s in signs if self.room(joint, values, s)]
                if not signs or size < 1e-6:
                    continue
                base, tilt, primitive = signs[self.draw.integers(len(signs))] * motion / size, HELD, "pulling-left"
            if self.room(joint, values, float(np.sign(base @ motion))):
                return self.make(primitive, row, point, int(k), self.tilted(base, tilt)), int(k)
        return None

    def seen(self, values: np.ndarray) -> np.ndarray:
        """Which points (rows, POINTS) can be seen from outside with the joints at ``values``: a lid may have shut on what is seen at 0. Of the
        rays by which ``artipg_dsl/geometry/outside.py`` tells, one enters no mesh; those that begin behind a mesh, as where a surface is
        hollow, may leave it."""
        turn, shift = self.batch.pose(values)
        corners, faces, start = [], [], 0
        for k, link in enumerate(self.robot.links):
            for visual in link.visuals:
                corners.append((visual.shape.vertices + link.origin) @ turn[k].T + shift[k])
                faces.append(visual.shape.faces + start)
                start += len(visual.shape.vertices)
        mesh = trimesh.Trimesh(np.concatenate(corners), np.concatenate(faces), process=False)
        link = self.cloud.link
        normal = np.einsum("rpij,rpj->rpi", turn[link], self.cloud.normal)
        place = np.einsum("rpij,rpj->rpi", turn[link], self.cloud.position) + shift[link] + ABOVE * normal
        ways = spread_directions()
        leaves = np.argwhere(normal @ ways.T > GRAZING)
        along = ways[leaves[:, 2]]
        met, ray = mesh.ray.intersects_id(place[leaves[:, 0], leaves[:, 1]], along, multiple_hits=True)
        free = np.ones(len(leaves), dtype=bool)
        free[ray[(mesh.face_normals[met] * along[ray]).sum(axis=1) < 0]] = False
        found = np.zeros(link.shape, dtype=bool)
        found[leaves[free, 0], leaves[free, 1]] = True
        return found

    def far(self, joint: int) -> float:
        """The way from rest to the farther end."""
        rest, low, high = self.batch.rest()[joint], self.joints.low[joint], self.joints.high[joint]
        low, high = (rest if np.isnan(end) else end for end in (low, high))
        return float(high - rest if high - rest >= rest - low else low - rest)

    def room(self, joint: int, values: np.ndarray, sign: float) -> bool:
        if self.batch.gates is not None and joint in self.batch.gates.joint[self.batch.gates.held(values)]:
            return False
        low, high = self.joints.low[joint], self.joints.high[joint]
        left = high - values[joint] if sign > 0 else values[joint] - low
        unit = self.unit if self.slides(joint) else 1.0
        return bool(np.isnan(left) or left > ROOM * unit or left > 0.6 * (high - low))

    def slides(self, row: int) -> bool:
        return bool(self.joints.kind[row] == "prismatic")

    def spans(self, rows: np.ndarray) -> np.ndarray:
        span = np.asarray(self.joints.high)[rows] - np.asarray(self.joints.low)[rows]
        return np.where(np.isnan(span), np.inf, span)

    def attempt(self, made: list[tuple[Trial, int, str, bool]]) -> list[Attempt]:
        found = []
        for state in range(len(self.states)):
            mine = [one for one in made if one[1] == state]
            if not mine:
                continue
            scene = Scene.of(self.batch, self.robot, self.states[state][1])
            told = foretell(scene, [one[0] for one in mine], self.unit, self.arena.groups)
            for (trial, _, word, labelled), foretold, note in zip(mine, told.good, told.why, strict=True):
                out = self.arena.run(trial, self.states[state][0])
                chain = np.array(self.chains[trial.link])
                begun, way = self.states[state][0], out.end - out.start
                gone = np.array([abs(out.values[self.names[row]] - begun[self.names[row]]) for row in chain])
                cosine = float(way @ trial.lead) / max(float(np.sqrt(way @ way)), 1e-12)
                slides = np.array([self.slides(row) for row in chain])
                came = succeeds(trial.primitive, out.fault, gone, self.spans(chain), slides, self.unit, cosine)
                more = f"state {state} gone {gone.round(4).tolist()} cosine {cosine:.2f}"
                found.append(
                    Attempt(
                        int(self.batch.numbers[0]), trial, self.robot.links[trial.link].name, self.names[chain[0]],
                        word, labelled, bool(foretold), came, out.fault, f"{note or 'should'}; {more}",
                    )
                )  # fmt: skip
        return found


def try_object(batch: Batch, count: int, each: int, seed: int = 0) -> list[Attempt]:
    """``count`` random trials and ``each`` of a word on a link, of a batch of one object."""
    joints = batch.joints()
    own = own_joints(batch)
    groups = np.where(own >= 0, own, -1)
    robot = Robots(batch).robot(0)
    arena = Arena(robot, folder_frame(robot).unit, groups)
    case = Case(batch, robot, arena, list(joints.name), seed)
    if not case.rows or not case.states:
        return []
    return case.attempt([*case.random(count), *case.worded(each)])
