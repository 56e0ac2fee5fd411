# ruff: noqa: E402 - the number of threads is set before NumPy is loaded
"""Objects per CPU second of the main job, beside a plain loop over objects with NumPy and trimesh, in one run.

Both make the same microwaves: the tables, a closed mesh per primitive, n labelled points on the visible surface.

* columns: one batch. `resolve` draws and computes the tables of all objects; `mesh` builds the meshes of all instances
  of a primitive in one call, placed in their objects; `points` samples the visible surface, exactly n per object;
  `labels` gives semantic classes and every label of the program.
* loop: one object after the other. `resolve` is a batch of that one object with its tables: the formulas of the
  program, once per object, and what NumPy costs on arrays of a few rows; a program that computes with plain floats
  is quicker there (`plain.py`), so the ratio is told without this stage too. `mesh` makes each primitive's mesh as one would
  by hand (`trimesh.creation.box` and `cylinder` where the primitive is one, else a `Trimesh` from the arrays of that
  instance), places it and joins all. `points` samples the joined surface with trimesh and drops what lies in another
  primitive, by boxes first and then the inside functions, until n are left. `labels` gives semantic, instance and
  link, and one affordance by a formula: less than the columns do.

Rounds of both take turns; the figures are medians. All in one thread.

    python benchmarks/main_job.py [--objects 256] [--rounds 5] [--points 2048]
"""

from __future__ import annotations

import os

for _variable in ("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS", "MKL_NUM_THREADS"):
    os.environ[_variable] = "1"

import argparse
import time

import numpy as np
import trimesh

from artipg_dsl import random
from artipg_dsl.annotate.points import label_points
from artipg_dsl.geometry import mesh, points
from artipg_dsl.geometry.resolution import Resolution
from artipg_dsl.geometry.sites import SiteTable
from artipg_dsl.graph.formula import compile_formula
from artipg_dsl.robot import solids
from artipg_dsl.session import Session

STAGES = ("resolve", "mesh", "points", "labels")
STEPS = 24  # of a round mesh per turn, here and there


def columns(sampler, numbers: np.ndarray, n_points: int) -> dict[str, float]:
    """CPU seconds per stage of the columnar runtime."""
    marks = [time.process_time()]
    batch = sampler.batch(numbers, seed=7)
    sites = batch.sites()
    marks.append(time.process_time())
    solids.build_meshes(sites, Resolution(STEPS))
    marks.append(time.process_time())
    made = points.sample(sites, len(batch), n_points, random.key(7, "points"), batch.numbers.astype(np.uint64))
    marks.append(time.process_time())
    labels = label_points(batch, sites, made)
    marks.append(time.process_time())
    assert labels.semantic.shape == (len(numbers), n_points)
    return dict(zip(STAGES, np.diff(marks).tolist(), strict=True))


