"""How near two pieces come within an interval of each of their joints: the plane between them, and how far corners can run towards it."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from ..geometry.collide import MOST_STEPS, separate
from ..geometry.vectors import dot
from ..native import cells as native
from ..native.backend import machine as compiled
from ..records import dataclass
from ..runtime.motion import apply, multiply, rotation_about
from .bodies import EXACT, Pieces, Placed, swept_extent
from .tree import Tree

if TYPE_CHECKING:
    from .together import Cells, Ways

_EIGHTH = np.pi / 4
_OWN = np.eye(3)


@dataclass(slots=True, eq=False)
class _Posed:
    """Turns (k, 3, 3) and shifts (k, 3) from rest, and the axes and points on them of joints (k, C, 3) there."""

    turn: np.ndarray
    shift: np.ndarray
    axis: np.ndarray
    origin: np.ndarray


def _posed(tree: Tree, joint: np.ndarray, value: np.ndarray) -> _Posed:
    """What joints (k, c), from the innermost to the outermost, do at values (k, c)."""
    known = np.maximum(joint, 0)
    found = _Posed(
        np.tile(_OWN, (len(joint), 1, 1)), np.zeros((len(joint), 3)), tree.axis[known].copy(), tree.origin[known].copy()
    )
    for column in range(joint.shape[1]):
        rows = np.flatnonzero(joint[:, column] >= 0)
        at, by = joint[rows, column], value[rows, column]
        own = rotation_about(tree.axis[at], np.where(tree.turns[at], by, 0.0))
        shift = tree.origin[at] - apply(own, tree.origin[at])
        shift = shift + tree.axis[at] * (np.where(tree.slides[at], 1.0, tree.advance[at]) * by)[:, None]
        found.turn[rows] = multiply(own, found.turn[rows])
        found.shift[rows] = apply(own, found.shift[rows]) + shift
        for inner in range(column):
            found.axis[rows, inner] = apply(own, found.axis[rows, inner])
            found.origin[rows, inner] = apply(own, found.origin[rows, inner]) + shift
    return found


def examine_cells(
    tree: Tree, body: Pieces, way: Ways, part: Cells
) -> tuple[np.ndarray, np.ndarray, np.ndarray, np.ndarray]:
    """Of cells: which meet in the middle (k,), which are proved to stay apart, how far each joint alone takes the pieces
    towards one another (k, C), and all of them together at most (k,)."""
    joint, half = way.joint[part.row], way.joint.shape[1] // 2
    middle, wide = (part.start + part.stop) / 2, (part.stop - part.start) / 2
    gap = body.apart(part.piece, part.other)
    near, machine, known = 0.5 if gap is None else EXACT, compiled(), None
    if machine is not None:
        first, second = (Placed(body, piece).side() for piece in (part.piece, part.other))
        given = native.Intervals(joint, middle, wide, part.radius, part.piece, part.other, body.low, body.high)
        known = native.examine(machine, first, second, _axes(tree), given, near, MOST_STEPS)
    seen = known or _seen(tree, body, part, joint, middle, wide, near)
    hit, bounds = seen.hit, seen.bounds
    need = seen.between if gap is None else seen.between - gap
    for number, (piece, to, ahead) in enumerate(
        ((part.piece, slice(0, half), -seen.away), (part.other, slice(half, 2 * half), seen.away))
    ):
        at = np.flatnonzero(seen.many[number] & ~hit & (need < bounds[0] + bounds[1] + part.slack))
        if len(at):  # these more exactly
            far = _cloud(tree, body, piece[at], joint[at, to], middle[at, to], wide[at, to], ahead[at])
            far -= seen.least[number][at]
            bounds[number][at] = np.minimum(np.maximum(far, 0.0), bounds[number][at])
    total = bounds[0] + bounds[1] + part.slack
    if gap is not None:
        hit |= seen.length < gap
    return hit, ~hit & (need >= total), seen.loss, total


def _axes(tree: Tree) -> native.Axes:
    return native.Axes(tree.axis, tree.origin, tree.advance, tree.turns, tree.slides)


def _seen(
    tree: Tree, body: Pieces, part: Cells, joint: np.ndarray, middle: np.ndarray, wide: np.ndarray, near: float
) -> native.Examined:
    """What can be told of cells in their middle, by NumPy."""
    half = joint.shape[1] // 2
    columns = slice(0, half), slice(half, 2 * half)
    poses = [_posed(tree, joint[:, side], middle[:, side]) for side in columns]
    sides = [
        Placed(body, piece, pose.turn, pose.shift) for piece, pose in zip((part.piece, part.other), poses, strict=True)
    ]
    hit, away = separate(sides[0], sides[1], near)
    length = np.maximum(np.sqrt(dot(away, away)), 1e-12)
    away = away / length[:, None]
    rows, loss = np.arange(len(part.row)), np.zeros(joint.shape)
    between, bounds, leasts, many = np.zeros(len(part.row)), [], [], []
    for side, pose, to, ahead in zip(sides, poses, columns, (-away, away), strict=True):
        least = dot(side.support(rows, ahead), ahead)
        between -= least
        moving = (joint[:, to] >= 0) & (wide[:, to] > 0.0)
        for column in range(half):
            at = np.flatnonzero(moving[:, column])
            known, by, axis = joint[at, to.start + column], wide[at, to.start + column], pose.axis[at, column]
            turn = np.where(tree.turns[known], np.minimum(by, np.pi), 0.0)
            far = swept_extent(side.at(at), axis, pose.origin[at, column], turn, ahead[at])
            along = np.where(tree.slides[known], 1.0, np.abs(tree.advance[known])) * by
            loss[at, to.start + column] = np.maximum(far - least[at], 0.0) + np.abs(dot(axis, ahead[at])) * along
        several = moving.sum(axis=1) > 1
        # the outermost exactly, those within by the way that corners can make
        last = half - 1 - np.argmax(moving[:, ::-1], axis=1)
        inner = np.where(np.arange(half) < last[:, None], wide[:, to] * part.radius[:, to], 0.0)
        bounds.append(np.where(several, loss[rows, to.start + last] + add_columns(inner), add_columns(loss[:, to])))
        leasts.append(least)
        many.append(several)
    return native.Examined(hit, away, length, between, loss, np.stack(bounds), np.stack(leasts), np.stack(many))


def _cloud(
    tree: Tree,
    body: Pieces,
    piece: np.ndarray,
    joint: np.ndarray,
    middle: np.ndarray,
    wide: np.ndarray,
    ahead: np.ndarray,
) -> np.ndarray:
    """How far (k,) pieces reach along unit vectors (k, 3) while their joints (k, c) go through their intervals together.

    In place of an arc stand its ends and where its tangents meet, which hold it between them; in place of a long one the corners
    of an octagon about the whole circle.
    """
    places, axes = _places(tree, joint, middle, wide), _axes(tree)
    spare = add_columns(np.where(places.turns, np.abs(tree.advance[np.maximum(joint, 0)]) * places.by, 0.0))
    machine = compiled()
    if machine is not None:
        side = Placed(body, piece).side()
        known = native.reach(machine, side, axes, joint, places.count, places.angle, places.wider, places.slide, ahead)
        if known is not None:
            return known + spare
    forward, beyond = _carried_back(axes, joint, places, ahead)
    found = np.empty(len(piece))
    for at, corners in body.classes(piece):
        far = dot(corners[:, None], forward[at][:, :, None]) + beyond[at][:, :, None]
        found[at] = far.max(axis=(1, 2))
    return found + spare


@dataclass(frozen=True, slots=True, eq=False)
class _Places:
    """What stands for the ways of joints (k, c): by how far each goes either way, ``count`` (k, c) places of up to 8, each turned by an
    ``angle``, put ``wider`` times as far out and ``slide`` along the axis, (k, c, 8)."""

    turns: np.ndarray
    by: np.ndarray
    count: np.ndarray
    angle: np.ndarray
    wider: np.ndarray
    slide: np.ndarray


def _places(tree: Tree, joint: np.ndarray, middle: np.ndarray, wide: np.ndarray) -> _Places:
    known, by = np.maximum(joint, 0), np.where(joint >= 0, wide, 0.0)
    turns, slides = (joint >= 0) & tree.turns[known], (joint >= 0) & tree.slides[known]
    long = turns & (by > _EIGHTH / 2)
    bend = np.where(turns & ~long, by, 0.0)
    sign, step = np.array((0.0, -1.0, 1.0))[np.arange(native.PLACES) % 3], np.arange(native.PLACES)
    angle = np.where(turns, middle, 0.0)[..., None]
    angle = angle + np.where(long[..., None], step * _EIGHTH, sign * bend[..., None])
    wider = np.where(sign == 0.0, (1.0 / np.cos(bend))[..., None], 1.0)
    wider = np.where(long[..., None], 1.0 / np.cos(_EIGHTH / 2), wider)
    slide = np.where(slides[..., None], middle[..., None] + sign * by[..., None], 0.0)
    slide = slide + np.where(turns, tree.advance[known] * middle, 0.0)[..., None]
    return _Places(turns, by, np.where(long, native.PLACES, np.where(by > 0.0, 3, 1)), angle, wider, slide)


def _carried_back(
    axes: native.Axes, joint: np.ndarray, places: _Places, ahead: np.ndarray
) -> tuple[np.ndarray, np.ndarray]:
    """The directions (k, n, 3) along which, and the ways (k, n) beyond which, corners at rest reach when their joints are at each of their
    places: what joints do to a corner is done to the direction instead, once for all corners, from the outermost joint to the innermost."""
    forward, beyond = ahead[:, None], np.zeros((len(joint), 1))
    for column in range(joint.shape[1] - 1, -1, -1):
        own = joint[:, column]
        known, many = np.maximum(own, 0), int(places.count[:, column].max(initial=1))
        axis, origin = axes.axis[known][:, None], axes.origin[known][:, None]
        made, past = [], []
        for step in range(many):  # where a row has fewer, some of them again
            turn = rotation_about(axis[:, 0], places.angle[:, column, step])
            wider, slide = places.wider[:, column, step, None], places.slide[:, column, step, None]
            along = dot(forward, axis)
            bare = apply(np.swapaxes(turn, 1, 2)[:, None], forward)
            way = bare * wider[..., None] + axis * ((1.0 - wider) * along)[..., None]
            off = beyond + (dot(forward, origin) + along * slide) - dot(way, origin)
            made.append(np.where((own >= 0)[:, None, None], way, forward))
            past.append(np.where((own >= 0)[:, None], off, beyond))
        forward, beyond = np.concatenate(made, axis=1), np.concatenate(past, axis=1)
    return forward, beyond


def add_columns(columns: np.ndarray) -> np.ndarray:
    """Sums of rows, column by column."""
    total = np.zeros(len(columns))
    for column in columns.T:
        total = total + column
    return total
