"""How well real surfaces are bound and worn: figures of each assignment, and a sheet of originals, structures, bound and mutated clouds.

python benchmarks/details.py figures FITTED...                  # folders that `apgc fit` has written: all assignments, fresh points
python benchmarks/details.py sheet FITTED BOUND -o sheet.png    # a row per object: original, structure, bound, mutants
python benchmarks/details.py borrowed NAME BOUND -o sheet.png   # fresh objects bare, and below in details that they borrow
python benchmarks/details.py labels FITTED BOUND [FITTED BOUND ...]  # carried labels against our links, for files that have links
python benchmarks/details.py held FITTED BOUND [FITTED BOUND ...]  # what symmetries foretell of details that are held out
python benchmarks/details.py speed FITTED BOUND -n 500          # objects per second of the transfer alone
python benchmarks/details.py meshes FITTED BOUND [FITTED BOUND ...]  # displaced meshes: distances, folds, crossings, closedness, time
python benchmarks/details.py surfaces FITTED BOUND [FITTED BOUND ...] -o sheet.png  # original, structure, displaced mesh, its mutants
"""

from __future__ import annotations

import argparse
import json
import time
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np
from scipy.optimize import linear_sum_assignment

from artipg_dsl import random
from artipg_dsl.annotate.sampling import Sampling
from artipg_dsl.details import displace
from artipg_dsl.details.assign import ASSIGNMENTS
from artipg_dsl.details.binding import Real, bind
from artipg_dsl.details.completion import lend
from artipg_dsl.details.elements import Solids
from artipg_dsl.details.measure import distances
from artipg_dsl.details.record import DIRECT, Details, of_arrays, to_arrays
from artipg_dsl.details.report import report
from artipg_dsl.details.store import borrow, dress, read_dressing
from artipg_dsl.details.unfold import find_folded, find_sheets, keep_apart, normals, unfold
from artipg_dsl.export.shards import point_arrays
from artipg_dsl.fit.outer import outer
from artipg_dsl.fit.real import read_real
from artipg_dsl.fit.sources import File
from artipg_dsl.geometry import points as geometry
from artipg_dsl.geometry.resolution import STANDARD
from artipg_dsl.robot.robots import Robots
from artipg_dsl.robot.solids import build_meshes
from artipg_dsl.run.job import Job, open_job
from artipg_dsl.run.request import read_request
from artipg_dsl.run.resume import reopen
from artipg_dsl.sampling.mutation import Mutation, read_operations
from artipg_dsl.view.camera import look_at
from artipg_dsl.view.png import png_bytes
from artipg_dsl.view.scene import make_scene
from artipg_dsl.view.sheet import Painter, Shot, by_pixels

TILE = 260


def objects(folder: Path) -> Iterator[tuple[Job, int, Real, dict[str, Any]]]:
    """The objects of a fitted folder with their real surfaces."""
    job = reopen(folder)
    for one in json.loads((folder / "fit.json").read_text())["objects"]:
        if one["object"] is not None:
            record = json.loads((folder / "fits" / f"{one['name']}.json").read_text())
            yield job, one["object"], read_real(File(folder / one["source"]), record), record


def figures(folders: list[str]) -> None:
    for folder in map(Path, folders):
        for job, number, real, _ in objects(folder):
            batch = job.batch([number])
            for name in ASSIGNMENTS:
                begun = time.process_time()
                details = bind(batch, real, assignment=name)
                spent = time.process_time() - begun
                told = report(batch, real, to_arrays(details, job.program.hash), 8192)["figures"]
                row = [told[k][w] for w in ("to_real", "to_worn") for k in ("before", "after", "floor") if told[k]]
                row += [told["after"]["covered_real"], told["after"]["covered_worn"], told["torn"], told["inverted"]]
                row += [told["worn"]]
                print(f"{folder.name},{number},{name},{spent:.2f}," + ",".join(f"{x:.4f}" for x in row), flush=True)


def mutants(job: Job, operations: str, each: int) -> Job:
    step = Mutation(read_operations(operations), 0, 1.0, 0.5, "*", False, each, job.request.numbers)
    return job.mutated(step, np.arange(len(job.request.objects) * each))


