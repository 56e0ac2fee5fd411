"""Which points of an object move? ``python -m experiments.moving``: networks that saw real objects, ours, or both, on real ones.

Real objects are held out fold by fold. Each way of training is done with several seeds; what is compared are means over the seeds, object by
object (``scores.paired_test``). ``--real FOLDER`` takes other objects in the form that ``clouds.read_real`` tells.
"""

from __future__ import annotations

import argparse
import json
import platform
import time
from collections.abc import Callable, Sequence
from pathlib import Path

import numpy as np

import artipg_dsl as apg
from artipg_dsl.errors import UserError

try:
    import torch
except ImportError as missing:
    raise SystemExit("this needs PyTorch: pip install 'artipg_dsl[torch]'") from missing

from .clouds import Clouds, read_real, sample_ours
from .network import Segmenter
from .scores import mean_iou, paired_test
from .warp import turn_and_scale, warp_locally

HERE = Path(__file__).parent
POINTS, BATCH, RATE = 256, 16, 2e-3
VOTES = 8  # random parts of a cloud that a network is asked about each of its points
ARMS = ("real", "real, warped", "ours", "ours, then both")


def warped(points: np.ndarray, draws: np.random.Generator) -> np.ndarray:
    """Turned and scaled; half of the clouds warped before."""
    half = len(points) // 2
    return turn_and_scale(np.concatenate([warp_locally(points[:half], draws), points[half:]]), draws)


