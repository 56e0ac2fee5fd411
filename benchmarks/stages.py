# ruff: noqa: E402 - the number of threads is set before NumPy is loaded
"""Every stage beside a plain loop over objects with NumPy and trimesh, and beside the time to fill its output memory.

Three programs: a microwave of boxes and cylinders alone (`sharp_microwave.apg`), the shipped one with its rounded
edges, and a kettle of turned and swept surfaces (`lathe_kettle.apg`). Per stage, microseconds of CPU time per object:

* columns: a batch. `resolve` gives the tables; `mesh` closed meshes of 24 steps per turn, placed; `points` candidates,
  placed and thinned; `hidden` what of them is hidden; `labels` classes and every label of the program; `collision`
  convex pieces and all penetrations of links, at rest and over the whole range of every joint; `views` four pictures of
  320 x 240 with depth, normals, classes, part coordinates and a cloud of 2,048 points each.
* loop: one object after the other, as in `main_job.py`. It does less in places: one affordance in `labels`; at rest and
  in eight states per joint in `collision` (FCL on the convex hulls of parts); depth, normals and classes in `views`
  (embree).
* fill: the time NumPy takes to allocate and fill arrays of the types and shapes that the columns give.

Rounds of all take turns; the figures are medians. All in one thread. With `--quality`, figures of quality instead:
whether points are uniform, meshes closed, labels the same after a rigid motion, bindings the same after a round trip.

    python benchmarks/stages.py [--objects 256] [--rounds 5] [--points 2048] [--quality]
"""

from __future__ import annotations

import os

for _variable in ("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS", "MKL_NUM_THREADS"):
    os.environ[_variable] = "1"

import argparse
import time
from pathlib import Path

import numpy as np
import quality
import trimesh
from main_job import STEPS, Loop

from artipg_dsl import random
from artipg_dsl.annotate.cameras import Cameras
from artipg_dsl.annotate.cloud import sample_points
from artipg_dsl.annotate.points import label_points
from artipg_dsl.annotate.views import make_views
from artipg_dsl.geometry import points
from artipg_dsl.geometry.hidden import Occlusion
from artipg_dsl.geometry.resolution import Resolution
from artipg_dsl.robot import solids
from artipg_dsl.session import Session
from artipg_dsl.validity.validate import find_collisions

HERE = Path(__file__).parent
PROGRAMS = {
    "sharp microwave": HERE / "sharp_microwave.apg",
    "rounded microwave": "Microwave",
    "lathe and sweep kettle": HERE / "lathe_kettle.apg",
}
STAGES = ("resolve", "mesh", "points", "hidden", "labels", "collision", "views")
MAIN = ("resolve", "mesh", "points", "hidden", "labels")
VIEW = Cameras(count=4)
SEEN = 16  # objects of which views are made, of a batch
ARRAYS = (np.int32, np.int32, np.int16, np.float64, np.float64)


class Watch:
    """CPU seconds spent in the methods that find hidden points."""

    NAMES = ("__init__", "visible", "flat_hidden", "loose_hidden")

    def __enter__(self) -> Watch:
        self.seconds, self.kept = 0.0, {name: getattr(Occlusion, name) for name in self.NAMES}
        for name, method in self.kept.items():
            setattr(Occlusion, name, self.timed(method))
        return self

    def timed(self, method):
        def run(*arguments):
            begun = time.process_time()
            made = method(*arguments)
            self.seconds += time.process_time() - begun
            return made

        return run

    def __exit__(self, *_) -> None:
        for name, method in self.kept.items():
            setattr(Occlusion, name, method)


