"""Parts that nothing holds, solids without thickness, and ranges of joints that are none.

Within a link, primitives that touch or overlap hang together; all of them must, with the one declared first. A link must
come near what holds it: their pieces (those of a slide anywhere on its way) within 2 cm, or the axis of a hinge, as long
as what turns about it, within 2 cm of both, or pieces of what a closed loop ties it to.
"""

from __future__ import annotations

from functools import cached_property

import numpy as np

from ..geometry.collide import find_near
from ..geometry.runs import absent, distinct
from ..geometry.vectors import dot
from ..native.narrow import Side
from ..runtime.batch import Batch
from .bodies import Pieces, Placed, enumerate_ranges, link_boxes
from .fault import Fault, Key, list_faults
from .meant import find_meant, sites_of
from .neighbours import find_neighbours
from .tree import Tree

_TOUCH = 1e-4  # metres: what is farther apart does not touch
_ROUND = 5e-3  # of the middle extent: round solids are polyhedra here, a little smaller than they are
_HOLD = 2e-2  # metres: a link this near to another can be held by it
_THIN = 1e-6  # metres
_FIRST = 4  # pairs of pieces of a link that are looked at first
_SOME = 16  # pieces of a link, of many, that are looked at first


def alone(part: str, link: str) -> str:
    """What is wrong with a part that floats, by its path and that of its link."""
    return f"`{part}` touches nothing else of its link, that of `{link}`"


