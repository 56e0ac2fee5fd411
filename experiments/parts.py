"""How parts that move lie: ``python -m experiments.parts``. A network says of each point of a part where it is in the part's own frame (NPCS);
the part's pose, its box and its joint follow by a fit. Judged on the moving parts of real objects.
"""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from pathlib import Path

import numpy as np
import torch
from torch import nn

from artipg_dsl.errors import UserError

from .clouds import Arrays, Clouds
from .network import PointNet
from .ours import our_parts
from .part import Part, part_arrays
from .pose import box_iou, distance_of_lines, fit_pose, line_error, rotation_error
from .real import Real
from .study import Arm, Metric, Scores
from .training import Experiment, command
from .warp import turn

VIEWS = 4  # turns about the vertical by which each part is judged
ASIDE = np.pi / 3  # of the front, to either side, as GAPartNet looks at objects
NEAR = 10.0, 0.1  # A10: degrees, and distance
JOINT = 10.0, 0.25  # OPD's: degrees, and the distance of a hinge in diagonals of the object


class Parts(Experiment):
    name = "parts"
    what = "The pose, the box and the joint of each moving part of real objects, told where the part is."
    metrics = {
        "iou": Metric("3D IoU, %", "higher"),
        "rotation": Metric("rotation off, degrees", "lower", 1.0),
        "a10": Metric("A10, %", "higher"),
        "joint": Metric("joint found, %", "higher"),
    }
    arms = {"real": Arm(("real",)), "ours": Arm(("ours",)), "real and ours": Arm(("real", "ours"))}
    pairs = [("ours", "real"), ("real and ours", "real"), ("real and ours", "ours")]
    steps = 400
    each = 40

    def real(self, objects: Sequence[Real]) -> Clouds:
        return real_parts(objects)

    def sources(self, real: Clouds, objects: Sequence[Real], each: int, output: Path) -> dict[str, Clouds]:
        return {"real": real, "ours": our_parts(real.known, each, 2048, seed=1)}

    def network(self, categories: int) -> nn.Module:
        return PointNet(categories, outputs=5, given=1)

    def vary(self, arrays: Arrays, draws: np.random.Generator) -> Arrays:
        """Turned and scaled evenly, which leaves canonical places as they are, with noise."""
        points = turn(arrays["points"], draws, ASIDE) * np.exp(
            draws.uniform(-0.22, 0.22, (len(arrays["points"]), 1, 1))
        )
        return arrays | {"points": points + draws.normal(0.0, 0.005, points.shape)}

    def loss(self, network: nn.Module, batch: dict[str, torch.Tensor]) -> torch.Tensor:
        own = batch["own"][..., None]
        said = network(batch["points"], batch["category"], own)
        away = torch.cat(
            [said[..., :3] - batch["npcs"], (said[..., 3:] - batch["hinge"]) * batch["hinged"][..., None]], dim=-1
        )
        return (
            nn.functional.huber_loss(away, torch.zeros_like(away), reduction="none", delta=0.1) * own
        ).sum() / own.sum()

    @torch.no_grad()
    def judge(self, network: nn.Module, clouds: Clouds, seed: int) -> Scores:
        """Means over VIEWS turns and random points of each part, the same ones for all networks."""
        found = {name: np.zeros((len(clouds), VIEWS)) for name in self.metrics}
        for row in range(len(clouds)):
            draws = np.random.default_rng([int(clouds.origin[row]), row])
            for k in range(VIEWS):
                at = draws.permutation(clouds["points"].shape[1])[: self.size]
                shown = {name: values[row, at] for name, values in clouds.arrays.items()}
                shown["points"] = turn(shown["points"][None], draws, ASIDE)[0].astype(np.float32)
                told = (
                    shown["points"][None],
                    clouds.category[row : row + 1],
                    shown["own"].astype(np.float32)[None, :, None],
                )
                said = network(*map(torch.from_numpy, told))[0].numpy().astype(np.float64)
                for name, value in pose_scores(shown, said).items():
                    found[name][row, k] = value
        return {name: values.mean(axis=1) for name, values in found.items()}


def pose_scores(arrays: Arrays, said: np.ndarray) -> dict[str, float]:
    """The metrics of one part: its arrays (n, ...), and what a network said of each point (n, 5)."""
    own, points = arrays["own"], arrays["points"].astype(np.float64)
    truth, made = (fit_pose(npcs[own], points[own], np.random.default_rng(0)) for npcs in (arrays["npcs"], said[:, :3]))
    off, apart = rotation_error(made.rotation, truth.rotation), float(np.sqrt(((made.shift - truth.shift) ** 2).sum()))
    along, line = made.rotation[:, 0], truth.rotation[:, 0]
    joint = line_error(along, line) <= JOINT[0]
    if arrays["hinged"].any():
        places = [
            pose.scale * pose.rotation @ [0.0, *at] + pose.shift
            for pose, at in ((made, said[own, 3:].mean(axis=0)), (truth, arrays["hinge"][0]))
        ]
        diagonal = float(np.sqrt((np.ptp(points, axis=0) ** 2).sum()))
        joint &= distance_of_lines(places[0], along, places[1], line) <= JOINT[1] * diagonal
    return {
        "iou": box_iou(made, truth),
        "rotation": off,
        "a10": float(off < NEAR[0] and apart < NEAR[1]),
        "joint": float(joint),
    }


def real_parts(objects: Sequence[Real]) -> Clouds:
    """A cloud for each part that a joint moves, with enough points to be seen. Raises UserError if there is none."""
    found: list[tuple[int, Part]] = [(k, part) for k, one in enumerate(objects) for part in _parts(one)]
    if not found:
        raise UserError("no object has points on a link that a joint moves", "joints.json tells them")
    known = tuple(sorted({objects[k].category for k, _ in found}))
    return Clouds(
        part_arrays([part for _, part in found]),
        np.array([known.index(objects[k].category) for k, _ in found]),
        known,
        tuple(objects[k].title for k, _ in found),
        np.array([k for k, _ in found]),
    )


def _parts(one: Real) -> Iterable[Part]:
    by = one.moved_by()[one.link]
    for k, joint in enumerate(one.joints):
        if (by == k).sum() >= 32:  # fewer do not show a shape
            hinge = joint.origin if joint.kind != "prismatic" else None
            yield Part(one.points.astype(np.float64), by == k, joint.axis, hinge)


if __name__ == "__main__":
    command(Parts())
