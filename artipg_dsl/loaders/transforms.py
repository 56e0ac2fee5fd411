"""Augmentations: functions of a batch's arrays and of random numbers that belong to its objects.

A transform is called with the arrays of a batch and a ``Draws``, and returns arrays. What is given is not changed. Any function of that
form is one. Those that take points away fill up with points that are left, so that arrays keep their shapes, and work on ``partial`` where
the task has it, on the points and all that is known of them where it has not.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable
from inspect import signature

import numpy as np

from ..arguments import read_amount, read_whole
from ..errors import UsageError
from ..records import dataclass
from .draws import Draws
from .tasks import Arrays

Transform = Callable[[Arrays, Draws], Arrays]

_PLACES = ("points", "partial")
_VECTORS = (*_PLACES, "normals", "motion")
_PER_BATCH = ("object", "category")
_MOST_PIXELS = 1 << 20  # of a side: farther apart no float32 tells points
_AXES = {"x": 0, "y": 1, "z": 2}
_NUMBERS = "biuf"
_RETURNS = "it returns the NumPy arrays by name: arrays | {...}"


def read_transforms(given: Iterable[Transform]) -> list[Transform]:
    """Functions, in their order. Raises UsageError."""
    if not isinstance(given, Iterable):
        raise UsageError(f"transforms is {given!r}", f"give a list: [{given!r}]")
    found = list(given)
    for one in found:
        if not callable(one) or isinstance(one, type):
            raise UsageError(f"{one!r} is not a transform", "give functions, such as Jitter()")
        if not _takes_two(one):
            raise UsageError(
                f"the transform {one!r} cannot be called with the arrays of a batch and their draws",
                "it is a function of both: def flip(arrays, draws)",
            )
    return found


def _takes_two(function: Transform) -> bool:
    try:
        signature(function).bind(None, None)
    except TypeError:
        return False
    except ValueError:  # some that are built in have no signature
        return True
    return True


def apply_transform(transform: Transform, arrays: Arrays, draws: Draws) -> Arrays:
    """What a transform makes of the arrays of a batch, whose types stay. Raises UsageError where it is not as many objects, or no arrays of
    numbers at all."""
    made = transform(arrays, draws)
    if not isinstance(made, dict):
        raise UsageError(f"the transform {transform!r} gives {type(made).__name__}", _RETURNS)
    if "points" not in made:
        raise UsageError(f"the transform {transform!r} gives no `points`", _RETURNS)
    count, found = len(arrays["points"]), {}
    for name, array in made.items():
        if not isinstance(array, np.ndarray):
            raise UsageError(f"the transform {transform!r} makes {name!r} {type(array).__name__}", _RETURNS)
        if array.shape[:1] != (count,):
            raise UsageError(
                f"the transform {transform!r} makes {name!r} of shape {array.shape}",
                f"the first axis is that of the {count} objects",
            )
        dtype = arrays[name].dtype if name in arrays else array.dtype
        if array.dtype.kind not in _NUMBERS or not np.can_cast(array.dtype, dtype, "same_kind"):
            kinds = "numbers" if name not in arrays else f"{dtype}"
            raise UsageError(f"the transform {transform!r} makes {name!r} of type {array.dtype}", f"it holds {kinds}")
        found[name] = array.astype(dtype, copy=False)
    return found


@dataclass(frozen=True, slots=True)
class Normalise:
    """Moves the middle of the box of ``points`` to 0 and scales to a radius of 1; ``by="partial"`` measures what is seen."""

    by: str = "points"

    def __post_init__(self) -> None:
        _check(self.by in _PLACES, f"{self.by!r} are not places to normalise by", f"these are {', '.join(_PLACES)}")

    def __call__(self, arrays: Arrays, draws: Draws) -> Arrays:
        if self.by not in arrays:
            raise UsageError(f"these batches have no {self.by!r} to normalise by", 'Normalise(by="points")')
        seen = arrays[self.by].astype(np.float64)
        middle = (seen.min(axis=1, keepdims=True) + seen.max(axis=1, keepdims=True)) / 2
        away = seen - middle
        radius = np.sqrt((away * away).sum(axis=-1).max(axis=1))[:, None, None]
        radius = np.where(radius > 0, radius, 1.0)
        changed = {n: ((arrays[n] - middle) / radius).astype(np.float32) for n in _PLACES if n in arrays}
        if "motion" in arrays:
            changed["motion"] = (arrays["motion"] / radius).astype(np.float32)
        return arrays | changed


@dataclass(frozen=True, slots=True)
class Turn:
    """Turns each object by a random angle, at most ``degrees`` to either side, about an axis of the object's frame."""

    degrees: float = 180.0
    axis: str = "z"

    def __post_init__(self) -> None:
        read_amount("degrees", self.degrees)
        _check(
            isinstance(self.axis, str) and self.axis in _AXES, f"there is no axis {self.axis!r}", "the axes are x, y, z"
        )

    def __call__(self, arrays: Arrays, draws: Draws) -> Arrays:
        angle = np.radians(self.degrees) * (2 * draws.uniform() - 1)[:, None]
        cos, sin = np.cos(angle), np.sin(angle)
        i, j = (k for k in range(3) if k != _AXES[self.axis])
        i, j = (j, i) if self.axis == "y" else (i, j)
        changed = {}
        for name in _VECTORS:
            if name in arrays:
                out = arrays[name].astype(np.float64)
                a, b = out[..., i].copy(), out[..., j].copy()
                out[..., i], out[..., j] = cos * a - sin * b, sin * a + cos * b
                changed[name] = out.astype(np.float32)
        return arrays | changed


