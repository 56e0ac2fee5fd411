"""Do two links ever meet, whatever the joints between them do? ``clearance all`` and ``clear a from b by d all``.

The joints that matter to two links are those on the way from either up to the nearest link that carries both. A *cell* is
two pieces and an interval of each of these joints. In its middle a plane that keeps the pieces apart is looked for and
proved for the whole cell: every corner runs along an arc or a line. What is not proved is halved, where it loses most,
until it is decided, or nothing in it moves by more than a tenth of a millimetre, which counts as a meeting.

Joints that go on as far as nothing is in the way share what there is: each cell has a share of their ways at which it
begins, and the least share at which anything meets is how far all of them go that have a part in it.
"""

from __future__ import annotations

import numpy as np

from ..geometry.runs import distinct
from ..geometry.vectors import dot
from ..records import dataclass
from ..runtime.motion import apply, rotation_about
from .bodies import FULL, Pieces, enumerate_ranges, link_boxes
from .cells import add_columns, examine_cells
from .tree import Tree

_ROUNDS = 60  # halvings of a cell, of all its joints together
_LOSS = 1e-4  # metres: cells in which corners move by less and that are not proved free count as meeting
_TIE = 1e-3  # of what a joint moves, where nothing tells which one matters
_NEAR = 2e-4  # of a way: how well shares are known
_SLICES = 16  # of a turn, for boxes
_MOST = 4_000  # cells of two links; what is left beyond counts as meeting


Boxes = tuple[np.ndarray, np.ndarray]
"""Low and high corners, (k, 3) each."""


@dataclass(slots=True, eq=False)
class Ways:
    """Pairs of links (k,) and the joints between them (k, C), -1 for none: those of the first from the innermost on, in the
    first half of the columns, those of the second in the other half."""

    first: np.ndarray
    second: np.ndarray
    joint: np.ndarray
    levels: tuple[np.ndarray, np.ndarray]  # how many links up the nearest is that carries both

    def at(self, rows: np.ndarray) -> Ways:
        levels = self.levels[0][rows], self.levels[1][rows]
        return Ways(self.first[rows], self.second[rows], self.joint[rows], levels)


def list_ways(tree: Tree) -> Ways:
    """All pairs of links of the objects of a batch, each once."""
    count, depth = len(tree.links.owner), tree.chain.shape[1]
    first, second = enumerate_ranges(np.arange(count) + 1, tree.start[tree.links.owner + 1] - np.arange(count) - 1)
    same = (tree.chain[first][:, :, None] == tree.chain[second][:, None, :]) & (tree.chain[first] >= 0)[:, :, None]
    one = np.argmax(same.any(axis=2), axis=1)
    two = np.argmax(same[np.arange(len(first)), one], axis=1) if len(first) else one
    columns = []
    moves = np.append(tree.joints.that(), False)
    for link, level in ((first, one), (second, two)):
        joint = np.where(np.arange(depth) < level[:, None], tree.joint[tree.chain[link]], -1)
        columns.append(np.where(moves[joint], joint, -1))
    return Ways(first, second, np.concatenate(columns, axis=1), (one, two))


@dataclass(frozen=True, slots=True, eq=False)
class Meeting:
    """Pieces that meet: of pairs of links ``row`` (k,), with the joints between them at ``value`` (k, C), less their rest values."""

    row: np.ndarray
    piece: np.ndarray
    other: np.ndarray
    value: np.ndarray


@dataclass(slots=True, eq=False)
class _Reach:
    """Boxes of things (k,) swept by the joints above them, (levels + 1, k, 3): by none, by the innermost, ...; and how far
    from the axis of each joint they reach (levels, k)."""

    low: np.ndarray
    high: np.ndarray
    radius: np.ndarray

    def boxes(self, level: np.ndarray, at: np.ndarray) -> Boxes:
        """Of things ``at`` (m,), each swept as far up as told."""
        return self.low[level, at], self.high[level, at]


def _reach(tree: Tree, link: np.ndarray, low: np.ndarray, high: np.ndarray) -> _Reach:
    """Of the boxes of things on links (k,), at rest."""
    lows, highs, radii = [low], [high], []
    for level in range(tree.chain.shape[1]):
        joint = tree.joint_above(link, level)
        rows = np.flatnonzero(joint >= 0)
        low, high, radius = lows[-1].copy(), highs[-1].copy(), np.zeros(len(link))
        if len(rows):
            low[rows], high[rows], radius[rows] = _swept(tree, joint[rows], low[rows], high[rows])
        lows.append(low)
        highs.append(high)
        radii.append(radius)
    return _Reach(np.stack(lows), np.stack(highs), np.stack(radii))


