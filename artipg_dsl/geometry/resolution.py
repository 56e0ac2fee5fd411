"""How many steps the meshes of instances take: by the angle that a surface turns through, or by its chord error.

By chord error, the steps of an instance follow from its own shape alone. The second differences of a patch on a fine
grid tell how far its chords lie off: by reach / (8 n^2) for n steps (the interpolation error of a linear function; see
any text on finite elements). Directions that share a seam are one class of the topology and take the steps of the
one that needs most, so that seams stay matched. Steps are rounded up to a ladder, so that instances share plans.
"""

from __future__ import annotations

from collections.abc import Sequence
from numbers import Real

import numpy as np

from ..arguments import read_whole
from ..errors import UsageError
from ..graph.primitive import Primitive
from ..records import dataclass
from .patches import grid, position_split, tangent_split
from .split import Params, rows_of
from .topology import Topology
from .vectors import dot

FINEST, COARSEST = 1e-5, 10.0  # metres: the tolerances that are taken
_LADDER = np.array([*range(1, 9), *(m << k for k in range(1, 10) for m in (5, 6, 7, 8))])
_SAFE = 1.05  # second differences over 1/32 of a direction miss a little of its sharpest bend
_QUARTER = np.pi / 2  # a step turns through no more than this, whatever the tolerance
_FINE = np.linspace(0.0, 1.0, 33)
_FEW = np.linspace(0.0, 1.0, 17)
_ACROSS = np.linspace(0.0, 1.0, 9)
_ENDS = np.linspace(0.0, 1.0, 3)
_AT_ONCE = 1024  # instances


@dataclass(frozen=True, slots=True)
class Resolution:
    """``steps`` per full turn; or, where given, no chord further than ``tolerance`` (metres) off the true surface, and
    no object of more than ``triangles``, as fine as that allows. An object that has more triangles at its coarsest, a
    quarter turn a step, keeps them. Raises UsageError.
    """

    steps: int = 24
    tolerance: float | None = None
    triangles: int | None = None

    def __post_init__(self) -> None:
        known = self.tolerance is None or isinstance(self.tolerance, Real) and FINEST <= self.tolerance <= COARSEST
        if not known or isinstance(self.tolerance, bool):
            raise UsageError(f"tolerance={self.tolerance} is not a distance from {FINEST} to {COARSEST} metres")
        if self.triangles is not None:
            read_whole("triangles", self.triangles, 1)

    @property
    def by_error(self) -> bool:
        return self.tolerance is not None or self.triangles is not None

    def plain(self) -> dict[str, float | int]:
        """What differs from the usual, for manifests."""
        if not self.by_error:
            return {} if self == STANDARD else {"steps": self.steps}
        found = {"tolerance": self.tolerance, "triangles": self.triangles}
        return {name: value for name, value in found.items() if value is not None}


STANDARD = Resolution()


@dataclass(frozen=True, slots=True, eq=False)
class Bends:
    """How k instances of one topology bend: ``reach`` (k, patches, 2) metres, and the ``least`` steps (k, classes)."""

    topology: Topology
    reach: np.ndarray
    least: np.ndarray

    def steps(self, tolerance: np.ndarray) -> np.ndarray:
        """(k, classes): the steps that keep within ``tolerance`` (k,) metres."""
        classes = self.topology.step_class
        # where both directions of a patch bend, their errors add up: each takes half, or what the other leaves
        coarse = self.reach / (8.0 * np.square(self.least[:, classes].astype(np.float64)))
        allowed = np.maximum(tolerance[:, None, None] - coarse[:, :, ::-1], tolerance[:, None, None] / 2)
        wanted = np.ceil(np.sqrt(self.reach / (8.0 * allowed)) - 1e-9).astype(np.int64)
        counts = self.least.copy()
        for patch, (along_u, along_v) in enumerate(classes.tolist()):
            np.maximum(counts[:, along_u], wanted[:, patch, 0], out=counts[:, along_u])
            np.maximum(counts[:, along_v], wanted[:, patch, 1], out=counts[:, along_v])
        return _LADDER[np.minimum(np.searchsorted(_LADDER, counts), len(_LADDER) - 1)]

    def triangles(self, tolerance: np.ndarray) -> np.ndarray:
        """(k,): how many triangles these steps make."""
        return _count_triangles(self.topology, self.steps(tolerance))


