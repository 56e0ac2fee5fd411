"""Objects as their values alone: what a batch is made of, as a few flat arrays, and the batch made of them again, the same to the bit.

``object`` (B,) the numbers; ``drawn`` (B,) the numbers that random values are addressed by; ``attempt``, ``lane``, ``salt`` (B,) the rest
of these addresses; ``rows`` (B, D) how many values the object has of each draw of the program; ``values`` these values, object by object,
draw by draw (choices as indices); ``repairs`` (B,) what was moved to make it valid, as JSON, nothing where nothing was.
"""

from __future__ import annotations

import json
from collections.abc import Mapping
from typing import TYPE_CHECKING

import numpy as np

from ..errors import UserError
from ..runtime import repairs
from ..runtime.batch import Batch
from ..runtime.kernels import State
from ..runtime.repairs import Repairs
from .known import keep_draw, make_batch
from .sample import Sampler

if TYPE_CHECKING:
    from ..graph.program import Program

TYPES = {
    "object": np.int64,
    "drawn": np.int64,
    "attempt": np.int32,
    "lane": np.int64,
    "salt": np.bytes_,
    "rows": np.uint16,
    "values": np.float64,
    "repairs": np.bytes_,
}
_AGAIN = "remove it, and give the command that wrote the folder again"


def to_columns(batch: Batch) -> dict[str, np.ndarray]:
    """The values of a batch."""
    state, draws, size = batch.state, batch.program.draws, len(batch)
    owners = [batch.owner(draw.column.scope) for draw in draws]
    rows = np.zeros((size, len(draws)), dtype=np.int64)
    for number, owner in enumerate(owners):
        rows[:, number] = np.bincount(owner, minlength=size)
    owner = np.concatenate([*owners, np.zeros(0, dtype=np.int64)])
    values = np.concatenate([*(state.values[k] for k in range(len(draws))), np.zeros(0)])
    told = [b""] * size
    for number in batch.repairs.objects().tolist():
        found = batch.repairs.of(np.array([number])).plain(batch.program)
        told[number] = json.dumps(found, ensure_ascii=False, separators=(",", ":")).encode()
    found_columns = {
        "object": batch.numbers,
        "drawn": state.objects,
        "attempt": state.attempt,
        "lane": state.lanes(),
        "salt": [state.salt.encode()] * size,
        "rows": rows,
        "values": values[np.argsort(owner, kind="stable")],
        "repairs": told,
    }
    return {name: np.array(found_columns[name], dtype=kind) for name, kind in TYPES.items()}


def take(columns: Mapping[str, np.ndarray], places: np.ndarray) -> dict[str, np.ndarray]:
    """The columns of the objects at some places, ascending."""
    wanted = np.zeros(len(columns["object"]), dtype=bool)
    wanted[places] = True
    held = np.repeat(wanted, columns["rows"].sum(axis=1, dtype=np.int64))
    return {name: array[held if name == "values" else wanted] for name, array in columns.items()}


def from_columns(
    sampler: Sampler, columns: Mapping[str, np.ndarray], seed: int, given: Mapping[int, float], name: str
) -> Batch:
    """The objects again; ``name`` is what messages call the file. Raises UserError for values that are not the program's."""
    program = sampler.program
    size, draws = len(columns["object"]), len(program.draws)
    rows, values = columns["rows"], columns["values"]
    lengths = rows.astype(np.int64).reshape(-1)
    if rows.shape != (size, draws) or lengths.sum() != len(values):
        raise UserError(f"{name} does not hold the values of {program.name}", _AGAIN)
    place = np.repeat(np.tile(np.arange(draws), size), lengths)
    ends = np.cumsum(rows.sum(axis=0, dtype=np.int64))[:-1]
    held = np.split(values[np.argsort(place, kind="stable")], ends) if draws else []
    salt = bytes(columns["salt"][0]).decode("utf-8", "replace") if size else ""
    said = (columns["drawn"], columns["attempt"].astype(np.int64))
    lane = columns["lane"]
    try:
        first = make_batch(program, sampler.plan, State(seed, *said, dict(enumerate(held)), salt=salt, lane=lane))
    except (ValueError, IndexError):  # more or fewer values than there are rows
        raise UserError(f"{name} does not hold the values of {program.name}", _AGAIN) from None
    if any(not np.array_equal(first.state.values[k], value) for k, value in enumerate(held)):
        raise UserError(f"{name} holds values that {program.name} does not take", _AGAIN)
    state = State(seed, *said, dict(given), salt=salt, lane=lane)
    everything = np.arange(size)
    state.kept = {k: keep_draw(first, k, everything) for k in range(draws)}
    found = make_batch(program, sampler.plan, state, columns["object"])
    found.repairs = Repairs.joined(
        [
            _read_repairs(program, owner, bytes(columns["repairs"][owner]), name)
            for owner in np.flatnonzero(columns["repairs"] != b"").tolist()
        ]
    )
    return found


def _read_repairs(program: Program, owner: int, told: bytes, name: str) -> Repairs:
    """What was moved of one object. Raises UserError."""
    try:
        return repairs.read_repairs(program, owner, json.loads(told))
    except (ValueError, KeyError, TypeError, OverflowError, RecursionError):
        raise UserError(f"{name} does not hold what was repaired of {program.name}", _AGAIN) from None
