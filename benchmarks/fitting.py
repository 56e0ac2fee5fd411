"""How near `apgc fit` comes to real objects; `benchmarks/round_trip.py` fits samples of our own.

    python benchmarks/fitting.py FOLDER Door Chair               # a category and the folder of its objects below FOLDER
    python benchmarks/fitting.py FOLDER TrashCan=Trashcan        # where the folder has another name
    python benchmarks/fitting.py FOLDER Bottle=Chair             # chairs fitted by bottles: what a wrong category gives

Beside each distance stands that of one box along the axes for each link, and what is chosen. CPU seconds are those of this process,
divided by the objects. How much of what is chosen is right, `benchmarks/structure.py` says.
"""

from __future__ import annotations

import argparse
import time
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from artipg_dsl.fit.finding import find_files
from artipg_dsl.fit.fitting import fit, usual_size
from artipg_dsl.fit.measure import Surface, distances
from artipg_dsl.fit.model import Model
from artipg_dsl.fit.outer import outer
from artipg_dsl.fit.pose import Frame, Posed, pose, turn
from artipg_dsl.fit.reading import read_cloud
from artipg_dsl.fit.states import can_open
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


@dataclass(frozen=True, slots=True)
class Case:
    """A real object by the ``name`` of its folder, what was fitted to it, its distance in percent, and that of boxes."""

    name: str
    values: dict[str, Any]
    verdict: str
    distance: float
    boxes: float


def real(folder: Path, category: str, objects: str, frame: Frame) -> tuple[list[Case], float]:
    """What is fitted to the real objects of a folder, and the CPU seconds for each."""
    sampler = Session.of(category).sampler
    model = Model(sampler)
    opened = Model(sampler, opened=True) if can_open(sampler.program) else None
    files = find_files([str(folder / objects)])
    usual = usual_size(model)
    posed = [pose(read_cloud(file), frame, file.suffix, usual) for file in files]
    begun = time.process_time()
    found = fit(model, posed, opened=opened)
    spent = (time.process_time() - begun) / len(files)
    cases = []
    for file, cloud, one in zip(files, posed, found, strict=True):
        boxes = boxed(cloud, one.told["frame"]["up"], one.told["frame"]["front"])
        cases.append(Case(file.parent.name, one.values, one.told["verdict"], one.told["distance"]["both"], boxes))
    return cases, spent


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("folder", type=Path)
    parser.add_argument("pairs", nargs="+", metavar="CATEGORY=FOLDER")
    parser.add_argument("--front", default="auto")
    asked = parser.parse_args()
    told = []
    for pair in asked.pairs:
        category, _, objects = pair.partition("=")
        cases, spent = real(asked.folder, category, objects or category, Frame(front=asked.front))
        for case in cases:
            chosen = {k: v for k, v in case.values.items() if isinstance(v, str | int) and "." not in k}
            print(
                f"{category:<17} {case.name[:34]:<35} {case.distance:6.2f} {case.boxes:6.2f}  {case.verdict:<13} {spent:5.1f} s  {chosen}",
                flush=True,
            )
            told.append((case.distance, case.boxes))
    shares = np.array(told)
    print(f"{len(shares)} objects: median {np.median(shares[:, 0]):.2f}, boxes {np.median(shares[:, 1]):.2f}")


if __name__ == "__main__":
    main()
