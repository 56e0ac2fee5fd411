"""Values of counts and choices that the requirements leave no object, or hardly any: found among first attempts at objects."""

from __future__ import annotations

import math

import numpy as np

from ..geometry.runs import distinct
from ..graph.interval import Intervals
from ..graph.program import Draw
from ..records import dataclass
from ..runtime.batch import Batch
from ..runtime.kernels import State, TooMany
from ..runtime.laws import Law, Room
from ..sampling.known import make_batch

_ATTEMPTS = 256  # at as many objects: hardly dearer than at a few, as all are one evaluation
_DUE = 16.0  # times that a value would have to occur: that it never does is then no chance
_HARDLY = 1 / 20  # of the times that it is due
_MOST = 64  # values of a count: of more, none is due often enough


@dataclass(frozen=True, slots=True)
class Excluded:
    """A value of a draw (an index of the program) that ``kept`` of the objects have that ``tried`` it; where ``tried`` is 0, the draw
    itself leaves it out. ``requirements`` (indices) are what it breaks or what leaves it out, the first the most often."""

    draw: int
    value: float
    tried: int
    kept: int
    requirements: tuple[int, ...]


def find_excluded(batch: Batch) -> list[Excluded]:
    """The values that a draw should often have by its law, and that hardly any valid object has, while it has others.

    Judged by the requirements alone, not by the solids. ``batch`` gives the program and its plan.
    """
    program = batch.program
    state = State(0, np.arange(_ATTEMPTS), np.zeros(_ATTEMPTS, dtype=np.int64))
    try:
        tried = make_batch(program, batch.plan, state)
    except TooMany:  # which is told of the objects that have too many rows
        return []
    intervals = Intervals(program.draws, program.definitions)
    found = []
    for number, draw in enumerate(program.draws):
        shares = _find_shares(draw, intervals)
        if not shares or number not in state.values:
            continue
        owner, values = tried.owner(draw.column.scope), state.values[number]
        valid = ~state.failed[owner]
        for value, share in shares.items():
            due, have = share * float(valid.sum()), values == value
            if due < _DUE or (have & valid).sum() > _HARDLY * due:
                continue
            objects = distinct(owner[have])
            left = have.sum() <= _HARDLY * share * len(owner)  # it is not even tried
            causes = _left_out_by(draw, value) if left else _broken_by(tried, objects[state.failed[objects]])
            if causes:
                kept = len(distinct(owner[have & valid]))
                found.append(Excluded(number, value, 0 if left else len(objects), kept, causes))
    return found


def _find_shares(draw: Draw, intervals: Intervals) -> dict[float, float]:
    """The least share of its law that each value of a count or a choice has, where all objects have the same law."""
    if draw.kind == "choice":
        weights = [intervals.of(weight) for weight in draw.weights]
        total = sum(max(high, 0.0) for _, high in weights)
        return {float(k): low / total for k, (low, _) in enumerate(weights)} if 0.0 < total < math.inf else {}
    if draw.kind != "count":
        return {}
    numbers = [*draw.ends, *draw.arguments]
    known = [float(number.constant) for number in numbers if number is not None and number.constant is not None]
    if len(known) < len(numbers) or known[1] - known[0] > _MOST:
        return {}
    values = np.arange(math.ceil(known[0]), math.floor(known[1]) + 1.0)
    if draw.distribution == "uniform":
        first, last = known[2:] or known[:2]
        levels = ((values >= first) & (values <= last)).astype(np.float64)
    else:
        law, room = Law(draw.distribution, tuple(known[2:])), Room(values - 0.5, values + 0.5)
        levels = np.broadcast_to(law.measure(room), values.shape)
    total = float(levels.sum())
    return dict(zip(values.tolist(), (levels / total).tolist(), strict=True)) if total > 0.0 else {}


def _left_out_by(draw: Draw, value: float | None = None) -> tuple[int, ...]:
    """The requirements that limit a draw, or that may leave out one of its values."""
    limits = [limit.requirement for limit in draw.limits if value is None or limit.option == value]
    limits += [bound.requirement for bound in draw.bounds] + [union.requirement for union in draw.unions]
    return tuple(dict.fromkeys(limits))


def _broken_by(batch: Batch, objects: np.ndarray) -> tuple[int, ...]:
    """The requirements that objects break, or that leave one of their draws no room; the one of most objects first."""
    program = batch.program
    count: dict[int, int] = {}
    for (kind, about), rows in batch.state.faults.items():
        scope = program.requirements[about].scope if kind == "requirement" else program.draws[about].column.scope
        struck = np.isin(objects, batch.owner(scope)[np.concatenate(rows)]).sum()
        for requirement in [about] if kind == "requirement" else _left_out_by(program.draws[about]):
            count[requirement] = count.get(requirement, 0) + int(struck)
    return tuple(sorted((r for r, many in count.items() if many), key=lambda r: (-count[r], r)))