@dataclass(frozen=True, slots=True, eq=False)
class Spans:
    """How long k instances of one topology are along the directions of its classes: ``longest`` (k, classes) metres, as if all
    of a line were as fast as where it is fastest; ``least`` (k, classes) are the steps that they take at any rate."""

    topology: Topology
    longest: np.ndarray
    least: np.ndarray

    def steps(self, edge: np.ndarray) -> np.ndarray:
        """(k, classes): the steps that are no longer than ``edge`` (k,) metres."""
        counts = np.maximum(self.least, np.ceil(self.longest / edge[:, None] - 1e-9).astype(np.int64))
        return _LADDER[np.minimum(np.searchsorted(_LADDER, counts), len(_LADDER) - 1)]

    def triangles(self, edge: np.ndarray) -> np.ndarray:
        """(k,): how many triangles these steps make."""
        return _count_triangles(self.topology, self.steps(edge))


def _count_triangles(topology: Topology, steps: np.ndarray) -> np.ndarray:
    """(k,): how many triangles the ``steps`` (k, classes) make."""
    counts = steps[:, topology.step_class]
    found = (2 * counts[:, :, 0] * counts[:, :, 1]).sum(axis=1)
    position = {patch: n for n, patch in enumerate(topology.patches)}
    for patch, edge in topology.collapsed:  # a row of quads at a point is a row of triangles
        found -= counts[:, position[patch], 1 if edge < 2 else 0]
    return np.asarray(found)


def measure_spans(primitive: Primitive, topology: Topology, params: Params, least: np.ndarray) -> Spans:
    """How long instances of one topology are, which take the ``least`` (k, classes) steps at any rate."""
    count = rows_of(params)
    longest = np.zeros((count, int(topology.step_class.max()) + 1))
    for start in range(0, count, _AT_ONCE):
        rows = slice(start, start + _AT_ONCE)
        some = {name: value[rows] for name, value in params.items()}
        for n, patch in enumerate(topology.patches):
            split = position_split(primitive, patch)
            for along in (0, 1):
                u, v = (_FEW[:, None], _ACROSS[None]) if along == 0 else (_ACROSS[None], _FEW[:, None])
                chords = np.diff(grid(split, some, *np.broadcast_arrays(u, v)), axis=1)
                longest_here = (len(_FEW) - 1) * np.sqrt(dot(chords, chords)).max(axis=(1, 2))
                own = topology.step_class[n, along]
                longest[rows, own] = np.maximum(longest[rows, own], longest_here)
    return Spans(topology, longest, least)


def measure_bends(primitive: Primitive, topology: Topology, params: Params) -> Bends:
    """How instances of one topology bend."""
    count = rows_of(params)
    reach = np.zeros((count, len(topology.patches), 2))
    least = np.repeat(np.where(topology.closed, 3, 1)[None], count, axis=0)
    bent = topology.turn[topology.step_class] > 0
    for start in range(0, count, _AT_ONCE):
        rows = slice(start, start + _AT_ONCE)
        some = {name: value[rows] for name, value in params.items()}
        for n, patch in enumerate(topology.patches):
            if bent[n].any():
                found, turn = _bend(primitive, patch, some, bent[n])
                reach[rows, n] = found
                for along in (0, 1):
                    own = topology.step_class[n, along]
                    quarters = np.ceil(turn[:, along] / _QUARTER - 0.01).astype(np.int64)
                    least[rows, own] = np.maximum(least[rows, own], quarters)
    return Bends(topology, reach, least)


