# ruff: noqa: E402 - the number of threads is set before NumPy is loaded
"""The two backends beside one another, in processes that take turns: the first object, the points stage, whole samples.

CPU seconds of one thread, the least of the rounds: `first`, from the start of a process to the first checked, labelled object, with what
is kept between runs; then milliseconds an object in batches of N: `surface`, points on surfaces alone; `check`, `points`,
`annotation` and `sample` (all of them with drawing) as in `whole.py`. The ratio is NumPy's time by that of the compiled backend.

    python benchmarks/backends.py [-n 256] [--rounds 2] [-o backends.json] [Microwave ...]
"""

from __future__ import annotations

import os

for _variable in ("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS", "MKL_NUM_THREADS"):
    os.environ[_variable] = "1"

import argparse
import json
import subprocess
import sys
from pathlib import Path

import whole

BACKENDS = ("numpy", "c")
FIGURES = ("first", "surface", "check", "points", "annotation", "sample")


def measure(category: str, count: int) -> dict[str, float]:
    """The figures of one process."""
    from artipg_dsl import random
    from artipg_dsl.geometry import points
    from artipg_dsl.session import Session

    found = whole.cold(category)
    row = {"first": found["plan"] + found["first"]}
    sampler = Session.of(category).sampler
    whole.warm(sampler, 8, 5, False)
    row |= whole.warm(sampler, count, 7, False)
    batch = sampler.batch(whole.numbers(0, count), 7)
    sites, address = batch.sites(), batch.numbers.astype("uint64")
    row["surface"] = (
        1e3
        / count
        * min(
            whole.clock(lambda: points.sample(sites, count, 2048, random.key(7, "points"), address))[0]
            for _ in range(3)
        )
    )
    return {name: row[name] for name in FIGURES}


def turns(category: str, count: int, rounds: int) -> dict[str, dict[str, float]]:
    """The least of some processes of each backend, which take turns."""
    found: dict[str, list[dict[str, float]]] = {name: [] for name in BACKENDS}
    for _ in range(rounds):
        for name in BACKENDS:
            command = [sys.executable, __file__, "-n", str(count), "--alone", category]
            done = subprocess.run(
                command, env={**os.environ, "APGC_BACKEND": name}, capture_output=True, text=True, check=True
            )
            found[name].append(json.loads(done.stdout))
    return {name: {f: min(row[f] for row in rows) for f in FIGURES} for name, rows in found.items()}


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("categories", nargs="*", default=["Microwave", "Laptop", "StorageFurniture", "Faucet"])
    parser.add_argument("-n", type=int, default=256)
    parser.add_argument("--rounds", type=int, default=2)
    parser.add_argument("-o", "--out", type=Path)
    parser.add_argument("--alone", action="store_true", help=argparse.SUPPRESS)
    given = parser.parse_args()
    if given.alone:
        print(json.dumps(measure(given.categories[0], given.n)))
        return
    every = {}
    print(f"{'':18}" + "".join(f"{name:>22}" for name in FIGURES))
    for category in given.categories:
        every[category] = found = turns(category, given.n, given.rounds)
        cells = ((found["numpy"][f], found["c"][f]) for f in FIGURES)
        print(f"{category:18}" + "".join(f"{a:9.2f}{b:7.2f} x{a / b:4.2f}" for a, b in cells), flush=True)
    if given.out is not None:
        given.out.write_text(json.dumps(every, indent=1), encoding="utf-8")


if __name__ == "__main__":
    main()
