"""Where an affordance lies on a moving link, and in which direction the link moves there."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from itertools import pairwise
from typing import TYPE_CHECKING

import numpy as np

from ..geometry.places import spread
from ..geometry.pointset import PointSet
from ..records import dataclass
from ..runtime.fields import read_pose, read_triples
from .frames import reflect, rotate
from .points import field_name, select_holding
from .states import Twist, own_joints

if TYPE_CHECKING:
    from ..graph.program import Label, Target
    from ..runtime.batch import Batch

# on a primitive, about, but one on each patch at least: more where fewer do not show an affordance
_PLACES = (1, 64, 256)
_PATCHES = 16  # of a primitive, about
_TOGETHER = 200_000  # places looked at together, about


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


def find_interactions(batch: Batch) -> Interactions:
    """All affordances of a batch that can be found on links a joint moves: labels of every vocabulary but ``semantic``.

    They are looked for at places on each primitive that such a label names, as ``label_points`` says what holds there.
    """
    first = np.searchsorted(batch.links().owner, np.arange(len(batch)))
    moving = own_joints(batch)
    acting = [label for label in batch.program.labels if label.vocabulary not in ("semantic", "field")]
    names = list(dict.fromkeys(field_name(label) for label in acting))
    rows: list[np.ndarray] = [np.zeros((0, 7))]
    above = _Above(batch)
    for label, target, row in _found_on(batch, acting, moving):
        table = batch.sites()[target.site]
        scope = batch.program.sites[target.site].scope
        rotation, translation, mirror = read_pose(batch, target.frame, scope)
        center = read_triples(batch, [target.center], scope)[0]
        point = (rotate(rotation, reflect(center, mirror)) + translation)[row]
        link = (first[table.owner] + table.link)[row]
        word = np.full(len(link), names.index(field_name(label)))
        joint = above.meant(label, link)
        rows.append(np.column_stack([table.owner[row], word, link, joint, np.round(point, 9) + 0.0]))
    # the primitives of one target share its middle: one row for all of them
    unique, _ = np.unique(np.concatenate(rows), axis=0, return_counts=True)  # without counts it loads numpy.ma
    owner, word, link, joint = (unique[:, k].astype(np.int64) for k in range(4))
    return Interactions(owner, [names[k] for k in word], link, joint, unique[:, 4:])


class _Above:
    """The joints above the links of a batch, and how they move."""

    def __init__(self, batch: Batch):
        joints, links = batch.joints(), batch.links()
        first = np.searchsorted(links.owner, joints.owner)
        self.most = len(batch.program.joints)
        self.joint = np.full(len(links.owner) + 1, -1, dtype=np.int64)  # the last one is above all
        self.joint[first + joints.child] = np.arange(len(joints.owner))
        self.parent = np.append(first + joints.parent, len(links.owner))
        self.moves = np.append(joints.that(), False)
        self.definition = np.append(joints.definition, -1)
        ways = {"along": joints.advance != 0.0, "about": joints.that("turns", "tilts")}
        self.ways = {motion: np.append(way, False) for motion, way in ways.items()}

    def meant(self, label: Label, link: np.ndarray) -> np.ndarray:
        """The joint (a row of the table) that a label on the link rows ``link`` (k,) is for, -1 where nothing moves.

        Of the joints above the link the nearest that the label names; else the nearest of the kind that its word moves by;
        else the nearest of all. Fixed ones do not count.
        """
        named = np.isin(self.definition, label.joints)
        worth = np.where(named, 3, np.where(self.ways.get(label.motion, False), 2, 1)) * self.moves
        rank, found, at = np.zeros(len(link), dtype=np.int64), np.full(len(link), -1), link
        for _ in range(self.most):
            joint = self.joint[at]
            if (joint < 0).all():
                break
            better = worth[joint] > rank
            rank, found = np.where(better, worth[joint], rank), np.where(better, joint, found)
            at = self.parent[joint]
        return found


def acting_joints(batch: Batch, points: PointSet) -> dict[str, np.ndarray]:
    """For each word that acts, the number in its object of the joint that it is for at each point, -1 where it does not
    hold or nothing moves: (P, n) each."""
    acting = [label for label in batch.program.labels if label.vocabulary not in ("semantic", "field")]
    number = np.append(np.asarray(batch.joints().number, dtype=np.int64), -1)
    found = {field_name(label): np.full(points.site.size, -1, dtype=np.int64) for label in acting}
    for label, at, joint in joints_meant(batch, points, acting):
        found[field_name(label)][at] = number[joint]
    return {name: values.reshape(points.site.shape) for name, values in sorted(found.items())}


def joints_meant(
    batch: Batch, points: PointSet, labels: Sequence[Label]
) -> Iterator[tuple[Label, np.ndarray, np.ndarray]]:
    """For each of the labels, target by target, the flat numbers (k,) of the points at which it holds, and the joint that it is for
    at each: a row (k,) of the table, -1 where nothing moves."""
    links, tables = batch.links(), batch.sites()
    first = np.searchsorted(links.owner, np.arange(len(batch)))
    rows = points.row.ravel()
    above = _Above(batch)
    for label, target, at in select_holding(batch, tables, points, labels):
        table, row = tables[target.site], rows[at]
        yield label, at, above.meant(label, first[table.owner[row]] + table.link[row])


def _found_on(batch: Batch, labels: Sequence[Label], moving: np.ndarray) -> Iterator[tuple[Label, Target, np.ndarray]]:
    """For each label and target the rows of the target's site on whose visible surface the label holds.

    Only on links that are ``moving`` (L,), which says so by numbers from 0 on. Labels run from outer to inner ones.
    What one place of each patch does not show is looked for at more, where it may be. Whether a place is seen is asked where a label
    holds alone.
    """
    tables = batch.sites()
    first = np.searchsorted(batch.links().owner, np.arange(len(batch)))
    able = [moving[first[table.owner] + table.link] >= 0 for table in tables]
    possible = {pair: may & able[pair[1].site] for pair, may in find_possible(batch, labels).items()}
    held = {pair: np.zeros(len(may), dtype=bool) for pair, may in possible.items()}
    for most in _PLACES:
        wanted = [np.zeros(len(table), dtype=bool) for table in tables]
        for (label, target), may in possible.items():
            wanted[target.site] |= may & ~held[label, target]
        for begin, stop in _blocks(batch, wanted, most):
            places = spread(tables, wanted, begin, stop, most)
            row = places.points.row.ravel()
            holding = list(select_holding(batch, tables, places.points, labels))
            asked = np.zeros(len(row), dtype=bool)
            for label, target, at in holding:
                asked[at] |= ~held[label, target][row[at]]
            seen = asked.copy()
            seen[asked] = places.seen(np.flatnonzero(asked))
            for label, target, at in holding:
                held[label, target][row[at[seen[at]]]] = True
    for (label, target), found in held.items():
        if found.any():
            yield label, target, np.flatnonzero(found)


def _blocks(batch: Batch, wanted: Sequence[np.ndarray], most: int) -> Iterator[tuple[int, int]]:
    """Ranges of objects with about as many places as are looked at together."""
    rows = np.zeros(len(batch), dtype=np.int64)
    for table, own in zip(batch.sites(), wanted, strict=True):
        rows += np.bincount(table.owner, own, len(batch)).astype(np.int64)
    number = np.cumsum(rows * max(most, _PATCHES)) // _TOGETHER
    for begin, stop in pairwise(np.flatnonzero(np.diff(number, prepend=-1, append=number[-1:] + 1)).tolist()):
        if rows[begin:stop].any():
            yield begin, stop


def find_possible(batch: Batch, labels: Sequence[Label]) -> dict[tuple[Label, Target], np.ndarray]:
    """For each label and target on which rows of the target's site the label may hold, as far as no point is needed to tell:
    not where its condition is false of the whole row, nor where a deeper label of its vocabulary holds all over."""
    tables = batch.sites()
    found: dict[tuple[Label, Target], np.ndarray] = {}
    over: dict[tuple[str, int], list[tuple[int, np.ndarray]]] = {}  # vocabulary, site: depth, where it holds all over
    for label in labels:
        whole = [formula for formula in label.formulas if not formula.reads]
        for target in label.targets:
            values = batch.read(whole, batch.program.sites[target.site].scope)
            may = np.ones(len(tables[target.site]), dtype=bool)
            for value in values:
                may &= value > 0
            found[label, target] = may
            if len(whole) == len(label.formulas) and not target.surfaces:
                over.setdefault((label.vocabulary, target.site), []).append((label.depth, may.copy()))
    for (label, target), may in found.items():
        for depth, where in over.get((label.vocabulary, target.site), ()):
            if depth > label.depth:
                may &= ~where
    return found


def directions_of(motion: Twist, joint: np.ndarray, points: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Unit directions (I, 3) in which points move as the value of the joint rows ``joint`` (I,) grows, nan on its axis,
    and speeds (I,). ``motion`` is that of ``joint_twist``."""
    velocity = motion.at(joint, points)
    x, y, z = velocity.T
    speed = np.sqrt(x * x + y * y + z * z)
    still = speed < 1e-9
    return np.where(still, np.nan, 1.0)[:, None] * velocity / np.where(still, 1.0, speed)[:, None], np.where(
        still, 0.0, speed
    )
