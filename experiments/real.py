"""Real objects, as they lie in a folder: ``CATEGORY/NAME/cloud.npz`` with ``joints.json`` beside it, or folders of PartNet-Mobility.

``cloud.npz`` has ``points`` (n, 3), ``link_id`` (n,) into ``link_names``, and ``normals`` (n, 3) of any length, where an experiment asks for
them. ``joints.json`` has ``up`` and ``front``, the axes that point up and to the front, and ``joints``: ``type``, ``parent``, ``child``, and
``axis``, ``origin``, ``lower``, ``upper`` in the frame of the points.
"""

from __future__ import annotations

import json
from collections import Counter
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any
from zipfile import BadZipFile

import numpy as np

import artipg_dsl as apg
from artipg_dsl.errors import UserError
from artipg_dsl.fit.pose import AXES, turn

from .clouds import Clouds, normalise

LEAST = 256  # points of a cloud


@dataclass(frozen=True, slots=True, eq=False)
class Joint:
    """``parent`` and ``child`` number links; unit ``axis`` (3,) and ``origin`` (3,). From rest, at 0, the joint goes along the axis, or turns
    about it by the right hand; ``both``: the other way, too."""

    kind: str
    parent: int
    child: int
    axis: np.ndarray
    origin: np.ndarray
    both: bool = False


@dataclass(frozen=True, slots=True, eq=False)
class Real:
    """``points`` (n, 3) and unit ``normals`` (n, 3), where they are known, x to the front and z up, in the unit of the file; ``link`` (n,)
    numbers links."""

    category: str
    name: str
    points: np.ndarray
    normals: np.ndarray | None
    link: np.ndarray
    links: int
    joints: tuple[Joint, ...]

    @property
    def title(self) -> str:
        return f"{self.category} {self.name}"

    def moved_by(self) -> np.ndarray:
        """(links,) the last joint that carries each link, -1 for those that stay."""
        children = {joint.child: k for k, joint in enumerate(self.joints)}
        found = np.full(self.links, -1)
        for link in range(self.links):
            at, seen = link, set()
            while at in children and at not in seen and found[link] < 0:
                seen.add(at)
                if self.joints[children[at]].kind != "fixed":
                    found[link] = children[at]
                at = self.joints[children[at]].parent
        return found


def read_real(folder: Path, map_file: Path | None = None) -> list[Real]:
    """All objects of a folder whose category is shipped, in the order of their paths; ``map_file`` is a JSON file of their names of
    categories and ours. Raises UserError with what is missing or wrong."""
    if not folder.is_dir():
        raise UserError(f"there is no folder {folder}")
    ours = _read_map(map_file)
    clouds = [p for p in sorted(folder.rglob("cloud.npz")) if (p.parent / "joints.json").exists()]
    places = [(path.parent.parent.name, path.parent, _read_cloud) for path in clouds]
    if not places:
        from .partnet import category_of, read_mobility

        mobility = [p.parent for p in sorted(folder.rglob("mobility_v2.json"))]
        places = [(category_of(place), place, read_mobility) for place in mobility]
    if not places:
        raise UserError(
            f"{folder} has no objects",
            "the form is CATEGORY/NAME/cloud.npz with joints.json beside it, or ID/mobility_v2.json as in PartNet-Mobility",
        )
    unknown = Counter(theirs for theirs, _, _ in places if theirs.lower() not in ours)
    if len(unknown) == len({theirs for theirs, _, _ in places}):
        raise UserError(
            f"no category of {folder} is shipped: {', '.join(sorted(unknown))}",
            'name ours with --map FILE, such as {"Cupboard": "StorageFurniture"}',
        )
    for theirs, count in sorted(unknown.items()):
        print(f"left out: {count} of {theirs}, which is no shipped category (--map FILE names ours)")
    return [read(place, ours[theirs.lower()]) for theirs, place, read in places if theirs.lower() in ours]


def _read_map(path: Path | None) -> dict[str, str]:
    """Names of categories in lower case and ours."""
    shipped = {name.lower(): name for name in apg.categories()}
    if path is None:
        return shipped
    try:
        told = json.loads(path.read_text(encoding="utf-8"))
    except OSError as wrong:
        raise UserError(f"{path} cannot be read: {wrong.strerror}") from None
    except ValueError as wrong:
        raise UserError(f"{path} is not JSON: {wrong}") from None
    if not isinstance(told, dict) or not all(isinstance(name, str) for name in told.values()):
        raise UserError(f"{path} is no map of names", 'it looks like {"Cupboard": "StorageFurniture"}')
    for theirs, name in told.items():
        if name.lower() not in shipped:
            raise UserError(
                f"{path}: {theirs} is mapped to {name}, which is no shipped category",
                f"they are {', '.join(sorted(shipped.values()))}",
            )
    return shipped | {theirs.lower(): shipped[name.lower()] for theirs, name in told.items()}


