"""Loops of joints that do not close, or that take a joint beyond its range: at rest, or in the states in which a joint drives them."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from ..runtime.loops import APART
from .contact import value_in_words
from .fault import Fault, Key, list_faults
from .tree import Tree


def find_open(tree: Tree) -> list[Fault]:
    """Each ``close`` and each range that does not hold. Of objects in which one does not at rest, nothing is told of other states.

    The example of a range is the state in which a joint goes farthest beyond it, that of a ``close`` the one nearest to rest.
    """
    loops, joints, program = tree.batch.loops, tree.joints, tree.batch.program
    if loops is None:
        return []
    closing = [("this loop does not close", closure.where) for closure in program.closures]
    ranges = [(f"the loop takes {joint.path} beyond its range", joint.where) for joint in program.joints]
    found: list[tuple[Key, np.ndarray]] = []
    worst: dict[Key, tuple[float, str]] = {}
    leads, states = tree.following
    rest = np.full(len(tree.first), -1), loops.apart(tree.turn, tree.shift), joints.rest
    lost = [loops.owner[rest[1]], joints.owner[loops.beyond(joints.rest)]]
    hopeless = np.isin(loops.owner, np.concatenate(lost)).all()  # nothing is told of how these move
    moved = zip(leads, *tree.poses(states)[2:], strict=True) if len(leads) and not hopeless else ()
    wrong = np.zeros(len(tree.first), dtype=bool)
    for state, (lead, apart, values) in enumerate((rest, *moved)):
        beyond = loops.beyond(values)
        shut = ~np.isin(joints.owner[beyond], loops.owner[apart])  # values of an open loop say nothing
        excess = loops.excess(beyond, values)
        excess = np.where(shut & (excess < np.pi), excess, -excess)  # nor those of one that has turned over
        near = -np.abs(values - joints.rest)[lead[loops.owner[apart]]]
        gaps = np.linalg.norm(loops.point[0] - loops.point[1], axis=1)[apart]
        for owner, which, words, much, rows, gap in (
            (loops.owner[apart], loops.which[apart], closing, near, np.full(len(apart), -1), gaps),
            (joints.owner[beyond], joints.definition[beyond], ranges, excess, beyond, np.full(len(beyond), np.nan)),
        ):
            told = ~wrong[owner] & ((state == 0) | (lead[owner] >= 0))
            for kind, joint in sorted(set(zip(which[told].tolist(), lead[owner[told]].tolist(), strict=True))):
                when = "at rest" if joint < 0 else f"while {program.joints[joints.definition[joint]].path} moves"
                here = told & (which == kind) & (lead[owner] == joint)
                what, where = words[kind]
                key = f"{what} {when}", where, None
                found.append((key, owner[here]))
                most = int(np.flatnonzero(here)[np.argmax(much[here])])
                if key not in worst or much[most] > worst[key][0]:
                    told_gap = gap[most] if joint < 0 else np.nan
                    example = _example(tree, values, int(rows[most]), joint, int(owner[most]), float(told_gap))
                    worst[key] = float(much[most]), example
        if state == 0:
            wrong[np.concatenate([loops.owner[apart], joints.owner[beyond]])] = True
    return [replace(f, example=worst[f.what, f.where, f.part][1]) for f in list_faults(found)]


def _example(tree: Tree, values: np.ndarray, joint: int, lead: int, owner: int, gap: float) -> str:
    """Where a joint of an object is, and what leads it, in words; -1 for neither. ``gap``: of what is to close, with all joints
    at 0 (the search may end anywhere); NaN where it says nothing."""
    joints = tree.joints
    at = [
        f"`{joints.name[row]}` {be}{value_in_words(joints.kind[row], values[row])}"
        for row, be in ((joint, "at "), (lead, "at " if joint < 0 else "is at "))
        if row >= 0
    ]
    at += [f"{gap * 1000:.1f} mm apart with all joints at 0"] * (gap > APART)
    return ", ".join([" where ".join(at)] * bool(at) + [f"in object {tree.batch.numbers[owner]}"])
