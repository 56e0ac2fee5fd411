"""Whether two fingers hold what a grasp says they hold: by the meshes that are exported, and by code of its own.

A hand of the size of a Panda's: two pads that come together, a palm behind them. A grasp holds where fingers and palm, opened
as it says, meet no mesh of the object (FCL), and where the pads, as they close, first meet the link of the grasp on both
sides (embree), on surfaces whose normals lie within the friction cone about the line between. A flat pad that comes to lie on
an edge or a crest, as of a pencil with six sides, presses along its own normal: then the line between the two contacts must lie
within that cone. What of a link could be held at all is found by trial: lines through points of its surface, and hands from
all sides.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import fcl
import numpy as np
import trimesh

from artipg_dsl.annotate.gripper import STANDARD
from artipg_dsl.annotate.states import own_joints
from artipg_dsl.robot.model import Robot, RobotJoint
from artipg_dsl.robot.pose import rest_poses
from artipg_dsl.robot.robots import Robots
from artipg_dsl.runtime.batch import Batch

ARM, ARM_LONG = 0.06, 0.3  # what comes behind the palm: how thick, how long
FRICTION = 0.5
APPROACHES = 12  # about a line between two pads
BUTTON = 4e-3  # metres that a button gives way by, at most
ROLLING = (  # nothing for two fingers where it turns without end: drums and rolls, castors and wheels, what a motor or water spins
    *("drum", "disc", "hub", "fork", "crown", "wheel", "run"),
    *("rotor", "arm", "second_arm"),
)
PRESSED = "pedal"  # by a foot
LINES = 7, 41  # between two pads, along x and along z: temples of spectacles are a millimetre high
MOST = 12  # solids of a link that are tried
CLEAR = 5e-5  # metres that fingers may touch by
CONE = 1 / np.sqrt(1 + FRICTION**2)


@dataclass(frozen=True)
class Hand:
    """Where a hand is: ``frame`` has the columns x, y (closing), z (approach); its measures as docs/labels.md tells them."""

    point: np.ndarray
    frame: np.ndarray
    opening: float
    stroke: float = STANDARD.stroke
    length: float = STANDARD.length
    width: float = STANDARD.width
    thickness: float = STANDARD.thickness
    pad: float = STANDARD.pad
    palm: float = STANDARD.palm
    palm_width: float = STANDARD.palm_width
    palm_depth: float = STANDARD.palm_depth


class Scene:
    """One object at rest: all its meshes as one, each triangle with its link."""

    def __init__(self, robot: Robot):
        vertices, faces, links, solids, start = [], [], [], [], 0
        for number, (link, (turn, shift)) in enumerate(zip(robot.links, rest_poses(robot), strict=True)):
            for visual in link.visuals:
                vertices.append(visual.shape.vertices @ turn.T + shift)
                faces.append(visual.shape.faces + start)
                links.append(np.full(len(visual.shape.faces), number))
                solids.append(np.full(len(visual.shape.faces), len(solids)))
                start += len(visual.shape.vertices)
        self.link, self.solid = np.concatenate(links), np.concatenate(solids)
        self.mesh = trimesh.Trimesh(np.concatenate(vertices), np.concatenate(faces), process=False)
        self.rays = trimesh.ray.ray_pyembree.RayMeshIntersector(self.mesh)
        body = fcl.BVHModel()
        body.beginModel(len(self.mesh.vertices), len(self.mesh.faces))
        body.addSubModel(np.asarray(self.mesh.vertices), np.asarray(self.mesh.faces))
        body.endModel()
        self.body = fcl.CollisionObject(body, fcl.Transform())

    def free(self, hand: Hand, arm: float = 0.0) -> bool:
        """Whether fingers and palm, opened, meet no mesh, nor does an ``arm`` so long behind them."""
        half = hand.opening / 2 + hand.thickness / 2 + CLEAR
        finger, back = np.array([hand.width, hand.thickness, hand.length]), hand.pad - hand.length / 2
        palm, behind = np.array([hand.palm_width, hand.palm, hand.palm_depth]), hand.pad - hand.length
        boxes = [
            (finger, np.array([0, half, back])),
            (finger, np.array([0, -half, back])),
            (palm, np.array([0, 0, behind - palm[2] / 2])),
        ]
        if arm:
            boxes.append((np.array([ARM, ARM, arm]), np.array([0, 0, behind - palm[2] - arm / 2])))
        for size, center in boxes:
            one = fcl.CollisionObject(
                fcl.Box(*(size - 2 * CLEAR)), fcl.Transform(hand.frame, hand.point + hand.frame @ center)
            )
            if fcl.collide(self.body, one, fcl.CollisionRequest(), fcl.CollisionResult()):
                return False
        return True

    def firm(self, hand: Hand, link: int) -> bool:
        """Whether some line between the pads meets the link first on both sides within the friction cone, or what both pads
        meet first of all is the link's, away from the rims of the pads, and opposite within that cone."""
        across, count = np.linspace(-0.9, 0.9, LINES[0]) * hand.width / 2, np.linspace(-0.9, 0.9, LINES[1]) * hand.pad
        x, z = (v.ravel() for v in np.meshgrid(across, count))
        inner = (abs(x) < across[-1]) & (abs(z) < count[-1])
        local, y = np.column_stack([x, np.zeros(x.size), z]), hand.frame[:, 1]
        firm, depth, pressed, middle = np.ones(len(local), dtype=bool), np.zeros(len(local)), True, []
        for sign in (1.0, -1.0):
            start = hand.point + local @ hand.frame.T + sign * y * (hand.opening / 2 + CLEAR)
            triangle, ray, place = self.rays.intersects_id(
                start, np.tile(-sign * y, (len(start), 1)), return_locations=True, multiple_hits=False
            )
            met, normal = np.full(len(local), -1), np.zeros((len(local), 3))
            met[ray], normal[ray] = triangle, self.mesh.face_normals[triangle]
            run = np.full(len(local), np.inf)
            run[ray] = np.sqrt(((place - start[ray]) ** 2).sum(axis=1))
            own = (met >= 0) & (self.link[met] == link)
            firm &= own & (sign * normal @ y >= CONE)
            depth += run
            if len(ray):
                first = run <= run.min() + CLEAR
                pressed &= bool(own[first].all() and inner[first].any())
                middle.append(np.array([x[first].mean(), z[first].mean(), run.min()]))
        if (firm & (depth <= hand.opening + 4 * CLEAR)).any():
            return True
        if not pressed or len(middle) < 2:
            return False
        between = hand.opening + 2 * CLEAR - middle[0][2] - middle[1][2]
        aside = np.sqrt(((middle[0] - middle[1])[:2] ** 2).sum())
        return bool(0 < between and aside <= FRICTION * between)

    def could(self, link: int, points: int = 16, seed: int = 0) -> Hand | None:
        """A hand that holds the link, found by trial at so many points of each of its solids; None where there seems to be none."""
        own, draw = np.flatnonzero(self.link == link), np.random.default_rng(seed)
        chosen = []
        for solid in np.unique(self.solid[own])[:MOST]:
            mine = own[self.solid[own] == solid]
            area = self.mesh.area_faces[mine]
            chosen.append(mine[draw.choice(len(mine), points, p=area / area.sum())])
        if not chosen:
            return None
        at = np.stack(chosen, axis=1).ravel()  # one of each solid in turn
        share = draw.random((len(at), 2))
        share[share.sum(axis=1) > 1] = 1 - share[share.sum(axis=1) > 1]
        corner = self.mesh.triangles[at]
        start = (
            corner[:, 0] + share[:, :1] * (corner[:, 1] - corner[:, 0]) + share[:, 1:] * (corner[:, 2] - corner[:, 0])
        )
        for point, normal in zip(start, self.mesh.face_normals[at], strict=True):
            triangle, _, place = self.rays.intersects_id(
                [point - 1e-5 * normal], [-normal], return_locations=True, multiple_hits=True
            )
            run = (point - place) @ normal
            for k in np.argsort(run)[::-1]:  # from the far side inwards
                width = run[k]
                ends = self.link[triangle[k]] == link and self.mesh.face_normals[triangle[k]] @ -normal >= CONE
                if not ends or not 1e-4 < width <= 0.078:
                    continue
                side = np.cross(normal, [1.0, 0, 0] if abs(normal[0]) < 0.9 else [0, 1.0, 0])
                side /= np.sqrt(side @ side)
                for angle in np.linspace(0, 2 * np.pi, APPROACHES, endpoint=False):
                    z = np.cos(angle) * side + np.sin(angle) * np.cross(normal, side)
                    hand = Hand(
                        point - normal * width / 2, np.column_stack([np.cross(normal, z), normal, z]), width + 0.002
                    )
                    if self.firm(hand, link) and self.free(hand, ARM_LONG):
                        return hand
        return None


