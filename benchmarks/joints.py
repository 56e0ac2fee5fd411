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
import sys
from dataclasses import asdict, dataclass
from pathlib import Path

import numpy as np
from scipy.spatial import cKDTree

import artipg_dsl as apg

sys.path.insert(0, str(Path(__file__).parent.parent))
from experiments.real import Real, read_real, upright  # noqa: E402

POINTS = 20000  # of ours
TURNS = ("revolute", "continuous", "screw")
ANGLE, LINE = 5.0, 2.0  # degrees, percent of the diagonal: what counts as the same axis


@dataclass(frozen=True)
class Link:
    """A real link that moves. ``ours``: how the link of ours moves, "" for not at all; ``angle`` between the axes (degrees); ``line``: how far
    our axis of a hinge passes the real one (percent of the diagonal), nan for slides."""

    object: str
    kind: str
    ours: str
    angle: float
    line: float
    iou: float

    @property
    def same(self) -> bool:
        return self.kind_right and self.angle <= ANGLE and not self.line > LINE

    @property
    def kind_right(self) -> bool:
        return bool(self.ours) and (self.kind in TURNS) == (self.ours in TURNS)


def majority(values: np.ndarray) -> int:
    return int(np.bincount(values).argmax())


def judged(real: Real, one: apg.FittedObject, turned: np.ndarray) -> tuple[list[Link], list[bool]]:
    """The real links that move, and of ours that move whether they should. ``turned`` brings the frame of the real object's file to that in
    which it was read here."""
    to_ours = one.to_object @ np.block([[turned.T, np.zeros((3, 1))], [np.zeros((1, 3)), np.ones((1, 1))]])
    linear, shift = to_ours[:3, :3], to_ours[:3, 3]
    points = real.points @ linear.T + shift
    said, joints = one.points(POINTS, one.posed()), one.batch.joints()
    rotation, place = one.batch.pose(one.posed())
    ours, ours_at = said.link[0], said.position[0]
    near = ours[cKDTree(ours_at).query(points)[1]]
    theirs = real.link[cKDTree(points).query(ours_at)[1]]
    diagonal = float(np.linalg.norm(np.ptp(points, axis=0)))
    above = {int(child): j for j, child in enumerate(joints.child)}
    moved, links = real.moved_by(), []

    def mover(link: int) -> int:
        while link in above:
            if joints.kind[above[link]] != "fixed":
                return above[link]
            link = int(joints.parent[above[link]])
        return -1

    for number in np.unique(real.link):
        if moved[number] < 0:
            continue
        joint, link = real.joints[moved[number]], majority(near[real.link == number])
        iou = float(((near == link) & (real.link == number)).sum() / ((near == link) | (real.link == number)).sum())
        j = mover(link)
        if j < 0:
            links.append(Link(real.title, joint.kind, "", np.nan, np.nan, iou))
            continue
        parent = int(joints.parent[j])
        axis = rotation[parent] @ joints.axis[j]
        origin = rotation[parent] @ joints.origin[j] + place[parent]
        way = linear @ joint.axis / np.linalg.norm(linear @ joint.axis)
        start = linear @ joint.origin + shift
        beside = (
            start + ((points[real.link == number].mean(axis=0) - start) @ way) * way
        )  # on the real axis, where the link is
        off = beside - origin
        far, cosine = float(np.linalg.norm(off - (off @ axis) * axis)), abs(float(axis @ way))
        turns = joint.kind in TURNS and joints.kind[j] in TURNS
        angle = float(np.degrees(np.arccos(min(cosine, 1.0))))
        links.append(
            Link(real.title, joint.kind, str(joints.kind[j]), angle, 100 * far / diagonal if turns else np.nan, iou)
        )
    extra = [bool(moved[majority(theirs[ours == link])] >= 0) for link in np.unique(ours) if mover(int(link)) >= 0]
    return links, extra


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("samples", type=Path)
    parser.add_argument("fitted", type=Path)
    parser.add_argument("--json", type=Path)
    asked = parser.parse_args()
    links: list[Link] = []
    extra: list[bool] = []
    for folder in sorted(path.parent for path in asked.fitted.glob("*/fit.json")):
        real = {one.name: one for one in read_real(asked.samples / folder.name)}
        turned = {}
        for name in real:
            told = json.loads((asked.samples / folder.name / name / "joints.json").read_text())
            turned[name] = upright(told["up"], told["front"])
        for one in apg.open_fitted(folder):
            name = next(name for name in real if name in one.record["source"])
            mine, more = judged(real[name], one, turned[name])
            links, extra = links + mine, extra + more
            for link in mine:
                print(
                    f"{link.object}: {link.kind}, ours {link.ours or 'stays'}, {link.angle:.1f} deg, {link.line:.2f} %, IoU {link.iou:.2f}",
                    flush=True,
                )
            print(
                f"{real[name].title}: {len(mine)} real links move; of ours {len(more)}, {len(more) - sum(more)} of them on what stays",
                flush=True,
            )
    moving = [link for link in links if link.ours]
    angles, lines = (np.array([getattr(link, key) for link in moving]) for key in ("angle", "line"))
    print(
        f"\n{len(links)} real links that move: of {len(moving)} ours does, of {sum(link.kind_right for link in links)} in the same way, of "
        f"{sum(link.same for link in links)} within {ANGLE:g} deg and {LINE:g} % of the same axis (medians {np.median(angles):.2f} deg, "
        f"{np.nanmedian(lines):.2f} %); IoU {np.median([link.iou for link in links]):.2f} at the median; {sum(extra)} of {len(extra)} links of "
        "ours that move are where a real one does"
    )
    if asked.json:
        asked.json.write_text(json.dumps([asdict(link) for link in links], indent=1) + "\n")


if __name__ == "__main__":
    main()
