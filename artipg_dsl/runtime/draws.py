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
from .laws import EVEN, TOLERANCE, Law, Room, gaps_of, in_gap, move_out_of_gaps, step_along

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


def _require_value(state: State, rows: Rows, number: int, bad: np.ndarray, room: Room, law: Law) -> None:
    """Rows that are left none of the values of their law fail, unless their value is kept and fits."""
    if not law.confined:
        return
    empty = law.is_empty(room)
    if number in state.kept:
        known, at = state.kept[number].find(rows)
        if known.any():
            empty &= ~(known & room.holds(state.kept[number].value[at]))
    _no_room(state, rows, number, empty & ~bad)


def _given(state: State, rows: Rows, number: int, room: Room) -> np.ndarray | None:
    """The value given for a draw, if any; an object that has no room for it fails (and goes on with a legal value)."""
    value = state.given.get(number)
    if value is None:
        return None
    found = full(rows, value).astype(np.float64)
    bad = ~((found >= room.low - TOLERANCE) & (found <= room.high + TOLERANCE))
    _no_room(state, rows, number, bad if room.gaps is None else bad | in_gap(found, room.gaps))
    return np.where(bad, room.low, found)


def _each_its_own(draw: Callable[..., np.ndarray]) -> Callable[..., np.ndarray]:
    """A draw of which some objects are asked for a value: drawn as if all were, and as if none was, and each object has its own of it."""

    @wraps(draw)
    def drawn(state: State, rows: Rows, number: int, *how: Any) -> np.ndarray:
        if not rows.size:  # of most alternatives nobody has a row
            state.values[number] = nobody = np.zeros(0)
            return nobody
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
    law, left = Law(distribution, arguments), Room(low, high, gaps_of(low, unions, False) if unions else None)
    found = _given(state, rows, number, left)
    if found is None:
        bad = ~(low <= high + TOLERANCE)  # nor is there room between ends that are no numbers
        _no_room(state, rows, number, bad)
        room = Room(low, np.maximum(low, high), left.gaps)
        if state.defaults and default is not None:
            found = move_out_of_gaps(room.clip(full(rows, default).astype(np.float64)), room)
        elif (held := _unmoved(state, rows, number)) is not None:
            found = room.clip(held)
            found = found + 0.0 if room.gaps is None else move_out_of_gaps(found, room)  # -0.0 is 0.0
            if law.confined and (found != held).any():
                found = _near(state.kept[number], rows, found, room, found, law)
                _require_value(state, rows, number, bad, room, law)
        else:
            unit = _lot(state, rows, address)
            found = law.spread(unit, room)
            _require_value(state, rows, number, bad, room, law)
            if number in state.kept:
                found = _near(state.kept[number], rows, unit, room, found, law)
        if room.gaps is not None:
            _no_room(state, rows, number, in_gap(found, room.gaps) & ~bad)
    if state.weigh and domain is not None:
        given = number in state.given
        part = law.density(found) if given else law.measure(left)
        least, most = (full(rows, end).astype(np.float64) for end in domain)
        _note(state, rows, part, law.measure(Room(least, most)), given)
    state.values[number] = found
    return found


def _note(state: State, rows: Rows, part: np.ndarray, whole: np.ndarray, dense: bool = False) -> None:
    """Note how much of the declared law, of which there is as much as ``whole``, lies in the room that was left of it, or how likely a
    value given is by it (``dense``)."""
    share = np.where(whole > 0.0, part / np.where(whole > 0.0, whole, 1.0), 1.0)
    share = np.maximum(share if dense else np.minimum(share, 1.0), LEAST)
    state.log_weight += np.bincount(rows.owner, weights=np.log(share), minlength=len(state.objects))


