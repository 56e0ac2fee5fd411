"""The last look at objects before they are handed out: numbers that are none, parts inside out, links that are no tree.

Lowering makes requirements of all this, or shows that it cannot be; a compiled program that anyone may have edited can lack
them, and is asked for its tree, too. What is wrong is an error of the program, told with the object and what it is in it.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from ..errors import UserError
from ..geometry.patches import evaluate_rows
from ..geometry.vectors import cross, dot
from ..runtime.needs import pose_cells

if TYPE_CHECKING:
    from ..geometry.sites import SiteTable
    from ..graph.expr import Expr, Scope
    from ..runtime.batch import Batch

_FAR = 1e6  # metres, radians and what else objects have: beyond all that is meant
_SQUARE = 1e-6  # how far a rotation or an axis may be from one
_SOLID = "give it a part with a solid in every alternative"
_AGAIN = "compile it again from its .apg file"


def prove(batch: Batch) -> None:
    """Raises UserError for the first object that cannot be one."""
    if not batch.program.foreign:  # of one that was read, too, objects without surface are drawn again
        bare = np.ones(len(batch), dtype=bool)
        for table in batch.sites():
            bare[table.owner] = False
        if bare.any():
            raise UserError(f"{batch.program.name} {batch.numbers[bare][0]}: none of its parts has a surface", _SOLID)
    for table in batch.sites():
        if len(table.owner):
            _site(batch, table)
    links, joints, parts = batch.links(), batch.joints(), batch.parts()
    _numbers(batch, "link", links.owner, links.name, links.rotation, links.translation)
    _numbers(batch, "part", parts.owner, parts.name, parts.rotation, parts.translation, parts.low, parts.high)
    _turned(batch, "link", links.owner, links.name, links.rotation)
    _turned(batch, "part", parts.owner, parts.name, parts.rotation)
    _numbers(
        batch,
        "joint",
        joints.owner,
        joints.name,
        joints.origin,
        joints.axis,
        joints.rest,
        joints.multiplier,
        joints.offset,
    )
    long = np.abs(np.sqrt((joints.axis**2).sum(axis=1)) - 1.0) <= _SQUARE
    _refuse(batch, "joint", joints.owner, joints.name, ~long, "its axis is not a unit vector")
    low, high = joints.low, joints.high  # nan: no limit
    _refuse(
        batch,
        "joint",
        joints.owner,
        joints.name,
        (low > high) | (np.abs(low) > _FAR) | (np.abs(high) > _FAR),
        "its range is empty or infinite",
    )
    physics = np.stack([joints.damping, joints.friction, joints.stiffness, joints.effort, joints.velocity])
    _refuse(
        batch,
        "joint",
        joints.owner,
        joints.name,
        ((physics < 0) | np.isinf(physics)).any(axis=0),
        "its damping, friction, stiffness, effort or velocity is negative or infinite",
    )
    few = (joints.positions < 2.0) | (joints.positions != np.rint(joints.positions)) & ~np.isnan(joints.positions)
    _refuse(batch, "joint", joints.owner, joints.name, few, "the number of its positions is not a whole number above 1")
    if batch.program.foreign:
        _tree(batch)
        _said(batch)


def _site(batch: Batch, table: SiteTable) -> None:
    names = [table.path] * len(table.owner)
    _numbers(batch, "primitive", table.owner, names, table.rotation, table.translation, *table.params.values())
    _turned(batch, "primitive", table.owner, names, table.rotation)
    flat: np.ndarray = np.abs(table.mirror) != 1.0
    _refuse(batch, "primitive", table.owner, names, flat, "its mirror factor is neither 1 nor -1")
    if table.primitive.requires:
        holds = evaluate_rows(table.primitive, table.primitive.requires, table.params, bool).all(axis=0)
        _refuse(
            batch,
            "primitive",
            table.owner,
            names,
            np.logical_not(holds),
            "its parameters break a requirement of its primitive",
        )


def _numbers(batch: Batch, what: str, owner: np.ndarray, names: list[str], *columns: np.ndarray) -> None:
    wrong = np.zeros(len(owner), dtype=bool)
    for column in columns:
        wrong |= ~(np.abs(column) <= _FAR).all(axis=tuple(range(1, column.ndim)))
    _refuse(batch, what, owner, names, wrong, "it has a number that is not finite or far too large")


def _turned(batch: Batch, what: str, owner: np.ndarray, names: list[str], rotation: np.ndarray) -> None:
    a, b, c = rotation[:, 0], rotation[:, 1], rotation[:, 2]
    wrong = dot(cross(a, b), c) < 0
    for one, two, product in ((a, a, 1.0), (b, b, 1.0), (c, c, 1.0), (a, b, 0.0), (b, c, 0.0), (c, a, 0.0)):
        wrong |= np.abs(dot(one, two) - product) > _SQUARE
    _refuse(batch, what, owner, names, wrong, "its rotation matrix is not a rotation")


def _said(batch: Batch) -> None:
    """Keypoints, and the frames of what labels are on."""
    program = batch.program
    places: dict[tuple[str, Scope, tuple[Expr, ...]], str] = {
        (point.name, point.scope, point.point): "keypoint" for point in program.keypoints
    }
    for label in program.labels:
        for target in label.targets:
            cells = (*pose_cells(target.frame), *target.size, *target.center)
            places[label.name, program.sites[target.site].scope, cells] = "label"
    for (name, scope, cells), what in places.items():
        owner = batch.owner(scope)
        _numbers(batch, what, owner, [name] * len(owner), np.stack(batch.read(list(cells), scope), axis=-1))


def _tree(batch: Batch) -> None:
    links, joints = batch.links(), batch.joints()
    first = np.searchsorted(links.owner, joints.owner)
    child, parent = first + joints.child, first + joints.parent
    twice = np.bincount(child, minlength=len(links.owner))[child] > 1
    _refuse(batch, "joint", joints.owner, joints.name, twice, "the link that it moves is also moved by another joint")
    above = np.full(len(links.owner), -1)
    above[child] = parent
    at = np.arange(len(above))
    for _ in range(int(links.number.max(initial=0)) + 1):
        at = np.where(at >= 0, above[np.maximum(at, 0)], -1)
    _refuse(batch, "link", links.owner, links.name, at >= 0, "it is attached to itself: the links form a ring")
    loose = (above < 0) & (links.number > 0)
    _refuse(batch, "link", links.owner, links.name, loose, "no joint attaches it to the others")


def _refuse(batch: Batch, what: str, owner: np.ndarray, names: list[str], wrong: np.ndarray, words: str) -> None:
    rows = np.flatnonzero(wrong)
    if len(rows):
        number = int(batch.numbers[owner[rows[0]]])
        raise UserError(f"{batch.program.name} {number}: {what} {names[rows[0]]}: {words}", _AGAIN)
