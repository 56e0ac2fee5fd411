"""Training a network on clouds, and the command that all experiments share."""

from __future__ import annotations

import argparse
import json
import platform
import sys
import time
from abc import ABC, abstractmethod
from collections.abc import Mapping, Sequence
from functools import partial
from pathlib import Path
from typing import Any, ClassVar

import numpy as np

import artipg_dsl as apg
from artipg_dsl.errors import UserError

try:
    import torch
    from torch import nn
except ImportError as missing:
    raise SystemExit("this needs PyTorch: pip install 'artipg_dsl[torch]'") from missing

from .clouds import Arrays, Clouds, draw
from .page import arms_table, pairs_table
from .real import Real, read_real
from .study import Arm, Metric, Scores, by_object, run, summarise
from .warp import turn_and_scale, warp_locally

HERE = Path(__file__).parent
RATE = 2e-3


class Experiment(ABC):
    """A task with its network, the arms that are compared, and how they are judged.

    ``steps`` of training, the same for all arms; ``size``: points of a cloud that are drawn in training; ``batch``: clouds of a step;
    ``each``: objects of ours of each category, or mutants of each real one; ``folds`` of the real objects.
    """

    name: ClassVar[str]
    what: ClassVar[str]
    metrics: ClassVar[Mapping[str, Metric]]
    arms: ClassVar[Mapping[str, Arm]]
    pairs: ClassVar[Sequence[tuple[str, str]]]
    steps: ClassVar[int] = 250
    size: ClassVar[int] = 256
    batch: ClassVar[int] = 16
    each: ClassVar[int] = 100
    folds: ClassVar[int] = 3

    @abstractmethod
    def real(self, objects: Sequence[Real]) -> Clouds:
        """The test set. Raises UserError if none of the objects will do."""

    @abstractmethod
    def sources(self, real: Clouds, objects: Sequence[Real], each: int, output: Path) -> dict[str, Clouds]:
        """What arms are trained on by name, "real" among it."""

    @abstractmethod
    def network(self, categories: int) -> nn.Module: ...

    @abstractmethod
    def loss(self, network: nn.Module, batch: dict[str, torch.Tensor]) -> torch.Tensor: ...

    @abstractmethod
    def judge(self, network: nn.Module, clouds: Clouds, seed: int) -> Scores:
        """Metrics (K,) of each cloud."""

    def vary(self, arrays: Arrays, draws: np.random.Generator) -> Arrays:
        """Other clouds with the same truth."""
        return arrays | {"points": turn_and_scale(arrays["points"], draws)}

    def train(self, arm: Arm, sources: Sequence[Clouds], seed: list[int], steps: int) -> nn.Module:
        """AdamW with a rate that rises and falls once."""
        torch.manual_seed(seed[0])
        draws = np.random.default_rng(seed if len(seed) > 1 else seed[0])
        network = self.network(len(sources[0].known))
        network.train()
        adam = torch.optim.AdamW(network.parameters(), RATE, weight_decay=1e-2)
        falling = torch.optim.lr_scheduler.OneCycleLR(adam, RATE, steps)
        for _ in range(steps):
            arrays = draw(sources, self.batch, self.size, draws)
            if arm.warped:
                half = len(arrays["points"]) // 2
                warped = warp_locally(arrays["points"][:half], draws)
                arrays["points"] = np.concatenate([warped, arrays["points"][half:]])
            loss = self.loss(network, tensors(self.vary(arrays, draws)))
            adam.zero_grad()
            loss.backward()
            adam.step()
            falling.step()
        return network.eval()


def tensors(arrays: Arrays) -> dict[str, torch.Tensor]:
    """Arrays by name; numbers that are not whole as float32."""
    return {
        name: torch.from_numpy(values.astype(np.float32) if values.dtype.kind in "fb" else values)
        for name, values in arrays.items()
    }


