"""Objects that wear details: points of their surface, moved as the surface of a donor lies off its structure.

A point asks which element of a donor its own wears (``suits``). There, at the same (patch, u, v), the nearest bound point gives its
offset; on a primitive of another kind the place is found on a map of its box. All points of all objects are one query.
"""

from __future__ import annotations

from functools import cached_property
from typing import TYPE_CHECKING

import numpy as np

from ..geometry.frames import Frames
from ..geometry.nearest import Nearest
from ..geometry.pointset import PointSet
from ..geometry.vectors import dot
from ..records import dataclass
from .assign import TURN
from .elements import Elements, Solids
from .maps import Boxes, find_turns, on_map, turn_along
from .record import DIRECT, Details
from .suits import Suits

if TYPE_CHECKING:
    from ..runtime.batch import Batch

_APART = 10.0  # diagonals between the elements of donors: points of one are never near those of another
_REACH = 0.03  # diagonals: farther from any bound point the structure shows itself, or, where there are few,
_SEEN = 0.012  # diagonals: farther from what was seen of its element a place was not seen
_BEFORE = 0.06  # diagonals: so far from it what was seen of others may lie before it
_LOOSE = 1.5  # times the square root of their share
_ON_MAP = 0.35  # the same on a map
_THIN = 0.25  # of the least side of a primitive of another kind: offsets reach no farther into it, nor out of it, which would be barbs
_MOST = 4.0  # times: offsets grow no further; they shrink as far as their primitive does


@dataclass(frozen=True, slots=True, eq=False)
class Worn:
    """Points (P, n, 3) and unit normals at joint values 0; ``bound`` (P, n) the bound point of the details that each wears, -1 for none."""

    position: np.ndarray
    normal: np.ndarray
    bound: np.ndarray


class Wardrobe:
    """Details of donors with what is looked up in them. ``solids``: what the elements of their program are made of."""

    def __init__(self, details: Details, solids: Solids):
        self.details, self.solids = details, solids
        elements = details.elements
        self.frames = solids.frames(elements, details.element, details.patch, details.u, details.v)
        self.boxes = _boxes(solids, elements)
        self.kind = solids.kind(elements.site)
        own = details.diagonal[details.owner]
        many = np.bincount(details.owner, minlength=len(details.names))
        self._spacing = _LOOSE / np.sqrt(np.maximum(many, 1))
        self._reach = np.maximum(_REACH, self._spacing)
        self._tree = (
            Nearest(_features(self.frames.place, self.frames.normal, own), details.element, _APART)
            if len(details)
            else None
        )
        self._maps: Nearest | None = None

    @cached_property
    def _seen(self) -> tuple[np.ndarray, Nearest, Nearest]:
        """The bound points that were seen: of which element each is, all among those of their elements, and of their donors."""
        at = np.flatnonzero(self.details.how == DIRECT)
        element, elements = self.details.element[at], self.details.elements
        place, normal, owner = self.frames.place[at], self.frames.normal[at], elements.owner[element]
        size = self.details.diagonal[owner]
        outer = _features(elements.placed(element, place), elements.turned(element, normal), size)
        return element, Nearest(_features(place, normal, size), element, _APART), Nearest(outer, owner, _APART)

    def before(self, place: np.ndarray, normal: np.ndarray, element: np.ndarray) -> np.ndarray:
        """(m,) the element that was seen where places of elements, in their own frames, were hidden by it; -1 where none was."""
        out = np.full(len(element), -1)
        if self._tree is None:
            return out
        of, among, every = self._seen
        elements, donor = self.details.elements, self.details.elements.owner[element]
        size = self.details.diagonal[donor]
        own = among.find(_features(place, normal, size), element, _SEEN)[0]
        far = np.flatnonzero(own >= _SEEN)
        outer = elements.placed(element[far], place[far]), elements.turned(element[far], normal[far])
        found = every.find(_features(*outer, size[far]), donor[far], _BEFORE)[1]
        other = np.append(of, -1)[found]
        out[far] = np.where(other != element[far], other, -1)
        return out

    def has(self, place: np.ndarray, normal: np.ndarray, element: np.ndarray) -> np.ndarray:
        """(m,) whether there are bound points at places of elements, in their own frames: as near as points are to one another."""
        if self._tree is None:
            return np.zeros(len(element), dtype=bool)
        donor = self.details.elements.owner[element]
        near = np.maximum(_SEEN, self._spacing)
        apart, _ = self._tree.find(_features(place, normal, self.details.diagonal[donor]), element, float(near.max()))
        return np.asarray(apart < near[donor])

    def nearest(self, place: np.ndarray, normal: np.ndarray, element: np.ndarray) -> np.ndarray:
        """(m,) the bound point nearest to places of elements, in their own frames; -1 where none is near."""
        if self._tree is None:
            return np.full(len(element), -1)
        donor = self.details.elements.owner[element]
        diagonal = self.details.diagonal[donor]
        apart, found = self._tree.find(_features(place, normal, diagonal), element, float(self._reach.max()))
        return np.where(apart < self._reach[donor], found, -1)

    def on_map(self, local: np.ndarray, inward: np.ndarray, element: np.ndarray) -> np.ndarray:
        """The same for places (m, 3) within the boxes of elements, by their maps; ``inward``: what faces the middle of its box."""
        if self._tree is None:
            return np.full(len(element), -1)
        if self._maps is None:
            own = self.details.element
            boxes, (place, normal) = self.boxes.take(own), (self.frames.place, self.frames.normal)
            held = on_map(boxes.within(place), self._axis[own])
            self._maps = Nearest(held, 2 * own + boxes.inward(place, normal), _APART)
        apart, found = self._maps.find(on_map(local, self._axis[element]), 2 * element + inward, _ON_MAP)
        return np.where(apart < _ON_MAP, found, -1)

    @cached_property
    def _axis(self) -> np.ndarray:
        """(N,) about which axis the map of an element is a cylinder, -1 where it is a sphere."""
        return np.where(self.boxes.long, self.boxes.order[:, 0], -1)


