"""What a repair did: which requirement failed, and which parameter moved from what to what, as columns and in words."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace
from typing import Any

import numpy as np

from ..geometry.runs import distinct, runs
from ..graph.program import Draw, Program, Requirement
from ..records import dataclass
from .tables import plain_name

HOW = ("clipped", "hint", "search", "redrawn")

# why a value could not stay: ("domain", draw), ("absent", draw) of what was no number, ("draw", draw without room), ("requirement", number),
# ("collision", (link, link, joint)), ("solid", what is wrong with the solids, in words) or ("told", (why, where)) by a file
Cause = tuple[str, Any]


@dataclass(frozen=True, slots=True, eq=False)
class Repairs:
    """One row per value that a repair moved, sorted by object.

    ``owner`` (R,) index of the object in its batch, ``draw`` (R,) index among the draws of the program, ``name`` the value
    (``cell[1].share``), ``before`` and ``after`` (R,) in metres, radians, counts or indices of options (nan: no value),
    ``how`` (R,) index into ``HOW``, and ``cause``, what was wrong.
    """

    owner: np.ndarray
    draw: np.ndarray
    name: list[str]
    before: np.ndarray
    after: np.ndarray
    how: np.ndarray
    cause: list[Cause]

    def __len__(self) -> int:
        return len(self.owner)

    @staticmethod
    def none() -> Repairs:
        whole, real = np.zeros(0, dtype=np.int64), np.zeros(0)
        return Repairs(whole, whole, [], real, real, whole, [])

    @staticmethod
    def joined(parts: Sequence[Repairs]) -> Repairs:
        """Rows of several, sorted by object."""
        if not parts:
            return Repairs.none()
        owner, draw, before, after, how = (
            np.concatenate([getattr(p, n) for p in parts]) for n in ("owner", "draw", "before", "after", "how")
        )
        name, cause = [n for p in parts for n in p.name], [c for p in parts for c in p.cause]
        order = np.lexsort((np.arange(len(owner)), owner))
        return Repairs(
            owner[order],
            draw[order],
            [name[k] for k in order],
            before[order],
            after[order],
            how[order],
            [cause[k] for k in order],
        )

    def without(self, objects: np.ndarray) -> Repairs:
        """The same without the objects for which a mask is set."""
        return self._rows(np.flatnonzero(~objects[self.owner]))

    def _rows(self, keep: np.ndarray) -> Repairs:
        name, cause = [self.name[k] for k in keep], [self.cause[k] for k in keep]
        return Repairs(
            self.owner[keep], self.draw[keep], name, self.before[keep], self.after[keep], self.how[keep], cause
        )

    def of(self, objects: np.ndarray) -> Repairs:
        """Those of some objects, which are numbered as they stand in ``objects``; an object may stand there often."""
        start, stop = (np.searchsorted(self.owner, objects, side=side) for side in ("left", "right"))
        rows = self._rows(runs(start, stop - start))
        return replace(rows, owner=np.repeat(np.arange(len(objects)), stop - start))

    def only(self, how: int) -> Repairs:
        """The rows that were moved in one way (an index into ``HOW``)."""
        return self._rows(np.flatnonzero(self.how == how))

    def objects(self) -> np.ndarray:
        return distinct(self.owner)

    def plain(self, program: Program) -> list[dict[str, Any]]:
        """A row each as plain data: ``path``, ``from``, ``to``, ``how``, ``because`` and ``where`` in the text."""
        found = []
        for k, cause in enumerate(self.cause):
            draw = program.draws[self.draw[k]]
            because, where = _explained(program, cause)
            if np.isnan(self.before[k]):
                because = f"`{draw.column.name}` has no value"
            found.append(
                {
                    "path": self.name[k],
                    "from": _shown(draw, self.before[k]),
                    "to": _shown(draw, self.after[k]),
                    "how": HOW[self.how[k]],
                    "because": because,
                    "where": where,
                }
            )
        return found


def describe_cause(program: Program, cause: Cause) -> str:
    """A cause in a line of statistics: its place in the text, then what is wrong."""
    kind, about = cause
    words, place = _explained(program, cause)
    if kind == "requirement":
        words = program.requirements[about].message
    return words if place is None else f"{place.rpartition(':')[0]}: {words}"


def find_yielding(program: Program, cause: Cause) -> tuple[int, ...]:
    """The draws that the text says should give way when something is wrong."""
    kind, about = cause
    if kind == "requirement":
        return program.requirements[about].repair
    stated = dict.fromkeys(b.requirement for b in program.draws[about].bounds) if kind == "draw" else ()
    return tuple(dict.fromkeys(k for r in stated for k in program.requirements[r].repair))


def read_repairs(program: Program, owner: int, entries: Sequence[Mapping[str, Any]]) -> Repairs:
    """The rows of one object as ``to_plain`` has told them. Raises KeyError and ValueError for what it has not."""
    parts = []
    for entry in entries:
        path, ends = plain_name(entry["path"]), (entry["from"], entry["to"])
        draws = [k for k, d in enumerate(program.draws) if d.column.name == path]
        fitting = [
            k
            for k in draws
            if all(not isinstance(e, str) or e in program.draws[k].options or _unending(e) for e in ends)
        ]
        if not fitting:
            raise ValueError(f"nothing draws `{entry['path']}`")
        options = program.draws[fitting[0]].options
        values = [np.nan if e is None else options.index(e) if e in options else float(e) for e in ends]
        cause: Cause = "told", (entry["because"], entry["where"])
        before, after = (np.array([value], dtype=np.float64) for value in values)
        how = np.array([HOW.index(entry["how"])])
        parts.append(Repairs(np.array([owner]), np.array(fitting[:1]), [entry["path"]], before, after, how, [cause]))
    return Repairs.joined(parts)


def _unending(text: str) -> bool:
    return text in ("inf", "-inf")


def _shown(draw: Draw, value: float) -> Any:
    """A value as files know it; None where there is none."""
    if np.isnan(value):
        return None
    if draw.kind == "choice":
        return draw.options[int(value)]
    if draw.kind == "count" and np.isfinite(value):
        return int(value)
    return float(value) if np.isfinite(value) else str(float(value))


def _stated(requirement: Requirement) -> str:
    """A requirement by its condition, or its message, with its place."""
    text = " ".join(requirement.text.split()) or requirement.message
    return f"`{text}` ({requirement.where})" if requirement.where is not None else f"`{text}`"


def _explained(program: Program, cause: Cause) -> tuple[str, str | None]:
    """A cause in words, and its place in the text as ``file:line:column``."""
    kind, about = cause
    where = None
    if kind == "told":
        return about
    if kind == "requirement":
        requirement = program.requirements[about]
        where, words = requirement.where, requirement.message
        if requirement.text and requirement.text not in words:
            words = f"{words} ({' '.join(requirement.text.split())})"
    elif kind == "domain":
        where, words = program.draws[about].where, f"`{program.draws[about].column.name}` lies outside its range"
    elif kind == "absent":
        where, words = program.draws[about].where, f"`{program.draws[about].column.name}` has no value"
    elif kind == "draw":
        draw = program.draws[about]
        numbers = [b.requirement for b in draw.bounds] + [b.requirement for b in draw.limits]
        numbers += [b.requirement for b in draw.unions]
        lines = list(dict.fromkeys(_stated(program.requirements[n]) for n in numbers))
        under = f" under {', '.join(lines[:3])}" if lines else ""
        where, words = draw.where, f"no legal value is left for `{draw.column.name}`{under}"
    elif kind == "collision":
        first, second, joint = about
        where = next((j.where for j in program.joints if j.path == joint), None)
        words = f"{first} and {second} collide {f'while {joint} moves' if joint else 'at rest'}"
    else:
        words = str(about)
    return words, None if where is None else f"{where.file}:{where.line}:{where.column}"
