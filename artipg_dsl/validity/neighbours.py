"""Which primitives of a link are near one another: boxes are swept along the axis on which they overlap least."""

from __future__ import annotations

import numpy as np

from .bodies import enumerate_ranges


def find_neighbours(
    link: np.ndarray, low: np.ndarray, high: np.ndarray, margin: np.ndarray
) -> tuple[np.ndarray, np.ndarray]:
    """Pairs of primitives of one link whose boxes, larger by the margin (S,), overlap; by link, then by first and second."""
    sort, stop = min((_swept(link, low[:, k], high[:, k], margin) for k in range(3)), key=lambda found: found[1].sum())
    place = np.arange(len(sort))
    i, j = enumerate_ranges(place + 1, stop - place - 1)
    first, second = np.minimum(sort[i], sort[j]), np.maximum(sort[i], sort[j])
    room = np.maximum(margin[first], margin[second])
    for k in range(3):
        near = (low[first, k] < high[second, k] + room) & (low[second, k] < high[first, k] + room)
        first, second, room = first[near], second[near], room[near]
    order = np.lexsort((second, first, link[first]))
    return first[order], second[order]


def _swept(link: np.ndarray, low: np.ndarray, high: np.ndarray, margin: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """The intervals of each link in the order of their low ends (S,), and before which of them those end that may reach one."""
    sort = np.lexsort((low, link))
    ends = np.searchsorted(link[sort], link[sort], side="right")
    reach = high + margin.max(initial=0.0)
    span = 2.0 * (reach.max(initial=0.0) - low.min(initial=0.0)) + 1.0  # links lie apart on one axis
    key, wanted = (low + link * span)[sort], (reach + link * span)[sort]
    if not np.isfinite(key).all() or not np.isfinite(wanted).all():
        return sort, ends
    # what the sums are rounded by: a pair too many does no harm
    slack = 1e-12 * (np.abs(wanted).max(initial=0.0) + 1.0)
    stop = np.searchsorted(key, wanted + slack, side="right")
    return sort, np.clip(stop, np.arange(len(sort)) + 1, ends)
