"""Joint values to show an object in: at rest, open, drawn at random within the limits; and how points move."""

from __future__ import annotations

import re
from collections.abc import Iterable, Sequence
from typing import TYPE_CHECKING

import numpy as np

from .. import random
from ..diagnostics.suggest import did_you_mean
from ..errors import UsageError
from ..graph.interval import Intervals
from ..language import JOINTS
from ..records import dataclass
from ..runtime.detents import caught, in_positions
from ..runtime.motion import freedoms_of
from .frames import rotate

if TYPE_CHECKING:
    from ..graph.program import Joint, Program
    from ..runtime.batch import Batch

_MOST = 10_000
_SLACK = 1e-6  # of limits, in metres and radians: values may have been float32
_FORMS = "`rest`, `open`, `random:K`, `joint=45deg`, or several of them with commas between"
_CHOSEN = re.compile(r"([A-Za-z_][\w.]*)\s*=\s*([-+]?(?:\d+\.?\d*|\.\d+))\s*(deg|rad|turn|mm|cm|m|%)")
_ANGLES = {"deg": np.pi / 180, "rad": 1.0, "turn": 2 * np.pi}
_LENGTHS = {"m": 1.0, "cm": 0.01, "mm": 0.001}


@dataclass(frozen=True, slots=True)
class States:
    """The configurations asked for, in order: ``("rest", 1)``, ``("open", 1)``, ``("random", K)`` or ``("a=1rad", 1)``."""

    wanted: tuple[tuple[str, int], ...] = (("rest", 1),)

    @property
    def count(self) -> int:
        return sum(count for _, count in self.wanted)

    @property
    def only_rest(self) -> bool:
        """Whether nothing but the rest is asked for: arrays then have no axis of states."""
        return self.wanted == (("rest", 1),)

    def __str__(self) -> str:
        return ",".join(f"{name}:{count}" if name == "random" else name for name, count in self.wanted)


REST = States()


def read_states(text: str) -> States:
    """``rest``, ``open``, ``random:4``, ``door=45deg+lid=20%``, or several with commas between. Raises UsageError."""
    if not isinstance(text, str):
        raise UsageError(f"states is {text!r}: text is needed", f"write {_FORMS}")
    wanted = []
    for piece in (p.strip() for p in text.split(",")):
        if all(_CHOSEN.fullmatch(one.strip()) for one in piece.split("+")):
            named = [one.partition("=")[0].strip() for one in piece.split("+")]
            if twice := next((name for k, name in enumerate(named) if name in named[:k]), None):
                raise UsageError(
                    f"`{piece}` gives `{twice}` two values", "for two states, write a comma for the plus sign"
                )
            wanted.append((piece, 1))
            continue
        match = re.fullmatch(r"(rest|open|random)(?::(\d{1,9}))?", piece)
        if match is None:
            if re.fullmatch(r"[\w.\[\]]+\s*=\s*[-+.\d]+", piece):
                raise UsageError(f"`{piece}` has no unit", "write mm, cm, m, deg, rad, turn or % after the number")
            raise UsageError(f"`{piece}` is not a joint state", f"write {_FORMS}")
        name, count = match.group(1), match.group(2)
        if name != "random" and count is not None:
            raise UsageError(f"`{piece}`: there is only one state `{name}`", f"write {name}, or random:{count}")
        if name == "random" and not 1 <= int(count or 0) <= _MOST:
            raise UsageError(f"`{piece}`: a number from 1 to {_MOST} is needed", "for example random:4")
        wanted.append((name, int(count or 1)))
    return States(tuple(wanted))


def joint_values(batch: Batch, states: States) -> np.ndarray:
    """Joint values (K, J) of the whole batch in the states asked for; mimics and closed loops follow."""
    found: list[np.ndarray] = []
    drawn = 0
    for name, count in states.wanted:
        if name == "random":
            found += [draw_values(batch, k) for k in range(drawn, drawn + count)]
            drawn += count
        else:
            found.append(
                rest_values(batch)
                if name == "rest"
                else caught(batch.joints(), open_values(batch))
                if name == "open"
                else _parse_state(batch, name)
            )
    return np.stack([batch.settle(values) for values in found])


