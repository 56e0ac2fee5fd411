"""Ways to draw valid objects side by side: how many first attempts are valid, what an object costs, what its law is.

* independent: every value from the hull of its declared range, whatever the others are. What equations determine still
  follows from them; drawn as well, it would be right with probability 0.
* ordered: every value from its declared range given the ones before, as a script draws them.
* static: ordered, each range narrowed beforehand to what the requirements leave of it whatever else is drawn.
* conditional: every value from the range that the ones before leave it. Sampling as shipped.
* prior: of 32 conditional attempts each one, resampled to the declared law.

The law of all draws is compared with what ``ordered`` accepts, which is the declared law restricted to valid objects.
"""

from __future__ import annotations

import argparse
import copy
import time
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np

from artipg_dsl.graph import expr as E
from artipg_dsl.graph.feasible import find_ranges
from artipg_dsl.graph.interval import Intervals
from artipg_dsl.graph.program import Draw, Program, Requirement
from artipg_dsl.runtime.kernels import State
from artipg_dsl.runtime.plan import Plan, make_plan
from artipg_dsl.sampling.sample import Sampler
from artipg_dsl.session import Session

BLOCK = 4096
REFERENCE = 6000  # valid objects that the law is compared with
LIMIT = 400_000_000  # draws at most for them
PROGRAMS = ("Microwave", "StorageFurniture", str(Path(__file__).parent / "tight_chain.apg"))


def varied(program: Program, draws: list[Draw], more: tuple[Requirement, ...] = ()) -> Plan:
    found = copy.copy(program)
    found.draws, found.requirements = draws, [*program.requirements, *more]
    return make_plan(found, ())


def bare(draw: Draw) -> Draw:
    return replace(draw, bounds=[], unions=[], limits=[])


def ordered(program: Program) -> Plan:
    return varied(program, [bare(d) for d in program.draws])


def static(program: Program) -> Plan:
    draws = []
    for number, draw in enumerate(program.draws):
        low, high = find_ranges(program).get(number, (0.0, 0.0))
        if number in find_ranges(program) and low <= high:
            draw = replace(draw, low=E.maximum(draw.low, E.const(low)), high=E.minimum(draw.high, E.const(high)))
        draws.append(bare(draw))
    return varied(program, draws)


def independent(program: Program) -> Plan:
    intervals = Intervals(program.draws, program.definitions)
    draws, more = [], []
    for draw in program.draws:
        if draw.low is not None and (draw.low.constant is None or draw.high.constant is None):
            value, scope = E.col(draw.column), draw.column.scope
            for low, high in ((draw.low, value), (value, draw.high)):
                more.append(Requirement(scope, E.call("le", low, high), E.TRUE, "its range", draw.where, (low, high)))
            draw = replace(draw, low=E.const(intervals.of(draw.low)[0]), high=E.const(intervals.of(draw.high)[1]))
        if draw.kind == "choice":
            draw = replace(draw, weights=tuple(E.const(max(intervals.of(w)[1], 1e-9)) for w in draw.weights))
        draws.append(bare(draw))
    return varied(program, draws, tuple(more))


@dataclass
class Drawn:
    """Objects by number: their draws as (object, value) columns, and weights."""

    columns: dict[int, tuple[np.ndarray, np.ndarray]]
    weights: np.ndarray


def evaluate(plan: Plan, first: int, count: int, attempt: int = 0, weigh: bool = False) -> tuple[State, list]:
    state = State(7, np.arange(first, first + count), np.full(count, attempt), weigh=weigh)
    return state, plan.function(state)[0]


def tried(plan: Plan, objects: int) -> tuple[float, float]:
    """The valid share of first attempts, and microseconds per valid object."""
    evaluate(plan, 0, 64)
    valid, begun = 0, time.process_time()
    for first in range(0, objects, BLOCK):
        valid += int((~evaluate(plan, first, min(BLOCK, objects - first))[0].failed).sum())
    spent = time.process_time() - begun
    return valid / objects, 1e6 * spent / valid if valid else np.inf


def columns(plan: Plan, state: State, tables: list, keep: np.ndarray) -> dict[int, tuple[np.ndarray, np.ndarray]]:
    """The draws of the objects to keep, numbered anew."""
    place = np.cumsum(keep) - 1
    found = {}
    for number, draw in enumerate(plan.program.draws):
        owner = tables[plan.scopes[draw.column.scope]].owner
        rows = keep[owner]
        found[number] = place[owner[rows]], state.values[number][rows]
    return found


