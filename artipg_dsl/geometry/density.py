"""The area element of a patch, classified when the primitive is compiled, and points drawn by area.

Along each fraction the element is constant, linear, or curved; it may be the same profile for all instances up to a
factor. Constant and linear elements have a closed inverse, curved ones a table of a piecewise linear density.
"""

from __future__ import annotations

import math
from functools import lru_cache
from typing import Any

import numpy as np

from ..graph.expr import Expr, call
from ..graph.primitive import Primitive, Triple
from ..records import dataclass
from ..shapes import fit
from . import facts
from .patches import find_existing, grid, surfaces
from .split import Params, Split
from .topology import shown_rows, turns

_FLAT = 1e-9  # relative deviation below which an element counts as constant or linear
_SAMPLES = np.linspace(0.0, 1.0, 9)
_QUARTER = 16  # cells of a table per quarter turn: a linear density is then within 0.2 % of a smooth one
_MOST_BOTH, _SHARED_BOTH, _SHARED = 32, 128, 256  # cells at most along two bent axes; of a table for all instances
_ORDER = 8  # points of quadrature per panel at most; fewer where the area is then the same but for _EXACT
_EXACT = 1e-8
_FAR = 1e300


@lru_cache(maxsize=4096)
def element_split(primitive: Primitive, patch: int) -> Split:
    """|du x dv| over fractions: square metres per unit of u and v."""
    return Split.kept(primitive, f"element of {patch}", 1, lambda: (norm(surfaces(primitive)[patch].cross),))


def norm(vector: Triple) -> Expr:
    """The length of a vector."""
    x, y, z = vector
    return call("sqrt", x * x + y * y + z * z)


@dataclass(frozen=True, slots=True, eq=False)
class Kind:
    """Nodes of the density along u and v: 1 constant, 2 linear, more a table.

    ``order`` is the points of quadrature per panel. With ``profile`` (nodes of u, nodes of v) one table holds for all
    instances: their area is ``factor`` times the element at ``reference`` (fractions).
    """

    nodes: tuple[int, int]
    profile: np.ndarray | None = None
    factor: float = 1.0
    reference: tuple[float, float] = (0.5, 0.5)
    order: int = _ORDER


@lru_cache(maxsize=4096)
def kind(primitive: Primitive, patch: int) -> Kind:
    """How the area element of a patch varies, from the test values."""
    return facts.recall_fact(primitive, f"kind {patch}", lambda: _found(primitive, patch), _to_data, _read)


def _to_data(found: Kind) -> dict[str, Any]:
    profile = None if found.profile is None else found.profile.ravel().tolist()
    return {
        "nodes": found.nodes,
        "profile": profile,
        "factor": found.factor,
        "at": found.reference,
        "order": found.order,
    }


def _read(held: Any) -> Kind:
    """Raises ValueError, TypeError or KeyError where data is no kind."""
    fit(held["nodes"], list[int])
    fit(held["profile"], list[float] | None)
    fit([held["factor"], *held["at"]], list[float])
    fit(held["order"], int)
    (u, v), (along_u, along_v), profile = held["nodes"], held["at"], held["profile"]
    if min(u, v) < 1 or not 2 <= held["order"] <= _ORDER or not all(0.0 <= at <= 1.0 for at in held["at"]):
        raise ValueError("no kind")
    table = None if profile is None else np.array(profile, dtype=np.float64).reshape(u, v)
    return Kind((u, v), table, float(held["factor"]), (float(along_u), float(along_v)), held["order"])


def _found(primitive: Primitive, patch: int) -> Kind:
    params = shown_rows(primitive, patch)
    u, v = np.meshgrid(_SAMPLES, _SAMPLES, indexing="ij")
    element = grid(element_split(primitive, patch), params, u, v)[..., 0]
    element = element / np.maximum(element.max(axis=(1, 2), keepdims=True), 1e-300)
    nodes = tuple(_bend(np.moveaxis(element, 1 + axis, 1)) for axis in range(2))
    curved = [n > 2 for n in nodes]
    if not any(curved):
        return Kind(nodes)  # type: ignore[arg-type]
    same = np.abs(element - element[:1]).max() < _FLAT
    cells = [_QUARTER * min(4, max(1, math.ceil(t / (math.pi / 2) - 1e-6))) for t in turns(primitive, patch)]
    if all(curved):
        cells = [_SHARED_BOTH if same else min(c, _MOST_BOTH) for c in cells]
    elif same:
        cells = [_SHARED, _SHARED]
    found: tuple[int, int] = tuple(c + 1 if b else n for c, b, n in zip(cells, curved, nodes, strict=True))  # type: ignore[assignment]
    if not same:
        return Kind(found, order=_least_order(primitive, patch, params, found))
    one = {name: value[:1] for name, value in params.items()}
    top = np.unravel_index(int(np.argmax(element[0])), element[0].shape)
    reference = (float(_SAMPLES[top[0]]), float(_SAMPLES[top[1]]))
    scale = _at(primitive, patch, one, *reference)
    factor = float((_integral(primitive, patch, one, found, _ORDER) / scale)[0])
    return Kind(found, _table(primitive, patch, one, found)[0], factor, reference)


