"""Samples of our own fitted again: how many of the choices and counts that can be seen are right, how far numbers are off, what it costs.

    python benchmarks/round_trip.py Door Chair -n 4 --json clean.json
    python benchmarks/round_trip.py Door Chair -n 4 --noise 0.01 --missing 0.3
    python benchmarks/round_trip.py Door Chair -n 4 --labels
    python benchmarks/round_trip.py Door Chair -n 4 --joints

A choice can be seen if the cloud that is fitted, with its noise and its holes, speaks against every other value of it for the true
object: by more than 12 in natural logarithms, whatever is drawn for parts that are new (two draws). It is clear if it does so also once these
have moved to where the cloud has them. Choices and counts of parts that occur several times count each. A choice is right if the part has it in
the same place among its like.

A number can be seen if the cloud speaks likewise, by the same 12, against moving it up or down by a tenth of its range: alone, and with all
others following so that the surface stays where it is as far as it can (the shares of the cells of a column may all double). Errors are
relative to ranges: the median of what can be seen and the share of it that is off by 2 % at most, and the median of all numbers.

CPU seconds are those of this process, for all of a fit. With ``--labels`` the points of clouds bear the words of ``semantic``,
with ``--joints`` links and joints are known.
"""

from __future__ import annotations

import argparse
import json
import time
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np

import artipg_dsl as apg
from artipg_dsl.fit.bodies import Bodies
from artipg_dsl.fit.compare import Candidates
from artipg_dsl.fit.decide import settled
from artipg_dsl.fit.develop import apart, copied
from artipg_dsl.fit.evidence import Clouds, Copies, weigh, weigh_again, weigh_change
from artipg_dsl.fit.fitting import Fitted, fit, usual_size
from artipg_dsl.fit.links import Moving
from artipg_dsl.fit.model import Changes, Model, Placed
from artipg_dsl.fit.pose import Frame, Posed, pose, targets
from artipg_dsl.fit.reading import Cloud
from artipg_dsl.fit.search import Effort
from artipg_dsl.fit.tries import tries
from artipg_dsl.fit.vary import Ways
from artipg_dsl.runtime.batch import Batch
from artipg_dsl.sampling.search import domain_ends

CATEGORIES = ("Door", "Bottle", "Microwave", "Chair", "StorageFurniture", "Window", "WashingMachine", "Kettle")
SURE = 12.0
LANES = 2
MOVED, ROOM, NEAR = 0.1, 0.05, 0.02  # of their ranges: how far numbers are moved, or at least, and what is right
SAME = 1e-4  # diagonals: what moves by less is not weighed
BLOCK = 96  # copies at a time
Row = tuple[int, ...]  # object, draw, and which of its rows, by the ranks of what it repeats in
Values = list[dict[Row, float]]  # of each object


def clouds(samples: apg.Samples, usual: float, noise: float, missing: float, joints: bool = False) -> list[Posed]:
    """The labelled surfaces of samples, with noise (of the diagonal) and without what is nearest to one of their points."""
    points, chance, posed = samples.points(20_000), np.random.default_rng(0), []
    names = tuple(samples.batch.program.vocabularies["semantic"])
    if joints:
        batch, points = samples.batch, replace(points, semantic=points.link)
        most = int(batch.links().number.max()) + 1
        names = tuple(f"link{k}" for k in range(most))
        moving = Moving.of(batch)
    for k, (place, normal, word) in enumerate(zip(points.position, points.normal, points.semantic, strict=True)):
        across = np.sqrt((np.ptp(place, axis=0) ** 2).sum())
        away = ((place - place[chance.integers(len(place))]) ** 2).sum(axis=1)
        kept = np.sort(np.argsort(away)[int(missing * len(place)) :])
        at = place[kept] + chance.normal(size=(len(kept), 3)) * noise * across / np.sqrt(3.0)
        cloud = Cloud(at, None if noise else normal[kept], word[kept].astype(np.int64), names)
        if joints:
            cloud = replace(cloud, bodies=Bodies(moving.first[k], moving.twist[k]))
        posed.append(pose(cloud, Frame(up="z", front="x", unit="m"), ".npz", usual))
    return posed


def said(posed: list[Posed]) -> dict[str, str]:
    """Each word that the clouds bear, meant as itself."""
    return {one.names[k]: one.names[k] for one in posed for k in np.unique(one.label).tolist() if k > 0}


