"""How big the objects are beside real ones: the boxes around them at rest against ranges measured in the real world."""

from __future__ import annotations

import json
from collections.abc import Mapping
from dataclasses import dataclass
from importlib import resources
from pathlib import Path
from typing import Any

import numpy as np

from ..errors import UserError
from ..runtime.batch import Batch
from ..sampling.known import evaluate_again
from ..validity.bodies import gather

_REFERENCE = "reference.json"
_AXES = ("width", "depth", "height")  # along y, x and z
_BLOCK = 128  # objects at a time


@dataclass(frozen=True, slots=True)
class Real:
    """What real objects of a category are like, in metres: 5th percentile, median, 95th percentile per axis.

    ``source`` says whose sizes these are. ``turned``: which side is the front is not known, so that the width is the
    longer of the horizontal sides. ``graphs`` is how many distinct kinematic graphs the real world is known to have,
    ``why`` the reason for the number.
    """

    width: tuple[float, float, float] | None = None
    depth: tuple[float, float, float] | None = None
    height: tuple[float, float, float] | None = None
    source: str = ""
    turned: bool = False
    graphs: int | None = None
    why: str = ""


@dataclass(frozen=True, slots=True)
class Extent:
    """One axis: 5th percentile, median, 95th percentile of the objects and of real ones; ``within``: share of the objects
    whose size lies in the real range; ``ratio`` of the medians; both None where nothing is known of real ones."""

    axis: str
    ours: tuple[float, float, float]
    real: tuple[float, float, float] | None
    within: float | None
    ratio: float | None


def read_reference(path: str | Path | None = None) -> dict[str, Real]:
    """What is known of real objects, by category: the shipped file, or one of its form. Raises UserError."""
    try:
        text = (
            Path(path).read_text(encoding="utf-8")
            if path is not None
            else resources.files(__package__).joinpath(_REFERENCE).read_text(encoding="utf-8")
        )
        found = json.loads(text)["categories"]
        return {name: _real(entry) for name, entry in found.items()}
    except (OSError, UnicodeDecodeError) as error:
        raise UserError(f"{path} cannot be read: {getattr(error, 'strerror', None) or error}") from None
    except (ValueError, KeyError, TypeError, AttributeError) as error:
        raise UserError(
            f"{path} is not a file of real sizes: {error}", "docs/categories.md shows what it holds"
        ) from None


def _real(entry: Mapping[str, Any]) -> Real:
    known: dict[str, Any] = dict(entry)
    for axis in _AXES:
        if axis in known:
            low, middle, high = (float(v) for v in known[axis])
            if not 0.0 < low <= middle <= high:
                raise ValueError(f"{axis} is not three rising lengths above 0")
            known[axis] = (low, middle, high)
    return Real(**known)


def measure_extents(batch: Batch) -> np.ndarray:
    """(B, 3) metres: depth along x, width along y, height along z of the box around each object, its joints at rest."""
    found = np.zeros((len(batch), 3))
    for start in range(0, len(batch), _BLOCK):
        objects = np.arange(start, min(start + _BLOCK, len(batch)))
        part = evaluate_again(batch, objects)
        links = part.links()
        turn, shift = part.pose()
        first = np.searchsorted(links.owner, np.arange(len(part)))
        body = gather(part, first, turn, shift)
        low, high = np.full((len(part), 3), np.inf), np.full((len(part), 3), -np.inf)
        np.minimum.at(low, body.owner, body.low)
        np.maximum.at(high, body.owner, body.high)
        found[objects] = np.where(high >= low, high - low, 0.0)
    return found


def compare_sizes(size: np.ndarray, real: Real | None) -> list[Extent]:
    """The sizes (B, 3) of objects along x, y, z beside real ones."""
    side = size[:, [1, 0, 2]]
    if real is not None and real.turned:
        side[:, :2] = np.sort(side[:, :2], axis=1)[:, ::-1]
    found = []
    for k, axis in enumerate(_AXES):
        low, middle, high = (float(v) for v in np.percentile(side[:, k], (5, 50, 95)))
        known = None if real is None else getattr(real, axis)
        within = ratio = None
        if known is not None:
            within = float(((side[:, k] >= known[0]) & (side[:, k] <= known[2])).mean())
            ratio = middle / known[1]
        found.append(Extent(axis, (low, middle, high), known, within, ratio))
    return found


__all__ = ["Extent", "Real", "compare_sizes", "measure_extents", "read_reference"]
