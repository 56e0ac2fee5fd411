"""Links of candidates beside those of real objects whose links and joints are known, as of a URDF: which of one are which of the other.

Links that are moved by the same joint, that nearest to the root, count as one. A link of a candidate and one of the cloud belong together if
most points of each lie on the other, and if both move, they do so alike. A point of what moves whose links do not belong together speaks
against a candidate. So two drawers are told from one with two fronts, and a door from a panel, where their surfaces are the same.
"""

from __future__ import annotations

from dataclasses import replace
from functools import cache

import numpy as np

from ..language import JOINTS
from ..records import dataclass
from ..runtime.batch import Batch
from ..runtime.motion import joints_by_depth
from .bodies import alike, twists
from .model import Placed

_STRANGE = 0.5  # how unlikely a point is whose links do not belong together, in natural logarithms: those of a link are no witnesses
# independent of each other
_MANY = 1 << 20  # more than there are elements of a repeat
_MOTION = "fit.motion"


@dataclass(frozen=True, slots=True, eq=False)
class Moving:
    """The links of K candidates, up to L each: a ``key`` (K, L) for what each is of the program, -1 where there is none; ``first`` (K, L): of
    the links that move on the way from the root the first, and the root where none does; and how this moves: ``twist`` (K, L, 6), see
    ``twists``."""

    key: np.ndarray
    first: np.ndarray
    twist: np.ndarray

    @staticmethod
    def of(batch: Batch) -> Moving:
        """The links of candidates in their own frames."""
        found: Moving | None = batch.known.get(_MOTION)
        if found is None:
            found = batch.known[_MOTION] = _moving(batch)
        return found

    def placed(self, placed: Placed) -> Moving:
        """The same in the frames of clouds."""
        turn, shift = self.twist[..., :3], placed.scale[:, None, None] * self.twist[..., 3:]
        return replace(self, twist=np.concatenate([turn, shift + np.cross(placed.shift[:, None], turn)], axis=-1))

    def __getitem__(self, at: np.ndarray | slice) -> Moving:
        return Moving(self.key[at], self.first[at], self.twist[at])


def _moving(batch: Batch) -> Moving:
    links, joints, program = batch.link_instances, batch.joint_instances, batch.program
    first = np.searchsorted(links.owner, np.arange(len(batch)))
    most = int(links.number.max(initial=-1)) + 1
    named = links.owner * len(program.links) + links.definition  # ascending
    key = np.full((len(batch), most), -1, dtype=np.int64)
    key[links.owner, links.number] = links.definition * _MANY + np.arange(len(named)) - np.searchsorted(named, named)
    told: list[list[np.ndarray]] = [[], [], [], []]
    for joint in program.joints:
        ends = (batch.link_numbers(joint.scope, end) for end in (joint.parent, (joint.child,)))
        lies = (np.stack(batch.read(cells, joint.scope), axis=-1) for cells in (joint.axis, joint.origin))
        for column, one in zip(told, (*ends, *lies), strict=True):
            column.append(one)
    parent, child = (first[joints.owner] + joints.sort(column, dtype=np.int64) for column in told[:2])
    axis, origin = (joints.sort(column, (3,)) for column in told[2:])
    ways = np.array([JOINTS[joint.kind].moves for joint in program.joints] or [""])[joints.definition]
    own, twist, top = twists(ways, axis, origin), np.zeros((len(links.owner), 6)), np.arange(len(links.owner))
    for at in joints_by_depth(len(links.owner), parent, child):
        moved = (twist[parent[at]] != 0.0).any(axis=1)
        begins = ~moved & (own[at] != 0.0).any(axis=1)
        top[child[at]] = np.where(begins, child[at], top[parent[at]])
        twist[child[at]] = np.where(moved[:, None], twist[parent[at]], own[at])
    every, leads = np.zeros((len(batch), most, 6)), np.zeros((len(batch), most), dtype=np.int64)
    every[links.owner, links.number], leads[links.owner, links.number] = twist, links.number[top]
    return Moving(key, leads, every)


def links_of_rows(batch: Batch) -> list[np.ndarray]:
    """Of each site the link that each primitive goes with, the first that moves or the root, as its number within its object."""
    links, first = cache(batch.link_numbers), Moving.of(batch).first  # of many sites the same
    sites = batch.program.sites
    return [first[batch.owner(site.scope), links(site.scope, site.link)] for site in sites]


@dataclass(frozen=True, slots=True, eq=False)
class Points:
    """Points of clouds that are asked about copies: on which links they lay, in what each copy was made of (``before``), and lie in the copy
    (``after``), -1 where these are the same, or nothing is known; on which links of the cloud (``theirs``), -1 for none; (K, m) each. A point
    stands for ``each`` (K,)."""

    before: np.ndarray
    after: np.ndarray
    theirs: np.ndarray
    each: np.ndarray


