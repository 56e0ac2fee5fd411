"""Bodies in many states of joints, looked at by compiled code: what ``validity.following`` computes, with the same bits."""

from __future__ import annotations

import ctypes
from typing import TYPE_CHECKING

import numpy as np

from ..records import dataclass
from .calls import address, call
from .narrow import Side, told

if TYPE_CHECKING:
    from .backend import Machine

_ROOM = 1 << 14  # pairs that there is room for at first


@dataclass(frozen=True, slots=True, eq=False)
class Scene:
    """Pieces sorted by link: ``begin`` and ``end`` (L,) of those of each link, the object of each (L,), boxes (N, 3) of pieces and
    (L, 3) of links, at rest."""

    begin: np.ndarray
    end: np.ndarray
    owner: np.ndarray
    low: np.ndarray
    high: np.ndarray
    lows: np.ndarray
    highs: np.ndarray


class _Scene(ctypes.Structure):
    _fields_ = [(name, ctypes.c_void_p) for name in Scene.__slots__]


def near_in_states(
    machine: Machine,
    scene: Scene,
    turn: np.ndarray,
    shift: np.ndarray,
    pairs: tuple[np.ndarray, np.ndarray],
    asked: np.ndarray,
) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """(state, piece, piece): those of pairs of links (P,) whose boxes overlap with the links posed by ``turn`` (S, L, 3, 3) and
    ``shift`` (S, L, 3), in the objects that are ``asked`` (S, B). Sorted by state, pair and pieces."""
    states, links = turn.shape[:2]
    whole, integer = np.float64, np.int64
    given = [
        np.ascontiguousarray(getattr(scene, name), dtype=integer if place < 3 else whole)
        for place, name in enumerate(Scene.__slots__)
    ]
    turn, shift = np.ascontiguousarray(turn, dtype=whole), np.ascontiguousarray(shift, dtype=whole)
    one, two = (np.ascontiguousarray(side, dtype=integer) for side in pairs)
    asked, pieces = np.ascontiguousarray(asked, dtype=np.bool_), len(scene.low)
    boxes, seen = np.empty(6 * pieces + 12 * links), np.empty(2 * links, dtype=integer)
    rows, room = np.empty(pieces, dtype=integer), _ROOM
    held = _Scene(*[address(array) for array in given])
    while True:
        found = np.empty((room, 3), dtype=integer)
        places = (states, links, asked.shape[1], turn, shift, held)
        kept = (pieces, boxes, seen, rows, room, found)
        count = call(machine.library.near_in_states, *places, len(one), one, two, asked, *kept)
        if count <= room:
            state, piece, other = np.ascontiguousarray(found[:count].T)
            return state, piece, other
        room = count


def meet_in_states(
    machine: Machine,
    first: Side,
    second: Side,
    pieces: tuple[np.ndarray, np.ndarray],
    boxes: tuple[np.ndarray, np.ndarray],
    clear: float,
    steps: int,
) -> np.ndarray:
    """Which pairs of pieces (k,), posed, overlap; those that a known direction keeps apart by more than ``clear`` do not.

    ``pieces`` (k,) number the two, which have ``boxes`` (N, 3) at rest.
    """
    hit = np.empty(len(pieces[0]), dtype=np.bool_)
    kept = np.empty(machine.library.way_size(), dtype=np.uint8)
    piece, other = (np.ascontiguousarray(side, dtype=np.int64) for side in pieces)
    low, high = (np.ascontiguousarray(end, dtype=np.float64) for end in boxes)
    (one, held), (two, more) = (told(side) for side in (first, second))
    bodies = (one, two, piece, other, low, high)
    call(machine.library.meet_in_states, len(hit), *bodies, float(clear), steps, kept, hit)
    del held, more  # were to live until here
    return hit