def rows_of(batch: Batch, number: int) -> list[Row]:
    scope = batch.program.draws[number].column.scope
    ranks = [rank for _, rank in batch.rowmap.ranks(scope)]
    columns = [batch.owner(scope), np.full(len(batch.owner(scope)), number), *ranks]
    return list(zip(*(column.tolist() for column in columns), strict=True))


def margins(model: Model, true: Batch, posed: list[Posed]) -> tuple[dict[Row, float], dict[Row, float]]:
    """For each choice and count what the cloud says against the value that is nearest to being as likely: as it is drawn, and after what is
    new has moved to where the cloud has it."""
    own, every = targets(posed), np.arange(len(true))
    asked = Clouds(own)
    whole = Candidates(true, every, Placed(np.ones(len(true)), np.zeros((len(true), 3))), np.zeros(len(true)))
    base = weigh(true, every, whole.placed, asked)
    drawn: dict[Row, float] = {}
    moved: dict[Row, float] = {}
    named = {number: rows_of(true, number) for number in (*model.discrete, *model.ruling)}
    for one in tries(model, true, LANES, 1):
        copies = copied(whole, one.batch, one.of)
        origins = Copies(model.assembled([(true, one.of)]), one.of, one.of, whole.placed.take(one.of))
        told = weigh_change(copies, asked, base, apart(whole, copies)).told
        near = settled(model, own, whole, copies, told, Effort())
        first, then = (weigh_again(each, origins, asked, base, apart(whole, each)).loss for each in (copies, near))
        for draw, row, one_loss, other in zip(*(a.tolist() for a in (one.draw, one.row, first, then)), strict=True):
            key = named[draw][row]
            drawn[key] = min(drawn.get(key, np.inf), one_loss)
            moved[key] = min(moved.get(key, np.inf), one_loss, other)
    return drawn, moved


def holds(model: Model, true: Batch, posed: list[Posed]) -> dict[Row, float]:
    """For each number what the cloud says against moving it, up or down, alone or with all others following: the least of these."""
    own, every = targets(posed), np.arange(len(true))
    whole = Candidates(true, every, Placed(np.ones(len(true)), np.zeros((len(true), 3))), np.zeros(len(true)))
    asked, ways = Clouds(own), Ways.of(model, own, whole)
    base, free = weigh(true, every, whole.placed, asked), ways.free
    at, by = np.tile(np.arange(len(free)), 2), np.repeat([-MOVED, MOVED], len(free))
    value = np.clip(free.value[at] + by * free.width[at], free.low[at], free.high[at])
    by = (value - free.value[at]) / free.width[at]
    room = np.flatnonzero(np.abs(by) > ROOM)
    told: dict[Row, float] = {}
    named = {number: rows_of(true, number) for number in model.smooth}
    for start in range(0, len(room), BLOCK):
        some = room[start : start + BLOCK]
        number, of = at[some], free.owner[at[some]]
        changes = Changes(np.arange(len(some)), free.draw[number], free.row[number], value[some])
        alone = copied(whole, model.altered(true, of, changes), of)
        following = ways.copies(model, whole, of, ways.moves(number, by[some]))
        origins = Copies(model.assembled([(true, of)]), of, of, whole.placed.take(of))
        for copies in (alone, following):
            change = apart(whole, copies, SAME * own.diagonal[of])
            loss = weigh_again(copies, origins, asked, base, change).loss
            loss = np.where(change.anywhere(len(of)), loss, 0.0)
            for k in np.flatnonzero(~copies.batch.state.failed).tolist():
                key = named[int(free.draw[number[k]])][int(free.row[number[k]])]
                told[key] = min(told.get(key, np.inf), float(loss[k]))
    return told


def values_of(model: Model, found: list[Fitted]) -> Values:
    """The values of what was found, each object by its place."""
    told: Values = []
    for place, one in enumerate(found):
        own = {}
        for number in (*model.discrete, *model.smooth):
            named = zip(rows_of(one.batch, number), one.batch.state.values[number].tolist(), strict=True)
            own |= {(place, *row[1:]): value for row, value in named if row[0] == one.row}
        told.append(own)
    return told


