"""Products of matrices in pieces that BLAS computes in one thread.

Larger ones are shared among threads, which round otherwise and wait for one another where other programs run: for up to sixty times as long.
"""

from __future__ import annotations

import numpy as np

_MOST = 250_000  # multiplications in a piece; OpenBLAS takes threads beyond 262,144


def at_a_time(each: int) -> int:
    """How many pieces of a product go together that take ``each`` multiplications."""
    return max(1, _MOST // max(each, 1))


def crossed(left: np.ndarray, right: np.ndarray) -> np.ndarray:
    """``left @ right.T`` (n, m) of rows (n, d) and (m, d)."""
    step = at_a_time(len(left) * len(right))
    found = left[:, :step] @ right[:, :step].T
    for start in range(step, left.shape[1], step):
        part = slice(start, start + step)
        found += left[:, part] @ right[:, part].T
    return found
