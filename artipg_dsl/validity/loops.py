"""Loops of joints that do not close, or that take a joint beyond its range: at rest, or in the states in which a joint drives them."""

from __future__ import annotations

import numpy as np

from .fault import Fault, Key, list_faults
from .tree import Tree


def find_open(tree: Tree) -> list[Fault]:
    """Each ``close`` and each range that does not hold. Of objects in which one does not at rest, nothing is told of other states."""
    loops, joints, program = tree.batch.loops, tree.joints, tree.batch.program
    if loops is None:
        return []
    closing = [("this loop does not close", closure.where) for closure in program.closures]
    ranges = [(f"the loop takes {joint.path} beyond its range", joint.where) for joint in program.joints]
    found: list[tuple[Key, np.ndarray]] = []
    leads, states = tree.following
    rest = np.full(len(tree.first), -1), loops.apart(tree.turn, tree.shift), joints.rest
    moved = zip(leads, *tree.poses(states)[2:], strict=True) if len(leads) else ()
    wrong = np.zeros(len(tree.first), dtype=bool)
    for state, (lead, apart, values) in enumerate((rest, *moved)):
        beyond = loops.beyond(values)
        for owner, which, words in (
            (loops.owner[apart], loops.which[apart], closing),
            (joints.owner[beyond], joints.definition[beyond], ranges),
        ):
            told = ~wrong[owner] & ((state == 0) | (lead[owner] >= 0))
            for kind, joint in sorted(set(zip(which[told].tolist(), lead[owner[told]].tolist(), strict=True))):
                when = "at rest" if joint < 0 else f"while {program.joints[joints.definition[joint]].path} moves"
                here = told & (which == kind) & (lead[owner] == joint)
                what, where = words[kind]
                found.append(((f"{what} {when}", where, None), owner[here]))
        if state == 0:
            wrong[np.concatenate([loops.owner[apart], joints.owner[beyond]])] = True
    return list_faults(found)
