"""Does a piece that turns about an axis meet another that stays, and at which angle?

Decided over whole intervals of angles: a plane that keeps the two apart is looked for in the middle and proved for the
interval, or the interval is halved. Boxes about pieces, and about groups of them, are asked first.
"""

from __future__ import annotations

import numpy as np

from ..geometry.collide import MOST_STEPS, separate
from ..geometry.runs import distinct
from ..geometry.vectors import dot
from ..native.backend import Machine
from ..native.backend import machine as compiled
from ..native.turning import Intervals, examine
from ..records import dataclass
from ..runtime.motion import apply, rotation_about
from .bodies import EXACT, Pieces, Placed, swept_extent
from .tree import Tree

HALVINGS = 16  # of an interval of angles; what is not decided then is nearer than a turn by 0.005 degrees
_COARSE = 12  # halvings for which boxes stand for the pieces
_MANY = 6  # pairs with one piece for which a box about the others stands first
_TILTED = 8  # and for which the boxes of tilted links do


@dataclass(slots=True, eq=False)
class Turns:
    """Pieces ``piece`` (k,) that turn about axes by ``start`` to ``stop`` beside others that stay."""

    piece: np.ndarray
    other: np.ndarray
    axis: np.ndarray
    origin: np.ndarray
    start: np.ndarray
    stop: np.ndarray
    advance: np.ndarray  # metres along the axis for a radian
    row: np.ndarray  # what it is a part of

    def at(self, rows: np.ndarray) -> Turns:
        return Turns(*(getattr(self, name)[rows] for name in self.__slots__))

    def halved(self) -> Turns:
        rows, count = np.tile(np.arange(len(self.row)), 2), len(self.row)
        middle, found = (self.start + self.stop) / 2, self.at(rows)
        found.stop[:count], found.start[count:] = middle, middle
        return found

    def examined(self, body: Pieces) -> tuple[np.ndarray, np.ndarray]:
        """Which meet in the middle, and which are proved to stay apart."""
        middle, half = (self.start + self.stop) / 2, (self.stop - self.start) / 2
        machine = compiled()
        if machine is not None:
            return self._examined_compiled(machine, body, middle, half)
        turn = rotation_about(self.axis, middle)
        along = self.axis * (self.advance * middle)[:, None]
        moved = Placed(body, self.piece, turn, self.origin - apply(turn, self.origin) + along)
        still = Placed(body, self.other)
        gap = body.apart(self.piece, self.other)
        hit, away = separate(moved, still, 0.5 if gap is None else EXACT)
        # moved lies beyond still along ``away``: does it while it turns by half the interval either way?
        least = -swept_extent(moved, self.axis, self.origin, np.minimum(half, np.pi), -away)
        least -= np.abs(dot(self.axis, away) * self.advance * half)
        most = dot(still.support(np.arange(len(self.row)), away), away)
        if gap is None:
            return hit, ~hit & (least >= most)
        length = np.sqrt(dot(away, away))
        hit |= length < gap
        return hit, ~hit & (least - most >= gap * length)

    def _examined_compiled(
        self, machine: Machine, body: Pieces, middle: np.ndarray, half: np.ndarray
    ) -> tuple[np.ndarray, np.ndarray]:
        """The same, by compiled code."""
        gap = body.apart(self.piece, self.other)
        pairs = Intervals(
            self.axis, self.origin, middle, half, self.advance, gap, self.piece, self.other, body.low, body.high
        )
        moved, still = (Placed(body, piece).side() for piece in (self.piece, self.other))
        return examine(machine, moved, still, pairs, 0.5 if gap is None else EXACT, MOST_STEPS)


