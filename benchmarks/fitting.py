"""How well `apgc fit` finds objects: real ones, those of a wrong category, and samples of our own with noise and holes.

    python benchmarks/fitting.py real FOLDER Door=Door Chair=Chair        # a category and the folder of its objects below FOLDER
    python benchmarks/fitting.py real FOLDER Bottle=Chair                 # chairs fitted by bottles: what a wrong category gives
    python benchmarks/fitting.py round Bottle Chair -n 6 --noise 0.01 --missing 0.3

Beside each distance stands that of one box along the axes for each link. CPU seconds are those of this process, divided by the objects.
"""

from __future__ import annotations

import argparse
import time
from pathlib import Path

import numpy as np

import artipg_dsl as apg
from artipg_dsl.fit.fitting import fit, usual_size
from artipg_dsl.fit.measure import Surface, distances
from artipg_dsl.fit.model import Model
from artipg_dsl.fit.outer import outer
from artipg_dsl.fit.pose import Frame, Posed, pose, turn
from artipg_dsl.fit.reading import Cloud, find_files, read_cloud
from artipg_dsl.session import Session

POINTS = 16_384


def boxed(posed: Posed, up: str, front: str) -> float:
    """The distance of a cloud from one box for each of its links, in percent."""
    matrix = turn(up, front)
    points, normals = posed.points @ matrix.T, posed.normals @ matrix.T
    places, outward = [], []
    chance = np.random.default_rng(0)
    for label in np.unique(posed.label):
        low, high = (f(points[posed.label == label], axis=0) for f in (np.min, np.max))
        size = np.maximum(high - low, 1e-6)
        area = np.array([size[1] * size[2], size[0] * size[2], size[0] * size[1]])
        axis = chance.choice(3, POINTS, p=area / area.sum())
        side = chance.integers(2, size=POINTS)
        at = chance.random((POINTS, 3))
        at[np.arange(POINTS), axis] = side
        places.append(low + at * size)
        outward.append((2 * side - 1)[:, None] * np.eye(3)[axis])
    place, normal = np.concatenate(places), np.concatenate(outward)
    some = chance.permutation(len(place))[:POINTS]
    place, normal = place[some], normal[some]
    seen = outer(place[None])[0]
    word = np.zeros(len(place), dtype=np.int64)
    whole = Surface(place, normal, word)
    return distances(points, normals, whole, Surface(place[seen], normal[seen], word[seen]))["both"]


def real(folder: Path, category: str, objects: str, frame: Frame) -> list[tuple[float, float]]:
    """The distances of real objects from what is fitted to them, and from their boxes."""
    model = Model(Session.of(category).sampler)
    files = find_files([str(folder / objects)])
    usual = usual_size(model)
    posed = [pose(read_cloud(file), frame, file.suffix, usual) for file in files]
    begun = time.process_time()
    found = fit(model, posed)
    spent = (time.process_time() - begun) / len(files)
    told = []
    for file, cloud, one in zip(files, posed, found, strict=True):
        box = boxed(cloud, one.told["frame"]["up"], one.told["frame"]["front"])
        both, said = one.told["distance"]["both"], one.told["verdict"]
        told.append((both, box))
        chosen = {k: v for k, v in one.values.items() if isinstance(v, str | int) and "." not in k}
        print(
            f"{category:<17} {file.parent.name[:34]:<35} {both:6.2f} {box:6.2f}  {said:<13} {spent:5.1f} s  {chosen}",
            flush=True,
        )
    return told


def round_trip(category: str, n: int, noise: float, missing: float) -> None:
    """Samples fitted again: which choices and counts are right, and how far numbers are off, in ranges."""
    samples = apg.sample(category, n=n, seed=77)
    model = Model(samples.job.sampler)
    points, chance, posed = samples.points(20_000), np.random.default_rng(0), []
    for place, normal in zip(points.position, points.normal, strict=True):
        across = np.sqrt((np.ptp(place, axis=0) ** 2).sum())
        away = ((place - place[chance.integers(len(place))]) ** 2).sum(axis=1)
        kept = np.sort(np.argsort(away)[int(missing * len(place)) :])
        at = place[kept] + chance.normal(size=(len(kept), 3)) * noise * across / np.sqrt(3.0)
        cloud = Cloud(at, None if noise else normal[kept], np.full(len(kept), -1), ())
        posed.append(pose(cloud, Frame(up="z", front="x", unit="m"), ".npz", 1.0))
    begun = time.process_time()
    found = fit(model, posed)
    spent = (time.process_time() - begun) / n
    right = total = 0
    errors: list[float] = []
    for row, one in enumerate(found):
        truth = samples.batch.drawn(row)
        for number in (*model.discrete, *model.smooth):
            draw = model.program.draws[number]
            rows = np.flatnonzero(samples.batch.owner(draw.column.scope) == row)
            was, now = truth.get(draw.column.name), one.values.get(draw.column.name)
            if not len(rows) or was is None:
                continue
            if number in model.discrete:
                total += 1
                right += was == now
            elif isinstance(was, float) and isinstance(now, float):
                low, high = samples.batch.read(draw.ends, draw.column.scope)
                errors.append(abs(was - now) / max(high[rows[0]] - low[rows[0]], 1e-9))
    both = np.median([one.told["distance"]["both"] for one in found])
    print(
        f"{category:<17} {n} objects  distance {both:5.2f}  choices and counts {right}/{total}  "
        f"numbers off by {100 * np.median(errors):.1f} % of their range "
        f"(90th percentile {100 * np.quantile(errors, 0.9):.0f} %)  {spent:.1f} s",
        flush=True,
    )


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("what", choices=("real", "round"))
    parser.add_argument("names", nargs="+")
    parser.add_argument("-n", type=int, default=6)
    parser.add_argument("--noise", type=float, default=0.0)
    parser.add_argument("--missing", type=float, default=0.0)
    parser.add_argument("--front", default="auto")
    asked = parser.parse_args()
    if asked.what == "round":
        for category in asked.names:
            round_trip(category, asked.n, asked.noise, asked.missing)
        return
    folder, *pairs = asked.names
    told = []
    for pair in pairs:
        category, _, objects = pair.partition("=")
        told += real(Path(folder), category, objects or category, Frame(front=asked.front))
    shares = np.array(told)
    print(f"{len(shares)} objects: median {np.median(shares[:, 0]):.2f}, boxes {np.median(shares[:, 1]):.2f}")


if __name__ == "__main__":
    main()
