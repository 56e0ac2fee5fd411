"""Draws of the generated code: a value per row within what the requirements leave, by the address of its row alone.

A draw has its value from what its object is asked for, else from what is given, else from what was kept, else from its default where those
are wanted, else from its law.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from functools import wraps
from typing import Any

import numpy as np

from ..graph.program import Draw
from ..random import key, uniform
from .kernels import Kept, Rows, State, full
from .laws import (
    TOLERANCE,
    density,
    fits,
    gaps_of,
    in_gap,
    is_empty,
    is_listed,
    measure,
    move_out_of_gaps,
    spread,
    spread_between,
    step_along,
    support_of,
    values_of,
)

Gaps = tuple[np.ndarray, np.ndarray]  # where gaps begin and end: (gaps, rows) each
LEAST = 1e-300  # a range that holds less of its law than this counts as holding so much


def narrow(low: np.ndarray, high: np.ndarray, side: str, bound: np.ndarray | float, guard: np.ndarray | bool) -> None:
    """Narrow the open interval in place by a bound where its guard holds."""
    if side == "low":
        np.maximum(low, np.where(guard, bound, -np.inf), out=low)
    else:
        np.minimum(high, np.where(guard, bound, np.inf), out=high)


def _lot(state: State, rows: Rows, address: str) -> np.ndarray:
    names = (address, state.salt) if state.salt else (address,)
    lane = 0 if state.lane is None else state.lane[rows.owner]
    return uniform(key(state.seed, *names), rows.address, lane, state.attempt[rows.owner])


def _no_room(state: State, rows: Rows, number: int, bad: np.ndarray) -> None:
    if bad.any():
        owners = rows.owner[bad]
        state.failed[owners] = True
        state.missed[number] = state.missed.get(number, 0) + int(np.count_nonzero(np.bincount(owners)))
        state.faults.setdefault(("draw", number), []).append(np.flatnonzero(bad))


def _unmoved(state: State, rows: Rows, number: int) -> np.ndarray | None:
    """The values kept of a draw, if every row has one that it keeps as far as it can: then nothing is drawn."""
    kept = state.kept.get(number)
    if kept is None or kept.reach.any() or kept.swap.any():
        return None
    known, at = kept.find(rows)
    return kept.value[at] if known.all() else None


def _require_value(
    state: State,
    rows: Rows,
    number: int,
    bad: np.ndarray,
    ends: tuple[np.ndarray, np.ndarray],
    gaps: Gaps | None,
    distribution: str,
    arguments: tuple[Any, ...],
) -> None:
    """Rows that are left none of the values of their law fail, unless their value is kept and fits."""
    if not _is_confined(distribution, arguments):
        return
    empty = is_empty(*ends, gaps, distribution, arguments)
    if number in state.kept:
        known, at = state.kept[number].find(rows)
        if known.any():
            empty &= ~(known & fits(state.kept[number].value[at], *ends, gaps))
    _no_room(state, rows, number, empty & ~bad)


def _is_confined(distribution: str, arguments: tuple[Any, ...]) -> bool:
    """Whether a law says where its values lie; others have some density everywhere."""
    return bool(arguments) and distribution not in ("normal", "lognormal")


def _given(
    state: State, rows: Rows, number: int, low: np.ndarray | float, high: np.ndarray | float, gaps: Gaps | None = None
) -> np.ndarray | None:
    """The value given for a draw, if any; an object that has no room for it fails (and goes on with a legal value)."""
    value = state.given.get(number)
    if value is None:
        return None
    found = full(rows, value).astype(np.float64)
    bad = ~((found >= low - TOLERANCE) & (found <= high + TOLERANCE))
    _no_room(state, rows, number, bad if gaps is None else bad | in_gap(found, gaps))
    return np.where(bad, low, found)


def _each_its_own(draw: Callable[..., np.ndarray]) -> Callable[..., np.ndarray]:
    """A draw of which some objects are asked for a value: drawn as if all were, and as if none was, and each object has its own of it."""

    @wraps(draw)
    def drawn(state: State, rows: Rows, number: int, *how: Any) -> np.ndarray:
        value = state.asked.get(number)
        if value is None:
            return draw(state, rows, number, *how)
        free = np.isnan(value)
        found = np.empty(rows.size)
        for given, own in (
            ({**state.given, number: np.where(free, 0.0, value)[rows.owner]}, ~free),
            (state.given, free),
        ):
            nothing = np.zeros(len(own))
            way = replace(
                state, given=given, failed=nothing > 0, missed={}, faults={}, values={}, log_weight=nothing.copy()
            )
            found = np.where(own[rows.owner], draw(way, rows, number, *how), found)
            for bad in way.faults.get(("draw", number), []):
                mine = np.zeros(rows.size, dtype=bool)
                mine[bad] = own[rows.owner[bad]]
                _no_room(state, rows, number, mine)
            state.log_weight += np.where(own, way.log_weight, 0.0)
        state.values[number] = found
        return found

    return drawn


@_each_its_own
def draw_real(
    state: State,
    rows: Rows,
    number: int,
    address: str,
    low: np.ndarray,
    high: np.ndarray,
    distribution: str,
    arguments: tuple[Any, ...],
    default: np.ndarray | float | None,
    domain: tuple[Any, ...] | None = None,
    unions: tuple[Any, ...] = (),
) -> np.ndarray:
    """A value between ``low`` and ``high`` per row, distributed as asked within them.

    ``domain``: the ends of the declared range, where it is another one. ``unions`` as ``laws.gaps_of`` has them.
    """
    gaps = gaps_of(low, unions, False) if unions else None
    found = _given(state, rows, number, low, high, gaps)
    if found is None:
        bad = ~(low <= high + TOLERANCE)  # nor is there room between ends that are no numbers
        _no_room(state, rows, number, bad)
        top = np.maximum(low, high)
        if state.defaults and default is not None:
            found = np.minimum(np.maximum(full(rows, default).astype(np.float64), low), top)
            found = found if gaps is None else move_out_of_gaps(found, low, top, gaps)
        elif (held := _unmoved(state, rows, number)) is not None:
            found = np.minimum(np.maximum(held, low), top)
            found = found + 0.0 if gaps is None else move_out_of_gaps(found, low, top, gaps)  # -0.0 is 0.0
            if _is_confined(distribution, arguments) and (found != held).any():
                found = _near(state.kept[number], rows, found, low, top, found, gaps, distribution, arguments)
                _require_value(state, rows, number, bad, (low, top), gaps, distribution, arguments)
        else:
            unit = _lot(state, rows, address)
            found = _spread(unit, low, top, gaps, distribution, arguments)
            _require_value(state, rows, number, bad, (low, top), gaps, distribution, arguments)
            if number in state.kept:
                found = _near(state.kept[number], rows, unit, low, top, found, gaps, distribution, arguments)
        if gaps is not None:
            _no_room(state, rows, number, in_gap(found, gaps) & ~bad)
    if state.weigh and domain is not None:
        _weigh(state, rows, number, found, (low, high), domain, gaps, distribution, arguments)
    state.values[number] = found
    return found


def _spread(
    unit: np.ndarray,
    low: np.ndarray,
    high: np.ndarray,
    gaps: Gaps | None,
    distribution: str,
    arguments: tuple[Any, ...],
) -> np.ndarray:
    if gaps is None:
        return spread(unit, low, high, distribution, arguments)
    return spread_between(unit, low, high, gaps, distribution, arguments)


def _weigh(
    state: State,
    rows: Rows,
    number: int,
    value: np.ndarray,
    ends: tuple[Any, ...],
    domain: tuple[Any, ...],
    gaps: Gaps | None,
    distribution: str,
    arguments: tuple[Any, ...],
) -> None:
    """Note how much of the declared law lies in the range that was left of it, or how likely a value given is by it."""
    whole = measure(
        full(rows, domain[0]).astype(np.float64),
        full(rows, domain[1]).astype(np.float64),
        None,
        distribution,
        arguments,
    )
    part = (
        density(value, distribution, arguments)
        if number in state.given
        else measure(ends[0], ends[1], gaps, distribution, arguments)
    )
    _note(state, rows, part, whole, number in state.given)


def _note(state: State, rows: Rows, part: np.ndarray, whole: np.ndarray, dense: bool = False) -> None:
    share = np.where(whole > 0.0, part / np.where(whole > 0.0, whole, 1.0), 1.0)
    share = np.maximum(share if dense else np.minimum(share, 1.0), LEAST)
    state.log_weight += np.bincount(rows.owner, weights=np.log(share), minlength=len(state.objects))


def _near(
    kept: Kept,
    rows: Rows,
    unit: np.ndarray,
    low: np.ndarray,
    high: np.ndarray,
    fresh: np.ndarray,
    gaps: Gaps | None,
    distribution: str,
    arguments: tuple[Any, ...],
) -> np.ndarray:
    """Within reach of the value kept, as far as the bounds and the law allow; the fresh value for rows that are new."""
    known, at = kept.find(rows)
    if not known.any():
        return fresh
    old, reach = kept.value[at], kept.reach[at]
    if is_listed(distribution):
        values = values_of(distribution, arguments)
        return np.where(known, step_along(unit, old, reach, kept.swap[at], low, high, gaps, values), fresh)
    if _is_confined(distribution, arguments):  # a value that stays may lie elsewhere, as one that was given
        stays = (reach == 0.0) & fits(old, low, high, gaps)
        tight = support_of(low, high, distribution, arguments)
        low, high = np.where(stays, low, tight[0]), np.where(stays, high, tight[1])
    first = np.minimum(np.maximum(old - reach, low), high)
    last = np.minimum(np.maximum(old + reach, low), high)
    if gaps is not None:
        room = first < last
        near = np.where(room, spread_between(unit, first, last, gaps, "uniform", ()), first) if room.any() else first
        return np.where(known, move_out_of_gaps(near, low, high, gaps), fresh)
    return np.where(known, np.minimum(first + unit * (last - first), last), fresh)


@_each_its_own
def draw_count(
    state: State,
    rows: Rows,
    number: int,
    address: str,
    low: np.ndarray,
    high: np.ndarray,
    distribution: str,
    arguments: tuple[Any, ...],
    default: np.ndarray | float | None,
    domain: tuple[Any, ...] | None = None,
    unions: tuple[Any, ...] = (),
) -> np.ndarray:
    """A whole number between ``low`` and ``high`` per row; ``domain`` and ``unions`` as of ``draw_real``."""
    gaps = gaps_of(low, unions, True) if unions else None
    first, last = np.ceil(low - TOLERANCE), np.floor(high + TOLERANCE)
    found = _given(state, rows, number, first, last, gaps)
    if found is None:
        bad, moved = ~(first <= last), False
        _no_room(state, rows, number, bad)
        last = np.maximum(first, last)
        if (held := _unmoved(state, rows, number)) is not None:
            found = np.minimum(np.maximum(held, first), last)
            moved = _is_confined(distribution, arguments) and bool((found != held).any())
        elif state.defaults and default is not None:
            found = np.minimum(np.maximum(full(rows, default).astype(np.float64), first), last)
        elif distribution == "uniform" and gaps is None:
            unit = _lot(state, rows, address)
            one, two = _whole(first, last, distribution, arguments)
            found = np.minimum(one + np.floor(unit * (two - one + 1.0)), two)
        else:
            one, two = _whole(first, last, distribution, arguments)
            law = () if distribution == "uniform" else arguments
            wide = _spread(_lot(state, rows, address), one - 0.5, two + 0.5, gaps, distribution, law)
            found = np.floor(wide + 0.5)
            found = found if is_listed(distribution) else np.minimum(np.maximum(found, one), two)
        if moved or (held is None and not (state.defaults and default is not None)):
            _require_value(
                state, rows, number, bad, (first, last), gaps, distribution, _rounded(distribution, arguments)
            )
        if moved or (held is None and number in state.kept):
            unit = _lot(state, rows, address)
            found = _other_count(state.kept[number], rows, unit, first, last, found, gaps, distribution, arguments)
        if gaps is not None:
            found = (
                np.floor(move_out_of_gaps(found, first - 0.5, last + 0.5, gaps) + 0.5)
                if state.defaults or (state.kept and not is_listed(distribution))
                else found
            )
            _no_room(state, rows, number, in_gap(found, gaps) & ~bad)
    if state.weigh and domain is not None:
        one, two = _whole(first, last, distribution, arguments)
        least, most = (full(rows, end).astype(np.float64) for end in domain)
        least, most = _whole(np.ceil(least - TOLERANCE), np.floor(most + TOLERANCE), distribution, arguments)
        law = () if distribution == "uniform" else arguments
        ends = (found, found) if number in state.given else (one, two)
        part = measure(ends[0] - 0.5, ends[1] + 0.5, gaps, distribution, law)
        _note(state, rows, part, measure(least - 0.5, most + 0.5, None, distribution, law))
    state.values[number] = found
    return found


def _whole(
    first: np.ndarray, last: np.ndarray, distribution: str, arguments: tuple[Any, ...]
) -> tuple[np.ndarray, np.ndarray]:
    """The whole numbers of a range in which a law lies."""
    first, last = support_of(first, last, distribution, arguments)
    return np.ceil(first - TOLERANCE), np.floor(last + TOLERANCE)


def _rounded(distribution: str, arguments: tuple[Any, ...]) -> tuple[Any, ...]:
    """The arguments of a law for whole numbers: ``uniform(a, b)`` from the first to the last of them."""
    if distribution != "uniform" or not arguments:
        return arguments
    return np.ceil(arguments[0] - TOLERANCE), np.floor(arguments[1] + TOLERANCE)


def _other_count(
    kept: Kept,
    rows: Rows,
    unit: np.ndarray,
    first: np.ndarray,
    last: np.ndarray,
    fresh: np.ndarray,
    gaps: Gaps | None,
    distribution: str,
    arguments: tuple[Any, ...],
) -> np.ndarray:
    """The count kept, moved into the range; another one of its law where that is asked for and there is one."""
    known, at = kept.find(rows)
    if not known.any():
        return fresh
    value, swap = kept.value[at], kept.swap[at]
    if is_listed(distribution):
        reach, values = np.where(swap, np.inf, 0.0), values_of(distribution, arguments)
        return np.where(known, step_along(unit, value, reach, swap, first, last, gaps, values), fresh)
    if _is_confined(distribution, arguments):
        stays = ~swap & fits(value, first, last, None)
        tight = _whole(first, last, distribution, arguments)
        first, last = np.where(stays, first, tight[0]), np.where(stays, last, tight[1])
    old = np.minimum(np.maximum(value, first), last)
    other = np.minimum(first + np.floor(unit * (last - first)), last)
    other = np.where(other >= old, np.minimum(other + 1.0, last), other)
    return np.where(known, np.where(swap & (last > first), other, old), fresh)


@_each_its_own
def draw_choice(
    state: State,
    rows: Rows,
    number: int,
    address: str,
    weights: tuple[Any, ...],
    declared: tuple[Any, ...] | None = None,
    default: np.ndarray | float | None = None,
) -> np.ndarray:
    """The index of one of the options, by weight; ``declared`` are the weights before requirements removed some."""
    table = np.stack([np.broadcast_to(np.asarray(w, dtype=np.float64), (rows.size,)) for w in weights])
    table = np.where(table < np.inf, table, 0.0)  # a weight that is no number is for a requirement to refuse
    found = _given(state, rows, number, 0.0, len(weights) - 1.0)
    if found is not None:
        _no_room(state, rows, number, table[found.astype(np.int64), np.arange(rows.size)] <= 0.0)
    else:
        left = _other_option(state.kept[number], rows, table) if number in state.kept else table
        total = np.cumsum(np.maximum(left, 0.0), axis=0)
        _no_room(state, rows, number, total[-1] <= 0.0)
        if state.defaults:
            found = np.argmax(left > 0.0, axis=0).astype(np.float64)
            if default is not None:
                usual = full(rows, default).astype(np.int64)
                found = np.where(left[usual, np.arange(rows.size)] > 0.0, usual, found).astype(np.float64)
        elif ((left > 0.0).sum(axis=0) == 1).all():  # nothing is left to chance
            found = np.argmax(left > 0.0, axis=0).astype(np.float64)
        else:
            mark = _lot(state, rows, address) * total[-1]
            found = np.minimum((total <= mark).sum(axis=0), len(weights) - 1).astype(np.float64)
    if state.weigh and (declared is not None or number in state.given):
        prior = table if declared is None else np.stack([full(rows, w).astype(np.float64) for w in declared])
        part = (
            prior[found.astype(np.int64), np.arange(rows.size)]
            if number in state.given
            else np.cumsum(np.maximum(table, 0.0), axis=0)[-1]
        )
        _note(state, rows, part, np.cumsum(np.maximum(prior, 0.0), axis=0)[-1])
    state.values[number] = found
    return found


def _other_option(kept: Kept, rows: Rows, table: np.ndarray) -> np.ndarray:
    """Weights (options, rows) that leave only the option kept, or only others where a swap is asked for and possible."""
    known, at = kept.find(rows)
    if not known.any():
        return table
    option = np.arange(len(table))[:, None] == kept.value[at].astype(np.int64)
    alone, others = np.where(option, table, 0.0), np.where(option, 0.0, table)
    swap = kept.swap[at] & (others > 0.0).any(axis=0)
    keep = ~swap & (alone > 0.0).any(axis=0)
    return np.where(known & swap, others, np.where(known & keep, alone, table))


def to_plain(draw: Draw, value: float) -> Any:
    """A value as people and files know it."""
    return draw.options[int(value)] if draw.kind == "choice" else int(value) if draw.kind == "count" else float(value)
