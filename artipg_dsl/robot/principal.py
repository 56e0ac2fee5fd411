"""Principal axes of inertia tensors by Jacobi rotations: the same bits on every machine, which LAPACK does not promise.

G. H. Golub, C. F. Van Loan, Matrix Computations, section 8.5 (cyclic Jacobi for symmetric matrices).
"""

from __future__ import annotations

import numpy as np

_SWEEPS = 8  # convergence is quadratic: five do for 3 x 3


def find_principal(tensors: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Moments (n, 3) and right-handed axes (n, 3, 3), as columns, of symmetric tensors (n, 3, 3).

    ``tensor = axes @ diag(moments) @ axes.T``. A diagonal tensor keeps its axes.
    """
    a = np.array(tensors, dtype=np.float64)
    axes = np.broadcast_to(np.eye(3), a.shape).copy()
    for _ in range(_SWEEPS):
        for p, q in ((0, 1), (0, 2), (1, 2)):
            _rotate(a, axes, p, q)
    return np.stack([a[:, k, k] for k in range(3)], axis=1), axes


def _rotate(a: np.ndarray, axes: np.ndarray, p: int, q: int) -> None:
    """Turn about the third axis so that the entry (p, q) vanishes, in place."""
    off = a[:, p, q].copy()
    tiny = np.abs(off) <= 1e-16 * (np.abs(a[:, p, p]) + np.abs(a[:, q, q]))
    safe = np.where(tiny, 1.0, off)
    theta = (a[:, q, q] - a[:, p, p]) / (2.0 * safe)
    sign = np.where(theta >= 0, 1.0, -1.0)
    t = np.where(tiny, 0.0, sign / (np.abs(theta) + np.sqrt(theta * theta + 1.0)))
    c = 1.0 / np.sqrt(t * t + 1.0)
    s = t * c
    for columns in (a, axes):  # columns p and q, then (of the tensor alone) rows p and q
        old_p, old_q = columns[:, :, p].copy(), columns[:, :, q].copy()
        columns[:, :, p] = c[:, None] * old_p - s[:, None] * old_q
        columns[:, :, q] = s[:, None] * old_p + c[:, None] * old_q
    old_p, old_q = a[:, p].copy(), a[:, q].copy()
    a[:, p] = c[:, None] * old_p - s[:, None] * old_q
    a[:, q] = s[:, None] * old_p + c[:, None] * old_q
    a[:, p, q] = a[:, q, p] = np.where(tiny, off, 0.0)