def read_values(batch: Batch, states: str | np.ndarray | None, *, several: bool = True) -> np.ndarray | None:
    """Joint values as given, (J,) or with ``several`` (K, J); of text that names one state (J,), of None none. Raises UsageError."""
    if states is None:
        return None
    if isinstance(states, str):
        read = read_states(states)
        found = joint_values(batch, read)
        found = found[0] if read.count == 1 else found
    else:
        found = np.asarray(states)
    joints = len(batch.joints().owner)
    if found.dtype.kind not in "fiu" or found.ndim not in (1, 2) or found.shape[-1] != joints:
        raise UsageError(
            f"states are text or joint values, one for each of {joints} joints: not {type(states).__name__} of shape {found.shape}",
            "such as open=60deg; `rest`, `opened`, `states` and `joint_values` of the same objects give values",
        )
    if found.ndim == 2 and not len(found):
        raise UsageError("no states are given: there is no row of joint values", "leave them out for the rest")
    if found.ndim == 2 and not several:
        raise UsageError(f"{len(found)} states, where one is shown at a time", "give the values (J,) of one of them")
    if not np.isfinite(found).all():
        raise UsageError("joint values are finite: some of the states are not", "`rest()` has a value for every joint")
    if not isinstance(states, str):
        _refuse_beyond(batch, found)
    return found


def _refuse_beyond(batch: Batch, values: np.ndarray) -> None:
    """Refuse joint values (..., J) beyond the limits of joints that follow no other. Raises UsageError."""
    joints = batch.joints()
    low = np.where(joints.that("tilts"), -joints.high, joints.low)  # a ball tilts to any side
    beyond = (values < low - _SLACK) | (values > joints.high + _SLACK)  # a missing limit is nan: nothing is beyond it
    beyond &= joints.mimic < 0
    if batch.loops is not None:
        beyond[..., batch.loops.variable[batch.loops.follows]] = False
    if beyond.any():
        place = np.argwhere(beyond)[0]
        k = place[-1]
        raise UsageError(
            f"joint `{joints.name[k]}` of object {batch.numbers[joints.owner[k]]} cannot be at {values[tuple(place)]:g}: "
            f"it moves from {low[k]:g} to {joints.high[k]:g} {'m' if JOINTS[joints.kind[k]].slides else 'rad'}",
            "`states(...)` and text such as open=60deg keep within the limits",
        )


def rest_values(batch: Batch) -> np.ndarray:
    """Joint values (J,) at rest, 0 where a joint states none."""
    rest = batch.joints().rest
    return np.where(np.isnan(rest), 0.0, rest)


def open_values(batch: Batch, share: float = 0.8) -> np.ndarray:
    """Joint values (J,) with every limited joint ``share`` of the way from rest to its farther end.

    A joint that another waits for goes as far as it can where that is not far enough. What mimics another joint is put
    right by ``batch.pose``.
    """
    values, low, high = _part_way(batch, share)
    return values if batch.gates is None else batch.gates.open(values, np.ones(len(values), dtype=bool), low, high)


