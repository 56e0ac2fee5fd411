"""A batch: the objects of some numbers as tables, and everything that follows from them."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from copy import copy
from dataclasses import fields, replace
from functools import cache, cached_property, lru_cache
from typing import Any

import numpy as np

from ..geometry.sites import SiteTable
from ..graph.expr import Expr, Scope
from ..graph.program import Program
from ..graph.reference import Reference
from . import motion
from .curves import add_curves
from .detents import rest_caught
from .drawn import Drawn
from .gates import Gates, gates_of
from .kernels import State
from .loops import Loops, loops_of
from .needs import find_wanted, pose_cells
from .plan import Plan, make_plan
from .referred import Referred
from .repairs import Repairs
from .rooted import lead_by_heads, root_joints
from .tables import Instances, JointTable, LinkTable, PartTable, Rowmap
from .tags import make_distinct
from .words import words_of_link, words_of_parts

_UNLIKE = np.array([1.0, 2.0])  # turns and axis of a part that is like itself only as it stands


class Batch:
    """Objects of one program as columns. ``numbers`` (B,) are the object numbers, ``seed`` what they were drawn with.

    ``ends`` gives the joints of a batch the ends that they have where they go on as far as nothing is in the way, which
    solids tell (``validity.clearance``); without it they keep the ends of their ranges.
    ``history``: the operations that made them from others (``sampling.mutate.Stage``), the first first. ``repairs``: what was
    moved to make them valid.
    """

    def __init__(
        self,
        program: Program,
        plan: Plan,
        state: State,
        tables: list[Any],
        values: list[Any],
        numbers: np.ndarray | None = None,
        ends: Callable[[Batch], JointTable] | None = None,
    ):
        self.program, self.plan, self.state = program, plan, state
        self.seed = state.seed
        self.numbers = (state.objects if numbers is None else np.asarray(numbers)).astype(np.int64)
        self.history: tuple[Any, ...] = ()
        self.repairs: Repairs = Repairs.none()
        self.known: dict[str, Any] = {}  # what other rooms worked out, the same wherever joints end
        self._tables, self._values, self._ends = tables, values, ends
        self._extra: dict[tuple[Expr, Scope], Any] = {}  # what was read that is not planned
        self.rowmap = Rowmap(plan.scopes, tables)

    def __len__(self) -> int:
        return len(self.numbers)

    def __copy__(self) -> Batch:
        twin = object.__new__(type(self))
        twin.__dict__.update(self.__dict__)
        return twin

    def __reduce__(self) -> tuple[Any, tuple[Any, ...]]:
        """To another process goes what it was evaluated with: the code and what was worked out since are made anew there."""
        return _revived, (self.program, self._asked(), self.numbers, self._ends, self.history, self.repairs)

    def _asked(self, *, weigh: bool = False) -> State:
        """The state to evaluate again what this is."""
        old = self.state
        asked = (old.seed, old.objects, old.attempt, old.given, old.defaults, old.kept, old.salt, old.lane)
        return State(*asked, weigh=weigh, asked=old.asked)

    # ------------------------------------------------------------ reading

    def owner(self, scope: Scope) -> np.ndarray:
        """The object (0 .. B - 1) of each row of a scope, ascending."""
        return self.rowmap.rows(scope).owner

    def read(self, exprs: Sequence[Expr], scope: Scope) -> list[np.ndarray]:
        """One array (rows of ``scope``,) per expression."""
        size = self.rowmap.rows(scope).size
        found = (np.asarray(value) for value in self._values_of(exprs, scope))
        return [array if array.shape == (size,) else np.full(size, array) for array in found]

    def _values_of(self, exprs: Sequence[Expr], scope: Scope) -> list[Any]:
        """The same, where all rows may share one value."""
        missing = [e for e in exprs if (e, scope) not in self.plan.outputs and e.op != "const"]
        if any((e, scope) not in self._extra for e in missing):
            plan = self.plan.also(tuple((e, scope) for e in missing))
            _, values = plan.function(self._asked())
            self._extra |= {(e, scope): values[plan.outputs[e, scope]] for e in missing}
        return [
            expr.value
            if expr.op == "const"
            else self._extra[expr, scope]
            if (expr, scope) in self._extra
            else self._values[self.plan.outputs[expr, scope]]
            for expr in exprs
        ]

    def _vectors(self, cells: Sequence[Expr], scope: Scope) -> np.ndarray:
        """(rows, len(cells)) float64."""
        found = np.empty((self.rowmap.rows(scope).size, len(cells)))
        for k, value in enumerate(self._values_of(cells, scope)):
            found[:, k] = value
        return found

    def _poses(self, pose: Any, scope: Scope) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        cells = self._vectors(pose_cells(pose), scope)
        return cells[:, :9].reshape(-1, 3, 3), cells[:, 9:12], cells[:, 12]

    # ------------------------------------------------------------ instances

    @cached_property
    def link_instances(self) -> Instances:
        return Instances.of([self.owner(link.scope) for link in self.program.links], len(self))

    @cached_property
    def _part_instances(self) -> Instances:
        return Instances.of([self.owner(part.scope) for part in self.program.parts], len(self))

    @cached_property
    def joint_instances(self) -> Instances:
        """Where the rows of each joint of the program stand in the table of joints."""
        return Instances.of([self.owner(joint.scope) for joint in self.program.joints], len(self))

    @property
    def part_count(self) -> int:
        """How many rows the table of parts has."""
        return len(self._part_instances.owner)

    def part_rows(self, number: int) -> np.ndarray:
        """The rows of the table of parts that are instances of a part of the program, in the order of its scope's rows."""
        made = self._part_instances
        return made.place[made.starts[number] + np.arange(self.rowmap.rows(self.program.parts[number].scope).size)]

    def link_numbers(self, scope: Scope, links: Reference) -> np.ndarray:
        """The link number within its object for each row of a scope, given a reference to links."""
        # not kept: it would hold the batch that holds it, and both would stay until garbage is collected
        referred = Referred(self.rowmap, self.link_instances, [link.scope for link in self.program.links], self.read)
        return np.maximum(referred.numbers(scope, links), 0)

    @cached_property
    def _words(self) -> list[np.ndarray]:
        """For each part (rows of its scope,) the place of its word in the vocabulary ``semantic``, 0 where it has none."""
        return words_of_parts(self.program, self.rowmap, self.read)

    def _meant(self, number: int, scope: Scope) -> tuple[np.ndarray, np.ndarray]:
        """For each row of a scope within that of a part: the number in its object of the nearest part at or above that
        one which bears a semantic word, or of itself, and the word's place, 0 for none."""
        parts, at = self.program.parts, number
        instance = self._part_instances.numbers(at, self.rowmap.across(scope, parts[at].scope))
        word = np.zeros(len(instance), dtype=np.int64)
        while at >= 0:
            if parts[at].semantic:
                row = self.rowmap.across(scope, parts[at].scope)
                own = np.where(word == 0, self._words[at][row], 0)
                instance = np.where(own > 0, self._part_instances.numbers(at, row), instance)
                word += own
            at = parts[at].parent
        return instance, word

    def sites(self) -> list[SiteTable]:
        """The elementary primitives, placed at joint values 0."""
        return self._sites

    @cached_property
    def _sites(self) -> list[SiteTable]:
        found = []
        links = cache(self.link_numbers)  # of many sites the same
        for number, site in enumerate(self.program.sites):
            owner = self.owner(site.scope)
            primitive = self.program.primitives[site.primitive]
            rotation, translation, mirror = self._poses(site.pose, site.scope)
            values = self.read(site.parameters, site.scope)
            params = {n: np.asarray(v, dtype=np.float64) for n, v in zip(primitive.parameters, values, strict=True)}
            params = params or {"": np.zeros(len(owner))}
            instance, word = self._meant(site.part, site.scope)
            first = np.searchsorted(owner, np.arange(len(self)))
            rank = np.arange(len(owner)) - first[owner]
            found.append(
                SiteTable(
                    number,
                    site.path,
                    primitive,
                    params,
                    owner,
                    rotation,
                    translation,
                    mirror,
                    links(site.scope, site.link),
                    instance,
                    word,
                    rank,
                )
            )
        return found

    def links(self) -> LinkTable:
        """The rigid links."""
        return self._links

    @cached_property
    def _links(self) -> LinkTable:
        rotations, translations, names, words = [], [], [], []
        made = self.link_instances
        for link in self.program.links:
            part = self.program.parts[link.part] if link.part >= 0 else None
            size = self.rowmap.rows(link.scope).size
            if part is not None and link.scope.within(part.scope):
                rotation, translation, _ = self._poses(part.pose, link.scope)
            else:
                rotation, translation = np.tile(np.eye(3), (size, 1, 1)), np.zeros((size, 3))
            rotations.append(rotation)
            translations.append(translation)
            words.append(words_of_link(self.program, self.rowmap, self._words, link))
            names.append(self.rowmap.names(link.scope, link.path))
        return LinkTable(
            made.owner,
            made.number,
            make_distinct(made.sort_names(names), made.owner),
            made.definition,
            made.sort(rotations, (3, 3)),
            made.sort(translations, (3,)),
            made.sort(words, dtype=np.int64),
        )

    @cached_property
    def link_words(self) -> list[str]:
        """The word of each link (L,), "" where it has none."""
        words = self.program.vocabularies.get("semantic", ())
        return [words[k] if k else "" for k in self.links().semantic.tolist()]

    def joints(self) -> JointTable:
        """The joints, each the one above its child link."""
        return self._limited

    @cached_property
    def _limited(self) -> JointTable:
        """The joints, those that go on as far as nothing is in the way with the ends that they have, and those of loops at rest where
        the loops put them; no program has both."""
        wide = copy(self)
        wide.__dict__["_limited"] = self._joints
        if self.program.closures:
            loops = wide.loops
            return self._joints if loops is None else replace(self._joints, rest=loops.settle(self._joints.rest))
        if self._ends is None or not any(joint.clearance for joint in self.program.joints):
            return self._joints
        return self._ends(wide)

    @cached_property
    def _joints(self) -> JointTable:
        made, program = self.joint_instances, self.program
        columns: dict[str, list[np.ndarray]] = {name: [] for name in _JOINT_COLUMNS}
        names: list[list[str]] = []
        leaders = Referred(self.rowmap, made, [joint.scope for joint in program.joints], self.read)
        for joint in program.joints:
            scope, size = joint.scope, self.rowmap.rows(joint.scope).size
            columns["parent"].append(self.link_numbers(scope, joint.parent))
            columns["child"].append(self.link_numbers(scope, (joint.child,)))
            columns["origin"].append(self._vectors(joint.origin, scope))
            columns["axis"].append(self._vectors(joint.axis, scope))
            for name in ("low", "high", "damping", "friction", "stiffness", "effort", "velocity", "pitch", "positions"):
                expr = getattr(joint, name)
                columns[name].append(np.full(size, np.nan) if expr is None else self.read([expr], scope)[0])
            columns["rest"].append(self.read([joint.rest], scope)[0])
            mimic, multiplier, offset = np.full(size, -1), np.ones(size), np.zeros(size)
            if joint.mimic is not None:
                mimic = leaders.numbers(scope, joint.mimic[0])
                multiplier, offset = self.read(joint.mimic[1:], scope)
            columns["mimic"].append(mimic)
            columns["multiplier"].append(multiplier)
            columns["offset"].append(offset)
            names.append(self.rowmap.names(scope, joint.path))
        kinds = [program.joints[d].kind for d in made.definition]
        sorted_columns = {
            name: made.sort(
                values,
                (3,) if name in ("origin", "axis") else (),
                np.int64 if name in ("parent", "child", "mimic") else np.float64,
            )
            for name, values in columns.items()
        }
        table = JointTable(
            made.owner,
            made.number,
            make_distinct(made.sort_names(names), made.owner),
            made.definition,
            kinds,
            curves=(),
            **sorted_columns,
        )
        return root_joints(add_curves(lead_by_heads(rest_caught(table)), self), self.numbers)

    def parts(self) -> PartTable:
        """The parts, elementary ones too."""
        return self._parts

    @cached_property
    def _parts(self) -> PartTable:
        made, program = self._part_instances, self.program
        rotations, translations, lows, highs, parents, links, semantics, symmetries, holders = ([] for _ in range(9))
        names = []
        referred = Referred(self.rowmap, made, [part.scope for part in program.parts], self.read)
        for number, part in enumerate(program.parts):
            size = self.rowmap.rows(part.scope).size
            rotation, translation, mirror = self._poses(part.pose, part.scope)
            low, high = (self._vectors(end, part.scope) for end in (part.low, part.high))
            low[:, 1], high[:, 1] = np.where(mirror < 0, (-high[:, 1], -low[:, 1]), (low[:, 1], high[:, 1]))
            rotations.append(rotation)
            translations.append(translation)
            lows.append(low)
            highs.append(high)
            if part.parent >= 0:
                row = self.rowmap.across(part.scope, program.parts[part.parent].scope)
                parents.append(made.numbers(part.parent, row))
            else:
                parents.append(np.full(size, -1))
            links.append(self.link_numbers(part.scope, part.link))
            semantics.append(self._words[number])
            holders.append(referred.numbers(part.scope, part.holder))
            turns = _UNLIKE if part.symmetry is None else self._vectors(part.symmetry, part.scope)
            symmetries.append(np.broadcast_to(turns, (size, 2)))
            names.append(self.rowmap.names(part.scope, part.path))
        return PartTable(
            made.owner,
            made.number,
            made.sort_names(names),
            [program.parts[d].path for d in made.definition],
            [program.parts[d].template for d in made.definition],
            made.definition,
            made.sort(parents, dtype=np.int64),
            made.sort(semantics, dtype=np.int64),
            made.sort(links, dtype=np.int64),
            made.sort(rotations, (3, 3)),
            made.sort(translations, (3,)),
            made.sort(lows, (3,)),
            made.sort(highs, (3,)),
            made.sort(symmetries, (2,), np.int64),
            made.sort(holders, dtype=np.int64),
        )

    # ------------------------------------------------------------ motion

    def rest(self) -> np.ndarray:
        """Joint values (J,) at rest."""
        return self.joints().rest

    def pose(self, states: np.ndarray | None = None) -> tuple[np.ndarray, np.ndarray]:
        """Rotation (..., L, 3, 3), translation (..., L, 3) that move each link from joint values 0 to ``states`` (..., J), rest by
        default."""
        values = self.settle(self.rest() if states is None else states)
        return self._chains.motion(motion.follow(self.joints(), values))

    @cached_property
    def _chains(self) -> motion.JointChains:
        return motion.JointChains(self.links(), self.joints())

    def settle(self, states: np.ndarray) -> np.ndarray:
        """Joint values (..., J) as mimics, closed loops and gates have them, the driving joints as in ``states``: one whose gates
        are not all open stays at rest."""
        if self.gates is not None:
            states = self.gates.settle(states)
        if self.loops is None:
            return motion.follow(self.joints(), states)
        return self.loops.settle(states)

    @cached_property
    def gates(self) -> Gates | None:
        """Which joints move only while others are open, where the program states any."""
        return gates_of(self)

    @cached_property
    def loops(self) -> Loops | None:
        """The closed loops, where the program states any."""
        return loops_of(self)

    # ------------------------------------------------------------ what was drawn

    @cached_property
    def log_weight(self) -> np.ndarray:
        """(B,) logarithm of how dense the declared distributions are at each object, against how dense its drawing was.

        Each variable is drawn in the range that the ones before leave it; the share of the declared distribution that
        lies in this range, multiplied over the draws, is the weight. Objects drawn in sequence and weighed by it are
        distributed as declared, restricted to what is valid.
        """
        state = self._asked(weigh=True)
        self.plan.bare.function(state)
        return state.log_weight

    def drawn(self, index: int) -> dict[str, Any]:
        """The drawn parameters, counts and choices of the object at ``index``: lists where a repeat draws several.

        A list has the values of all elements in their order, also where alternatives of a part share the name.
        """
        return self._drawn.of(index)

    @cached_property
    def _drawn(self) -> Drawn:
        return Drawn(self.program, self.rowmap, self.owner, self.state.values, len(self))

    def values(self) -> dict[str, np.ndarray]:
        """Each drawn column by its address: one value per row of its table (choices as indices)."""
        return {draw.address: self.state.values[k] for k, draw in enumerate(self.program.draws)}


# behind those that say which joint it is, before `curves`
_JOINT_COLUMNS = tuple(f.name for f in fields(JointTable))[5:-1]


@lru_cache(maxsize=8)
def full_plan(program: Program) -> Plan:
    """The plan of all that a batch is asked for; one for all batches of a program that came from another process."""
    return make_plan(program, find_wanted(program))


def _revived(
    program: Program,
    state: State,
    numbers: np.ndarray,
    ends: Callable[[Batch], JointTable] | None,
    history: tuple[Any, ...],
    repairs: Repairs,
) -> Batch:
    """A batch from what it was evaluated with; the same to the bit."""
    plan = full_plan(program)
    tables, values = plan.function(state)
    batch = Batch(program, plan, state, tables, values, numbers, ends)
    batch.history, batch.repairs = history, repairs
    return batch
