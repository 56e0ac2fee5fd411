"""Details of what was hidden in the original, by the symmetries of each primitive.

Nothing is known of a surface that another part hid, and a mutant may show it. Where a mirror image, a turn or a shift of its primitive
lies on surface that was seen, that lends its details. Which of these a real object follows is read off its own details: where both a
place and its image were seen, the offsets of one say how well they foretell those of the other. A patch takes an image only if that
foretells it better than the bare structure does, and of several the best. A patch that was all hidden says nothing: it takes an
image only if the whole primitive follows that well.

An image has to lie on the same primitive, with the same normal, so nothing need be known of its shape: a box has three mirrors, a
cylinder all turns, a prism all shifts, because points are found there.
"""

from __future__ import annotations

from itertools import product

import numpy as np
from scipy.spatial import cKDTree

from ..geometry.surface import areas, place
from ..geometry.vectors import dot
from ..records import dataclass
from .assign import TURN
from .elements import Elements, Solids
from .record import MIRRORED, SHIFTED, TURNED, Details

_TURNS = (90, 270, 45, 135, 225, 315)  # degrees; half a turn is two mirrors
_SHIFTS = (1, 2, 3, 4, 6)  # eighths of the box
_REACH = 0.02  # diagonals between an image and the bound point that stands for it
_LEAST = 8  # pairs of places, both of which were seen, that tell how well an image foretells
_BETTER = 0.8  # of the error of the bare structure: what an image may have
_MANY = 50  # pairs of two patches of a primitive, that tell of a patch that was all hidden, and
_SURE = 0.5  # what an image may then have
_AWAY = 0.03  # diagonals that an image has to be away for a pair to count: what is next to a place is like it anyway
_JUDGED = 4096  # bound points, at most, that images are judged by
_HIDDEN = 2.0  # distances between points: farther from what was seen is hidden
_ELSEWHERE = 10.0  # diagonals between elements


@dataclass(frozen=True, slots=True)
class _Image:
    """Takes the place x to ``turn @ x + shift * size`` of the box, about its centre."""

    turn: np.ndarray
    shift: np.ndarray
    how: int


def _images() -> list[_Image]:
    still = np.zeros(3)
    signs = sorted(product((1.0, -1.0), repeat=3), key=lambda s: (s.count(-1.0), s))[1:]
    found = [_Image(np.diag(s), still, MIRRORED) for s in signs]
    for axis, degrees in product(range(3), _TURNS):
        i, j = (axis + 1) % 3, (axis + 2) % 3
        turn = np.eye(3)
        turn[i, i] = turn[j, j] = np.cos(np.radians(degrees))
        turn[j, i] = np.sin(np.radians(degrees))
        turn[i, j] = -turn[j, i]
        found.append(_Image(turn, still, TURNED))
    for eighths, axis, sign in product(_SHIFTS, range(3), (1, -1)):
        found.append(_Image(np.eye(3), sign * eighths / 8 * np.eye(3)[axis], SHIFTED))
    return found


_IMAGES = _images()


def complete(details: Details, solids: Solids, seen: tuple[np.ndarray, ...], spacing: float) -> Details:
    """The details of one donor, with those of its hidden surface after them; ``seen``: element, patch, u, v (m,) of the structure that was
    visible, about ``spacing`` metres apart."""
    if not len(details):
        return details
    diagonal, elements = float(details.diagonal[0]), details.elements
    target = _surface(elements, solids, spacing)
    known = _Places.of(elements, solids, details.element, details.patch, details.u, details.v)
    visible, wanted = (_Places.of(elements, solids, *columns) for columns in (seen, target))
    covered = np.concatenate([known.features(diagonal), visible.features(diagonal)])
    apart = cKDTree(covered).query(wanted.features(diagonal), distance_upper_bound=_HIDDEN * spacing / diagonal)[0]
    hidden = np.flatnonzero(~np.isfinite(apart))
    target = tuple(column[hidden] for column in target)
    at, new = lend(details, solids, target)
    return details.extended(
        new | dict(zip(("element", "patch", "u", "v"), (column[at] for column in target), strict=True))
    )


