"""Repeats whose elements hold choices, as fitting sees them: what says how many elements there are, what places them, what they hold."""

from __future__ import annotations

from collections.abc import Iterable

import numpy as np

from ..graph.depend import draws_behind, nodes_behind
from ..graph.expr import Expr, Scope, leaves
from ..graph.program import Program
from ..random import mix
from ..records import dataclass
from ..runtime.batch import Batch
from ..runtime.kernels import Kept, State
from ..runtime.needs import pose_cells
from ..sampling.known import make_batch, rows_of_draw
from ..sampling.search import domain_ends
from .model import Model
from .states import tables


@dataclass(frozen=True, slots=True, eq=False)
class Repeat:
    """A ``scope`` that repeats below ``parent`` as often as the draw ``count`` says. ``weight``: the draw that elements share the room by,
    -1 where they do not; ``inside``: all other draws of what they hold."""

    scope: Scope
    parent: Scope
    count: int
    weight: int
    inside: tuple[int, ...]

    def holds(self, other: Repeat) -> bool:
        """Whether the other one is within its elements."""
        return other.scope is not self.scope and other.scope.within(self.scope)


def find_repeats(model: Model) -> list[Repeat]:
    """Those whose elements have choices or counts of their own, outer ones first."""
    program, found = model.program, []
    draws, running = program.draws, _running_sums(program)
    for scope in program.scopes:
        if scope.kind != "repeat" or scope.count is None or scope.parent is None:
            continue
        counted = leaves(scope.count)
        counts = [k for k in model.discrete if draws[k].kind == "count" and draws[k].column in counted]
        inside = [k for k in (*model.discrete, *model.smooth) if draws[k].column.scope.within(scope)]
        if len(counts) != 1 or not set(inside) & set(model.discrete):
            continue
        if any(s.kind == "repeat" for s in _between(scope.parent, draws[counts[0]].column.scope)):
            continue  # several rows would have one count
        behind = set(draws_behind(program, running.get(scope, ())))
        weights = [k for k in inside if k in behind and k in model.smooth and draws[k].column.scope is scope]
        weight = weights[0] if len(weights) == 1 else -1
        found.append(Repeat(scope, scope.parent, counts[0], weight, tuple(k for k in inside if k != weight)))
    return sorted(found, key=lambda one: one.scope.depth)


def held(model: Model, batch: Batch) -> np.ndarray:
    """(B, R) bool: which of the R repeats whose elements hold choices each candidate has."""
    found = [Places.of(batch, one).many > 0 for one in find_repeats(model)]
    return np.stack([np.zeros(len(batch), dtype=bool), *found], axis=1)[:, 1:]


def _between(low: Scope, high: Scope) -> Iterable[Scope]:
    """The scopes from one up to another above it, without that."""
    for scope in low.ancestors():
        if scope is high:
            return
        yield scope


def _running_sums(program: Program) -> dict[Scope, list[Expr]]:
    """What places of primitives sum up over the elements of a scope before one."""
    found: dict[Scope, list[Expr]] = {}
    cells = (cell for site in program.sites for cell in (*site.parameters, *pose_cells(site.pose)))
    for node in nodes_behind(program, cells):
        if node.op == "scan":
            found.setdefault(node.value, []).append(node.args[0])
    return found


@dataclass(frozen=True, slots=True, eq=False)
class Places:
    """The rows below which a repeat has its elements, by candidate: ``owner``, ``address``, the ``row`` of the draw that counts, which
    lies between ``least`` and ``most``; ``first`` (K,), ``many`` (K,) of each candidate."""

    owner: np.ndarray
    address: np.ndarray
    row: np.ndarray
    least: np.ndarray
    most: np.ndarray
    first: np.ndarray
    many: np.ndarray

    @staticmethod
    def of(batch: Batch, one: Repeat) -> Places:
        rows = batch.rowmap.rows(one.parent)
        row = batch.rowmap.up(one.parent, batch.program.draws[one.count].column.scope)
        least, most = (np.rint(end[row]).astype(np.int64) for end in domain_ends(batch, one.count))
        many = np.bincount(rows.owner, minlength=len(batch))
        return Places(rows.owner, rows.address, row, least, most, np.cumsum(many) - many, many)