def train(
    network: Segmenter,
    sources: Sequence[Clouds],
    steps: int,
    draws: np.random.Generator,
    change: Callable[[np.ndarray, np.random.Generator], np.ndarray],
) -> None:
    """AdamW with a rate that rises and falls once; each step sees random points of random clouds, as many of each source."""
    network.train()
    adam = torch.optim.AdamW(network.parameters(), RATE, weight_decay=1e-2)
    falling = torch.optim.lr_scheduler.OneCycleLR(adam, RATE, steps)
    for _ in range(steps):
        points, truth, category = [], [], []
        for clouds in sources:
            rows = draws.integers(0, len(clouds), BATCH // len(sources))
            every = np.tile(np.arange(clouds.moves.shape[1]), (len(rows), 1))
            at = draws.permuted(every, axis=1)[:, :POINTS]
            points.append(np.take_along_axis(clouds.points[rows], at[..., None], axis=1))
            truth.append(np.take_along_axis(clouds.moves[rows], at, axis=1))
            category.append(clouds.category[rows])
        seen = change(np.concatenate(points), draws).astype(np.float32)
        said = network(torch.from_numpy(seen), torch.from_numpy(np.concatenate(category)))
        wanted = torch.from_numpy(np.concatenate(truth).astype(np.float32))
        loss = torch.nn.functional.binary_cross_entropy_with_logits(said, wanted)
        adam.zero_grad()
        loss.backward()
        adam.step()
        falling.step()


@torch.no_grad()
def judge(network: Segmenter, clouds: Clouds, seed: int) -> np.ndarray:
    """(K,) mean IoU of each cloud, every point judged in VOTES parts of its cloud."""
    network.eval()
    draws, (count, n) = np.random.default_rng(seed), clouds.moves.shape
    parts = n // POINTS
    total = np.zeros((count, n))
    for _ in range(VOTES):
        at = draws.permuted(np.tile(np.arange(n), (count, 1)), axis=1)[:, : parts * POINTS].reshape(
            count, parts, POINTS
        )
        for part in range(parts):
            points = np.take_along_axis(clouds.points, at[:, part, :, None], axis=1)
            said = network(torch.from_numpy(points), torch.from_numpy(clouds.category)).numpy()
            np.put_along_axis(total, at[:, part], np.take_along_axis(total, at[:, part], axis=1) + said, axis=1)
    return mean_iou(total > 0.0, clouds.moves)


def run(real: Clouds, ours: Clouds, seeds: int, folds: int, steps: dict[str, int]) -> dict[str, np.ndarray]:
    """Per arm the mean IoU (seeds, K) of every real object by a network that has not seen it."""
    found = {arm: np.zeros((seeds, len(real))) for arm in ARMS}
    fold = np.arange(len(real)) % folds
    for seed in range(seeds):
        torch.manual_seed(seed)
        base = Segmenter(len(real.known))
        train(base, [ours], steps["ours"], np.random.default_rng(seed), turn_and_scale)
        found["ours"][seed] = judge(base, real, seed)
        print(f"seed {seed}: ours {found['ours'][seed].mean():.3f}", flush=True)
        for k in range(folds):
            held, seen = np.flatnonzero(fold == k), real.take(np.flatnonzero(fold != k))
            for arm, change in (
                ("real", turn_and_scale),
                ("real, warped", warped),
                ("ours, then both", turn_and_scale),
            ):
                torch.manual_seed(seed)
                network = Segmenter(len(real.known))
                if arm == "ours, then both":
                    network.load_state_dict(base.state_dict())
                sources = [seen, ours] if arm == "ours, then both" else [seen]
                train(network, sources, steps[arm], np.random.default_rng([seed, k]), change)
                found[arm][seed, held] = judge(network, real.take(held), seed)
                print(f"seed {seed}, fold {k}: {arm} {found[arm][seed, held].mean():.3f}", flush=True)
    return found


def summarise(real: Clouds, found: dict[str, np.ndarray]) -> dict[str, object]:
    """What is written to the file of results."""
    mean = {arm: scores.mean(axis=0) for arm, scores in found.items()}
    pairs = [
        ("ours, then both", "real"),
        ("ours, then both", "real, warped"),
        ("real, warped", "real"),
        ("ours", "real"),
    ]
    return {
        "arms": {
            arm: {
                "mean_iou": round(float(scores.mean()), 4),
                "over_seeds": [round(float(v), 4) for v in scores.mean(axis=1)],
                "objects": dict(zip(real.names, mean[arm].round(4).tolist(), strict=True)),
            }
            for arm, scores in found.items()
        },
        "pairs": [
            {
                "one": one,
                "other": other,
                "difference": round(float((mean[one] - mean[other]).mean()), 4),
                "better_on": int((mean[one] > mean[other]).sum()),
                "of": len(real),
                "p": round(paired_test(mean[one], mean[other]), 4),
            }
            for one, other in pairs
        ],
    }


def main() -> None:
    parser = argparse.ArgumentParser(prog="python -m experiments.moving", description=__doc__.splitlines()[0])
    parser.add_argument("--real", type=Path, default=HERE / "real", help="folder of real objects")
    parser.add_argument("--each", type=int, default=100, help="objects of ours of each category")
    parser.add_argument("--seeds", type=int, default=3)
    parser.add_argument("--folds", type=int, default=3)
    parser.add_argument("--steps", type=float, default=1.0, help="share of the steps of training, for a quick look")
    parser.add_argument("-o", "--output", type=Path, default=HERE / "results" / "moving.json")
    given = parser.parse_args()
    torch.set_num_threads(1)  # small networks gain nothing from more
    torch.use_deterministic_algorithms(True)
    start = time.perf_counter()
    try:
        real = read_real(given.real)
        ours = sample_ours(real.known, given.each, 2 * POINTS, seed=1)
    except UserError as wrong:
        raise SystemExit(f"error: {wrong}") from None
    print(f"{len(real)} real objects, {len(ours)} clouds of ours ({time.perf_counter() - start:.0f} s)", flush=True)
    steps = {"ours": 2000, "real": 600, "real, warped": 600, "ours, then both": 300}
    steps = {arm: max(1, round(given.steps * number)) for arm, number in steps.items()}
    found = run(real, ours, given.seeds, given.folds, steps)
    told = {
        "what": "mean IoU of what moves and what does not, real objects",
        "versions": {
            "artipg_dsl": apg.__version__,
            "torch": torch.__version__.split("+")[0],
            "python": platform.python_version(),
        },
        "seeds": given.seeds,
        "folds": given.folds,
        "steps": steps,
        "ours": {"categories": list(ours.known), "clouds": len(ours)},
        **summarise(real, found),
    }
    given.output.parent.mkdir(parents=True, exist_ok=True)
    part = given.output.with_suffix(".part")
    part.write_text(json.dumps(told, indent=1) + "\n", encoding="utf-8")
    part.replace(given.output)
    for arm, scores in found.items():
        print(
            f"{arm:16} {100 * scores.mean():5.1f}  (seeds {', '.join(f'{100 * v:.1f}' for v in scores.mean(axis=1))})"
        )
    for pair in told["pairs"]:
        better = f"better on {pair['better_on']} of {pair['of']}, p = {pair['p']}"
        print(f"{pair['one']} - {pair['other']}: {100 * pair['difference']:+.1f}, {better}")
    print(f"{given.output} ({time.perf_counter() - start:.0f} s)")


if __name__ == "__main__":
    main()
