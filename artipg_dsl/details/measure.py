"""How well points wear details: distances both ways, what is covered, and neighbourhoods that are torn or turned over."""

from __future__ import annotations

import numpy as np
from scipy.spatial import cKDTree

from ..geometry.vectors import cross, dot

NEAR = 0.015  # diagonals: what has a point this near is covered
_TORN = 4.0  # times as far apart as before, and
_TORN_AT_LEAST = 0.02  # diagonals
_AROUND = 7  # neighbours, the point itself among them


def distances(cloud: np.ndarray, worn: np.ndarray, diagonal: float) -> dict[str, float]:
    """Of points (n, 3) of a real surface and of a structure in its details, in percent of the diagonal: ``to_real`` from each worn point to
    the nearest real one and ``to_worn`` the other way (means); the shares ``covered_real`` and ``covered_worn`` that have one near."""
    there, back = cKDTree(cloud).query(worn)[0] / diagonal, cKDTree(worn).query(cloud)[0] / diagonal
    return {
        "to_real": _percent(there.mean()),
        "to_worn": _percent(back.mean()),
        "covered_real": round(float((back < NEAR).mean()), 4),
        "covered_worn": round(float((there < NEAR).mean()), 4),
    }


def _percent(share: np.ndarray | float) -> float:
    return round(100.0 * float(share), 4)


def spoiled(
    before: np.ndarray, outward: np.ndarray, group: np.ndarray, after: np.ndarray, normals: np.ndarray, diagonal: float
) -> dict[str, float]:
    """Shares of the neighbourhoods of points (n, 3) that are ``torn`` or ``inverted`` once the points have moved.

    A neighbourhood is a point with two of its nearest neighbours of the same ``group`` (n,) and a like normal ``outward``, about
    at right angles. It is torn where a side is more than four times as long as it was, and longer by more than 2 % of the diagonal;
    inverted where the triangle has turned its back on the ``normals`` (n, 3) of the moved points.
    """
    features = np.concatenate([before / diagonal, 0.3 * outward, 10.0 * group[:, None]], axis=1)
    _, near = cKDTree(features).query(features, k=min(_AROUND, len(before)))
    own = before[near[:, 1:]] - before[:, None]
    length = np.sqrt(dot(own, own))
    first = near[:, 1]
    cosine = dot(own, own[:, :1]) / np.maximum(length * length[:, :1], 1e-12)
    pick = np.argmin(np.abs(cosine), axis=1)
    second = near[np.arange(len(near)), pick + 1]
    alike = (group[first] == group) & (group[second] == group)
    alike &= (dot(outward[first], outward) > 0.7) & (dot(outward[second], outward) > 0.7)
    if not alike.any():
        return {"torn": 0.0, "inverted": 0.0}
    old = [before[k] - before for k in (first, second)]
    new = [after[k] - after for k in (first, second)]
    limit = [np.maximum(_TORN * np.sqrt(dot(e, e)), np.sqrt(dot(e, e)) + _TORN_AT_LEAST * diagonal) for e in old]
    torn = (np.sqrt(dot(new[0], new[0])) > limit[0]) | (np.sqrt(dot(new[1], new[1])) > limit[1])
    turn = np.sign(dot(cross(*old), outward)) * dot(cross(*new), normals)
    return {"torn": round(float(torn[alike].mean()), 4), "inverted": round(float((turn < 0.0)[alike].mean()), 4)}