def _near(kept: Kept, rows: Rows, unit: np.ndarray, room: Room, fresh: np.ndarray, law: Law) -> np.ndarray:
    """Within reach of the value kept, as far as the room and the law allow; the fresh value for rows that are new."""
    known, at = kept.find(rows)
    if not known.any():
        return fresh
    old, reach = kept.value[at], kept.reach[at]
    if law.listed:
        return np.where(known, step_along(unit, old, reach, kept.swap[at], room, law.values), fresh)
    if law.confined:  # a value that stays may lie elsewhere, as one that was given
        room = room.but((reach == 0.0) & room.holds(old), law.support(room))
    near = Room(room.clip(old - reach), room.clip(old + reach), room.gaps)
    wide = near.low < near.high
    if room.gaps is None:
        found = np.minimum(near.low + unit * (near.high - near.low), near.high)
    else:
        found = np.where(wide, EVEN.spread(unit, near), near.low) if wide.any() else near.low
    return np.where(known, move_out_of_gaps(found, room), fresh)


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
    law = Law(distribution, arguments)
    levels = EVEN if distribution == "uniform" else law  # of all that is rounded to a whole number
    room = Room(np.ceil(low - TOLERANCE), np.floor(high + TOLERANCE), gaps_of(low, unions, True) if unions else None)
    found = _given(state, rows, number, room)
    if found is None:
        bad, moved = ~(room.low <= room.high), False
        _no_room(state, rows, number, bad)
        room = Room(room.low, np.maximum(room.low, room.high), room.gaps)
        usual = state.defaults and default is not None
        if (held := _unmoved(state, rows, number)) is not None:
            found = room.clip(held)
            moved = law.confined and bool((found != held).any())
        elif state.defaults and default is not None:
            found = room.clip(full(rows, default).astype(np.float64))
        else:
            found = _whole_number(levels, _lot(state, rows, address), _whole(law, room))
        if moved or (held is None and not usual):
            _require_value(state, rows, number, bad, room, _rounded(law))
        if moved or (held is None and number in state.kept):
            found = _other_count(state.kept[number], rows, _lot(state, rows, address), room, found, law)
        if room.gaps is not None:
            if state.defaults or (state.kept and not law.listed):
                found = np.floor(move_out_of_gaps(found, room.widened(0.5)) + 0.5)
            _no_room(state, rows, number, in_gap(found, room.gaps) & ~bad)
    if state.weigh and domain is not None:
        least, most = (full(rows, end).astype(np.float64) for end in domain)
        declared = _whole(law, Room(np.ceil(least - TOLERANCE), np.floor(most + TOLERANCE)))
        left = Room(found, found, room.gaps) if number in state.given else _whole(law, room)
        _note(state, rows, levels.measure(left.widened(0.5)), levels.measure(declared.widened(0.5)))
    state.values[number] = found
    return found


def _whole_number(law: Law, unit: np.ndarray, room: Room) -> np.ndarray:
    """Uniform numbers to whole ones of a law within a room."""
    if law is EVEN and room.gaps is None:
        return np.minimum(room.low + np.floor(unit * (room.high - room.low + 1.0)), room.high)
    found = np.floor(law.spread(unit, room.widened(0.5)) + 0.5)
    return found if law.listed else room.clip(found)


def _whole(law: Law, room: Room) -> Room:
    """The whole numbers of a room in which a law lies."""
    tight = law.support(room)
    return Room(np.ceil(tight.low - TOLERANCE), np.floor(tight.high + TOLERANCE), room.gaps)


def _rounded(law: Law) -> Law:
    """A law for whole numbers: ``uniform(a, b)`` from the first to the last of them."""
    if law.name != "uniform" or not law.arguments:
        return law
    return Law("uniform", (np.ceil(law.arguments[0] - TOLERANCE), np.floor(law.arguments[1] + TOLERANCE)))


def _other_count(kept: Kept, rows: Rows, unit: np.ndarray, room: Room, fresh: np.ndarray, law: Law) -> np.ndarray:
    """The count kept, moved into the room; another one of its law where that is asked for and there is one."""
    known, at = kept.find(rows)
    if not known.any():
        return fresh
    value, swap = kept.value[at], kept.swap[at]
    if law.listed:
        return np.where(known, step_along(unit, value, np.where(swap, np.inf, 0.0), swap, room, law.values), fresh)
    if law.confined:
        room = room.but(~swap & Room(room.low, room.high).holds(value), _whole(law, room))
    first, last = room.low, room.high
    old = room.clip(value)
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
    found = _given(state, rows, number, Room(np.zeros(rows.size), np.full(rows.size, len(weights) - 1.0)))
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