def _boxes(solids: Solids, elements: Elements) -> Boxes:
    axes = elements.rotation.copy()
    axes[:, :, 1] *= elements.mirror[:, None]
    return Boxes(*solids.boxes(elements), axes)


def _features(place: np.ndarray, normal: np.ndarray, diagonal: np.ndarray) -> np.ndarray:
    """What two bound points are compared by: where they are, as a share of their object, and how they face."""
    return np.concatenate([place / diagonal[:, None], TURN * normal], axis=1)


def wear(
    batch: Batch, points: PointSet, owner: np.ndarray, wardrobe: Wardrobe, suits: Suits, strength: float = 1.0
) -> Worn:
    """Points (P, n) of the objects ``owner`` (P,) of a batch, in the details that ``suits`` of the same batch says. ``strength`` scales
    offsets, from 0, the structure, to 1."""
    whose = np.repeat(owner, points.u.shape[1])
    tables = batch.sites()
    site = points.site.ravel().astype(np.int64)
    first = np.cumsum([0, *(len(table) for table in tables)])
    rank = np.concatenate([np.empty(0, np.int64), *(table.rank for table in tables)])[first[site] + points.row.ravel()]
    element = suits.elements.find(whose, site, rank)
    match = suits.match[element]
    flat = _Flat(suits.elements, element, points.patch.ravel().astype(np.int64), points.u.ravel(), points.v.ravel())
    position, normal = points.position.reshape(-1, 3).copy(), points.normal.reshape(-1, 3).copy()
    bound = np.full(len(whose), -1)
    at = np.flatnonzero(match >= 0)
    if len(at):
        moved, turned, bound[at] = _clothed(wardrobe, flat.take(at), match[at], strength)
        good = at[bound[at] >= 0]
        kept = bound[at] >= 0
        position[good], normal[good] = moved[kept], turned[kept]
    shape = points.u.shape
    return Worn(position.reshape(*shape, 3), normal.reshape(*shape, 3), bound.reshape(shape))


@dataclass(frozen=True, slots=True, eq=False)
class _Flat:
    """m points of elements."""

    elements: Elements
    element: np.ndarray
    patch: np.ndarray
    u: np.ndarray
    v: np.ndarray

    def take(self, at: np.ndarray) -> _Flat:
        return _Flat(self.elements, self.element[at], self.patch[at], self.u[at], self.v[at])