class Loop:
    """The plain way: one object after the other, one primitive after the other."""

    def __init__(self, sampler, n_points: int):
        self.sampler, self.n_points = sampler, n_points
        self.inside = {
            name: compile_formula((p.inside,), (*p.parameters, "p.x", "p.y", "p.z"))
            for name, p in sampler.program.primitives.items()
        }

    def run(self, numbers: np.ndarray) -> dict[str, float]:
        """CPU seconds per stage."""
        spent = dict.fromkeys(STAGES, 0.0)
        generator = np.random.default_rng(0)
        for number in numbers:
            marks = [time.process_time()]
            sites = self.sampler.batch(np.array([number]), seed=7).sites()
            marks.append(time.process_time())
            placed = [self.primitive(table, row) for table in sites for row in range(len(table))]
            whole = trimesh.util.concatenate([m for m, *_ in placed])
            owner = np.repeat(np.arange(len(placed)), [len(m.faces) for m, *_ in placed])
            marks.append(time.process_time())
            _, normal, which = self.visible(whole, owner, placed, generator)
            marks.append(time.process_time())
            self.label(normal, which, placed)
            marks.append(time.process_time())
            for stage, seconds in zip(STAGES, np.diff(marks).tolist(), strict=True):
                spent[stage] += seconds
        return spent

    def primitive(self, table: SiteTable, row: int):
        """The placed mesh of one row, with its table, row and pose."""
        kind, params = table.primitive.name, {name: values[row] for name, values in table.params.items()}
        if kind == "Cuboid":
            shape = trimesh.creation.box([params["size.x"], params["size.y"], params["size.z"]])
        elif kind == "Cylinder" and params["radius"] == params["top_radius"]:
            shape = trimesh.creation.cylinder(params["radius"], params["height"], sections=STEPS)
        else:
            one = {name: values[row : row + 1] for name, values in table.params.items()}
            group = mesh.build(table.primitive, one, STEPS)[0]
            shape = trimesh.Trimesh(group.vertices[0], group.faces, process=False)
        pose = np.eye(4)
        pose[:3, :3], pose[:3, 3] = table.rotation[row] * [1.0, table.mirror[row], 1.0], table.translation[row]
        shape.apply_transform(pose)
        return shape, table, row, pose

    def visible(self, whole, owner, placed, generator):
        """Exactly n points that lie in no other primitive."""
        kept: list[np.ndarray] = []
        normals: list[np.ndarray] = []
        owners: list[np.ndarray] = []
        have = 0
        bounds = [m.bounds for m, *_ in placed]
        while have < self.n_points:
            count, seed = int(1.3 * self.n_points), int(generator.integers(1 << 30))
            position, face = trimesh.sample.sample_surface(whole, count, seed=seed)
            normal, which = whole.face_normals[face], owner[face]
            probe = position + 1e-5 * normal
            hidden = np.zeros(len(position), dtype=bool)
            for k, (_, table, row, pose) in enumerate(placed):
                near = np.flatnonzero(
                    (which != k) & ~hidden & (probe > bounds[k][0]).all(axis=1) & (probe < bounds[k][1]).all(axis=1)
                )
                if not len(near):
                    continue
                local = (probe[near] - pose[:3, 3]) @ pose[:3, :3]
                arguments = [table.params[name][row] for name in table.primitive.parameters]
                distance = self.inside[table.primitive.name](*arguments, *local.T)[0]
                hidden[near[np.broadcast_to(distance, near.shape) < 0]] = True
            kept.append(position[~hidden])
            normals.append(normal[~hidden])
            owners.append(which[~hidden])
            have += int((~hidden).sum())
        joined = [np.concatenate(x)[: self.n_points] for x in (kept, normals, owners)]
        return joined[0], joined[1], joined[2]

    def label(self, normal, which, placed):
        """Semantic, instance and link of each point, and one affordance by a formula."""
        semantic = np.array([t.semantic[r] for _, t, r, _ in placed])[which]
        instance = np.array([t.instance[r] for _, t, r, _ in placed])[which]
        link = np.array([t.link[r] for _, t, r, _ in placed])[which]
        grip = np.array([t.path.startswith("handle.grip") for _, t, _, _ in placed])[which]
        return semantic, instance, link, grip & (normal[:, 0] > -0.5)


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--objects", type=int, default=256)
    parser.add_argument("--rounds", type=int, default=5)
    parser.add_argument("--points", type=int, default=2048)
    options = parser.parse_args()
    sampler = Session.of("Microwave").sampler
    numbers = np.arange(options.objects)
    few = numbers[:: max(1, options.objects // 12)]
    loop = Loop(sampler, options.points)
    columns(sampler, numbers[:8], options.points)  # what is compiled once is compiled here
    loop.run(few[:2])
    ours, theirs = [], []
    for _ in range(options.rounds):
        ours.append(columns(sampler, numbers, options.points))
        theirs.append(loop.run(few))
    print(
        f"{options.objects} microwaves, {options.points} points each; medians of {options.rounds} rounds; "
        f"microseconds of CPU per object"
    )
    print(f"{'stage':24}{'columns':>12}{'loop':>12}{'ratio':>10}")
    a = {stage: float(np.median([o[stage] for o in ours])) / len(numbers) * 1e6 for stage in STAGES}
    b = {stage: float(np.median([t[stage] for t in theirs])) / len(few) * 1e6 for stage in STAGES}
    rows = [((stage,), stage) for stage in STAGES] + [(STAGES[1:], "all but resolve"), (STAGES, "all")]
    for stages, name in rows:
        one, other = sum(a[s] for s in stages), sum(b[s] for s in stages)
        print(f"{name:24}{one:12.0f}{other:12.0f}{other / one:10.1f}")
    print(f"objects per CPU second: columns {1e6 / sum(a.values()):.0f}, loop {1e6 / sum(b.values()):.1f}")


if __name__ == "__main__":
    main()
