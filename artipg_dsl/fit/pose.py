"""Clouds in the frame of programs: unit, upward axis and front as given, or as the file and the category suggest; outer surface, normals."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import field

import numpy as np
from scipy.spatial import cKDTree

from ..errors import UsageError, UserError
from ..records import dataclass
from .bodies import Bodies
from .compare import Targets
from .outer import outer, spacing, towards
from .reading import Cloud

AXES = ("x", "-x", "y", "-y", "z", "-z")
_ANY = "any"  # upward axis
UNITS = {"m": 1.0, "cm": 0.01, "mm": 0.001, "in": 0.0254, "ft": 0.3048}
_GUESSED = "m", "cm", "mm", "in"  # a foot is too near to a metre to be told from it by the size of an object
_COMPARED = 8192  # points of a target
_NEIGHBOURS = 12, 24, 48  # that tell a normal: as few as lie in a plane
_THICK = 0.15  # of the reach of neighbours: how far they may lie off a plane
_ASKED = 2000  # points of a cloud that are asked for its noise
_ALIKE = 0.8  # what normals agree by at least that tell it
_FROM_MEDIAN = 1.05  # of a difference of two normal deviates to the deviation of one: 1 / (0.674 * sqrt(2))
_ODD = 2.5  # times larger or smaller than usual objects: then the unit is looked for
_FAR = 30.0  # times: then it is no object of the category


@dataclass(frozen=True, slots=True)
class Frame:
    """How files stand: ``up`` and ``front`` axes and ``unit``, or "auto"; with "any" for ``up`` all are tried. ``normalised``: the scale
    says nothing."""

    up: str = "auto"
    front: str = "auto"
    unit: str = "auto"
    normalised: bool = False

    def __post_init__(self) -> None:
        told = (
            ("up", self.up, ("auto", _ANY, *AXES)),
            ("front", self.front, ("auto", *AXES)),
            ("unit", self.unit, ("auto", *UNITS)),
        )
        for name, value, known in told:
            if value not in known:
                raise UsageError(f"{name} is {value!r}", f"it is one of {', '.join(known)}")
        if self.up in AXES and self.front in AXES and self.up[-1] == self.front[-1]:
            raise UsageError(
                f"up is {self.up} and front is {self.front}: they lie on one axis", "they are square to each other"
            )
        if self.normalised and self.unit != "auto":
            raise UsageError("objects without a scale have no unit", "leave out the unit, or that they are normalised")

    def turns(self, suffix: str) -> list[tuple[str, str]]:
        """The pairs of upward axis and front that are possible."""
        if self.up == _ANY:
            return [(up, front) for up in AXES for front in self._fronts(up)]
        up = ("y" if suffix in (".glb", ".gltf") else "z") if self.up == "auto" else self.up
        if not self._fronts(up):
            up = "z" if up[-1] != "z" else "y"
        return [(up, front) for front in self._fronts(up)]

    def others(self, suffix: str) -> list[tuple[str, str]]:
        """Further pairs, for files that fit less well than is usual: those of other upward axes, where none is given."""
        if self.up != "auto":
            return []
        first = self.turns(suffix)[0][0]
        return [(up, front) for up in AXES if up != first for front in self._fronts(up)]

    def _fronts(self, up: str) -> list[str]:
        """The fronts that are possible with an upward axis."""
        return [front for front in (AXES if self.front == "auto" else (self.front,)) if front[-1] != up[-1]]


def axis(name: str) -> np.ndarray:
    return np.eye(3)["xyz".index(name[-1])] * (-1.0 if name.startswith("-") else 1.0)


def turn(up: str, front: str) -> np.ndarray:
    """(3, 3) the rotation that brings ``front`` to x and ``up`` to z."""
    x, z = axis(front), axis(up)
    return np.stack([x, np.cross(z, x), z])


@dataclass(frozen=True, slots=True, eq=False)
class Posed:
    """A cloud's outer surface in metres, in the frame of its file: ``points``, ``normals`` (n, 3), ``label`` (n,); its ``unit`` in metres,
    which ``turns`` are tried, and which ``others`` if nothing fits well in these. ``doubt`` says what is odd about its size."""

    points: np.ndarray
    normals: np.ndarray
    label: np.ndarray
    names: tuple[str, ...]
    unit: str
    turns: list[tuple[str, str]]
    known: bool
    others: list[tuple[str, str]] = field(default_factory=list)
    doubt: str = ""
    bodies: Bodies | None = None


def pose(cloud: Cloud, frame: Frame, suffix: str, usual: float | None) -> Posed:
    """The outer surface of a cloud; ``usual`` is the diagonal of common objects of the category, in metres, None if any size is right.
    Raises UserError for one that is far larger or smaller."""
    unit, doubt = _unit(float(np.sqrt((np.ptp(cloud.points, axis=0) ** 2).sum())), frame, usual)
    points = np.asarray(cloud.points, dtype=np.float64) * UNITS[unit]
    apart = _apart(points)
    seen = outer(points[None], np.array([apart]))[0]
    points, label = points[seen], cloud.label[seen]
    normals = _estimated(points) if cloud.normals is None else np.asarray(cloud.normals[seen], dtype=np.float64)
    facing = (towards(points, apart) * normals).sum(axis=1)
    if cloud.normals is not None:  # a group of a mesh may be inside out, as a whole
        facing = np.bincount(label + 1, facing)[label + 1]
    normals = np.where((facing < 0.0)[:, None], -normals, normals)
    turns = frame.turns(suffix), not frame.normalised, frame.others(suffix)
    bodies = None if cloud.bodies is None else cloud.bodies.scaled(UNITS[unit])
    return Posed(points, normals, label, cloud.names, unit, *turns, doubt, bodies)


def _unit(across: float, frame: Frame, usual: float | None) -> tuple[str, str]:
    """The unit of a cloud with a diagonal ``across``, and what is odd about its size, if anything is. Raises UserError."""
    unit = "m" if frame.unit == "auto" else frame.unit
    if usual is None or frame.normalised:
        return unit, ""
    if frame.unit == "auto" and abs(np.log(across / usual)) > np.log(_ODD):
        unit = min(_GUESSED, key=lambda name: abs(np.log(across * UNITS[name] / usual)))
    off = abs(np.log(across * UNITS[unit] / usual))
    told = f"its diagonal is {across * UNITS[unit]:.2g} m with {unit} as unit, that of usual objects {usual:.2g} m"
    if off > np.log(_FAR):
        raise UserError(told, "scale it, or say that it is normalised (--normalised) if its scale means nothing")
    odd = frame.unit == "auto" and off > np.log(_ODD)
    return unit, f"{told}: if the unit is another, say which (--unit)" if odd else ""


def _apart(points: np.ndarray) -> float:
    """How far points lie apart: of uniform ones the nearest is half as far on average."""
    some = points[:2000]
    return max(2.0 * float(np.median(cKDTree(points).query(some, k=2)[0][:, 1])), float(spacing(points[None])[0]) * 0.7)


def _estimated(points: np.ndarray) -> np.ndarray:
    """Normals, but for their sign: across the plane of the nearest points, of more where noise leaves no plane of few."""
    tree, found = cKDTree(points), points
    for count in _NEIGHBOURS:
        far, near = tree.query(points, k=min(count, len(points)))
        beside = points[near]
        beside = beside - beside.mean(axis=1, keepdims=True)
        square, axes = np.linalg.eigh(np.einsum("kni,knj->kij", beside, beside) / near.shape[1])
        found = axes[:, :, 0]
        if np.median(square[:, 0]) <= (_THICK * np.median(far[:, -1])) ** 2:
            break
    return found


def targets(
    several: Sequence[Posed], words: Sequence[np.ndarray] = (), meant: Sequence[int] = (), most: int = _COMPARED
) -> Targets:
    """The targets of some objects, one for each way in which each may stand. ``words``: of each object those of its points (n,), places in
    ``semantic``, 0 where nothing is said; ``meant``: all that may be. Each has ``most`` points."""
    columns: list[list[np.ndarray]] = [[] for _ in range(7)]
    most_links = max((len(one.bodies.twist) for one in several if one.bodies is not None), default=0)
    of, known, noise, count = [], [], [], []
    for number, one in enumerate(several):
        roughness = _roughness(one)
        taken = np.resize(np.arange(len(one.points)), most)
        for up, front in one.turns:
            matrix = turn(up, front)
            points = one.points @ matrix.T
            word = words[number][taken] if len(words) else np.zeros(len(taken), dtype=np.int64)
            link, twist = np.full(len(taken), -1), np.zeros((most_links, 6))
            if one.bodies is not None:
                link = np.append(one.bodies.of, -1)[one.label[taken]]
                twist[: len(one.bodies.twist)] = one.bodies.turned(matrix).twist
            told = (
                points[taken],
                (one.normals @ matrix.T)[taken],
                points.min(axis=0),
                points.max(axis=0),
                word,
                link,
                twist,
            )
            for column, value in zip(columns, told, strict=True):
                column.append(value)
            of.append(number)
            known.append(one.known)
            noise.append(roughness)
            count.append(min(len(one.points), most))
    points, normals, low, high, word, link, twist = (np.stack(column) for column in columns)
    diagonal = np.sqrt(((high - low) ** 2).sum(axis=1))
    counts = np.array(count)
    apart = np.repeat((spacing(points) * np.sqrt(most / counts))[:, None], most, axis=1)
    return Targets(
        points=points,
        normals=normals,
        diagonal=diagonal,
        apart=apart,
        low=low,
        high=high,
        of=np.array(of),
        known=np.array(known),
        noise=np.array(noise) / diagonal,
        count=counts,
        word=word,
        meant=np.array(meant, dtype=np.int64),
        link=link,
        twist=twist,
    )


def _roughness(one: Posed) -> float:
    """How far points lie off the planes of those beside them that face the same way, in the middle of a cloud's, in metres: its noise."""
    some = slice(0, _ASKED)
    near = cKDTree(one.points).query(one.points[some], k=min(_NEIGHBOURS[0], len(one.points)))[1]
    off = ((one.points[near] - one.points[some, None]) * one.normals[some, None]).sum(axis=2)
    alike = (one.normals[near] * one.normals[some, None]).sum(axis=2) > _ALIKE
    return float(_FROM_MEDIAN * np.median(np.abs(off[:, 1:][alike[:, 1:]]))) if alike[:, 1:].any() else 0.0
