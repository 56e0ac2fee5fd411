"""Repair after a disturbance: every number of valid objects moved by up to a tenth of its domain, then put right.

    python benchmarks/repair.py [-n OBJECTS] [CATEGORY ...]

For each category: how many disturbed objects are invalid as they are (a value out of its range, a requirement, solids),
how many the repair makes valid without drawing anything again, how many values it moves and how far, and the time.
"""

from __future__ import annotations

import argparse
import time

import numpy as np

from artipg_dsl.random import key, uniform
from artipg_dsl.runtime.kernels import Kept
from artipg_dsl.sampling.clips import Asked
from artipg_dsl.sampling.known import evaluate_again, match_keys, rows_of_draw
from artipg_dsl.sampling.repair import repair
from artipg_dsl.sampling.search import domain_ends
from artipg_dsl.session import Session, categories

SHARE = 0.1  # of the width of a domain


def disturbed(batch, share: float = SHARE) -> list[np.ndarray]:  # noqa: ANN001
    """The drawn numbers of a batch, each moved evenly within ``share`` of the width of its domain either way."""
    asked = []
    for number, draw in enumerate(batch.program.draws):
        value = batch.state.values[number]
        if draw.kind == "real":
            low, high = domain_ends(batch, number)
            rows = batch.rowmap.rows(draw.column.scope)
            unit = uniform(key(batch.seed, draw.address, "disturbed"), rows.address)
            value = value + share * (high - low) * (2.0 * unit - 1.0)
        asked.append(value)
    return asked


def kept(batch, asked: list[np.ndarray]):  # noqa: ANN001, ANN201
    """The objects of a batch evaluated with values asked, clipped into what is left of their ranges."""
    values = []
    for number, held in enumerate(asked):
        at = rows_of_draw(batch, number, np.arange(len(batch)))
        order = np.argsort(at.key, kind="stable")
        still = np.zeros(len(order))
        values.append(Kept(at.key[order], held[at.row][order], still, still.astype(bool)))
    return evaluate_again(batch, np.arange(len(batch)), values=values)


def stated(batch, asked: list[np.ndarray], trial) -> Asked:  # noqa: ANN001
    """What was asked, by the rows of the evaluation: templates that no longer fit have brought rows of their own."""
    values, known = [], []
    for number in range(len(asked)):
        old, new = (rows_of_draw(b, number, np.arange(len(batch))) for b in (batch, trial))
        here, there = match_keys(old.key, new.key)
        value, mine = trial.state.values[number].copy(), np.zeros(len(new.row), dtype=bool)
        value[new.row[there]], mine[new.row[there]] = asked[number][old.row[here]], True
        values.append(value)
        known.append(mine)
    return Asked(values, known)


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("names", nargs="*", metavar="CATEGORY")
    parser.add_argument("-n", type=int, default=500)
    options = parser.parse_args()
    print(
        "| category | invalid as disturbed | still after clipping | repaired | values moved of | change of a moved value | ms an object |"
    )
    print("|---|---:|---:|---:|---:|---:|---:|")
    shares = []
    for name in options.names or sorted(categories()):
        sampler = Session.of(name).sampler
        batch = sampler.batch(np.arange(options.n), 0, checked=True)
        asked = disturbed(batch)
        start = time.process_time()
        trial = kept(batch, asked)
        found = repair(sampler, trial, stated(batch, asked, trial))
        spent = 1e3 * (time.process_time() - start) / options.n
        log = found.repairs
        failing = np.unique(np.concatenate([np.zeros(0, dtype=np.int64), *found.failing.values()]))
        wrong = np.union1d(log.objects(), found.failed)
        good = 1.0 - len(found.failed) / options.n
        shares.append(good)
        width = np.array([domain_width(batch, k) for k in range(len(sampler.program.draws))])
        change = np.abs(log.after - log.before) / np.maximum(width[log.draw], 1e-12)
        numbers = sum(len(v) for v, d in zip(asked, sampler.program.draws, strict=True) if d.kind == "real") / options.n
        print(
            f"| {name} | {100 * len(wrong) / options.n:.1f} % | {100 * len(failing) / options.n:.1f} % | {100 * good:.2f} % "
            f"| {len(log) / options.n:.1f} of {numbers:.0f} | {100 * np.median(change) if len(log) else 0:.1f} % | {spent:.1f} |",
            flush=True,
        )
    print(f"\nrepaired in all: {100 * np.mean(shares):.2f} %")


def domain_width(batch, number: int) -> float:  # noqa: ANN001
    """The mean width of the domain of a draw."""
    low, high = domain_ends(batch, number)
    return float(np.mean(high - low)) if len(low) else 1.0


if __name__ == "__main__":
    main()