@dataclass(frozen=True)
class Verdict:
    """A grasp of an annotation: where, and what is wrong with it, nothing where it holds. ``name`` and ``link`` as the
    program calls them, without ranks."""

    object: int
    name: str
    link: str
    fault: str


def verdicts(batch: Batch, told: list[dict[str, Any]]) -> tuple[list[Verdict], list[tuple[str, bool]]]:
    """All grasps at rest for a hand of 8 cm; and of all links that move and can be held at all, the name and whether it, or
    what it carries, has a grasp. Not gripped are links that give way when they are pressed, those whose joint waits for another
    one, as a rack behind a closed door does, drums, wheels and pedals, and the rotors of fans and dishwashers: nobody takes hold
    of what spins by itself."""
    robots, moving = Robots(batch, physics=False), own_joints(batch)
    first, held, links = np.searchsorted(batch.links().owner, np.arange(len(batch))), [], []
    for i, one in enumerate(told):
        robot = robots.robot(i)
        scene = Scene(robot)
        names = [link["name"] for link in one["links"]]
        paths = [batch.program.links[k].path for k in batch.links().definition[first[i] : first[i] + len(names)]]
        grasped: set[str] = set()
        for grasp in one["grasps"]:
            own, link = grasp["gripper"] or {}, names.index(grasp["link"])
            grasped |= set(carriers(one["joints"], grasp["link"]))
            if own.get("stroke", 0.0) > Hand.stroke or not grasp["reachable"]:
                continue
            hand = Hand(np.array(grasp["point"]), turned(grasp["quaternion"]), grasp["opening"], **own)
            fault = (
                "wide"
                if hand.opening > hand.stroke + 1e-9
                else "the fingers meet something"
                if not scene.free(hand)
                else ""
                if scene.firm(hand, link)
                else "not between the pads"
            )
            held.append(Verdict(i, grasp["name"], paths[link], fault))
        for link, name in enumerate(names):
            words = paths[link].split(".")
            if moving[first[i] + link] < 0 or PRESSED in words:
                continue
            joint = next(j for j in robot.joints if robot.links[j.child].name == name)
            if joint.kind == "continuous" and any(word in words for word in ROLLING):
                continue
            if short(robot, joint) or locked(robot, joint):
                continue
            if name in grasped or scene.could(link) is not None:
                links.append((paths[link], name in grasped))
    return held, links


