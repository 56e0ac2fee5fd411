"""Objects of several batches put into one with all that is known of them: nothing is evaluated again."""

from __future__ import annotations

from collections.abc import Sequence
from functools import lru_cache
from typing import Any

import numpy as np

from ..geometry.runs import runs
from ..graph.expr import Scope
from ..runtime.batch import Batch
from ..runtime.kernels import Rows, State
from ..runtime.plan import Plan
from ..sampling.known import keep_draw
from ..validity.clearance import limit_joints


class _Gathered(Batch):
    """Objects that were evaluated in other batches. What their draws are kept by is worked out where something else is to be evaluated."""

    def _asked(self, *, weigh: bool = False) -> State:
        if not self.state.kept:
            every = np.arange(len(self))
            self.state.kept = {number: keep_draw(self, number, every) for number in range(len(self.program.draws))}
        return super()._asked(weigh=weigh)


class _Chosen:
    """The rows of all scopes that the objects ``chosen`` (B,), told by their place among those of all batches, have there."""

    def __init__(self, batches: list[Batch], chosen: np.ndarray):
        self._batches, self._chosen = batches, chosen
        self._before = np.cumsum([0, *map(len, batches)])
        self._known: dict[Scope, tuple[np.ndarray, np.ndarray, np.ndarray]] = {}

    def index(self, scope: Scope) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        """Which rows (n,), among those of all batches, these are; of each object its first (B,) there, and how many it has (B,)."""
        if scope not in self._known:
            if not self._rows(scope):
                none = np.zeros(len(self._chosen), dtype=np.int64)
                self._known[scope] = none[:0], none, none
                return self._known[scope]
            owners = [batch.owner(scope) + before for batch, before in zip(self._batches, self._before, strict=False)]
            owner = _joined(owners)
            first, last = (np.searchsorted(owner, self._chosen, side=side) for side in ("left", "right"))
            self._known[scope] = runs(first, last - first), first, last - first
        return self._known[scope]

    def _rows(self, scope: Scope) -> int:
        """How many rows the batches have, all together: none in most alternatives."""
        return sum([batch.rowmap.rows(scope).size for batch in self._batches])

    def of(self, scope: Scope, values: list[list[Any]]) -> list[Any]:
        """What the rows of a scope have of some values, each a list of what each batch has of it; or one number where all rows share it."""
        found: list[Any] = [one[0] for one in values]
        if not self._rows(scope):
            return found
        alike: dict[tuple[str, ...], list[int]] = {}  # taken together, columns of a kind: hundreds are a few calls
        for k, one in enumerate(values):
            if any(map(_is_column, one)) or any(value != one[0] for value in one[1:]):
                values[k] = one = [self._whole(scope, number, value) for number, value in enumerate(one)]
                alike.setdefault(tuple([column.dtype.char for column in one]), []).append(k)
        for places in alike.values():
            each = zip(*(values[k] for k in places), strict=True)
            parts = [np.concatenate(columns).reshape(len(places), -1) for columns in each]
            both = parts[0] if len(parts) == 1 else np.concatenate(parts, axis=1)
            for k, column in zip(places, both.take(self.index(scope)[0], axis=1), strict=True):
                found[k] = column
        return found

    def _whole(self, scope: Scope, number: int, value: Any) -> np.ndarray:
        """A value of one batch as a column."""
        return value if _is_column(value) else np.full(self._batches[number].rowmap.rows(scope).size, value)

    def table(self, scope: Scope) -> Rows:
        """The rows of a scope as a table of their own."""
        index, first, many = self.index(scope)
        if scope.parent is not None and not self._rows(scope):
            still = np.zeros(len(self.index(scope.parent)[0]), dtype=np.int64)
            return Rows(0, index, index, index, np.zeros(0, dtype=np.uint64), still, still)
        every, size = np.arange(len(many)), len(index)
        tables = [batch.rowmap.rows(scope) for batch in self._batches]
        address = _joined([table.address for table in tables])[index]
        if scope.parent is None:
            return Rows(
                size, every, np.zeros(size, dtype=np.int64), every, address, every, np.ones(size, dtype=np.int64)
            )
        above, above_first, above_many = self.index(scope.parent)
        owner, above_owner = np.repeat(every, many), np.repeat(every, above_many)
        parents, starts = [], []
        row = above_row = 0
        for table in tables:
            parents.append(table.parent + above_row)
            starts.append(table.start + row)
            row, above_row = row + table.size, above_row + len(table.count)
        parent = _joined(parents)[index] + (np.cumsum(above_many) - above_many - above_first)[owner]
        start = _joined(starts)[above] + (np.cumsum(many) - many - first)[above_owner]
        rank, count = (
            _joined([table.rank for table in tables])[index],
            _joined([table.count for table in tables])[above],
        )
        return Rows(size, parent, rank, owner, address, start, count)


def _is_column(value: Any) -> bool:
    return isinstance(value, np.ndarray) and value.ndim > 0


def _joined(arrays: list[np.ndarray]) -> np.ndarray:
    return arrays[0] if len(arrays) == 1 else np.concatenate(arrays)


def gather(parts: Sequence[tuple[Batch, np.ndarray]], places: Sequence[np.ndarray] | None = None) -> Batch:
    """The objects at the given rows of each of some batches of one plan, one after the other or at the given ``places``."""
    first = parts[0][0]
    batches = list(dict.fromkeys(batch for batch, _ in parts))
    begin = dict(zip(batches, np.cumsum([0, *map(len, batches)]).tolist(), strict=False))
    chosen = np.concatenate([begin[batch] + at for batch, at in parts])
    if places is not None:
        chosen = chosen[np.argsort(np.concatenate(places))]
    rows = _Chosen(batches, chosen)
    states = [batch.state for batch in batches]
    objects = _joined([state.objects for state in states])[chosen]
    lane = _joined([state.lanes() for state in states])[chosen]
    state = State(first.seed, objects, np.zeros(len(chosen), dtype=np.int64), lane=lane)
    state.failed, state.crowd, state.log_weight, state.leaning = (
        _joined([getattr(one, name) for one in states])[chosen] for name in ("failed", "crowd", "log_weight", "leaning")
    )
    plan = first.plan
    tables: list[Rows] = [rows.table(scope) for scope in plan.scopes]
    found: list[list[Any]] = []
    of_draws = [[one.values[number] for one in states] for number in range(len(first.program.draws))]
    of_plan = [[batch._values[number] for batch in batches] for number in range(len(plan.outputs))]
    for each, scopes in zip((of_draws, of_plan), _scopes(plan), strict=True):
        found.append([None] * len(each))
        for scope, numbers in scopes:
            for place, column in zip(numbers, rows.of(scope, [each[k] for k in numbers]), strict=True):
                found[-1][place] = column
    drawn, values = found
    state.values.update(enumerate(drawn))
    return _Gathered(first.program, plan, state, tables, values, ends=limit_joints)


@lru_cache(maxsize=8)
def _scopes(plan: Plan) -> tuple[list[tuple[Scope, list[int]]], ...]:
    """The scopes of the draws of a program, each with the places of its draws; and likewise of what a plan gives."""
    found = []
    for scopes in ([draw.column.scope for draw in plan.program.draws], [scope for _, scope in plan.outputs]):
        places: dict[Scope, list[int]] = {}
        for place, scope in enumerate(scopes):
            places.setdefault(scope, []).append(place)
        found.append(list(places.items()))
    return tuple(found)
