"""What a program states to no effect: parameters whose value shows nowhere, alternatives nobody takes or nobody could tell, labels
that hold nowhere, or where what is pressed would not move, grasps that no hand makes.

Found by trial: a value is moved within its range, all else kept, and the objects are looked at again; an alternative is
taken on purpose, and compared with the others; a label is looked for at points of what it is on, and its joint moved there.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace

import numpy as np

from ..annotate.grasps import sample_grasps
from ..annotate.gripper import REASONS, STANDARD, judge
from ..annotate.interactions import find_possible, joints_meant, look_at
from ..annotate.points import field_name, select_holding
from ..annotate.states import joint_twist, open_values
from ..graph.expr import TRUE
from ..graph.program import Draw, Label
from ..records import dataclass
from ..runtime.batch import Batch
from ..runtime.kernels import Kept, State
from ..sampling.known import evaluate_again, find_differing, keep_draw, make_batch
from ..sampling.sample import Sampler
from .fingerprint import fingerprint_objects

_FEW = 48  # objects tried at first
_MANY = 400  # objects tried before a parameter is called dead
_LOOKS = ((_FEW, 64), (_MANY, 512))  # objects, and points on each primitive that a label names
_ROWS = 8  # of primitives on which a label may hold, at least, for it to be called dead
_HINDERS = {
    "wide": "it opens wider than the gripper",
    "blocked": "something is in the way of fingers or palm",
    "empty": "nothing is between the fingers",
}
_PRESSES = ("press", "push")  # words of what a fingertip does, along the normal
_ACROSS = 0.45  # the cosine of the widest angle between a normal and a way that it counts as across: 63 degrees
_ACROSS_SHARE = 1 / 3  # of the points of a label, at least, that lie across the way
_ROUND = (0.37, -0.23, 0.61)  # of its range, how far a value is moved, round and round


@dataclass(frozen=True, slots=True)
class Dead:
    """A draw or a label by name and line; ``option`` of a choice; ``why`` in words."""

    name: str
    where: str
    why: str
    option: str = ""


def find_dead_parameters(batch: Batch, progress: Callable[[int, int], None] | None = None) -> list[Dead]:
    """Numbers that are drawn and change nothing that can be observed; ``progress(done, total)`` counts draws."""
    found = []
    for number, draw in enumerate(batch.program.draws):
        if progress is not None:
            progress(number, len(batch.program.draws))
        if draw.kind == "choice" or number in batch.state.given:
            continue
        having = np.unique(batch.owner(draw.column.scope))
        why = _effect(batch, number, having) if len(having) else "is never drawn"
        if why:
            found.append(Dead(draw.column.name, str(draw.where or ""), why))
    return found


def _effect(batch: Batch, number: int, having: np.ndarray) -> str:
    """Why a draw counts as dead; nothing said if it shows somewhere."""
    everything = [keep_draw(batch, k, having[:_MANY]) for k in range(len(batch.program.draws))]
    others = [k for k in range(len(batch.program.draws)) if k != number]
    moved, alone = False, False
    shown = False
    for count in (_FEW, _MANY):
        objects = having[:count]
        if count > _FEW and len(having) <= _FEW:
            break
        values = (
            everything if count == _MANY else [keep_draw(batch, k, objects) for k in range(len(batch.program.draws))]
        )
        before = fingerprint_objects(evaluate_again(batch, objects, values=values))
        for step in _ROUND:
            other = list(values)
            other[number] = _moved(batch.program.draws[number], batch.state.values[number], values[number], step)
            after = evaluate_again(batch, objects, values=other)
            changed = find_differing(batch, objects, after, [number]) & ~after.state.failed
            look = changed & (fingerprint_objects(after) != before)
            still = changed & ~find_differing(batch, objects, after, others)  # nothing else had to give way
            if (look & still).any():
                return ""
            moved, alone, shown = moved or bool(changed.any()), alone or bool(still.any()), shown or bool(look.any())
    if shown and not alone:
        return ""
    return "changes nothing" if moved else "has no room to vary"


def _moved(draw: Draw, drawn: np.ndarray, values: Kept, step: float) -> Kept:
    """The values moved within the range of the draw by a share of it, coming in again at the other end."""
    low, high = float(drawn.min()), float(drawn.max())
    if draw.low is not None and draw.low.constant is not None:
        low = float(draw.low.constant)
    if draw.high is not None and draw.high.constant is not None:
        high = float(draw.high.constant)
    span = high - low + (draw.kind == "count")
    if span <= 0.0:
        return values
    shift = max(1.0, round(abs(step) * span)) if draw.kind == "count" else step * span
    return replace(values, value=low + np.mod(values.value - low + shift, span))


def find_dead_alternatives(
    sampler: Sampler, batch: Batch, progress: Callable[[int, int], None] | None = None
) -> list[Dead]:
    """Alternatives that no object takes or that look exactly like another; ``progress(done, total)`` counts draws."""
    found = []
    for number, draw in enumerate(batch.program.draws):
        if progress is not None:
            progress(number, len(batch.program.draws))
        if draw.kind != "choice" or number in batch.state.given:
            continue
        count = np.bincount(batch.state.values[number].astype(np.int64), minlength=len(draw.options))
        for option in np.flatnonzero(count == 0).tolist():
            found.append(Dead(draw.column.name, str(draw.where or ""), "is never taken", draw.options[option]))
        numbers = batch.numbers[np.unique(batch.owner(draw.column.scope))[:_FEW]]  # of those in which it is drawn
        seen: dict[int, tuple[np.ndarray, np.ndarray]] = {}
        for option in np.flatnonzero(count).tolist():
            look, valid = _taken(sampler, batch, number, option, numbers)
            for other, (second, too) in seen.items():
                both = valid & too
                if both.any() and np.array_equal(look[both], second[both]):
                    why = f"cannot be told from {draw.options[other]}"
                    found.append(Dead(draw.column.name, str(draw.where or ""), why, draw.options[option]))
                    break
            seen[option] = look, valid
    return found


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
        points = look_at(some, [np.full(len(table), count * (table.number in asked)) for table in tables])
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
            objects = len(np.unique(grasps.owner[own]))
            found.append(Dead(name, where, f"is a grasp that no hand makes: {_HINDERS[worst]} ({objects} objects)"))
    return found


def look_across(batch: Batch) -> dict[tuple[tuple[str, str], int], np.ndarray]:
    """For each label of what is pressed or pushed, by name and line, and each joint (of the program) that it is for: at which of the points
    (k,) where it holds the joint moves across the surface."""
    labels = [label for label in batch.program.labels if label.name in _PRESSES and label.vocabulary != "semantic"]
    tables, joints = batch.sites(), batch.joints()
    asked = {target.site for label in labels for target in label.targets}
    points = look_at(batch, [np.full(len(table), _LOOKS[0][1] * (table.number in asked)) for table in tables])
    position, normal = points.position.reshape(-1, 3), points.normal.reshape(-1, 3)
    motion = joint_twist(batch, np.zeros(len(joints.owner)))
    found: dict[tuple[tuple[str, str], int], list[np.ndarray]] = {}
    for label, at, joint in joints_meant(batch, points, labels):
        at, joint = at[joint >= 0], joint[joint >= 0]
        way = motion.at(joint, position[at])
        speed, out = np.sqrt((way * way).sum(axis=1)), np.abs((way * normal[at]).sum(axis=1))
        own = joints.definition[joint]
        for definition in np.unique(own).tolist():
            found.setdefault((_statement(label), definition), []).append((out > _ACROSS * speed)[own == definition])
    return {key: np.concatenate(across) for key, across in found.items()}


def _statement(label: Label) -> tuple[str, str]:
    """What is written once: in each alternative and at each use it is a label of its own."""
    return field_name(label), str(label.where or "")


def _taken(
    sampler: Sampler, batch: Batch, number: int, option: int, numbers: np.ndarray
) -> tuple[np.ndarray, np.ndarray]:
    """The fingerprints of some objects in which a choice is given, and which of them are valid and have the choice."""
    given = {**batch.state.given, number: float(option)}
    state = State(batch.seed, numbers, np.zeros(len(numbers), dtype=np.int64), given)
    taken = make_batch(sampler.program, sampler.plan, state)
    there = np.zeros(len(numbers), dtype=bool)
    there[taken.owner(batch.program.draws[number].column.scope)] = True
    return fingerprint_objects(taken), there & ~state.failed
