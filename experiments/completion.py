"""From one view of an object to its whole surface: ``python -m experiments.completion``, judged on real objects."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

import numpy as np
import torch
from torch import nn

from artipg_dsl.loaders import View
from artipg_dsl.loaders.draws import Draws

from .clouds import Arrays, Clouds, normalise
from .network import Completer, chamfer
from .ours import our_shapes
from .real import Real, real_shapes
from .scores import chamfer_l1, f_score
from .study import Arm, Metric, Scores
from .training import Experiment, command
from .warp import turn, turn_and_scale

SEEN = 256  # points that a network is shown
WANTED = 512  # of the surface that it is trained on
VIEWS = 4  # of each object, by which it is judged
NEAR = 0.01  # of the diagonal: PoinTr's threshold
LOOK = View(pixels=32, depth=0.05)


class Completion(Experiment):
    name = "completion"
    what = "From one view of real objects, turned about the vertical, to their whole surface, in units of the diagonal of their box."
    metrics = {"cd_l1": Metric("CD-l1 x 1000", "lower", 1000.0), "f_score": Metric("F-score at 0.01, %", "higher")}
    arms = {"real": Arm(("real",)), "real, warped": Arm(("real",), warped=True), "ours": Arm(("ours",))}
    pairs = [("ours", "real"), ("real, warped", "real")]
    steps = 400
    size = 2048
    batch = 8
    each = 20
    folds = 2

    def real(self, objects: Sequence[Real]) -> Clouds:
        return real_shapes(objects)

    def sources(self, real: Clouds, objects: Sequence[Real], each: int, output: Path) -> dict[str, Clouds]:
        return {"real": real, "ours": our_shapes(real.known, each, self.size, seed=1)}

    def network(self, categories: int) -> nn.Module:
        return Completer()

    def vary(self, arrays: Arrays, draws: np.random.Generator) -> Arrays:
        return view(turn_and_scale(arrays["points"], draws), draws)

    def loss(self, network: nn.Module, batch: dict[str, torch.Tensor]) -> torch.Tensor:
        return chamfer(network(batch["partial"]), batch["points"][:, :WANTED])

    @torch.no_grad()
    def judge(self, network: nn.Module, clouds: Clouds, seed: int) -> Scores:
        """Means over VIEWS views of each object, the same ones for all networks."""
        found: dict[str, list[np.ndarray]] = {name: [] for name in self.metrics}
        for k in range(VIEWS):
            seen = [self._seen(clouds["points"][row], int(origin), k) for row, origin in enumerate(clouds.origin)]
            whole = np.stack([arrays["points"][0] for arrays in seen])
            partial = torch.from_numpy(np.stack([arrays["partial"][0] for arrays in seen]))
            fine = network(partial).numpy()
            found["cd_l1"].append(chamfer_l1(fine, whole))
            found["f_score"].append(f_score(fine, whole, NEAR))
        return {name: np.mean(values, axis=0) for name, values in found.items()}

    def _seen(self, points: np.ndarray, origin: int, k: int) -> Arrays:
        draws = np.random.default_rng([origin, k])
        return view(turn(points[None], draws), draws)


def view(points: np.ndarray, draws: np.random.Generator) -> Arrays:
    """``points`` (B, n, 3) about the centre of their box, its diagonal 1, and ``partial`` (B, SEEN, 3), what a random side shows."""
    whole = normalise(points)
    whole /= np.sqrt((np.ptp(whole, axis=1, keepdims=True) ** 2).sum(axis=-1, keepdims=True))
    seen = LOOK(
        {"points": whole, "partial": whole}, Draws(int(draws.integers(2**31)), "view", np.arange(len(whole)), 0)
    )
    return {"points": whole, "partial": seen["partial"][:, :SEEN]}


if __name__ == "__main__":
    command(Completion())