def beside(model: Model, true: Batch, posed: list[Posed], found: Values) -> dict[str, Any]:
    """What of the true objects was found."""
    seen, still = margins(model, true, posed)
    held = holds(model, true, posed)
    right = total = unseen = sure = clear = 0
    wrong: dict[str, int] = {}
    errors: list[tuple[bool, float]] = []
    for number in (*model.discrete, *model.smooth):
        values = true.state.values[number]
        low, high = domain_ends(true, number)
        for k, key in enumerate(rows_of(true, number)):
            now = found[key[0]].get(key)
            if number not in model.discrete:
                if now is not None and high[k] > low[k]:
                    errors.append((held.get(key, 0.0) > SURE, abs(now - values[k]) / (high[k] - low[k])))
            elif seen.get(key, 0.0) > SURE:
                total += 1
                good = now is not None and abs(now - values[k]) < 1e-9
                right += int(good)
                clear += int(still[key] > SURE)
                sure += int(good and still[key] > SURE)
                name = model.program.draws[number].column.name
                wrong |= {} if good else {name: wrong.get(name, 0) + 1}
            else:
                unseen += 1
    return {
        "right": right,
        "seen": total,
        "unseen": unseen,
        "clear": clear,
        "right_clear": sure,
        "wrong": wrong,
        "errors": errors,
    }


def figures(visible: np.ndarray, off: np.ndarray) -> dict[str, float]:
    """Of errors (n,) in ranges, of which some are ``visible`` (n,)."""
    seen = off[visible] if visible.any() else np.array([np.nan])
    return {
        "seen": int(visible.sum()),
        "unseen": int((~visible).sum()),
        "median_seen": round(float(np.median(seen)), 4),
        "near": round(float((seen <= NEAR).mean()), 3),
        "mean_seen": round(float(seen.mean()), 4),
        "median": round(float(np.median(off)), 4),
    }


def said_of(one: dict[str, float]) -> str:
    seen = f"{100 * one['median_seen']:.1f} % of {one['seen']}"
    return f"{seen:>20} {100 * one['near']:>9.0f} % {one['unseen']:>9} {100 * one['median']:>7.1f} %"


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("categories", nargs="*", default=CATEGORIES)
    parser.add_argument("-n", type=int, default=4)
    parser.add_argument("--noise", type=float, default=0.0)
    parser.add_argument("--missing", type=float, default=0.0)
    parser.add_argument("--labels", action="store_true")
    parser.add_argument("--joints", action="store_true")
    parser.add_argument("--seed", type=int, default=77)
    parser.add_argument("--json", type=Path)
    asked = parser.parse_args()
    told: dict[str, dict[str, Any]] = {}
    every: list[tuple[np.ndarray, np.ndarray]] = []
    print(
        f"{'':<17} right of seen    of clear  not seen  median error of seen  within 2 %  not seen   of all  distance  CPU s",
        flush=True,
    )
    for category in asked.categories or CATEGORIES:
        samples = apg.sample(category, n=asked.n, seed=asked.seed)
        model = Model(samples.job.sampler, jointed=asked.joints)
        posed = clouds(samples, usual_size(model), asked.noise, asked.missing, asked.joints)
        begun = time.process_time()
        found = fit(model, posed, words=said(posed) if asked.labels else None)
        spent = (time.process_time() - begun) / asked.n
        true = model.assembled([(samples.batch, np.arange(asked.n))])
        one = beside(model, true, posed, values_of(model, found))
        visible, off = (np.array(column) for column in zip(*one.pop("errors"), strict=True))
        every.append((visible, off))
        one |= {
            "numbers": figures(visible, off),
            "distance": float(np.median([each.told["distance"]["both"] for each in found])),
            "seconds": round(spent, 2),
        }
        told[category] = one
        print(
            f"{category:<17} {one['right']:>5} of {one['seen']:<5} {one['right_clear']:>4} of {one['clear']:<4} {one['unseen']:>6} "
            f"{said_of(one['numbers'])} {one['distance']:>8.2f} {one['seconds']:>7.1f}  {one['wrong']}",
            flush=True,
        )
    for right, seen in (("right", "seen"), ("right_clear", "clear")):
        good, of = (sum(one[name] for one in told.values()) for name in (right, seen))
        print(f"all, {seen:<12} {good:>5} of {of:<5} ({100 * good / max(of, 1):.0f} %)")
    told["all"] = {"numbers": figures(*(np.concatenate(column) for column in zip(*every, strict=True)))}
    print(f"all numbers {said_of(told['all']['numbers'])}")
    if asked.json:
        asked.json.write_text(json.dumps(told, indent=1) + "\n")


if __name__ == "__main__":
    main()