def short(robot: Robot, joint: RobotJoint) -> bool:
    """Whether a joint slides, or turns its link, so little that it is a button's."""
    if joint.low is None or joint.high is None:
        return False
    travel = joint.high - joint.low
    if joint.kind == "revolute":  # the axis goes through the origin of the link's frame
        visuals = robot.links[joint.child].visuals
        away = np.concatenate([np.cross(visual.shape.vertices, joint.axis) for visual in visuals])
        travel *= np.sqrt((away**2).sum(axis=1).max())
    return joint.kind in ("prismatic", "revolute") and travel < BUTTON


def locked(robot: Robot, joint: RobotJoint) -> bool:
    """Whether at rest a joint still waits for another one."""
    rest = {other.name: other.rest for other in robot.joints}
    return any(not low <= rest[name] <= high for name, low, high in joint.gates)


def carriers(joints: list[dict[str, Any]], link: str) -> list[str]:
    """A link and all that carry it: what holds a handle moves the door."""
    above = {joint["child"]: joint["parent"] for joint in joints}
    found = [link]
    while found[-1] in above:
        found.append(above[found[-1]])
    return found


def turned(quaternion: list[float]) -> np.ndarray:
    """The rotation matrix of w x y z."""
    w, x, y, z = quaternion
    return np.array(
        [
            [1 - 2 * (y * y + z * z), 2 * (x * y - w * z), 2 * (x * z + w * y)],
            [2 * (x * y + w * z), 1 - 2 * (x * x + z * z), 2 * (y * z - w * x)],
            [2 * (x * z - w * y), 2 * (y * z + w * x), 1 - 2 * (x * x + y * y)],
        ]
    )
