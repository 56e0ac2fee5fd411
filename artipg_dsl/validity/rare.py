"""What makes many of a few objects invalid, each perhaps for a reason of its own: what `check` tells where no one fault is that of all."""

from __future__ import annotations

import numpy as np

from ..geometry.runs import distinct
from ..graph.program import Where
from ..records import dataclass
from .bodies import Pieces
from .contact import contact_in_words, describe_contact
from .fault import Fault
from .floating import Solids
from .loops import find_open
from .stance import find_toppling, name_feet
from .tree import Tree
from .validate import Collisions


@dataclass(frozen=True, slots=True)
class Rare:
    """``many`` objects are invalid; ``count`` of them for what is ``worst``, in words, at ``where`` if that is a statement, else on the
    part with the path ``part``. ``example`` tells of one."""

    many: int
    count: int
    worst: str
    where: Where | None
    part: str
    example: str


def find_rare(solids: Solids, found: Collisions) -> Rare | None:
    """What fails most, if half of the objects or more are invalid; ``found``: what meets in them.

    Whether they stand is asked by bounds of their masses, with all joints at rest: what topples here does for certain.
    """
    tree, body = solids.tree, solids.body
    faults = [fault for fault in (*solids.floating(), *solids.find_unheld(), *find_open(tree)) if len(fault.objects)]
    for statement, objects in zip(tree.batch.program.stable, find_toppling(tree, body), strict=True):
        if len(objects):
            example = name_feet(tree, body, int(objects[0]))
            faults.append(Fault(statement.message, objects, statement.where, example=example))
    invalid = distinct(np.concatenate([found.owner, *(fault.objects for fault in faults)]))
    if 2 * len(invalid) < len(tree.first):
        return None
    rare = [
        Rare(len(invalid), len(one.objects), one.what, one.where, one.part or "", one.example) for one in faults
    ] + _pairs(tree, body, found, len(invalid))
    return max(rare, key=lambda one: one.count)


def _pairs(tree: Tree, body: Pieces, found: Collisions, many: int) -> list[Rare]:
    """The same of the pairs of links that meet, at rest or while a joint moves."""
    start = tree.first[found.owner]
    keys = np.stack([tree.links.definition[start + side] for side in (found.first, found.second)], axis=1)
    pairs = []
    for key in sorted(set(map(tuple, np.sort(keys, axis=1).tolist()))):
        rows = np.flatnonzero((np.sort(keys, axis=1) == key).all(axis=1))
        row = int(rows[np.argmin(found.joint[rows] >= 0)])  # at rest, if in any
        joint = int(found.joint[row])
        if joint >= 0:
            joint = int(tree.joints.definition[int(np.searchsorted(tree.joints.owner, found.owner[row])) + joint])
        contact = describe_contact(tree, body, found, row)
        when = "at rest" if joint < 0 else f"while `{tree.batch.program.joints[joint].path}` moves"
        words = f"`{contact.parts[0]}` and `{contact.parts[1]}` collide {when}"
        if len(set(found.joint[rows] < 0)) > 1:
            words += ", or when joints move"
        example = contact_in_words("" if joint < 0 else tree.batch.program.joints[joint].kind, contact)
        pairs.append(Rare(many, len(distinct(found.owner[rows])), words, None, contact.parts[1], example))
    return pairs