def _read_cloud(place: Path, category: str) -> Real:
    path, beside = place / "cloud.npz", place / "joints.json"
    try:
        record = json.loads(beside.read_text(encoding="utf-8"))
        with np.load(path) as data:
            held = {name: data[name] for name in data}
    except (OSError, ValueError, BadZipFile) as wrong:
        raise UserError(f"{place}: {wrong}", "cloud.npz and joints.json are read") from None
    try:
        points, link, names = held["points"], held["link_id"], [str(n) for n in held["link_names"]]
        turned = upright(record["up"], record["front"])
        joints = tuple(_joint(joint, names, turned) for joint in record["joints"])
    except (KeyError, IndexError, TypeError, ValueError, AttributeError) as wrong:
        raise UserError(
            f"{path}: {wrong!r} is missing or wrong",
            "points, link_id, link_names; in joints.json up, front and joints with type, parent, child, axis, origin",
        ) from None
    normals = held.get("normals")
    normals = None if normals is None else normals @ turned.T
    return checked(
        path, category, place.name, points @ turned.T.astype(points.dtype), normals, link, len(names), joints
    )


def checked(
    path: Path,
    category: str,
    name: str,
    points: np.ndarray,
    normals: np.ndarray | None,
    link: np.ndarray,
    links: int,
    joints: tuple[Joint, ...],
) -> Real:
    """The object, if its arrays fit together. Raises UserError."""
    wrong = ""
    if points.dtype.kind != "f" or points.ndim != 2 or points.shape[1] != 3 or len(points) < LEAST:
        wrong = f"points are of shape {points.shape}, ({LEAST} or more, 3) is needed"
    elif link.shape != points.shape[:1] or not (0 <= link.min() and link.max() < links):
        wrong = f"link_id is of shape {link.shape}, one of {links} links for each of {len(points)} points is needed"
    elif normals is not None and normals.shape != points.shape:
        wrong = f"normals are of shape {normals.shape}, not that of the points"
    elif not np.isfinite(points).all() or not np.ptp(points, axis=0).max() > 0:
        wrong = "points are no numbers, or all the same"
    if wrong:
        raise UserError(f"{path}: {wrong}")
    if normals is not None:
        normals = normals / np.maximum(np.sqrt((normals**2).sum(axis=1, keepdims=True)), 1e-12)
    return Real(category, name, points, normals, link.astype(np.int64), links, joints)


def upright(up: str, front: str) -> np.ndarray:
    """(3, 3) the rotation that brings the axis ``up``, such as "y" or "-z", to z and the axis ``front`` to x. Raises ValueError."""
    if up not in AXES or front not in AXES or up[-1] == front[-1]:
        raise ValueError(f"up {up}, front {front}")
    return turn(up, front)


def _joint(told: Mapping[str, Any], names: Sequence[str], turned: np.ndarray) -> Joint:
    parent, child = names.index(told["parent"]), names.index(told["child"])
    if told["type"] == "fixed":
        return Joint("fixed", parent, child, np.zeros(3), np.zeros(3))
    return make_joint(
        told["type"],
        parent,
        child,
        turned @ told["axis"],
        turned @ told["origin"],
        told.get("lower"),
        told.get("upper"),
    )


def make_joint(
    kind: str, parent: int, child: int, axis: np.ndarray, origin: np.ndarray, low: float | None, high: float | None
) -> Joint:
    """A joint with its axis the way it has more room to go from 0. Raises ValueError for an axis without a length."""
    length = float(np.sqrt((axis**2).sum()))
    if not length > 1e-9 or not np.isfinite(origin).all():
        raise ValueError(f"axis {axis}")
    least, most = (end if end is not None else sign * np.inf for end, sign in ((low, -1), (high, 1)))
    back = -least > most + 1e-9
    return Joint(kind, parent, child, (-axis if back else axis) / length, origin, least < -1e-9 and most > 1e-9)


def to_clouds(objects: Sequence[Real], arrays: Mapping[str, Sequence[np.ndarray]]) -> Clouds:
    """Clouds of the objects, thinned at random to as many points as all have; ``arrays`` by name, for each object (n, ...)."""
    least = min(len(one.points) for one in objects)
    thinned = [np.random.default_rng(k).permutation(len(one.points))[:least] for k, one in enumerate(objects)]
    known = tuple(sorted({one.category for one in objects}))
    found = {
        name: np.stack([each[at] for each, at in zip(values, thinned, strict=True)]) for name, values in arrays.items()
    }
    found["points"] = normalise(np.stack([one.points[at] for one, at in zip(objects, thinned, strict=True)]))
    return Clouds(
        found,
        np.array([known.index(one.category) for one in objects]),
        known,
        tuple(one.title for one in objects),
        np.arange(len(objects)),
    )


def real_shapes(objects: Sequence[Real]) -> Clouds:
    """Clouds of points alone."""
    return to_clouds(objects, {})


def real_motion(objects: Sequence[Real]) -> Clouds:
    """Clouds of the objects with a joint: ``moves`` (K, n) tells whether one moves the point. Raises UserError if there is none."""
    moves = [(one, (one.moved_by() >= 0)[one.link]) for one in objects]
    moves = [(one, found) for one, found in moves if found.any()]
    if not moves:
        raise UserError("no object has points on a link that a joint moves", "joints.json tells them")
    return to_clouds([one for one, _ in moves], {"moves": [found for _, found in moves]})
