"""Figures of quality: uniform points, closed meshes, labels that follow motions, bindings that come back."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import trimesh
from scipy.spatial import cKDTree
from scipy.stats import chi2

from artipg_dsl import random
from artipg_dsl.annotate.cloud import sample_points
from artipg_dsl.annotate.points import label_points
from artipg_dsl.annotate.rebind import rebind
from artipg_dsl.annotate.sampling import Sampling
from artipg_dsl.geometry import points
from artipg_dsl.geometry.block import block_of
from artipg_dsl.geometry.cells import Cells
from artipg_dsl.geometry.density import element_split
from artipg_dsl.geometry.patches import grid
from artipg_dsl.graph import expr as E
from artipg_dsl.graph.program import Pose, Program
from artipg_dsl.lower.values.vectors import compose, direct, place, rotation_about
from artipg_dsl.robot import solids
from artipg_dsl.run.job import prepare
from artipg_dsl.run.request import Request
from artipg_dsl.sampling.mutation import Mutation
from artipg_dsl.sampling.sample import Sampler

OBJECTS, POINTS = 48, 8192
ALONE = 6  # objects whose primitives are drawn on one by one
BINS = 6  # of a patch along either fraction


def table(name: str, session) -> None:
    """Print one program's figures."""
    sampler, program = session.sampler, session.lowering.program
    batch = sampler.batch(np.arange(OBJECTS), seed=7)
    print(f"\n{name}")
    figures = (uniform, shares, even, apart, closed)
    for title, text in (*(figure(batch) for figure in figures), equivariant(program), bound(sampler)):
        print(f"  {title:48}{text}")


def alone(batch) -> list[tuple[Cells, np.ndarray, points.PointSet]]:
    """Each primitive of the first objects as an object of its own, nothing of it hidden: cells, the cell of each point
    (m,), and the points."""
    found = []
    for table in batch.sites():
        rows = np.flatnonzero(table.owner < ALONE)
        if not len(rows):
            continue
        columns = {
            n: getattr(table, n)[rows] for n in ("rotation", "translation", "mirror", "link", "instance", "semantic")
        }
        params = {name: values[rows] for name, values in table.params.items()}
        every = np.arange(len(rows))
        one = replace(table, number=0, params=params, owner=every, rank=0 * every, **columns)
        key = random.key(7, "points", table.path)
        made = points.sample([one], len(rows), POINTS, key, every.astype(np.uint64))
        cells = Cells(block_of([one], 0, len(rows)))
        cells.measure_bent()
        found.append((cells, (cells.first[:, None] + made.patch).ravel(), made))
    return found


def uniform(batch) -> tuple[str, str]:
    """Within patches: chi-square over bins of (u, v), each expected its share of the area."""
    total, freedom, patches = 0.0, 0, 0
    middle = (np.arange(8 * BINS) + 0.5) / (8 * BINS)
    mesh = np.meshgrid(middle, middle, indexing="ij")
    for cells, cell, made in alone(batch):
        (shelf,) = cells.rows.shelves
        count = np.bincount(cell, minlength=len(cells.row))
        u, v = made.u.ravel(), made.v.ravel()
        for patch in range(int(cells.patch.max()) + 1):
            mine = cells.first + patch
            chosen = np.flatnonzero(count[mine] >= 10 * BINS * BINS)
            if not len(chosen):
                continue
            params = {n: a[chosen] for n, a in shelf.params.items()}
            element = grid(element_split(shelf.primitive, patch), params, *mesh)[..., 0]
            share = element.reshape(len(chosen), BINS, 8, BINS, 8).sum(axis=(2, 4))
            share /= share.sum(axis=(1, 2), keepdims=True)
            slot = np.full(len(cells.row), -1)
            slot[mine[chosen]] = np.arange(len(chosen))
            here = np.flatnonzero(slot[cell] >= 0)
            box = (slot[cell[here]] * BINS + (u[here] * BINS).astype(int)) * BINS + (v[here] * BINS).astype(int)
            seen = np.bincount(box, minlength=share.size).reshape(share.shape)
            expected = share * count[mine[chosen]][:, None, None]
            large = expected >= 5  # where a patch comes to a point, bins next to it have none
            total += float(((seen - expected) ** 2 / np.maximum(expected, 1e-9))[large].sum())
            freedom += int(large.sum()) - len(chosen)
            patches += len(chosen)
    text = f"{total / freedom:.4f} over {patches} patches, p = {chi2.sf(total, freedom):.2f}"
    return "chi-square per degree of freedom, in patches", text


def shares(batch) -> tuple[str, str]:
    """Over patches: chi-square of their counts by area. Candidates are allocated evenly: far below 1."""
    total, patches = 0.0, 0
    for cells, cell, _ in alone(batch):
        count = np.bincount(cell, minlength=len(cells.row))
        surface = np.bincount(cells.owner, cells.area, len(cells.start) - 1)
        expected = POINTS * cells.area / surface[cells.owner]
        kept = expected >= 5
        total += float(((count - expected) ** 2 / np.maximum(expected, 1e-9))[kept].sum())
        patches += int(kept.sum())
    return "chi-square per patch, over patches", f"{total / patches:.4f} over {patches} patches"