def lend(details: Details, solids: Solids, target: tuple[np.ndarray, ...]) -> tuple[np.ndarray, dict[str, np.ndarray]]:
    """For places of the surface, element, patch, u, v (m,), which of them symmetries tell of (k,), and the columns ``offset``, ``facing``,
    ``label`` and ``how`` (k,) of their details."""
    elements, diagonal = details.elements, float(details.diagonal[0])
    lending = solids.frames(elements, details.element, details.patch, details.u, details.v)
    known = _Places.of(elements, solids, details.element, details.patch, details.u, details.v)
    wanted = _Places.of(elements, solids, *target)
    source, image = _sources(details, lending.out_of(details.offset), known, wanted, target[1], diagonal)
    at = np.flatnonzero(source >= 0)
    source, image = source[at], image[at]
    frames = solids.frames(elements, *(column[at] for column in target))
    back = np.stack([one.turn.T for one in _IMAGES])[image]
    offset, facing = (
        frames.into(_turned(back, lending.out_of(vectors)[source])) for vectors in (details.offset, details.facing)
    )
    how = np.array([one.how for one in _IMAGES])[image]
    return at, {"offset": offset, "facing": facing, "label": details.label[source], "how": how}


def _surface(elements: Elements, solids: Solids, spacing: float) -> tuple[np.ndarray, ...]:
    """Element, patch, u, v of points all over the surfaces of elements, hidden or not, one for each square of ``spacing``."""
    whole, real = np.zeros(0, dtype=np.int64), np.zeros(0)
    # nothing, if no two points tell how far they lie apart
    found: list[tuple[np.ndarray, ...]] = [(whole, whole, real, real)]
    kind = solids.kind(elements.site)
    for number in np.unique(kind).tolist():
        at = np.flatnonzero(kind == number)
        primitive, params = solids.primitives[number], dict(solids.params(elements, number, at))
        count = np.ceil(areas(primitive, params) / spacing**2).astype(np.int64)
        for patch in range(count.shape[1]):
            row = np.repeat(np.arange(len(at)), count[:, patch])
            if not len(row):
                continue
            rank = np.arange(len(row)) - np.searchsorted(row, row)
            first, second = ((0.5 + rank * step) % 1.0 for step in (0.7548776662466927, 0.5698402909980532))  # evenly
            u, v = place(primitive, patch, params, row, *(np.clip(x, 1e-9, 1 - 1e-9) for x in (first, second)))
            found.append(
                (at[row], np.full(len(row), patch), *(x.astype(np.float32).astype(np.float64) for x in (u, v)))
            )
    return tuple(np.concatenate(columns) for columns in zip(*found, strict=True))


@dataclass(frozen=True, slots=True, eq=False)
class _Places:
    """Points (m,) of elements: where they are and how they face, (m, 3) about the centres of their boxes, of ``size`` (m, 3)."""

    element: np.ndarray
    centred: np.ndarray
    normal: np.ndarray
    size: np.ndarray

    @staticmethod
    def of(
        elements: Elements, solids: Solids, element: np.ndarray, patch: np.ndarray, u: np.ndarray, v: np.ndarray
    ) -> _Places:
        low, high = solids.boxes(elements)
        frames = solids.frames(elements, element, patch, u, v)
        return _Places(element, frames.place - ((low + high) / 2)[element], frames.normal, (high - low)[element])

    def __len__(self) -> int:
        return len(self.element)

    def take(self, at: np.ndarray) -> _Places:
        return _Places(self.element[at], self.centred[at], self.normal[at], self.size[at])

    def seen_in(self, image: _Image) -> _Places:
        """Where an image takes them."""
        turn = image.turn[None]
        centred = _turned(turn, self.centred) + image.shift * self.size
        return _Places(self.element, centred, _turned(turn, self.normal), self.size)

    def features(self, diagonal: float) -> np.ndarray:
        """(m, 7) what two points are compared by: their places in diagonals, how they face, and their elements."""
        return np.concatenate([self.centred / diagonal, TURN * self.normal, _ELSEWHERE * self.element[:, None]], axis=1)