def command(experiment: Experiment) -> None:
    """Reads the options, runs the experiment, writes its results."""
    parser = argparse.ArgumentParser(
        prog=f"python -m experiments.{experiment.name}", description=experiment.what, allow_abbrev=False
    )
    parser.add_argument("--real", type=Path, default=HERE / "real", help="folder of real objects (see README.md)")
    parser.add_argument("--map", type=Path, help="JSON file of its names of categories and ours")
    parser.add_argument(
        "--each", type=_whole, default=experiment.each, help="objects of ours of each category, or mutants of each"
    )
    parser.add_argument("--seeds", type=_whole, default=3)
    parser.add_argument("--folds", type=_whole, default=experiment.folds)
    parser.add_argument("--steps", type=float, default=1.0, help="share of the steps of training, for a quick look")
    parser.add_argument("--arms", nargs="+", default=list(experiment.arms), help="some of the arms alone, by name")
    parser.add_argument("-o", "--output", type=Path, default=HERE / "results" / f"{experiment.name}.json")
    given = parser.parse_args()
    torch.set_num_threads(1)  # small networks gain nothing from more
    torch.use_deterministic_algorithms(True)
    torch.utils.deterministic.fill_uninitialized_memory = False  # nothing reads it, and it takes a seventh of the time
    try:
        told = perform(
            experiment,
            given.real,
            given.map,
            given.each,
            given.seeds,
            given.folds,
            given.steps,
            given.output,
            given.arms,
        )
    except UserError as wrong:
        raise SystemExit(f"error: {wrong}") from None
    print(f"\n{arms_table(told)}\n\n{pairs_table(told)}")


def perform(
    experiment: Experiment,
    folder: Path,
    map_file: Path | None,
    each: int,
    seeds: int,
    folds: int,
    share: float,
    output: Path,
    only: Sequence[str] | None = None,
) -> dict[str, Any]:
    """Runs the experiment, of its arms all or ``only`` some, and writes ``output``; ``share`` of its steps. Raises UserError."""
    start = time.process_time()
    for name in only or ():
        if name not in experiment.arms:
            raise UserError(f"{experiment.name} has no arm {name}", f"its arms are {'; '.join(experiment.arms)}")
    arms = {name: arm for name, arm in experiment.arms.items() if only is None or name in only}
    pairs = [pair for pair in experiment.pairs if set(pair) <= set(arms)]
    objects = read_real(folder, map_file)
    real = experiment.real(objects)
    count = len(np.unique(real.origin))
    if not 2 <= folds <= count:
        raise UserError(f"{count} real objects cannot be held out in {folds} folds", f"give --folds from 2 to {count}")
    output.parent.mkdir(parents=True, exist_ok=True)
    sources = experiment.sources(real, objects, each, output)
    clouds = {name: len(source) for name, source in sources.items()}
    print(f"clouds: {clouds} ({time.process_time() - start:.0f} s of CPU time)", flush=True)
    steps = max(1, round(share * experiment.steps))
    train = partial(experiment.train, steps=steps)
    found = run(real, sources, arms, train, experiment.judge, seeds, folds, lambda line: print(line, flush=True))
    told = {
        "what": experiment.what,
        "versions": {
            "artipg_dsl": apg.__version__,
            "torch": torch.__version__.split("+")[0],
            "python": platform.python_version(),
        },
        "seeds": seeds,
        "folds": folds,
        "each": each,
        "steps": steps,
        "clouds": clouds,
        "categories": list(real.known),
        "cpu_minutes": round((time.process_time() - start) / 60, 1),
        **summarise(*by_object(real, found), experiment.metrics, pairs),
    }
    part = output.with_suffix(".part")
    part.write_text(json.dumps(told, indent=1) + "\n", encoding="utf-8")
    part.replace(output)
    print(f"{output} ({told['cpu_minutes']} minutes of CPU time)", file=sys.stderr)
    return told


def _whole(text: str) -> int:
    number = int(text)
    if number < 1:
        raise argparse.ArgumentTypeError(f"{text} is less than 1")
    return number
