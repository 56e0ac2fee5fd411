"""How big the objects are beside real ones: the boxes around them at rest against ranges measured in the real world."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import field, fields
from pathlib import Path
from typing import Any

import numpy as np

from ..diagnostics.suggest import did_you_mean
from ..errors import UserError
from ..files import read_json
from ..records import dataclass
from ..runtime.batch import Batch
from ..sampling.known import evaluate_again
from ..validity.bodies import gather

_SHIPPED = Path(__file__).resolve().with_name("reference.json")
_FORM = "docs/cli.md shows, under `report`, what it holds"
_AXES = ("width", "depth", "height")  # along y, x and z
_RATIOS = ("width/height", "depth/height")
_BLOCK = 128  # objects at a time


@dataclass(frozen=True, slots=True)
class Real:
    """What real objects of a category are like, in metres: 5th percentile, median, 95th percentile per axis.

    ``source`` says whose sizes these are. ``turned``: which side is the front is not known, so that the width is the
    longer of the horizontal sides. ``ratios`` of sizes likewise, by names such as ``width/height``. ``graphs`` is how many
    distinct kinematic graphs the real world is known to have, ``why`` the reason for the number. ``variants`` are what a
    buyer would call another model: the settings that give it, by its name.
    """

    width: tuple[float, float, float] | None = None
    depth: tuple[float, float, float] | None = None
    height: tuple[float, float, float] | None = None
    source: str = ""
    turned: bool = False
    graphs: int | None = None
    why: str = ""
    ratios: Mapping[str, tuple[float, float, float]] = field(default_factory=dict)
    variants: Mapping[str, Mapping[str, str]] = field(default_factory=dict)


@dataclass(frozen=True, slots=True)
class Extent:
    """One axis, or a ratio of two: 5th percentile, median, 95th percentile of the objects and of real ones; ``within``: share
    of the objects in the real range; ``ratio`` of the medians; both None where nothing is known of real ones."""

    axis: str
    ours: tuple[float, float, float]
    real: tuple[float, float, float] | None
    within: float | None
    ratio: float | None


def read_reference(path: str | Path | None = None) -> dict[str, Real]:
    """What is known of real objects, by category: the shipped file, or one of its form. Raises UserError."""
    path = _SHIPPED if path is None else path
    try:
        return {name: _real(name, entry) for name, entry in _categories(read_json(path, _FORM)).items()}
    except FileNotFoundError:
        raise UserError(f"there is no file {path}", _FORM) from None
    except (ValueError, TypeError, OverflowError) as error:
        raise UserError(f"{path} is not a file of real sizes: {error}", _FORM) from None


def _categories(found: Any) -> dict[str, Any]:
    """The entries of a file, by category."""
    entries = found.get("categories") if isinstance(found, dict) else None
    if not isinstance(entries, dict):
        raise ValueError('it has no table "categories"')
    return entries


def _real(category: str, entry: Any) -> Real:
    if not isinstance(entry, dict):
        raise ValueError(f"the entry of {category} is not a table")
    known: dict[str, Any] = {key: value for key, value in entry.items() if key not in _RATIOS}
    known.update({axis: _range(axis, known[axis]) for axis in _AXES if axis in known})
    known["ratios"] = {name: _range(name, entry[name]) for name in _RATIOS if name in entry}
    models = entry.get("variants", {})
    if not isinstance(models, dict):
        raise ValueError("`variants` is not a table of names and their settings")
    known["variants"] = {name: _variant(name, chosen) for name, chosen in models.items()}
    names = [entry.name for entry in fields(Real)]
    if odd := sorted(known.keys() - set(names)):
        raise ValueError(f"there is no `{odd[0]}`; {did_you_mean(odd[0], names) or 'there are ' + ', '.join(names)}")
    return Real(**known)


def _range(name: str, values: Any) -> tuple[float, float, float]:
    if not isinstance(values, list) or len(values) != 3 or not all(type(v) in (int, float) for v in values):
        raise ValueError(f"{name} is not a list of three numbers")
    low, middle, high = (float(v) for v in values)
    if not 0.0 < low <= middle <= high:
        raise ValueError(f"{name} is not three rising {'ratios' if name in _RATIOS else 'lengths'} above 0")
    return low, middle, high


def _variant(name: str, chosen: Any) -> dict[str, str]:
    """The settings of a variant as `--set` takes them: JSON's true is `true`."""
    fits = isinstance(chosen, dict) and chosen and all(isinstance(v, str | int | float) for v in chosen.values())
    if not fits:
        raise ValueError(f'the variant `{name}` is not a table of settings, such as {{"body": "StockPot"}}')
    return {key: str(value).lower() if isinstance(value, bool) else str(value) for key, value in chosen.items()}


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
    side = _sides(size, real)
    return [_compare(axis, side[:, k], None if real is None else getattr(real, axis)) for k, axis in enumerate(_AXES)]


def compare_ratios(size: np.ndarray, real: Real | None) -> list[Extent]:
    """The ratios of the sizes (B, 3) of objects that are known of real ones, beside those."""
    if real is None:
        return []
    side = _sides(size, real)
    deep = side[:, 2] > 0.0
    shares = {name: side[deep, k] / side[deep, 2] for k, name in enumerate(_RATIOS)}
    return [_compare(name, shares[name], known) for name, known in real.ratios.items() if len(shares[name])]


def _sides(size: np.ndarray, real: Real | None) -> np.ndarray:
    """(B, 3) width, depth, height."""
    side = size[:, [1, 0, 2]]
    if real is not None and real.turned:
        side[:, :2] = np.sort(side[:, :2], axis=1)[:, ::-1]
    return side


def _compare(name: str, found: np.ndarray, known: tuple[float, float, float] | None) -> Extent:
    low, middle, high = (float(v) for v in np.percentile(found, (5, 50, 95)))
    if known is None:
        return Extent(name, (low, middle, high), None, None, None)
    within = float(((found >= known[0]) & (found <= known[2])).mean())
    return Extent(name, (low, middle, high), known, within, middle / known[1])


__all__ = ["Extent", "Real", "compare_ratios", "compare_sizes", "measure_extents", "read_reference"]
