"""Joints of candidates: at rest, or anywhere in their ranges, where their values are numbers like others. Primitives stand where they lead."""

from __future__ import annotations

from dataclasses import field, fields, replace

import numpy as np

from .. import random
from ..annotate.states import rest_values
from ..geometry.sites import SiteTable
from ..graph.expr import Column
from ..graph.program import Draw, Program
from ..records import dataclass
from ..runtime import motion
from ..runtime.batch import Batch
from ..runtime.kernels import State
from ..runtime.needs import motion_of
from ..runtime.plan import make_plan
from .bare import bare_tables

_LOOKED = 64  # objects that tell whether joints rest at 0
_KINDS = ("revolute", "prismatic")
_TABLES = "fit.tables"


@dataclass(slots=True, eq=False)
class Searched(Program):
    """A program as fits search it; ``jointed``: with how links move, as the joints of what is fitted are known."""

    jointed: bool = False


@dataclass(slots=True, eq=False)
class Moved(Searched):
    """A program whose candidates do not have all joints at 0, where primitives are described."""


@dataclass(slots=True, eq=False)
class Opened(Moved):
    """A program that also draws the values of joints: ``states`` has the number of the draw for that of a joint. The other draws
    have the numbers and the values that they have without."""

    states: dict[int, int] = field(default_factory=dict)


def is_jointed(program: Program) -> bool:
    """Whether candidates of a program are compared by how their links move."""
    return isinstance(program, Searched) and program.jointed


def resting(program: Program, jointed: bool) -> Program:
    """The program as one whose joints are at rest, if some of its objects rest elsewhere than at 0: for the others that is only slower.
    ``jointed``: as one with how links move."""
    plan = make_plan(program, list(motion_of(program)))
    state = State(0, np.arange(_LOOKED), np.zeros(_LOOKED, dtype=np.int64))
    # without the ends that solids leave to joints, which take long and which a rest does not depend on
    batch = Batch(program, plan, state, *plan.function(state))
    told = {one.name: getattr(program, one.name) for one in fields(Program)}
    if not rest_values(batch).any():
        return Searched(**told, jointed=True) if jointed else program
    return Moved(**told, jointed=jointed)


def can_open(program: Program) -> bool:
    """Whether some joint has a range in which it can be looked for: a hinge or a slide, not in a closed loop, that follows no other."""
    return bool(_free(program))


def _free(program: Program) -> list[int]:
    if program.closures:
        return []
    return [
        number
        for number, joint in enumerate(program.joints)
        if joint.kind in _KINDS and None not in (joint.low, joint.high) and joint.mimic is None and joint.curve is None
    ]


def opened(program: Program, jointed: bool) -> Opened:
    """The program, ``jointed`` or not, with a draw for each joint that can be opened, after all others."""
    draws, states = list(program.draws), {}
    for number in _free(program):
        joint = program.joints[number]
        states[number] = len(draws)
        name = f"value of {joint.path}"
        draws.append(Draw(Column(joint.scope, name), name, "real", joint.low, joint.high))
    told = {one.name: getattr(program, one.name) for one in fields(Program)}
    joints = [replace(joint, clearance=False) for joint in program.joints]  # as far as the text lets them
    return Opened(**{**told, "draws": draws, "joints": joints}, jointed=jointed, states=states)


def joint_values(batch: Batch) -> np.ndarray:
    """(J,) the values of the joints of candidates: those drawn, others at rest."""
    program = batch.program
    if not isinstance(program, Opened):
        return rest_values(batch)
    columns = []
    for number, joint in enumerate(program.joints):
        drawn = program.states.get(number)
        size = batch.rowmap.rows(joint.scope).size
        columns.append(np.full(size, np.nan) if drawn is None else batch.state.values[drawn])
    found = batch.joint_instances.sort(columns)
    return np.where(np.isnan(found), rest_values(batch), found)


def tables(batch: Batch) -> list[SiteTable]:
    """The primitives of candidates, where the values of their joints lead them."""
    found: list[SiteTable] | None = batch.known.get(_TABLES)
    if found is None:
        found = bare_tables(batch, linked=isinstance(batch.program, Moved))
        if isinstance(batch.program, Moved):
            found = _led(batch, found, joint_values(batch))
        batch.known[_TABLES] = found
    return found


def moved(batch: Batch, values: np.ndarray) -> list[SiteTable]:
    """The primitives of a batch for joint values (J,)."""
    return _led(batch, batch.sites(), values)


def _led(batch: Batch, sites: list[SiteTable], values: np.ndarray) -> list[SiteTable]:
    rotation, translation = batch.pose(values)
    first = np.searchsorted(batch.links().owner, np.arange(len(batch)))
    at = np.concatenate([np.zeros(0, dtype=np.int64), *(first[table.owner] + table.link for table in sites)])
    own, there = (
        np.concatenate([none, *(getattr(table, name) for table in sites)])
        for name, none in (("rotation", np.zeros((0, 3, 3))), ("translation", np.zeros((0, 3))))
    )
    turned = motion.multiply(rotation[at], own)
    shifted = motion.apply(rotation[at], there) + translation[at]
    ends = np.cumsum([len(table) for table in sites])[:-1]
    parted = zip(sites, np.split(turned, ends), np.split(shifted, ends), strict=True)
    return [replace(table, rotation=one, translation=other) for table, one, other in parted]


def carried(batch: Batch, found: Batch) -> np.ndarray:
    """(J,) joint values of a batch that are those of the candidates ``found``, object by object and name by name; others at rest."""
    values = rest_values(batch).copy()
    ours, theirs = (
        np.array([f"{owner} {name}" for owner, name in zip(b.joints().owner, b.joints().name, strict=True)], dtype=str)
        for b in (batch, found)
    )
    _, here, there = np.intersect1d(ours, theirs, return_indices=True)
    values[here] = joint_values(found)[there]
    return batch.settle(values)


def shut(batch: Batch, seed: int) -> tuple[np.ndarray, np.ndarray, np.ndarray, np.ndarray]:
    """Which joints of drawn candidates are put to rest: all of every other candidate, half of those of the rest. Candidate, draw, row,
    value."""
    program = batch.program
    assert isinstance(program, Opened)
    told: list[list[np.ndarray]] = [[], [], [], []]
    for number, drawn in program.states.items():
        joint = program.joints[number]
        rows = batch.rowmap.rows(joint.scope)
        at_rest = batch.read([joint.rest], joint.scope)[0]
        chance = random.uniform(random.key(seed, "fit", "shut", joint.path), rows.address)
        own = np.flatnonzero((batch.state.objects[rows.owner] % 2 == 0) | (chance < 0.5))
        for column, one in zip(
            told, (rows.owner, np.full(len(rows.owner), drawn), np.arange(len(rows.owner)), at_rest), strict=True
        ):
            column.append(one[own])
    copy, draw, row, value = (np.concatenate([np.zeros(0), *column]) for column in told)
    order = np.argsort(copy, kind="stable")
    return copy[order].astype(np.int64), draw[order].astype(np.int64), row[order].astype(np.int64), value[order]
