"""Equations without a closed form: Newton's method on all rows at once, by rules that each row follows alone.

A row takes full steps; a step that does not bring the largest residual down is undone and tried again at half its length
(Deuflhard, *Newton Methods for Nonlinear Problems*, 2011, section 3). A row that has arrived or cannot go on stands
still, so what the other rows do never shows in its bits. Whether a solution was found is for a requirement to say.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import Any

import numpy as np

_MOST_STEPS = 80
_ARRIVED = 1e-15  # of 1 + the value: steps this small change nothing that matters
_SHORTEST = 2.0**-12  # of a full step


@np.errstate(divide="ignore", invalid="ignore", over="ignore")
def solve_roots(
    system: Callable[..., tuple[Any, ...]], starts: Sequence[np.ndarray | float], knowns: Sequence[np.ndarray | float]
) -> np.ndarray:
    """The unknowns (n, rows) or, all being scalars, (n,) where ``system`` is 0, looked for from ``starts``.

    ``system(*unknowns, *knowns)`` gives n residuals, then their n * n derivatives, one residual after the other.
    """
    shape = np.broadcast_shapes(*(np.shape(v) for v in (*starts, *knowns)))
    given = [np.ravel(np.broadcast_to(np.asarray(v, dtype=np.float64), shape)) for v in knowns]
    x = np.stack([np.ravel(np.broadcast_to(np.asarray(v, dtype=np.float64), shape)) for v in starts])
    residual, slope, worst = _at(system, x, given)
    length, still = np.ones(x.shape[1]), worst == 0.0
    for _ in range(_MOST_STEPS):
        if still.all():
            break
        step = length * solve_small(slope, residual)
        trial = x - step
        at_trial = _at(system, trial, given)
        better = (at_trial[2] < worst) & ~still
        x, residual = np.where(better, trial, x), np.where(better, at_trial[0], residual)
        slope, worst = np.where(better, at_trial[1], slope), np.where(better, at_trial[2], worst)
        tiny = (np.abs(step) <= _ARRIVED * (1.0 + np.abs(x))).all(axis=0)
        still |= (worst == 0.0) | tiny | (~better & (length <= _SHORTEST))
        length = np.where(better, np.minimum(2.0 * length, 1.0), 0.5 * length)
    return x.reshape(len(starts), *shape)


def _at(
    system: Callable[..., tuple[Any, ...]], x: np.ndarray, given: list[np.ndarray]
) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Residuals (n, rows), derivatives (n, n, rows), and the largest residual of each row (inf where there is none)."""
    n, rows = x.shape
    found = np.stack([np.broadcast_to(np.asarray(v, dtype=np.float64), (rows,)) for v in system(*x, *given)])
    residual, slope = found[:n], found[n:].reshape(n, n, rows)
    worst = np.abs(residual).max(axis=0)
    return residual, slope, np.where(np.isfinite(worst), worst, np.inf)


def solve_small(matrix: np.ndarray, right: np.ndarray) -> np.ndarray:
    """Solve a small system (n, n, rows) per row: elimination with the largest pivot of each column, in a fixed order."""
    n, _, rows = matrix.shape
    table = np.concatenate([matrix, right[:, None]], axis=1)
    every = np.arange(rows)
    for k in range(n):
        chosen = k + np.argmax(np.abs(table[k:, k]), axis=0)
        top, other = table[k].copy(), table[chosen, :, every].T.copy()
        table[chosen, :, every] = top.T
        table[k] = other / other[k]
        for i in range(n):
            if i != k:
                table[i] = table[i] - table[i, k] * table[k]
    return table[:, n]