@dataclass(frozen=True, slots=True)
class Scale:
    """Scales each object by a random factor from ``low`` to ``high``."""

    low: float = 0.8
    high: float = 1.25

    def __post_init__(self) -> None:
        read_amount("low", self.low)
        read_amount("high", self.high)
        _check(0 < self.low <= self.high, f"{self.low} to {self.high} is not a range of factors", "0 < low <= high")

    def __call__(self, arrays: Arrays, draws: Draws) -> Arrays:
        factor = (self.low + (self.high - self.low) * draws.uniform())[:, None, None]
        return arrays | {n: (arrays[n] * factor).astype(np.float32) for n in (*_PLACES, "motion") if n in arrays}


@dataclass(frozen=True, slots=True)
class Jitter:
    """Normal noise on the places that a network is shown, ``sigma`` in their unit, no more than ``clip``."""

    sigma: float = 0.01
    clip: float = 0.05

    def __post_init__(self) -> None:
        read_amount("sigma", self.sigma)
        read_amount("clip", self.clip)

    def __call__(self, arrays: Arrays, draws: Draws) -> Arrays:
        name = _shown(arrays)
        noise = np.clip(self.sigma * draws.normal(*arrays[name].shape[1:]), -self.clip, self.clip)
        return arrays | {name: (arrays[name] + noise).astype(np.float32)}


@dataclass(frozen=True, slots=True)
class Drop:
    """Loses a random share of the points, at most ``share``, differently for each object."""

    share: float = 0.5

    def __post_init__(self) -> None:
        _check_share(self.share)

    def __call__(self, arrays: Arrays, draws: Draws) -> Arrays:
        name = _shown(arrays)
        n = arrays[name].shape[1]
        left = np.maximum(1, np.ceil(n * (1 - self.share * draws.uniform()))).astype(np.int64)
        return _keep(arrays, name, draws.order(n) < left[:, None], draws)


@dataclass(frozen=True, slots=True)
class Occlude:
    """Cuts off by a random plane the ``share`` of the points that lie farthest along its normal."""

    share: float = 0.25

    def __post_init__(self) -> None:
        _check_share(self.share)

    def __call__(self, arrays: Arrays, draws: Draws) -> Arrays:
        name = _shown(arrays)
        n = arrays[name].shape[1]
        along = np.einsum("bnk,bk->bn", arrays[name].astype(np.float64), draws.direction())
        rank = np.argsort(np.argsort(along, axis=1, kind="stable"), axis=1, kind="stable")
        return _keep(arrays, name, rank < max(1, round(n * (1 - self.share))), draws)


@dataclass(frozen=True, slots=True)
class View:
    """What is seen from one random side, far away: of the points in a pixel the nearest, and those at most ``depth`` behind it.

    ``pixels``: of the longer side of the cloud; ``depth``: a share of the cloud's diameter. A depth buffer of points, an approximation;
    task ``completion`` casts rays at the solids.
    """

    pixels: int = 32
    depth: float = 0.05

    def __post_init__(self) -> None:
        read_whole("pixels", self.pixels, 1, _MOST_PIXELS)
        read_amount("depth", self.depth)

    def __call__(self, arrays: Arrays, draws: Draws) -> Arrays:
        name = _shown(arrays)
        cloud = arrays[name].astype(np.float64)
        b, n = cloud.shape[:2]
        look = draws.direction()
        side = np.where(np.abs(look[:, 2:]) < 0.9, [[0.0, 0.0, 1.0]], [[1.0, 0.0, 0.0]])
        across = np.cross(look, side)
        across /= np.sqrt((across * across).sum(axis=-1, keepdims=True))
        frame = np.stack([across, np.cross(look, across), look], axis=1)
        place = np.einsum("bnk,bak->bna", cloud, frame)
        place -= place.min(axis=1, keepdims=True)
        size = place.max(axis=1)
        step = np.maximum(size[:, :2].max(axis=1), 1e-12)[:, None, None] / self.pixels
        pixel = np.minimum(place[..., :2] / step, self.pixels - 1).astype(np.int64)
        at = (np.arange(b)[:, None] * self.pixels + pixel[..., 0]) * self.pixels + pixel[..., 1]
        known, at = np.unique(at.ravel(), return_inverse=True)  # those that show a point: of all there may be too many
        nearest = np.full(len(known), np.inf)
        np.minimum.at(nearest, at, place[..., 2].ravel())
        slack = self.depth * np.sqrt((size * size).sum(axis=-1))
        return _keep(arrays, name, place[..., 2] <= nearest[at].reshape(b, n) + slack[:, None], draws)


def _shown(arrays: Arrays) -> str:
    return "partial" if "partial" in arrays else "points"


def _keep(arrays: Arrays, name: str, kept: np.ndarray, draws: Draws) -> Arrays:
    """The points (B, n) that are kept, in their order, then some of them again at random until there are n."""
    b, n = kept.shape
    left = kept.sum(axis=1)
    first = np.argsort(~kept, axis=1, kind="stable")
    again = (draws.uniform(n) * left[:, None]).astype(np.int64)
    place = np.where(np.arange(n) < left[:, None], np.arange(n), again)
    chosen = np.take_along_axis(first, place, axis=1)
    names = [name] if name == "partial" else [m for m in arrays if m not in _PER_BATCH]
    return arrays | {m: arrays[m][np.arange(b)[:, None], chosen] for m in names}


def _check(holds: bool, wrong: str, hint: str) -> None:
    if not holds:
        raise UsageError(wrong, hint)


def _check_share(share: float) -> None:
    read_amount("share", share)
    _check(0 <= share < 1, f"{share} of the points cannot be taken away", "give a share from 0 to below 1")