def _swept(
    tree: Tree, joint: np.ndarray, low: np.ndarray, high: np.ndarray
) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Boxes (k, 3) that hold boxes wherever their joints put them, and how far from the axes the boxes reach."""
    axis, origin, rest = tree.axis[joint], tree.origin[joint], tree.joints.rest[joint]
    least, most = tree.low[joint] - rest, tree.high[joint] - rest
    middle, half = (low + high) / 2, (high - low) / 2
    arm = middle - origin
    across = arm - axis * dot(axis, arm)[:, None]
    radius = np.sqrt(dot(across, across)) + np.sqrt(dot(half, half))
    slides, turns = tree.slides[joint], tree.turns[joint]
    along = np.where(slides, 1.0, tree.advance[joint])
    ends = np.stack([axis * (along * least)[:, None], axis * (along * most)[:, None]])
    found_low, found_high = low + ends.min(axis=0), high + ends.max(axis=0)
    rows = np.flatnonzero(turns)
    if len(rows):
        least, most, axis, arm, half = least[rows], most[rows], axis[rows], arm[rows], half[rows]
        lows, highs = np.full((len(rows), 3), np.inf), np.full((len(rows), 3), -np.inf)
        step = np.minimum(most - least, FULL) / _SLICES
        for k in range(_SLICES):
            turn = rotation_about(axis, least + (k + 0.5) * step)
            at, wide = apply(turn, arm), apply(np.abs(turn), half)
            lows, highs = np.minimum(lows, at - wide), np.maximum(highs, at + wide)
        across = np.sqrt(np.maximum(1.0 - axis * axis, 0.0))  # along its axis nothing turns
        slack = (radius[rows] * step / 2)[:, None] * across
        found_low[rows] = origin[rows] + lows - slack + ends[:, rows].min(axis=0)
        found_high[rows] = origin[rows] + highs + slack + ends[:, rows].max(axis=0)
    balls, corner = ~(slides | turns), np.maximum(np.abs(low - origin), np.abs(high - origin))
    radius = np.where(balls, np.sqrt(dot(corner, corner)), radius)
    tilt = np.where(balls, radius * np.maximum(np.abs(tree.low[joint]), np.abs(tree.high[joint])), 0.0)[:, None]
    return found_low - tilt, found_high + tilt, np.where(slides, 1.0, np.hypot(radius, np.where(turns, along, 0.0)))


@dataclass(slots=True, eq=False)
class Cells:
    """Two pieces, and of each joint between their links (k, C) where its interval begins and ends, less its rest value."""

    row: np.ndarray  # of the pairs of links
    piece: np.ndarray
    other: np.ndarray
    start: np.ndarray
    stop: np.ndarray
    radius: np.ndarray  # (k, C): how far a corner moves for one unit of a joint
    slack: np.ndarray  # (k,): and for all that balls between them can tilt

    def at(self, rows: np.ndarray) -> Cells:
        return Cells(*(getattr(self, name)[rows] for name in self.__slots__))

    def halved(self, column: np.ndarray) -> Cells:
        """Each halved along one of its joints."""
        count = len(self.row)
        rows, both = np.arange(count), self.at(np.tile(np.arange(count), 2))
        middle = (self.start[rows, column] + self.stop[rows, column]) / 2
        both.stop[rows, column], both.start[rows + count, column] = middle, middle
        return both


def _cells(tree: Tree, body: Pieces, way: Ways) -> Cells:
    """The pairs of pieces of pairs of links that can come near one another, with all that their joints can do."""
    links = len(tree.links.owner)
    lows, highs, begin, end = link_boxes(body, links)
    count, half = end - begin, way.joint.shape[1] // 2
    full = np.flatnonzero(count)
    seen = np.flatnonzero((count[way.first] > 0) & (count[way.second] > 0))
    whole = _reach(tree, full, lows[full], highs[full])
    number = np.zeros(links, dtype=np.int64)
    number[full] = np.arange(len(full))
    sides = tuple(zip(way.levels, (way.first, way.second), strict=True))
    one, two = (whole.boxes(level[seen], number[link[seen]]) for level, link in sides)
    seen = seen[_meet(one, two)]
    # their pieces, as far as these come near the other link at all
    used = np.flatnonzero(np.isin(body.link, distinct(np.concatenate([way.first[seen], way.second[seen]]))))
    own = _reach(tree, body.link[used], body.low[used], body.high[used])
    place = np.zeros(len(body), dtype=np.int64)
    place[used] = np.arange(len(used))
    chosen = []
    for (level, link), (beyond, beside) in zip(sides, reversed(sides), strict=True):
        index, piece = enumerate_ranges(begin[link[seen]], count[link[seen]])
        row = seen[index]
        kept = _meet(own.boxes(level[row], place[piece]), whole.boxes(beyond[row], number[beside[row]]))
        chosen.append((index[kept], piece[kept]))
    (index, piece), (index_of_others, others) = chosen
    many = np.bincount(index_of_others, minlength=len(seen))
    at, other = enumerate_ranges((np.cumsum(many) - many)[index], many[index])
    row, piece, other = seen[index[at]], piece[at], others[other]
    keep = body.opposed(piece, other)
    row, piece, other = row[keep], piece[keep], other[keep]
    near = _meet(own.boxes(way.levels[0][row], place[piece]), own.boxes(way.levels[1][row], place[other]))
    row, piece, other = row[near], piece[near], other[near]
    joint = way.joint[row]
    known = np.maximum(joint, 0)
    start, stop = (
        np.where(joint >= 0, (end - tree.joints.rest)[known], 0.0) if len(known) else np.zeros(joint.shape)
        for end in (tree.low, tree.high)
    )
    radius = np.concatenate([own.radius[:half, place[piece]], own.radius[:half, place[other]]]).T
    radius = np.where(joint >= 0, radius, 0.0)
    balls = (joint >= 0) & np.append(~(tree.slides | tree.turns), False)[joint]
    slack = add_columns(np.where(balls, radius * np.maximum(np.abs(start), np.abs(stop)), 0.0))
    start, stop = np.where(balls, 0.0, start), np.where(balls, 0.0, stop)
    return _where_gates_let(tree, joint, Cells(row, piece, other, start, stop, radius, slack))


def _where_gates_let(tree: Tree, joint: np.ndarray, part: Cells) -> Cells:
    """The cells without states that no gate lets joints (k, C) be in: a joint that waits rests, or its gates are open."""
    gates, owner = tree.gates, tree.joints.owner
    if gates is None:
        return part
    waiting = distinct(joint[np.append(tree.gated, False)[joint]])
    turn = np.arange(len(waiting)) - np.searchsorted(owner[waiting], owner[waiting])
    object_of = owner[joint.max(axis=1, initial=-1)]
    moved = np.zeros(len(joint), dtype=np.int64)  # which objects have cells that were told apart
    for number in range(int(turn.max(initial=-1)) + 1):  # the first joint that waits of every object, the second, ...
        chosen, asked = np.zeros(len(owner) + 1, dtype=bool), np.zeros(len(owner) + 1, dtype=bool)
        chosen[waiting[turn == number]] = True
        asks = np.flatnonzero(chosen[gates.joint])
        asked[gates.gate[asks]] = True
        own, gate = chosen[joint] & (part.stop > part.start), asked[joint]
        rows = np.flatnonzero(own.any(axis=1) & gate.any(axis=1))
        if not len(rows):
            continue
        low, high = np.full(len(asked), -np.inf), np.full(len(asked), np.inf)
        rest = tree.joints.rest[gates.gate[asks]]
        np.maximum.at(low, gates.gate[asks], gates.low[asks] - rest)
        np.minimum.at(high, gates.gate[asks], gates.high[asks] - rest)
        shut, wide, at = part.at(rows), part.at(rows), joint[rows]
        shut.start, shut.stop = (np.where(own[rows], 0.0, end) for end in (shut.start, shut.stop))
        wide.start = np.where(gate[rows], np.maximum(wide.start, low[at]), wide.start)
        wide.stop = np.where(gate[rows], np.minimum(wide.stop, high[at]), wide.stop)
        open_ = np.flatnonzero((wide.start <= wide.stop).all(axis=1))
        others = np.ones(len(joint), dtype=bool)
        others[rows] = False
        left = np.flatnonzero(others)
        parts = (part.at(left), shut, wide.at(open_))
        from_ = np.concatenate([left, rows, rows[open_]])
        joint, object_of, moved = joint[from_], object_of[from_], moved[from_]
        moved[len(left) :] = 1 + object_of[len(left) :]
        part = Cells(*(np.concatenate([getattr(p, name) for p in parts]) for name in Cells.__slots__))
    return part.at(np.argsort(moved, kind="stable"))


def _meet(first: Boxes, second: Boxes) -> np.ndarray:
    """Which of two boxes (k,) overlap."""
    return np.logical_and.reduce((first[0] < second[1]) & (second[0] < first[1]), axis=1)


def least_share(
    tree: Tree, body: Pieces, way: Ways, yields: np.ndarray, found: list[Meeting] | None = None
) -> tuple[np.ndarray, np.ndarray]:
    """The least share of the ways of joints that ``yield`` (J,) at which any of the pairs of links meet.

    Returns that share of each joint (J,), 1 where nothing meets, and which pairs of links meet where none of their joints yields;
    ``found`` is told which pieces do, and where.
    """
    room, met = np.ones(len(yields)), np.zeros(len(way.first), dtype=bool)
    part = _cells(tree, body, way)
    joint = way.joint
    giving = (joint >= 0) & np.append(yields, False)[joint]
    alike = np.append(tree.turns & (tree.advance == 0.0), False)[joint]  # each turn is like the first
    again = alike & (joint >= 0) & ~giving
    part.stop = np.where(again[part.row], np.minimum(part.stop, part.start + FULL), part.stop)
    far = np.where(giving, np.append(tree.high - tree.joints.rest, 1.0)[joint], np.inf)
    far = np.where(far > 0.0, far, np.inf)
    body.ready(part.piece, part.other)
    for number in range(_ROUNDS):
        own = giving[part.row]
        begins = _shares(part.start, far[part.row])
        limit = np.where(own, np.append(room, 0.0)[joint[part.row]], -np.inf).max(axis=1, initial=-np.inf)
        limit = np.where(own.any(axis=1), limit, np.where(met[part.row], -np.inf, np.inf))
        part = part.at(np.flatnonzero(begins < limit - _NEAR))
        if not len(part.row):
            break
        own, begins = giving[part.row], _shares(part.start, far[part.row])
        hit, apart, loss, total = examine_cells(tree, body, way, part)
        crowd = np.bincount(part.row, minlength=len(met))[part.row] > _MOST
        giving_way = np.where(own, (part.stop - part.start) * part.radius, 0.0).max(axis=1, initial=0.0)
        bound = hit & own.any(axis=1)
        small = ~apart & (crowd | (np.where(bound, giving_way, total) < _LOSS) | (number == _ROUNDS - 1))
        share = np.where(small, begins, _shares((part.start + part.stop) / 2, far[part.row]))
        told = np.flatnonzero(hit | small)
        for column in range(joint.shape[1]):
            rows = told[own[told, column]]
            np.minimum.at(room, joint[part.row[rows], column], share[rows])
        firm = told[~own[told].any(axis=1)]
        met[part.row[firm]] = True
        if found is not None and len(firm):
            middle = (part.start[firm] + part.stop[firm]) / 2
            found.append(Meeting(part.row[firm], part.piece[firm], part.other[firm], middle))
        going = np.flatnonzero(~apart & ~small)
        # of what meets in the middle, the joint that has gone farthest of its way gives way
        ends = np.where(own[going], part.stop[going] / far[part.row[going]], -np.inf)
        # what each does alone, and of what they do together a share by how far each moves
        moved = ((part.stop - part.start) / 2 * part.radius)[going]
        mixed = np.maximum(total[going] - add_columns(loss[going]), 0.0) / np.maximum(add_columns(moved), 1e-300)
        weight = loss[going] + np.maximum(np.minimum(mixed, 1.0), _TIE)[:, None] * moved
        widest = np.where(bound[going], np.argmax(ends, axis=1), np.argmax(weight, axis=1))
        part = part.at(going).halved(widest)
    return room, met


def _shares(value: np.ndarray, far: np.ndarray) -> np.ndarray:
    """The share (k,) of the ways of joints (k, C) at which states lie: the greatest of them."""
    return np.maximum(value / far, 0.0).max(axis=1, initial=0.0)
