"""Near-duplicates: objects with the same choices and counts whose drawn values all lie close together.

Same choices and counts in the same rows give the same tables, so such objects have equally many values, in one order.
"""

from __future__ import annotations

import numpy as np
from scipy.spatial import cKDTree

from ..random import mix
from ..runtime.batch import Batch

CLOSE = 0.02  # of the range of a value
_LEAST = 1e-12  # the width of a range that is a point, or unknown: only equal values are close

Ranges = tuple[tuple[float, float], ...]


def find_near_duplicates(batch: Batch, kind: np.ndarray | None = None, ranges: Ranges | None = None) -> np.ndarray:
    """(B,) whether an object is nearly the same as one before it in the batch.

    ``kind`` (B,) sets objects apart beforehand (their kinematic graphs). ``ranges`` of the values are by default those
    that ``find_ranges`` finds in the batch itself.
    """
    mark = hash_structure(batch)
    if kind is not None:
        mark = mix(mark, kind)
    owner, value = _unit_values(batch, find_ranges(batch) if ranges is None else ranges)
    start = np.searchsorted(owner, np.arange(len(batch)))
    count = np.diff(np.append(start, len(owner)))
    found = np.zeros(len(batch), dtype=bool)
    order = np.argsort(mark, kind="stable")
    for group in np.split(order, np.flatnonzero(np.diff(mark[order])) + 1):
        if len(group) < 2:
            continue
        if count[group[0]] == 0:
            found[group[1:]] = True
            continue
        cells = value[start[group][:, None] + np.arange(count[group[0]])]
        pairs = cKDTree(cells).query_pairs(CLOSE, p=np.inf, output_type="ndarray")
        found[group[pairs.max(axis=1)]] = True
    return found


def hash_structure(batch: Batch) -> np.ndarray:
    """(B,) uint64, equal for objects with the same rows of draws and the same choices and counts in them."""
    found = np.zeros(len(batch), dtype=np.uint64)
    for number, draw in enumerate(batch.program.draws):
        owner = batch.owner(draw.column.scope)
        place = np.arange(len(owner)) - np.searchsorted(owner, owner)
        value = np.zeros(len(owner)) if draw.kind == "real" else batch.state.values[number]
        mark = mix(mix(np.full(len(owner), number, dtype=np.uint64), place), value.astype(np.int64) + 2**31)
        np.add.at(found, owner, mark)
    return found


def find_ranges(batch: Batch) -> Ranges:
    """The range of the values of each draw: that of its declaration if constant, else of what the objects of a batch have drawn;
    (0, 0) where that is nothing."""
    found = []
    for number, draw in enumerate(batch.program.draws):
        drawn = batch.state.values[number]
        low, high = (float(drawn.min()), float(drawn.max())) if len(drawn) else (0.0, 0.0)
        if draw.low is not None and draw.high is not None:
            if draw.low.constant is not None and draw.high.constant is not None:
                low, high = float(draw.low.constant), float(draw.high.constant)
        found.append((low, high))
    return tuple(found)


def _unit_values(batch: Batch, ranges: Ranges) -> tuple[np.ndarray, np.ndarray]:
    """The owner and the value, as a fraction of its range, of all real draws; by owner, then in the order of the text."""
    owners, values = [np.zeros(0, dtype=np.int64)], [np.zeros(0)]
    for number, (draw, (low, high)) in enumerate(zip(batch.program.draws, ranges, strict=True)):
        drawn = batch.state.values[number]
        if draw.kind != "real" or not len(drawn):
            continue
        owners.append(batch.owner(draw.column.scope))
        values.append((drawn - low) / max(high - low, _LEAST))
    owner = np.concatenate(owners)
    order = np.argsort(owner, kind="stable")
    return owner[order], np.concatenate(values)[order]
