"""Files of real objects: meshes, point clouds and robots (URDF), each as one cloud of its surface in the file's own frame and unit.

What a file holds once it is read, arrays of points or triangles, becomes a cloud as it does from memory (``given``).
"""

from __future__ import annotations

import json
import logging
import warnings
from collections.abc import Iterator, Mapping, Sequence
from contextlib import contextmanager
from dataclasses import replace
from pathlib import Path
from typing import Any
from urllib.parse import unquote
from xml.etree import ElementTree
from zipfile import is_zipfile

import numpy as np

from ..errors import UserError
from ..records import dataclass
from .bodies import Bodies
from .finding import CLOUDS, KINDS, ROBOT
from .meshes import load_meshes
from .urdf import mesh_of, read_robot
from .xyz import read_table

_POINTS = 30_000  # taken of a surface
_LEAST = 200  # points that a cloud has at least
_MOST_BYTES = 2 << 30
_SEED = 1


@dataclass(frozen=True, slots=True, eq=False)
class Cloud:
    """``points`` (n, 3) of a surface, in random order; ``normals`` (n, 3) as the file has them, None where it has none; ``label`` (n,)
    indexes ``names``, those of groups, links or classes that the file tells apart, -1 for none. ``lost`` says what of the file was left
    out, if anything was."""

    points: np.ndarray
    normals: np.ndarray | None
    label: np.ndarray
    names: tuple[str, ...]
    lost: str = ""
    bodies: Bodies | None = None


def read_cloud(path: Path) -> Cloud:
    """The surface of a file as points. Raises UserError with what is wrong with it."""
    suffix = path.suffix.lower()
    if suffix not in KINDS:
        raise UserError(
            f"{path.name}: {suffix or 'a file without a suffix'} is no kind that can be read",
            f"the kinds are {', '.join(KINDS)}",
        )
    try:
        if path.stat().st_size > _MOST_BYTES:
            raise UserError(f"{path.name} is larger than 2 GB", "simplify it first")
        if path.stat().st_size == 0:
            raise UserError(f"{path.name} is empty", "export it again")
        with _silent():
            cloud = _read_points(path) if suffix in CLOUDS else _read_solids(path)
    except UserError:
        raise
    except FileNotFoundError as missing:
        raise UserError(f"{path.name}: there is no file {missing.filename or path}") from None
    except OSError as wrong:
        raise UserError(f"{path.name} cannot be read: {wrong.strerror or wrong}") from None
    except Exception as wrong:  # noqa: BLE001 - libraries that read formats raise whatever they please
        raise UserError(
            f"{path.name} cannot be read as {suffix[1:]}: {str(wrong)[:120] or type(wrong).__name__}",
            "export it again, or in another format",
        ) from None
    return check_cloud(cloud, path.name)


@contextmanager
def _silent() -> Iterator[None]:
    """What NumPy and trimesh remark on a file, some of it with a traceback, is not said: it is read, or refused in words."""
    log, deaf = logging.getLogger("trimesh"), logging.NullHandler()
    log.addHandler(deaf)
    try:
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")
            yield
    finally:
        log.removeHandler(deaf)


@np.errstate(over="ignore")  # what is too large is refused in words
def check_cloud(cloud: Cloud, name: str) -> Cloud:
    """As much of a cloud as fits are made from, in random order, without what is no number. Raises UserError for one without a shape."""
    good = np.isfinite(cloud.points).all(axis=1)
    if cloud.normals is not None:
        length = np.sqrt((cloud.normals**2).sum(axis=1))
        good &= np.isfinite(length)
    missing = len(good) - int(good.sum())
    told = f"{missing} of {len(good)} points are no numbers" if missing else ""
    if missing > 0.5 * len(good):
        raise UserError(f"{name}: {told}", "export it again")
    lost = ", ".join(filter(None, (cloud.lost, told)))
    at = np.flatnonzero(good)
    if len(at) < _LEAST:
        raise UserError(f"{name} has {len(at)} points, too few to see a shape", f"at least {_LEAST} are needed")
    at = at[np.random.Generator(np.random.Philox(_SEED)).permutation(len(at))[:_POINTS]]
    points = cloud.points[at].astype(np.float64)
    size = np.ptp(points, axis=0)
    if not 1e-9 < size.max() < 1e9:
        raise UserError(f"{name} is {size.max():g} long: there is no shape in it")
    if np.sort(size)[1] < 1e-4 * size.max():
        raise UserError(f"{name} is a line, not a surface", "give points all over its surface")
    normals = None if cloud.normals is None else cloud.normals[at].astype(np.float64)
    if normals is not None:
        length = np.sqrt((normals**2).sum(axis=1, keepdims=True))
        normals = None if (length < 1e-9).mean() > 0.01 else normals / np.maximum(length, 1e-12)
    return Cloud(points, normals, cloud.label[at], cloud.names, lost, cloud.bodies)


