"""What labels say at points: their formulas in the frames of their targets, and whether what comes of them can be said.

Labels without a value at a place make an object invalid. That is looked for at places of its own, a grid on each surface, so
that an object does not depend on the points that are drawn on it.
"""

from __future__ import annotations

from functools import lru_cache
from typing import TYPE_CHECKING, Protocol

import numpy as np

from ..geometry.patches import surfaces
from ..geometry.points import evaluate_flat
from ..geometry.pointset import PointSet
from ..graph.expr import Scope, variables
from ..graph.program import Label, Program, Target
from ..native import backend
from ..native.points import in_frames
from ..runtime.fields import Field, FieldReader, read_pose, read_triples
from ..runtime.motion import apply
from .fault import Fault, Key, list_faults

if TYPE_CHECKING:
    from ..geometry.sites import SiteTable
    from ..runtime.batch import Batch

_ROUNDING = 1e-6  # so far may a degree lie outside 0 .. 1: it is set to the end
_CHUNK = 16_000  # points at a time: their arrays stay in the caches
_GRID = np.array([0.001, *((k + 0.5) / 16 for k in range(16)), 0.999])  # places on a surface, along either fraction


class BoundPoints(Protocol):
    """Points of any shape, each bound to a row of a table of sites, at joint values 0 in the object's frame."""

    @property
    def site(self) -> np.ndarray: ...
    @property
    def row(self) -> np.ndarray: ...
    @property
    def patch(self) -> np.ndarray: ...
    @property
    def u(self) -> np.ndarray: ...
    @property
    def v(self) -> np.ndarray: ...
    @property
    def position(self) -> np.ndarray: ...
    @property
    def normal(self) -> np.ndarray: ...


def select_on_surfaces(at: np.ndarray, table: SiteTable, target: Target, points: BoundPoints) -> np.ndarray:
    """Those of the flat point numbers ``at`` that lie on the surfaces a target names."""
    if not target.surfaces:
        return at
    declared = table.primitive.patches
    meant = [i for i, patch in enumerate(surfaces(table.primitive)) if declared[patch.declared].name in target.surfaces]
    return at[np.isin(np.asarray(points.patch).ravel()[at], meant)]


def evaluate_label(
    reader: FieldReader, label: Label, target: Target, at: np.ndarray, points: BoundPoints
) -> tuple[np.ndarray, np.ndarray]:
    """Those of the flat point numbers ``at``, all of one site, at which a label says something, and what: (k,) or (k, 3).

    Formulas are evaluated in the frame of the target; vectors are returned in the object's.
    """
    scope = reader.program.sites[target.site].scope
    field = Field.of(label.formulas)
    reads = [np.asarray(v) for v in reader.read(field.inputs, scope)] if field.inputs else []
    place = _Place(reader, target, scope, {name for name in field.names if "." in name}, bool(label.vector))
    rows, found = np.asarray(points.row).ravel(), []
    for start in range(0, len(at), _CHUNK):
        some = at[start : start + _CHUNK]
        row = rows[some]
        variables = {name: getattr(points, name).ravel()[some] for name in field.names if name in ("u", "v")}
        variables |= place.variables(row, some, points)
        guard, *values = (np.broadcast_to(v, some.shape) for v in field([r[row] for r in reads], variables))
        told = place.turned(row, np.stack(values, axis=-1)) if label.vector else values[0]
        found.append((some, told) if guard.all() else (some.compress(guard), told.compress(guard, axis=0)))
    return np.concatenate([f[0] for f in found]), np.concatenate([f[1] for f in found])


def is_degree(label: Label) -> bool:
    return label.vocabulary != "field" and not is_predicate(label)


def is_predicate(label: Label) -> bool:
    value = label.value
    return value.op in ("lt", "le", "eq", "and", "or", "not") or isinstance(value.value, bool)


def is_wrong(label: Label, told: np.ndarray) -> np.ndarray:
    """At which points (k,) what a label says is no number, or no degree from 0 to 1."""
    if told.dtype == bool:
        return np.zeros(len(told), dtype=bool)
    bad = ~np.isfinite(told)
    if is_degree(label):
        bad |= (told < -_ROUNDING) | (told > 1.0 + _ROUNDING)
    return bad.any(axis=-1) if bad.ndim > 1 else bad


def label_in_words(label: Label) -> str:
    """That a label says nothing that can be said at a point."""
    if label.vocabulary == "field":
        return f"the field `{label.name}` has no value at some point"
    return f"the label `{label.name}` is not a degree from 0 to 1 at some point"


# ---------------------------------------------------------------- validity


