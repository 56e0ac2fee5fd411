"""Whether what is declared about a primitive agrees: box and inside function with the surfaces, convex pieces with the solid.

An author is told where they do not; the tests ask more of the primitives of the library (``tests/geometry/selftest.py``).
"""

from __future__ import annotations

from collections.abc import Callable, Iterator
from functools import cached_property
from typing import Any

import numpy as np

from .. import random
from ..graph.primitive import Primitive
from . import mesh, pieces, surface
from .box import bounds
from .patches import inside_split, surfaces
from .split import Params, rows_of
from .topology import place_in_words, value_in_words
from .trial import draw_trial
from .vectors import cross

ON_SURFACE = 1e-9  # how far the inside function may be from 0 on a surface, relative to the diagonal
_JUMP = 0.005  # of the distance to the solid
_LOOSE = 2e-3  # how much of its greatest side a box may exceed the mesh by
_WITHIN = 1e-6  # how far out of the solid a piece may reach, relative to the diagonal
_FILL = 0.5  # what pieces leave out may lie this deep, relative to the greatest depth: a quarter of a wall
_OPEN = 1000  # places that no piece covers, of which the furthest is sought
_FINE = 96  # steps per turn of the mesh that stands for the true shape
VOLUME = 4096  # places in the box
_PER_PLACE = 64  # of them for each place on a surface
_FEW, _COARSE = 1024, 24  # places and steps where faults that matter are looked for alone
_AT_ONCE = 8192  # places asked at a time, so that the terms stay in the caches

Report = Iterator[tuple[str, str | None, str]]
"""What does not agree (inside, normal, slope, box, area, volume, pieces), at which surface or piece if at one, and words."""


