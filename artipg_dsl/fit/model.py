"""A program as fitting sees it: which draws shape its surface, candidates as rows of a batch, and the same with other values."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import fields
from functools import cached_property

import numpy as np

from ..errors import UserError
from ..graph.depend import draws_behind
from ..graph.expr import Expr, Scope
from ..graph.reference import ranks_of
from ..random import mix
from ..records import dataclass
from ..runtime.batch import Batch
from ..runtime.kernels import Kept, State
from ..runtime.laws import TOLERANCE
from ..runtime.needs import axes_of, motion_of, narrowing_of, pose_cells
from ..runtime.plan import Plan, make_plan
from ..sampling.known import DrawRows, evaluate_again, keep_draw, make_batch, rows_of_draw
from ..sampling.sample import Sampler
from ..sampling.search import domain_ends
from .gather import gather
from .ruled import ruled_by, ruling_of
from .states import Moved, Opened, is_jointed, resting, shut
from .states import opened as open_program

_BLOCKS = 5  # in which candidates are drawn at most, until enough are valid


@dataclass(frozen=True, slots=True, eq=False)
class Freedoms:
    """The numbers of each candidate that can be moved: one row per number, sorted by ``owner`` (candidate).

    ``draw`` and ``row`` say which number it is, ``place`` counts within the candidate; ``value``, and the range ``low`` ..
    ``high`` that the requirements leave it; ``width`` is that of its domain.
    """

    owner: np.ndarray
    draw: np.ndarray
    row: np.ndarray
    place: np.ndarray
    value: np.ndarray
    low: np.ndarray
    high: np.ndarray
    width: np.ndarray

    def __len__(self) -> int:
        return len(self.owner)

    @property
    def names(self) -> np.ndarray:
        """One number for each that says which it is, of which candidate."""
        return mix(mix(self.owner.astype(np.uint64), self.draw), self.row)

    def take(self, at: np.ndarray) -> Freedoms:
        """Some of them, ascending."""
        owner = self.owner[at]
        place = np.arange(len(at)) - np.searchsorted(owner, owner)
        columns = (getattr(self, name)[at] for name in ("value", "low", "high", "width"))
        return Freedoms(owner, self.draw[at], self.row[at], place, *columns)

    @property
    def most(self) -> int:
        """The largest number of them in one candidate."""
        return int(self.place.max(initial=-1)) + 1


@dataclass(frozen=True, slots=True, eq=False)
class Changes:
    """Values that rows of draws are to take: in the copy ``copy`` (its place among the copies), ``draw``, ``row`` (of the batch that
    is copied), ``value``."""

    copy: np.ndarray
    draw: np.ndarray
    row: np.ndarray
    value: np.ndarray

    def take(self, at: np.ndarray, copy: np.ndarray | None = None) -> Changes:
        """Some of them, each in its own copy or in another ``copy`` (n,)."""
        return Changes(self.copy[at] if copy is None else copy, self.draw[at], self.row[at], self.value[at])

    @staticmethod
    def joined(several: Sequence[Changes]) -> Changes:
        """Of several, one after the other."""
        return Changes(*(np.concatenate([getattr(one, field.name) for one in several]) for field in fields(Changes)))


class Model:
    """The draws on which the surface depends: ``discrete`` (choices, counts, values of a list) and ``smooth``; and the choices, ``ruling``,
    that only say which options of the discrete ones there may be."""

    def __init__(self, sampler: Sampler, *, opened: bool = False, jointed: bool = False):
        self.sampler = sampler
        self.program = (open_program if opened else resting)(sampler.program, jointed)
        behind = draws_behind(self.program, self._surface())
        draws = self.program.draws
        listed = [k for k in behind if draws[k].kind != "real" or draws[k].distribution == "values"]
        if jointed:  # of what only says how links move, choices and counts: no distance holds a number
            moving = set(draws_behind(self.program, self._motion())) - set(behind)
            listed = sorted({*listed, *(k for k in moving if draws[k].kind != "real")})
        self.discrete = listed
        states = self.program.states.values() if isinstance(self.program, Opened) else ()
        self.ruling = ruling_of(self.program, listed, behind)
        self.ruled = ruled_by(self.program, listed, self.ruling)
        self.smooth = [*(k for k in behind if k not in set(listed)), *states]

    @cached_property
    def plan(self) -> Plan:
        """What candidates are evaluated by: their primitives, and the ranges and weights of their draws."""
        program = self.program
        wanted = list(narrowing_of(program))
        for site in program.sites:
            wanted += [(expr, site.scope) for expr in (*site.parameters, *pose_cells(site.pose))]
        for part in program.parts:
            wanted += [(holds, part.scope) for _, holds in part.semantic]
            wanted += ranks_of(part.link)
        for number in (*self.discrete, *self.ruling):
            wanted += [(weight, program.draws[number].column.scope) for weight in program.draws[number].weights]
        if isinstance(program, Moved):
            wanted += motion_of(program)
        if is_jointed(program):
            wanted += axes_of(program)
        return make_plan(program, wanted)

    def _surface(self) -> Iterable[Expr]:
        for site in self.program.sites:
            yield from (*site.parameters, *pose_cells(site.pose))
            yield from (scope.count for scope in site.scope.ancestors() if scope.count is not None)
        if isinstance(self.program, Moved):  # where primitives stand as joints rest
            drawn = self.program.states if isinstance(self.program, Opened) else {}
            yield from (joint.rest for number, joint in enumerate(self.program.joints) if number not in drawn)

    def _motion(self) -> Iterable[Expr]:
        for joint in self.program.joints:
            yield from (*joint.origin, *joint.axis)
            yield from (scope.count for scope in joint.scope.ancestors() if scope.count is not None)

    # ------------------------------------------------------------ candidates

    def assembled(self, parts: Sequence[tuple[Batch, np.ndarray]], places: Sequence[np.ndarray] | None = None) -> Batch:
        """Candidates of several batches in one, those at the given rows of each, with all the values they have; one after the
        other, or at the given ``places``."""
        own = [(batch if batch.plan is self.plan else self._again(batch), at) for batch, at in parts]
        return gather(own, places)

    def _again(self, batch: Batch) -> Batch:
        """Objects of another plan as candidates."""
        old, every = batch.state, np.arange(len(batch))
        state = State(old.seed, old.objects, np.zeros(len(batch), dtype=np.int64), lane=old.lanes())
        state.kept = {number: keep_draw(batch, number, every) for number in range(len(self.program.draws))}
        return make_batch(self.program, self.plan, state)

    def merged(self, batch: Batch, others: Batch, of: np.ndarray, order: np.ndarray) -> Batch:
        """Candidates, each with what the ``others``, copies of the one ``of`` (n,) which they are, have otherwise than it: where these differ
        from one another, of the one first in ``order`` (n,)."""
        state = State(batch.seed, batch.state.objects, batch.state.attempt, lane=batch.state.lanes())
        for number in range(len(self.program.draws)):
            own = rows_of_draw(batch, number, np.arange(len(batch)))
            theirs = rows_of_draw(others, number, np.arange(len(others)))
            rows = others.rowmap.rows(self.program.draws[number].column.scope)
            key, value = own.key, batch.state.values[number][own.row]
            new, now = mix(rows.address[theirs.row], of[theirs.owner]), others.state.values[number][theirs.row]
            ascending = np.argsort(key, kind="stable")
            at = ascending[np.minimum(np.searchsorted(key[ascending], new), max(len(key) - 1, 0))] if len(key) else new
            differs = (key[at] != new) | (value[at] != now) if len(key) else np.ones(len(new), dtype=bool)
            keys, values = np.concatenate([new[differs], key]), np.concatenate([now[differs], value])
            rank = np.concatenate([order[theirs.owner[differs]], np.full(len(key), len(others))])
            first = np.lexsort((rank, keys))
            first = first[np.diff(keys[first], prepend=~keys[first[:1]]) != 0]
            state.kept[number] = _kept(keys[first], values[first])
        return make_batch(self.program, self.plan, state)

    def drawn(self, numbers: np.ndarray, seed: int) -> Batch:
        """First attempts of the objects of some numbers; which are valid their state tells. Where joints have values, every other object
        is at rest, and half of the joints of the others are."""
        state = State(seed, numbers, np.zeros(len(numbers), dtype=np.int64))
        batch = make_batch(self.program, self.plan, state)
        if not isinstance(self.program, Opened):
            return batch
        return self.altered(batch, np.arange(len(batch)), Changes(*shut(batch, seed)))

    def valid(self, count: int, seed: int, wanted: int = 1) -> Batch:
        """Those of the first ``count`` of them that are valid; of more where there are fewer than ``wanted``, as where facts leave little.
        Raises UserError where none is."""
        found: list[tuple[Batch, np.ndarray]] = []
        for block in range(_BLOCKS):
            drawn = self.drawn(np.arange(block * count, (block + 1) * count), seed)
            found.append((drawn, np.flatnonzero(~drawn.state.failed)))
            if sum(len(good) for _, good in found) >= wanted:
                break
        if not any(len(good) for _, good in found):
            raise UserError(
                f"of {_BLOCKS * count} objects that were drawn of {self.program.name}, none is as it is known to be",
                "leave some facts out",
            )
        return self.assembled(found)

    def at_rest(self, batch: Batch) -> Batch:
        """The candidates as objects of the sampler's program, whose joints have no values of their own."""
        program, every = self.sampler.program, np.arange(len(batch))
        old = batch.state
        state = State(old.seed, old.objects, old.attempt, dict(old.given), salt=old.salt, lane=old.lanes())
        state.kept = {number: keep_draw(batch, number, every) for number in range(len(program.draws))}
        return make_batch(program, self.sampler.plan, state, batch.numbers)

    def fingerprints(self, batch: Batch) -> np.ndarray:
        """(B,) uint64: a number for all values on which the surfaces of candidates depend."""
        found = np.zeros(len(batch), dtype=np.uint64)
        for number in (*self.discrete, *self.smooth):
            scope = self.program.draws[number].column.scope
            said = mix(np.full(len(batch.owner(scope)), number + 1, dtype=np.uint64), _bits(batch.state.values[number]))
            for _, rank in batch.rowmap.ranks(scope):
                said = mix(said, rank)
            np.add.at(found, batch.owner(scope), said)
        return found

    def structures(self, batch: Batch) -> np.ndarray:
        """(B,) uint64: a number for the discrete values of each candidate, equal where all of them are; and for the quarter of its range
        in which each joint is, as a search from one seldom leads to another."""
        found = np.zeros(len(batch), dtype=np.uint64)
        states = set(self.program.states.values()) if isinstance(self.program, Opened) else set()
        for number in (*self.discrete, *sorted(states)):
            scope = self.program.draws[number].column.scope
            value = batch.state.values[number]
            if number in states:
                low, high = domain_ends(batch, number)
                value = np.floor(4.0 * (value - low) / np.maximum(high - low, TOLERANCE))
            elif self.program.draws[number].kind == "real":
                value = np.round(value / TOLERANCE)
            said = mix(np.full(len(value), number + 1, dtype=np.uint64), value.astype(np.int64))
            for _, rank in batch.rowmap.ranks(scope):
                said = mix(said, rank)
            np.add.at(found, batch.owner(scope), said)
        return found

    def altered(
        self,
        batch: Batch,
        copies: np.ndarray,
        changes: Changes,
        lane: np.ndarray | None = None,
        alike: np.ndarray | None = None,
    ) -> Batch:
        """Copies of candidates, each with the changed values; what no longer fits moves to where it does.

        ``copies``: the place in the batch of what each copy is of. ``lane``: what the rows that are new are drawn by.
        ``alike`` (copies,): in which of them what stands in the place of its twin holds what that held.
        """
        kept, altered = [], set(changes.draw.tolist())
        theirs: dict[int, tuple[np.ndarray, np.ndarray, np.ndarray]] = {}
        known: dict[Scope, tuple[DrawRows, np.ndarray, np.ndarray]] = {}
        for number, draw in enumerate(self.program.draws):
            scope = draw.column.scope
            if scope not in known:
                chosen = rows_of_draw(batch, number, copies)
                known[scope] = chosen, *_sorted(chosen.key)
            chosen, order, key = known[scope]
            value = batch.state.values[number][chosen.row]
            if number in altered:
                mine = np.flatnonzero(changes.draw == number)
                size = int(chosen.row.max(initial=0)) + 1
                where = chosen.owner * size + chosen.row  # ascending
                value[np.searchsorted(where, changes.copy[mine] * size + changes.row[mine])] = changes.value[mine]
            kept.append(_kept(key, value[order]))
            if alike is not None:
                theirs[number] = key, value[order], alike[chosen.owner[order]]
        for one, other in [pair for ruled in self.ruled for pair in ruled.same] if alike is not None else ():
            key, value, mine = theirs[one]
            keys, values = (
                np.concatenate([kept[other].address, key[mine]]),
                np.concatenate([kept[other].value, value[mine]]),
            )
            order = np.argsort(keys, kind="stable")
            kept[other] = _kept(keys[order], values[order])
        return evaluate_again(batch, copies, values=kept, lane=lane, plan=self.plan)

    def freedoms(self, batch: Batch) -> Freedoms:
        """The numbers of all candidates of a batch that can be moved."""
        columns: list[list[np.ndarray]] = [[] for _ in range(7)]
        for number in self.smooth:
            draw = self.program.draws[number]
            owner = batch.owner(draw.column.scope)
            if not len(owner):
                continue
            first, last = domain_ends(batch, number)
            low, high = first.copy(), last.copy()
            for bound in draw.bounds:
                end, guard = batch.read([bound.value, bound.guard], draw.column.scope)
                if bound.side == "low":
                    np.maximum(low, np.where(guard, end, -np.inf), out=low)
                else:
                    np.minimum(high, np.where(guard, end, np.inf), out=high)
            width = last - first
            rows = np.flatnonzero(width > 0.0)
            value = batch.state.values[number]
            told = owner, np.full(len(owner), number), np.arange(len(owner)), value, low, high, width
            for column, one in zip(columns, told, strict=True):
                column.append(one[rows])
        owner, draws, row, value, low, high, width = (
            np.concatenate([np.zeros(0, dtype=kind), *column])
            for column, kind in zip(columns, (int, int, int, float, float, float, float), strict=True)
        )
        order = np.argsort(owner, kind="stable")
        owner = owner[order]
        place = np.arange(len(owner)) - np.searchsorted(owner, owner)
        return Freedoms(owner, draws[order], row[order], place, value[order], low[order], high[order], width[order])


