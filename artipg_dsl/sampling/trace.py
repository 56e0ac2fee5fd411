"""What was done to objects, step by step: as plain data, in words, and done again.

A step says ``op`` (apa, dpa, cpa), ``how`` and the ``path`` of a value with what it was and is (``from``, ``to``). How:
"changed" on purpose, "clipped" (moved because it no longer fitted), "new", "gone", or "determined" (it follows from
others). ``draw`` and ``at`` (the ranks of the repeats) say exactly which value it is; determined ones have none, for they
need no saying: the first four kinds alone make the object again.
"""

from __future__ import annotations

import json
from collections.abc import Iterable, Mapping, Sequence
from hashlib import blake2b
from typing import Annotated, Any, Literal, NotRequired, TypedDict

import numpy as np

from ..errors import UserError
from ..graph import expr as E
from ..graph.expr import Scope
from ..graph.program import Draw
from ..random import mix
from ..records import dataclass
from ..runtime import repairs
from ..runtime.batch import Batch
from ..runtime.draws import to_plain
from ..runtime.kernels import Kept
from ..runtime.repairs import HOW, Repairs
from ..shapes import Misfit, Rule, fit
from .known import evaluate_again, rows_of_draw
from .mutate import OPERATIONS, Stage
from .sample import Sampler, find_faulty, is_examined
from .statistics import Exhausted, Statistics

_WRITTEN = "give a trace-*.jsonl written by `apgc mutate`"
_TOLD = 1e-9  # determined values that move by less are not told


_Place = Annotated[int, Rule("a whole number, at least 0", lambda value: 0 <= value < 2**62)]
_Value = float | int | str | None
_Changed = TypedDict(
    "_Changed",
    {
        "op": Literal["apa", "dpa", "cpa"],
        "how": Literal["changed", "clipped", "new", "gone", "determined"],
        "path": str,
        "from": _Value,
        "to": _Value,
        "draw": NotRequired[str],
        "at": NotRequired[list[_Place]],
    },
)
_Repaired = TypedDict(
    "_Repaired",
    {
        "path": str,
        "from": _Value,
        "to": _Value,
        "how": Annotated[str, Rule(f"one of {', '.join(HOW)}", lambda value: value in HOW)],
        "because": str,
        "where": str | None,
    },
)


class _Record(TypedDict):
    """What a line of a trace holds."""

    object: _Place
    source: _Place
    steps: list[_Changed]
    rejected: NotRequired[_Place]
    salt: NotRequired[str]
    lane: NotRequired[Annotated[int, Rule("a whole number of 32 bits", lambda value: 0 <= value < 2**32)]]
    program: NotRequired[str]
    repairs: NotRequired[list[_Repaired]]


@dataclass(frozen=True, slots=True)
class Step:
    """One value of one object before and after an operation, in metres or radians; choices by name."""

    op: str
    how: str
    path: str
    before: Any
    after: Any
    draw: str | None = None
    at: tuple[int, ...] = ()

    def plain(self) -> dict[str, Any]:
        found = {"op": self.op, "how": self.how, "path": self.path, "from": self.before, "to": self.after}
        return found | ({} if self.draw is None else {"draw": self.draw, "at": list(self.at)})


def trace_objects(batch: Batch) -> list[list[Step]]:
    """The steps that made each object of a batch from the one it was made from; none for those that were drawn."""
    found: list[list[Step]] = [[] for _ in range(len(batch))]
    for stage in batch.history:
        _append_steps(stage, found)
    return found


def _append_steps(stage: Stage, into: list[list[Step]]) -> None:
    """Append what one operation did, per object: what was changed on purpose, then what followed."""
    lists: tuple[list[list[Step]], list[list[Step]]] = [[] for _ in into], [[] for _ in into]
    for owner, step in _drawn(stage):
        lists[step.how != "changed"][owner].append(step)
    for owner, step in _determined(stage):
        lists[1][owner].append(step)
    for mine, first, rest in zip(into, *lists, strict=True):
        mine.extend(first)
        mine.extend(rest)