class Inspection:
    """What the checks share: places on the surfaces and in the boxes of the test values."""

    def __init__(self, primitive: Primitive, params: Params, each: int = VOLUME, steps: int = _FINE):
        self.primitive, self.params, self.each = primitive, params, each
        self.count = rows_of(params)
        self.low, self.high = bounds(primitive, params)
        self._split = inside_split(primitive)
        self._rows = self._split.rows(params)
        self.fine = mesh.build(primitive, params, steps)
        low, high = np.empty((self.count, 3)), np.empty((self.count, 3))
        for group in self.fine:
            low[group.rows], high[group.rows] = group.vertices.min(axis=1), group.vertices.max(axis=1)
        self.mesh_low, self.mesh_high = low, high
        self.diagonal = np.sqrt(((high - low) ** 2).sum(axis=1))

    @cached_property
    def areas(self) -> np.ndarray:
        """(rows, patches) by formula."""
        return surface.areas(self.primitive, self.params)

    def inside(self, row: np.ndarray, points: np.ndarray) -> np.ndarray:
        """(m,) the inside function of rows at points (m, 3)."""
        out = np.empty(len(row))
        for start in range(0, len(row), _AT_ONCE):
            part = slice(start, start + _AT_ONCE)
            out[part] = self._split.points([r[row[part]] for r in self._rows], *points[part].T)[0]
        return out

    def places(self, patch: int) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        """Rows (m,), positions and normals (m, 3) of places spread over one surface of all rows that have it."""
        row = np.repeat(np.flatnonzero(self.areas[:, patch] > 0), max(1, self.each // _PER_PLACE))
        first, second = self.numbers(f"surface {patch}", len(row))
        u, v = surface.place(self.primitive, patch, self.params, row, first, second)
        return row, *surface.evaluate(self.primitive, patch, self.params, row, u, v)

    def numbers(self, name: str, count: int) -> tuple[np.ndarray, np.ndarray]:
        return random.pair(random.key(0, "selftest", self.primitive.name, name), np.arange(count))

    @cached_property
    def in_boxes(self) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        """Rows (m,), places (m, 3) spread over boxes a tenth wider than those of the meshes, and the inside function there (m,)."""
        row = np.repeat(np.arange(self.count), self.each)
        x, y = self.numbers("volume", len(row))
        z, _ = self.numbers("height", len(row))
        fraction = np.stack([x, y, z], axis=-1) * 1.1 - 0.05
        points = self.mesh_low[row] + fraction * (self.mesh_high - self.mesh_low)[row]
        return row, points, self.inside(row, points)

    @cached_property
    def moments(self) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        """Volumes (rows,), centres (rows, 3) and inertias (rows, 3, 3) of the fine meshes."""
        volume, centre, inertia = np.empty(self.count), np.empty((self.count, 3)), np.empty((self.count, 3, 3))
        for group in self.fine:
            volume[group.rows], centre[group.rows], inertia[group.rows] = mesh.moments(group.vertices, group.faces)
        return volume, centre, inertia

    def at(self, row: int) -> str:
        """The test value of a row, for messages."""
        return value_in_words(self.primitive, self.params, row)


def slope_faults(seen: Inspection, most: float = 1e-6) -> Report:
    """The inside function is a length: it changes by no more than the distance, and outside by JUMP of itself more.

    A sweep of a section that is not round is measured from the nearest place of its path. Where two places are as near, far out in
    the hollow of a bend, the section may lie turned another way at each.
    """
    row, points, value = seen.in_boxes
    first, second = seen.numbers("direction", len(row))
    polar, around = np.arccos(2 * first - 1), 2 * np.pi * second
    direction = np.stack([np.sin(polar) * np.cos(around), np.sin(polar) * np.sin(around), np.cos(polar)], axis=-1)
    step = 1e-4 * seen.diagonal[row]
    change = np.abs(seen.inside(row, points + step[:, None] * direction) - value)
    change = (change - _JUMP * np.maximum(value, 0.0)) / step
    worst = int(np.argmax(change))
    if change[worst] > 1 + most:
        yield (
            "slope",
            None,
            f"the slope of the inside function reaches {change[worst]:.4g}, not 1 ({seen.at(row[worst])})",
        )


def box_faults(seen: Inspection, most: float = ON_SURFACE, wide: float = _LOOSE) -> Report:
    """The stated box is that of the mesh, which reaches out of it by ``most`` of its size, and it is ``wide`` beyond it at most."""
    size = (seen.mesh_high - seen.mesh_low).max(axis=1)
    for axis, name in enumerate("xyz"):
        flipped = seen.low[:, axis] >= seen.high[:, axis]
        if flipped.any():
            yield "box", None, f"the box is turned inside out along {name} ({seen.at(int(np.argmax(flipped)))})"
            continue
        ends: tuple[tuple[str, np.ndarray, Callable[..., Any]], ...] = (
            ("low", seen.low[:, axis] - seen.mesh_low[:, axis], np.argmin),
            ("high", seen.mesh_high[:, axis] - seen.high[:, axis], np.argmax),
        )
        for end, beyond, find in ends:
            out = beyond / size
            worst = int(np.argmax(np.abs(out)))
            if out.max() > most:
                worst = int(np.argmax(out))
                patch = _reaching(seen, worst, axis, find)
                yield (
                    "box",
                    patch,
                    f"it reaches {1000 * beyond[worst]:.4g} mm out of the box at {end} {name} ({seen.at(worst)})",
                )
            elif np.abs(out).max() > wide:
                yield (
                    "box",
                    None,
                    f"the box is {-1000 * beyond[worst]:.4g} mm too wide at {end} {name} ({seen.at(worst)})",
                )


def _reaching(seen: Inspection, row: int, axis: int, find: Callable[..., Any]) -> str:
    """The surface of the vertex that lies furthest out."""
    for group in seen.fine:
        at = np.flatnonzero(group.rows == row)
        if len(at):
            vertex = find(group.vertices[at[0], :, axis])
            face = int(np.argmax((group.faces == vertex).any(axis=1)))
            return surfaces(seen.primitive)[group.face_patch[face]].name
    raise AssertionError("every row has a mesh")


def fill_faults(seen: Inspection) -> Report:
    """The share of the box that the inside function fills is that of the mesh."""
    _, _, value = seen.in_boxes
    filled = (value < 0).reshape(seen.count, -1).mean(axis=1)
    box = np.prod(1.1 * (seen.mesh_high - seen.mesh_low), axis=1)
    expected = seen.moments[0]
    if (expected <= 0).any():
        yield (
            "volume",
            None,
            f"the surfaces enclose what is outside by the inside function ({seen.at(int(np.argmin(expected)))})",
        )
        return
    share = expected / box
    error = np.abs(filled - share) - 5 * np.sqrt(share * np.maximum(1 - share, 0) / seen.each) - 2e-3
    worst = int(np.argmax(error))
    if error[worst] > 0:
        shares = f"{100 * share[worst]:.3g} % of the space, the inside function {100 * filled[worst]:.3g} %"
        yield "volume", None, f"the mesh fills {shares} ({seen.at(worst)})"


def pieces_beyond(seen: Inspection, most: float = _WITHIN) -> Iterator[tuple[float, str, str]]:
    """How far the declared pieces reach out of the solid, as shares of its size above ``most``: each with its name, and in words."""
    groups = pieces.build(seen.primitive, seen.params)
    furthest: dict[str, tuple[float, int, str]] = {}  # per declared piece, the worst of all its indices
    asked = [_on_piece(group) for group in groups]
    whose = np.concatenate([np.repeat(group.rows, p.shape[1]) for group, p in zip(groups, asked, strict=True)])
    every = seen.inside(whose, np.concatenate([p.reshape(-1, 3) for p in asked])) / seen.diagonal[whose]
    begin = 0
    for group, points in zip(groups, asked, strict=True):
        out = every[begin : begin + points.shape[0] * points.shape[1]]
        begin += len(out)
        worst = int(np.argmax(out))
        declared = group.name.partition("[")[0]
        if out[worst] > max(most, furthest.get(declared, (0.0, 0, ""))[0]):
            furthest[declared] = (float(out[worst]), int(group.rows[worst // points.shape[1]]), group.name)
    for out_by, at, name in furthest.values():
        length = 1000 * out_by * seen.diagonal[at]
        yield out_by, name, f"this piece reaches {length:.4g} mm out of the solid ({seen.at(at)})"


def covered_places(seen: Inspection, groups: list[pieces.PieceGroup]) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Rows and places deep within the solid, and whether a piece covers them."""
    row, points = _deep(seen)
    covered = np.zeros(len(row), dtype=bool)
    for group in groups:
        slot = np.full(seen.count, -1)
        slot[group.rows] = np.arange(len(group.rows))
        low, high = np.full((seen.count, 3), np.inf), np.full((seen.count, 3), -np.inf)
        low[group.rows], high[group.rows] = group.vertices.min(axis=1), group.vertices.max(axis=1)
        open_ones = np.flatnonzero(~covered)
        near = (points[open_ones] >= low[row[open_ones]]) & (points[open_ones] <= high[row[open_ones]])
        asked = open_ones[near.all(axis=1)]
        corners = group.vertices[:, group.faces]
        normal = cross(corners[:, :, 1] - corners[:, :, 0], corners[:, :, 2] - corners[:, :, 0])
        reach = (normal * corners[:, :, 0]).sum(axis=-1)
        mine, (x, y, z) = slot[row[asked]], points[asked].T
        for face in range(len(group.faces)):
            (a, b, c), most = normal[:, face].T, reach[:, face] + 1e-15
            behind = a[mine] * x + b[mine] * y + c[mine] * z <= most[mine]
            asked, mine, x, y, z = asked[behind], mine[behind], x[behind], y[behind], z[behind]
        covered[asked] = True
    return row, points, covered


def find_box_fault(primitive: Primitive, wide: float) -> str | None:
    """Where, at a few test values, surfaces leave the stated box or it is ``wide`` of their size beyond them; None if nowhere."""
    return next(
        (words for _, _, words in box_faults(Inspection(primitive, draw_trial(primitive, 2)), _LOOSE, wide)), None
    )


def find_inside_fault(primitive: Primitive, steep: float) -> str | None:
    """Where, at a few test values, the inside function rises by ``steep`` more than the distance, or does not fill what the surfaces
    enclose; None if nowhere."""
    seen = Inspection(primitive, draw_trial(primitive, 2), _FEW, _COARSE)
    return next((words for _, _, words in (*slope_faults(seen, steep), *fill_faults(seen))), None)


def find_piece_beyond(primitive: Primitive, most: float) -> tuple[str, str] | None:
    """The piece that reaches furthest out of the solid at a few test values, by ``most`` of its size at least: its name, and in words."""
    seen = Inspection(primitive, draw_trial(primitive, 2), _FEW, _COARSE)
    found = max(pieces_beyond(seen, most), default=None)
    return None if found is None else found[1:]


def measure_missed(primitive: Primitive) -> tuple[float, str] | None:
    """How far (a share of its size) a place deep within a solid lies from all its convex pieces, at the worst of a few test
    values, and where; None where pieces cover it all.
    """
    seen = Inspection(primitive, draw_trial(primitive, 2))
    groups = pieces.build(primitive, seen.params)
    row, points, covered = covered_places(seen, groups)
    some = np.flatnonzero(~covered)
    some = some[:: 1 + len(some) // _OPEN]
    row, points = row[some], points[some]
    if not len(row):
        return None
    far = np.full(len(row), np.inf)
    for group in groups:
        slot = np.full(seen.count, -1)
        slot[group.rows] = np.arange(len(group.rows))
        there = np.flatnonzero(slot[row] >= 0)
        corners = group.vertices[:, group.faces][slot[row[there]]]
        normal = cross(corners[:, :, 1] - corners[:, :, 0], corners[:, :, 2] - corners[:, :, 0])
        normal = normal / np.maximum(np.sqrt((normal**2).sum(axis=-1, keepdims=True)), 1e-300)
        beyond = (normal * (points[there, None] - corners[:, :, 0])).sum(axis=-1).max(axis=1)
        far[there] = np.minimum(far[there], beyond)
    far = far / seen.diagonal[row]
    worst = int(np.argmax(far))
    return float(far[worst]), place_in_words(seen.primitive, seen.params, int(row[worst]), points[worst])


def _on_piece(group: pieces.PieceGroup) -> np.ndarray:
    """(k, n, 3): the corners of a piece, the middles of its faces and of their edges."""
    corners = group.vertices[:, group.faces]
    middle = (corners[:, :, 0] + corners[:, :, 1] + corners[:, :, 2]) / 3
    start, end, count = group.faces.ravel(), np.roll(group.faces, 1, axis=1).ravel(), group.vertices.shape[1]
    ends = np.unique(np.minimum(start, end) * count + np.maximum(start, end))  # an edge is that of two faces
    edges = (group.vertices[:, ends // count] + group.vertices[:, ends % count]) / 2
    return np.concatenate([group.vertices, middle, edges], axis=1)


def _deep(seen: Inspection) -> tuple[np.ndarray, np.ndarray]:
    """Rows and places that lie deeper than ``_FILL`` of the greatest depth, found from the box and below surfaces."""
    row, points, value = (of[::8] for of in seen.in_boxes)
    rows, places = [], []
    thickness = np.min(seen.mesh_high - seen.mesh_low, axis=1)
    for patch in range(seen.areas.shape[1]):
        own, position, normal = seen.places(patch)
        for fraction in (0.45, 0.2, 0.05, 0.02, 0.005):
            rows.append(own)
            places.append(position - fraction * thickness[own, None] * normal)
    below = np.concatenate(rows), np.concatenate(places)
    row, points = np.concatenate([row, below[0]]), np.concatenate([points, below[1]])
    depth = -np.concatenate([value, seen.inside(*below)])
    greatest = np.zeros(seen.count)
    np.maximum.at(greatest, row, depth)
    kept = depth > _FILL * greatest[row]
    return row[kept], points[kept]