def picture(points: np.ndarray, normals: np.ndarray, bounds: tuple[np.ndarray, float]) -> np.ndarray:
    """(TILE, TILE, 3) a cloud from the front, above and left; shaded by its normals."""
    middle, reach = bounds
    a, e = np.radians(-35.0), np.radians(20.0)
    way = np.array([np.cos(e) * np.cos(a), np.cos(e) * np.sin(a), np.sin(e)])
    right = np.array([-np.sin(a), np.cos(a), 0.0])
    up = np.cross(way, right)
    local = (points - middle) / reach
    x, y, depth = local @ right, local @ up, local @ way
    light = way + 0.5 * up - 0.4 * right
    shade = 0.25 + 0.7 * np.abs(normals @ (light / np.linalg.norm(light)))
    image = np.full((TILE, TILE, 3), 246, dtype=np.uint8)
    order = np.argsort(depth, kind="stable")
    px = ((0.5 + 0.92 * x) * TILE).astype(int)[order]
    py = ((0.5 - 0.92 * y) * TILE).astype(int)[order]
    colour = (shade[order, None] * np.array([120, 150, 190])).clip(0, 255).astype(np.uint8)
    wide = 5  # what lies behind nearer points is hidden
    cell = (py // wide) * (TILE // wide + 1) + px // wide
    front = np.full((TILE // wide + 2) ** 2, -np.inf)
    inside = (px >= 0) & (px < TILE - 1) & (py >= 0) & (py < TILE - 1)
    np.maximum.at(front, cell[inside], depth[order][inside])
    kept = inside & (depth[order] > front[np.where(inside, cell, 0)] - 0.06)
    for dx in (0, 1):
        for dy in (0, 1):
            image[py[kept] + dy, px[kept] + dx] = colour[kept]
    return image


def sheet(folder: Path, bound: Path, out: Path, operations: str, each: int, points: int) -> None:
    dressing = read_dressing(bound)
    rows = []
    for job, number, real, _ in objects(folder):
        own = job.of([number])
        batches = [own.batch(), mutants(own, operations, each).batch()]
        size = np.ptp(real.points, axis=0).max()
        bounds = (real.points.max(axis=0) + real.points.min(axis=0)) / 2, float(size) * 1.15
        row = [picture(real.points, real.normals, bounds)]
        for k, batch in enumerate(batches):
            address = batch.numbers.astype(np.uint64)
            made = geometry.sample(batch.sites(), len(batch), points, random.key(1, "sheet"), address, outside=True)
            worn = dress(batch, made, np.arange(len(batch)), dressing)
            if k == 0:
                row.append(picture(made.position[0], made.normal[0], bounds))
            for place, normal in zip(worn.position, worn.normal, strict=True):
                low, high = place.min(axis=0), place.max(axis=0)
                row.append(picture(place, normal, ((low + high) / 2, float((high - low).max()) * 1.15)))
        rows.append(np.concatenate(row, axis=1))
    out.write_bytes(png_bytes(np.concatenate(rows, axis=0)))


def borrowed(name: str, bound: Path, out: Path, count: int, points: int) -> None:
    job = open_job(read_request(name, n=count))
    dressing, batch = borrow(bound, 1.0, job.program), job.batch()
    address = batch.numbers.astype(np.uint64)
    made = geometry.sample(batch.sites(), len(batch), points, random.key(1, "sheet"), address, outside=True)
    worn = dress(batch, made, np.arange(len(batch)), dressing)
    rows = []
    for cloud in (made, worn):
        row = []
        for place, normal in zip(cloud.position, cloud.normal, strict=True):
            low, high = place.min(axis=0), place.max(axis=0)
            row.append(picture(place, normal, ((low + high) / 2, float((high - low).max()) * 1.15)))
        rows.append(np.concatenate(row, axis=1))
    out.write_bytes(png_bytes(np.concatenate(rows, axis=0)))


def label_agreement(pairs: list[tuple[Path, Path]], points: int) -> None:
    """Of the points that carry a label of the file, the share on the link of ours that the label stands for (one link for each label, so that
    most points agree), and the share that the largest link would have by itself."""
    for fitted, bound in pairs:
        job, dressing = reopen(fitted), read_dressing(bound)
        for one in json.loads((bound / "bind.json").read_text())["objects"]:
            arrays = point_arrays(job.batch([one["object"]]), Sampling(points, "outside"), details=dressing)
            label, link = arrays["real_label"][0].astype(int), arrays["link"][0].astype(int)
            known = label >= 0
            table = np.zeros((label.max() + 2, link.max() + 1), dtype=int)
            np.add.at(table, (label[known], link[known]), 1)
            table = table[table.any(axis=1)]
            if len(table) < 2:
                continue
            rows, columns = linear_sum_assignment(-table)
            agreed, largest = table[rows, columns].sum() / known.sum(), table.sum(axis=0).max() / known.sum()
            print(
                f"{one['name']:45} {len(table)} links in the file, {table.any(axis=0).sum()} of ours: {agreed:.1%} agree "
                f"(largest link alone {largest:.1%}), {known.mean():.0%} of points carry a label"
            )


def held_out(pairs: list[tuple[Path, Path]]) -> None:
    """Bound points of a region are left out and lent again by the symmetries of their primitive: the error, as a share of that of the
    bare structure (those that no symmetry tells of stay bare), over all and over those alone that were lent."""
    chance, rows = np.random.default_rng(0), {}
    for fitted, bound in pairs:
        job = reopen(fitted)
        for one in json.loads((bound / "bind.json").read_text())["objects"]:
            solids = Solids.of(job.batch([one["object"]]).sites())
            with np.load(bound / one["details"]) as held:
                details = of_arrays(dict(held), one["name"])
            details = details.take(np.flatnonzero(details.how == DIRECT))
            for what, element, out in _regions(details, solids, chance):
                left = details.take(np.setdiff1d(np.flatnonzero(details.element == element), out))
                true = details.take(out)
                at, lent = lend(left, solids, (true.element, true.patch, true.u, true.v))
                made = np.zeros_like(true.offset)
                made[at] = lent["offset"]
                error, bare = (np.sqrt((way * way).sum(axis=1)) for way in (true.offset - made, true.offset))
                told = np.array([len(out), len(at), bare.sum(), error.sum(), bare[at].sum(), error[at].sum()])
                name = solids.primitives[details.elements.site[element]].name
                for key in ((name, what), ("all", what), (fitted.name, "all")):
                    rows.setdefault(key, []).append(told * ([1, 1] + [100 / details.diagonal[0]] * 4))
    for (name, what), every in sorted(rows.items()):
        count, lent, bare, error, bare_lent, error_lent = np.sum(every, axis=0)
        print(
            f"{name:20} {what:6} {len(every):4} regions, {bare / count:5.2f} % of the diagonal, {lent / count:4.0%} lent, "
            f"error {error / bare:4.2f}, of those lent {error_lent / max(bare_lent, 1e-9):4.2f}"
        )


def _regions(details: Details, solids: Solids, chance: np.random.Generator) -> Iterator[tuple[str, int, np.ndarray]]:
    """Of each of the larger elements a round region, an end and each patch."""
    frames = solids.frames(details.elements, details.element, details.patch, details.u, details.v)
    low, high = solids.boxes(details.elements)
    many = np.bincount(details.element, minlength=len(details.elements))
    for element in np.argsort(-many, kind="stable")[:8].tolist():
        own = np.flatnonzero(details.element == element)
        if len(own) < 150:
            return
        place = frames.place[own]
        apart = ((place - place[chance.integers(len(own))]) ** 2).sum(axis=1)
        yield "round", element, own[np.argsort(apart, kind="stable")[: len(own) // 4]]
        along = place[:, int(np.argmax((high - low)[element]))]
        yield "end", element, own[along > np.quantile(along, 0.7)]
        for patch in np.unique(details.patch[own]).tolist():
            mine = own[details.patch[own] == patch]
            if 30 <= len(mine) <= 0.6 * len(own):
                yield "patch", element, mine


class Measured:
    """What the steps of ``displace`` leave, caught as they are taken."""

    def __init__(self) -> None:
        self.folded, self.crossed, self.faces, self.places, self.turned, self.still = 0, 0, 0, 0, 0, 0.0

    def unfold(self, place: np.ndarray, way: np.ndarray, faces: np.ndarray, mesh: np.ndarray) -> np.ndarray:
        self.folded = int(find_folded(normals(place, faces), place + way, faces).sum())
        self.faces, kept = len(faces), unfold(place, way, faces, mesh)
        each, outward = normals(place, faces), np.zeros_like(place)
        for k in range(3):
            np.add.at(outward, faces[:, k], each)
        outward /= np.maximum(np.sqrt((outward**2).sum(axis=1)), 1e-12)[:, None]
        here, there, thick = find_sheets(place, outward, mesh, self.scale[mesh])
        self.still = int((thick + ((kept[here] - kept[there]) * outward[here]).sum(axis=1) < 0.0).sum()) / len(place)
        self.turned = int(find_folded(each, place + kept, faces).sum())
        return kept

    def keep_apart(self, place: np.ndarray, normal: np.ndarray, way: np.ndarray, *more: np.ndarray) -> np.ndarray:
        here, there, thick = find_sheets(place, normal, *more[1:])
        self.crossed = int((thick + ((way[here] - way[there]) * normal[here]).sum(axis=1) < 0.0).sum())
        self.places, mesh, scale = len(place), more[1], more[2]
        self.scale = np.ones(int(mesh.max()) + 1)
        self.scale[mesh] = scale
        return keep_apart(place, normal, way, *more)


def triangles(robots: Robots) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Vertices (V, 3), faces (F, 3) of all meshes of a batch, and which mesh each face is of."""
    places, faces, mesh, first = [], [], [], 0
    for group in robots.meshes:
        for vertices in group.vertices:
            places.append(vertices)
            faces.append(group.faces.astype(np.int64) + first)
            mesh.append(np.full(len(group.faces), len(mesh)))
            first += len(vertices)
    return np.concatenate(places), np.concatenate(faces), np.concatenate(mesh)


def outside(robots: Robots, count: int = 8192) -> np.ndarray:
    """Points all over what can be seen of the meshes of one object, by the measure that real objects are read by."""
    places, faces, _ = triangles(robots)
    chance, area = np.random.default_rng(0), np.sqrt((normals(places, faces) ** 2).sum(axis=1))
    chosen = faces[chance.choice(len(faces), 60_000, p=area / area.sum())]
    u, v = chance.random((2, len(chosen)))
    u, v = np.where(u + v > 1.0, 1.0 - u, u), np.where(u + v > 1.0, 1.0 - v, v)
    a, b, c = (places[chosen[:, k]] for k in range(3))
    points = a + u[:, None] * (b - a) + v[:, None] * (c - a)
    return points[outer(points[None])[0]][:count]


def meshes(pairs: list[tuple[Path, Path]], operations: str) -> None:
    for fitted, bound in pairs:
        dressing, caught = read_dressing(bound), Measured()
        displace.unfold, displace.keep_apart = caught.unfold, caught.keep_apart
        for job, number, real, _ in objects(fitted):
            batch = job.batch([number])
            found = [outside(Robots(batch, physics=False, details=worn)) for worn in (None, dressing)]
            told = [distances(real.points, points, real.diagonal) for points in found]
            row = [round(one[key], 2) for key in ("to_real", "to_worn") for one in told]
            print(f"{real.name:42} {row}", *(f"{told[1][key]:.0%}" for key in ("covered_real", "covered_worn")))
        own = reopen(fitted)
        for name, batch in (("fitted", own.batch()), ("mutants", mutants(own, operations, 8).batch())):
            begun = time.process_time()
            robots = Robots(batch, physics=False, details=dressing)
            spent = 1000.0 * (time.process_time() - begun) / len(batch)
            places, faces, mesh = triangles(robots)
            still = build_meshes(robots.tables)
            start, end = faces.ravel(), np.roll(faces, -1, axis=1).ravel()
            edges = np.sort(start * len(places) + end), np.sort(end * len(places) + start)
            closed = np.array_equal(*edges) and not (np.diff(edges[0]) == 0).any()
            a, b, c = (places[faces[:, k]] for k in range(3))
            volume = np.bincount(mesh, (a * np.cross(b, c)).sum(axis=1))
            few = sum(group.faces.shape[0] * len(group.rows) for group in still) // len(batch)
            print(
                f"{fitted.name} {name}: {len(batch)} objects, {len(faces) // len(batch)} triangles ({few} of the structure), "
                f"{spent:.0f} ms an object; closed {closed}; {(volume <= 0).sum()} of {len(volume)} of volume below 0; "
                f"folded {caught.folded / caught.faces:.1%}, crossed {caught.crossed / caught.places:.1%} before both were undone, "
                f"{caught.turned} folded and {caught.still:.2%} crossed after"
            )


def surfaces(pairs: list[tuple[Path, Path]], out: Path, operations: list[str], each: int) -> None:
    global TILE
    TILE, rows, painter = 300, [], Painter("auto", 300)

    def drawn(batch: Any, dressing: Any) -> list[np.ndarray]:
        fine = by_pixels(batch, TILE) if dressing is None else STANDARD
        robots, found = Robots(batch, resolution=fine, physics=False, details=dressing), []
        for i in range(len(batch)):
            shown = make_scene(robots, i, batch.pose(), "part")
            camera = look_at(shown.vertices, -35.0, 20.0)
            found.append(painter.paint(Shot(shown, camera, float(shown.vertices[:, 2].min()))))
        return found

    for fitted, bound in pairs:
        dressing = read_dressing(bound)
        for job, number, real, _ in objects(fitted):
            own = job.of([number])
            size = float(np.ptp(real.points, axis=0).max()) * 1.15
            middle = (real.points.max(axis=0) + real.points.min(axis=0)) / 2
            row = [picture(real.points[:16_000], real.normals[:16_000], (middle, size)), *drawn(own.batch(), None)]
            row += drawn(own.batch(), dressing)
            for which in operations:
                row += drawn(mutants(own, which, each).batch(), dressing)
            rows.append(np.concatenate(row, axis=1))
    out.write_bytes(png_bytes(np.concatenate(rows, axis=0)))


def speed(folder: Path, bound: Path, count: int, points: int) -> None:
    dressing = read_dressing(bound)
    job = reopen(folder)
    batch = mutants(job, "cpa", -(-count // len(job.request.objects))).batch()
    address = batch.numbers.astype(np.uint64)
    made = geometry.sample(batch.sites(), len(batch), points, random.key(1, "speed"), address)
    dress(batch, made, np.arange(len(batch)), dressing)
    begun = time.process_time()
    dress(batch, made, np.arange(len(batch)), dressing)
    spent = time.process_time() - begun
    print(f"{folder.name}: {len(batch)} objects of {points} points in {spent:.2f} s: {len(batch) / spent:.0f} a second")


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument(
        "what", choices=("figures", "sheet", "borrowed", "held", "labels", "speed", "meshes", "surfaces")
    )
    parser.add_argument("folders", nargs="+")
    parser.add_argument("-o", "--out", default="sheet.png")
    parser.add_argument("-n", type=int, default=4)
    parser.add_argument("--points", type=int, default=12_000)
    parser.add_argument("--ops", nargs="+", default=["cpa"], help="mutants of what; surfaces: -n of each")
    asked = parser.parse_args()
    if len(asked.ops) > 1 and asked.what != "surfaces":
        parser.error("only surfaces shows mutants of several lists of operations")
    if asked.what == "figures":
        figures(asked.folders)
        return
    if asked.what in ("held", "labels", "meshes", "surfaces"):
        pairs = [(Path(a), Path(b)) for a, b in zip(asked.folders[::2], asked.folders[1::2], strict=True)]
        if asked.what == "meshes":
            meshes(pairs, asked.ops[0])
            return
        if asked.what == "surfaces":
            surfaces(pairs, Path(asked.out), asked.ops, asked.n)
            return
        held_out(pairs) if asked.what == "held" else label_agreement(pairs, asked.points)
        return
    if asked.what == "borrowed":
        borrowed(asked.folders[0], Path(asked.folders[1]), Path(asked.out), asked.n, asked.points)
        return
    fitted, bound = map(Path, asked.folders)
    if asked.what == "sheet":
        sheet(fitted, bound, Path(asked.out), asked.ops[0], asked.n, asked.points)
    else:
        speed(fitted, bound, asked.n, asked.points)


if __name__ == "__main__":
    main()
