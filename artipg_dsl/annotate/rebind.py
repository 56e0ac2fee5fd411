"""Points bound to a program, placed again: on the same objects after their parameters have changed, or from a file."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace
from typing import TYPE_CHECKING

import numpy as np

from ..errors import UsageError
from ..geometry import points as geometry
from ..geometry.patches import surfaces
from ..geometry.pointset import PointSet
from .cloud import Points, complete

if TYPE_CHECKING:
    from ..runtime.batch import Batch

_BINDING = ("primitive", "element", "patch", "u", "v")
_HINT = "bind points of the same program, as `points` gives them or a points shard holds them"


def rebind(
    batch: Batch, points: Points | Mapping[str, np.ndarray], states: np.ndarray | None = None, *, motion: bool = False
) -> Points:
    """The same places on the objects of a batch: the formulas of their patches at (u, v), and all labels anew.

    ``points``: of another batch of the program with as many objects, such as the one that this was mutated from, or
    the arrays of a points shard, whose ``object`` names the objects. What has lost its primitive (another template, a
    lower count) or its patch is not ``bound``. Places are where the formulas say, whether they can still be seen or
    not. Raises UsageError.
    """
    owner, (site, element, patch, u, v) = _binding(batch, points)
    tables = batch.sites()
    _require_places(batch, site, element, patch, u, v)
    every = np.arange(len(batch))
    first = np.array([np.searchsorted(table.owner, every) for table in tables])
    count = np.array([np.searchsorted(table.owner, every, side="right") for table in tables]) - first
    row = first[site, owner[:, None]] + element
    flat = np.flatnonzero(element < count[site, owner[:, None]])
    whose = np.repeat(owner, site.shape[1])[flat]
    order = np.argsort(whose, kind="stable")
    flat, whose = flat[order], whose[order]
    columns = [x.ravel()[flat] for x in (site, row, patch, u, v)]
    position, normal, exists = geometry.evaluate_flat(tables, whose, *columns)
    kept = np.flatnonzero(exists)
    flat, made = flat[kept], PointSet(*(x[kept, None] for x in (*columns, position, normal)))
    known = complete(batch, made, whose[kept], states, motion)

    def spread(values: np.ndarray, missing: float, own: int = 1) -> np.ndarray:
        """Values (k, [states,] 1, ...) of the points that are bound, in their places among all (P, [states,] n, ...);
        each has ``own`` axes."""
        values = np.squeeze(values, axis=values.ndim - 1 - own if values.ndim > 1 + own else 1)
        out = np.full((site.size, *values.shape[1:]), missing, dtype=values.dtype)
        out[flat] = values
        out = out.reshape(*site.shape, *values.shape[1:])
        return np.moveaxis(out, 2, 1) if values.ndim == 2 + own else out

    bound = np.zeros(site.size, dtype=bool)
    bound[flat] = True
    numbers = {name: spread(getattr(known, name), -1) for name in ("semantic", "instance", "link", "material")}
    unsaid = {name: np.nan if name.startswith("field.") and a.dtype != bool else 0 for name, a in known.labels.items()}
    labels = {name: spread(a, unsaid[name]) for name, a in known.labels.items()}
    return replace(
        known,
        object=owner,
        position=spread(known.position, np.nan),
        normal=spread(known.normal, np.nan),
        npcs=spread(known.npcs, np.nan),
        **numbers,
        primitive=site.astype(np.int32),
        element=element,
        patch=patch.astype(np.int16),
        u=u,
        v=v,
        labels=labels,
        motion=None if known.motion is None else spread(known.motion, np.nan),
        drivers=None if known.drivers is None else spread(known.drivers, -1),
        velocities=None if known.velocities is None else spread(known.velocities, np.nan, 2),
        bound=bound.reshape(site.shape),
        acting=None if known.acting is None else {name: spread(values, -1) for name, values in known.acting.items()},
    )


def _require_places(
    batch: Batch, site: np.ndarray, element: np.ndarray, patch: np.ndarray, u: np.ndarray, v: np.ndarray
) -> None:
    """Raise UsageError for points that are bound where no object of the program has a place."""
    patches = np.array([len(surfaces(table.primitive)) for table in batch.sites()], dtype=np.int64)
    for name, column in (("primitive", site), ("element", element), ("patch", patch)):
        if (column < 0).any():
            raise UsageError(f"`{name}` has {column.min()}: numbers count from 0", _HINT)
    if (site >= len(patches)).any():
        raise UsageError(f"{batch.program.name} has no primitive {site.max()}", _HINT)
    if (patch >= patches[site]).any():
        raise UsageError("points are bound to patches that their primitives do not have", _HINT)
    if not ((u >= 0) & (u <= 1) & (v >= 0) & (v <= 1)).all():
        raise UsageError("points are bound to places beyond 0 .. 1 on their patches", _HINT)


def _binding(batch: Batch, points: Points | Mapping[str, np.ndarray]) -> tuple[np.ndarray, list[np.ndarray]]:
    """The objects (P,) as indices in the batch, and the arrays (P, n) of ``_BINDING``."""
    if isinstance(points, Points):
        owner, found = points.object, [getattr(points, name) for name in _BINDING]
        if len(owner) and owner.max() >= len(batch):
            raise UsageError(f"points of {owner.max() + 1} objects on a batch of {len(batch)}", _HINT)
    elif not isinstance(points, Mapping):
        raise UsageError(f"points is {points!r}", _HINT)
    else:
        missing = [name for name in ("object", *_BINDING) if name not in points]
        if missing:
            raise UsageError(f"the points have no array `{missing[0]}`", _HINT)
        numbers, found = np.asarray(points["object"]), [np.asarray(points[name]) for name in _BINDING]
        owner = np.minimum(np.searchsorted(batch.numbers, numbers), max(len(batch) - 1, 0))
        unknown = np.flatnonzero(batch.numbers[owner] != numbers)
        if len(unknown):
            raise UsageError(f"object {numbers[unknown[0]]} is not in the batch", "make a batch of the points' objects")
    shapes = {array.shape for array in found}
    if len(shapes) != 1 or len(shape := next(iter(shapes))) != 2 or shape[0] != len(owner):
        raise UsageError("the arrays of the points are not of one shape, (objects, points)", _HINT)
    kinds = (np.int64, np.int64, np.int64, np.float64, np.float64)
    return owner, [array.astype(kind) for array, kind in zip(found, kinds, strict=True)]