@dataclass(frozen=True, slots=True, eq=False)
class Held:
    """On which links of candidates the points of clouds lie: ``mine`` (K, M), -1 where nothing is known of a point; how many points of each of
    the cloud's links lie on each: ``count`` (K, L, R); and how unlikely that makes each point: ``strange`` (K, M)."""

    moving: Moving
    mine: np.ndarray
    count: np.ndarray
    strange: np.ndarray

    def __getitem__(self, at: np.ndarray | slice) -> Held:
        return Held(self.moving[at], self.mine[at], self.count[at], self.strange[at])

    @staticmethod
    def none(shape: tuple[int, ...]) -> Held:
        """Where no links of clouds are known."""
        still = np.zeros((shape[0], 0), dtype=np.int64)
        moving = Moving(still, still, np.zeros((shape[0], 0, 6)))
        return Held(moving, np.full(shape, -1), np.zeros((shape[0], 0, 0)), np.zeros(shape))

    @staticmethod
    def of(moving: Moving, mine: np.ndarray, theirs: np.ndarray, real: np.ndarray, diagonal: np.ndarray) -> Held:
        """Of points that lie on the links ``mine`` of candidates and ``theirs`` of clouds (K, M) each; ``real`` (K, R, 6) are the twists of
        these, ``diagonal`` (K,) is that of clouds."""
        shape = *moving.key.shape, real.shape[1]
        count = tally(mine, theirs, np.ones(mine.shape), shape)
        strange = _strangeness(together(moving, count, real, diagonal), mine, theirs, real)
        return Held(moving, np.where(theirs < 0, -1, mine), count, strange)

    def otherwise(self, moving: Moving, points: Points, real: np.ndarray, diagonal: np.ndarray) -> np.ndarray:
        """(K, m) how unlikely some ``points`` are for copies whose links are ``moving``, these being of what each copy was made of; ``real``
        and ``diagonal`` as ``of`` has them."""
        same = (self.moving.key[:, :, None] == moving.key[:, None]) & (self.moving.key >= 0)[:, :, None]
        count = np.matmul(np.swapaxes(same, 1, 2).astype(np.float64), self.count)
        number = np.where(same.any(axis=2), same.argmax(axis=2), -1)  # of each link, in the copy
        number = np.append(number, np.full((len(number), 1), -1), axis=1)
        before = np.take_along_axis(number, points.before, axis=1)
        after = np.where(points.after < 0, before, points.after)
        weight = np.broadcast_to(points.each[:, None], after.shape)
        count += tally(after, points.theirs, weight, count.shape) - tally(before, points.theirs, weight, count.shape)
        return _strangeness(together(moving, count, real, diagonal), after, points.theirs, real)


def together(moving: Moving, count: np.ndarray, real: np.ndarray, diagonal: np.ndarray) -> np.ndarray:
    """(K, L, R) whether links belong together, of which ``count`` (K, L, R) points lie on one another."""
    may = alike(moving.twist[:, :, None], real[:, None], diagonal[:, None, None])
    count = np.where(may, count, 0.0)
    most = [count.max(axis=axis, keepdims=True, initial=0.0) for axis in (1, 2)]
    return np.asarray((count > 0.5) & (count >= most[0]) & (count >= most[1]))


def _strangeness(belong: np.ndarray, mine: np.ndarray, theirs: np.ndarray, real: np.ndarray) -> np.ndarray:
    """(K, m) how unlikely points are by their links, of which those belong together that ``belong`` (K, L, R) says; those of what does not
    move, as ``real`` (K, R, 6) has it, are not: many a door was left rigid."""
    own, point = np.nonzero((theirs >= 0) & (mine >= 0))
    other = theirs[own, point]
    strange = (real[own, other] != 0.0).any(axis=1) & ~belong[own, mine[own, point], other]
    found = np.zeros(mine.shape)
    found[own, point] = np.where(strange, _STRANGE, 0.0)
    return found


def tally(mine: np.ndarray, theirs: np.ndarray, weight: np.ndarray, shape: tuple[int, ...]) -> np.ndarray:
    """(K, L, R) sums of the ``weight`` (K, m) of points on the links ``mine`` and ``theirs`` (K, m), but for those of which one is -1."""
    own, point = np.nonzero((theirs >= 0) & (mine >= 0))
    at = np.ravel_multi_index((own, mine[own, point], theirs[own, point]), shape)
    return np.bincount(at, weight[own, point], minlength=int(np.prod(shape))).reshape(shape)
