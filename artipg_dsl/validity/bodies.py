"""The convex pieces of a batch, placed at rest and sorted by link, and what joints make of them.

Pieces are inset by half the depth that counts, so that what touches does not meet. They lie in arrays by their number
of corners; a piece that moves is the piece at rest with a turn and a shift, or the hull of its two ends.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from ..geometry.collide import DEPTH, inset
from ..geometry.pieces import Cloud
from ..geometry.runs import distinct, runs
from ..geometry.sites import scatter
from ..geometry.vectors import cross, dot, extent
from ..native import turning as native
from ..native.backend import machine as compiled
from ..native.narrow import Side
from ..records import dataclass
from ..runtime.batch import Batch
from ..runtime.motion import apply
from .meant import same_elements

EXACT = 1 - 1e-6  # of the distance: how well it is known where a gap is asked for
FULL = 2 * np.pi
_KEPT = 1 << 27  # bytes of corners, as much as is kept with a batch


@dataclass(slots=True, eq=False)
class Pieces:
    """N pieces sorted by link (links by object): corners by class and slot, box, object, link (a row of the link table).

    ``corners`` holds (n, P, 3) per class, P a power of two; a piece with fewer corners repeats its last. ``shape`` is
    the index of its faces in ``faces``, or of the cloud that it is the piece ``place`` of and that finds them. ``solid`` is
    the row of its primitive in the tables of sites, one after the other. Only pieces that come near others get faces and
    are inset, in place, by ``ready``; ``done`` tells which, by class and slot. ``source`` tells where a piece stood before it
    was sorted, ``met`` which pieces have been found to meet another.
    """

    corners: list[np.ndarray]
    faces: list[np.ndarray | Cloud]
    done: list[np.ndarray]
    kind: np.ndarray
    slot: np.ndarray
    low: np.ndarray
    high: np.ndarray
    owner: np.ndarray
    link: np.ndarray
    shape: np.ndarray
    place: np.ndarray
    solid: np.ndarray
    met: np.ndarray
    source: np.ndarray
    # metres: two that are nearer than the less of theirs meet; boxes are larger by half of it
    gap: np.ndarray | None = None
    side: np.ndarray | None = None  # 1, 2 or 3, of two sides: pieces of one meet only those of the other
    # (N, R) elements of repeats: pieces of one side meet those of the other in the same ones
    group: np.ndarray | None = None

    def __len__(self) -> int:
        return len(self.owner)

    def fresh(self) -> Pieces:
        """The same with corners of its own, to be inset and blamed apart from these."""
        return replace(
            self,
            corners=[corners.copy() for corners in self.corners],
            done=[known.copy() for known in self.done],
            met=self.met.copy(),
        )

    def part(self, rows: slice | np.ndarray) -> Pieces:
        """Some of the pieces; they share the corners."""
        names = ("kind", "slot", "low", "high", "owner", "link", "shape", "place", "solid", "met", "source")
        columns = (getattr(self, name)[rows] for name in names)
        found = Pieces(self.corners, self.faces, self.done, *columns)
        found.gap, found.side, found.group = (
            None if column is None else column[rows] for column in (self.gap, self.side, self.group)
        )
        return found

    def opposed(self, i: np.ndarray, j: np.ndarray) -> np.ndarray:
        """Which pairs of pieces are asked whether they meet: of two sides, where there are any, those of one group."""
        if self.side is None:
            return np.ones(len(i), dtype=bool)
        one, two = self.side[i], self.side[j]
        keep: np.ndarray = ((one & 1) * (two >> 1)) | ((one >> 1) * (two & 1)) > 0
        keep &= (self.link[i] != self.link[j]) | (self.solid[i] < self.solid[j])
        if self.group is not None:
            keep &= same_elements(self.group[i], self.group[j])
        return keep

    def apart(self, i: np.ndarray, j: np.ndarray) -> np.ndarray | None:
        """How far (k,) pairs of pieces have to be from one another, metres; None where they may touch."""
        return None if self.gap is None else np.minimum(self.gap[i], self.gap[j])

    def boxes(self, turn: np.ndarray | None = None, chosen: np.ndarray | None = None) -> Pieces:
        """The boxes of the pieces at rest in place of the pieces; with the turns (L, 3, 3) of the links from joint values 0
        to rest, boxes along the axes that the links had there, right for the pieces ``chosen`` alone."""
        ends = np.stack([self.low, self.high], axis=1)  # (N, 2, 3)
        if turn is None or chosen is None:
            return self._boxed(_corners_of(ends))
        ends[chosen] = self._ends(turn, chosen)
        corners = _corners_of(ends)
        corners[chosen] = turn_points(turn[self.link[chosen]], corners[chosen])
        return self._boxed(corners)

    def boxes_of_groups(self, turn: np.ndarray, chosen: np.ndarray, members: np.ndarray, begin: np.ndarray) -> Pieces:
        """The same boxes of the pieces ``chosen``, and after all pieces one about each group of ``members``, pieces of one link;
        ``begin`` tells where in ``members`` each group begins."""
        alone, link = self.boxes(turn, chosen), self.link[members[begin]]
        ends = self._ends(turn, members)
        ends = np.stack([np.minimum.reduceat(ends[:, 0], begin), np.maximum.reduceat(ends[:, 1], begin)], axis=1)
        corners = np.concatenate([alone.corners[0], turn_points(turn[link], _corners_of(ends))])
        found = self._boxed(corners)
        found.low, found.high = extent(corners)
        found.link = np.append(self.link, link)
        return found

    def _ends(self, turn: np.ndarray, chosen: np.ndarray) -> np.ndarray:
        """Low and high ends (k, 2, 3) of pieces along the axes that their links had at joint values 0."""
        back, ends = turn[self.link[chosen]].transpose(0, 2, 1), np.empty((len(chosen), 2, 3))
        for at, corners in self.classes(chosen):
            straight = turn_points(back[at], corners)
            half = 0.0 if self.gap is None else self.gap[chosen[at], None] / 2
            low, high = extent(straight)
            ends[at] = np.stack([low - half, high + half], axis=1)
        return ends

    def _boxed(self, corners: np.ndarray) -> Pieces:
        count, corners = len(corners), np.ascontiguousarray(corners)  # once, for all who ask for pairs of them
        return replace(self, corners=[corners], kind=np.zeros(count, dtype=np.int64), slot=np.arange(count), gap=None)

    def ready(self, *chosen: np.ndarray) -> None:
        """Inset the pieces of some numbers (repeated ones too)."""
        piece = np.zeros(len(self), dtype=bool)
        for rows in chosen:
            piece[rows] = True
        for number, known in enumerate(self.done):
            at = np.flatnonzero(piece & (self.kind == number))
            piece[at] = ~known[self.slot[at]]
            known[self.slot[at]] = True
        rows = np.flatnonzero(piece)
        rows = rows[np.argsort(self.shape[rows], kind="stable")]
        alike: dict[tuple[int, int], list[tuple[np.ndarray, np.ndarray, np.ndarray]]] = {}
        for group in np.split(rows, np.flatnonzero(np.diff(self.shape[rows])) + 1) if len(rows) else ():
            kind = int(self.kind[group[0]])
            for own, used, faces in self._with_faces(group):
                alike.setdefault((kind, id(faces)), []).append((own, used, faces))
        blocks, firsts, triangles, begin = [], [], [], 0
        places = []
        for (kind, _), parts in alike.items():
            _, used, faces = parts[0]
            slot = self.slot[np.concatenate([own for own, _, _ in parts])]
            first = begin + len(used) * np.arange(len(slot))
            blocks.append(self.corners[kind][slot[:, None], used].reshape(-1, 3))
            firsts.append(first)
            triangles.append((first[:, None, None] + faces).reshape(-1, 3))
            places.append((kind, slot, len(used)))
            begin += len(used) * len(slot)
        if not places:
            return
        moved = inset(np.concatenate(blocks), np.concatenate(firsts), np.concatenate(triangles))
        for (kind, slot, many), first in zip(places, firsts, strict=True):
            corners, own = self.corners[kind], moved[first[0] : first[0] + many * len(slot)].reshape(-1, many, 3)
            corners[slot, :many] = own
            corners[slot, many:] = own[:, -1:]

    def _with_faces(self, group: np.ndarray) -> list[tuple[np.ndarray, np.ndarray, np.ndarray]]:
        """Pieces of one shape by their faces: (pieces, which of their points are corners, faces)."""
        shape = self.faces[self.shape[group[0]]]
        if isinstance(shape, Cloud):
            return [(group[at], hull.used, hull.told) for at, hull in shape.fitted(self.place[group])]
        return [(group, np.arange(int(shape.max()) + 1), shape)]

    def classes(self, piece: np.ndarray) -> list[tuple[np.ndarray, np.ndarray]]:
        """(positions within ``piece``, their corners (m, P, 3)) for each class that occurs."""
        kind = self.kind[piece]
        found = []
        for number, corners in enumerate(self.corners):
            at = np.flatnonzero(kind == number)
            if len(at):
                found.append((at, corners[self.slot[piece[at]]]))
        return found


@dataclass(slots=True, eq=False)
class Placed:
    """Pieces ``piece`` (k,), each with a turn and a shift from rest, or swept between two shifts (``ends``)."""

    pieces: Pieces
    piece: np.ndarray
    turn: np.ndarray | None = None
    shift: np.ndarray | None = None
    ends: tuple[np.ndarray, np.ndarray] | None = None

    def __len__(self) -> int:
        return len(self.piece)

    def at(self, rows: np.ndarray) -> Placed:
        """Some of them."""
        turn, shift = (None if column is None else column[rows] for column in (self.turn, self.shift))
        ends = None if self.ends is None else (self.ends[0][rows], self.ends[1][rows])
        return Placed(self.pieces, self.piece[rows], turn, shift, ends)

    def center(self) -> np.ndarray:
        middle = (self.pieces.low[self.piece] + self.pieces.high[self.piece]) / 2
        if self.ends is not None:
            return middle + (self.ends[0] + self.ends[1]) / 2
        if self.turn is None or self.shift is None:
            return middle
        return apply(self.turn, middle) + self.shift

    def support(self, rows: np.ndarray, direction: np.ndarray) -> np.ndarray:
        own = direction if self.turn is None else apply(self.turn[rows].transpose(0, 2, 1), direction)
        found = np.empty((len(rows), 3))
        for at, corners in self.pieces.classes(self.piece[rows]):
            best = np.argmax(dot(corners, own[at, None]), axis=1)
            found[at] = corners[np.arange(len(at)), best]
        if self.ends is not None:
            first, last = self.ends[0][rows], self.ends[1][rows]
            return found + np.where((dot(first, own) >= dot(last, own))[:, None], first, last)
        if self.turn is None or self.shift is None:
            return found
        return apply(self.turn[rows], found) + self.shift[rows]

    def side(self) -> Side:
        kind, slot = self.pieces.kind[self.piece], self.pieces.slot[self.piece]
        return Side(self.pieces.corners, kind, slot, self.turn, self.shift, self.ends)


@dataclass(frozen=True, slots=True, eq=False)
class Alike:
    """Convex pieces with common faces (F, 3), or pieces ``place`` (k,) of a cloud: corners (k, P, 3) at rest, object and link
    (a row of the link table) of each."""

    corners: np.ndarray
    faces: np.ndarray | Cloud
    owner: np.ndarray
    link: np.ndarray
    solid: np.ndarray | None = None  # rows of their primitives in the tables of sites, one after the other
    place: np.ndarray | None = None


def gather(batch: Batch, first: np.ndarray, turn: np.ndarray, shift: np.ndarray) -> Pieces:
    """All pieces of a batch; ``first`` (B,) is each object's first link, ``turn`` and ``shift`` carry links to rest.

    What was gathered last is kept with the batch: the check, the ends of joints and the gripper want the same.
    """
    known = batch.known.get("pieces")
    if known is None or not (np.array_equal(known[0], turn) and np.array_equal(known[1], shift)):
        made = _gathered(batch, first, turn, shift)
        if sum(corners.nbytes for corners in made.corners) > _KEPT:
            return made
        known = batch.known["pieces"] = turn, shift, made
    kept: Pieces = known[2]
    return kept.fresh()


def _gathered(batch: Batch, first: np.ndarray, turn: np.ndarray, shift: np.ndarray) -> Pieces:
    tables = batch.sites()
    scatter(tables)
    offset = np.cumsum([0, *(len(table) for table in tables)]).tolist()
    groups = [
        (points, faces, rows + start, place)
        for table, start in zip(tables, offset, strict=False)
        for cloud in table.clouds
        for points, faces, rows, place in _unplaced(cloud)
    ]
    if not groups:
        return pack_pieces([])
    owner, link, mirror = (np.concatenate([getattr(t, name) for t in tables]) for name in ("owner", "link", "mirror"))
    link = first[owner] + link
    rotation, translation = (np.concatenate([getattr(t, name) for t in tables]) for name in ("rotation", "translation"))
    found: list[Alike | None] = [None] * len(groups)
    corners = np.array([points.shape[1] for points, *_ in groups])
    for count in distinct(corners):  # those with as many corners are placed together
        alike = np.flatnonzero(corners == count).tolist()
        rows = np.concatenate([groups[k][2] for k in alike])
        sign = np.stack([np.ones(len(rows)), mirror[rows], np.ones(len(rows))], axis=-1)
        placed = np.concatenate([groups[k][0] for k in alike]) * sign[:, None]
        placed = turn_points(rotation[rows], placed, translation[rows])
        placed = turn_points(turn[link[rows]], placed, shift[link[rows]])
        stop = 0
        for k in alike:
            _, faces, at, place = groups[k]
            start, stop = stop, stop + len(at)
            found[k] = Alike(placed[start:stop], faces, owner[at], link[at], at, place)
    return pack_pieces([group for group in found if group is not None])


def _unplaced(cloud: Cloud) -> list[tuple[np.ndarray, np.ndarray | Cloud, np.ndarray, np.ndarray | None]]:
    """Pieces in their own frames: (corners, faces or the cloud that finds them, rows, places in the cloud). Faces are found at
    once where not all points may be corners, or some are no numbers, which is refused."""
    later = cloud.settled() & bool(np.isfinite(cloud.points).all())
    found: list[tuple[np.ndarray, np.ndarray | Cloud, np.ndarray, np.ndarray | None]] = []
    if later.any():
        place = np.flatnonzero(later)
        found.append((cloud.points[place], cloud, cloud.rows[place], place))
    if not later.all():
        groups = cloud.at(np.flatnonzero(~later)).groups()
        found += [(group.vertices, group.faces, group.rows, None) for group in groups]
    return found


def pack_pieces(groups: list[Alike]) -> Pieces:
    """Pieces group by group, sorted by link."""
    alike: dict[int, int] = {}  # by the identity of their faces: what has the same is inset together
    shapes = [alike.setdefault(id(group.faces), len(alike)) for group in groups]
    counts = np.array([len(group.owner) for group in groups], dtype=np.int64)
    given = np.array([group.corners.shape[1] for group in groups], dtype=np.int64)
    wide = np.array([max(8, 1 << (n - 1).bit_length()) for n in given.tolist()], dtype=np.int64)
    if not groups:
        none, flags = np.zeros(0, dtype=np.int64), np.zeros(0, dtype=bool)
        return Pieces(
            [], [], [], none, none, np.zeros((0, 3)), np.zeros((0, 3)), none, none, none, none, none, flags, none
        )
    sizes, corners, begin = distinct(wide), [], np.zeros(len(groups), dtype=np.int64)
    for size in sizes:
        same = np.flatnonzero(wide == size)
        begin[same] = np.cumsum(counts[same]) - counts[same]
        points = np.empty((int(counts[same].sum()), int(size), 3))
        for count in distinct(given[same]):
            mine = same[given[same] == count]
            own = np.concatenate([groups[k].corners for k in mine.tolist()])
            _, at = enumerate_ranges(begin[mine], counts[mine])
            points[at, :count], points[at, count:] = own, own[:, -1:]
        corners.append(points)
    owner, link = (np.concatenate([getattr(group, name) for group in groups]) for name in ("owner", "link"))
    slot, kind = enumerate_ranges(begin, counts)[1], np.repeat(np.searchsorted(sizes, wide), counts)
    low, high = np.empty((len(owner), 3)), np.empty((len(owner), 3))
    for number, points in enumerate(corners):
        at = kind == number
        low[at], high[at] = (end[slot[at]] for end in extent(points))
    order = np.argsort(link, kind="stable")
    solid, place = (
        np.concatenate([np.full(len(g.owner), -1) if getattr(g, name) is None else getattr(g, name) for g in groups])
        for name in ("solid", "place")
    )
    shape, met, source = np.repeat(shapes, counts), np.zeros(len(owner), dtype=bool), np.arange(len(owner))
    columns = (kind, slot, low + DEPTH / 2, high - DEPTH / 2, owner, link, shape, place, solid, met, source)
    done = [np.zeros(len(points), dtype=bool) for points in corners]
    faces = list({id(group.faces): group.faces for group in groups}.values())  # in the order of ``alike``
    return Pieces(corners, faces, done, *(column[order] for column in columns))


def pack_inset(corners: np.ndarray, first: np.ndarray, owner: np.ndarray, link: np.ndarray) -> Pieces:
    """Pieces that are inset already, sorted by link: their corners (N, 3) at rest follow one another, ``first`` (k,) tells where each
    begins; object and link (a row of the link table) of each."""
    order = np.argsort(link, kind="stable")
    count = np.diff(first, append=len(corners))[order]
    first, owner, link = first[order], owner[order], link[order]
    wide = 1 << np.ceil(np.log2(np.maximum(count, 8))).astype(np.int64)
    sizes, kind = np.unique(wide, return_inverse=True)
    none, slot, low, high = np.zeros(len(order), dtype=np.int64), np.empty_like(order), *np.empty((2, len(order), 3))
    packed = []
    for number, size in enumerate(sizes.tolist()):
        at = np.flatnonzero(kind == number)
        own = corners.take(first[at, None] + np.minimum(np.arange(size), count[at, None] - 1), axis=0)
        slot[at], (low[at], high[at]) = np.arange(len(at)), extent(own)
        packed.append(own)
    done = [np.ones(len(own), dtype=bool) for own in packed]
    unmet = np.zeros(len(order), dtype=bool)
    return Pieces(packed, [], done, kind, slot, low, high, owner, link, none, none - 1, none - 1, unmet, order)


def _corners_of(ends: np.ndarray) -> np.ndarray:
    """The corners (k, 8, 3) of boxes with ends (k, 2, 3)."""
    pick = np.array([[i, j, k] for i in (0, 1) for j in (0, 1) for k in (0, 1)])
    return np.stack([ends[:, pick[:, axis], axis] for axis in range(3)], axis=-1)


def enumerate_ranges(first: np.ndarray, count: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """(index, value): the values ``first .. first + count - 1`` of each index."""
    count = np.maximum(count, 0)
    return np.repeat(np.arange(len(first)), count), runs(first, count)


def boxes_meet(
    i: np.ndarray, j: np.ndarray, low: np.ndarray, high: np.ndarray, lows: np.ndarray, highs: np.ndarray
) -> np.ndarray:
    """The places of the pairs (i, j) whose boxes overlap."""
    rows = np.arange(len(i))
    for one, two, ones, twos in zip(*(np.ascontiguousarray(end.T) for end in (low, high, lows, highs)), strict=True):
        close = (one[i] < twos[j]) & (ones[j] < two[i])
        rows, i, j = rows[close], i[close], j[close]
    return rows


def link_boxes(body: Pieces, links: int) -> tuple[np.ndarray, np.ndarray, np.ndarray, np.ndarray]:
    """Box (L, 3) and range of pieces of every link; those without pieces here have none."""
    begin, end = (np.searchsorted(body.link, np.arange(links), side=side) for side in ("left", "right"))
    low, high = np.full((links, 3), np.inf), np.full((links, 3), -np.inf)
    full = np.flatnonzero(end > begin)
    if len(full):
        low[full], high[full] = np.minimum.reduceat(body.low, begin[full]), np.maximum.reduceat(body.high, begin[full])
    return low, high, begin, end


def turn_points(rotation: np.ndarray, points: np.ndarray, shift: np.ndarray | None = None) -> np.ndarray:
    """Matrices (k, 3, 3) times points (k, P, 3), written out, and shifts (k, 3) after them."""
    machine = compiled()
    if machine is not None:
        return native.turn_points(machine, rotation, points, shift)
    r = rotation[:, None]
    cells = [r[..., i, 0] * points[..., 0] for i in range(3)]
    for i, cell in enumerate(cells):
        cell += r[..., i, 1] * points[..., 1]
        cell += r[..., i, 2] * points[..., 2]
        if shift is not None:
            cell += shift[:, None, i]
    return np.stack(cells, axis=-1)


def swept_extent(
    moved: Placed, axis: np.ndarray, origin: np.ndarray, half: np.ndarray, direction: np.ndarray
) -> np.ndarray:
    """How far (k,) placed pieces reach along ``direction`` (k, 3) while they turn by up to ``half`` (k,) either way.

    Exact for the corners: each runs along an arc.
    """
    assert moved.turn is not None and moved.shift is not None
    machine = compiled()
    if machine is not None:
        return native.sweep(machine, moved.side(), axis, origin, half, direction)
    found = np.empty(len(moved))
    along = dot(axis, direction)
    flat = direction - axis * along[:, None]
    side = cross(flat, axis)
    for at, corners in moved.pieces.classes(moved.piece):
        local = turn_points(moved.turn[at], corners, (moved.shift - origin)[at])
        c, s = dot(local, flat[at, None]), np.abs(dot(local, side[at, None]))
        w = half[at, None]
        radius = np.sqrt(c * c + s * s)
        reach = np.where(c >= radius * np.cos(w), radius, c * np.cos(w) + s * np.sin(w))
        found[at] = (along[at, None] * dot(local, axis[at, None]) + reach).max(axis=1)
    return found + dot(origin, direction)