class Solids:
    """The primitives of a batch, by row of their tables, one table after the other."""

    def __init__(self, tree: Tree, body: Pieces):
        tables = tree.batch.sites()
        self.tree, self.body = tree, body
        self.site = (
            np.concatenate([np.full(len(t), t.number) for t in tables]) if tables else np.zeros(0, dtype=np.int64)
        )
        self.owner = np.concatenate([t.owner for t in tables]) if tables else self.site
        self.link = tree.first[self.owner] + np.concatenate([t.link for t in tables]) if tables else self.site
        self.order = np.argsort(body.solid, kind="stable")  # pieces by primitive
        self.begin = np.searchsorted(body.solid[self.order], np.arange(len(self.site)))
        self.count = np.searchsorted(body.solid[self.order], np.arange(len(self.site)), side="right") - self.begin
        self.low, self.high = np.full((len(self.site), 3), np.inf), np.full((len(self.site), 3), -np.inf)
        full = np.flatnonzero(self.count)
        if len(full):
            self.low[full] = np.minimum.reduceat(body.low[self.order], self.begin[full])
            self.high[full] = np.maximum.reduceat(body.high[self.order], self.begin[full])

    def paths(self) -> list[str]:
        """The path of each of the program's sites."""
        program = self.tree.batch.program
        return [program.parts[site.part].path for site in program.sites]

    def path(self, solid: int) -> str:
        program = self.tree.batch.program
        return program.parts[program.sites[self.site[solid]].part].path

    def told(self, wrong: np.ndarray, words: str) -> list[Fault]:
        """``wrong`` (S,) bool by path, in words with the path."""
        paths = ((self.path(solid), int(self.owner[solid])) for solid in np.flatnonzero(wrong).tolist())
        return list_faults(((words.format(path), None, path), owner) for path, owner in paths)

    def degenerate(self) -> list[Fault]:
        """Primitives without pieces, without thickness, or with sizes that are no numbers."""
        extent = self.high - self.low
        return self.told(~((extent > _THIN).all(axis=1) & np.isfinite(extent).all(axis=1)), "`{}` has no thickness")

    def missing(self) -> list[Fault]:
        """Objects without any primitive."""
        batch = self.tree.batch
        bare = absent(len(batch), self.owner)
        return [Fault(f"no part of `{batch.program.name}` has a surface", bare)]

    def margin(self) -> np.ndarray:
        """By how much (S,) the pieces of each primitive may lie within it."""
        middle = np.sort(np.where(np.isfinite(self.high - self.low), self.high - self.low, 0.0), axis=1)[:, 1]
        corners = np.array([len(points[0]) for points in self.body.corners] or [0])
        boxy = (
            corners[self.body.kind[self.order[np.minimum(self.begin, len(self.order) - 1)]]] == 8
            if len(self.order)
            else True
        )
        return _TOUCH + np.where((self.count == 1) & boxy, 0.0, _ROUND * middle)

    # ------------------------------------------------------------ within a link

    def floating(self) -> list[Fault]:
        """Primitives that hang together with the first of their link by no chain of contacts."""
        loose = np.flatnonzero(self.loose()).tolist()
        told = ((self.path(solid), self.carrier(solid), int(self.owner[solid])) for solid in loose)
        return list_faults(((alone(path, link), None, path), owner) for path, link, owner in told)

    def carrier(self, solid: int) -> str:
        """The path of the link that a primitive is on."""
        return self.tree.batch.program.links[self.tree.links.definition[self.link[solid]]].path

    def loose(self) -> np.ndarray:
        """Which primitives (S,) hang together with the first of their link by no chain of contacts."""
        group, margin = np.arange(len(self.site)), self.margin()
        first, second = find_neighbours(self.link, self.low, self.high, margin)
        most, least = np.maximum(self.low[first], self.low[second]), np.minimum(self.high[first], self.high[second])
        shared = (least - most).min(axis=1)  # the deeper boxes overlap, the sooner a pair is asked
        while True:
            apart = group[first] != group[second]
            first, second, shared = first[apart], second[apart], shared[apart]
            if not len(first):
                break
            best = distinct(np.concatenate([_best(group[side], shared) for side in (first, second)]))
            met = self._touch(first[best], second[best], margin)
            group = _join_groups(group, first[best[met]], second[best[met]])
            left = np.ones(len(first), dtype=bool)
            left[best] = False
            first, second, shared = first[left], second[left], shared[left]
        return _find_loose(self.tree.batch, self.link, group)

    def _touch(self, first: np.ndarray, second: np.ndarray, margin: np.ndarray) -> np.ndarray:
        """Indices of the pairs of primitives that touch."""
        k, one = enumerate_ranges(self.begin[first], self.count[first])
        room = np.maximum(margin[first], margin[second])
        i, j = self.order[one], second[k]
        near = np.ones(len(k), dtype=bool)
        for axis in range(3):
            near &= (self.body.low[i, axis] < self.high[j, axis] + room[k]) & (
                self.low[j, axis] < self.body.high[i, axis] + room[k]
            )
        k, i = k[near], i[near]
        n, other = enumerate_ranges(self.begin[second[k]], self.count[second[k]])
        k, i, j = k[n], i[n], self.order[other]
        for axis in range(3):
            near = (self.body.low[i, axis] < self.body.high[j, axis] + room[k]) & (
                self.body.low[j, axis] < self.body.high[i, axis] + room[k]
            )
            k, i, j = k[near], i[near], j[near]
        return distinct(k[find_near(Placed(self.body, i), Placed(self.body, j), room[k])])

    # ------------------------------------------------------------ between links

    def find_unheld(self) -> list[Fault]:
        """Links that nothing of what holds them comes near."""
        tree = self.tree
        count = len(tree.links.owner)
        _, _, begin, end = self._links
        solid = end > begin
        holder = tree.above.copy()
        while True:  # links without solids hold nothing themselves
            empty = (holder >= 0) & ~solid[np.maximum(holder, 0)]
            if not empty.any():
                break
            holder[empty] = tree.above[holder[empty]]
        asked = np.flatnonzero(solid & (holder >= 0) & ~np.isin(np.arange(count), self._links_allowed()))
        joint = tree.joint[asked]
        far = asked[~self._axis_holds(asked, holder[asked], joint)]
        far = far[~self._near(far, holder[far])]
        looped = np.zeros(count, dtype=bool)
        if len(far) and tree.batch.loops is not None:
            looped[tree.batch.loops.link] = True
            far = self._unheld_by_loops(far, tree.batch.loops.link)
        found: list[tuple[Key, int]] = []
        for link in far.tolist():
            name = tree.batch.program.links[tree.links.definition[link]].path
            away = (
                "neither the link that carries it nor what `close` ties it to is"
                if looped[link]
                else "the link that carries it is not"
            )
            found.append(((f"nothing holds `{name}`: {away} within 2 cm", None, name), int(tree.links.owner[link])))
        return list_faults(found)

    def _unheld_by_loops(self, far: np.ndarray, ties: np.ndarray) -> np.ndarray:
        """Those of the links ``far`` from what carries them that no chain of closed loops, ``ties`` (2, C), holds near one that is not."""
        held = np.ones(len(self.tree.links.owner), dtype=bool)
        held[far] = False
        ties = np.concatenate([ties, ties[::-1]], axis=1)
        ties = ties[:, ~held[ties[0]]]
        link, other = ties[:, self._near(ties[0], ties[1])]
        while (more := held[other] & ~held[link]).any():
            held[link[more]] = True
        return far[~held[far]]

    def _links_allowed(self) -> np.ndarray:
        return distinct(self.link[_may_float(self.tree.batch)])

    @cached_property
    def _links(self) -> tuple[np.ndarray, np.ndarray, np.ndarray, np.ndarray]:
        """Boxes (L, 3) of the links, and where their pieces begin and end."""
        return link_boxes(self.body, len(self.tree.links.owner))

    def _axis_holds(self, link: np.ndarray, holder: np.ndarray, joint: np.ndarray) -> np.ndarray:
        """Whether the axis of a hinge, as long as what turns about it, comes near both."""
        tree, body = self.tree, self.body
        axis, origin = tree.axis[joint], tree.origin[joint]
        lows, highs, begin, end = self._links
        middle, half = (lows[link] + highs[link]) / 2, (highs[link] - lows[link]) / 2
        along, reach = dot(middle - origin, axis), dot(half, np.abs(axis))
        ends = origin + axis * (along - reach - _HOLD)[:, None], origin + axis * (along + reach + _HOLD)[:, None]
        held = tree.turns[joint].copy()
        for side in (link, holder):
            rows = np.flatnonzero(held)
            k, piece = enumerate_ranges(begin[side[rows]], (end - begin)[side[rows]])
            at = rows[k]
            near = np.ones(len(at), dtype=bool)
            for axis_ in range(3):
                one, two = ends[0][at, axis_], ends[1][at, axis_]
                near &= (np.minimum(one, two) < body.high[piece, axis_] + _HOLD) & (
                    body.low[piece, axis_] - _HOLD < np.maximum(one, two)
                )
            at, piece = at[near], piece[near]
            met = np.zeros(len(link), dtype=bool)
            met[at[find_near(Placed(body, piece), _Segments(ends[0][at], ends[1][at]), np.full(len(at), _HOLD))]] = True
            held &= met
        return held

    def _near(self, link: np.ndarray, holder: np.ndarray) -> np.ndarray:
        """Whether any pieces of two links come near one another; those of a slide anywhere on its way."""
        tree, body = self.tree, self.body
        lows, highs, begin, end = self._links
        joint = tree.joint[link]
        shift = [
            tree.axis[joint] * np.where(tree.slides[joint], end_[joint] - tree.joints.rest[joint], 0.0)[:, None]
            for end_ in (tree.low, tree.high)
        ]
        first, last = np.minimum(*shift), np.maximum(*shift)
        k, i = enumerate_ranges(begin[link], (end - begin)[link])
        close = _within(body.low[i] + first[k], body.high[i] + last[k], lows[holder][k], highs[holder][k])
        k, i = k[close], i[close]
        n, j = enumerate_ranges(begin[holder], (end - begin)[holder])
        close = _within(body.low[j], body.high[j], (lows[link] + first)[n], (highs[link] + last)[n])
        n, j = n[close], j[close]
        met = np.zeros(len(link), dtype=bool)
        for most in (_SOME, len(body)):  # of some pieces of either, a pair is near as a rule
            one, other = (~met[of] & _some_of(of, most) for of in (k, n))
            met |= self._near_pairs(len(link), (k[one], i[one]), (n[other], j[other]), shift)
        return met

    def _near_pairs(
        self,
        count: int,
        ours: tuple[np.ndarray, np.ndarray],
        theirs: tuple[np.ndarray, np.ndarray],
        shift: list[np.ndarray],
    ) -> np.ndarray:
        """Which of ``count`` pairs of links have pieces near one another: ``ours`` of those that slide from one ``shift`` to the other,
        ``theirs`` of what holds them, each as the pair, ascending, and the piece."""
        body, (k, i), (n, j) = self.body, ours, theirs
        first, last = np.minimum(*shift), np.maximum(*shift)
        start = np.searchsorted(n, np.arange(count))
        n, at = enumerate_ranges(start[k], (np.searchsorted(n, np.arange(count), side="right") - start)[k])
        k, i, j = k[n], i[n], j[at]
        low, high = body.low[i] + first[k], body.high[i] + last[k]
        gap = np.maximum(np.maximum(low - body.high[j], body.low[j] - high), 0.0)
        gap = dot(gap, gap)
        near = np.flatnonzero(gap < _HOLD * _HOLD)
        order = near[np.lexsort((gap[near], k[near]))]
        rank = np.arange(len(order)) - np.searchsorted(k[order], k[order])
        met, begun, stop = np.zeros(count, dtype=bool), 0, _FIRST
        while (rank >= begun).any():  # the nearest boxes first
            at = order[(rank >= begun) & (rank < stop) & ~met[k[order]]]
            moved = Placed(body, i[at], ends=(shift[0][k[at]], shift[1][k[at]]))
            met[k[at[find_near(moved, Placed(body, j[at]), np.full(len(at), _HOLD))]]] = True
            begun, stop = stop, 4 * stop
        return met