def _bend(primitive: Primitive, patch: int, params: Params, bent: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Reach and turning (k, 2) of one patch along u and v."""
    split = position_split(primitive, patch)
    count = rows_of(params)
    reach, turn = np.zeros((count, 2)), np.zeros((count, 2))
    for along in np.flatnonzero(bent).tolist():
        across = _ACROSS if bent.all() else _ENDS
        u, v = (_FINE[:, None], across[None]) if along == 0 else (across[None], _FINE[:, None])
        points = grid(split, params, *np.broadcast_arrays(u, v))  # (k, 33, lines, 3)
        chords = np.diff(points, axis=1)
        second, middle = np.diff(chords, axis=1), chords[:, 1:] + chords[:, :-1]
        square = dot(middle, middle)
        askew = second - middle * (dot(second, middle) / np.where(square > 0, square, 1.0))[..., None]
        reach[:, along] = _SAFE * (len(_FINE) - 1) ** 2 * np.sqrt(dot(askew, askew)).max(axis=(1, 2))
        u, v = (_FEW[:, None], _ENDS[None]) if along == 0 else (_ENDS[None], _FEW[:, None])
        tangents = grid(tangent_split(primitive, patch), params, *np.broadcast_arrays(u, v))
        turn[:, along] = _turned(tangents[..., 3 * along : 3 * along + 3])
    if bent.all():
        twist = _twist(grid(split, params, *np.broadcast_arrays(_ACROSS[:, None], _ACROSS[None])))
        reach += twist[:, None]  # 2 |ab| <= a^2 + b^2 splits the mixed term between both directions
    return reach, turn


def _turned(tangents: np.ndarray) -> np.ndarray:
    """(k,): the greatest sum of angles between successive tangents (k, 17, lines, 3) of lines that are no points."""
    first, second = tangents[:, :-1], tangents[:, 1:]
    cross = np.cross(first, second)
    size = np.sqrt(dot(tangents, tangents))
    good = (size > 1e-9 * size.max(axis=(1, 2), keepdims=True)).all(axis=1)
    angle = np.arctan2(np.sqrt(dot(cross, cross)), dot(first, second))
    total = np.zeros(good.shape)
    for step in range(angle.shape[1]):  # one after the other: the same bits in any batch
        total += angle[:, step]
    return np.where(good, total, 0.0).max(axis=1)


def _twist(points: np.ndarray) -> np.ndarray:
    """(k,): the mixed second difference of a grid (k, 9, 9, 3) along the normal, as of fractions."""
    across, up = points[:, 1:] - points[:, :-1], points[:, :, 1:] - points[:, :, :-1]
    mixed = across[:, :, 1:] - across[:, :, :-1]
    normal = np.cross(across[:, :, 1:] + across[:, :, :-1], up[:, 1:] + up[:, :-1])
    length = np.sqrt(dot(normal, normal))
    out = np.abs(dot(mixed, normal)) / np.where(length > 0, length, 1.0)
    return (len(_ACROSS) - 1) ** 2 * out.max(axis=(1, 2))


def within_budget(
    parts: Sequence[tuple[Bends | Spans, np.ndarray]], objects: int, triangles: int, start: float | np.ndarray
) -> np.ndarray:
    """(objects,): the finest tolerance, or the shortest edge, from ``start`` on at which an object keeps to its triangles.

    ``parts`` are the instances of the objects, with the object of each.
    """
    low, high = np.log(np.broadcast_to(start, objects)), np.full(objects, np.log(COARSEST))
    for _ in range(24):
        middle = (low + high) / 2
        total = np.zeros(objects)
        for bend, owner in parts:
            total += np.bincount(owner, bend.triangles(np.exp(middle)[owner]), objects)
        fits = total <= triangles
        low, high = np.where(fits, low, middle), np.where(fits, middle, high)
    return np.exp(high)
