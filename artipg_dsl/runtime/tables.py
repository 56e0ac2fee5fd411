"""Instances of links, joints and parts as columns, numbered within their objects."""

from __future__ import annotations

import re
from collections.abc import Sequence
from typing import TYPE_CHECKING

import numpy as np

from ..graph.expr import Scope
from ..language import JOINTS
from ..records import dataclass
from .columns import Columns
from .kernels import Rows

if TYPE_CHECKING:
    from .curves import Curve


_RANKS = re.compile(r"\[\d+\]")  # of elements of repeats


def plain_name(name: str) -> str:
    """The name of a part or a value without the ranks of elements: ``row.handle`` for ``row[2].handle``."""
    return _RANKS.sub("", name)


@dataclass(frozen=True, slots=True, eq=False, repr=False)
class LinkTable(Columns):
    """L links sorted by owner, then number; ``rotation`` (L, 3, 3), ``translation`` (L, 3) place the link's part, ``semantic`` (L,)
    is the place of its word in that vocabulary, 0 for none."""

    owner: np.ndarray
    number: np.ndarray
    name: list[str]
    definition: np.ndarray
    rotation: np.ndarray
    translation: np.ndarray
    semantic: np.ndarray


@dataclass(frozen=True, slots=True, eq=False, repr=False)
class JointTable(Columns):
    """J joints sorted by owner, then number. ``parent`` and ``child`` are link numbers, ``mimic`` a joint number or -1.

    ``origin``, ``axis`` (J, 3) lie in the object's frame at joint values 0; radians or metres; nan: not limited, not given.
    ``pitch`` is the advance of a screw by a turn, in metres, ``positions`` in how many places a joint catches (see ``detents``). The
    value of a ball joint is a tilt (see ``motion``). Joints of ``curves`` follow by a formula; ``multiplier`` and ``offset`` are the
    straight line between its ends.
    """

    owner: np.ndarray
    number: np.ndarray
    name: list[str]
    definition: np.ndarray
    kind: list[str]
    parent: np.ndarray
    child: np.ndarray
    origin: np.ndarray
    axis: np.ndarray
    low: np.ndarray
    high: np.ndarray
    rest: np.ndarray
    mimic: np.ndarray
    multiplier: np.ndarray
    offset: np.ndarray
    damping: np.ndarray
    friction: np.ndarray
    stiffness: np.ndarray
    effort: np.ndarray
    velocity: np.ndarray
    pitch: np.ndarray
    positions: np.ndarray
    curves: tuple[Curve, ...] = ()

    def that(self, *ways: str) -> np.ndarray:
        """Which joints (J,) move in one of these ways: ``turns``, ``slides``, ``tilts``; without a way, which move at all."""
        moves = {kind: JOINTS[kind].moves for kind in set(self.kind)}
        asked = {kind: way in ways if ways else way != "" for kind, way in moves.items()}
        return np.array([asked[kind] for kind in self.kind], dtype=bool)

    @property
    def advance(self) -> np.ndarray:
        """How far (J,) joints slide per unit of their value: 1 of what slides, metres per radian of a screw, else 0."""
        screws = {kind for kind in set(self.kind) if JOINTS[kind].advances}
        advances = np.array([kind in screws for kind in self.kind], dtype=bool)
        return np.where(advances, np.nan_to_num(self.pitch) / (2.0 * np.pi), self.that("slides") * 1.0)


@dataclass(frozen=True, slots=True, eq=False, repr=False)
class PartTable(Columns):
    """P parts sorted by owner, then number; ``low``, ``high`` (P, 3) is the box in the part's own frame, of mirrored ones as they stand.

    ``parent`` is the number of the part around it, ``holder`` of the part that it is rigidly connected to, -1 for none.
    """

    owner: np.ndarray
    number: np.ndarray
    name: list[str]
    path: list[str]
    template: list[str]
    definition: np.ndarray
    parent: np.ndarray
    semantic: np.ndarray
    link: np.ndarray
    rotation: np.ndarray
    translation: np.ndarray
    low: np.ndarray
    high: np.ndarray
    symmetry: np.ndarray
    holder: np.ndarray


