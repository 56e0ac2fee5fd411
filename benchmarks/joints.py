"""Whether what `apgc fit` finds of real objects moves as these do: their links beside ours.

    python benchmarks/joints.py SAMPLES FITTED               # SAMPLES/CATEGORY/NAME/cloud.npz and joints.json
    python benchmarks/joints.py SAMPLES FITTED --json found.json

FITTED/CATEGORY is what `apgc fit CATEGORY SAMPLES/CATEGORY -o FITTED/CATEGORY` has written. Points of a real link belong to that of our
links which is nearest to most of them. Asked are, for each real link that moves, whether that link of ours moves, in the same way, about
or along the same axis, and how much of both links' points the two share (intersection over union); and for each of ours that moves whether
the real link that is nearest to most of it does.
"""

from __future__ import annotations

import argparse
import json
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import Any

import numpy as np
from scipy.spatial import cKDTree

import artipg_dsl as apg

POINTS = 20000  # of ours
TURNS = ("revolute", "continuous", "screw")
ANGLE, LINE = 5.0, 2.0  # degrees, percent of the diagonal: what counts as the same axis


@dataclass(frozen=True)
class Link:
    """A real link that moves. ``ours``: how the link of ours moves, "" for not at all; ``angle`` between the axes (degrees); ``line``: how far
    our axis of a hinge passes the real one, beside the link (percent of the diagonal), nan for slides."""

    object: str
    kind: str
    ours: str
    angle: float
    line: float
    iou: float

    @property
    def alike(self) -> bool:
        return bool(self.ours) and (self.kind in TURNS) == (self.ours in TURNS)

    @property
    def same(self) -> bool:
        return self.alike and self.angle <= ANGLE and not self.line > LINE


def majority(values: np.ndarray) -> int:
    return int(np.bincount(values).argmax())


def mover(link: Any, joints: dict[Any, tuple[Any, Any]]) -> Any:
    """The joint that carries a link, None for one that stays; ``joints``: of each child its joint, None if it is fixed, and parent."""
    while link in joints:
        joint, parent = joints[link]
        if joint is not None:
            return joint
        link = parent
    return None


def judged(place: Path, one: apg.FittedObject) -> tuple[list[Link], list[bool]]:
    """The links of the real object in a folder that move; and of those of ours that move whether they should."""
    with np.load(place / "cloud.npz") as held:
        points, link, names = held["points"].astype(np.float64), held["link_id"], held["link_names"].tolist()
    told = json.loads((place / "joints.json").read_text())
    theirs = {j["child"]: (None if j["type"] == "fixed" else j, j["parent"]) for j in told["joints"]}
    linear, shift = one.to_object[:3, :3], one.to_object[:3, 3]
    points = points @ linear.T + shift
    said, joints = one.points(POINTS, one.posed()), one.batch.joints()
    own = {
        int(child): (None if joints.kind[j] == "fixed" else j, int(joints.parent[j]))
        for j, child in enumerate(joints.child)
    }
    rotation, moved = one.batch.pose(one.posed())
    ours, ours_at = said.link[0], said.position[0]
    near = ours[cKDTree(ours_at).query(points)[1]]
    diagonal = float(np.linalg.norm(np.ptp(points, axis=0)))
    found = []
    for number in np.unique(link).tolist():
        joint = mover(names[number], theirs)
        if joint is None:
            continue
        best = majority(near[link == number])
        iou = float(((near == best) & (link == number)).sum() / ((near == best) | (link == number)).sum())
        j = mover(best, own)
        if j is None:
            found.append(Link(place.name, joint["type"], "", np.nan, np.nan, iou))
            continue
        parent, kind = int(joints.parent[j]), str(joints.kind[j])
        axis, origin = rotation[parent] @ joints.axis[j], rotation[parent] @ joints.origin[j] + moved[parent]
        way = linear @ np.array(joint["axis"])
        way /= np.linalg.norm(way)
        start = linear @ np.array(joint["origin"]) + shift
        off = start + ((points[link == number].mean(axis=0) - start) @ way) * way - origin
        angle = float(np.degrees(np.arccos(min(abs(float(axis @ way)), 1.0))))
        line = 100.0 * float(np.linalg.norm(off - (off @ axis) * axis)) / diagonal
        turns = joint["type"] in TURNS and kind in TURNS
        found.append(Link(place.name, joint["type"], kind, angle, line if turns else np.nan, iou))
    real = link[cKDTree(points).query(ours_at)[1]]
    moving = [n for n in np.unique(ours).tolist() if mover(n, own) is not None]
    return found, [mover(names[majority(real[ours == n])], theirs) is not None for n in moving]


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("samples", type=Path)
    parser.add_argument("fitted", type=Path)
    parser.add_argument("--json", type=Path)
    asked = parser.parse_args()
    links: list[Link] = []
    right: list[bool] = []
    for folder in sorted(path.parent for path in asked.fitted.glob("*/fit.json")):
        places = sorted(path.parent for path in (asked.samples / folder.name).glob("*/joints.json"))
        for one in apg.open_fitted(folder):
            place = next(place for place in places if f"/{place.name}/" in one.record["source"])
            mine, more = judged(place, one)
            links, right = links + mine, right + more
            for link in mine:
                where = f"{link.angle:.1f} deg, {link.line:.2f} %, " if link.ours else ""
                moves = f"{link.kind}, ours {link.ours or 'stays'}"
                print(f"{folder.name} {link.object}: {moves}, {where}IoU {link.iou:.2f}", flush=True)
            print(
                f"{folder.name} {place.name}: {len(more)} of ours move, {sum(more)} where a real one does", flush=True
            )
    moving = [link for link in links if link.ours]
    angles, lines = (np.array([getattr(link, key) for link in moving]) for key in ("angle", "line"))
    alike, same = sum(link.alike for link in links), sum(link.same for link in links)
    print(f"\n{len(links)} real links that move; ours move {len(moving)}, {alike} in the same way,")
    print(f"{same} by the same axis within {ANGLE:g} deg and {LINE:g} %")
    print(
        f"medians: {np.median(angles):.2f} deg, {np.nanmedian(lines):.2f} %, IoU {np.median([k.iou for k in links]):.2f}"
    )
    print(f"{len(right)} of ours that move, {sum(right)} where a real one does")
    if asked.json:
        asked.json.write_text(json.dumps([asdict(link) for link in links], indent=1) + "\n")


if __name__ == "__main__":
    main()
