"""What a program states to no effect: parameters whose value shows nowhere, alternatives nobody takes or nobody could tell, labels
that hold nowhere, or where what is pressed would not move, grasps that no hand makes.

Found by trial: a value is moved within its range, all else kept, and the objects are looked at again; an alternative is
taken on purpose, and compared with the others; a label is looked for at points of what it is on, and its joint moved there.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import replace
from itertools import combinations

import numpy as np

from .. import random
from ..annotate.grasps import sample_grasps
from ..annotate.gripper import REASONS, STANDARD, judge
from ..annotate.interactions import find_possible, joints_meant
from ..annotate.points import field_name, select_holding
from ..annotate.states import joint_twist, open_values
from ..geometry.points import sample_counts
from ..geometry.pointset import PointSet, Pools
from ..geometry.runs import distinct
from ..graph.expr import TRUE
from ..graph.program import Draw, Label
from ..records import dataclass
from ..runtime.batch import Batch
from ..runtime.kernels import Kept
from ..sampling.known import evaluate_again, find_differing, keep_draw, owners_kept
from ..sampling.sample import Sampler
from .asking import Question, ask
from .fingerprint import fingerprint_objects

_FEW = 48  # objects tried at first
_MANY = 400  # objects tried before a parameter is called dead
_MORE = 2048  # objects among which what is rare is looked for
_TOGETHER = 1024  # objects evaluated at once
_LOOKS = ((_FEW, 64), (_MANY, 512))  # objects, and points on each primitive that a label names
_ROWS = 8  # of primitives on which a label may hold, at least, for it to be called dead
_HINDERS = {
    "wide": "it opens wider than the gripper",
    "blocked": "something is in the way of fingers or palm",
    "empty": "nothing is between the fingers",
}
_PRESSES = ("press", "push")  # words of what a fingertip does, along the normal
_ACROSS = 0.45  # the cosine of the widest angle between a normal and a way that it counts as across: 63 degrees
_GIVES = 0.1  # of the points that are pressed, at least, that give way
_ACROSS_SHARE = 1 / 3  # of the points of a label, at least, that lie across the way
_ROUND = (0.37, -0.23, 0.61)  # of its range, how far a value is moved, round and round


@dataclass(frozen=True, slots=True)
class Dead:
    """A draw or a label by name and line; ``option`` of a choice; ``why`` in words."""

    name: str
    where: str
    why: str
    option: str = ""


def find_dead_parameters(
    batch: Batch, further: Callable[[], Batch], progress: Callable[[int, int], None] | None = None
) -> list[Dead]:
    """Numbers that are drawn and change nothing that can be observed; ``progress(done, total)`` counts draws.

    What few of the objects have is looked for among ``further`` ones as well.
    """
    draws = batch.program.draws
    tried = [k for k, draw in enumerate(draws) if draw.kind != "choice" and k not in batch.state.given]
    told = {number: _Told() for number in tried}
    having = _having(batch, tried)
    _try(batch, having, told, progress)
    rare = [number for number in tried if not told[number].alive and len(having[number]) < _FEW]
    if rare:
        others = further()
        _try(others, _having(others, rare), told, progress)
    found = []
    for number in tried:
        why = told[number].why()
        if why:
            found.append(Dead(draws[number].column.name, str(draws[number].where or ""), why))
    return found


def draw_further(sampler: Sampler, batch: Batch) -> Batch:
    """First attempts at ``_MORE`` objects beside those of the batch."""
    numbers = np.uint64(batch.numbers.max()) + np.arange(1, _MORE + 1, dtype=np.uint64)
    (answers,) = ask(sampler.program, sampler.plan, batch.seed, batch.state.given, [Question({}, numbers)], _MORE)
    return answers.batch


def _having(batch: Batch, draws: Sequence[int]) -> dict[int, np.ndarray]:
    """The objects that have each of some draws, and are as they are asked to be."""
    good = ~batch.state.failed
    owners = {number: distinct(batch.owner(batch.program.draws[number].column.scope)) for number in draws}
    return {number: own[good[own]] for number, own in owners.items()}


def _try(
    batch: Batch,
    having: Mapping[int, np.ndarray],
    told: Mapping[int, _Told],
    progress: Callable[[int, int], None] | None,
) -> None:
    """Move each draw in objects that have it until one of them shows it."""
    for number, objects in having.items():
        told[number].drawn = told[number].drawn or len(objects) > 0
    for most in (_FEW, _MANY):
        left = {n: own[:most] for n, own in having.items() if len(own) > (0 if most == _FEW else _FEW)}
        left = {number: objects for number, objects in left.items() if not told[number].alive}
        there = distinct(np.concatenate([np.zeros(0, dtype=np.int64), *left.values()]))
        before = np.zeros(len(batch), dtype=np.uint64)
        if len(there):
            before[there] = fingerprint_objects(evaluate_again(batch, there))
        for step in _ROUND:
            left = {number: objects for number, objects in left.items() if not told[number].alive}
            done = len(told) - len(left)
            for group in _in_groups(left):
                if progress is not None:
                    progress(done, len(told))
                _move(batch, group, step, before, told)
                done += len(group)


@dataclass(slots=True)
class _Told:
    """What objects told in which a draw was moved: whether there were any, whether it changed, changed ``alone``, whether they ``look``
    otherwise; and whether one did so where nothing else had to give way."""

    drawn: bool = False
    moved: bool = False
    alone: bool = False
    look: bool = False
    alive: bool = False

    def why(self) -> str:
        """Why the draw counts as dead; nothing said if it shows somewhere."""
        if not self.drawn:
            return "is never drawn"
        if self.alive or (self.look and not self.alone):
            return ""
        return "changes nothing" if self.moved else "has no room to vary"


def _in_groups(objects: Mapping[int, np.ndarray]) -> Iterator[dict[int, np.ndarray]]:
    """The draws, about as many at a time as have ``_TOGETHER`` objects."""
    group: dict[int, np.ndarray] = {}
    for number, own in objects.items():
        group[number] = own
        if sum(map(len, group.values())) >= _TOGETHER:
            yield group
            group = {}
    if group:
        yield group


def _move(
    batch: Batch, group: Mapping[int, np.ndarray], step: float, before: np.ndarray, told: Mapping[int, _Told]
) -> None:
    """Move each draw of a group in its own objects (places in the batch), all of them evaluated together. ``before``: the fingerprints
    of the objects of the batch."""
    draws = batch.program.draws
    objects = np.concatenate(list(group.values()))
    mover = np.repeat(list(group), [len(own) for own in group.values()])
    values = [keep_draw(batch, k, objects) for k in range(len(draws))]
    for number in group:
        own = mover[owners_kept(batch, number, objects)] == number
        values[number] = _moved(draws[number], batch.state.values[number], values[number], np.where(own, step, 0.0))
    after = evaluate_again(batch, objects, values=values)
    differs = np.stack([find_differing(batch, objects, after, [k]) for k in range(len(draws))])
    seen = fingerprint_objects(after) != before[objects]
    for number in group:
        own = mover == number
        changed = differs[number, own] & ~after.state.failed[own]
        still = changed & (differs[:, own].sum(axis=0) == 1)  # nothing else had to give way
        look, about = changed & seen[own], told[number]
        about.moved, about.alone = about.moved or bool(changed.any()), about.alone or bool(still.any())
        about.look, about.alive = about.look or bool(look.any()), about.alive or bool((look & still).any())


def _moved(draw: Draw, drawn: np.ndarray, values: Kept, step: np.ndarray) -> Kept:
    """The values moved within the range of the draw by a share of it each, coming in again at the other end; by none, they stay."""
    low, high = float(drawn.min()), float(drawn.max())
    if draw.low is not None and draw.low.constant is not None:
        low = float(draw.low.constant)
    if draw.high is not None and draw.high.constant is not None:
        high = float(draw.high.constant)
    span = high - low + (draw.kind == "count")
    if span <= 0.0:
        return values
    shift = np.maximum(1.0, np.round(np.abs(step) * span)) if draw.kind == "count" else step * span
    moved = low + np.mod(values.value - low + shift, span)
    return replace(values, value=np.where(step == 0.0, values.value, moved))


def find_dead_alternatives(
    sampler: Sampler, batch: Batch, further: Callable[[], Batch], progress: Callable[[int, int], None] | None = None
) -> list[Dead]:
    """Alternatives that no object takes, nor one of the ``further`` ones, or that look exactly like another; ``progress(done, total)``
    counts options."""
    chosen = [k for k, d in enumerate(batch.program.draws) if d.kind == "choice" and k not in batch.state.given]
    count = {k: _taken(batch, k) for k in chosen}
    if rare := [k for k in chosen if not count[k].all()]:
        others = further()
        for k in rare:
            count[k] += _taken(others, k)
    taken = [(number, option) for number in chosen for option in np.flatnonzero(count[number]).tolist()]
    looks = dict(zip(taken, _take(sampler, batch, taken, progress or (lambda done, total: None)), strict=True))
    found = []
    for number in chosen:
        draw = batch.program.draws[number]
        told = {option: "is never taken" for option in np.flatnonzero(count[number] == 0).tolist()}
        seen = {option: look for (of, option), look in looks.items() if of == number}
        for (other, (first, valid)), (option, (second, too)) in combinations(seen.items(), 2):
            both = valid & too
            if both.any() and np.array_equal(first[both], second[both]):
                told.setdefault(option, f"cannot be told from {draw.options[other]}")
        found += [Dead(draw.column.name, str(draw.where or ""), why, draw.options[k]) for k, why in told.items()]
    return found


def _taken(batch: Batch, number: int) -> np.ndarray:
    """How often each option of a choice is taken by objects that are as they are asked to be."""
    draw = batch.program.draws[number]
    good = ~batch.state.failed[batch.owner(draw.column.scope)]
    return np.bincount(batch.state.values[number][good].astype(np.int64), minlength=len(draw.options))


def find_dead_labels(batch: Batch) -> list[Dead]:
    """Labels of words that hold at no visible point of any object, or only where a deeper one of their vocabulary does. Not those that name a
    whole part, which is called so whatever deeper words its points have."""
    labels = [label for label in batch.program.labels if label.vocabulary != "field"]
    left = {_statement(label) for label in labels if label.vocabulary != "semantic" or label.value is not TRUE}
    for objects, count in _LOOKS:
        if not left:
            return []
        some = evaluate_again(batch, np.arange(min(objects, len(batch))))
        tables = some.sites()
        asked = {target.site for label in labels if _statement(label) in left for target in label.targets}
        points = _points_on(some, asked, count)
        left -= {_statement(label) for label, _, _ in select_holding(some, tables, points, labels)}
    rows = dict.fromkeys(left, 0)
    for (label, _), may in find_possible(some, [label for label in labels if _statement(label) in left]).items():
        rows[_statement(label)] += int(may.sum())
    return [Dead(name, where, "holds nowhere") for name, where in sorted(left) if rows[name, where] >= _ROWS]


def find_idle_labels(batch: Batch) -> list[Dead]:
    """Labels of what is pressed or pushed that hold, for the most part, where the joint that they are for moves along the surface: as on the
    sides of a key, which a fingertip slides off. Not those of links that nothing moves."""
    some = evaluate_again(batch, np.arange(min(_FEW, len(batch))))
    return [
        Dead(name, where, f"holds where `{some.program.joints[joint].path}` moves along the surface")
        for ((name, where), joint), across in sorted(look_across(some).items())
        if across.mean() < _ACROSS_SHARE
    ]


def find_dead_grasps(batch: Batch) -> list[Dead]:
    """Grasps that the gripper they are meant for can make in none of some objects, neither at rest nor with all joints open."""
    some = evaluate_again(batch, np.arange(min(_FEW, len(batch))))
    grasps = sample_grasps(some)
    rest = judge(some, grasps, STANDARD)
    made = (rest == 0) | (judge(some, grasps, STANDARD, open_values(some)) == 0)
    stated: dict[tuple[str, str], list[int]] = {}
    for number, grasp in enumerate(some.program.grasps):
        stated.setdefault((grasp.name, str(grasp.where or "")), []).append(number)
    found = []
    for (name, where), families in sorted(stated.items()):
        own = np.isin(grasps.family, families)
        if own.any() and not made[own].any():
            worst = REASONS[int(np.bincount(rest[own]).argmax())]
            objects = len(distinct(grasps.owner[own]))
            found.append(Dead(name, where, f"is a grasp that no hand makes: {_HINDERS[worst]} ({objects} objects)"))
    return found


def look_across(batch: Batch) -> dict[tuple[tuple[str, str], int], np.ndarray]:
    """For each label of what is pressed or pushed, by name and line, and each joint (of the program) that it is for: at which of the points
    (k,) where it holds the joint moves across the surface."""
    labels = [label for label in batch.program.labels if label.name in _PRESSES and label.vocabulary != "semantic"]
    joints = batch.joints()
    found: dict[tuple[tuple[str, str], int], list[np.ndarray]] = {}
    for label, joint, out, speed in _moved_out(batch, labels):
        own = joints.definition[joint]
        for definition in distinct(own).tolist():
            across = np.abs(out) > _ACROSS * speed
            found.setdefault((_statement(label), definition), []).append(across[own == definition])
    return {key: np.concatenate(across) for key, across in found.items()}


def find_lifting(batch: Batch, labels: Sequence[Label]) -> Iterator[tuple[Label, int]]:
    """Which of some labels of what is pressed hold where the joint that they are for, a definition, moves out of the surface alone, or
    not at all, from rest: no press moves it."""
    joints = batch.joints()
    open_up, open_down = ~(joints.high <= joints.rest), ~(joints.low >= joints.rest)  # what has no ends goes on
    gives: dict[tuple[tuple[str, str], int], list[np.ndarray]] = {}
    known: dict[tuple[tuple[str, str], int], Label] = {}
    for label, joint, out, speed in _moved_out(batch, labels):
        free = np.where(out < 0.0, open_up[joint], open_down[joint])
        across, own = np.abs(out) > _ACROSS * speed, joints.definition[joint]
        for definition in distinct(own[across]).tolist():
            key = _statement(label), definition
            gives.setdefault(key, []).append(free[across & (own == definition)])
            known.setdefault(key, label)
    for key, each in gives.items():
        if np.concatenate(each).mean() < _GIVES:
            yield known[key], key[1]


def _moved_out(batch: Batch, labels: Sequence[Label]) -> Iterator[tuple[Label, np.ndarray, np.ndarray, np.ndarray]]:
    """For each target of some labels: the joint (k,) that the label is for at each point where it holds, a row of the table, and how fast
    that moves the point, out of the surface (k,) and whatever way (k,), metres by radian or metre."""
    points = _points_on(batch, {target.site for label in labels for target in label.targets}, _LOOKS[0][1])
    position, normal = points.position.reshape(-1, 3), points.normal.reshape(-1, 3)
    motion = joint_twist(batch, np.zeros(len(batch.joints().owner)))
    for label, at, joint in joints_meant(batch, points, labels):
        at, joint = at[joint >= 0], joint[joint >= 0]
        way = motion.at(joint, position[at])
        yield label, joint, (way * normal[at]).sum(axis=1), np.sqrt((way * way).sum(axis=1))


def _points_on(batch: Batch, sites: set[int], count: int) -> PointSet:
    """``count`` points on each primitive of the sites that has so much surface to show: (P, count)."""
    tables = batch.sites()
    pools = [np.where(table.number in sites, np.int64(table.number + 1) << 32 | table.rank, 0) for table in tables]
    own = Pools.of(tables, pools, len(batch))
    address, key = np.asarray(batch.numbers).astype(np.uint64), random.key(batch.seed, "interactions")
    points, full, _ = sample_counts(tables, own, np.where(own.label > 0, count, 0), key, address)
    return points.take(np.flatnonzero(full & (own.label > 0)))


def _statement(label: Label) -> tuple[str, str]:
    """What is written once: in each alternative and at each use it is a label of its own."""
    return field_name(label), str(label.where or "")


def _take(
    sampler: Sampler, batch: Batch, taken: Sequence[tuple[int, int]], progress: Callable[[int, int], None]
) -> Iterator[tuple[np.ndarray, np.ndarray]]:
    """For each choice and an option of it that it is given: the fingerprints of some objects, and which of them are valid and have the
    choice."""
    scopes = {number: batch.program.draws[number].column.scope for number, _ in taken}
    numbers = {k: batch.numbers[distinct(batch.owner(scope))[:_FEW]] for k, scope in scopes.items()}
    questions = [Question({number: float(option)}, numbers[number]) for number, option in taken]
    for answers in ask(sampler.program, sampler.plan, batch.seed, batch.state.given, questions, _TOGETHER):
        progress(answers.first, len(taken))
        looks = fingerprint_objects(answers.batch)
        for (number, _), objects in zip(taken[answers.first :], answers.objects(), strict=False):
            there = ~answers.batch.state.failed
            there &= np.bincount(answers.batch.owner(scopes[number]), minlength=len(looks)) > 0
            yield looks[objects], there[objects]
