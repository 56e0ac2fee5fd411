"""What meets in many states of the joints, of all objects at once: those that others follow, and random ones.

Boxes of links tell first which of them can meet in which state, boxes of pieces then. A direction along which one piece lies
beyond another proves that they are apart, wherever it comes from: of all the states in which two pieces come near, the one in
the middle is asked, and its direction tried in the others, as it turns with the one piece and as it turns with the other.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator

import numpy as np

from ..geometry.box import turn_boxes
from ..geometry.collide import MOST_STEPS, separate
from ..geometry.runs import distinct
from ..geometry.vectors import dot
from ..native import states as native_states
from ..native.backend import Machine
from ..native.backend import machine as compiled
from ..native.narrow import Side
from ..records import dataclass
from ..runtime.motion import apply
from .bodies import Pieces, Placed, boxes_meet, enumerate_ranges, link_boxes
from .tree import Tree

_CLEAR = 1e-8  # metres, of the millionth by which what touches is apart
_BLOCK = 50_000  # pieces at a time, each in a state
_TRIES = 6  # states of two pieces that are asked for a direction; what is left is asked one by one


@dataclass(frozen=True, slots=True, eq=False)
class Met:
    """What meets in the state ``number``: pairs of pieces."""

    number: int
    pieces: tuple[np.ndarray, np.ndarray]


Meeting = Callable[[Placed, Placed], np.ndarray]


def meet_in_states(
    tree: Tree, body: Pieces, states: np.ndarray, asked: np.ndarray | None = None, meeting: Meeting | None = None
) -> Iterator[Met]:
    """State by state of ``states`` (S, J), what meets that may not, of objects that have pieces and are ``asked`` (S, B), by
    default of all. ``meeting`` tells instead which placed pieces meet."""
    here = np.zeros(len(tree.first), dtype=bool)
    here[body.owner] = True
    wanted = np.logical_and(np.ones((len(states), 1), dtype=bool) if asked is None else asked, here)
    if not wanted.any():
        return
    pairs, ways = _pairs(tree, body, np.logical_or.reduce(wanted, axis=0)), _Ways()
    size = max(1, _BLOCK // max(len(body), len(pairs[0]), len(tree.links.owner)))
    for start in range(0, len(states), size):
        part = slice(start, start + size)
        turn, shift, _, _ = tree.poses(states[part])
        state, i, j = _near(body, turn, shift, pairs, wanted[part], tree.links.owner)
        body.ready(i, j)
        machine = compiled()
        if meeting is None and machine is not None:
            hit = _compiled_meeting(machine, body, turn, shift, state, (i, j))
        else:
            first, second = (
                Placed(body, piece, turn[state, body.link[piece]], shift[state, body.link[piece]]) for piece in (i, j)
            )
            hit = meeting(first, second) if meeting else ways.meeting(first, second, i * len(body) + j)
        state, i, j = state[hit], i[hit], j[hit]
        edge = np.searchsorted(state, np.arange(len(turn) + 1))
        for k in range(len(turn)):
            rows = slice(edge[k], edge[k + 1])
            yield Met(start + k, (i[rows], j[rows]))


_Pairs = tuple[np.ndarray, np.ndarray]


def _pairs(tree: Tree, body: Pieces, asked: np.ndarray) -> _Pairs:
    """Links of objects ``asked`` (B,) bool that have pieces, in pairs; where sides are told, each with itself, too."""
    _, _, begin, end = link_boxes(body, len(tree.links.owner))
    full = np.flatnonzero((end > begin) & asked[tree.links.owner])
    owner = tree.links.owner[full]
    own = np.arange(len(full)) + (1 if body.side is None else 0)
    at, other = enumerate_ranges(own, np.searchsorted(owner, owner, side="right") - own)
    first, second = full[at], full[other]
    if body.side is None:  # of other pairs it is asked whether they keep a distance
        keep = ~tree.permitted(first, second)
        first, second = first[keep], second[keep]
    return first, second


def _near(
    body: Pieces, turn: np.ndarray, shift: np.ndarray, pairs: _Pairs, asked: np.ndarray, owner: np.ndarray
) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """(state, piece, piece): those whose boxes overlap with the links posed by ``turn`` (S, L, 3, 3), ``shift`` (S, L, 3), in
    the objects that are ``asked`` (S, B). Sorted by state."""
    links, machine = turn.shape[1], compiled()
    low, high, begin, end = link_boxes(body, links)
    if machine is not None:
        scene = native_states.Scene(begin, end, owner, body.low, body.high, low, high)
        state, i, j = native_states.near_in_states(machine, scene, turn, shift, pairs, asked)
        keep = body.opposed(i, j)
        return (state, i, j) if keep.all() else (state[keep], i[keep], j[keep])
    used = distinct(np.concatenate(pairs))
    place = np.zeros(links, dtype=np.int64)
    place[used] = np.arange(len(used))
    first, second = place[pairs[0]], place[pairs[1]]
    one, two = turn_boxes(turn[:, used], shift[:, used], low[used], high[used])
    close = asked[:, owner[pairs[0]]]
    for axis in range(3):
        close &= (one[..., axis][:, first] < two[..., axis][:, second]) & (
            one[..., axis][:, second] < two[..., axis][:, first]
        )
    state, pair = np.nonzero(close)
    # the pieces of the links that come near another, in these states
    posed, back = np.unique(np.concatenate([state * links + side[pair] for side in pairs]), return_inverse=True)
    if not len(posed):
        return state, state, state
    link, where = np.remainder(posed, links), np.floor_divide(posed, links)
    count = (end - begin)[link]
    at, piece = enumerate_ranges(begin[link], count)
    low, high = turn_boxes(turn[where, link][at], shift[where, link][at], body.low[piece], body.high[piece])
    start = np.cumsum(count) - count
    least, most = np.minimum.reduceat(low, start), np.maximum.reduceat(high, start)
    here, there = back[: len(pair)], back[len(pair) :]
    found = []
    for own, other in ((here, there), (there, here)):  # those of either that come near the other as a whole
        k, i = enumerate_ranges(start[own], count[own])
        keep = boxes_meet(i, other[k], low, high, least, most)
        found.append((k[keep], i[keep]))
    (k, i), (pair_of, j) = found
    begun = np.searchsorted(pair_of, k)
    n, at = enumerate_ranges(begun, np.searchsorted(pair_of, k, side="right") - begun)
    k, i, j = k[n], i[n], j[at]
    keep = boxes_meet(i, j, low, high, low, high)
    state, i, j = state[k[keep]], piece[i[keep]], piece[j[keep]]
    keep = body.opposed(i, j)
    return state[keep], i[keep], j[keep]


def _compiled_meeting(
    machine: Machine, body: Pieces, turn: np.ndarray, shift: np.ndarray, state: np.ndarray, pieces: _Pairs
) -> np.ndarray:
    """Which pieces (k,) overlap in the states ``state`` (k,), by compiled code."""
    links = turn.shape[1]
    sides = [
        Side(body.corners, body.kind[piece], body.slot[piece], turn, shift, pose=state * links + body.link[piece])
        for piece in pieces
    ]
    return native_states.meet_in_states(machine, sides[0], sides[1], pieces, (body.low, body.high), _CLEAR, MOST_STEPS)


class _Ways:
    """Directions along which pieces were apart, in the frames of both: of the pairs ``code`` (G,), ascending."""

    def __init__(self) -> None:
        self.code, self.held = np.zeros(0, dtype=np.int64), np.zeros((2, 0, 3))

    def meeting(self, first: Placed, second: Placed, code: np.ndarray) -> np.ndarray:
        """Which placed pieces meet (k,); ``code`` (k,) is the same for the same two in several states."""
        assert first.turn is not None and second.turn is not None
        turns = first.turn, second.turn
        pairs = distinct(np.concatenate([self.code, code]))
        held = np.zeros((2, len(pairs), 3))
        held[:, np.searchsorted(pairs, self.code)] = self.held
        self.code, self.held = pairs, held
        group, hit, met = (
            np.searchsorted(pairs, code),
            np.zeros(len(code), dtype=bool),
            np.zeros(len(pairs), dtype=bool),
        )
        left = self.open(first, second, group, np.argsort(group, kind="stable"))
        for number in range(_TRIES + 1):
            if not len(left):
                break
            own = group[left]
            start, stop = np.searchsorted(own, own), np.searchsorted(own, own, side="right")
            chosen = np.arange(len(own)) == (start + stop - 1) // 2
            chosen |= met[own] | (number == _TRIES)
            rows, left = left[chosen], left[~chosen]
            hit[rows], way = separate(first.at(rows), second.at(rows), near=0.0)
            met[group[rows[hit[rows]]]] = True
            way = way / np.maximum(np.sqrt(dot(way, way)), 1e-300)[:, None]
            for known, turn in zip(self.held, turns, strict=True):
                known[group[rows]] = apply(turn[rows].transpose(0, 2, 1), way)
            left = self.open(first, second, group, left)
        return hit

    def open(self, first: Placed, second: Placed, group: np.ndarray, rows: np.ndarray) -> np.ndarray:
        """Those of ``rows`` that no known direction parts."""
        assert first.turn is not None and second.turn is not None
        for known, turn in zip(self.held, (first.turn, second.turn), strict=True):
            tried = apply(turn[rows], known[group[rows]])
            rows = rows[~(dot(tried, first.support(rows, -tried) - second.support(rows, tried)) > _CLEAR)]
        return rows