def _clothed(
    wardrobe: Wardrobe, points: _Flat, match: np.ndarray, strength: float
) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Places and normals (m, 3) in the frames of the objects, and which bound point each wears (-1: none)."""
    here, offset, facing, bound = _found(wardrobe, points, match, strength)
    place = points.elements.placed(points.element, here.place + here.out_of(offset))
    bare = np.array([1.0, 0.0, 0.0])
    facing = facing * strength + bare * (1.0 - strength)
    turned = points.elements.turned(points.element, here.out_of(facing))
    length = np.sqrt(dot(turned, turned))[:, None]
    turned /= np.maximum(length, 1e-6)
    lost = np.flatnonzero(length[:, 0] <= 1e-6)
    turned[lost] = points.elements.turned(points.element[lost], here.normal[lost])
    return place, turned, bound


def find_offsets(
    wardrobe: Wardrobe,
    suits: Suits,
    element: np.ndarray,
    patch: np.ndarray,
    u: np.ndarray,
    v: np.ndarray,
    strength: float,
) -> tuple[np.ndarray, np.ndarray, np.ndarray, np.ndarray]:
    """For m places of the surface, on elements of ``suits``: how far each is moved (m, 3) metres, the normal there (m, 3), both in the
    frame of the object, whether anything is worn there (m,), and whether it lay behind another
    in the original that is worn here, too (m,)."""
    points = _Flat(suits.elements, element, patch, u, v)
    match = suits.match[element]
    here, offset, _, bound = _found(wardrobe, points, match, strength)
    at = np.flatnonzero((match >= 0) & (wardrobe.solids.kind(suits.elements.site)[element] == wardrobe.kind[match]))
    there = wardrobe.solids.frames(wardrobe.details.elements, match[at], patch[at], u[at], v[at])
    other = wardrobe.before(there.place, there.normal, match[at])
    behind = np.zeros(len(match), dtype=bool)
    owner, several = suits.elements.owner, len(wardrobe.details.elements)
    behind[at] = (other >= 0) & np.isin(owner[element[at]] * several + other, owner * several + suits.match)
    moved, normal = (suits.elements.turned(element, vectors) for vectors in (here.out_of(offset), here.normal))
    worn = (bound >= 0) & ~behind
    return np.where(worn[:, None], moved, 0.0), normal, worn, behind


def _found(
    wardrobe: Wardrobe, points: _Flat, match: np.ndarray, strength: float
) -> tuple[Frames, np.ndarray, np.ndarray, np.ndarray]:
    """Frames of m points, the offsets and facings (m, 3) that they wear by their parts, and which bound point each wears (-1: none)."""
    solids, details = wardrobe.solids, wardrobe.details
    here = solids.frames(points.elements, points.element, points.patch, points.u, points.v)
    boxes = _boxes(solids, points.elements)
    alike = solids.kind(points.elements.site)[points.element] == wardrobe.kind[match]
    bound = np.full(len(match), -1)
    scale = np.ones((len(match), 3))
    same, other = np.flatnonzero(alike & (match >= 0)), np.flatnonzero(~alike & (match >= 0))
    if len(same):
        part = points.take(same)
        there = solids.frames(details.elements, match[same], part.patch, part.u, part.v)
        bound[same] = wardrobe.nearest(there.place, there.normal, match[same])
        sizes = boxes.size[part.element], wardrobe.boxes.size[match[same]]
        scale[same] = _scales(here.normal[same], here.speed[same], there.speed, *sizes)
    if len(other):
        own, mine = points.element[other], match[other]
        pairs, which = np.unique(np.stack([own, mine]), axis=1, return_inverse=True)
        turns = find_turns(boxes.take(pairs[0]), wardrobe.boxes.take(pairs[1]))[which]
        place, normal = here.place[other], here.normal[other]
        local = _times(turns, boxes.take(own).within(place))
        bound[other] = wardrobe.on_map(local, boxes.take(own).inward(place, normal), mine)
        size = _times(np.abs(turns), boxes.size[own])
        scale[other] = (size / np.maximum(wardrobe.boxes.size[mine], 1e-9)).min(axis=1)[:, None]
    offset, facing = np.zeros((len(match), 3)), np.zeros((len(match), 3))
    worn = np.flatnonzero(bound >= 0)
    offset[worn], facing[worn] = details.offset[bound[worn]], details.facing[bound[worn]]
    if len(other) and len(details):
        offset, facing = _mapped(wardrobe, other, turns, here, bound, offset, facing)
    offset = offset * np.minimum(scale, _MOST)
    if len(other):
        offset[other] = _no_longer(offset[other], _THIN * boxes.size[points.element[other]].min(axis=1))
    return here, offset * strength, facing, bound


def _scales(normal: np.ndarray, speed: np.ndarray, before: np.ndarray, size: np.ndarray, old: np.ndarray) -> np.ndarray:
    """(m, 3) what offsets are scaled by along normal, tangent and second axis: aside as the patch has grown; outward as the least of what the
    patch and the box along the normal have, so that the relief of a rod that is only longer stays as deep as it was."""
    grown = speed / before
    square = normal * normal
    deep = (size / np.maximum(old, 1e-9) * square).sum(axis=1)
    return np.stack([np.minimum(deep, grown.min(axis=1)), grown[:, 0], grown[:, 1]], axis=-1)


def _mapped(
    wardrobe: Wardrobe,
    other: np.ndarray,
    turns: np.ndarray,
    here: Frames,
    bound: np.ndarray,
    offset: np.ndarray,
    facing: np.ndarray,
) -> tuple[np.ndarray, np.ndarray]:
    """Offsets and facings of which those of the points ``other``, whose primitives are of another kind, go with their boxes, as places do,
    and turn with the normals."""
    theirs, mine, back = _rows(wardrobe.frames, bound[other]), _rows(here, other), turns.transpose(0, 2, 1)
    normal = _times(back, theirs.normal)
    offset, facing = offset.copy(), facing.copy()
    for vectors in (offset, facing):
        way = _times(back, theirs.out_of(vectors[other]))
        vectors[other] = mine.into(turn_along(way, normal, mine.normal))
    return offset, facing


def _no_longer(vectors: np.ndarray, most: np.ndarray) -> np.ndarray:
    """Vectors (m, 3) that are at ``most`` (m,) long: longer ones are shortened."""
    length = np.sqrt(dot(vectors, vectors))
    return vectors * (most / np.maximum(np.maximum(length, most), 1e-12))[:, None]


def _times(matrices: np.ndarray, vectors: np.ndarray) -> np.ndarray:
    """(m, 3) products of matrices (m, 3, 3) and vectors (m, 3)."""
    return np.asarray((matrices * vectors[:, None]).sum(axis=2))


def _rows(frames: Frames, at: np.ndarray) -> Frames:
    return Frames(*(getattr(frames, name)[at] for name in Frames.__slots__))