# ---------------------------------------------------------------- points


def _read_points(path: Path) -> Cloud:
    if path.suffix.lower() == ".xyz":
        points, normals, lost = read_table(path)
        return Cloud(points, normals, np.full(len(points), -1), (), lost)
    if not is_zipfile(path):  # NumPy would take it for pickled data, and advise to load it unsafely
        raise UserError(f"{path.name} cannot be read as npz: it is no archive of arrays", "np.savez writes one")
    with open(path, "rb") as file, np.load(file, allow_pickle=False) as held:
        if "vertices" in held and "points" not in held:
            return solid_of(held, path.name, path.stem).surface(path.name)
        return points_of(held, path.name)


def points_of(held: Mapping[str, Any], name: str) -> Cloud:
    """The cloud of named arrays, as those of an ``.npz``. Raises UserError where they do not belong together."""
    if "points" not in held:
        lacking = "no array `points`, nor `vertices` and `faces`"
        raise UserError(f"{name} has {lacking}", f"it has {', '.join(held) or 'none'}")
    points = np.asarray(held["points"], dtype=np.float64)
    if points.ndim != 2 or points.shape[1] != 3:
        raise UserError(f"{name}: `points` is of shape {points.shape}", "one of (n, 3) is needed")
    normals = np.asarray(held["normals"], dtype=np.float64) if "normals" in held else None
    if normals is not None and normals.shape != points.shape:
        raise UserError(
            f"{name}: `normals` is of shape {normals.shape}, not that of the points", f"one of {points.shape} is needed"
        )
    return Cloud(points, normals, *_labels_of(held, len(points), "points", name))


def _normals_of(cloud: Any) -> np.ndarray | None:
    """(n, 3) the normals that a PLY has of its points, None where it has none: trimesh keeps what else it reads of these beside them."""
    try:
        held = cloud.metadata["_ply_raw"]["vertex"]["data"]
        found = np.stack([np.asarray(held[key], dtype=np.float64).ravel() for key in ("nx", "ny", "nz")], axis=1)
    except (AttributeError, KeyError, TypeError, ValueError):
        return None
    return found if found.shape == np.shape(cloud.vertices) else None


def _labels_of(held: Mapping[str, Any], count: int, of: str, name: str) -> tuple[np.ndarray, tuple[str, ...]]:
    """The labels (count,) of points or faces among named arrays, and what they are called; -1 where nothing is said. Raises UserError."""
    for ids, words in (("label", "label_names"), ("link_id", "link_names")):
        if ids in held and words in held:
            label, names = np.asarray(held[ids]), tuple(map(str, held[words]))
            if label.dtype.kind not in "biu" and not (label.dtype.kind == "f" and (label == np.floor(label)).all()):
                raise UserError(
                    f"{name}: `{ids}` is of type {label.dtype}", f"whole numbers are needed, places in `{words}`"
                )
            label = label.astype(np.int64)
            if label.shape != (count,):
                raise UserError(
                    f"{name}: `{ids}` is of shape {label.shape}", f"one of ({count},) is needed, as of the {of}"
                )
            low, high = label.min(initial=-1), label.max(initial=-1)
            if low < -1 or high >= len(names):
                raise UserError(
                    f"{name}: `{ids}` has {low if low < -1 else high}, and `{words}` names 0 to {len(names) - 1}",
                    "-1 stands for none",
                )
            return label, names
    return np.full(count, -1), ()


# ---------------------------------------------------------------- solids


def _read_solids(path: Path) -> Cloud:
    if path.suffix.lower() != ROBOT:
        return join_meshes(load_meshes(path)).cloud(path.name)
    robot = read_robot(path)
    cloud = join_meshes(robot.meshes).cloud(path.name)
    return replace(cloud, bodies=robot.bodies(cloud.names))


@dataclass(frozen=True, slots=True, eq=False)
class Solid:
    """``vertices`` (v, 3) of triangles ``faces`` (f, 3), each with a ``label`` (f,) that indexes ``names``, -1 for none; of a cloud all
    vertices and no face, and their ``normals`` (v, 3) if they are known."""

    vertices: np.ndarray
    faces: np.ndarray
    label: np.ndarray
    names: tuple[str, ...]
    normals: np.ndarray | None = None

    def surface(self, name: str) -> Cloud:
        """Points of its faces. Raises UserError where it has none."""
        if not len(self.faces):
            raise UserError(f"{name} has no faces", "give its vertices alone to fit them as points")
        return self.cloud(name)

    def cloud(self, name: str) -> Cloud:
        """Points of its faces, or else its vertices. Raises UserError where it has neither."""
        if len(self.faces):
            return _sampled(self.vertices[self.faces], self.label, self.names, name)
        if not len(self.vertices):
            raise UserError(f"{name} has no surface")
        return Cloud(self.vertices, self.normals, np.full(len(self.vertices), -1), ())


