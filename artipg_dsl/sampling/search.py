"""The search of a repair: values tried around those that an object should have, many candidates of all objects at once.

A candidate is an evaluation with every value kept but some. First each value alone takes steps of 1/64 to the whole of its
domain both ways (a count its neighbours and ends, a choice its other options, a number of a list the others), then
several move together within a growing reach. Of the candidates that leave least at fault, the one that changes least is
taken, and then brought back towards the old values as far as it stays valid. What is tried for an object depends on that object alone.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from typing import TYPE_CHECKING

import numpy as np

from ..random import key, mix, uniform
from ..records import dataclass
from ..runtime.batch import Batch
from ..runtime.kernels import Kept, State, full
from ..runtime.laws import is_listed, values_of
from .known import make_batch

_STEPS = 2.0 ** -np.arange(6, -1, -1)  # of the width of a domain, for a value that moves alone
_TOGETHER = 48  # candidates in which several values move
_SECTIONS, _ROUNDS = 4, 4  # of the way back towards the old values, and of what is left of it
_WAVES = (
    (0.05, 0.2),
    (0.2, 0.7),
    (0.7, np.inf),
    (-1.0, 0.05),
)  # in what order candidates are examined for solids, by cost

if TYPE_CHECKING:
    from .sample import Sampler
_EXAMINED = 40  # of them of an object at a time, evenly over the wave
_BLOCK = 2048  # candidates evaluated at a time
AGAIN = 2  # searches from what was better and not yet valid
_DRAWN = 0.05  # how much less it costs to move a value that nobody asked for
COUNTED, CHOSEN = 0.25, 1.0  # what another count or option costs, in widths of a domain


@dataclass(frozen=True, slots=True, eq=False)
class Spots:
    """Rows of draws that may move: place of the object, index of the draw, row of its table."""

    owner: np.ndarray
    draw: np.ndarray
    row: np.ndarray

    @staticmethod
    def of(found: Sequence[tuple[np.ndarray, np.ndarray | int, np.ndarray]]) -> Spots:
        """From (owners, draw, rows), each row once, by object, draw and row."""
        columns = [
            np.concatenate([np.zeros(0, dtype=np.int64), *(np.broadcast_to(f[k], len(f[2])) for f in found)])
            for k in range(3)
        ]
        table = np.unique(np.stack(columns, axis=1).astype(np.int64), axis=0)
        return Spots(table[:, 0], table[:, 1], table[:, 2])

    def part(self, objects: np.ndarray) -> Spots:
        keep = np.isin(self.owner, objects)
        return Spots(self.owner[keep], self.draw[keep], self.row[keep])


@dataclass(frozen=True, slots=True, eq=False)
class Moves:
    """Candidates: ``place`` (C,) of the object each is of; moved values by ``candidate``, ``draw``, ``row`` and ``value``."""

    place: np.ndarray
    candidate: np.ndarray
    draw: np.ndarray
    row: np.ndarray
    value: np.ndarray

    def part(self, chosen: np.ndarray) -> Moves:
        """Some of the candidates, in the order given."""
        where = np.full(len(self.place), -1, dtype=np.int64)
        where[chosen] = np.arange(len(chosen))
        keep = where[self.candidate] >= 0
        return Moves(self.place[chosen], where[self.candidate[keep]], self.draw[keep], self.row[keep], self.value[keep])

    def times(self, count: int) -> Moves:
        """Each candidate so many times, one after the other."""
        candidate = self.candidate[:, None] * count + np.arange(count)
        draw, row, value = (np.repeat(column, count) for column in (self.draw, self.row, self.value))
        return Moves(np.repeat(self.place, count), candidate.ravel(), draw, row, value)

    def over(self, chosen: np.ndarray, others: Moves) -> Moves:
        """With other values for some candidates, which ``others`` has in the order of ``chosen``."""
        value = self.value.copy()
        for k, candidate in enumerate(chosen.tolist()):  # few: those that solids keep from coming nearer
            value[self.candidate == candidate] = others.value[others.candidate == k]
        return Moves(self.place, self.candidate, self.draw, self.row, value)


@dataclass(frozen=True, slots=True, eq=False)
class Judged:
    """Of each candidate: how many rows are at fault, what the change costs, and whether only spots moved."""

    faults: np.ndarray
    cost: np.ndarray
    alone: np.ndarray


class Search:
    """Candidates around objects: ``batch`` has their rows, ``target`` per draw the values they should have,
    ``stated`` which of these someone asked for.

    ``sound(batch)`` tells of each object of a batch whether its solids are in order.
    """

    def __init__(
        self,
        sampler: Sampler,
        batch: Batch,
        target: Sequence[np.ndarray],
        stated: Sequence[np.ndarray],
        sound: Callable[[Batch], np.ndarray] | None,
    ):
        self.sampler, self.batch, self.target, self.stated, self.sound = (
            sampler,
            batch,
            list(target),
            list(stated),
            sound,
        )
        self.rows = [batch.rowmap.rows(d.column.scope) for d in batch.program.draws]
        self.real = np.array(
            [d.kind == "real" and not is_listed(d.distribution) for d in batch.program.draws], dtype=bool
        )
        self.targets = np.concatenate([np.zeros(0), *self.target])  # of all draws, one behind the other
        self.first = np.cumsum([0, *map(len, self.target)])
        self.low, self.high, self.width = [], [], []
        for number, draw in enumerate(batch.program.draws):
            low, high = domain_ends(batch, number)
            wide = high - low
            some = np.where(np.isfinite(wide) & (wide > 0.0), wide, np.maximum(np.abs(self.target[number]), 1e-3))
            self.low.append(low)
            self.high.append(high)
            self.width.append(some if draw.kind == "real" else np.maximum(some, 1.0))

    # ------------------------------------------------------------ candidates

    def alone(self, spots: Spots) -> Moves:
        """Every spot by itself, in steps."""
        found: list[tuple[np.ndarray, np.ndarray, np.ndarray, np.ndarray]] = []
        for number in np.unique(spots.draw).tolist():
            here = np.flatnonzero(spots.draw == number)
            row = spots.row[here]
            old, low, high = (a[row][:, None] for a in (self.target[number], self.low[number], self.high[number]))
            draw = self.batch.program.draws[number]
            if draw.kind == "choice":
                value = np.broadcast_to(np.arange(len(draw.options), dtype=np.float64), (len(row), len(draw.options)))
            elif is_listed(draw.distribution):
                read = self.batch.read(values_of(draw.distribution, draw.arguments), draw.column.scope)
                value = np.stack([full(self.rows[number], v).astype(np.float64)[row] for v in read], axis=1)
                value = np.where((value >= low) & (value <= high), value, old)
            elif draw.kind == "count":
                value = np.concatenate([old + np.array([-1.0, 1.0, -2.0, 2.0]), low, high], axis=1)
                value = np.minimum(np.maximum(value, np.ceil(low)), np.floor(high))
            else:
                steps = np.concatenate([-_STEPS, _STEPS]) * self.width[number][row][:, None]
                value = np.minimum(np.maximum(old + steps, low), high)
            value = np.where(np.isfinite(value), value, old)
            i, k = np.nonzero(value != old)
            found.append((spots.owner[here][i], np.full(len(i), number), row[i], value[i, k]))
        owner, draw_, row, value = (np.concatenate([np.zeros(0), *(f[k] for f in found)]) for k in range(4))
        order = np.argsort(owner, kind="stable")
        return Moves(
            owner[order].astype(np.int64),
            np.arange(len(order)),
            draw_[order].astype(np.int64),
            row[order].astype(np.int64),
            value[order],
        )

    def together(self, spots: Spots) -> Moves:
        """All numbers among the spots of an object, each anywhere within a reach that grows from candidate to candidate."""
        real = Spots(*(column[self.real[spots.draw]] for column in (spots.owner, spots.draw, spots.row)))
        places = np.unique(real.owner)
        number = np.arange(_TOGETHER)
        reach = 2.0 ** (-6.0 + 6.0 * number / (_TOGETHER - 1))
        state, values = self.batch.state, np.zeros((len(real.row), _TOGETHER))
        for k in np.unique(real.draw).tolist():
            here = np.flatnonzero(real.draw == k)
            row = real.row[here]
            address = self.rows[k].address[row][:, None]
            lane = state.lanes()[real.owner[here]][:, None]
            names = (self.batch.program.draws[k].address, f"repair of {state.salt}")
            unit = uniform(
                key(state.seed, *names), address, lane, state.attempt[real.owner[here]][:, None] * _TOGETHER + number
            )
            wide = self.width[k][row][:, None] * reach
            moved = self.target[k][row][:, None] + wide * (2.0 * unit - 1.0)
            values[here] = np.minimum(np.maximum(moved, self.low[k][row][:, None]), self.high[k][row][:, None])
        at = np.searchsorted(places, real.owner)
        candidate = at[:, None] * _TOGETHER + number
        draw, row = (np.broadcast_to(c[:, None], values.shape) for c in (real.draw, real.row))
        return Moves(np.repeat(places, _TOGETHER), candidate.ravel(), draw.ravel(), row.ravel(), values.ravel())

    # ------------------------------------------------------------ evaluation

    def evaluated(self, moves: Moves) -> tuple[Batch, list[np.ndarray]]:
        """The candidates as a batch, and for each draw the row here of each value kept."""
        old, place = self.batch.state, moves.place
        state = State(
            old.seed, old.objects[place], old.attempt[place], dict(old.given), salt=old.salt, lane=old.lanes()[place]
        )
        sources = []
        for number in range(len(self.target)):
            rows = self.rows[number]
            first = np.searchsorted(rows.owner, place)
            count = np.searchsorted(rows.owner, place, side="right") - first
            start = np.cumsum(count) - count
            owner = np.repeat(np.arange(len(place)), count)
            row = np.arange(len(owner)) - start[owner] + first[owner]
            value = self.target[number][row]
            mine = np.flatnonzero(moves.draw == number)
            candidate = moves.candidate[mine]
            value[start[candidate] + moves.row[mine] - first[candidate]] = moves.value[mine]
            address = mix(rows.address[row], owner)
            order = np.argsort(address, kind="stable")
            still = np.zeros(len(row))
            state.kept[number] = Kept(address[order], value[order], still, still.astype(bool))
            sources.append(row[order])
        return make_batch(self.batch.program, self.sampler.plan, state, self.batch.numbers[place]), sources

    def judged(self, moves: Moves, spots: Spots | None = None) -> Judged:
        """The candidates by the requirements; with ``spots``, whether nothing else moved."""
        starts = range(0, len(moves.place), _BLOCK)
        blocks = [self._judged(moves.part(np.arange(s, min(s + _BLOCK, len(moves.place)))), spots) for s in starts]
        names = ("faults", "cost", "alone")
        return Judged(*(np.concatenate([np.zeros(0), *(getattr(b, n) for b in blocks)]) for n in names))

    def _judged(self, moves: Moves, spots: Spots | None) -> Judged:
        batch, sources = self.evaluated(moves)
        size = len(moves.place)
        faults = np.zeros(size)
        for _, owners in find_broken(batch):
            faults += np.bincount(owners, minlength=size)
        cost, alone = np.zeros(size), np.ones(size, dtype=bool)
        for number, draw in enumerate(batch.program.draws):
            rows = batch.rowmap.rows(draw.column.scope)
            known, at = batch.state.kept[number].find(rows)
            if not known.any():
                continue
            row = sources[number][at[known]]
            owner = rows.owner[known]
            apart = np.abs(batch.state.values[number][known] - self.target[number][row])
            moved = apart > 1e-9 * self.width[number][row]
            price = apart / self.width[number][row] if draw.kind != "choice" else np.zeros(len(row))
            price = price + moved * {"real": 0.0, "count": COUNTED, "choice": CHOSEN}[draw.kind]
            price = np.where(self.stated[number][row], price, _DRAWN * price)
            cost += np.bincount(owner, weights=price, minlength=size)
            if spots is not None and moved.any():
                mine = spots.row[spots.draw == number]
                alone[owner[moved & self.stated[number][row] & ~np.isin(row, mine)]] = False
        return Judged(faults, np.round(cost, 9), alone)

    # ------------------------------------------------------------ choosing

    def best(self, moves: Moves, judged: Judged, only: bool) -> tuple[np.ndarray, np.ndarray]:
        """The cheapest valid candidate of each object that has one; and of the others that with least at fault."""
        fit = judged.alone.astype(bool) if only else np.ones(len(moves.place), dtype=bool)
        order = np.lexsort((np.arange(len(fit)), judged.cost, judged.faults, moves.place))
        order = order[fit[order]]
        if self.sound is None:
            places, first = np.unique(moves.place[order], return_index=True)
            top = order[first]
            return top[judged.faults[top] == 0], top[judged.faults[top] > 0]
        valid = order[judged.faults[order] == 0]
        places, index = np.unique(moves.place[valid], return_inverse=True)
        winner = np.full(len(places), -1, dtype=np.int64)
        cost = judged.cost[valid]
        for above, upto in _WAVES:
            asked = np.flatnonzero((winner[index] < 0) & (cost > above) & (cost <= upto))
            count = np.bincount(index[asked], minlength=len(places))
            rank = np.arange(len(asked)) - (np.cumsum(count) - count)[index[asked]]
            share = np.maximum(count[index[asked]], _EXAMINED)
            asked = asked[rank * _EXAMINED // share != (rank - 1) * _EXAMINED // share]
            good = asked[self.examined(moves.part(valid[asked]))] if len(asked) else asked
            found, first = np.unique(index[good], return_index=True)
            winner[found] = valid[good[first]]
        winner = winner[winner >= 0]
        rest = order[judged.faults[order] > 0]
        _, first = np.unique(moves.place[rest], return_index=True)
        some = rest[first]
        with_valid = np.unique(moves.place[valid])
        return winner, some[~np.isin(moves.place[some], with_valid)]

    def examined(self, moves: Moves) -> np.ndarray:
        """Which candidates have their solids in order."""
        assert self.sound is not None
        return self.sound(self.evaluated(moves)[0])

    def shrunk(self, moves: Moves, spots: Spots | None) -> Moves:
        """Valid candidates brought back towards the target as far as they stay valid."""
        near = self._nearest(moves, spots, False)
        if self.sound is None:
            return near
        lost = np.flatnonzero(~self.examined(near))  # the text alone allows more than the solids do
        return near if not len(lost) else near.over(lost, self._nearest(moves.part(lost), spots, True))

    def _nearest(self, moves: Moves, spots: Spots | None, solids: bool) -> Moves:
        """The same by the text, and the ``solids``. Each round cuts what is left of the way back into sections and looks at their ends,
        since evaluating few candidates takes as long as evaluating one."""
        several = moves.times(_SECTIONS - 1)
        before, step = np.zeros(len(moves.place)), 1.0
        for _ in range(_ROUNDS):
            step /= _SECTIONS
            ends = before[:, None] + step * np.arange(1, _SECTIONS)
            there = self._back(several, ends.ravel())
            judged = self.judged(there, spots)
            good = (judged.faults == 0) & judged.alone.astype(bool)
            some = np.flatnonzero(good)
            if solids and len(some):
                good[some] = self.examined(there.part(some))
            good = good.reshape(ends.shape)
            before += step * np.where(good.any(axis=1), good.argmax(axis=1), _SECTIONS - 1)
        return self._back(moves, before + step)

    def _back(self, moves: Moves, share: np.ndarray) -> Moves:
        """Candidates with so much (C,) of their way from the target; counts, choices and numbers of a list go all of it."""
        old, way = self.targets[self.first[moves.draw] + moves.row], share[moves.candidate]
        value = np.where(self.real[moves.draw] & (way < 1.0), old + way * (moves.value - old), moves.value)
        return Moves(moves.place, moves.candidate, moves.draw, moves.row, value)


def domain_ends(batch: Batch, number: int) -> tuple[np.ndarray, np.ndarray]:
    """The declared ends of a draw, per row (a choice: its first and last option)."""
    draw = batch.program.draws[number]
    rows = batch.rowmap.rows(draw.column.scope)
    if draw.kind == "choice":
        return np.zeros(rows.size), np.full(rows.size, len(draw.options) - 1.0)
    low, high = batch.read(draw.ends, draw.column.scope)
    low, high = (full(rows, end).astype(np.float64) for end in (low, high))
    return low, np.maximum(low, high)


def find_broken(batch: Batch) -> Iterator[tuple[tuple[str, int], np.ndarray]]:
    """What the text finds wrong with a batch: ("draw" or "requirement", number), and the object of each row at fault."""
    program = batch.program
    for (kind, number), rows in batch.state.faults.items():
        scope = program.draws[number].column.scope if kind == "draw" else program.requirements[number].scope
        yield (kind, number), batch.owner(scope)[np.unique(np.concatenate(rows))]
