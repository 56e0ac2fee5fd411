"""Objects whose values are known, evaluated again: the same to the bit, alone, several times over, or with some changed.

A row of a table is known by its random address and its object's place in the batch: the ranks of the repeats that lead
to it. So elements of a repeat keep their values by rank, and the inputs of a role outlive the template.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from ..graph.program import Program
from ..random import mix
from ..records import dataclass
from ..runtime.batch import Batch
from ..runtime.kernels import Kept, State
from ..runtime.plan import Plan
from ..validity.clearance import limit_joints


@dataclass(frozen=True, slots=True, eq=False)
class DrawRows:
    """Rows of a draw for some objects of a batch, an object as often as it is named: ``row`` of the table, ``owner``
    (place among the objects named), ``key`` (what the row is known by)."""

    row: np.ndarray
    owner: np.ndarray
    key: np.ndarray


def rows_of_draw(batch: Batch, number: int, objects: np.ndarray) -> DrawRows:
    """The rows that draw ``number`` has in the objects at the given places of a batch."""
    rows = batch.rowmap.rows(batch.program.draws[number].column.scope)
    if not rows.size:
        none = np.zeros(0, dtype=np.int64)
        return DrawRows(none, none, rows.address)
    first = np.searchsorted(rows.owner, objects)
    count = np.searchsorted(rows.owner, objects, side="right") - first
    owner = np.repeat(np.arange(len(objects)), count)
    row = np.arange(len(owner)) - np.repeat(np.cumsum(count) - count, count) + np.repeat(first, count)
    return DrawRows(row, owner, mix(rows.address[row], owner))


def keep_draw(
    batch: Batch, number: int, objects: np.ndarray, reach: np.ndarray | None = None, swap: np.ndarray | None = None
) -> Kept:
    """What the objects at the given places have of a draw, to be kept as far as ``reach`` and ``swap`` (per row) say."""
    at = rows_of_draw(batch, number, objects)
    order = np.argsort(at.key, kind="stable")
    row = at.row[order]
    held = batch.state.values[number][row]
    still = np.zeros(len(row))
    return Kept(
        at.key[order], held, still if reach is None else reach[row], still.astype(bool) if swap is None else swap[row]
    )


def owners_kept(batch: Batch, number: int, objects: np.ndarray) -> np.ndarray:
    """For each value that ``keep_draw`` keeps, the place among the objects named."""
    at = rows_of_draw(batch, number, objects)
    return at.owner[np.argsort(at.key, kind="stable")]


def evaluate_again(
    batch: Batch,
    objects: np.ndarray,
    *,
    attempt: np.ndarray | None = None,
    lane: np.ndarray | None = None,
    salt: str | None = None,
    values: Sequence[Kept] | None = None,
    plan: Plan | None = None,
) -> Batch:
    """The objects at the given places of a batch with all the values they have, or with ``values`` (one per draw).

    ``attempt``, ``lane`` and ``salt`` what they are said to be drawn with; ``plan``
    another one of the program.
    """
    old = batch.state
    state = State(
        old.seed,
        old.objects[objects],
        old.attempt[objects] if attempt is None else attempt,
        dict(old.given),
        salt=old.salt if salt is None else salt,
        lane=old.lanes()[objects] if lane is None else lane,
        asked=old.asked_of(objects),
    )
    draws = range(len(batch.program.draws))
    state.kept = dict(enumerate(values)) if values is not None else {k: keep_draw(batch, k, objects) for k in draws}
    return make_batch(batch.program, plan or batch.plan, state, batch.numbers[objects])


def make_batch(program: Program, plan: Plan, state: State, numbers: np.ndarray | None = None) -> Batch:
    tables, values = plan.function(state)
    return Batch(program, plan, state, tables, values, numbers, ends=limit_joints)


def find_differing(before: Batch, objects: np.ndarray, after: Batch, numbers: Sequence[int] | None) -> np.ndarray:
    """Which objects of ``after`` differ in a draw from those at the given places of ``before``: (len(after),) bool."""
    found = np.zeros(len(after), dtype=bool)
    everything = np.arange(len(after))
    for number in range(len(after.program.draws)) if numbers is None else numbers:
        old, new = rows_of_draw(before, number, objects), rows_of_draw(after, number, everything)
        a, b = before.state.values[number][old.row], after.state.values[number][new.row]
        if len(old.key) == len(new.key) and np.array_equal(old.key, new.key):
            found[new.owner[a != b]] = True
            continue
        here, there = match_keys(old.key, new.key)
        found[new.owner[there[a[here] != b[there]]]] = True
        found[np.delete(old.owner, here)] = True
        found[np.delete(new.owner, there)] = True
    return found


def match_keys(first: np.ndarray, second: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Where keys that both hold lie in one and in the other."""
    _, here, there = np.intersect1d(first, second, assume_unique=True, return_indices=True)
    return here, there
