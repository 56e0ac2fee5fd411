"""Which points of an object move? ``python -m experiments.moving``: networks that saw real objects, ours, or both, on real ones."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

import numpy as np
import torch
from torch import nn

from .clouds import Arrays, Clouds
from .network import PointNet
from .ours import our_motion
from .real import Real, real_motion
from .scores import mean_iou
from .study import Arm, Metric, Scores
from .training import Experiment, command
from .warp import tilt_and_scale

VOTES = 8  # random parts of a cloud that a network is asked about each of its points


class Moving(Experiment):
    name = "moving"
    what = "Which points of real objects move: mean IoU of what does and of what does not."
    metrics = {"mean_iou": Metric("mean IoU, %", "higher")}
    arms = {
        "real": Arm(("real",)),
        "real, warped": Arm(("real",), warped=True),
        "ours": Arm(("ours",)),
        "ours, as PartNet-Mobility has them": Arm(("as in PartNet-Mobility",)),
        "real and ours": Arm(("real", "ours")),
    }
    pairs = [
        ("ours", "real"),
        ("ours, as PartNet-Mobility has them", "real"),
        ("ours, as PartNet-Mobility has them", "ours"),
        ("real and ours", "real"),
        ("real and ours", "real, warped"),
        ("real and ours", "ours"),
        ("real, warped", "real"),
    ]

    size = 512

    def real(self, objects: Sequence[Real]) -> Clouds:
        return real_motion(objects)

    def sources(self, real: Clouds, objects: Sequence[Real], each: int, output: Path) -> dict[str, Clouds]:
        """Ours as declared, and by a prior under which nearly every object has a joint, as every real one here has."""
        made = {"ours": None, "as in PartNet-Mobility": "partnet"}
        return {"real": real} | {
            name: our_motion(real.known, each, 2 * self.size, seed=1, prior=prior) for name, prior in made.items()
        }

    def network(self, categories: int) -> nn.Module:
        return PointNet(categories)

    def vary(self, arrays: Arrays, draws: np.random.Generator) -> Arrays:
        """Objects stand upright and to the front, as in PartNet, ShapeNet and Shape2Motion."""
        return arrays | {"points": tilt_and_scale(arrays["points"], draws)}

    def loss(self, network: nn.Module, batch: dict[str, torch.Tensor]) -> torch.Tensor:
        said = network(batch["points"], batch["category"])[..., 0]
        return nn.functional.binary_cross_entropy_with_logits(said, batch["moves"])

    @torch.no_grad()
    def judge(self, network: nn.Module, clouds: Clouds, seed: int) -> Scores:
        """Every point is judged in VOTES random parts of its cloud."""
        draws, (count, n) = np.random.default_rng(seed), clouds["moves"].shape
        size = min(self.size, n)
        parts = n // size
        total = np.zeros((count, n))
        for _ in range(VOTES):
            at = draws.permuted(np.tile(np.arange(n), (count, 1)), axis=1)[:, : parts * size].reshape(
                count, parts, size
            )
            for part in range(parts):
                points = np.take_along_axis(clouds["points"], at[:, part, :, None], axis=1)
                said = network(torch.from_numpy(points), torch.from_numpy(clouds.category))[..., 0].numpy()
                np.put_along_axis(total, at[:, part], np.take_along_axis(total, at[:, part], axis=1) + said, axis=1)
        return {"mean_iou": mean_iou(total > 0.0, clouds["moves"])}


if __name__ == "__main__":
    command(Moving())