def _drawn(stage: Stage) -> Iterable[tuple[int, Step]]:
    before, after = stage.before, stage.after
    everything = np.arange(len(after))
    for number, draw in enumerate(after.program.draws):
        scope = draw.column.scope
        old, new = rows_of_draw(before, number, everything), rows_of_draw(after, number, everything)
        a, b = before.state.values[number], after.state.values[number]
        here, there = _pair(old.key, new.key)
        apart = a[old.row[here]] != b[new.row[there]]
        here_gone = np.setdiff1d(np.arange(len(old.key)), here, assume_unique=True)
        there_new = np.setdiff1d(np.arange(len(new.key)), there, assume_unique=True)
        if not (apart.any() or len(here_gone) or len(there_new)):
            continue
        names = [batch.rowmap.names(scope, draw.column.name) for batch in (before, after)]
        ranks = [_ranks(batch, scope) for batch in (before, after)]
        for i, j in zip(here[apart].tolist(), there[apart].tolist(), strict=True):
            p, q = int(old.row[i]), int(new.row[j])
            how = "changed" if stage.wanted[number][p] else "clipped"
            step = Step(
                stage.operation, how, names[1][q], to_plain(draw, a[p]), to_plain(draw, b[q]), draw.address, ranks[1][q]
            )
            yield int(new.owner[j]), step
        for j in there_new.tolist():
            q = int(new.row[j])
            yield (
                int(new.owner[j]),
                Step(stage.operation, "new", names[1][q], None, to_plain(draw, b[q]), draw.address, ranks[1][q]),
            )
        for i in here_gone.tolist():
            p = int(old.row[i])
            yield (
                int(old.owner[i]),
                Step(stage.operation, "gone", names[0][p], to_plain(draw, a[p]), None, draw.address, ranks[0][p]),
            )


