"""Joints that follow another by a formula of its value: cams, cranks, levers that push off centre.

The formula is evaluated wherever the leader stands. Where only a factor and an offset serve, as in most formats of simulators,
the straight line between the ends of the leader's range stands in for it.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace
from typing import TYPE_CHECKING

import numpy as np

from ..errors import UserError
from ..graph.program import LEAD
from ..records import dataclass
from .fields import Field
from .needs import following
from .tables import JointTable

if TYPE_CHECKING:
    from .batch import Batch

_SHARES = np.linspace(0.0, 1.0, 33)  # of the leader's range, at which a formula is looked at and written to files
_BACK = 1e-9  # of what the follower covers: less is rounding


class TurnsBack(UserError):
    """A follower, the joint number ``definition`` of its program, does not rise or fall throughout its leader's range."""

    definition = -1


@dataclass(frozen=True, slots=True, eq=False)
class Curve:
    """The rows of one definition of a joint in the table of joints, the rows of their leaders, and how they follow."""

    row: np.ndarray
    leader: np.ndarray
    formulas: Field  # the value, and its derivative
    inputs: list[np.ndarray]

    def value(self, lead: np.ndarray) -> np.ndarray:
        """The followers' values (..., n) with their leaders at ``lead`` (..., n)."""
        return self._at(lead, 0)

    def rate(self, lead: np.ndarray) -> np.ndarray:
        """How many times as fast as their leaders the followers move there, (..., n)."""
        return self._at(lead, 1)

    def _at(self, lead: np.ndarray, which: int) -> np.ndarray:
        return np.asarray(self.formulas(self.inputs, {LEAD: lead})[which], dtype=np.float64)


def add_curves(table: JointTable, batch: Batch) -> JointTable:
    """The table with the curves of its followers, which rest where their leaders put them. Raises UserError where one turns
    back: no straight line stands in for that."""
    curves = tuple(_curves(table, batch))
    if not curves:
        return table
    multiplier, offset, rest = table.multiplier.copy(), table.offset.copy(), table.rest.copy()
    for curve in curves:
        lead, values = _sampled(table, curve)
        _refuse_turning(batch, table, curve, values)
        width = lead[-1] - lead[0]
        multiplier[curve.row] = (values[-1] - values[0]) / np.where(width == 0.0, 1.0, width)
        offset[curve.row] = values[0] - multiplier[curve.row] * lead[0]
        rest[curve.row] = curve.value(rest[curve.leader])
    return replace(table, multiplier=multiplier, offset=offset, rest=rest, curves=curves)


def tabulate(table: JointTable) -> dict[int, tuple[np.ndarray, np.ndarray]]:
    """By the row of a joint that follows by a formula: values (k,) over the range of its leader, and its own at these."""
    found: dict[int, tuple[np.ndarray, np.ndarray]] = {}
    for curve in table.curves:
        lead, values = _sampled(table, curve)
        wide = lead[-1] > lead[0]
        found |= {row: (lead[:, n], values[:, n]) for n, row in enumerate(curve.row.tolist()) if wide[n]}
    return found


def _sampled(table: JointTable, curve: Curve) -> tuple[np.ndarray, np.ndarray]:
    """Values (k, n) over the range of each leader, a turn where it has no ends, and those of its follower."""
    low, high = table.low[curve.leader], table.high[curve.leader]
    low = np.where(np.isnan(low), -np.pi, low)
    lead = low + _SHARES[:, None] * (np.where(np.isnan(high), np.pi, high) - low)
    return lead, curve.value(lead)


def _curves(table: JointTable, batch: Batch) -> Iterator[Curve]:
    program = batch.program
    if all(joint.curve is None for joint in program.joints):
        return
    base = np.searchsorted(table.owner, table.owner)
    places = [np.arange(batch.rowmap.rows(joint.scope).size) for joint in program.joints]
    place = batch.joint_instances.sort(places, dtype=np.int64)
    for number, joint in enumerate(program.joints):
        row = np.flatnonzero(table.definition == number)
        if joint.curve is None or not len(row):
            continue
        formulas = Field.of(following(joint))
        inputs = batch.read(formulas.inputs, joint.scope) if formulas.inputs else []
        yield Curve(
            row, base[row] + table.mimic[row], formulas, [np.asarray(v, dtype=np.float64)[place[row]] for v in inputs]
        )


def _refuse_turning(batch: Batch, table: JointTable, curve: Curve, values: np.ndarray) -> None:
    steps, least = np.diff(values, axis=0), -_BACK * np.ptp(values, axis=0)
    wrong = ~(((steps >= least).all(axis=0) | (steps <= -least).all(axis=0)) & np.isfinite(values).all(axis=0))
    if wrong.any():
        at = int(np.flatnonzero(wrong)[0])
        row, leader = int(curve.row[at]), int(curve.leader[at])
        definition = int(table.definition[row])
        joint = batch.program.joints[definition]
        error = TurnsBack(
            f"{joint.where}: object {batch.numbers[table.owner[row]]}: the joint `{table.name[row]}` does not rise or fall"
            f" throughout the range of `{table.name[leader]}`, which it follows",
            hint="narrow that range to where the formula of its `mimic` rises or falls and is defined, or close a loop of joints"
            " with `close`",
        )
        error.definition = definition
        raise error
