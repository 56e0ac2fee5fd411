"""The frame of a part that moves, and where its points lie in it.

x goes along the part's joint, the way it opens; y from a hinge to the part, and of what slides as far up as can be; z is square to
both. The part's box along these axes has its centre at 0 and a diagonal of 1.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from .clouds import Arrays, ball

OWN = 256  # points of the part, and as many of the whole object


@dataclass(frozen=True, slots=True, eq=False)
class Part:
    """``points`` (n, 3) of a whole object with z up, which of them are its ``own`` (n,), the unit ``axis`` of its joint and, of a hinge, a
    point of it."""

    points: np.ndarray
    own: np.ndarray
    axis: np.ndarray
    hinge: np.ndarray | None

    def frame(self) -> np.ndarray:
        """(3, 3) the axes of the part as columns."""
        points = self.points[self.own]
        x, middle = self.axis, points.mean(axis=0)
        up = np.array([0.0, 0.0, 1.0])
        outward = middle - (self.points.min(axis=0) + self.points.max(axis=0)) / 2
        size = float(np.ptp(points, axis=0).max())
        ways = [up if abs(x[2]) < 0.9 else outward, outward, np.eye(3)[int(np.argmin(np.abs(x)))] * size]
        if self.hinge is not None:
            ways.insert(0, middle - self.hinge)
        for way in ways:
            y = way - (way @ x) * x
            length = float(np.sqrt((y**2).sum()))
            if length > 0.02 * size:  # else it says nothing: a knob lies on its hinge
                y = y / length
                return np.stack([x, y, np.cross(x, y)], axis=1)
        raise AssertionError("one of the axes is square to any other")

    def canonical(self) -> tuple[np.ndarray, np.ndarray]:
        """(n, 3) the places of all points in the part's frame, and (2,) where its hinge meets the plane of y and z."""
        frame = self.frame()
        own = self.points @ frame
        low, high = own[self.own].min(axis=0), own[self.own].max(axis=0)
        centre, diagonal = (low + high) / 2, max(float(np.sqrt(((high - low) ** 2).sum())), 1e-12)
        hinge = np.zeros(3) if self.hinge is None else (self.hinge @ frame - centre) / diagonal
        return (own - centre) / diagonal, hinge[1:]


def part_arrays(parts: Sequence[Part]) -> Arrays:
    """Arrays (K, 2 * OWN, ...): ``points``, the whole object in a ball of radius 1; ``own``, which are the part's; ``npcs``, canonical places;
    ``hinge`` (2) and ``hinged``, the same for all points of a part."""
    found: dict[str, list[np.ndarray]] = {}
    for k, part in enumerate(parts):
        draws = np.random.default_rng(k)
        at = np.concatenate([_some(np.flatnonzero(part.own), OWN, draws), _some(np.arange(len(part.own)), OWN, draws)])
        at = draws.permutation(at)
        places, hinge = part.canonical()
        centre, radius = ball(part.points)
        told = {
            "points": ((part.points - centre) / radius)[at].astype(np.float32),
            "own": part.own[at],
            "npcs": places[at].astype(np.float32),
            "hinge": np.tile(hinge.astype(np.float32), (len(at), 1)),
            "hinged": np.full(len(at), part.hinge is not None),
        }
        for name, values in told.items():
            found.setdefault(name, []).append(values)
    return {name: np.stack(values) for name, values in found.items()}


def _some(rows: np.ndarray, count: int, draws: np.random.Generator) -> np.ndarray:
    """``count`` of the rows, each once if there are enough."""
    return draws.permutation(rows)[:count] if len(rows) >= count else draws.choice(rows, count)