def solid_of(held: Mapping[str, Any], name: str, called: str) -> Solid:
    """The mesh of named arrays, ``vertices`` and ``faces``, with labels of its faces, or ``called`` as a whole. Raises UserError where they
    do not belong together."""
    if "faces" not in held:
        raise UserError(f"{name} has `vertices`, and no `faces`", 'give them as "points" to fit a cloud')
    vertices, faces = np.asarray(held["vertices"], dtype=np.float64), np.asarray(held["faces"])
    for key, array in (("vertices", vertices), ("faces", faces)):
        if array.ndim != 2 or array.shape[1] != 3:
            raise UserError(f"{name}: `{key}` is of shape {array.shape}", "one of (n, 3) is needed")
    if faces.dtype.kind not in "iu" and faces.size:
        raise UserError(f"{name}: `faces` is of type {faces.dtype}", "whole numbers are needed")
    if faces.size and not 0 <= faces.min() <= faces.max() < len(vertices):
        wrong = faces.min() if faces.min() < 0 else faces.max()
        raise UserError(f"{name}: `faces` has {wrong}, and there are {len(vertices)} vertices", "they count from 0")
    label, names = _labels_of(held, len(faces), "faces", name)
    faces = faces.astype(np.int64, copy=False)
    return Solid(vertices, faces, *((label, names) if names else (np.zeros(len(faces), dtype=np.int64), (called,))))


def join_meshes(meshes: Sequence[tuple[str, Any]]) -> Solid:
    """Meshes of trimesh as one, with their names as labels. Those without faces stand for their points, where none has any."""
    solid = [(name, mesh) for name, mesh in meshes if len(getattr(mesh, "faces", ()))]
    if not solid:
        points = [np.asarray(mesh.vertices, dtype=np.float64).reshape(-1, 3) for _, mesh in meshes]
        known = [found for _, mesh in meshes if (found := _normals_of(mesh)) is not None]
        normals = np.concatenate(known) if known and len(known) == len(meshes) else None
        none = np.zeros((0, 3), dtype=np.int64)
        return Solid(np.concatenate([np.zeros((0, 3)), *points]), none, none[:, 0], (), normals)
    names = tuple(dict.fromkeys(name for name, _ in solid))
    vertices = [np.asarray(mesh.vertices, dtype=np.float64) for _, mesh in solid]
    first = np.cumsum([0, *map(len, vertices)])
    faces = [np.asarray(mesh.faces) + begin for (_, mesh), begin in zip(solid, first, strict=False)]
    label = [np.full(len(mesh.faces), names.index(name)) for name, mesh in solid]
    return Solid(np.concatenate(vertices), np.concatenate(faces), np.concatenate(label), names)


def _sampled(corners: np.ndarray, label: np.ndarray, names: tuple[str, ...], name: str) -> Cloud:
    """Points uniform by area on triangles (f, 3, 3)."""
    across = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    twice = np.sqrt((across**2).sum(axis=1))
    twice = np.where(np.isfinite(twice), twice, 0.0)
    if not twice.sum() > 0.0:
        raise UserError(
            f"{name} has triangles, but no surface: they are all without area, or no numbers",
            "a mesh needs triangles with an area",
        )
    chance = np.random.Generator(np.random.Philox(_SEED))
    count = 2 * _POINTS  # what lies inside goes
    face = np.searchsorted(np.cumsum(twice), (np.arange(count) + chance.random()) * twice.sum() / count, side="right")
    face = np.minimum(face, len(twice) - 1)
    first, second = np.sqrt(chance.random(count)), chance.random(count)
    weights = np.stack([1.0 - first, first * (1.0 - second), first * second], axis=1)
    points = (corners[face] * weights[:, :, None]).sum(axis=1)
    return Cloud(points, across[face] / np.maximum(twice[face], 1e-300)[:, None], label[face], names)


def parts_of(path: Path) -> list[Path]:
    """The other files that one is read from, as far as they are there: the visible meshes of a URDF, the buffers of a glTF."""
    found: dict[Path, None] = {}
    waiting = [path]
    while waiting:
        new = [part for part in _named_by(waiting.pop()) if part not in found and part.is_file()]
        found |= dict.fromkeys(new)
        waiting += new
    return list(found)


def _named_by(path: Path) -> list[Path]:
    """The files that one names."""
    try:
        if path.suffix.lower() == ROBOT:
            root = ElementTree.parse(path).getroot()
            return [mesh_of(mesh, path)[1] for visual in root.iter("visual") for mesh in visual.iter("mesh")]
        if path.suffix.lower() == ".gltf":
            names = [buffer.get("uri", "") for buffer in json.loads(path.read_bytes()).get("buffers", ())]
            return [path.parent / unquote(name) for name in names if not name.startswith("data:")]
    except (OSError, ValueError, AttributeError, TypeError, ElementTree.ParseError, RecursionError):
        pass  # what is wrong with it is told where it is read
    return []
