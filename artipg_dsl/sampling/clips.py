"""Which values of objects were moved, and why: by a bound that a requirement puts on them, their domain, or on purpose."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence

import numpy as np

from ..graph.program import Program
from ..records import dataclass
from ..runtime.batch import Batch
from ..runtime.kernels import full
from ..runtime.laws import TOLERANCE
from ..runtime.repairs import HOW, Cause, Repairs, find_yielding
from .known import match_keys, rows_of_draw
from .search import domain_ends

CLIPPED, HINT, SEARCH, REDRAWN = range(len(HOW))


@dataclass(frozen=True, slots=True, eq=False)
class Asked:
    """The values that objects should have, per draw and row of a batch (nan: any), and which of them someone stated.

    Those that nobody stated were drawn: they give way easily, and nobody is told.
    """

    values: list[np.ndarray]
    stated: list[np.ndarray]

    @staticmethod
    def all(batch: Batch, values: Sequence[np.ndarray] | None = None) -> Asked:
        """What a batch has, or what is given, all of it stated."""
        found = [batch.state.values[k] for k in range(len(batch.program.draws))] if values is None else list(values)
        return Asked(found, [np.ones(len(v), dtype=bool) for v in found])


@dataclass(frozen=True, slots=True, eq=False)
class Clips:
    """Rows whose value is not the one that was asked: object, draw, row, and what forbids the value asked (None: nothing
    that a bound of the draw would say)."""

    owner: np.ndarray
    draw: np.ndarray
    row: np.ndarray
    why: list[Cause | None]


def read_clipped(batch: Batch, asked: Asked) -> Clips:
    """What an evaluation has made of the values asked."""
    owner, draw, row, why = (
        [np.zeros(0, dtype=np.int64)],
        [np.zeros(0, dtype=np.int64)],
        [np.zeros(0, dtype=np.int64)],
        [],
    )
    for number, values in enumerate(asked.values):
        rows = np.flatnonzero(~(values == batch.state.values[number]) & asked.stated[number])
        if len(rows):
            owner.append(batch.owner(batch.program.draws[number].column.scope)[rows])
            draw.append(np.full(len(rows), number))
            row.append(rows)
            why.extend(_binding(batch, number, rows, values[rows])[1])
    return Clips(np.concatenate(owner), np.concatenate(draw), np.concatenate(row), why)


def _binding(batch: Batch, number: int, rows: np.ndarray, asked: np.ndarray) -> tuple[np.ndarray, list[Cause | None]]:
    """Of rows of a draw: whether their value is the legal one nearest to what was asked, and what keeps it there."""
    draw, scope = batch.program.draws[number], batch.program.draws[number].column.scope
    table = batch.rowmap.rows(scope)
    value = batch.state.values[number][rows]
    why: list[Cause | None] = [None] * len(rows)
    if draw.kind == "choice":
        for limit in draw.limits:
            allowed = full(table, batch.read([limit.allowed], scope)[0]).astype(bool)[rows]
            for k in np.flatnonzero(~allowed & (asked == limit.option)).tolist():
                why[k] = why[k] or ("requirement", limit.requirement)
        for k in np.flatnonzero(np.isnan(asked)).tolist():
            why[k] = ("absent", number)
        return np.array([w is not None for w in why], dtype=bool), why
    low, high = (end[rows] for end in domain_ends(batch, number))
    whole = draw.kind == "count"
    ends = {"low": np.ceil(low - TOLERANCE) if whole else low, "high": np.floor(high + TOLERANCE) if whole else high}
    reason = {side: np.full(len(rows), -1) for side in ends}  # the requirement of the tightest bound
    for bound in draw.bounds:
        end, guard = (full(table, e)[rows] for e in batch.read([bound.value, bound.guard], scope))
        end = np.where(guard.astype(bool), end, -np.inf if bound.side == "low" else np.inf).astype(np.float64)
        if whole:
            end = np.ceil(end - TOLERANCE) if bound.side == "low" else np.floor(end + TOLERANCE)
        tighter = end > ends[bound.side] if bound.side == "low" else end < ends[bound.side]
        ends[bound.side] = np.where(tighter, end, ends[bound.side])
        reason[bound.side][tighter] = bound.requirement
    nearest = np.minimum(np.maximum(asked, ends["low"]), ends["high"])
    legal = np.isnan(asked) | (np.abs(nearest - value) <= 1e-9 * np.maximum(1.0, np.abs(value)))
    legal &= ~((asked >= ends["low"] - TOLERANCE) & (asked <= ends["high"] + TOLERANCE))
    blamed = np.where(np.isnan(asked), -1, np.where(asked > value, reason["high"], reason["low"]))
    for k in np.flatnonzero(legal).tolist():
        kind = "absent" if np.isnan(asked[k]) else "domain"
        why[k] = ("requirement", int(blamed[k])) if blamed[k] >= 0 else (kind, number)
    return legal, why


@dataclass(frozen=True, slots=True, eq=False)
class Blame:
    """What was wrong with which objects (``failing``), and the draws behind each of these (``behind``)."""

    behind: Callable[[Cause], list[int]]
    failing: Mapping[Cause, np.ndarray]


def log_moved(before: Batch, asked: Asked, after: Batch, blame: Blame, redrawn: np.ndarray | None = None) -> Repairs:
    """The values that objects were to have (``asked``, per row of ``before``) and have not in ``after``, with the reasons.

    ``redrawn`` (objects,): those that were drawn again in part.
    """
    program, everything = after.program, np.arange(len(after))
    wrong: dict[int, list[Cause]] = {}
    for cause, objects in blame.failing.items():
        for owner in objects.tolist():
            wrong.setdefault(owner, []).append(cause)
    parts = []
    for number, draw in enumerate(program.draws):
        old, new = rows_of_draw(before, number, everything), rows_of_draw(after, number, everything)
        here, there = match_keys(old.key, new.key)
        wanted, rows = asked.values[number][old.row[here]], new.row[there]
        apart = np.flatnonzero(~(wanted == after.state.values[number][rows]) & asked.stated[number][old.row[here]])
        if not len(apart):
            continue
        apart = apart[np.argsort(rows[apart], kind="stable")]
        wanted, rows = wanted[apart], rows[apart]
        owner = after.owner(draw.column.scope)[rows]
        legal, why = _binding(after, number, rows, wanted)
        names = after.rowmap.names(draw.column.scope, draw.column.name)
        how = np.where(legal, CLIPPED, SEARCH)
        how[np.isnan(wanted) | (legal & (draw.kind == "choice"))] = REDRAWN
        causes: list[Cause] = []
        for k, (place, bound) in enumerate(zip(owner.tolist(), why, strict=True)):
            if bound is not None:
                causes.append(bound)
                continue
            cause, hinted = _blamed(blame, wrong.get(place, []), number, program)
            how[k] = HINT if hinted else REDRAWN if redrawn is not None and redrawn[place] else SEARCH
            causes.append(cause)
        parts.append(
            Repairs(
                owner,
                np.full(len(rows), number),
                [names[k] for k in rows],
                wanted,
                after.state.values[number][rows],
                how,
                causes,
            )
        )
    return Repairs.joined(parts)


def _blamed(blame: Blame, wrong: Sequence[Cause], number: int, program: Program) -> tuple[Cause, bool]:
    """What a value was moved for on purpose, and whether the text says that it should give way."""
    for cause in wrong:
        if number in find_yielding(program, cause):
            return cause, True
    for cause in wrong:
        if number in blame.behind(cause):
            return cause, False
    return (wrong[0] if wrong else ("draw", number)), False
