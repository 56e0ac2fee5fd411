"""Labels of sampled points: every label formula applied to all points of a site at once."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from typing import TYPE_CHECKING

import numpy as np

from ..errors import UserError
from ..graph.program import Label, Target
from ..records import dataclass
from ..runtime.fields import FieldReader
from ..validity.formulas import (
    BoundPoints,
    evaluate_label,
    is_degree,
    is_predicate,
    is_wrong,
    label_in_words,
    select_on_surfaces,
)

if TYPE_CHECKING:
    from ..geometry.sites import SiteTable


@dataclass(frozen=True, slots=True)
class Labels:
    """``semantic`` (B, n) ids into the vocabulary; ``fields`` such as ``affordance.pull``, (B, n) bool or float32.

    A field of vectors is (B, n, 3), in the object's frame. A point outside all targets is False, 0 (graded) or nan
    (a field).
    """

    semantic: np.ndarray
    fields: dict[str, np.ndarray]


def label_points(
    reader: FieldReader, sites: list[SiteTable], points: BoundPoints, labels: Sequence[Label] | None = None
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
    chosen = _by_site(reader, tables, points)

    semantic = np.zeros(flat_site.shape, dtype=np.int64)
    for number, table in tables.items():
        semantic[chosen[number]] = table.semantic[rows[chosen[number]]]

    fields = _empty_fields(labels, flat_site.shape)
    levels = {label.vocabulary: np.full(flat_site.shape, -1, dtype=np.int16) for label in labels}
    classes = {name: i for i, name in enumerate(reader.program.vocabularies.get("semantic", ()))}
    for label in labels:
        for target in label.targets:
            if target.site not in tables:
                continue
            at = select_on_surfaces(chosen[target.site], tables[target.site], target, points)
            if not len(at):
                continue
            at, value = _evaluate(reader, label, target, at, points)
            if label.vocabulary == "semantic":
                semantic[at.compress(value > 0)] = classes[label.name]
                continue
            into = fields[field_name(label)]
            if label.vocabulary == "field":  # the innermost one says what it is
                into[at] = value
                continue
            _outdo(label, at.compress(value > 0), levels[label.vocabulary], fields)
            into[at] = _merge(into[at], value)
    shape = np.asarray(points.site).shape
    made = {name: _finish(field).reshape(shape + field.shape[1:]) for name, field in fields.items()}
    return Labels(semantic.reshape(shape), made)


def _by_site(reader: FieldReader, tables: Mapping[int, SiteTable], points: BoundPoints) -> dict[int, np.ndarray]:
    """The flat numbers of the points of each site, ascending."""
    flat_site = np.asarray(points.site).ravel()
    narrow = flat_site.astype(np.int16) if len(reader.program.sites) < 2**15 else flat_site  # sorted by its digits
    order = np.argsort(narrow, kind="stable")
    edges = np.searchsorted(flat_site[order], np.arange(len(reader.program.sites) + 1))
    return {number: order[edges[number] : edges[number + 1]] for number in tables}


def select_holding(
    reader: FieldReader, sites: list[SiteTable], points: BoundPoints, labels: Sequence[Label]
) -> Iterator[tuple[Label, Target, np.ndarray]]:
    """For each label (whole vocabularies, outer ones first) and target the flat numbers of the points at which it holds
    and no deeper one does; what holds nowhere is left out."""
    tables = {table.number: table for table in sites}
    chosen = _by_site(reader, tables, points)
    levels = {label.vocabulary: np.full(points.site.size, -1, dtype=np.int16) for label in labels}
    found = []
    for label in labels:
        for target in label.targets:
            if target.site not in tables:
                continue
            at = select_on_surfaces(chosen[target.site], tables[target.site], target, points)
            if len(at):
                at, value = _evaluate(reader, label, target, at, points)
                at, level = at.compress(value > 0), levels[label.vocabulary]
                level[at] = np.maximum(level[at], label.depth)
                found.append((label, target, at))
    for label, target, at in found:
        own = at.compress(levels[label.vocabulary][at] == label.depth)
        if len(own):
            yield label, target, own


def _outdo(label: Label, at: np.ndarray, level: np.ndarray, fields: dict[str, np.ndarray]) -> None:
    """Where ``label`` holds (flat point numbers ``at``), take back what less deep ones of its vocabulary have said."""
    over = at.compress(level[at] < label.depth)
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


def _empty_fields(labels: Sequence[Label], shape: tuple[int, ...]) -> dict[str, np.ndarray]:
    empty = {"mask": False, "grade": 0.0, "field": np.nan, "vectors": np.nan}
    kinds = field_kinds(labels).items()
    return {name: np.full((*shape, 3) if kind == "vectors" else shape, empty[kind]) for name, kind in kinds}


def _merge(old: np.ndarray, new: np.ndarray) -> np.ndarray:
    """Where several labels of one name cover a point: or, or the larger number."""
    return old | new if old.dtype == bool else np.fmax(old, new)


def _finish(field: np.ndarray) -> np.ndarray:
    return field if field.dtype == bool else field.astype(np.float32)


def _evaluate(
    reader: FieldReader, label: Label, target: Target, at: np.ndarray, points: BoundPoints
) -> tuple[np.ndarray, np.ndarray]:
    """Those of the flat point numbers ``at``, all of one site, at which a label says something, and what: (k,) or (k, 3).

    Numbers, and degrees from 0 to 1. Raises UserError.
    """
    at, told = evaluate_label(reader, label, target, at, points)
    wrong = np.flatnonzero(is_wrong(label, told))
    if len(wrong):
        row = np.asarray(points.row).ravel()[at[wrong[0]]]
        place = int(np.asarray(reader.owner(reader.program.sites[target.site].scope))[row])
        number = getattr(reader, "numbers", np.arange(place + 1))[place]
        raise UserError(
            f"{'' if label.where is None else f'{label.where}: '}{label_in_words(label)} of object {number}",
            "say with `where` at which points it holds, or keep the formula in its range with `min` and `max`",
        )
    return at, told if told.dtype == bool or not is_degree(label) else np.clip(told, 0.0, 1.0)
