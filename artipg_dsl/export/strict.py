"""The strict protocol: do the meshes that are seen share anything, in any of many states of all joints?

At rest, while each joint runs through its range with all others at rest, and in random states of all joints together, for
every pair of links. The solids that meshes bound are intersected (manifold3d); what is deeper than ``_DEEP`` is a fault.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import replace
from typing import TYPE_CHECKING, Any

import numpy as np

from ..errors import UserError
from ..extras import MANIFOLD
from ..records import dataclass
from ..robot.solids import build_meshes
from ..runtime.batch import Batch
from ..runtime.motion import apply
from ..validity.bodies import Alike, Pieces, pack_pieces
from ..validity.evidence import STATES, random_states
from ..validity.tree import Tree, lead_states
from ..validity.validate import find_near_pieces

if TYPE_CHECKING:
    from manifold3d import Manifold

_DEEP = 1e-6  # metres
_STEPS = 33  # of the range of each joint
_KINDS = ("at rest", "sweep", "all joints")


@dataclass(frozen=True, slots=True)
class Touch:
    """Two parts of two links of an object that share ``depth`` metres about ``at``, in the object's frame, in ``state``."""

    object: int
    links: tuple[str, str]
    parts: tuple[str, str]
    state: str  # of KINDS
    joint: str  # the one that moves, of a sweep
    values: dict[str, float]  # of the joints that are not at rest
    depth: float
    at: tuple[float, float, float]


@dataclass(frozen=True, slots=True)
class Strict:
    """How many objects of ``objects`` have meshes that share nothing, up to each kind of states; the deepest touch of each pair
    of links of an object and kind."""

    objects: int
    rest: int
    sweeps: int
    all: int
    states: int
    touches: tuple[Touch, ...]


def check_meshes(batch: Batch, states: int = STATES) -> Strict:
    """Look at the meshes of a batch. Raises UserError where manifold3d is not installed."""
    require_manifold()
    tree = Tree(batch)
    solids = _Solids(batch, tree)
    worst: dict[tuple[Any, ...], Touch] = {}
    for kind, moved, values, apart in _configurations(tree, states):
        for touch in solids.touching(values, kind, moved, apart):
            key = (touch.object, touch.links, touch.state)
            if key not in worst or worst[key].depth < touch.depth:
                worst[key] = touch
    found = tuple(sorted(worst.values(), key=lambda t: (t.object, _KINDS.index(t.state), t.links)))
    bad = [len({t.object for t in found if t.state in _KINDS[: k + 1]}) for k in range(len(_KINDS))]
    rest, sweeps, every = (len(batch) - count for count in bad)
    return Strict(len(batch), rest, sweeps, every, states, found)


def join_strict(found: Sequence[Strict]) -> Strict:
    """What is known of all objects, out of what is known of some of them each, in their order."""
    objects, rest, sweeps, every = (
        sum(getattr(f, name) for f in found) for name in ("objects", "rest", "sweeps", "all")
    )
    touches = tuple(touch for f in found for touch in f.touches)
    return Strict(objects, rest, sweeps, every, max((f.states for f in found), default=0), touches)


def require_manifold() -> None:
    """Raise UserError where manifold3d is not installed."""
    MANIFOLD.require("looking at meshes")


def _configurations(tree: Tree, states: int) -> Iterator[tuple[str, np.ndarray, np.ndarray, np.ndarray]]:
    """States of all objects at once: their kind, the joint (B,) that moves in each (-1: none), values (J,), and the objects
    whose loops do not close there."""
    rest = tree.joints.rest
    none = np.full(len(tree.first), -1)
    yield _KINDS[0], none, rest, np.zeros(0, dtype=np.int64)
    moves = tree.joints.that()
    for lead, values, _ in lead_states(tree, moves & (tree.high > tree.low), np.linspace(0.0, 1.0, _STEPS)):
        yield _KINDS[1], lead, values, _open_ones(tree, values)
    for number in range(states if moves.any() else 0):
        values = random_states(tree.batch, number)
        yield _KINDS[2], none, values, _open_ones(tree, values)


def _open_ones(tree: Tree, values: np.ndarray) -> np.ndarray:
    loops = tree.batch.loops
    return np.zeros(0, dtype=np.int64) if loops is None else np.unique(loops.owner[tree.at(values)[2]])