def _bits(value: np.ndarray) -> np.ndarray:
    return np.ascontiguousarray(value + 0.0).view(np.uint64)  # -0.0 is 0.0


def _sorted(key: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """The order in which keys ascend, and the keys in it."""
    order = np.argsort(key, kind="stable")
    return order, key[order]


def _kept(key: np.ndarray, value: np.ndarray) -> Kept:
    """Values to be kept by their keys, which ascend."""
    still = np.zeros(len(key))
    return Kept(key, value, still, still.astype(bool))


@dataclass(frozen=True, slots=True, eq=False)
class Placed:
    """How candidates lie in the frame of what they are fitted to: points are ``scale`` times theirs plus ``shift``."""

    scale: np.ndarray
    shift: np.ndarray

    def take(self, at: np.ndarray) -> Placed:
        return Placed(self.scale[at], self.shift[at])

    @staticmethod
    def joined(several: Sequence[Placed]) -> Placed:
        """Of all candidates of several sets."""
        return Placed(*(np.concatenate([getattr(one, name) for one in several]) for name in ("scale", "shift")))

    def moved(self, by: np.ndarray) -> Placed:
        """With candidates moved, ``by`` (K, 3) in their own frame."""
        return Placed(self.scale, self.shift + self.scale[:, None] * by)

    def of(self, points: np.ndarray) -> np.ndarray:
        return self.scale[:, None, None] * points + self.shift[:, None, :]