@dataclass(frozen=True, slots=True, eq=False)
class Layout:
    """How the elements of copies are laid out, the rows of ``Places`` of one copy after the other: ``place``, the ``copy``, how ``many``
    elements, and their ``weight`` (rows, most), as far as there are so many."""

    place: np.ndarray
    copy: np.ndarray
    many: np.ndarray
    weight: np.ndarray


def relaid(
    model: Model,
    batch: Batch,
    of: np.ndarray,
    lane: np.ndarray,
    one: Repeat,
    places: Places,
    layout: Layout,
    contents: dict[int, tuple[np.ndarray, np.ndarray]] | None = None,
) -> Batch:
    """Copies of candidates ``of`` which (K,), with the elements of a repeat laid out anew. What these hold is drawn, by the ``lane`` (K,) of
    each copy, unless ``contents`` has it: keys and values by draw."""
    old, still = batch.state, {}
    for number in range(len(model.program.draws)):
        if number in one.inside:
            key, value = (contents or {}).get(number, (np.zeros(0, dtype=np.uint64), np.zeros(0)))
        elif number == one.weight:
            row, rank = np.nonzero(np.arange(layout.weight.shape[1]) < layout.many[:, None])
            key = mix(mix(places.address[layout.place[row]], rank), layout.copy[row])
            value = layout.weight[row, rank]
        else:
            chosen = rows_of_draw(batch, number, of)
            key, value = chosen.key, old.values[number][chosen.row]
            if number == one.count:
                size = len(old.values[number])
                where = chosen.owner * size + chosen.row  # ascending
                value[np.searchsorted(where, layout.copy * size + places.row[layout.place])] = layout.many
        order = np.argsort(key, kind="stable")
        none = np.zeros(len(key))
        if len(key):
            still[number] = Kept(key[order], value[order], none, none.astype(bool))
    state = State(old.seed, old.objects[of], old.attempt[of], dict(old.given), salt=old.salt, lane=lane)
    state.kept = still
    return make_batch(model.program, model.plan, state, batch.numbers[of])


def contents_of(
    model: Model, batch: Batch, one: Repeat, element: np.ndarray, copy: np.ndarray, rank: np.ndarray
) -> dict[int, tuple[np.ndarray, np.ndarray]]:
    """What the ``element`` (n,) rows of a repeat hold, as it is known once they stand at a ``rank`` (n,) in a ``copy`` (n,) to be made."""
    order = np.argsort(element, kind="stable")
    element, copy, rank = element[order], copy[order], rank[order]
    level = len(batch.rowmap.ranks(one.scope)) - 1
    found = {}
    for number in one.inside:
        scope = model.program.draws[number].column.scope
        above = batch.rowmap.up(scope, one.scope)  # ascending
        low, high = (np.searchsorted(above, element, side=side) for side in ("left", "right"))
        many = high - low
        which = np.repeat(np.arange(len(element)), many)
        row = np.arange(len(which)) - np.repeat(np.cumsum(many) - many, many) + np.repeat(low, many)
        address = batch.state.objects[batch.owner(scope)[row]].astype(np.uint64)
        for depth, (_, ranks) in enumerate(batch.rowmap.ranks(scope)):
            address = mix(address, rank[which] if depth == level else ranks[row])
        found[number] = mix(address, copy[which]), batch.state.values[number][row]
    return found


def boxes_of_elements(batch: Batch, one: Repeat) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Low and high corners (n, 3) of the boxes of the elements of a repeat, inf and -inf where one has no primitives; and for each row of
    all tables of a batch, one after the other, the element that it belongs to, -1 for none."""
    size = batch.rowmap.rows(one.scope).size
    low, high = np.full((size, 3), np.inf), np.full((size, 3), -np.inf)
    element = [np.zeros(0, dtype=np.int64)]
    for table, site in zip(tables(batch), batch.program.sites, strict=True):
        within = site.scope.within(one.scope)
        element.append(batch.rowmap.up(site.scope, one.scope) if within else np.full(len(table), -1))
        if within and len(table):
            least, most = table.boxes()
            np.minimum.at(low, element[-1], least)
            np.maximum.at(high, element[-1], most)
    return low, high, np.concatenate(element)
