"""New objects from old ones: APA swaps templates, DPA changes counts, CPA perturbs parameters (Arti-PG, section 3).

Each operation is the sampler's own evaluation with most draws kept, and takes the object that the one before has made:
the inputs of a role outlive a swap, elements of a repeat keep their values by rank, new rows and new templates are drawn
in their conditional range, determined parameters follow, and what no longer fits is moved as little as possible. An
object that fails a requirement or collides is repaired, or tried again where that finds nothing; after several attempts the
numbers that are kept may give way, too, and other templates and counts are changed, and fewer.
"""

from __future__ import annotations

import re
from collections.abc import Callable, Sequence
from dataclasses import field, replace

import numpy as np

from ..graph.expr import leaves
from ..graph.program import Draw, Program
from ..random import key, uniform
from ..records import dataclass
from ..runtime.batch import Batch
from ..runtime.kernels import Kept, State, full
from ..runtime.laws import is_listed, values_of
from ..runtime.repairs import Repairs
from ..runtime.tables import plain_name
from .clips import CLIPPED, Asked, Blame, log_moved
from .known import evaluate_again, find_differing, keep_draw, make_batch, match_keys, rows_of_draw
from .repair import Mended, join_solved, mend, tally
from .sample import Sampler, find_faulty, is_examined
from .statistics import ATTEMPTS, Exhausted, Statistics

OPERATIONS = ("apa", "dpa", "cpa")
_PATIENCE = 6  # attempts before what is kept may give way, a little more with each further one, and others are swapped
_FEWER = 0.9  # of the share that is swapped, with each further one
_TRIALS = 40  # attempts to change one value alone, each but the first few with a shorter step
SHARE = 0.5
_KIND = {"apa": "choice", "dpa": "count", "cpa": "real"}


@dataclass(frozen=True, slots=True, eq=False)
class Stage:
    """One operation on a batch: what it was, what it became, and which rows of each draw were to change."""

    operation: str
    before: Batch
    after: Batch
    wanted: list[np.ndarray] = field(repr=False)


def find_structural(program: Program) -> set[int]:
    """The choices that decide which parts there are (not which material they have)."""
    read = {column for scope in program.scopes if scope.count is not None for column in leaves(scope.count)}
    return {k for k, d in enumerate(program.draws) if d.kind == "choice" and d.column in read}


def mutate(
    sampler: Sampler,
    batch: Batch,
    *,
    operations: Sequence[str] = OPERATIONS,
    variant: int | np.ndarray = 0,
    strength: float = 1.0,
    share: float = SHARE,
    only: str = "*",
    one: bool = False,
    statistics: Statistics | None = None,
    checked: bool = False,
) -> Batch:
    """Mutants of all objects of a batch, one each; the arguments are those of ``Mutation``.

    ``variant`` may differ from object to object; an object of variant -1 stays what it is. ``checked``: only mutants
    without collisions. The batch remembers in ``history`` what each operation did. Raises ValueError for an unknown
    operation, Exhausted when no attempt is valid.
    """
    unknown = [o for o in operations if o not in OPERATIONS]
    if unknown:
        raise ValueError(f"unknown operation {unknown[0]!r}; there are {', '.join(OPERATIONS)}")
    variants = np.broadcast_to(np.asarray(variant, dtype=np.int64), (len(batch),))
    salt = f"mutant of {batch.state.salt or 'the original'}"
    lane = (batch.state.lanes() * 1_000_003 + variants + 1) % (1 << 32)
    statistics = statistics if statistics is not None else Statistics()
    history: list[Stage] = []
    rejected = np.zeros(len(batch), dtype=np.int64)
    repairs: list[Repairs] = []
    now, able = batch, variants >= 0
    for operation in [o for o in OPERATIONS if o in operations]:
        step = _Step(sampler, now, operation, f"{salt} by {operation}", lane, able, strength, share, Names(only))
        after, tries = step.one(statistics, checked) if one else step.run(statistics, checked)
        rejected += tries
        logs = [_find_moved(now, after, step.purpose()), *step.logs()]
        tally(statistics, logs[0], {}, np.zeros(len(batch), dtype=bool))
        repairs += logs
        history.append(Stage(operation, now, after, step.purpose()))
        now = after
        if one:  # each object by itself: what else is in the batch must not matter
            able = able & ~step.having(step.meant)
    found = evaluate_again(now, np.arange(len(batch)), attempt=rejected, lane=lane, salt=salt)
    found.history = tuple(history)
    found.repairs = Repairs.joined(repairs)
    return found


def _find_moved(before: Batch, after: Batch, meant: Sequence[np.ndarray]) -> Repairs:
    """What an operation has moved without meaning to: kept values that no longer fitted, each with what forbids it."""
    asked = Asked(Asked.all(before).values, [~rows for rows in meant])
    return log_moved(before, asked, after, Blame(lambda _: [], {})).only(CLIPPED)


