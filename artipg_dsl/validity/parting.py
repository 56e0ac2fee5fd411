"""Which pieces meet in state after state: a direction that kept two apart in one state mostly does so in the next.

A direction along which one piece lies beyond another proves that they are apart, wherever it comes from. It is tried as it
turns with the one and as it turns with the other, and only pairs that neither parts are asked anew.
"""

from __future__ import annotations

import numpy as np

from ..geometry.collide import dot, examine
from ..runtime.motion import apply
from .bodies import Pieces, Placed

CLEAR = 1e-8  # metres, of the millionth by which what touches is apart


class Parting:
    """The pairs of pieces of the state before: a number for each, and unit directions in the frames of both."""

    def __init__(self) -> None:
        self.code = np.zeros(0, dtype=np.int64)
        self.ways = np.zeros((0, 3)), np.zeros((0, 3))

    def meeting(self, body: Pieces, first: Placed, second: Placed) -> np.ndarray:
        """Which pairs (k,) of placed pieces meet; the answer is the same whatever was asked before."""
        assert first.turn is not None and second.turn is not None
        code = first.piece * len(body) + second.piece
        at = np.searchsorted(self.code, code)
        at[at == len(self.code)] = 0
        left = np.ones(len(code), dtype=bool)
        known = self.code[at] == code if len(self.code) else ~left
        way = np.zeros((len(code), 3))
        for turn, held in zip((first.turn, second.turn), self.ways, strict=True):
            rows = np.flatnonzero(known & left)
            tried = apply(turn[rows], held[at[rows]])
            parted = dot(tried, first.support(rows, -tried) - second.support(rows, tried)) > CLEAR
            way[rows[parted]], left[rows[parted]] = tried[parted], False
        rows, hit = np.flatnonzero(left), np.zeros(len(code), dtype=bool)
        hit[rows], way[rows] = examine(first.at(rows), second.at(rows), near=0.0)
        way[rows] /= np.maximum(np.sqrt(dot(way[rows], way[rows])), 1e-300)[:, None]
        order = np.argsort(code, kind="stable")
        self.code = code[order]
        one, two = (apply(turn[order].transpose(0, 2, 1), way[order]) for turn in (first.turn, second.turn))
        self.ways = one, two
        return hit