def _turned(matrix: np.ndarray, vectors: np.ndarray) -> np.ndarray:
    """Vectors (m, 3) turned by matrices (m, 3, 3) or (1, 3, 3)."""
    cells = [
        matrix[:, k, 0] * vectors[:, 0] + matrix[:, k, 1] * vectors[:, 1] + matrix[:, k, 2] * vectors[:, 2]
        for k in range(3)
    ]
    return np.stack(cells, axis=-1)


def _sources(
    details: Details, offset: np.ndarray, known: _Places, wanted: _Places, patch: np.ndarray, diagonal: float
) -> tuple[np.ndarray, np.ndarray]:
    """For places that want details (m,) the bound point that lends its own, -1 for none, and the image that it is seen in.

    ``offset`` (E, 3) of the bound points in the frames of their elements, ``patch`` (m,) of the places."""
    tree = cKDTree(known.features(diagonal))
    patches = int(max(details.patch.max(), patch.max(initial=0))) + 1
    cell, asked = details.element * patches + details.patch, wanted.element * patches + patch
    judges = np.arange(len(known))[:: -(-len(known) // _JUDGED)]
    source, image, best = np.full(len(wanted), -1), np.full(len(wanted), -1), np.full(len(wanted), np.inf)
    for number, one in enumerate(_IMAGES):
        error = _errors(one, tree, known, offset, judges, (cell, len(details.elements) * patches, patches), diagonal)
        some = np.flatnonzero(error[asked] < best)
        apart, found = tree.query(wanted.take(some).seen_in(one).features(diagonal), distance_upper_bound=_REACH)
        good = np.isfinite(apart)
        source[some[good]], image[some[good]], best[some[good]] = found[good], number, error[asked][some[good]]
    return source, image


def _errors(
    image: _Image,
    tree: cKDTree,
    known: _Places,
    offset: np.ndarray,
    judges: np.ndarray,
    cells: tuple[np.ndarray, int, int],
    diagonal: float,
) -> np.ndarray:
    """(C,) for each cell, a patch of an element, how much of the offsets of its points an image leaves, inf where it is not to be taken.

    ``cells``: that of each bound point, how many there are, how many of an element."""
    cell, several, patches = cells
    there = known.take(judges)
    seen = there.seen_in(image)
    way = (seen.centred - there.centred) / diagonal
    judges = judges[dot(way, way) > _AWAY**2]
    apart, found = tree.query(known.take(judges).seen_in(image).features(diagonal), distance_upper_bound=_REACH)
    judges, found = judges[np.isfinite(apart)], found[np.isfinite(apart)]
    way = offset[judges] - _turned(image.turn.T[None], offset[found])
    error, bare = np.sqrt(dot(way, way)), np.sqrt(dot(offset[judges], offset[judges]))
    other = cell[judges] != cell[found]

    def totals(at: np.ndarray) -> np.ndarray:
        return np.stack([np.bincount(cell[judges[at]], x, several) for x in (error[at], bare[at], None)])

    own, across = totals(np.arange(len(judges))), totals(np.flatnonzero(other))
    across = np.repeat(across.reshape(3, -1, patches).sum(axis=2), patches, axis=1)  # of all patches of the element
    share, alike = (each[0] / np.maximum(each[1], 1e-12) for each in (own, across))
    told = np.where((own[2] >= _LEAST) & (share < _BETTER), share, np.inf)
    unseen = (own[2] < _LEAST) & (across[2] >= _MANY) & (alike < _SURE)
    return np.where(unseen, 1.0 + alike, told)
