"""Are objects valid in every configuration? Measured on exported files alone, by code that shares nothing with the project.

    python benchmarks/strict.py Kettle Window -n 60       # samples them first, with `apgc`
    python benchmarks/strict.py FOLDER ...                # a folder written with `apgc sample NAME --format urdf,mjcf -o FOLDER`

Each object is read from its URDF, the OBJ files of its visuals (each `o` is a closed solid) and, for rest values, its
annotation. It is looked at in these states: at rest; while each joint, with those that mimic it, runs through its range in
33 equal steps, the others at rest; and in 64 states of all joints together, the points of a Sobol sequence. In each, every pair
of links is asked for the solid that their solids share (manifold3d). How deep they meet is the least width of that
solid along the normals of its faces, at most six times its volume by its surface; more than 1e-6 m is a fault. Where loops close
(`connect` of the MJCF file) the other joints of the loop follow by Newton's method, and states that no joint
values reach are left out.
"""

from __future__ import annotations

import argparse
import json
import subprocess
import sys
import tempfile
import time
import xml.etree.ElementTree as ET
from collections import Counter
from dataclasses import dataclass, field
from pathlib import Path

import manifold3d
import numpy as np
from scipy.stats import qmc

STEPS, STATES, DEPTH = 33, 64, 1e-6


@dataclass
class Joint:
    name: str
    kind: str
    parent: int
    child: int
    origin: np.ndarray  # (4, 4)
    axis: np.ndarray
    low: float
    high: float
    rest: float
    mimic: tuple[str, float, float] | None


@dataclass
class Solid:
    name: str
    link: int
    body: manifold3d.Manifold
    low: np.ndarray
    high: np.ndarray


@dataclass
class Thing:
    """An object as its files tell it."""

    name: str
    links: list[str]
    joints: list[Joint]  # parents before children
    solids: list[Solid] = field(default_factory=list)
    loops: list[tuple[int, np.ndarray, int, np.ndarray]] = field(default_factory=list)


@dataclass(frozen=True)
class Hit:
    """Solids of two links that share more than they may, and where: in the object's frame."""

    pair: tuple[str, str]
    solids: tuple[str, str]
    when: str
    depth: float
    at: tuple[float, ...]


# ------------------------------------------------------------------ reading


def numbers(text: str | None, default: str) -> np.ndarray:
    return np.array([float(part) for part in (text or default).split()])


def placed(node: ET.Element | None) -> np.ndarray:
    """The matrix of an `origin`: roll, pitch and yaw about fixed axes, then the shift."""
    matrix = np.eye(4)
    if node is not None:
        (cr, cp, cy), (sr, sp, sy) = (f(numbers(node.get("rpy"), "0 0 0")) for f in (np.cos, np.sin))
        matrix[:3, :3] = [
            [cy * cp, cy * sp * sr - sy * cr, cy * sp * cr + sy * sr],
            [sy * cp, sy * sp * sr + cy * cr, sy * sp * cr - cy * sr],
            [-sp, cp * sr, cp * cr],
        ]
        matrix[:3, 3] = numbers(node.get("xyz"), "0 0 0")
    return matrix