def columns(sampler, numbers: np.ndarray, n_points: int) -> tuple[dict[str, float], dict[str, list]]:
    """CPU seconds per object and stage of the columnar runtime; shapes and types of what each stage gives."""
    spent, out = {}, {}
    begun = time.process_time()
    batch = sampler.batch(numbers, seed=7)
    sites = batch.sites()
    spent["resolve"] = time.process_time() - begun
    columns = [np.zeros((len(s), 15 + len(s.params))) for s in sites]
    out["resolve"] = [(a.shape, a.dtype) for a in columns]

    begun = time.process_time()
    meshes = solids.build_meshes(sites, Resolution(STEPS))
    spent["mesh"] = time.process_time() - begun
    out["mesh"] = [(group.vertices.shape, np.float64) for group in meshes]

    begun = time.process_time()
    with Watch() as watch:
        made = points.sample(sites, len(batch), n_points, random.key(7, "points"), batch.numbers.astype(np.uint64))
    spent["points"] = time.process_time() - begun - watch.seconds
    spent["hidden"] = watch.seconds
    shape = made.site.shape
    out["points"] = [(shape, kind) for kind in ARRAYS] + [((*shape, 3), np.float64)] * 2
    out["hidden"] = [(shape, bool)]

    begun = time.process_time()
    labels = label_points(batch, sites, made)
    spent["labels"] = time.process_time() - begun
    out["labels"] = [(a.shape, a.dtype) for a in (labels.semantic, *labels.fields.values())]

    begun = time.process_time()
    found = find_collisions(batch)
    spent["collision"] = time.process_time() - begun
    out["collision"] = [((len(batch), len(found.joint) // len(batch) + 1), np.float64)]

    few = sampler.batch(numbers[:SEEN], seed=7)
    sample_points(few, 16)  # tables and the formulas of labels are at hand then
    begun = time.process_time()
    views = make_views(few, VIEW)
    spent["views"] = (time.process_time() - begun) * len(numbers) / len(few)
    arrays = (*views.images.values(), *views.cloud.values())
    out["views"] = [(a.shape, a.dtype) for a in arrays]
    return {stage: seconds / len(numbers) for stage, seconds in spent.items()}, out


def fill(shapes: dict[str, list], count: int) -> dict[str, float]:
    """CPU seconds per object to allocate and fill what each stage gives."""
    spent = {}
    for stage, arrays in shapes.items():
        begun = time.process_time()
        kept = [np.full(shape, 1, kind) for shape, kind in arrays]
        spent[stage] = (time.process_time() - begun) / (SEEN if stage == "views" else count)
        del kept
    return spent


class PlainLoop(Loop):
    """The plain way of all stages."""

    def objects(self, numbers: np.ndarray) -> dict[str, float]:
        """CPU seconds per object and stage."""
        spent = dict.fromkeys(STAGES, 0.0)
        generator = np.random.default_rng(0)
        for number in numbers:
            marks = [time.process_time()]

            def mark(marks=marks) -> None:
                marks.append(time.process_time())

            batch = self.sampler.batch(np.array([number]), seed=7)
            sites = batch.sites()
            mark()
            placed = [self.primitive(table, row) for table in sites for row in range(len(table))]
            whole = trimesh.util.concatenate([m for m, *_ in placed])
            owner = np.repeat(np.arange(len(placed)), [len(m.faces) for m, *_ in placed])
            mark()
            trimesh.sample.sample_surface(whole, int(1.3 * self.n_points), seed=1)
            mark()
            _, normal, which = self.visible(whole, owner, placed, generator)
            mark()
            self.label(normal, which, placed)
            mark()
            self.collide(batch, placed)
            mark()
            self.look(batch, whole, owner, placed)
            mark()
            steps = np.diff(marks)
            steps[3] -= steps[2]  # drawing points is part of what finds visible ones
            for stage, seconds in zip(STAGES, steps.tolist(), strict=True):
                spent[stage] += seconds / len(numbers)
        return spent

    def collide(self, batch, placed) -> bool:
        """Whether links meet, at rest or in eight states of each joint alone."""
        manager = trimesh.collision.CollisionManager()
        links = np.array([t.link[r] for _, t, r, _ in placed])
        for link in np.unique(links):
            parts = [placed[k][0].convex_hull for k in np.flatnonzero(links == link)]
            manager.add_object(str(link), trimesh.util.concatenate(parts))
        rest, joints, met = batch.rest(), batch.joints(), False
        states = [rest]
        for k in range(len(rest)):
            low, high = np.nan_to_num([joints.low[k], joints.high[k]], nan=np.pi)
            states += [np.where(np.arange(len(rest)) == k, value, rest) for value in np.linspace(low, high, 8)]
        for state in states:
            turn, shift = batch.pose(state)
            for link in np.unique(links):
                pose = np.eye(4)
                pose[:3, :3], pose[:3, 3] = turn[link], shift[link]
                manager.set_transform(str(link), pose)
            met |= bool(manager.in_collision_internal())
        return met

    def look(self, batch, whole, owner, placed) -> list[tuple[np.ndarray, ...]]:
        """Depth, normals and classes of the pictures."""
        low, high = whole.bounds
        centre, radius = (low + high) / 2, float(np.linalg.norm(high - low)) / 2
        turns, eyes = VIEW.place(random.key(7, "views"), np.array([0], np.uint64), centre[None], np.array([radius]))
        y, x = np.mgrid[: VIEW.height, : VIEW.width] + 0.5
        local = np.stack(
            [(x - VIEW.width / 2) / VIEW.focal, (y - VIEW.height / 2) / VIEW.focal, np.ones_like(x)], axis=-1
        )
        classes, made = np.array([t.semantic[r] for _, t, r, _ in placed])[owner], []
        for turn, eye in zip(turns[0], eyes[0], strict=True):
            ways = local.reshape(-1, 3) @ turn
            starts = np.repeat(eye[None], len(ways), axis=0)
            place, ray, face = whole.ray.intersects_location(starts, ways, multiple_hits=False)
            depth, normal = np.zeros(len(ways)), np.zeros((len(ways), 3))
            semantic = np.full(len(ways), 0xFFFF)
            depth[ray], normal[ray], semantic[ray] = (place - eye) @ turn[2], whole.face_normals[face], classes[face]
            made.append((depth, normal, semantic))
        return made


def table(name: str, options: argparse.Namespace) -> None:
    """Print one program's figures."""
    sampler = Session.of(PROGRAMS[name]).sampler
    numbers = np.arange(options.objects)
    few = numbers[:: max(1, options.objects // 12)]
    loop = PlainLoop(sampler, options.points)
    columns(sampler, numbers[:8], options.points)  # what is compiled once is compiled here
    loop.objects(few[:2])
    ours, theirs, least = [], [], []
    for _ in range(options.rounds):
        spent, shapes = columns(sampler, numbers, options.points)
        ours.append(spent)
        least.append(fill(shapes, len(numbers)))
        theirs.append(loop.objects(few))
    a, b, c = ({s: float(np.median([o[s] for o in runs])) * 1e6 for s in STAGES} for runs in (ours, theirs, least))
    print(f"\n{name}: {options.objects} objects, {options.points} points each")
    print(f"{'stage':22}{'columns':>10}{'loop':>11}{'ratio':>8}{'fill':>9}{'share':>8}")
    for title, stages in [*((s, (s,)) for s in STAGES), ("resolve to labels", MAIN), ("all", STAGES)]:
        one, other, bound = (sum(x[s] for s in stages) for x in (a, b, c))
        print(f"{title:22}{one:10.0f}{other:11.0f}{other / one:8.1f}{bound:9.2f}{100 * bound / one:7.1f}%")


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--objects", type=int, default=256)
    parser.add_argument("--rounds", type=int, default=5)
    parser.add_argument("--points", type=int, default=2048)
    parser.add_argument("--quality", action="store_true")
    options = parser.parse_args()
    for name, program in PROGRAMS.items():
        if options.quality:
            quality.table(name, Session.of(program))
        else:
            table(name, options)


if __name__ == "__main__":
    main()