def _pair(old: np.ndarray, new: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Where the keys lie that both have, in the order of the new ones: that of keys differs from batch to batch."""
    _, here, there = np.intersect1d(old, new, assume_unique=True, return_indices=True)
    order = np.argsort(there)
    return here[order], there[order]


def _ranks(batch: Batch, scope: Scope) -> list[tuple[int, ...]]:
    """The ranks of the repeats above each row, outermost first."""
    found = [rank.tolist() for _, rank in batch.rowmap.ranks(scope)]
    return list(zip(*found, strict=True)) if found else [()] * batch.rowmap.rows(scope).size


def _determined(stage: Stage) -> Iterable[tuple[int, Step]]:
    """Parameters and sizes that follow from others. Where parts lie is told by the correspondence of their primitives."""
    before, after = stage.before, stage.after
    for column in after.program.definitions:
        if ".at." in column.name or column.kind != "real":
            continue
        expr, scope = E.col(column), column.scope
        rows = [batch.rowmap.rows(scope) for batch in (before, after)]
        was, now = (mix(r.address, r.owner) for r in rows)
        a, b = (batch.read([expr], scope)[0] for batch in (before, after))
        here, there = _pair(was, now)
        apart = np.abs(a[here] - b[there]) > _TOLD
        if not apart.any():
            continue
        names = after.rowmap.names(scope, column.name)
        for i, j in zip(here[apart].tolist(), there[apart].tolist(), strict=True):
            yield int(rows[1].owner[j]), Step(stage.operation, "determined", names[j], float(a[i]), float(b[j]))


# ---------------------------------------------------------------- files


def _make_record(batch: Batch, index: int, made: Sequence[Step], sources: np.ndarray) -> dict[str, Any]:
    """The trace of one object as a line of a file holds it."""
    return {
        "object": int(batch.numbers[index]),
        "source": int(sources[index]),
        "rejected": int(batch.state.attempt[index]),
        "salt": batch.state.salt,
        "lane": int(batch.state.lanes()[index]),
        "program": batch.program.hash,
        "steps": [s.plain() for s in made],
    } | ({"repairs": found} if (found := batch.repairs.of(np.array([index])).plain(batch.program)) else {})


def trace_lines(batch: Batch) -> bytes:
    """The traces of a batch, one object a line (JSON)."""
    sources = batch.history[0].before.numbers if batch.history else batch.numbers
    found = [_make_record(batch, i, made, sources) for i, made in enumerate(trace_objects(batch))]
    return "".join(json.dumps(line, ensure_ascii=False, separators=(",", ":")) + "\n" for line in found).encode()


def check_record(record: Any) -> Mapping[str, Any]:
    """A record that is one. Raises UserError."""
    try:
        fit(record, _Record)
    except Misfit as wrong:
        raise UserError(f"this is not a trace record: {wrong}", _WRITTEN) from None
    return record


def read_traces(text: str, name: str) -> dict[int, dict[str, Any]]:
    """The records of a trace file by the number of their object. Raises UserError."""
    found: dict[int, dict[str, Any]] = {}
    for number, line in enumerate(text.split("\n"), 1):  # no other character ends a line: text may hold them
        if not line.strip():
            continue
        try:
            entry = json.loads(line)
            fit(entry, _Record)
        except (ValueError, RecursionError) as error:
            raise UserError(f"{name}:{number} is not a mutation trace: {error}", _WRITTEN) from None
        found[entry["object"]] = entry
    return found


# ---------------------------------------------------------------- again


@dataclass(frozen=True, slots=True, eq=False)
class Replay:
    """A step of a job as ``Mutation`` is one: the records of traces, by the number of the object they made, and whether these may
    collide."""

    records: Mapping[int, Mapping[str, Any]]
    unchecked: bool = False

    @property
    def mark(self) -> str:
        """The digest of the records."""
        text = json.dumps([self.records[n] for n in sorted(self.records)], sort_keys=True)
        return blake2b(text.encode(), digest_size=16).hexdigest()

    def lines(self) -> bytes:
        """The records as a file holds them, one a line (JSON)."""
        found = (json.dumps(self.records[n], ensure_ascii=False, separators=(",", ":")) for n in sorted(self.records))
        return "".join(line + "\n" for line in found).encode()

    def plain(self) -> dict[str, Any]:
        found: dict[str, Any] = {"replay": self.mark}
        return found | {"unchecked": True} if self.unchecked else found

    def origins(self, numbers: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        missing = [n for n in numbers.tolist() if n not in self.records]
        if missing:
            raise UserError(f"the trace has no record of object {missing[0]}", "give all its files, trace-*.jsonl")
        return np.array([self.records[n]["source"] for n in numbers.tolist()], dtype=np.int64), np.zeros(
            len(numbers), dtype=np.int64
        )

    def apply(
        self,
        sampler: Sampler,
        batch: Batch,
        numbers: np.ndarray,
        variants: np.ndarray,
        statistics: Statistics,
        checked: bool,
    ) -> Batch:
        """The objects ``numbers``, made from those of the batch as their records say. Raises Exhausted, UserError."""
        found = replay(batch, [self.records[n] for n in numbers.tolist()])
        bad = found.state.failed.copy()
        if is_examined(found.program, checked) and not bad.all():
            sound = np.flatnonzero(~bad)
            bad[sound[find_faulty(evaluate_again(found, sound), statistics, checked)]] = True
        statistics.add(found.state, True, bad)
        if bad.any():
            raise Exhausted(numbers[bad], statistics, 1)
        found.numbers = numbers
        return found


def replay(batch: Batch, records: Sequence[Mapping[str, Any]]) -> Batch:
    """Do the steps of a record to each object of a batch; the same bytes as when they were done first. Raises UserError."""
    everything = np.arange(len(batch))
    lane = np.array([entry.get("lane", 0) for entry in records], dtype=np.int64)
    attempt = np.array([entry.get("rejected", 0) for entry in records], dtype=np.int64)
    salt = str(records[0].get("salt", "")) if records else ""
    history, now = [], batch
    for operation in OPERATIONS:
        changed, wanted = _asked(now, operation, records)
        if changed:
            after = evaluate_again(now, everything, values=_overlaid(now, changed))
            history.append(Stage(operation, now, after, wanted))
            now = after
    found = evaluate_again(now, everything, attempt=attempt, lane=lane, salt=salt)
    try:
        told = [
            repairs.read_repairs(batch.program, place, entry.get("repairs", ())) for place, entry in enumerate(records)
        ]
    except ValueError as error:
        raise UserError(f"the repairs in the trace do not fit this program: {error}", _WRITTEN) from None
    found.repairs = Repairs.joined(told)
    found.history = tuple(history) or (Stage(OPERATIONS[0], batch, found, _asked(batch, "", [])[1]),)
    return found


def _asked(
    batch: Batch, operation: str, records: Sequence[Mapping[str, Any]]
) -> tuple[dict[int, dict[int, float]], list[np.ndarray]]:
    """The values that an operation gives, per draw by key, and the rows of each draw that it changes on purpose."""
    program = batch.program
    known = {draw.address: number for number, draw in enumerate(program.draws)}
    changed: dict[int, dict[int, float]] = {}
    purpose: list[set[int]] = [set() for _ in program.draws]
    for owner, entry in enumerate(records):
        for step in entry["steps"]:
            if step["op"] != operation or step.get("draw") is None or step["to"] is None:
                continue
            number = known.get(step["draw"])
            if number is None:
                raise UserError(
                    f"{program.name} draws no `{step['path']}`", "replay a trace with the program that it was made with"
                )
            draw = program.draws[number]
            found = int(mix(_address(draw, int(batch.state.objects[owner]), step), owner).item())
            changed.setdefault(number, {})[found] = _number(draw, step)
            if step["how"] == "changed":
                purpose[number].add(found)
    wanted = []
    for draw, keys in zip(program.draws, purpose, strict=True):
        rows = batch.rowmap.rows(draw.column.scope)
        wanted.append(np.isin(mix(rows.address, rows.owner), np.array(sorted(keys), dtype=np.uint64)))
    return changed, wanted


def _overlaid(batch: Batch, changed: Mapping[int, Mapping[int, float]]) -> list[Kept]:
    """All values of a batch, some of them replaced and some added."""
    values = []
    for number in range(len(batch.program.draws)):
        old = rows_of_draw(batch, number, np.arange(len(batch)))
        new = changed.get(number, {})
        keys = np.concatenate([np.array(list(new), dtype=np.uint64), old.key])
        held = np.concatenate([np.array(list(new.values()), dtype=np.float64), batch.state.values[number][old.row]])
        keys, first = np.unique(keys, return_index=True)
        values.append(Kept(keys, held[first], np.zeros(len(keys)), np.zeros(len(keys), dtype=bool)))
    return values


def _address(draw: Draw, number: int, step: Mapping[str, Any]) -> np.ndarray:
    """The random address of the row that a step is about."""
    address = np.array([number], dtype=np.uint64)
    repeats = sum(scope.kind == "repeat" for scope in draw.column.scope.ancestors())
    ranks = step.get("at", [])
    if len(ranks) != repeats:
        raise UserError(f"`{step['path']}` is nested in {repeats} repeats, but the trace gives {len(ranks)} indices")
    for rank in ranks:
        address = mix(address, np.array([rank]))
    return address


def _number(draw: Draw, step: Mapping[str, Any]) -> float:
    value = step["to"]
    if draw.kind == "choice":
        if value not in draw.options:
            raise UserError(f"`{step['path']}` cannot be `{value}`: it must be one of {', '.join(draw.options)}")
        return float(draw.options.index(value))
    if isinstance(value, bool) or not isinstance(value, int | float):
        raise UserError(f"`{step['path']}` cannot be {value!r}: it must be a number")
    return float(value)


# ---------------------------------------------------------------- two states of the same objects


def compare_batches(before: Batch, after: Batch) -> list[list[Step]]:
    """What sets objects of two batches of one program apart, object by object in their order."""
    nothing = [np.zeros(before.rowmap.rows(d.column.scope).size, dtype=bool) for d in before.program.draws]
    found: list[list[Step]] = [[] for _ in range(len(after))]
    _append_steps(Stage("", evaluate_again(before, np.arange(len(before))), after, nothing), found)
    return found