def read(folder: Path, rest: dict[str, float]) -> Thing:
    root = ET.parse(folder / "object.urdf").getroot()
    links = [node.get("name", "") for node in root.findall("link")]
    joints = []
    for node in root.findall("joint"):
        kind, name, limit, mimic = node.get("type", ""), node.get("name", ""), node.find("limit"), node.find("mimic")
        low, high = (-np.pi, np.pi) if kind == "continuous" else (0.0, 0.0)
        if limit is not None and kind != "continuous":
            low, high = float(limit.get("lower", 0)), float(limit.get("upper", 0))
        axis = node.find("axis")
        joints.append(
            Joint(
                name,
                kind,
                links.index(node.find("parent").get("link")),
                links.index(node.find("child").get("link")),
                placed(node.find("origin")),
                numbers(None if axis is None else axis.get("xyz"), "1 0 0"),
                low,
                high,
                rest.get(name, min(max(0.0, low), high)),
                None
                if mimic is None
                else (mimic.get("joint"), float(mimic.get("multiplier", 1)), float(mimic.get("offset", 0))),
            )
        )
    reached, ordered = {k for k in range(len(links)) if all(j.child != k for j in joints)}, []
    while len(ordered) < len(joints):
        following = [j for j in joints if j.parent in reached and j.child not in reached]
        if not following:
            raise ValueError(f"{folder}: the links are no tree")
        ordered += following
        reached |= {j.child for j in following}
    thing = Thing(folder.name, links, ordered)
    for number, node in enumerate(root.findall("link")):
        for visual in node.findall("visual"):
            matrix = placed(visual.find("origin"))
            file = folder / visual.find("geometry/mesh").get("filename")
            thing.solids += [closed(name, number, v, f, matrix) for name, v, f in objects(file)]
    mjcf = folder / "object.xml"
    if mjcf.exists():
        sites = {
            site.get("name"): (body.get("name"), numbers(site.get("pos"), "0 0 0"))
            for body in ET.parse(mjcf).getroot().iter("body")
            for site in body.findall("site")
        }
        for node in ET.parse(mjcf).getroot().iter("connect"):
            (one, a), (two, b) = sites[node.get("site1")], sites[node.get("site2")]
            thing.loops.append((links.index(one), a, links.index(two), b))
    return thing


def objects(file: Path) -> list[tuple[str, np.ndarray, np.ndarray]]:
    """The solids of an OBJ file, each after a comment with its name: that, vertices (V, 3), triangles (F, 3)."""
    vertices: list[list[float]] = []
    groups: list[tuple[str, list[list[int]]]] = []
    for line in file.read_text().splitlines():
        word, *rest = line.split()
        if word == "#":
            groups.append((rest[0], []))
        elif word == "v":
            vertices.append([float(x) for x in rest])
        elif word == "f":
            groups[-1][1].append([int(x.split("/")[0]) - 1 for x in rest])
    points, found = np.array(vertices), []
    for name, faces in groups:
        used, index = np.unique(np.array(faces), return_inverse=True)
        found.append((name, points[used], index.reshape(-1, 3)))
    return found


def closed(name: str, link: int, vertices: np.ndarray, faces: np.ndarray, matrix: np.ndarray) -> Solid:
    vertices = vertices @ matrix[:3, :3].T + matrix[:3, 3]
    body = manifold3d.Manifold(manifold3d.Mesh64(vertices, faces.astype(np.uint64)))
    if body.status() != manifold3d.Error.NoError:
        raise ValueError(f"{name} is no closed solid: {body.status()}")
    return Solid(name, link, body, vertices.min(axis=0), vertices.max(axis=0))


# ------------------------------------------------------------------ states


def motion(thing: Thing, values: np.ndarray) -> np.ndarray:
    """(L, 4, 4): where each link is with the joints at ``values``."""
    found = np.tile(np.eye(4), (len(thing.links), 1, 1))
    for joint, value in zip(thing.joints, values, strict=True):
        local, axis = np.eye(4), joint.axis
        if joint.kind == "prismatic":
            local[:3, 3] = axis * value
        elif joint.kind in ("revolute", "continuous"):
            c, s, (x, y, z) = np.cos(value), np.sin(value), axis
            cross = np.array([[0, -z, y], [z, 0, -x], [-y, x, 0]])
            local[:3, :3] = c * np.eye(3) + s * cross + (1 - c) * np.outer(axis, axis)
        elif joint.kind != "fixed":
            raise ValueError(f"{joint.name}: a {joint.kind} joint has no one value")
        found[joint.child] = found[joint.parent] @ joint.origin @ local
    return found


def followed(thing: Thing, values: np.ndarray) -> np.ndarray:
    index = {joint.name: k for k, joint in enumerate(thing.joints)}
    values = values.copy()
    for _ in thing.joints:
        for k, joint in enumerate(thing.joints):
            if joint.mimic is not None:
                values[k] = joint.mimic[1] * values[index[joint.mimic[0]]] + joint.mimic[2]
    return values


def ajar(thing: Thing, values: np.ndarray) -> np.ndarray:
    pose = motion(thing, values)
    ends = [
        (pose[a][:3, :3] @ p + pose[a][:3, 3]) - (pose[b][:3, :3] @ q + pose[b][:3, 3]) for a, p, b, q in thing.loops
    ]
    return np.concatenate(ends)