class Names:
    """Which values a list of names means: their own, of parts above them, or patterns; ranks may be left out."""

    def __init__(self, only: str):
        pieces = [p.strip() for p in only.split(",") if p.strip()]
        parts = ["".join(".*" if c == "*" else "." if c == "?" else re.escape(c) for c in p) for p in pieces]
        self.ranked = any("[" in p for p in pieces)
        self.everything = "*" in pieces
        self.pattern = re.compile(f"(?:{'|'.join(parts) or '(?!)'})(?:[.\\[].*)?")

    @staticmethod
    def unknown(only: str, program: Program) -> list[str]:
        """The names of a list that mean no value of the program at all."""
        pieces = [p.strip() for p in only.split(",")]
        drawn = {d.column.name for d in program.draws}
        plain = {p: Names(plain_name(p)) for p in pieces}
        return [
            p for p, names in plain.items() if not names.everything and not any(map(names.pattern.fullmatch, drawn))
        ]

    @staticmethod
    def changed(only: str, program: Program, operations: Sequence[str]) -> bool:
        """Whether any of the operations has a value of the program to change among those that a list means."""
        names, parts = Names(plain_name(only)), find_structural(program)
        kinds = [_KIND[operation] for operation in operations]
        return any(
            draw.kind in kinds
            and (names.everything or names.pattern.fullmatch(draw.column.name) is not None)
            and (draw.kind != "choice" or (len(draw.options) > 1 and (number in parts or not names.everything)))
            for number, draw in enumerate(program.draws)
        )

    def of(self, batch: Batch, draw: Draw) -> np.ndarray:
        """The rows of a draw that are meant, as a mask."""
        size = batch.rowmap.rows(draw.column.scope).size
        if self.everything or self.pattern.fullmatch(draw.column.name):
            return np.ones(size, dtype=bool)
        if not self.ranked:
            return np.zeros(size, dtype=bool)
        names = batch.rowmap.names(draw.column.scope, draw.column.name)
        return np.array([self.pattern.fullmatch(n) is not None for n in names], dtype=bool)


