"""Which way does a point go? ``python -m experiments.critic``: a network that is shown an object as it rests says of a point and of a direction
in which a hand leads it whether the point goes along, as the critic of Where2Act (Mo et al., ICCV 2021) does.

The truth, of real objects and of ours, is that of the joints: a point goes along if its joint moves it within 60 degrees of the direction
(Where2Act's threshold) and has room that way. Nothing is simulated here; ``benchmarks/trials.py`` compares this truth with physics.
"""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

import numpy as np
import torch
from torch import nn

from artipg_dsl.errors import UserError
from artipg_dsl.layouts.where2act.hand import ALONG

from .clouds import Arrays, Clouds, unit
from .network import PointActions
from .ours import our_ways
from .real import Real, to_clouds
from .scores import f1_score
from .study import Arm, Metric, Scores
from .training import Experiment, command
from .warp import turn

WAYS = 8  # directions by which a point is judged, and in training
PROPOSED = 20  # pairs of a point and a direction that a network is surest of
VIEWS = 4  # turns about the vertical by which an object is judged; any, as the cameras of Where2Act stand all around


class Critic(Experiment):
    name = "critic"
    what = "Whether points of real objects go along with a hand that leads them in a direction."
    metrics = {"f1": Metric("F1, %", "higher"), "ssr": Metric("proposals that succeed, %", "higher")}
    arms = {"real": Arm(("real",)), "ours": Arm(("ours",)), "real and ours": Arm(("real", "ours"))}
    pairs = [("ours", "real"), ("real and ours", "real"), ("real and ours", "ours")]
    steps = 400

    def real(self, objects: Sequence[Real]) -> Clouds:
        return real_ways(objects)

    def sources(self, real: Clouds, objects: Sequence[Real], each: int, output: Path) -> dict[str, Clouds]:
        return {"real": real, "ours": our_ways(real.known, each, 2 * self.size, seed=1)}

    def network(self, categories: int) -> nn.Module:
        return PointActions(categories)

    def vary(self, arrays: Arrays, draws: np.random.Generator) -> Arrays:
        """Turned and scaled evenly, with noise; ``ways`` (B, n, WAYS, 3) to be judged, half of them near the way that the point goes, and
        whether it goes ``along``."""
        points, opens = turned(arrays["points"], arrays["opens"], draws)
        points = points * np.exp(draws.uniform(-0.22, 0.22, (len(points), 1, 1)))
        ways = directions(draws, (*points.shape[:2], WAYS))
        ways[:, :, ::2] += 2.0 * opens[:, :, None]
        ways /= np.sqrt((ways**2).sum(axis=-1, keepdims=True))
        return {
            "points": points + draws.normal(0.0, 0.005, points.shape),
            "category": arrays["category"],
            "ways": ways,
            "along": goes_along(opens, arrays["both"], ways),
        }

    def loss(self, network: nn.Module, batch: dict[str, torch.Tensor]) -> torch.Tensor:
        said = network(batch["points"], batch["category"], batch["ways"])
        return nn.functional.binary_cross_entropy_with_logits(said, batch["along"])

    @torch.no_grad()
    def judge(self, network: nn.Module, clouds: Clouds, seed: int) -> Scores:
        """Each object is turned VIEWS times; random parts of it are shown, and each point led in WAYS directions, the same for all networks."""
        found = {name: np.zeros((len(clouds), VIEWS)) for name in self.metrics}
        for row, origin in enumerate(clouds.origin):
            category = torch.from_numpy(clouds.category[row : row + 1])
            for k in range(VIEWS):
                draws = np.random.default_rng([int(origin), k])
                points, opens = turned(clouds["points"][row : row + 1], clouds["opens"][row : row + 1], draws)
                n = points.shape[1] // self.size * self.size
                at = draws.permutation(points.shape[1])[:n].reshape(-1, self.size)
                ways = directions(draws, (*at.shape, WAYS))
                shown, led = (torch.from_numpy(a.astype(np.float32)) for a in (points[0][at], ways))
                said = network(shown, category.expand(len(at)), led).numpy()
                along = goes_along(opens[0][at], clouds["both"][row][at], ways)
                found["f1"][row, k] = f1_score(said > 0.0, along)
                surest = np.argsort(-said, axis=None, kind="stable")[:PROPOSED]
                found["ssr"][row, k] = along.flat[surest].mean()
        return {name: values.mean(axis=1) for name, values in found.items()}


def turned(points: np.ndarray, opens: np.ndarray, draws: np.random.Generator) -> tuple[np.ndarray, np.ndarray]:
    """Clouds (B, n, 3) and the ways that their points open, turned about the vertical."""
    both = turn(np.concatenate([points, opens], axis=1), draws)
    return both[:, : points.shape[1]], both[:, points.shape[1] :]


def directions(draws: np.random.Generator, shape: tuple[int, ...]) -> np.ndarray:
    """Unit vectors (*shape, 3), uniform on the sphere."""
    found = draws.normal(size=(*shape, 3))
    return found / np.sqrt((found**2).sum(axis=-1, keepdims=True))


def goes_along(opens: np.ndarray, both: np.ndarray, ways: np.ndarray) -> np.ndarray:
    """(..., k) bool: whether points that open along ``opens`` (..., 3), 0 where nothing moves, or ``both`` (...) ways, go along with ``ways``
    (..., k, 3)."""
    cosine = (opens[..., None, :] * ways).sum(axis=-1)
    found: np.ndarray = np.where(both[..., None], np.abs(cosine), cosine) > ALONG
    return found


def real_ways(objects: Sequence[Real]) -> Clouds:
    """Clouds of the objects with a joint: ``opens`` (K, n, 3), the unit vector along which each point opens, 0 where none moves it, and
    whether it goes ``both`` ways. Raises UserError if there is none."""
    moving = [one for one in objects if (one.moved_by()[one.link] >= 0).any()]
    if not moving:
        raise UserError("no object has points on a link that a joint moves", "joints.json tells them")
    opens, both = zip(*map(_opens, moving), strict=True)
    return to_clouds(moving, {"opens": opens, "both": both})


def _opens(one: Real) -> tuple[np.ndarray, np.ndarray]:
    by, found = one.moved_by()[one.link], np.zeros((len(one.link), 3))
    for k, joint in enumerate(one.joints):
        own = by == k
        slides = joint.kind == "prismatic"
        found[own] = joint.axis if slides else np.cross(joint.axis, one.points[own] - joint.origin)
    return unit(found), np.array([*(joint.both for joint in one.joints), False])[by]


if __name__ == "__main__":
    command(Critic())