def find_meeting(tree: Tree, body: Pieces, turns: Turns) -> tuple[np.ndarray, np.ndarray]:
    """Rows that meet while they turn, and an angle at which they do."""
    turns = turns.at(_possible_by_groups(tree, body, turns))
    turns = turns.at(_possible(tree, body, turns))
    turns = without_apart_boxes(body, turns)
    turns = turns.at(_possible(tree, body, turns))
    hits, values = [np.zeros(0, dtype=np.int64)], [np.zeros(0)]
    for _ in range(HALVINGS):
        if not len(turns.row):
            break
        hit, apart = turns.examined(body)
        hits.append(turns.row[hit])
        values.append(((turns.start + turns.stop) / 2)[hit])
        turns = turns.at(np.flatnonzero(~hit & ~apart)).halved()
    return np.concatenate(hits), np.concatenate(values)


def without_apart_boxes(body: Pieces, turns: Turns) -> Turns:
    """What is left of the turns once the boxes of pieces have told most of them apart, halved as far as it took."""
    boxes, open_ones = body.boxes(), []
    for _ in range(_COARSE):
        if not len(turns.row):
            break
        hit, apart = turns.examined(boxes)
        open_ones.append(turns.at(np.flatnonzero(hit)))
        turns = turns.at(np.flatnonzero(~hit & ~apart)).halved()
    left = [turns, *open_ones]
    turns = Turns(*(np.concatenate([getattr(part, name) for part in left]) for name in Turns.__slots__))
    body.ready(turns.piece, turns.other)
    return turns


def _possible_by_groups(tree: Tree, body: Pieces, turns: Turns) -> np.ndarray:
    """The turns that no box about many of the others rules out: about those of one site and link, as the keys of a keyboard."""
    before = np.cumsum([len(table) for table in tree.batch.sites()])
    kind = np.searchsorted(before, body.solid[turns.other], side="right") + body.link[turns.other] * (len(before) + 1)
    _, group, count = np.unique(np.stack([turns.piece, kind]), axis=1, return_inverse=True, return_counts=True)
    group = group.reshape(-1)
    order = np.flatnonzero(count[group] >= _MANY)
    if not len(order):
        return np.arange(len(turns.row))
    order = order[np.argsort(group[order], kind="stable")]
    begin = np.flatnonzero(np.diff(group[order], prepend=-1))
    whole = turns.at(order[begin])
    whole.start = np.minimum.reduceat(turns.start[order], begin)
    whole.stop = np.maximum.reduceat(turns.stop[order], begin)
    boxes = body.boxes_of_groups(tree.turn, distinct(whole.piece), turns.other[order], begin)
    whole.other, whole.row = len(body) + np.arange(len(begin)), np.arange(len(begin))
    met = _not_apart(whole, boxes, len(begin))
    possible = np.ones(len(turns.row), dtype=bool)
    possible[order] = met[np.repeat(np.arange(len(begin)), np.diff(begin, append=len(order)))]
    return np.flatnonzero(possible)


def _possible(tree: Tree, body: Pieces, turns: Turns) -> np.ndarray:
    """The turns that boxes do not rule out which lie straight in the frames of their links, tilted where these rest tilted."""
    away = np.abs(tree.turn - np.eye(3)).reshape(-1, 9).max(axis=1)
    tilted = away[body.link] > 1e-9
    possible = ~(tilted[turns.piece] | tilted[turns.other])
    rest = turns.at(np.flatnonzero(~possible))
    if len(rest.row):
        rest.row = np.flatnonzero(~possible)
        boxes = body.boxes(tree.turn, distinct(np.concatenate([rest.piece, rest.other])))
        possible |= _not_apart(rest, boxes, len(possible))
    return np.flatnonzero(possible)


def _not_apart(turns: Turns, boxes: Pieces, count: int) -> np.ndarray:
    """(count,) bool: the rows of turns that boxes, however often intervals are halved, do not prove to stay apart."""
    met = np.zeros(count, dtype=bool)
    for _ in range(_TILTED):
        if not len(turns.row):
            break
        hit, apart = turns.examined(boxes)
        met[turns.row[hit]] = True
        turns = turns.at(np.flatnonzero(~apart & ~met[turns.row])).halved()
    met[turns.row] = True
    return met
