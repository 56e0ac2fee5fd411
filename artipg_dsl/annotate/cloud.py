"""Labelled point clouds: points on the surface of every object of a batch, with all that is known of them."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from typing import TYPE_CHECKING, Protocol

import numpy as np

from .. import random
from ..errors import UserError
from ..geometry import points as geometry
from ..geometry.pointset import PointSet
from ..records import dataclass
from ..runtime.columns import Columns
from ..validity.materials import material_rows
from .frames import rotate, rotate_rows
from .interactions import acting_joints
from .jacobian import find_jacobian
from .points import field_kinds, label_points
from .sampling import Sampling
from .seen import part_coordinates
from .shares import DrawnPoints, draw_points, make_weigher
from .states import twist

if TYPE_CHECKING:
    from ..runtime.batch import Batch


@dataclass(frozen=True, slots=True, repr=False)
class Points(Columns):
    """n points for each of B objects, in the object's frame, metres; or for each of P links, parts, ... of them.

    ``object`` (B,): the index in the batch. ``position``, ``normal`` (B, n, 3); ``semantic``, ``instance`` (part
    number), ``link``, ``material`` (index in the program, -1: none) (B, n). ``npcs`` (B, n, 3): the place in the box of
    the instance, its centre 0 and its diagonal 1. The binding: ``primitive`` (site number), ``element`` (which of the
    object's primitives of that site), ``patch``, ``u``, ``v`` (B, n) patch fractions. ``labels`` such as
    ``affordance.pull``, (B, n) each, fields of vectors (B, n, 3). With K states, ``position``, ``normal``, ``motion`` and
    fields of vectors are (B, K, n, 3): the same points, moved. ``motion`` is the velocity per unit (radian, metre) of
    the point's own joint, None unless asked for; so are ``drivers`` (B, n, D), the numbers of all joints of the object
    that move the point, -1 for no more, and ``velocities`` (B, n, D, 3) or (B, K, n, D, 3) per unit of each of them, what
    mimics it and what closed loops move along included. ``bound`` (B, n) tells of points that were bound again which of them
    still have their primitive and patch; what is not has nan for its place, no label and -1 for semantic, instance,
    link and material. It is None for points that were drawn. ``area`` (B, n): the surface, in square metres, that a point
    stands for, which differs where points are drawn per part or balanced; it is None for points that were bound again. ``acting``, with
    ``motion``: for each word such as ``affordance.lift`` the number (B, n) of the joint that it is for, -1 where it does not
    hold or nothing moves. ``worn`` (B, n): the bound point of the details that each wears, -1 for none; None without details.
    """

    object: np.ndarray
    position: np.ndarray
    normal: np.ndarray
    semantic: np.ndarray
    instance: np.ndarray
    link: np.ndarray
    material: np.ndarray
    npcs: np.ndarray
    primitive: np.ndarray
    element: np.ndarray
    patch: np.ndarray
    u: np.ndarray
    v: np.ndarray
    labels: dict[str, np.ndarray]
    motion: np.ndarray | None = None
    drivers: np.ndarray | None = None
    velocities: np.ndarray | None = None
    bound: np.ndarray | None = None
    area: np.ndarray | None = None
    acting: dict[str, np.ndarray] | None = None
    worn: np.ndarray | None = None


@dataclass(frozen=True, slots=True)
class Surface:
    """Where points are and what they are on, as in ``Points``, without labels."""

    position: np.ndarray
    normal: np.ndarray
    instance: np.ndarray
    link: np.ndarray
    material: np.ndarray


class _Moved(Protocol):
    """Points in details, at joint values 0: where they are instead of on the structure."""

    @property
    def position(self) -> np.ndarray: ...
    @property
    def normal(self) -> np.ndarray: ...
    @property
    def bound(self) -> np.ndarray: ...


Dress = Callable[["Batch", PointSet, np.ndarray], _Moved]


def sample_points(
    batch: Batch,
    how: Sampling | int = 2048,
    states: np.ndarray | None = None,
    *,
    motion: bool = False,
    dress: Dress | None = None,
    vocabulary: str | None = None,
) -> Points:
    """Points uniform by area, exactly as many as asked for, with joints at ``states`` (J,) or (K, J), rest by default.

    Points lie on the surface that is there with all joints at 0, where objects are closed, and move with their links.
    The points of an object are the same in any batch, in the same random order. ``dress`` moves them to where their details are; labels
    are those of the structure. ``vocabulary``: only labels of this one are found, and of motion only that by the own joint, in 0.8 of the
    time. Raises UserError for objects without visible surface,
    UsageError.
    """
    drawn = _draw(batch, how if isinstance(how, Sampling) else Sampling(how))
    if dress is None:
        return replace(complete(batch, drawn.points, drawn.owner, states, motion, None, vocabulary), area=drawn.area)
    moved = dress(batch, drawn.points, drawn.owner)
    shown = replace(drawn.points, position=moved.position, normal=moved.normal)
    found = complete(batch, drawn.points, drawn.owner, states, motion, shown, vocabulary)
    return replace(found, area=drawn.area, worn=moved.bound)


def sample_surface(batch: Batch, how: Sampling, states: np.ndarray | None = None) -> Surface:
    """The points of ``sample_points`` with joints at ``states`` (J,), in a fraction of the time."""
    drawn = _draw(batch, how)
    instance, link, _, material = _held(batch, drawn.points)
    own = np.searchsorted(batch.links().owner, drawn.owner)[:, None] + link
    position, normal, _, _ = _move_points(batch, drawn.points, own, states, False, False)
    return Surface(position, normal, instance, link, material)


def _draw(batch: Batch, how: Sampling) -> DrawnPoints:
    """Points as a sampling wants them. Raises UserError for objects without such surface."""
    address, weigh = np.asarray(batch.numbers).astype(np.uint64), make_weigher(batch, how)
    try:
        return draw_points(batch.sites(), len(batch), how, random.key(batch.seed, "points"), address, weigh)
    except geometry.PointsError as wrong:
        numbers = ", ".join(str(batch.numbers[k]) for k in wrong.objects[:5])
        what = "that can be seen from outside" if how.surface == "outside" else "to put points on"
        raise UserError(
            f"{batch.program.name} {numbers} has no surface {what}", "give it a part with a solid"
        ) from None


def complete(
    batch: Batch,
    made: PointSet,
    owner: np.ndarray,
    states: np.ndarray | None,
    motion: bool,
    shown: PointSet | None = None,
    vocabulary: str | None = None,
) -> Points:
    """All that is known of points (P, n) on objects ``owner`` (P,); ``shown``: where they are instead of there. ``vocabulary`` as in
    ``sample_points``."""
    placed, whole = made if shown is None else shown, vocabulary is None
    wanted = [label for label in batch.program.labels if whole or label.vocabulary == vocabulary]
    labels = label_points(batch, batch.sites(), made, wanted)
    instance, link, rank, made_of = _held(batch, made)
    own = np.searchsorted(batch.links().owner, owner)[:, None] + link
    part = np.searchsorted(batch.parts().owner, owner)[:, None] + instance
    npcs = part_coordinates(batch, part.ravel(), placed.position.reshape(-1, 3)).reshape(*link.shape, 3)
    several = states is not None and np.ndim(states) == 2
    every = np.asarray(states) if several else [states]
    moved = [_move_points(batch, placed, own, one, motion, motion and whole) for one in every]
    drivers = find_jacobian(batch, every[0]).driver[own] if motion and whole else None
    position, normal, velocity, velocities = (
        None if arrays[0] is None else np.stack(arrays, axis=1) if several else arrays[0]
        for arrays in zip(*moved, strict=True)
    )
    assert position is not None and normal is not None
    binding = made.site, rank, made.patch, made.u, made.v
    fields = dict(labels.fields)
    for name in [name for name, kind in field_kinds(wanted).items() if kind == "vectors"]:
        carried = [rotate(batch.pose(one)[0][own], fields[name]).astype(np.float32) for one in every]
        fields[name] = np.stack(carried, axis=1) if several else carried[0]
    classes = labels.semantic, instance, link, made_of
    acting = acting_joints(batch, made) if motion and whole else None
    return Points(
        owner, position, normal, *classes, npcs, *binding, fields, velocity, drivers, velocities, acting=acting
    )


def _held(batch: Batch, made: PointSet) -> tuple[np.ndarray, np.ndarray, np.ndarray, np.ndarray]:
    """Part instance, link, rank of the primitive and material (-1: none) of points (P, n)."""
    tables = batch.sites()
    at = _starts(batch)[made.site] + made.row
    instance, link, rank = (
        np.concatenate([np.empty(0, np.int64), *(getattr(table, name) for table in tables)])[at]
        for name in ("instance", "link", "rank")
    )
    made_of = np.concatenate([np.empty(0, np.int64), *(material_rows(batch, table) for table in tables)])[at] - 1
    return instance, link, rank, made_of


def _starts(batch: Batch) -> np.ndarray:
    """Where the rows of each site begin in the site tables put together."""
    tables = batch.sites()
    starts = np.zeros(len(batch.program.sites), dtype=np.int64)
    starts[[table.number for table in tables]] = np.cumsum([0, *(len(table) for table in tables[:-1])])
    return starts


def _move_points(
    batch: Batch, made: PointSet, link: np.ndarray, states: np.ndarray | None, motion: bool, drivers: bool
) -> tuple[np.ndarray, np.ndarray, np.ndarray | None, np.ndarray | None]:
    """Position and normal (B, n, 3) of points on the link rows ``link`` (B, n); if asked for, their velocity by their own
    joint, and (B, n, D, 3) by each joint that drives them."""
    turn, shift = batch.pose(states)
    row = link.ravel()
    position, normal = (
        rotate_rows(turn, row, vectors.reshape(-1, 3), by).reshape(vectors.shape)
        for vectors, by in ((made.position, shift), (made.normal, None))
    )
    velocity = twist(batch, states).at(link, position) if motion else None
    return position, normal, velocity, find_jacobian(batch, states).at(link, position) if drivers else None
