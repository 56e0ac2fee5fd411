"""Made-up objects of several primitives, as the runtime hands them over."""

from __future__ import annotations

import numpy as np

from artipg_dsl import random
from artipg_dsl.geometry.sites import SiteTable
from artipg_dsl.graph.primitive import Primitive


def turned(angle: np.ndarray, axis: int) -> np.ndarray:
    """Rotation matrices (k, 3, 3) about a coordinate axis."""
    out = np.zeros((len(angle), 3, 3))
    a, b = (axis + 1) % 3, (axis + 2) % 3
    out[:, axis, axis] = 1.0
    out[:, a, a] = out[:, b, b] = np.cos(angle)
    out[:, a, b], out[:, b, a] = -np.sin(angle), np.sin(angle)
    return out


def table(number: int, primitive: Primitive, params: dict, owner, translation, rotation=None, mirror=None) -> SiteTable:
    """A site from its parameters (k,), owners (k,) and translations (k, 3)."""
    owner = np.asarray(owner, dtype=np.int64)
    count = len(owner)
    rank = np.arange(count) - np.searchsorted(owner, owner)
    zeros = np.zeros(count, dtype=np.int64)
    return SiteTable(
        number,
        f"site{number}",
        primitive,
        {n: np.broadcast_to(np.asarray(v, dtype=np.float64), (count,)).copy() for n, v in params.items()},
        owner,
        np.broadcast_to(np.eye(3), (count, 3, 3)).copy() if rotation is None else rotation,
        np.broadcast_to(np.asarray(translation, dtype=np.float64), (count, 3)).copy(),
        np.ones(count) if mirror is None else np.asarray(mirror, dtype=np.float64),
        zeros,
        zeros,
        zeros,
        rank,
    )


def cluttered(primitives: list[Primitive], numbers: np.ndarray, sites: int = 40) -> list[SiteTable]:
    """Objects of ``sites`` overlapping, turned and mirrored primitives in a space of half a metre.

    An object depends on its number alone; sites with an even number repeat twice in every other object.
    """
    out = []
    for site in range(sites):
        primitive = primitives[site % len(primitives)]
        rows = np.where((numbers % 2 == 1) & (site % 2 == 0), 2, 1)
        owner = np.repeat(np.arange(len(numbers)), rows)
        rank = np.arange(len(owner)) - np.searchsorted(owner, owner)
        address = random.mix(numbers[owner], rank)

        def draw(name, low, high, where=address, s=site):
            return low + random.uniform(random.key(5, name, str(s)), where) * (high - low)

        params = {}
        for name in primitive.parameters:
            limits = {"radius": (0.005, 0.02), "top_radius": (0.005, 0.02)}.get(name, (0.05, 0.2))
            params[name] = draw(name, *limits)
        place = np.stack([draw(f"at{a}", -0.25, 0.25) for a in range(3)], axis=-1)
        rotation = turned(draw("turn", -3.0, 3.0), site % 3)
        if site % 4:
            rotation = np.broadcast_to(np.eye(3), rotation.shape).copy()
        out.append(
            table(site, primitive, params, owner, place, rotation, np.where(draw("mirror", 0, 1) < 0.5, -1.0, 1.0))
        )
    return out