class Rowmap:
    """Tables by scope, and which row of one table belongs to a row of another."""

    def __init__(self, scopes: dict[Scope, int], tables: Sequence[Rows]):
        self.scopes, self.tables = scopes, tables
        self._ranks: dict[Scope, list[tuple[str, np.ndarray]]] = {}

    def rows(self, scope: Scope) -> Rows:
        return self.tables[self.scopes[scope]]

    def up(self, scope: Scope, to: Scope) -> np.ndarray:
        """The row of the ancestor ``to`` for each row of ``scope``."""
        index = np.arange(self.rows(scope).size)
        while scope is not to:
            index = self.rows(scope).parent[index]
            assert scope.parent is not None
            scope = scope.parent
        return index

    def across(self, scope: Scope, to: Scope) -> np.ndarray:
        """The row of ``to`` (the first of several) for each row of ``scope``; -1 where there is none."""
        path: list[Scope] = []
        common = to
        while not scope.within(common):
            path.append(common)
            assert common.parent is not None
            common = common.parent
        index = self.up(scope, common)
        for step in reversed(path):
            rows = self.rows(step)
            at = np.where(index >= 0, index, len(rows.count))  # what is not there has no rows either
            index = np.where(np.append(rows.count, 0)[at] > 0, np.append(rows.start, 0)[at], -1)
        return index

    def ranks(self, scope: Scope) -> list[tuple[str, np.ndarray]]:
        """The repeats above a row: (name of the repeat, rank per row), outermost first."""
        if scope not in self._ranks:
            found: list[tuple[str, np.ndarray]] = []
            if scope.parent is not None:
                rows = self.rows(scope)
                found = [(name, rank[rows.parent]) for name, rank in self.ranks(scope.parent)]
                if scope.kind == "repeat":
                    found.append((scope.name, rows.rank))
            self._ranks[scope] = found
        return self._ranks[scope]

    def names(self, scope: Scope, path: str) -> list[str]:
        """The path with the ranks of its repeats: ``pad.row[1].key[0].cap``, one per row."""
        head = shape = path
        ranks: list[list[int]] = []
        for name, rank in reversed(self.ranks(scope)):
            if head == name or head.startswith(name + "."):
                head, shape = name, f"{name}[%d]{shape[len(name) :]}"
                ranks.insert(0, rank.tolist())
        return [shape % row for row in zip(*ranks, strict=True)] if ranks else [shape] * self.rows(scope).size


@dataclass(slots=True, eq=False)
class Instances:
    """Rows of several definitions put into one table sorted by owner: the order, and where each row went."""

    order: np.ndarray  # position in the concatenation -> the sorted table
    owner: np.ndarray
    number: np.ndarray
    definition: np.ndarray
    starts: np.ndarray  # offset of each definition in the concatenation
    place: np.ndarray  # row of the sorted table for each row of the concatenation

    @staticmethod
    def of(owners: Sequence[np.ndarray], objects: int) -> Instances:
        sizes = np.array([len(o) for o in owners], dtype=np.int64)
        starts = np.cumsum(sizes) - sizes
        owner = np.concatenate(owners) if owners else np.zeros(0, dtype=np.int64)
        definition = np.repeat(np.arange(len(owners)), sizes)
        order = np.argsort(owner, kind="stable")
        place = np.empty(len(order), dtype=np.int64)
        place[order] = np.arange(len(order))
        sorted_owner = owner[order]
        first = np.searchsorted(sorted_owner, np.arange(objects))
        number = np.arange(len(order)) - first[sorted_owner] if len(order) else np.zeros(0, dtype=np.int64)
        return Instances(order, sorted_owner, number, definition[order], starts, place)

    def numbers(self, definition: int, row: np.ndarray) -> np.ndarray:
        """The number within its object of each given row of a definition; -1 stays -1."""
        if not len(self.number):
            return np.full(np.shape(row), -1, dtype=np.int64)
        at = self.place[np.minimum(self.starts[definition] + np.maximum(row, 0), len(self.place) - 1)]
        return np.where(row >= 0, self.number[at], -1)

    def sort(self, columns: Sequence[np.ndarray], shape: tuple[int, ...] = (), dtype: type = np.float64) -> np.ndarray:
        """Columns of the definitions, joined and sorted."""
        if not columns:
            return np.zeros((0, *shape), dtype=dtype)
        return np.concatenate([np.asarray(c, dtype=dtype) for c in columns])[self.order]

    def sort_names(self, columns: Sequence[list[str]]) -> list[str]:
        joined = [name for column in columns for name in column]
        return [joined[k] for k in self.order]