def shut(thing: Thing, values: np.ndarray, held: set[int]) -> np.ndarray | None:
    """Values near ``values`` in which the loops close; None where none are found within the limits."""
    if not thing.loops:
        return values
    free = [k for k, j in enumerate(thing.joints) if k not in held and j.mimic is None and j.high > j.low]
    low, high = (np.array([getattr(thing.joints[k], end) for k in free]) for end in ("low", "high"))
    for _ in range(60):
        away = ajar(thing, values)
        if np.abs(away).max() < 1e-9:
            return values
        slope = np.empty((len(away), len(free)))
        for column, k in enumerate(free):
            near = values.copy()
            near[k] += 1e-7
            slope[:, column] = (ajar(thing, followed(thing, near)) - away) / 1e-7
        step = slope.T @ np.linalg.solve(slope @ slope.T + 1e-12 * np.eye(len(away)), away)
        values = values.copy()
        values[free] = np.clip(values[free] - step, low, high)
        values = followed(thing, values)
    return values if np.abs(ajar(thing, values)).max() < 1e-6 else None


def states(thing: Thing) -> list[tuple[str, np.ndarray]]:
    """What the object is looked at in: what it is called, and the values of the joints."""
    joints = thing.joints
    rest = followed(thing, np.array([joint.rest for joint in joints]))
    found: list[tuple[str, np.ndarray]] = [("at rest", rest)]
    leads = [k for k, joint in enumerate(joints) if joint.mimic is None and joint.high > joint.low]
    for k in leads:
        for way in (joints[k].low, joints[k].high):  # from rest to either end, so that loops can follow
            values = rest
            for value in np.linspace(joints[k].rest, way, (STEPS + 1) // 2)[1:]:
                wanted = values.copy()
                wanted[k] = value
                reached = shut(thing, followed(thing, wanted), {k})
                if reached is None:
                    break
                values = reached
                found.append((f"while {joints[k].name} moves, at {value:.4f}", values))
    if leads:
        low, high = (np.array([getattr(joints[k], end) for k in leads]) for end in ("low", "high"))
        for number, share in enumerate(qmc.Sobol(len(leads), scramble=False).random(STATES)):
            values = rest.copy()
            values[leads] = low + share * (high - low)
            together = shut(thing, followed(thing, values), set())
            if together is not None:
                found.append((f"in state {number} of all joints", together))
    return found


# ------------------------------------------------------------------ what meets


def shared(first: manifold3d.Manifold, second: manifold3d.Manifold) -> tuple[float, np.ndarray]:
    """How deep two solids meet, and the middle of the deepest place."""
    deepest, at = 0.0, np.zeros(3)
    both = first ^ second
    for part in () if both.is_empty() else both.decompose():
        mesh = part.to_mesh64()
        points, corners = mesh.vert_properties[:, :3], mesh.tri_verts.astype(np.int64)
        a, b, c = (points[corners[:, k]] for k in range(3))
        normal = np.cross(b - a, c - a)
        length = np.linalg.norm(normal, axis=1)
        normal = np.concatenate([normal[length > 0] / length[length > 0, None], np.eye(3)])
        width = np.ptp(points @ normal.T, axis=0).min()
        depth = min(float(width), 6 * part.volume() / max(part.surface_area(), 1e-300))
        if depth > deepest:
            deepest, at = depth, (points.min(axis=0) + points.max(axis=0)) / 2
    return deepest, at


def examine(thing: Thing) -> tuple[list[Hit], int]:
    """The deepest meeting of each pair of links in each kind of states, and how many states there were."""
    count, link = len(thing.links), np.array([solid.link for solid in thing.solids], dtype=int)
    middle = np.array([(solid.low + solid.high) / 2 for solid in thing.solids]).reshape(-1, 3)
    half = np.array([(solid.high - solid.low) / 2 for solid in thing.solids]).reshape(-1, 3)
    seen: dict[tuple[int, int], set[bytes]] = {}  # states of pairs of links, one to the other, that were looked at
    worst: dict[tuple[str, str, str], Hit] = {}
    looked = states(thing)
    for when, values in looked:
        pose = motion(thing, values)
        turn, shift = pose[link, :3, :3], pose[link, :3, 3]
        centre = np.einsum("nij,nj->ni", turn, middle) + shift
        reach = np.einsum("nij,nj->ni", np.abs(turn), half)
        near = np.ones((len(link), len(link)), dtype=bool)
        for axis in range(3):
            near &= np.abs(centre[:, None, axis] - centre[None, :, axis]) < reach[:, None, axis] + reach[None, :, axis]
        near &= link[:, None] < link[None, :]
        one, two = np.nonzero(near)
        fresh = {}
        for pair in set(zip(link[one].tolist(), link[two].tolist(), strict=True)):
            between = np.linalg.inv(pose[pair[0]]) @ pose[pair[1]]
            key = np.round(between, 9).tobytes()
            fresh[pair] = key not in seen.setdefault(pair, set())
            seen[pair].add(key)
        for i, j in zip(one.tolist(), two.tolist(), strict=True):
            a, b = thing.solids[i], thing.solids[j]
            if not fresh[a.link, b.link]:
                continue
            depth, at = shared(a.body.transform(pose[a.link][:3]), b.body.transform(pose[b.link][:3]))
            kind = when.split(",")[0] if not when.startswith("in state") else "all joints"
            key = (thing.links[a.link], thing.links[b.link], kind)
            if depth > DEPTH and (key not in worst or worst[key].depth < depth):
                worst[key] = Hit(key[:2], (a.name, b.name), when, depth, tuple(np.round(at, 4).tolist()))
    assert count
    return list(worst.values()), len(looked)


# ------------------------------------------------------------------ the run


def measure(folder: Path, only: int | None = None, tell: bool = True) -> dict[str, int]:
    """Look at the objects of a folder of samples: how many there are, and how many meet none of their own links in which states."""
    rest = {}
    for file in sorted(folder.glob("annotation-*.jsonl")):
        for line in file.read_text().splitlines():
            known = json.loads(line)
            rest[known["object"]] = {joint["name"]: joint["rest"] for joint in known["joints"]}
    names, found = Counter(), Counter(objects=0, rest=0, sweep=0, all=0, joints=0, states=0)
    for path in sorted((folder / "objects").iterdir())[:only]:
        thing = read(path, rest.get(int(path.name), {}))
        hits, looked = examine(thing)
        found.update(objects=1, joints=len(thing.joints), states=looked)
        found["rest"] += not any(hit.when == "at rest" for hit in hits)
        found["sweep"] += not any(not hit.when.startswith("in state") for hit in hits)
        found["all"] += not hits
        for hit in hits:
            names[tuple(sorted(hit.pair))] += 1
            if tell:
                print(
                    f"  {path.name}  {hit.pair[0]} ({hit.solids[0]}) and {hit.pair[1]} ({hit.solids[1]}) {hit.when}: "
                    f"{1e3 * hit.depth:.4f} mm at {hit.at}",
                    flush=True,
                )
    return dict(found)


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("what", nargs="+", help="categories, or folders of samples")
    parser.add_argument("-n", type=int, default=60, help="objects of each")
    parser.add_argument("--seed", type=int, default=0)
    options = parser.parse_intermixed_args()
    print("category             objects  joints   rest %  sweeps %  all joints %  seconds")
    for name in options.what:
        start = time.time()
        with tempfile.TemporaryDirectory() as made:
            folder = Path(name)
            if not folder.is_dir():
                folder, command = Path(made), [str(Path(sys.executable).with_name("apgc")), "sample", name]
                command += ["-n", str(options.n), "--seed", str(options.seed), "--format", "urdf,mjcf", "-o", made]
                subprocess.run(command, check=True, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
            found = measure(folder, options.n)
        share = [100 * found[key] / max(found["objects"], 1) for key in ("rest", "sweep", "all")]
        print(
            f"{Path(name).name:20} {found['objects']:7} {found['joints']:7} {share[0]:8.1f} {share[1]:9.1f} {share[2]:13.1f}"
            f" {time.time() - start:8.1f}",
            flush=True,
        )


if __name__ == "__main__":
    main()
