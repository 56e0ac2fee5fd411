"""Where an affordance lies on a moving link, and in which direction the link moves there."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from .fields import read_pose, read_triples
from .frames import reflect, rotate
from .points import field_name
from .states import Twist, own_joints

if TYPE_CHECKING:
    from ..runtime.batch import Batch


@dataclass(frozen=True, slots=True)
class Interactions:
    """One row per affordance, target and object, sorted by owner. ``name`` such as ``affordance.pull``, ``link`` (I,)
    a row of the link table, ``joint`` (I,) of the joint table; ``point`` (I, 3): the middle of the target at joint
    values 0, in the object's frame."""

    owner: np.ndarray
    name: list[str]
    link: np.ndarray
    joint: np.ndarray
    point: np.ndarray


def interactions(batch: Batch) -> Interactions:
    """All affordances of a batch that lie on links a joint moves: labels of every vocabulary but ``semantic``."""
    first = np.searchsorted(batch.links().owner, np.arange(len(batch)))
    moving = own_joints(batch)
    names = list(dict.fromkeys(field_name(label) for label in batch.program.labels))
    tables = {table.number: table for table in batch.sites()}
    rows: list[np.ndarray] = [np.zeros((0, 6))]
    for label in batch.program.labels:
        if label.vocabulary in ("semantic", "field"):
            continue
        for target in label.targets:
            table = tables.get(target.site)
            if table is None or not len(table):
                continue
            scope = batch.program.sites[target.site].scope
            rotation, translation, mirror = read_pose(batch, target.frame, scope)
            center = read_triples(batch, [target.center], scope)[0]
            point = rotate(rotation, reflect(center, mirror)) + translation
            link = first[table.owner] + table.link
            word = np.full(len(link), names.index(field_name(label)))
            found = np.column_stack([table.owner, word, link, np.round(point, 9) + 0.0])
            rows.append(found[moving[link] >= 0])
    # the primitives of one target share its middle: one row for all of them
    unique = np.unique(np.concatenate(rows), axis=0)
    owner, word, link = (unique[:, k].astype(np.int64) for k in range(3))
    return Interactions(owner, [names[k] for k in word], link, moving[link], unique[:, 3:])


def directions(motion: Twist, link: np.ndarray, points: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Unit directions (I, 3) in which points move as the joint's value grows, nan on its axis, and speeds (I,)."""
    velocity = motion.at(link, points)
    x, y, z = velocity.T
    speed = np.sqrt(x * x + y * y + z * z)
    still = speed < 1e-9
    return np.where(still, np.nan, 1.0)[:, None] * velocity / np.where(still, 1.0, speed)[:, None], np.where(
        still, 0.0, speed
    )
