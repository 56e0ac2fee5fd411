"""Where an affordance lies on a moving link, and in which direction the link moves there."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from typing import TYPE_CHECKING

import numpy as np

from .. import random
from ..geometry import points as geometry
from ..geometry.pointset import PointSet, Pools
from ..records import dataclass
from ..runtime.fields import read_pose, read_triples
from ..validity.formulas import is_predicate
from .frames import reflect, rotate
from .points import field_name, select_holding
from .states import Twist, own_joints

if TYPE_CHECKING:
    from ..graph.program import Label, Target
    from ..runtime.batch import Batch

_FEW, _MANY = 64, 512  # points on each primitive that an affordance may lie on
_GLANCE = 8  # where it lies on all of a primitive or nowhere: so many of one round show that there is surface to see


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

    They are looked for at points on each primitive that such a label names, as ``label_points`` says what holds there.
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
    What few points do not show is looked for at many, where it may be; what holds on all of a row at a glance first.
    """
    tables = batch.sites()
    first = np.searchsorted(batch.links().owner, np.arange(len(batch)))
    possible = find_possible(batch, labels)
    held = {pair: np.zeros(len(may), dtype=bool) for pair, may in possible.items()}
    wanted, mixed = ([np.zeros(len(table), dtype=bool) for table in tables] for _ in range(2))
    for (label, target), may in possible.items():
        wanted[target.site] |= may
        if target.surfaces or not is_predicate(label) or any(formula.reads for formula in label.formulas):
            mixed[target.site] |= may  # it may hold at some points alone
    for table, mine in zip(tables, wanted, strict=True):
        mine &= moving[first[table.owner] + table.link] >= 0
    for few, many in ((_GLANCE, _FEW), (_FEW, _MANY)):
        counts = [mine * np.where(own, many, few) for mine, own in zip(wanted, mixed, strict=True)]
        points = look_at(batch, counts)
        for label, target, at in select_holding(batch, tables, points, labels):
            held[label, target][points.row.ravel()[at]] = True
        missed = [np.zeros(len(table), dtype=bool) for table in tables]
        for (label, target), found in held.items():
            missed[target.site] |= possible[label, target] & ~found
        shown = [~own for own in mixed]
        for table, seen in zip(tables, shown, strict=True):
            seen[points.row[:, 0][points.site[:, 0] == table.number]] = True
        wanted = [a & b & c for a, b, c in zip(wanted, missed, shown, strict=True)]
    for (label, target), found in held.items():
        if found.any():
            yield label, target, np.flatnonzero(found)


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


def look_at(batch: Batch, counts: Sequence[np.ndarray]) -> PointSet:
    """Points on rows of the sites, ``counts`` (k,) of each, as far as they show any surface: (P, n), a primitive each. Those of few points come
    first; where there is none, the site is -1. Rows of ``_GLANCE`` points are looked at once."""
    tables = batch.sites()
    pools = [
        np.where(count > 0, np.int64(table.number + 1) << 32 | table.rank, 0)
        for table, count in zip(tables, counts, strict=True)
    ]
    address = np.asarray(batch.numbers).astype(np.uint64)
    if not any(pool.any() for pool in pools):
        return PointSet.empty(0, _FEW)
    own = Pools.of(tables, pools, len(batch))
    many = np.zeros(len(own.owner), dtype=np.int64)
    for count, row in zip(counts, own.rows, strict=True):
        many[row] = count
    points, full, _ = geometry.sample_counts(
        tables, own, many, random.key(batch.seed, "interactions"), address, once=many == _GLANCE
    )
    points.site[np.arange(points.site.shape[1]) >= np.where(full, many, 0)[:, None]] = -1
    return points


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
