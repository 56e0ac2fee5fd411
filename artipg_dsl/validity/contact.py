"""Where two links meet: the parts, a point of both, and the value of the joint that brings it about."""

from __future__ import annotations

import numpy as np

from ..geometry.collide import common_point, overlap
from ..language import JOINTS
from ..records import dataclass
from ..runtime.motion import apply, rotation_about
from ..runtime.tables import plain_name
from .bodies import Pieces, Placed
from .tree import Tree
from .validate import Collisions

_PLACES = 65  # of the range of a joint that are looked at


@dataclass(frozen=True, slots=True)
class Contact:
    """Two parts by name, in the order of their links' paths, of the object of a number; ``at`` is in the object's frame.

    ``value`` of the joint, radians or metres; None at rest.
    """

    object: int
    parts: tuple[str, str]
    at: tuple[float, float, float]
    value: float | None


def describe_contact(tree: Tree, body: Pieces, found: Collisions, row: int) -> Contact:
    """What meets in a row of ``found``, whose pieces are those of ``body``."""
    pair = found.pieces[row]
    owner, named = int(found.owner[row]), int(found.joint[row])
    i, j = (np.flatnonzero(body.source == source) for source in pair)
    body.ready(i, j)
    states, value = tree.joints.rest.copy(), None
    if named >= 0:
        joint = int(np.searchsorted(tree.joints.owner, owner)) + named
        value = float(found.value[row])
        if tree.alone[joint]:
            nearest = _nearest(tree, body, i, j, joint)
            value = nearest if nearest is not None else float(tree.high[joint]) if tree.slides[joint] else value
        states[joint] = value
    turn, shift, _ = tree.at(states)
    first, second = (Placed(body, k, turn[body.link[k]], shift[body.link[k]]) for k in (i, j))
    at = tuple(np.round(common_point(first, second)[0], 4).tolist())
    return Contact(int(tree.batch.numbers[owner]), meeting_parts(tree, body, found, row), at, value)


def meeting_parts(tree: Tree, body: Pieces, found: Collisions, row: int) -> tuple[str, str]:
    """The two parts that meet in a row of ``found``, by name, in the order of their links' paths."""
    one, other = (int(np.flatnonzero(body.source == source)[0]) for source in found.pieces[row])
    paths = [tree.batch.program.links[tree.links.definition[body.link[k]]].path for k in (one, other)]
    if paths[0] > paths[1]:
        one, other = other, one
    names = part_name(tree, body, one), part_name(tree, body, other)
    if names[0] == names[1]:  # two links of one part
        return part_name(tree, body, one, within=True), part_name(tree, body, other, within=True)
    return names


def _nearest(tree: Tree, body: Pieces, i: np.ndarray, j: np.ndarray, joint: int) -> float | None:
    """The value of a joint that moves alone nearest to rest at which two pieces meet, of some; None where they meet at none of these."""
    rest, axis, origin = tree.joints.rest[joint], tree.axis[joint], tree.origin[joint]
    values = np.linspace(tree.low[joint], tree.high[joint], _PLACES)
    values = values[np.argsort(np.abs(values - rest), kind="stable")]
    still, way = np.tile(np.eye(3), (_PLACES, 1, 1)), axis * (values - rest)[:, None]
    turn, shift = still, way
    if tree.turns[joint]:
        turn = rotation_about(np.tile(axis, (_PLACES, 1)), values - rest)
        shift = origin - apply(turn, origin) + tree.advance[joint] * way
    placed = []
    for k in (i, j):
        moves = (tree.chain[body.link[k]] == tree.child[joint]).any()
        placed.append(Placed(body, np.repeat(k, _PLACES), turn if moves else still, shift * moves))
    hit = np.flatnonzero(overlap(*placed))
    return float(values[hit[0]]) if len(hit) else None


def part_name(tree: Tree, body: Pieces, piece: int, within: bool = False) -> str:
    """The name of the part that a piece is of, ``column[0].cell[1].unit.handle``; ``within`` it, the path of its primitive."""
    row = int(body.solid[piece])
    for table in tree.batch.sites():
        if row < len(table):
            parts = tree.batch.parts()
            name = parts.name[int(np.searchsorted(parts.owner, table.owner[row])) + int(table.instance[row])]
            return f"{name}{table.path.removeprefix(plain_name(name))}" if within else name
        row -= len(table)
    return ""


def contact_in_words(kind: str, found: Contact) -> str:
    """``handle.grip and frame.rim at 12.3 deg, about (0.2, 0.1, 0.45), in object 17``; ``kind`` of the joint."""
    when = "" if found.value is None else f" at {value_in_words(kind, found.value)}"
    at = ", ".join(f"{x + 0.0:.4g}" for x in found.at)
    return f"`{found.parts[0]}` and `{found.parts[1]}`{when}, about ({at}) m, in object {found.object}"


def value_in_words(kind: str, value: float) -> str:
    """A value of a joint of a ``kind``, metres or radians: ``12.3 deg``, ``45.0 mm``."""
    slides = kind in JOINTS and JOINTS[kind].slides
    return f"{tenths(1e3 * value)} mm" if slides else f"{tenths(np.degrees(value))} deg"


def tenths(value: float) -> str:
    """A value to one decimal place; what rounds to zero has no sign."""
    return f"{round(value, 1) + 0.0:.1f}"
