"""A number per object that stands for all that can be observed of it: primitives, joints, materials, labels, grasps.

Not the names of parts, nor the boxes of templates, nor what was drawn: two objects that look, move and are labelled the
same have the same fingerprint, whatever text made them. It is a sum of hashes over rows, so their order does not count.
"""

from __future__ import annotations

from collections.abc import Iterable
from hashlib import blake2b

import numpy as np

from ..graph.expr import Expr, Scope
from ..graph.formula import row_values
from ..random import mix
from ..runtime.batch import Batch
from ..runtime.needs import pose_cells
from ..validity.materials import material_rows

_GRAIN = 1e-9  # metres, radians: what differs by less is the same


def fingerprint_objects(batch: Batch) -> np.ndarray:
    """(B,) uint64 per object of a batch."""
    return _Observer(batch).found


class _Observer:
    def __init__(self, batch: Batch):
        self.batch, self.program = batch, batch.program
        self.found = np.zeros(len(batch), dtype=np.uint64)
        self.sites()
        self.joints()
        self.labels()
        self.hands()

    def note(self, what: str, owner: np.ndarray, columns: Iterable[np.ndarray]) -> None:
        """Add the rows of a table to their objects."""
        if not len(owner):
            return
        head = int.from_bytes(blake2b(what.encode(), digest_size=8).digest(), "little")
        cells = np.stack([np.asarray(column, dtype=np.float64) for column in columns])
        whole = np.round(np.nan_to_num(cells, nan=-1e6) / _GRAIN).astype(np.int64).astype(np.uint64)
        place = np.arange(len(cells), dtype=np.uint64)[:, None]
        np.add.at(self.found, owner, mix(head, mix(whole, place).sum(axis=0, dtype=np.uint64)))  # wraps: no order

    def read(self, what: str, scope: Scope, exprs: Iterable[Expr]) -> None:
        self.note(what, self.batch.owner(scope), self.batch.read(list(exprs), scope))

    def sites(self) -> None:
        for table in self.batch.sites():
            pose = [*table.rotation.reshape(-1, 9).T, *table.translation.T, table.mirror]
            material = material_rows(self.batch, table)
            self.note(table.primitive.name, table.owner, [*table.params.values(), *pose, material])

    def joints(self) -> None:
        for joint in self.program.joints:
            there = [e for e in joint.values if e is not None]
            absent = "".join("-" if e is None else "+" for e in joint.values)
            cells = [*joint.origin, *joint.axis, *there, *(joint.mimic[1:] if joint.mimic is not None else ())]
            followed = [] if joint.curve is None else [joint.curve]
            shape = "".join(map(_shape_of, followed))
            self.read(f"joint {joint.kind} {absent}{shape}", joint.scope, [*cells, *row_values(followed)])
        for closure in self.program.closures:
            self.read("closure", closure.scope, [*closure.points[0], *closure.points[1]])

    def labels(self) -> None:
        for label in self.program.labels:
            inputs = row_values(label.formulas)
            shape = " ".join(_shape_of(f) for f in label.formulas)
            for target in label.targets:
                site = self.program.sites[target.site]
                cells = [*pose_cells(target.frame), *target.size, *target.center, *inputs]
                what = f"label {label.vocabulary}.{label.name} {site.primitive} {' '.join(target.surfaces)} {shape}"
                self.read(what, site.scope, cells)

    def hands(self) -> None:
        for grasp in self.program.grasps:
            formulas = list(grasp.formulas)
            cells = [*pose_cells(grasp.frame), *grasp.size, *grasp.center, grasp.low, grasp.high, *row_values(formulas)]
            self.read(f"grasp {grasp.name} {' '.join(map(_shape_of, formulas))}", grasp.scope, cells)
        for keypoint in self.program.keypoints:
            self.read(f"keypoint {keypoint.name}", keypoint.scope, keypoint.point)


def _shape_of(formula: Expr) -> str:
    """A formula as text without what stands in the rows of a table: those are compared by value."""
    if formula.op == "const":
        return repr(formula.value)
    if formula.op == "var":
        return str(formula.value)
    if formula.scope is not None and not formula.reads:
        return "_"
    return f"{formula.op}({', '.join(map(_shape_of, formula.args))})"