def reference(program: Program) -> Drawn | None:
    """The declared law restricted to valid objects, by rejection; None where that takes too long."""
    plan, parts, count, first = ordered(program), [], 0, 0
    while count < REFERENCE and first * len(program.draws) < LIMIT:
        state, tables = evaluate(plan, first, BLOCK)
        keep = ~state.failed
        parts.append((count, columns(plan, state, tables, keep)))
        count, first = count + int(keep.sum()), first + BLOCK
    if count < REFERENCE // 4:
        return None
    joined = {
        k: (np.concatenate([at + part[k][0] for at, part in parts]), np.concatenate([part[k][1] for _, part in parts]))
        for k in range(len(program.draws))
    }
    return Drawn(joined, np.ones(count))


def conditional(program: Program, count: int) -> tuple[Drawn, np.ndarray]:
    """Valid first attempts, and the logarithms of their weights."""
    plan = make_plan(program, ())
    state, tables = evaluate(plan, 0, count, weigh=True)
    keep = ~state.failed
    return Drawn(columns(plan, state, tables, keep), np.ones(int(keep.sum()))), state.log_weight[keep]


def resampled(program: Program, count: int, candidates: int) -> tuple[Drawn, float]:
    """Objects of ``prior``, and the microseconds that one takes."""
    sampler = Sampler(program, make_plan(program, ()))
    sampler.batch(np.arange(4), 7, candidates=candidates)
    begun = time.process_time()
    batch = sampler.batch(np.arange(count), 7, candidates=candidates)
    spent = time.process_time() - begun
    found = {k: (batch.owner(d.column.scope), batch.state.values[k]) for k, d in enumerate(program.draws)}
    return Drawn(found, np.ones(count)), 1e6 * spent / count


def distances(ours: Drawn, theirs: Drawn) -> np.ndarray:
    """Kolmogorov and Smirnov's distance for each draw that has rows enough on both sides."""
    found = []
    for number, (owner, value) in ours.columns.items():
        other, known = theirs.columns[number]
        if min(len(value), len(known)) < 500:
            continue
        marks = np.unique(np.round(np.concatenate([value, known]), 9))
        found.append(np.abs(step(value, ours.weights[owner], marks) - step(known, theirs.weights[other], marks)).max())
    return np.array(found)


def step(value: np.ndarray, weight: np.ndarray, marks: np.ndarray) -> np.ndarray:
    value = np.round(value, 9)
    order = np.argsort(value, kind="stable")
    total = np.concatenate([[0.0], np.cumsum(weight[order])]) / weight.sum()
    return total[np.searchsorted(value[order], marks, side="right")]


def halves(drawn: Drawn) -> np.ndarray:
    """What two samples of one law are apart: the even and the odd objects of a reference."""
    parts = []
    for odd in (0, 1):
        found = {k: (o[o % 2 == odd] // 2, v[o % 2 == odd]) for k, (o, v) in drawn.columns.items()}
        parts.append(Drawn(found, np.ones((len(drawn.weights) + 1) // 2)))
    return distances(*parts)


def told(title: str, found: np.ndarray) -> None:
    print(f"  {title:44} mean {found.mean():.3f}   greatest {found.max():.3f}")


def table(name: str, objects: int) -> None:
    session = Session.of(name)
    program = session.sampler.program
    real = sum(d.kind != "choice" for d in program.draws)
    print(f"\n{program.name}: {len(program.draws)} draws ({real} numbers), {len(program.requirements)} requirements")
    for title, plan in (
        ("independent", independent(program)),
        ("ordered", ordered(program)),
        ("static", static(program)),
        ("conditional", make_plan(program, ())),
    ):
        share, cost = tried(plan, objects)
        print(f"  {title:14}{100 * share:10.4f} % of first attempts valid{cost:14,.1f} us per valid object")
    known = reference(program)
    if known is None:
        print("  no reference: rejection finds too few objects")
    for candidates in (8, 32, 128):
        made, cost = resampled(program, REFERENCE if candidates < 128 else REFERENCE // 2, candidates)
        print(f"  prior:{candidates:<8}{100.0:10.4f} %{cost:41,.1f} us per object")
        if known is not None:
            told(f"KS distance, prior:{candidates}", distances(made, known))
    plain, weights = conditional(program, REFERENCE)
    weight = np.exp(weights - weights.max())
    print(f"  effective sample size of the weights {weight.sum() ** 2 / (weight**2).sum():,.0f} of {len(weight):,}")
    if known is not None:
        told("KS distance, conditional", distances(plain, known))
        told("KS distance, conditional, weighed", distances(Drawn(plain.columns, weight), known))
        told(f"two halves of the reference ({len(known.weights):,})", halves(known))


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.split("\n")[0])
    parser.add_argument("programs", nargs="*", default=PROGRAMS)
    parser.add_argument("-n", type=int, default=40_000, help="first attempts of each way")
    options = parser.parse_args()
    for name in options.programs:
        table(name, options.n)


if __name__ == "__main__":
    main()
