"""Test parameters of a primitive: the values at which its declaration is examined when it is compiled."""

from __future__ import annotations

from functools import lru_cache

import numpy as np

from .. import random
from ..graph.expr import Expr
from ..graph.primitive import Primitive
from .errors import PrimitiveError
from .patches import evaluate_rows, find_existing
from .split import Params

_OVERSAMPLE = 64  # candidates per wanted row: `requires` may refuse many
_PER_END = 3  # rows with one parameter at an end of its range, per end


@lru_cache(maxsize=512)
def _trial(primitive: Primitive, count: int) -> Params:
    parts = [_draw(primitive, count, {}, 0)]
    if len(parts[0][""]) == 0:
        raise PrimitiveError(primitive, None, "no values in its test ranges meet its requirements")
    fixed = [
        (name, value)
        for name, (low, high) in zip(primitive.parameters, primitive.test, strict=True)
        for value in (np.arange(low, high + 1) if name in primitive.whole else (low, high))
    ]
    for which, (name, value) in enumerate(fixed):
        parts.append(_draw(primitive, _PER_END, {name: float(value)}, 1 + which))
    return {name: np.concatenate([p[name] for p in parts]) for name in parts[0]}


def draw_trial(primitive: Primitive, count: int = 12) -> Params:
    """``count`` rows drawn over the test ranges, then some with each parameter at either end, or with every value of
    one that counts; all meet `requires`."""
    return dict(_trial(primitive, count))


def draw_any(primitive: Primitive, count: int) -> Params:
    """``count`` rows drawn over the test ranges, whether they meet `requires` or not."""
    return _values(primitive, count, {}, 0)


def _draw(primitive: Primitive, count: int, fixed: dict[str, float], attempt: int) -> Params:
    params = _values(primitive, count * _OVERSAMPLE, fixed, attempt)
    kept = np.flatnonzero(_allowed(primitive, primitive.requires, params))[:count]
    return {name: value[kept] for name, value in params.items()}


def _values(primitive: Primitive, count: int, fixed: dict[str, float], attempt: int) -> Params:
    number = np.arange(count, dtype=np.uint64)
    params: Params = {"": np.zeros(len(number))}
    for name, (low, high) in zip(primitive.parameters, primitive.test, strict=True):
        q = random.uniform(random.key(0, "trial", primitive.name, name), number, attempt=attempt)
        value = low + q * (high - low)
        if name in primitive.whole:
            value = np.floor(low + q * (high + 1 - low))
        elif low > 0:  # small ones too: every other row by ratio
            value = np.where(number % 2 == 1, np.clip(low * np.power(high / low, q), low, high), value)
        params[name] = np.full(len(number), fixed[name]) if name in fixed else value
    return params


def _allowed(primitive: Primitive, conditions: tuple[Expr, ...], params: Params) -> np.ndarray:
    """(k,) bool: which instances meet all conditions."""
    if not conditions:
        return np.ones(len(next(iter(params.values()))), dtype=bool)
    return np.logical_and.reduce(evaluate_rows(primitive, conditions, params, bool), axis=0)


@lru_cache(maxsize=512)
def variants(primitive: Primitive) -> dict[tuple[bool, ...], np.ndarray]:
    """Which patches can exist together: a tuple per variant, with the rows of ``draw_trial`` that show it."""
    there = find_existing(primitive, draw_trial(primitive))
    found: dict[tuple[bool, ...], list[int]] = {}
    for row, flags in enumerate(there.tolist()):
        found.setdefault(tuple(flags), []).append(row)
    return {flags: np.array(rows) for flags, rows in found.items()}