@lru_cache(maxsize=8)
def find_fallible(program: Program) -> tuple[Label, ...]:
    """The labels whose values depend on the point and may be none."""
    return tuple(label for label in program.labels if not is_predicate(label) and variables(label.formulas))


def find_unsaid(batch: Batch) -> list[Fault]:
    """Labels that have no value somewhere on the surfaces they lie on."""
    labels = find_fallible(batch.program)
    if not labels:
        return []
    sites = batch.sites()
    tables = {table.number: table for table in sites}
    wrong: list[tuple[Key, np.ndarray]] = []
    for label in labels:
        for target in label.targets:
            table = tables.get(target.site)
            if table is None or not len(table):
                continue
            points = _places(sites, table)
            at = select_on_surfaces(np.arange(points.site.size), table, target, points)
            if not len(at):
                continue
            at, told = evaluate_label(batch, label, target, at, points)
            rows = points.row.ravel()[at[is_wrong(label, told)]]
            wrong.append(((label_in_words(label), label.where, None), table.owner[rows]))
    return [fault for fault in list_faults(wrong) if len(fault.objects)]


def _places(sites: list[SiteTable], table: SiteTable) -> PointSet:
    """A grid on every surface of every row of a site, as far as the row has it: (points, 1)."""
    u, v = (a.ravel() for a in np.meshgrid(_GRID, _GRID, indexing="ij"))
    patches = len(surfaces(table.primitive))
    row = np.repeat(np.arange(len(table)), patches * len(u))
    patch = np.tile(np.repeat(np.arange(patches), len(u)), len(table))
    u, v = (np.tile(a, patches * len(table)) for a in (u, v))
    site = np.full(len(row), table.number)
    position, normal, exists = evaluate_flat(sites, table.owner[row], site, row, patch, u, v)
    return PointSet(*(x[exists, None] for x in (site, row, patch, u, v, position, normal)))


class _Place:
    """The variables ``p``, ``n`` and ``size`` of a target: those of their coordinates that ``names`` tells."""

    def __init__(self, reader: FieldReader, target: Target, scope: Scope, names: set[str], vector: bool):
        self.axes: dict[str, list[int]] = {}  # of each kind, in their order
        for name in sorted(names):
            kind, _, letter = name.partition(".")
            self.axes.setdefault(kind, []).append("xyz".index(letter))
        if vector or self.axes.keys() & {"p", "n"}:
            self.rotation, translation, self.mirror = read_pose(reader, target.frame, scope)
            self.columns = np.ascontiguousarray(self.rotation.reshape(-1, 9).T)
            self.translation = np.ascontiguousarray(translation.T)
        if self.axes.keys() & {"p", "size"}:
            size, center = read_triples(reader, [target.size, target.center], scope)
            self.size, self.center = np.ascontiguousarray(size.T), np.ascontiguousarray(center.T)

    def variables(self, row: np.ndarray, at: np.ndarray, points: BoundPoints) -> dict[str, np.ndarray]:
        """Values at the flat point numbers ``at``, whose rows are ``row``."""
        out: dict[str, np.ndarray] = {}
        for kind, axes in self.axes.items():
            if kind == "size":
                found = [self.size[axis][row] for axis in axes]
            else:
                vectors = points.position if kind == "p" else points.normal
                found = self._in_frames(row, at, vectors.reshape(-1, 3), axes, placed=kind == "p")
            out |= {f"{kind}.{'xyz'[axis]}": value for axis, value in zip(axes, found, strict=True)}
        return out

    def _in_frames(
        self, row: np.ndarray, at: np.ndarray, vectors: np.ndarray, axes: list[int], placed: bool
    ) -> list[np.ndarray]:
        """Some coordinates of vectors (m, 3) in the frames of rows, from the middle of the target on if they are ``placed`` in the object."""
        machine = backend.machine()
        if machine is not None:
            shift, center = (self.translation, self.center) if placed else (None, None)
            return in_frames(machine, vectors, at, row, (self.columns, shift, self.mirror, center), axes)
        away = [vectors[at, k] - self.translation[k][row] if placed else vectors[at, k] for k in range(3)]
        found = []
        for axis in axes:
            x, y, z = (self.columns[3 * k + axis][row] * away[k] for k in range(3))
            value = x + y + z
            value = value * self.mirror[row] if axis == 1 else value
            found.append(value - self.center[axis][row] if placed else value)
        return found

    def turned(self, row: np.ndarray, vectors: np.ndarray) -> np.ndarray:
        """Vectors of the target (m, 3) in the object's frame."""
        return apply(
            self.rotation[row], np.stack([vectors[:, 0], vectors[:, 1] * self.mirror[row], vectors[:, 2]], axis=-1)
        )