def even(batch) -> tuple[str, str]:
    """L2 star discrepancy of the points on the largest flat patches (Warnock's formula), over that expected of white noise."""
    ratio = []
    for cells, cell, made in alone(batch):
        flat = np.flatnonzero((cells.shape == 0) & (cells.area > 0))
        for k in flat[np.argsort(-cells.area[flat], kind="stable")][:4]:
            at = np.flatnonzero(cell == k)[:2000]
            if len(at) < 500:
                continue
            x = np.stack([made.u.ravel()[at], made.v.ravel()[at]], axis=-1)
            n = len(x)
            pairs = (1 - np.maximum(x[:, None], x[None])).prod(axis=-1).sum() / n**2
            square = 1 / 9 - 2 / n * ((1 - x**2) / 2).prod(axis=-1).sum() + pairs
            ratio.append(square / ((1 / 4 - 1 / 9) / n))
    text = f"{np.sqrt(np.mean(ratio)):.2f} over {len(ratio)} patches" if ratio else "no flat patch is large enough"
    return "L2 star discrepancy, over white noise", text


def apart(batch) -> tuple[str, str]:
    """Least distance between neighbours, and how evenly space is filled: of blue points over that of white ones."""
    ratio, spread = [], []
    few = 4
    made = [sample_points(batch, Sampling(2048, spread=kind)) for kind in ("random", "blue")]
    for k in range(few):
        least, filled = [], []
        for cloud in made:
            position, normal = cloud.position[k], cloud.normal[k]
            near, which = cKDTree(position).query(position, k=16)
            facing = (normal[which] * normal[:, None]).sum(axis=-1) > -0.5
            least.append(np.where(facing & (near > 0), near, np.inf).min())
            corners = sample_points(batch, 20_000).position[k]
            filled.append(cKDTree(position).query(corners)[0].max())
        ratio.append(least[1] / least[0])
        spread.append(filled[1] / filled[0])
    return "blue over white: least gap, largest hole", f"{np.median(ratio):.0f} times, {np.median(spread):.2f} times"


def closed(batch) -> tuple[str, str]:
    """Meshes that are watertight and wound outwards."""
    good, number = 0, 0
    for group in solids.build_meshes(batch.sites()):
        for vertices in group.vertices[:OBJECTS]:
            mesh = trimesh.Trimesh(vertices, group.faces, process=False)
            good += mesh.is_watertight and mesh.is_winding_consistent and mesh.volume > 0
            number += 1
    return "meshes watertight and wound outwards", f"{good} of {number}"


def rigid(angle: float, shift: tuple[float, float, float]) -> Pose:
    turn = rotation_about(tuple(E.const(a) for a in (0.36, 0.48, 0.8)), E.const(angle))
    return Pose(turn, tuple(E.const(s) for s in shift), E.ONE)


def moved(program: Program, motion: Pose) -> Program:
    """The same program with every pose of the object carried by a rigid motion."""
    made = replace(program)
    made.sites = [replace(s, pose=compose(motion, s.pose)) for s in program.sites]
    made.parts = [replace(p, pose=compose(motion, p.pose)) for p in program.parts]
    made.joints = [replace(j, origin=place(motion, j.origin), axis=direct(motion, j.axis)) for j in program.joints]
    made.labels = [
        replace(label, targets=tuple(replace(t, frame=compose(motion, t.frame)) for t in label.targets))
        for label in program.labels
    ]
    return made


def equivariant(program: Program) -> tuple[str, str]:
    """Labels of points that are the same after a rigid motion of the whole object."""
    same, number = 0, 0
    for angle, shift in ((0.7, (0.3, -0.2, 1.5)), (2.9, (-4.0, 2.0, 0.1)), (1.6, (50.0, 0.0, -20.0))):
        here, there = (Sampler(p).batch(np.arange(OBJECTS), 7) for p in (program, moved(program, rigid(angle, shift))))
        made = points.sample(here.sites(), OBJECTS, 1024, random.key(5, "points"), here.numbers.astype(np.uint64))
        position, normal = points.evaluate(there.sites(), made)
        other = replace(made, position=position, normal=normal)
        first, second = (label_points(b, b.sites(), s) for b, s in ((here, made), (there, other)))
        for a, b in [(first.semantic, second.semantic), *((a, second.fields[n]) for n, a in first.fields.items())]:
            same += int((a == b).sum())
            number += a.size
    return "labels unchanged by three rigid motions", f"{same} of {number}"


def bound(sampler) -> tuple[str, str]:
    """Points taken to a mutant and back, in double precision and with u and v in single precision."""
    job = prepare(sampler, Request(sampler.program.name, 7, checked=False))
    here, there = (j.batch(np.arange(OBJECTS)) for j in (job, job.mutated(Mutation(("cpa",)))))
    made = sample_points(here, 1024)
    away = rebind(there, made)
    assert away.bound is not None
    back = rebind(here, away)
    coarse = rebind(here, replace(made, u=made.u.astype(np.float32), v=made.v.astype(np.float32)))
    errors = [float(np.nanmax(np.abs(x.position - made.position))) for x in (back, coarse)]
    text = f"{errors[0]:.1e} m, in single precision {errors[1]:.1e} m ({100 * away.bound.mean():.1f}% still bound)"
    return "binding to a mutant and back, largest error", text