class _Step:
    """One operation on a batch: which rows it is about, and the attempts at it."""

    def __init__(
        self,
        sampler: Sampler,
        batch: Batch,
        operation: str,
        salt: str,
        lane: np.ndarray,
        able: np.ndarray,
        strength: float,
        share: float,
        names: Names,
    ):
        self.sampler, self.batch, self.operation = sampler, batch, operation
        self.salt, self.lane, self.strength, self.share = salt, lane, strength, share
        draws = batch.program.draws
        parts = find_structural(batch.program)
        self.meant = [np.zeros(batch.rowmap.rows(d.column.scope).size, dtype=bool) for d in draws]
        self.swaps = [np.zeros_like(m) for m in self.meant]
        for number, draw in enumerate(draws):
            if draw.kind == _KIND[operation] and (draw.kind != "choice" or number in parts or not names.everything):
                self.meant[number] = names.of(batch, draw) & self.can_change(draw) & able[self.owner(draw)]
        self.reaches = [self.reach(number) for number in range(len(draws))]
        self.mended: list[Mended] = []  # attempts that were put right, by their places in the batch

    def owner(self, draw: Draw) -> np.ndarray:
        return self.batch.rowmap.rows(draw.column.scope).owner

    def can_change(self, draw: Draw) -> np.ndarray | bool:
        """A number of one possible value cannot."""
        if draw.kind == "choice":
            return len(draw.options) > 1
        low, high = self.batch.read(draw.ends, draw.column.scope)
        if is_listed(draw.distribution):
            values = self.batch.read(values_of(draw.distribution, draw.arguments), draw.column.scope)
            low, high = np.maximum(low, np.minimum.reduce(values)), np.minimum(high, np.maximum.reduce(values))
        return np.asarray(high) > np.asarray(low)

    def lots(self, late: np.ndarray | None = None) -> list[np.ndarray]:
        """A number in 0 .. 1 for each row that may change, 2 for the others; another one for each ``late`` attempt (B,)."""
        late = np.zeros(len(self.batch), dtype=np.int64) if late is None else late
        found = []
        for draw, meant in zip(self.batch.program.draws, self.meant, strict=True):
            rows = self.batch.rowmap.rows(draw.column.scope)
            which = key(self.batch.seed, draw.address, self.salt, "which")
            lot = uniform(which, rows.address, self.lane[rows.owner], late[rows.owner])
            found.append(np.where(meant, lot, 2.0))
        return found

    def lowest(self, lots: list[np.ndarray]) -> np.ndarray:
        found = np.full(len(self.batch), np.inf)
        for draw, lot in zip(self.batch.program.draws, lots, strict=True):
            np.minimum.at(found, self.owner(draw), lot)
        return found

    def purpose(self) -> list[np.ndarray]:
        """The rows that were to change."""
        return [s | (r > 0) for s, r in zip(self.swaps, self.reaches, strict=True)]

    def reach(self, number: int) -> np.ndarray:
        """How far CPA may move each row of a draw: the declared step, or a tenth of the domain."""
        draw, meant = self.batch.program.draws[number], self.meant[number]
        if draw.kind != "real" or not meant.any():
            return np.zeros(len(meant))
        if draw.vary is None:
            return np.where(meant, 0.1 * self.strength * self.width(draw), 0.0)
        relative, amount = draw.vary
        rows = self.batch.rowmap.rows(draw.column.scope)
        step = full(rows, self.batch.read([amount], draw.column.scope)[0])
        if relative:
            step = step * np.abs(self.batch.state.values[number])
        return np.where(meant, self.strength * step, 0.0)

    def width(self, draw: Draw) -> np.ndarray:
        low, high = self.batch.read(draw.ends, draw.column.scope)
        return np.asarray(high, dtype=np.float64) - np.asarray(low, dtype=np.float64)

    # ------------------------------------------------------------ attempts

    def run(self, statistics: Statistics, checked: bool) -> tuple[Batch, np.ndarray]:
        """The operation on every object, and how many attempts of each failed. Raises Exhausted."""
        attempt = np.zeros(len(self.batch), dtype=np.int64)
        self.choose(attempt)
        left, first = self.concerned(), True
        touched = left
        while len(left):
            trial = self.trial(left, attempt, self.giving)
            while self.operation != "cpa" and self.spare(trial, left):
                self.choose(attempt)
                trial = self.trial(left, attempt, self.giving)
            bad = self.failing(trial, left, statistics, checked, first)
            if first and bad.any():
                self.mend(trial, left, bad, statistics, checked)
            left, first = left[bad], False
            attempt[left] += 1
            if len(left) and attempt.max() >= ATTEMPTS:
                raise Exhausted(self.batch.numbers[left], statistics, ATTEMPTS, mutants=True)
            if len(left) and attempt.max() > _PATIENCE:
                self.choose(attempt)
        if not len(touched):
            return self.batch, attempt
        found = self.trial(np.arange(len(self.batch)), attempt, self.giving)
        return join_solved(found, [(m.batch, m.places) for m in self.mended]), attempt

    def choose(self, attempt: np.ndarray) -> None:
        """The templates and counts to swap: the same in the first attempts at an object, then others and fewer, as what is kept
        may leave the only other value of one no valid object."""
        if self.operation == "cpa":
            return
        late = np.maximum(attempt - _PATIENCE, 0)
        lots, share = self.lots(late), self.share * _FEWER**late
        lowest = self.lowest(lots)
        for number, (draw, lot) in enumerate(zip(self.batch.program.draws, lots, strict=True)):
            owner = self.owner(draw)
            self.swaps[number] = (lot < 1.0) & ((lot < share[owner]) | (lot == lowest[owner]))

    def spare(self, trial: Batch, objects: np.ndarray) -> bool:
        """Whether some objects of an attempt are what they were, as what is kept leaves what was to change no other value:
        then that is no longer meant, so that something else is."""
        wanted = self.purpose()
        idle = np.zeros(len(self.batch), dtype=bool)
        idle[objects] = ~trial.state.failed & ~self.differing(trial, objects, wanted)
        idle &= self.having(wanted)
        for number, draw in enumerate(trial.program.draws):
            self.meant[number] = self.meant[number] & ~(wanted[number] & idle[self.owner(draw)])
        return bool(idle.any())

    def mend(self, trial: Batch, objects: np.ndarray, bad: np.ndarray, statistics: Statistics, checked: bool) -> None:
        """Put attempts right that failed, by their numbers: templates and counts are what the operation is about."""
        fixed = [number for number, draw in enumerate(trial.program.draws) if draw.kind != "real"]
        found = mend(self.sampler, trial, np.flatnonzero(bad), statistics, checked, fixed)
        bad[found.places] = False
        self.mended.append(replace(found, places=objects[found.places]))

    def logs(self) -> list[Repairs]:
        """What was moved to put attempts right, by the places of the objects in the batch."""
        return [replace(m.batch.repairs, owner=m.places[m.batch.repairs.owner]) for m in self.mended]

    def one(self, statistics: Statistics, checked: bool) -> tuple[Batch, np.ndarray]:
        """One value of each object changed and no other that both have; unchanged where that cannot be."""
        lots = self.lots()
        lowest = self.lowest(lots)
        single = [
            (lot < 1.0) & (lot == lowest[self.owner(d)]) for d, lot in zip(self.batch.program.draws, lots, strict=True)
        ]
        if self.operation == "cpa":
            self.reaches = [np.where(s, r, 0.0) for s, r in zip(single, self.reaches, strict=True)]
        else:
            self.swaps = single
        attempt = np.zeros(len(self.batch), dtype=np.int64)
        left, first = self.concerned(), True
        if not len(left):
            return self.batch, attempt
        lost = np.zeros(len(self.batch), dtype=bool)
        while len(left):
            trial = self.trial(left, attempt, self.shortening)
            bad = self.failing(trial, left, statistics, checked, first, alone=True)
            left, first = left[bad], False
            attempt[left] += 1
            lost[left[attempt[left] >= _TRIALS]] = True
            left = left[attempt[left] < _TRIALS]
        for number, draw in enumerate(self.batch.program.draws):  # those stay as they are
            stays = lost[self.owner(draw)]
            self.reaches[number] = np.where(stays, 0.0, self.reaches[number])
            self.swaps[number] = self.swaps[number] & ~stays
        return self.trial(np.arange(len(self.batch)), attempt, self.shortening), attempt

    def concerned(self) -> np.ndarray:
        """The objects in which something is to change."""
        return np.flatnonzero(self.having(self.purpose()))

    def having(self, rows: list[np.ndarray]) -> np.ndarray:
        """Which objects (B,) have any of some rows of the draws."""
        found = np.zeros(len(self.batch), dtype=bool)
        for draw, wanted in zip(self.batch.program.draws, rows, strict=True):
            found[self.owner(draw)[wanted]] = True
        return found

    def trial(self, objects: np.ndarray, attempt: np.ndarray, how: Callable[[int, np.ndarray], np.ndarray]) -> Batch:
        """An attempt at the objects at some places of the batch, what is kept reaching as far as ``how`` says."""
        old = self.batch.state
        state = State(
            old.seed, old.objects[objects], attempt[objects], dict(old.given), salt=self.salt, lane=self.lane[objects]
        )
        for number in range(len(self.batch.program.draws)):
            state.kept[number] = self.keep_values(number, objects, how(number, attempt))
        return make_batch(self.batch.program, self.batch.plan, state, self.batch.numbers[objects])

    def keep_values(self, number: int, objects: np.ndarray, reach: np.ndarray) -> Kept:
        """A number of a list that is to change takes another one of them, however short the step."""
        return keep_draw(self.batch, number, objects, reach, self.swaps[number] | (self.reaches[number] > 0.0))

    def giving(self, number: int, attempt: np.ndarray) -> np.ndarray:
        """The reach of each row, and after many attempts that failed, a little for all that is kept."""
        draw = self.batch.program.draws[number]
        late = np.maximum(attempt[self.owner(draw)] - _PATIENCE, 0)
        if draw.kind != "real" or not late.any():
            return self.reaches[number]
        return self.reaches[number] + 0.05 * late * self.width(draw)

    def shortening(self, number: int, attempt: np.ndarray) -> np.ndarray:
        """The reach of each row, halved with every other attempt that failed."""
        late = attempt[self.owner(self.batch.program.draws[number])] // 2
        return self.reaches[number] * 0.5 ** np.minimum(late, 16)

    def failing(
        self, trial: Batch, objects: np.ndarray, statistics: Statistics, checked: bool, first: bool, alone: bool = False
    ) -> np.ndarray:
        """Which objects of an attempt are not valid, or with ``alone`` differ in more than they should."""
        bad = trial.state.failed.copy()
        if alone:
            bad |= self.spoiled(trial, objects)
        sound = np.flatnonzero(~bad)
        if is_examined(trial.program, checked) and len(sound):
            part = trial if len(sound) == len(trial) else evaluate_again(trial, sound)
            bad[sound[find_faulty(part, statistics, checked)]] = True
        statistics.add(trial.state, first, bad)
        return bad

    def spoiled(self, trial: Batch, objects: np.ndarray) -> np.ndarray:
        """Objects of which a value that was to stay has moved, or the one that was to change has not."""
        wanted = self.purpose()
        return self.differing(trial, objects, [~rows for rows in wanted]) | ~self.differing(trial, objects, wanted)

    def differing(self, trial: Batch, objects: np.ndarray, rows: list[np.ndarray]) -> np.ndarray:
        """Which objects of an attempt differ in any of some rows of the draws that they still have."""
        found = np.zeros(len(trial), dtype=bool)
        everything = np.arange(len(trial))
        for number, asked in enumerate(rows):
            if not asked.any():
                continue
            old, new = rows_of_draw(self.batch, number, objects), rows_of_draw(trial, number, everything)
            here, there = match_keys(old.key, new.key)
            apart = self.batch.state.values[number][old.row[here]] != trial.state.values[number][new.row[there]]
            found[new.owner[there[apart & asked[old.row[here]]]]] = True
        return found


__all__ = ["OPERATIONS", "Names", "Stage", "find_differing", "mutate", "find_structural"]