def _bend(element: np.ndarray) -> int:
    """1, 2 or 3: constant, linear or curved along axis 1."""
    if np.abs(element - element[:, :1]).max() < _FLAT:
        return 1
    chord = element[:, :1] + _SAMPLES[None, :, None] * (element[:, -1:] - element[:, :1])
    return 2 if np.abs(element - chord).max() < _FLAT else 3


def _at(primitive: Primitive, patch: int, params: Params, u: float, v: float) -> np.ndarray:
    """(k,): the element of each instance at one place."""
    return grid(element_split(primitive, patch), params, np.array([u]), np.array([v]))[:, 0, 0]


@lru_cache(maxsize=256)
def _rule(nodes: int, order: int) -> tuple[np.ndarray, np.ndarray]:
    """Places and weights of a quadrature over 0 .. 1; not to be written to, as they are kept."""
    if nodes <= 2:
        return (np.array([0.5]), np.array([1.0])) if nodes == 1 else (np.array([0.0, 1.0]), np.array([0.5, 0.5]))
    panels = min(4, (nodes - 1) // _QUARTER)  # bends of quarter turns end where panels do
    at, weight = np.polynomial.legendre.leggauss(order)
    places = (np.arange(panels)[:, None] + (at + 1) / 2) / panels
    return places.ravel(), np.tile(weight / (2 * panels), panels)


@lru_cache(maxsize=256)
def _rules(nodes: tuple[int, int], order: int) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """The same over both fractions: u, v and weights (m,)."""
    (u, wu), (v, wv) = (_rule(n, order) for n in nodes)
    places = np.meshgrid(u, v, indexing="ij")
    return places[0].ravel(), places[1].ravel(), (wu[:, None] * wv).ravel()


def _integral(primitive: Primitive, patch: int, params: Params, nodes: tuple[int, int], order: int) -> np.ndarray:
    """(k,) areas; the rows of terms are contiguous, so that the batch does not change the order of summation."""
    u, v, weight = _rules(nodes, order)
    element = grid(element_split(primitive, patch), params, u, v)[..., 0]
    return np.add.reduce(np.ascontiguousarray(element * weight), axis=1)


def _least_order(primitive: Primitive, patch: int, params: Params, nodes: tuple[int, int]) -> int:
    """The fewest points of quadrature per panel that give the areas of the test values."""
    exact = _integral(primitive, patch, params, nodes, _ORDER)
    for order in range(2, _ORDER):
        if (np.abs(_integral(primitive, patch, params, nodes, order) - exact) <= _EXACT * exact).all():
            return order
    return _ORDER


@lru_cache(maxsize=256)
def _spaced(nodes: tuple[int, int]) -> tuple[np.ndarray, np.ndarray]:
    """Equally spaced nodes (nodes of u, nodes of v); not to be written to."""
    u, v = (np.array([0.5]) if n == 1 else np.linspace(0.0, 1.0, n) for n in nodes)
    along_u, along_v = np.meshgrid(u, v, indexing="ij")
    return along_u, along_v


def _table(primitive: Primitive, patch: int, params: Params, nodes: tuple[int, int]) -> np.ndarray:
    """(k, nodes of u, nodes of v) the element at equally spaced nodes."""
    return grid(element_split(primitive, patch), params, *_spaced(nodes))[..., 0]


def patch_area(primitive: Primitive, patch: int, params: Params) -> np.ndarray:
    """(k,) areas of one patch on k instances in square metres, 0 where it does not exist."""
    found = kind(primitive, patch)
    if found.profile is not None:
        area = _at(primitive, patch, params, *found.reference) * found.factor
    else:
        area = _integral(primitive, patch, params, found.nodes, found.order)
    if surfaces(primitive)[patch].guard is not None:
        area = np.where(find_existing(primitive, params)[:, patch], area, 0.0)
    return area


class AreaPlacement:
    """Where numbers in (0, 1) fall on one patch of k instances."""

    def __init__(self, primitive: Primitive, patch: int, params: Params):
        found = kind(primitive, patch)
        self._shared = found.profile is not None
        if found.profile is not None:
            density = found.profile[None]
        elif found.nodes == (1, 1):
            density = None
        else:
            density = _table(primitive, patch, params, found.nodes)
        self._density = density
        if density is not None:
            marginal = (
                (density[:, :, 1:] + density[:, :, :-1]).sum(axis=2) if density.shape[2] > 1 else density[:, :, 0]
            )
            self._first = _Line(marginal) if density.shape[1] > 1 else None

    def place(self, row: np.ndarray, first: np.ndarray, second: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Fractions (u, v) for two arrays of numbers in (0, 1) on instances ``row``; area-uniform."""
        density = self._density
        if density is None:
            return first, second
        if self._shared:
            row = np.zeros_like(row)
        nu, nv = density.shape[1:]
        if self._first is None:
            return first, _Line(density[:, 0]).invert(row, second)
        u = self._first.invert(row, first)
        if nv == 1:
            return u, second
        cell = np.minimum((u * (nu - 1)).astype(np.int64), nu - 2)
        t = u * (nu - 1) - cell
        flat = density.reshape(-1, nv)
        low = row * nu + cell
        return u, _Line(flat).between(low, t, second)


class _Line:
    """Piecewise linear densities (k, n + 1) over 0 .. 1 with their running sums."""

    def __init__(self, density: np.ndarray):
        self.density = np.ascontiguousarray(density)
        self.cells = density.shape[1] - 1
        running = np.cumsum((self.density[:, 1:] + self.density[:, :-1]) / 2, axis=1)
        self.steps = [1 << k for k in reversed(range((self.cells - 1).bit_length()))]
        self.width = max(2 * sum(self.steps[:1]), self.cells) + 1
        self.running = np.full((len(density), self.width), _FAR)  # what no target reaches, up to a power of 2
        self.running[:, 0] = 0.0
        self.running[:, 1 : self.cells] = running[:, :-1]
        self.total = running[:, -1]

    def invert(self, row: np.ndarray, q: np.ndarray) -> np.ndarray:
        """Where the share ``q`` of the mass of line ``row`` is reached."""
        density, running = self.density.reshape(-1), self.running.reshape(-1)
        if len(self.density) == 1:
            target = q * self.total[0]
            cell = np.searchsorted(running[1 : self.cells], target, side="right")
            left, reached = cell, running[cell]
        else:
            target = q * self.total[row]
            at = row * self.width
            for step in self.steps:
                at += step * (running[at + step] <= target)
            reached = running[at]
            cell = at - row * self.width
            left = row * (self.cells + 1) + cell
        return (cell + _solve(target - reached, density[left], density[left + 1])) / self.cells

    def between(self, low: np.ndarray, t: np.ndarray, q: np.ndarray) -> np.ndarray:
        """The same on the line at ``t`` between lines ``low`` and ``low + 1``."""
        density, running = self.density.reshape(-1), self.running.reshape(-1)
        s, w = 1.0 - t, self.width
        target = q * (s * self.total[low] + t * self.total[low + 1])
        at = low * w
        for step in self.steps:
            there = at + step
            at += step * (s * running[there] + t * running[there + w] <= target)
        reached = s * running[at] + t * running[at + w]
        cell = at - low * w
        left = low * (self.cells + 1) + cell
        right = left + self.cells + 1
        start, end = s * density[left] + t * density[right], s * density[left + 1] + t * density[right + 1]
        return (cell + _solve(target - reached, start, end)) / self.cells


def _solve(mass: np.ndarray, start: np.ndarray, end: np.ndarray) -> np.ndarray:
    """x in 0 .. 1 with start * x + (end - start) * x ** 2 / 2 = mass, without cancellation."""
    root = np.sqrt(np.maximum(start * start + 2.0 * mass * (end - start), 0.0))
    return np.clip(2.0 * mass / np.maximum(start + root, 1e-300), 0.0, 1.0)


def solve_linear(q: np.ndarray, start: np.ndarray, end: np.ndarray) -> np.ndarray:
    """Where the share ``q`` of the mass of a density that runs straight from ``start`` to ``end`` is reached."""
    start, end = np.maximum(start, 0.0), np.maximum(end, 0.0)
    return _solve(q * (start + end) / 2, start, end)
