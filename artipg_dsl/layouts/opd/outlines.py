"""Masks as the polygons of COCO's annotations, exactly: outlines along the edges of pixels, without holes.

COCO has no holes, so a mask is cut into pieces: runs of pixels that follow one another from row to row, each touching one alone
above and below.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np


def outlines(mask: np.ndarray) -> list[list[float]]:
    """Polygons ``[x, y, x, y ...]`` in pixels whose union is the mask (H, W) bool; a pixel covers [column, column + 1)."""
    row, start, stop = _runs(mask)
    if not len(row):
        return []
    chain = _chains(row, start, stop, mask.shape[1] + 1)
    order = np.argsort(chain, kind="stable")
    cuts = np.flatnonzero(np.diff(chain[order])) + 1
    return [_outline(row[own], start[own], stop[own]) for own in np.split(order, cuts)]


def _runs(mask: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Row, first column and column after the last (n,) of each run of pixels, row by row."""
    padded = np.zeros((mask.shape[0], mask.shape[1] + 2), dtype=np.int8)
    padded[:, 1:-1] = mask
    step = np.diff(padded, axis=1)
    row, start = np.nonzero(step == 1)
    return row, start, np.nonzero(step == -1)[1]


def _chains(row: np.ndarray, start: np.ndarray, stop: np.ndarray, width: int) -> np.ndarray:
    """A number (n,) for each run, the same for those that follow one another."""
    first, last, below = row * width + start, row * width + stop, width
    low = np.searchsorted(last, first + below, side="right")
    high = np.searchsorted(first, last + below, side="left")
    touched = np.zeros(len(row) + 1, dtype=np.int64)
    np.add.at(touched, low, 1)
    np.add.at(touched, high, -1)
    above = np.cumsum(touched)[:-1]  # how many runs of the row before each touches
    upper = np.flatnonzero((high - low == 1) & (above[np.minimum(low, len(row) - 1)] == 1))
    root = np.arange(len(row))
    root[low[upper]] = upper
    while (root[root] != root).any():
        root = root[root]
    return root


def _outline(row: np.ndarray, start: np.ndarray, stop: np.ndarray) -> list[float]:
    """Around runs that follow one another: down their ends, up their beginnings, without corners in a straight line."""
    right, left = (_steps(row, column) for column in (stop, start))
    return np.concatenate([right, left[::-1]]).ravel().tolist()


def _steps(row: np.ndarray, column: np.ndarray) -> np.ndarray:
    """Corners (m, 2) of a flight of steps."""
    turn = np.flatnonzero(np.diff(column)) + 1
    begin, end = np.concatenate([[0], turn]), np.concatenate([turn - 1, [len(row) - 1]])
    corners = np.stack([column[begin], row[begin], column[end], row[end] + 1], axis=-1)
    return corners.reshape(-1, 2).astype(np.float64)


def fill(polygons: Sequence[Sequence[float]], height: int, width: int) -> np.ndarray:
    """The mask (height, width) of pixels whose centres lie within any of some polygons: what COCO makes of outlines along pixels."""
    made = np.zeros((height, width), dtype=bool)
    middle = np.arange(width) + 0.5
    for polygon in polygons:
        corner = np.asarray(polygon, dtype=np.float64).reshape(-1, 2)
        after = np.roll(corner, -1, axis=0)
        low, high = np.minimum(corner[:, 1], after[:, 1]), np.maximum(corner[:, 1], after[:, 1])
        y = np.arange(height)[:, None] + 0.5
        across = (low <= y) & (y < high)
        with np.errstate(divide="ignore", invalid="ignore"):
            share = (y - corner[:, 1]) / (after[:, 1] - corner[:, 1])
            x = np.where(across, corner[:, 0] + share * (after[:, 0] - corner[:, 0]), np.inf)
        inside = np.zeros((height, width), dtype=np.int64)
        for k in np.flatnonzero(across.any(axis=0)).tolist():
            inside += middle > x[:, k : k + 1]
        made |= inside % 2 == 1
    return made


def along_pixels(polygons: Sequence[Sequence[float]]) -> bool:
    """Whether all edges run along the edges of pixels, so that it is plain which pixels are inside."""
    for polygon in polygons:
        corner = np.asarray(polygon, dtype=np.float64).reshape(-1, 2)
        edge = np.roll(corner, -1, axis=0) - corner
        if (corner != np.round(corner)).any() or (edge != 0).all(axis=1).any():
            return False
    return True
