"""The other values that one choice, count or listed number of a candidate can have, and how much likelier the text has them."""

from __future__ import annotations

from collections.abc import Iterable

import numpy as np

from ..runtime.batch import Batch
from ..runtime.laws import TOLERANCE
from ..sampling.search import domain_ends
from .model import Changes, Model

_RARE = 1e-4  # a weight of what the text does not have
_COUNTED = 8  # a count changes by as much at a time, at most


def alternatives(model: Model, batch: Batch, numbers: Iterable[int] | None = None) -> Changes:
    """Every other value that one discrete row of a candidate can have, or one of the draws of some ``numbers``."""
    found: list[list[np.ndarray]] = [[], [], [], []]
    for number in (*model.discrete, *model.ruling) if numbers is None else numbers:
        draw = model.program.draws[number]
        owner, old = batch.owner(draw.column.scope), batch.state.values[number]
        if draw.kind == "choice":
            possible = [float(k) for k, weight in enumerate(draw.weights) if weight.constant != 0.0]
            options = np.broadcast_to(possible, (len(old), len(possible)))
        elif draw.kind == "count":
            low, high = domain_ends(batch, number)
            steps = np.arange(1.0, 1.0 + np.minimum(high - low, _COUNTED).max(initial=0.0))
            options = old[:, None] + np.concatenate([-steps, steps])
        else:
            options = np.stack(batch.read(draw.arguments, draw.column.scope), axis=1)
        rows, which = np.nonzero(np.abs(options - old[:, None]) > 1e-9)
        told = owner[rows], np.full(len(rows), number), rows, options[rows, which]
        for column, one in zip(found, told, strict=True):
            column.append(one)
    copy, draws, row, value = (np.concatenate([np.zeros(0, dtype=np.int64), *column]) for column in found)
    return Changes(copy, draws.astype(np.int64), row.astype(np.int64), value)


def odds_of(batch: Batch, told: Changes) -> np.ndarray:
    """(n,) by how much the text has the values of some changes more often than those that their rows have, in natural logarithms."""
    found = np.zeros(len(told.draw))
    for number in np.unique(told.draw).tolist():
        draw, mine = batch.program.draws[number], np.flatnonzero(told.draw == number)
        row, scope = told.row[mine], draw.column.scope
        if draw.kind == "choice":
            weights = np.stack(batch.read(draw.weights, scope), axis=1)[row]
            values = np.broadcast_to(np.arange(weights.shape[1]), weights.shape)
        elif draw.distribution in ("values", "weighted"):
            values = np.stack(batch.read(draw.arguments, scope), axis=1)[row]
            weights = np.ones(values.shape)
            if draw.distribution == "weighted":
                values, weights = np.split(values, 2, axis=1)
        else:
            continue
        now, then = (
            np.where(np.abs(values - one[:, None]) < TOLERANCE, weights, 0.0).sum(axis=1)
            for one in (batch.state.values[number][row], told.value[mine])
        )
        found[mine] = np.log(np.maximum(then, _RARE)) - np.log(np.maximum(now, _RARE))
    return found