def _part_way(batch: Batch, share: float) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Joint values (J,) ``share`` of the way from rest to the farther end, and both ends (J,); a missing one is the rest."""
    joints, rest = batch.joints(), rest_values(batch)
    low, high = (np.where(np.isnan(limit), rest, limit) for limit in (joints.low, joints.high))
    end = np.where(high - rest >= rest - low, high, low)
    return rest + share * (end - rest), low, high


def name_values(batch: Batch, named: Iterable[tuple[str, float, str]]) -> np.ndarray:
    """Joint values (J,) of all joints of the names, each with a number and its unit, the others at rest.

    The unit % is of the way from rest to the farther end, none means radians or metres. Values stay within the limits. What a
    joint waits for is open, unless it is named too. Raises UsageError.
    """
    joints, values = batch.joints(), rest_values(batch)
    chosen = np.zeros(len(values), dtype=bool)
    own = [batch.program.joints[k].name for k in joints.definition]
    every = list(dict.fromkeys(joint.name for joint in batch.program.joints))
    defined = {name for joint in batch.program.joints for name in (joint.name, joint.path)} | set(joints.name)
    for name, number, unit in named:
        if name not in defined:
            known = f"its joints are {', '.join(every)}" if every else "it has none at all"
            raise UsageError(f"{batch.program.name} has no joint `{name}`", did_you_mean(name, every) or known)
        rows = [k for k, names in enumerate(zip(joints.name, own, strict=True)) if name in names]
        meant = _meant(batch.program, name)
        _refuse_idle(batch, name, meant, rows, unit)
        _refuse_far(batch.program, name, meant, number, unit)
        chosen[rows] = True
        if unit == "%":
            values[rows] = _part_way(batch, number / 100)[0][rows]
            continue
        for kind in sorted({joints.kind[row] for row in rows}):
            units = _LENGTHS if JOINTS[kind].slides else _ANGLES
            if unit and unit not in units:
                raise UsageError(
                    f"`{name}={number:g}{unit}`: the joint is {kind}",
                    f"write {name}=20% or a unit of {', '.join(units)}",
                )
            mine = [row for row in rows if joints.kind[row] == kind]
            values[mine] = number * units.get(unit, 1.0)
    low, high = (np.where(np.isnan(end), values, end) for end in (joints.low, joints.high))
    values = np.clip(values, low, high)
    return (
        values
        if batch.gates is None
        else np.where(chosen, values, batch.gates.open(values, chosen, joints.low, joints.high))
    )


def _meant(program: Program, name: str) -> list[Joint]:
    """The joints of a program of which a name may be."""
    names = {name, re.sub(r"_\d+(?=\.|$)", "", name)}  # half_1.open is one of half.open
    return [joint for joint in program.joints if names & {joint.name, joint.path}]


def _refuse_far(program: Program, name: str, meant: Sequence[Joint], number: float, unit: str) -> None:
    """A value that no object reaches, by the domains of its program."""
    if unit == "%":
        if number > 100:
            raise UsageError(f"`{name}={number:g}%` is more than the whole way", f"write {name}=100% for its end")
        return
    asked = [joint for joint in meant if unit in ("", *(_LENGTHS if JOINTS[joint.kind].slides else _ANGLES))]
    if not asked or any(joint.low is None or joint.high is None or joint.mimic is not None for joint in asked):
        return
    domains = Intervals(program.draws, program.definitions)
    ends = [(domains.of(joint.low), domains.of(joint.high)) for joint in asked if joint.low and joint.high]
    tilting = any(JOINTS[joint.kind].tilts for joint in asked)
    high = max(far[1] for _, far in ends)
    low = -high if tilting else min(near[0] for near, _ in ends)
    scale = {**_LENGTHS, **_ANGLES}.get(unit, 1.0)
    if not low - _SLACK <= number * scale <= high + _SLACK:
        raise UsageError(
            f"`{name}={number:g}{unit}` is out of reach: the joint moves from {low / scale:.4g}{unit} to {high / scale:.4g}{unit} at most",
            f"values beyond the limits of some objects are clipped; write {name}=100% for the end of each",
        )


def _refuse_idle(batch: Batch, name: str, meant: Sequence[Joint], rows: list[int], unit: str) -> None:
    """A name that moves nothing, in whichever objects: of joints that follow others, or a share of a way that has no end."""
    joints = batch.joints()
    if unit == "%" and meant and all(joint.low is None and joint.high is None for joint in meant):
        raise UsageError(f"the joint `{name}` has no end to share the way to", f"write a value, such as {name}=45deg")
    if rows and all(joint.mimic is not None for joint in meant) and (joints.mimic[rows] >= 0).all():
        same = np.flatnonzero(joints.owner == joints.owner[rows[0]])
        leader = joints.name[same[joints.number[same] == joints.mimic[rows[0]]][0]]
        raise UsageError(f"the joint `{name}` follows `{leader}`", "name that one: both move then")


def _parse_state(batch: Batch, text: str) -> np.ndarray:
    """Joint values (J,) such as ``door=45deg+drawer=5cm``."""
    named = []
    for piece in text.split("+"):
        read = _CHOSEN.fullmatch(piece.strip())
        assert read is not None  # as it was read
        name, number, unit = read.groups()
        named.append((name, float(number), unit))
    return name_values(batch, named)


def draw_values(batch: Batch, k: int) -> np.ndarray:
    """The ``k``-th random joint values (J,): independent and uniform within the limits, -pi .. pi where none are, or over positions.

    Addressed by object, path of the joint and rank of its repeats. A sliding joint without a limit rests.
    """
    joints, values = batch.joints(), rest_values(batch)
    definition = np.asarray(joints.definition)
    turning = joints.that("turns", "tilts")
    free = np.array([JOINTS[kind].endless for kind in joints.kind], dtype=bool)
    low, high = (
        np.where(free | (turning & np.isnan(limit)), end, np.where(np.isnan(limit), values, limit))
        for limit, end in ((joints.low, -np.pi), (joints.high, np.pi))
    )
    instance = joints.owner * len(batch.program.joints) + definition
    rank = np.arange(len(instance)) - np.searchsorted(instance, instance)
    share = np.zeros(len(instance))
    address = random.mix(np.asarray(batch.numbers).astype(np.uint64)[joints.owner], rank)
    for number, joint in enumerate(batch.program.joints):
        at = np.flatnonzero(definition == number)
        if len(at):
            share[at] = random.uniform(random.key(batch.seed, "states", joint.path), address[at], 0, k)
            values[at] = low[at] + share[at] * (high[at] - low[at])
    return in_positions(joints, share, values)


def state_table(batch: Batch, values: np.ndarray) -> np.ndarray:
    """Joint values (K, J) as (B, K, most joints of an object), each in the order of its annotation, then nan."""
    joints = batch.joints()
    counts = np.bincount(joints.owner, minlength=len(batch))
    table = np.full((len(batch), len(values), int(counts.max(initial=0))), np.nan)
    number = np.asarray(joints.number)
    table[joints.owner, :, number] = values.T
    return table


def own_joints(batch: Batch) -> np.ndarray:
    """The joint (a row of the table) that moves each link, (L,): the next one above it that is not fixed; -1 for none."""
    links, joints = batch.links(), batch.joints()
    start = np.searchsorted(links.owner, joints.owner)
    parent, child = start + joints.parent, start + joints.child
    found = np.full(len(links.owner), -1, dtype=np.int64)
    stiff = ~joints.that()
    found[child[~stiff]] = np.flatnonzero(~stiff)
    for _ in range(len(batch.program.joints)):  # what is fixed to a link moves as that link does
        before = found[child[stiff]]
        found[child[stiff]] = found[parent[stiff]]
        if np.array_equal(before, found[child[stiff]]):
            break
    return found


@dataclass(frozen=True, slots=True)
class Twist:
    """How points of links move per unit of the next moving joint above: ``turn x p + shift``, (L, 3), 0 at a root.

    Metres per radian of a hinge, per metre of a slide; in the object's frame.
    """

    turn: np.ndarray
    shift: np.ndarray

    def at(self, link: np.ndarray, points: np.ndarray) -> np.ndarray:
        """Velocities (..., 3) of points (..., 3) that lie on the rows ``link`` (...)."""
        turn = self.turn[link]
        x, y, z = (points[..., i] for i in range(3))
        a, b, c = (turn[..., i] for i in range(3))
        return np.stack([b * z - c * y, c * x - a * z, a * y - b * x], axis=-1) + self.shift[link]


def joint_twist(batch: Batch, states: np.ndarray | None = None) -> Twist:
    """The motion by each joint, (J, 3) each, of what it carries, with the joints at ``states`` (J,), at rest by default."""
    links, joints = batch.links(), batch.joints()
    rotation, translation = batch.pose(states)
    parent = np.searchsorted(links.owner, joints.owner) + joints.parent
    axis, slide = (rotate(rotation[parent], way) for way in freedoms_of(joints))  # with the link that carries them
    x, y, z = (rotate(rotation[parent], joints.origin) + translation[parent]).T
    a, b, c = axis.T
    return Twist(axis, np.stack([c * y - b * z, a * z - c * x, b * x - a * y], axis=-1) + slide)  # - axis x origin


def twist(batch: Batch, states: np.ndarray | None = None) -> Twist:
    """The motion of each link by its own joint, with the joints at ``states`` (J,), at rest by default."""
    links, joints = batch.links(), batch.joints()
    start = np.searchsorted(links.owner, joints.owner)
    parent, child = start + joints.parent, start + joints.child
    stiff = np.flatnonzero(~np.any([(way != 0.0).any(axis=1) for way in freedoms_of(joints)], axis=0))
    own = joint_twist(batch, states)
    made = Twist(np.zeros((len(links.owner), 3)), np.zeros((len(links.owner), 3)))
    made.turn[child], made.shift[child] = own.turn, own.shift
    for _ in range(len(batch.program.joints)):  # what is fixed to a link moves as that link does
        before = made.turn[child[stiff]], made.shift[child[stiff]]
        made.turn[child[stiff]], made.shift[child[stiff]] = made.turn[parent[stiff]], made.shift[parent[stiff]]
        after = made.turn[child[stiff]], made.shift[child[stiff]]
        if all(np.array_equal(a, b) for a, b in zip(before, after, strict=True)):
            break
    return made
