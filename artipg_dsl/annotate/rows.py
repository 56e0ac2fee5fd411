"""Rows of an annotation as columns, and what becomes of them: dictionaries, or the same as text, which is made without these.

Numbers are rounded to 1e-9 (a nanometre, a nanoradian), so that they print short and read back as they are.
"""

from __future__ import annotations

import json
from collections.abc import Mapping
from itertools import pairwise
from typing import Any

import numpy as np

from ..native.digits import Numbers, Words, print_records
from ..records import dataclass


@dataclass(frozen=True, slots=True, eq=False)
class Known:
    """A column (n, k) of numbers; of a row with a nan nothing is known: None stands for it."""

    values: np.ndarray

    @property
    def absent(self) -> np.ndarray:
        return np.isnan(self.values).any(axis=1)


Column = list[Any] | np.ndarray | Known


@dataclass(frozen=True, slots=True, eq=False)
class Rows:
    """Rows by object: ``owner`` (n,) is sorted. A column is a list of plain data, all of one kind or None; an array of whole numbers or
    truths (n,); or one of numbers (n,) or (n, k), which are rounded: in one dimension nan becomes None."""

    owner: np.ndarray
    columns: Mapping[str, Column]

    def plain(self, n_objects: int) -> list[list[dict[str, Any]]]:
        """Rows as dictionaries, one list per object."""
        names, values = list(self.columns), [_plain(column) for column in self.columns.values()]
        rows = [dict(zip(names, row, strict=True)) for row in zip(*values, strict=True)]
        return [rows[a:b] for a, b in pairwise(self._starts(n_objects))]

    def text(self, n_objects: int) -> list[str]:
        """What ``to_text`` makes of each list of ``plain``."""
        marks = [f"{'{' if not k else ','}{to_text(name)}:" for k, name in enumerate(self.columns)]
        columns = [_to_print(column) for column in self.columns.values()]
        printed = print_records(columns, (f",{marks[0]}", *marks[1:], "}")) if len(self.owner) else None
        if printed is None:
            return [to_text(rows) for rows in self.plain(n_objects)]
        text, done = printed
        ends = np.concatenate([[0], done])[self._starts(n_objects)].tolist()
        return [f"[{text[a + 1 : b].decode()}]" for a, b in pairwise(ends)]

    def _starts(self, n_objects: int) -> list[int]:
        starts: list[int] = np.searchsorted(self.owner, np.arange(n_objects + 1)).tolist()
        return starts


@dataclass(frozen=True, slots=True, eq=False)
class PerObject:
    """Plain data of each object."""

    values: list[Any]

    def plain(self, n_objects: int) -> list[Any]:
        del n_objects
        return self.values

    def text(self, n_objects: int) -> list[str]:
        del n_objects
        return [to_text(value) for value in self.values]


@dataclass(frozen=True, slots=True, eq=False)
class PerState:
    """Rows by name, in each of several states."""

    states: list[dict[str, Rows]]

    def plain(self, n_objects: int) -> list[list[dict[str, Any]]]:
        """Of each object a dictionary for each state."""
        states = [{name: rows.plain(n_objects) for name, rows in state.items()} for state in self.states]
        return [[{name: rows[i] for name, rows in state.items()} for state in states] for i in range(n_objects)]

    def text(self, n_objects: int) -> list[str]:
        told = []
        for state in self.states:
            rows = zip(*(rows.text(n_objects) for rows in state.values()), strict=True)
            told.append(["{" + ",".join(map("{}:{}".format, map(to_text, state), row)) + "}" for row in rows])
        return [f"[{','.join(each)}]" for each in zip(*told, strict=True)] if told else ["[]"] * n_objects


def to_text(value: Any) -> str:
    """Plain data as JSON, the same text for the same numbers."""
    return json.dumps(value, ensure_ascii=False, separators=(",", ":"), allow_nan=False)


def tidy(values: np.ndarray) -> list[Any]:
    """An array as nested lists, rounded to 1e-9, without negative zeros; nan becomes None in one dimension."""
    rounded = np.round(np.asarray(values, dtype=np.float64), 9) + 0.0
    if rounded.ndim == 1 and np.isnan(rounded).any():
        return [None if value != value else value for value in rounded.tolist()]
    return rounded.tolist()


def _plain(column: Column) -> list[Any]:
    if isinstance(column, Known):
        return [None if gone else row for gone, row in zip(column.absent.tolist(), tidy(column.values), strict=True)]
    if isinstance(column, list):
        return column
    return tidy(column) if column.dtype.kind == "f" else column.tolist()


def _to_print(column: Column) -> Words | Numbers:
    if isinstance(column, Known):
        return Numbers(column.values, column.absent)
    if isinstance(column, np.ndarray) and column.dtype.kind in "fiu":
        return Numbers(column)
    values = column if isinstance(column, list) else column.tolist()
    try:  # what stands in several rows is told once
        known: dict[Any, int] = {}
        which = [known.setdefault(value, len(known)) for value in values]
        return Words([to_text(value) for value in known], np.array(which, dtype=np.int64))
    except TypeError:  # lists and dictionaries
        return Words(["null" if v is None else to_text(v) for v in values], np.arange(len(values)))