class _Solids:
    """The meshes of a batch as solids, and boxes about them."""

    def __init__(self, batch: Batch, tree: Tree):
        from manifold3d import Error, Manifold, Mesh64

        self.batch, self.tree = batch, tree
        self.parts = batch.parts()
        start = np.searchsorted(self.parts.owner, np.arange(len(batch)))
        groups, self.solids, self.names = [], [], []
        for group in build_meshes(batch.sites()):
            table, rows = group.table, group.rows
            link = tree.first[table.owner[rows]] + table.link[rows]
            ends = np.stack([group.vertices.min(axis=1), group.vertices.max(axis=1)], axis=1)
            pick = np.array([[i, j, k] for i in (0, 1) for j in (0, 1) for k in (0, 1)])
            corners = np.stack([ends[:, pick[:, axis], axis] for axis in range(3)], axis=-1)
            groups.append(Alike(corners, group.faces, table.owner[rows], link))
            faces = group.faces.astype(np.uint64)
            for k, part in enumerate((start[table.owner[rows]] + table.instance[rows]).tolist()):
                solid = Manifold(Mesh64(np.ascontiguousarray(group.vertices[k]), np.ascontiguousarray(faces)))
                if solid.status() != Error.NoError:
                    raise UserError(
                        f"the mesh of `{self.parts.name[part]}` does not bound a solid: {solid.status().name}"
                    )
                self.solids.append(solid)
                self.names.append(self.parts.name[part])
        self.boxes: Pieces = pack_pieces(groups)  # at joint values 0
        self.seen: set[tuple[Any, ...]] = set()

    def touching(self, values: np.ndarray, kind: str, lead: np.ndarray, apart: np.ndarray) -> Iterator[Touch]:
        """What meets with the joints at ``values`` (J,); pairs of links that stand as they have stood before are left out."""
        tree, body, batch = self.tree, self.boxes, self.batch
        turn, shift = batch.pose(values)
        own, at = turn[body.link], shift[body.link]
        middle = apply(own, (body.low + body.high) / 2) + at
        half = apply(np.abs(own), (body.high - body.low) / 2)
        placed = replace(body, low=middle - half, high=middle + half)
        i, j = find_near_pieces(tree, placed, np.arange(len(body)), placed.low, placed.high, None)
        keep = ~np.isin(body.owner[i], apart) & ~tree.permitted(body.link[i], body.link[j])
        i, j = i[keep], j[keep]
        fresh = self.fresh(body.link[i], body.link[j], turn, shift)
        for a, b in zip(i[fresh].tolist(), j[fresh].tolist(), strict=True):
            both = [
                self.solids[body.source[k]].transform(np.concatenate([own[k], at[k][:, None]], axis=1)) for k in (a, b)
            ]
            depth, place = _shared(*both)
            if depth > _DEEP:
                yield self.touch(a, b, kind, lead, values, depth, place)

    def fresh(self, first: np.ndarray, second: np.ndarray, turn: np.ndarray, shift: np.ndarray) -> np.ndarray:
        """Of pairs of links (k,), those that have not been looked at where they stand to one another."""
        back = turn[first].transpose(0, 2, 1)
        stand = np.concatenate(
            [apply(back, turn[second][:, :, axis]) for axis in range(3)] + [apply(back, shift[second] - shift[first])],
            axis=1,
        )
        keys = [
            (a, b, row.tobytes())
            for a, b, row in zip(first.tolist(), second.tolist(), np.round(stand, 9) + 0.0, strict=True)
        ]
        new = np.array([key not in self.seen for key in keys], dtype=bool)
        self.seen.update(keys)
        return new

    def touch(
        self, a: int, b: int, kind: str, lead: np.ndarray, values: np.ndarray, depth: float, place: np.ndarray
    ) -> Touch:
        tree, body = self.tree, self.boxes
        joints, owner = tree.joints, int(body.owner[a])
        mine = np.flatnonzero(joints.owner == owner)
        stand = self.batch.settle(values)
        moved = mine[np.abs(stand - joints.rest)[mine] > 1e-9]
        (one, part), (two, other) = sorted((tree.links.name[body.link[k]], self.names[body.source[k]]) for k in (a, b))
        return Touch(
            int(self.batch.numbers[owner]),
            (one, two),
            (part, other),
            kind,
            joints.name[lead[owner]] if lead[owner] >= 0 else "",
            {joints.name[k]: round(float(stand[k]), 6) for k in moved.tolist()},
            depth,
            (float(place[0]), float(place[1]), float(place[2])),
        )


def _shared(first: Manifold, second: Manifold) -> tuple[float, Any]:
    """How deep two solids share space, metres, and the middle of where they do so most deeply.

    Of each connected piece of what they share: the least width along the normals of its faces and the axes, at most six
    times volume by surface, which is what a pyramid's height is, as thin shells are wide in every direction.
    """
    deepest, at = 0.0, np.zeros(3)
    both = first ^ second
    for part in () if both.is_empty() else both.decompose():
        made = part.to_mesh64()
        points, corners = made.vert_properties[:, :3], made.tri_verts.astype(np.int64)
        normal = np.cross(points[corners[:, 1]] - points[corners[:, 0]], points[corners[:, 2]] - points[corners[:, 0]])
        length = np.sqrt((normal * normal).sum(axis=1))
        normal = np.concatenate([normal[length > 0] / length[length > 0, None], np.eye(3)])
        along = (points[:, None] * normal[None]).sum(axis=2)
        depth = min(float(np.ptp(along, axis=0).min()), 6 * part.volume() / max(part.surface_area(), 1e-300))
        if depth > deepest:
            deepest, at = depth, (points.min(axis=0) + points.max(axis=0)) / 2
    return deepest, at
