"""Labels of sampled points: every label formula applied to all points of a site at once."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Protocol

import numpy as np

from ..errors import UserError
from ..geometry.patches import surfaces
from ..graph.expr import Scope
from ..graph.program import Label, Target
from .fields import Field, Reader, read_pose, read_triples
from .frames import reflect, rotate

if TYPE_CHECKING:
    from ..geometry.sites import SiteTable

ROUNDING = 1e-6  # so far may a degree lie outside 0 .. 1: it is set to the end
_CHUNK = 16_000  # points at a time: their arrays stay in the caches


class Points(Protocol):
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


@dataclass(frozen=True, slots=True)
class Labels:
    """``semantic`` (B, n) ids into the vocabulary; ``fields`` such as ``affordance.pull``, (B, n) bool or float32.

    A field of vectors is (B, n, 3), in the object's frame. A point outside all targets is False, 0 (graded) or nan
    (a field).
    """

    semantic: np.ndarray
    fields: dict[str, np.ndarray]


def label_points(
    reader: Reader, sites: list[SiteTable], points: Points, labels: Sequence[Label] | None = None
) -> Labels:
    """Labels of points at joint values 0, where ``points.position`` and ``normal`` are in the object's frame.

    ``Program.labels`` run from the outer targets to the inner ones. Within one vocabulary the deepest label that holds
    at a point wins; those of one depth unite (in ``semantic``, which has one word per point, the later wins). Of one
    field the innermost counts.
    ``labels``: those of whole vocabularies that are wanted, all by default.
    """
    labels = reader.program.labels if labels is None else labels
    tables = {table.number: table for table in sites}
    rows, flat_site = np.asarray(points.row).ravel(), np.asarray(points.site).ravel()
    chosen = by_site(reader, tables, points)

    semantic = np.zeros(flat_site.shape, dtype=np.int64)
    for number, table in tables.items():
        semantic[chosen[number]] = table.semantic[rows[chosen[number]]]

    fields = empty_fields(labels, flat_site.shape)
    levels = {label.vocabulary: np.full(flat_site.shape, -1, dtype=np.int16) for label in labels}
    classes = {name: i for i, name in enumerate(reader.program.vocabularies.get("semantic", ()))}
    for label in labels:
        for target in label.targets:
            if target.site not in tables:
                continue
            at = on_surfaces(chosen[target.site], tables[target.site], target, points)
            if not len(at):
                continue
            at, value = evaluate(reader, label, target, at, points)
            if label.vocabulary == "semantic":
                semantic[at[value > 0]] = classes[label.name]
                continue
            into = fields[field_name(label)]
            if label.vocabulary == "field":  # the innermost one says what it is
                into[at] = value
                continue
            outdo(label, at[value > 0], levels[label.vocabulary], fields)
            into[at] = merge(into[at], value)
    shape = np.asarray(points.site).shape
    made = {name: finish(field).reshape(shape + field.shape[1:]) for name, field in fields.items()}
    return Labels(semantic.reshape(shape), made)


def by_site(reader: Reader, tables: Mapping[int, SiteTable], points: Points) -> dict[int, np.ndarray]:
    """The flat numbers of the points of each site, ascending."""
    flat_site = np.asarray(points.site).ravel()
    narrow = flat_site.astype(np.int16) if len(reader.program.sites) < 2**15 else flat_site  # sorted by its digits
    order = np.argsort(narrow, kind="stable")
    edges = np.searchsorted(flat_site[order], np.arange(len(reader.program.sites) + 1))
    return {number: order[edges[number] : edges[number + 1]] for number in tables}


def holding(
    reader: Reader, sites: list[SiteTable], points: Points, labels: Sequence[Label]
) -> Iterator[tuple[Label, Target, np.ndarray]]:
    """For each label (whole vocabularies, outer ones first) and target the flat numbers of the points at which it holds
    and no deeper one does; what holds nowhere is left out."""
    tables = {table.number: table for table in sites}
    chosen = by_site(reader, tables, points)
    levels = {label.vocabulary: np.full(points.site.size, -1, dtype=np.int16) for label in labels}
    found = []
    for label in labels:
        for target in label.targets:
            if target.site not in tables:
                continue
            at = on_surfaces(chosen[target.site], tables[target.site], target, points)
            if len(at):
                at, value = evaluate(reader, label, target, at, points)
                at, level = at[value > 0], levels[label.vocabulary]
                level[at] = np.maximum(level[at], label.depth)
                found.append((label, target, at))
    for label, target, at in found:
        own = at[levels[label.vocabulary][at] == label.depth]
        if len(own):
            yield label, target, own


def outdo(label: Label, at: np.ndarray, level: np.ndarray, fields: dict[str, np.ndarray]) -> None:
    """Where ``label`` holds (flat point numbers ``at``), take back what less deep ones of its vocabulary have said."""
    over = at[level[at] < label.depth]
    level[over] = label.depth
    for name, field in fields.items():
        if name.startswith(f"{label.vocabulary}."):
            field[over] = 0


def field_name(label: Label) -> str:
    return f"{label.vocabulary}.{label.name}"


def field_kinds(labels: Sequence[Label]) -> dict[str, str]:
    """The kind of each label array but ``semantic``, in the order of names.

    "mask" (bool), "grade" (0 .. 1), "field" or "vectors". A name is a mask only if all its labels are predicates.
    """
    kinds: dict[str, str] = {}
    for label in labels:
        if label.vocabulary == "semantic":
            continue
        name, other = field_name(label), "field" if label.vocabulary == "field" else "grade"
        kind = "vectors" if label.vector else "mask" if is_predicate(label) else other
        kinds[name] = kind if kinds.get(name, kind) == kind else other
    return dict(sorted(kinds.items()))


def is_predicate(label: Label) -> bool:
    value = label.value
    return value.op in ("lt", "le", "eq", "and", "or", "not") or isinstance(value.value, bool)


def empty_fields(labels: Sequence[Label], shape: tuple[int, ...]) -> dict[str, np.ndarray]:
    empty = {"mask": False, "grade": 0.0, "field": np.nan, "vectors": np.nan}
    kinds = field_kinds(labels).items()
    return {name: np.full((*shape, 3) if kind == "vectors" else shape, empty[kind]) for name, kind in kinds}


def merge(old: np.ndarray, new: np.ndarray) -> np.ndarray:
    """Where several labels of one name cover a point: or, or the larger number."""
    return old | new if old.dtype == bool else np.fmax(old, new)


def finish(field: np.ndarray) -> np.ndarray:
    return field if field.dtype == bool else field.astype(np.float32)


def on_surfaces(at: np.ndarray, table: SiteTable, target: Target, points: Points) -> np.ndarray:
    """Those of the flat point numbers ``at`` that lie on the surfaces a target names."""
    if not target.surfaces:
        return at
    meant = [i for i, patch in enumerate(surfaces(table.primitive)) if patch.name in target.surfaces]
    return at[np.isin(np.asarray(points.patch).ravel()[at], meant)]


def evaluate(
    reader: Reader, label: Label, target: Target, at: np.ndarray, points: Points
) -> tuple[np.ndarray, np.ndarray]:
    """Those of the flat point numbers ``at``, all of one site, at which a label says something, and what: (k,) or (k, 3).

    Formulas are evaluated in the frame of the target; vectors are returned in the object's.
    """
    scope = reader.program.sites[target.site].scope
    field = Field(label.formulas)
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
        kept = (some, told) if guard.all() else (some[guard], told[guard])
        found.append((kept[0], legal(label, kept[1], reader, scope, rows[kept[0]])))
    return np.concatenate([f[0] for f in found]), np.concatenate([f[1] for f in found])


def legal(label: Label, told: np.ndarray, reader: Reader, scope: Scope, row: np.ndarray) -> np.ndarray:
    """What a label says at points of the rows ``row``: numbers, and degrees from 0 to 1. Raises UserError."""
    if told.dtype == bool:
        return told
    kind = "field" if label.vocabulary == "field" else "degree"
    bad = ~np.isfinite(told)
    if kind == "degree" and not is_predicate(label):
        bad |= (told < -ROUNDING) | (told > 1.0 + ROUNDING)
        told = np.clip(told, 0.0, 1.0)
    if bad.any():
        first = int(np.flatnonzero(bad.any(axis=-1) if bad.ndim > 1 else bad)[0])
        place = int(np.asarray(reader.owner(scope))[row[first]])
        number = getattr(reader, "numbers", np.arange(place + 1))[place]
        what = "has no value" if kind == "field" else "is not a degree from 0 to 1"
        raise UserError(
            f"{label.where}: the {'field' if kind == 'field' else 'label'} `{label.name}` {what} at a point of object {number}",
            "say with `where` at which points it holds, or keep the formula in its range with `min` and `max`",
        )
    return told


class _Place:
    """The variables ``p``, ``n`` and ``size`` of a target: those of their coordinates that ``names`` tells."""

    def __init__(self, reader: Reader, target: Target, scope: Scope, names: set[str], vector: bool):
        self.names, self.kinds = sorted(names), {name.partition(".")[0] for name in names}
        if vector or self.kinds & {"p", "n"}:
            self.rotation, translation, self.mirror = read_pose(reader, target.frame, scope)
            self.columns = np.ascontiguousarray(self.rotation.reshape(-1, 9).T)
            self.translation = np.ascontiguousarray(translation.T)
        if self.kinds & {"p", "size"}:
            size, center = read_triples(reader, [target.size, target.center], scope)
            self.size, self.center = np.ascontiguousarray(size.T), np.ascontiguousarray(center.T)

    def variables(self, row: np.ndarray, at: np.ndarray, points: Points) -> dict[str, np.ndarray]:
        """Values at the flat point numbers ``at``, whose rows are ``row``."""
        away = {}
        if "p" in self.kinds:
            position = points.position.reshape(-1, 3)
            away["p"] = [position[at, k] - self.translation[k][row] for k in range(3)]
        if "n" in self.kinds:
            normal = points.normal.reshape(-1, 3)
            away["n"] = [normal[at, k] for k in range(3)]
        out = {}
        for name in self.names:
            kind, _, letter = name.partition(".")
            axis = "xyz".index(letter)
            if kind == "size":
                out[name] = self.size[axis][row]
                continue
            x, y, z = (self.columns[3 * k + axis][row] * away[kind][k] for k in range(3))
            value = x + y + z
            value = value * self.mirror[row] if axis == 1 else value
            out[name] = value - self.center[axis][row] if kind == "p" else value
        return out

    def turned(self, row: np.ndarray, vectors: np.ndarray) -> np.ndarray:
        """Vectors of the target (m, 3) in the object's frame."""
        return rotate(self.rotation[row], reflect(vectors, self.mirror[row]))