def _some_of(owner: np.ndarray, most: int) -> np.ndarray:
    """At most so many of the rows of each owner (ascending), spread evenly: (len,) bool."""
    first = np.searchsorted(owner, owner)
    count, rank = np.searchsorted(owner, owner, side="right") - first, np.arange(len(owner)) - first
    return (count <= most) | ((rank + 1) * most // count > rank * most // count)


def _within(low: np.ndarray, high: np.ndarray, lows: np.ndarray, highs: np.ndarray) -> np.ndarray:
    """Which boxes come within reach of others along every axis; a micrometre more, so that rounding loses none."""
    near = np.ones(len(low), dtype=bool)
    for axis in range(3):
        near &= (low[:, axis] < highs[:, axis] + _HOLD + 1e-6) & (lows[:, axis] < high[:, axis] + _HOLD + 1e-6)
    return near


class _Segments:
    """Straight lines between points (k, 3)."""

    def __init__(self, first: np.ndarray, last: np.ndarray):
        self.ends = first, last

    def __len__(self) -> int:
        return len(self.ends[0])

    def center(self) -> np.ndarray:
        return (self.ends[0] + self.ends[1]) / 2

    def support(self, rows: np.ndarray, direction: np.ndarray) -> np.ndarray:
        one, two = self.ends[0][rows], self.ends[1][rows]
        return np.where((dot(one, direction) >= dot(two, direction))[:, None], one, two)

    def side(self) -> Side:
        every = np.arange(len(self))
        return Side([np.stack(self.ends, axis=1)], np.zeros_like(every), every)


def _best(group: np.ndarray, value: np.ndarray) -> np.ndarray:
    """The index of the highest value of each group, the first of equals."""
    order = np.lexsort((-value, group))
    return order[np.diff(group[order], prepend=-1) != 0]


def _may_float(batch: Batch) -> np.ndarray:
    """Primitives within parts that may float."""
    free = [said for said in batch.program.allowed if said.kind == "floating"]
    rows = [find_meant(batch, said, said.first, said.ranks[0]).row for said in free]
    if not rows:
        return np.zeros(0, dtype=np.int64)
    inside = sites_of(batch, distinct(np.concatenate(rows)))
    start = np.cumsum([0, *(len(table) for table in batch.sites())])
    return np.concatenate([begin + row for begin, (row, _) in zip(start[:-1], inside, strict=True)])


def _find_loose(batch: Batch, link: np.ndarray, group: np.ndarray) -> np.ndarray:
    """Which primitives (S,) are in another group than the first of their link, and in none that may float. The first is one that
    may not float itself: what floats beside the others holds none of them."""
    floats = _may_float(batch)
    own = absent(len(link), floats)
    head = np.full(int(link.max(initial=-1)) + 1, len(link))
    np.minimum.at(head, link[own], own)
    excused = np.zeros(len(link), dtype=bool)
    excused[group[floats]] = True
    return (group != np.append(group, -1)[head[link]]) & ~excused[group]


def _join_groups(group: np.ndarray, first: np.ndarray, second: np.ndarray) -> np.ndarray:
    """Groups (S,), each known by its lowest member, with those of the pairs put together."""
    while True:
        before = group
        group = group.copy()
        least = np.minimum(group[first], group[second])
        np.minimum.at(group, before[first], least)
        np.minimum.at(group, before[second], least)
        while not np.array_equal(group, group[group]):
            group = group[group]
        if np.array_equal(group, before):
            return group


def find_inverted(tree: Tree) -> list[Fault]:
    """Joints whose range does not hold their rest value, as none does that ends below where it begins; those that others
    leave no way at all. Requirements see to the former, which an edited program may lack; of loops, `find_open` tells."""
    joints = tree.joints
    found: list[tuple[Key, int]] = []
    low, high = (
        np.where(np.isnan(joints.low), -np.inf, joints.low),
        np.where(np.isnan(joints.high), np.inf, joints.high),
    )
    outside = (joints.rest < low - 1e-9) | (joints.rest > high + 1e-9) | ~np.isfinite(joints.rest)
    if tree.batch.loops is not None:
        outside[tree.batch.loops.beyond(joints.rest)] = False
    whatever = np.array([joint.whatever for joint in tree.batch.program.joints], dtype=bool)[joints.definition]
    shut = whatever & (high <= joints.rest)
    for row in np.flatnonzero(outside | shut).tolist():
        joint = tree.batch.program.joints[joints.definition[row]]
        what = "does not contain its rest value"
        if shut[row]:
            what = "is empty: something is in the way from the start when other joints are open"
        found.append(((f"the range of `{joint.path}` {what}", joint.where, None), int(joints.owner[row])))
    return list_faults(found)
