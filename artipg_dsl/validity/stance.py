"""Do objects stand by themselves: is the centre of mass well inside the polygon on which they stand?

The polygon is the hull of what touches the floor (``feet``). It must hold the point below the centre of mass with a
margin: the object still stands when the floor is tilted by two degrees in any direction. ``open``: also with each joint
alone at 33 positions in its range (9 of one that moves others), and, for each of eight directions, with all joints
together that move the centre of mass that way, each where it does so most (the test of an empty chest of drawers with
everything open, ASTM F2057). Nobody sits on anything and nothing lies in the drawers.
"""

from __future__ import annotations

from itertools import islice

import numpy as np

from ..diagnostics.suggest import any_of
from ..geometry.runs import distinct
from ..geometry.vectors import dot
from ..native.backend import machine as compiled
from ..native.feet import Overlaps, Standing, over_edges
from ..runtime.motion import apply, multiply, rotation_about
from .bodies import Pieces
from .contact import part_name
from .feet import FLOOR, find_feet
from .hull import NEAR, depth, hulls
from .mass import SAMPLED, Mass, Rough, masses, weighing
from .tree import Tree, lead_states

TILT = float(np.tan(np.radians(2.0)))
_STEEP = 1.001  # a margin changes by no more than this, times what the centre of mass moves
_ROUNDING = 1e-9  # metres
_SHARES = np.linspace(0.0, 1.0, 33)  # of the range of a joint that moves by itself
_LOW = 0.01  # of the height of an object: what is so near the floor may touch it
_INNER = 1 / 6  # of the rectangle of its feet: what lies farther inside stands, as boxes tell
_WELL = 0.1  # of its size: how far inside is well within
_STANDS = ("foot", "leg", "base", "stand", "wheel", "castor")  # words for what an object stands on
_NAMED = 4  # of the parts that an object stands on
_APART = 4  # of these, one in so many of what moves others, which takes a pose each
_BLOCK = 10_000  # links at a time, each in a state
_WAYS = tuple((np.cos(angle), np.sin(angle)) for angle in np.arange(8) * (np.pi / 4))


def find_falling(tree: Tree, body: Pieces) -> list[np.ndarray]:
    """For each ``require stable`` of the program, the indices of the objects that do not stand.

    Bounds of the masses decide most objects; where primitives overlap is measured for the others alone.
    """
    program, batch = tree.batch.program, tree.batch
    if not program.stable:
        return []
    whatever = any(statement.open for statement in program.stable)
    asked = np.zeros((len(program.stable), len(batch)), dtype=bool)
    for own, statement in zip(asked, program.stable, strict=True):
        own[batch.owner(statement.scope)] = True
    left = np.asarray(asked.any(axis=0))
    if "masses" in batch.known:
        still, tipped = Stance(tree, body, masses(batch)).verdicts(whatever, left)
    else:
        known = weighing(batch).rough
        stance = Stance(tree, body, known)
        still, stands = stance.decided(known, whatever)
        tipped, left = still.copy(), left & ~(still | stands)
        if left.any():
            stance.weigh(weighing(batch).masses(left))
            found = stance.verdicts(whatever, left)
            still, tipped = still | found[0], tipped | found[1]
    return [
        np.flatnonzero(own & (tipped if statement.open else still))
        for own, statement in zip(asked, program.stable, strict=True)
    ]


def find_toppling(tree: Tree, body: Pieces) -> list[np.ndarray]:
    """For each ``require stable`` of the program, the indices of the objects with narrow feet that do not stand at rest, by bounds of
    their masses alone; none unless half of the objects have such feet, so that of most programs nothing is weighed."""
    program, batch = tree.batch.program, tree.batch
    asked = np.zeros((len(program.stable), len(batch)), dtype=bool)
    for own, statement in zip(asked, program.stable, strict=True):
        own[batch.owner(statement.scope)] = True
    if asked.any():
        asked &= _narrow(tree, body)
    if 2 * asked.any(axis=0).sum() >= len(batch) > 0 and asked.any():
        rough = weighing(batch).rough
        asked &= Stance(tree, body, rough).decided(rough, False)[0]
        return [np.flatnonzero(own) for own in asked]
    return [np.zeros(0, dtype=np.int64) for _ in asked]


def find_unasked(tree: Tree, body: Pieces) -> bool:
    """Whether each of the objects tips over at rest, by bounds of their masses, on what is labelled as something to stand on, and
    nothing requires that they stand. Of other programs nothing is weighed."""
    batch = tree.batch
    program, tables = batch.program, batch.sites()
    standing = {
        program.sites[target.site].path
        for label in program.labels
        if label.vocabulary == "semantic" and label.name in _STANDS
        for target in label.targets
    }
    if program.stable or not standing or not _top_heavy(tree, body).all():
        return False
    meant = np.concatenate([np.full(len(table), table.path in standing) for table in tables])
    feet = find_feet(tree, body).piece
    on = np.zeros(len(batch), dtype=bool)
    on[body.owner[feet[meant[body.solid[feet]]]]] = True
    if not on.all():
        return False
    rough = weighing(batch).rough
    return bool(Stance(tree, body, rough).decided(rough, False)[0].all())


def _narrow(tree: Tree, body: Pieces) -> np.ndarray:
    """Which objects (B,) have a middle that is not well within the rectangle of what is near the floor, by boxes of pieces."""
    low, high, feet = _feet_boxes(tree, body)
    middle, spare = (low + high) / 2, _WELL * (high - low)
    return ~((feet[0] <= middle - spare) & (feet[1] >= middle + spare))[:, :2].all(axis=1)


def _top_heavy(tree: Tree, body: Pieces) -> np.ndarray:
    """Which objects (B,) have the middle of the boxes of their primitives, by volume, not well within that rectangle when it
    is tilted."""
    total, moment = np.zeros(len(tree.batch)), np.zeros((len(tree.batch), 3))
    for table in tree.batch.sites():
        low, high = table.boxes()
        volume = (high - low).prod(axis=1)
        np.add.at(total, table.owner, volume)
        np.add.at(moment, table.owner, volume[:, None] * (low + high) / 2)
    middle, (floor, _, feet) = moment / np.maximum(total, 1e-300)[:, None], _feet_boxes(tree, body)
    spare = TILT * (middle - floor)[:, 2:] + _INNER * (feet[1] - feet[0])
    return np.asarray(((feet[0] + spare > middle) | (feet[1] - spare < middle))[:, :2].any(axis=1))


def _feet_boxes(tree: Tree, body: Pieces) -> tuple[np.ndarray, np.ndarray, tuple[np.ndarray, np.ndarray]]:
    """The corners (B, 3) of the boxes of objects, and of what of each is near the floor."""
    shape = len(tree.batch), 3
    low, high, feet = np.full(shape, np.inf), np.full(shape, -np.inf), (np.full(shape, np.inf), np.full(shape, -np.inf))
    np.minimum.at(low, body.owner, body.low)
    np.maximum.at(high, body.owner, body.high)
    near = body.low[:, 2] <= low[body.owner, 2] + _LOW * (high - low)[body.owner, 2]
    np.minimum.at(feet[0], body.owner[near], body.low[near])
    np.maximum.at(feet[1], body.owner[near], body.high[near])
    return low, high, feet


def name_feet(tree: Tree, body: Pieces, owner: int) -> str:
    """The parts that an object stands on at rest, in words."""
    feet = distinct(find_feet(tree, body).piece)
    names = list(dict.fromkeys(part_name(tree, body, piece) for piece in feet[body.owner[feet] == owner].tolist()))
    more = len(names) - _NAMED
    told = any_of(names, "and") if more <= 1 else f"{', '.join(f'`{name}`' for name in names[:_NAMED])} and {more} more"
    return f"it stands on {told}, in object {tree.batch.numbers[owner]}"


class Stance:
    """Masses and feet of a batch."""

    def __init__(self, tree: Tree, body: Pieces, weights: Mass | Rough):
        self.tree = tree
        self.owner = tree.links.owner
        self.count = len(tree.batch)
        self.weigh(weights)
        feet = find_feet(tree, body)
        self.floor, self.link, self.point = feet.floor, body.link[feet.piece], feet.point  # by link, and so by object
        whose = self.owner[self.link]
        self.place = whose, np.arange(len(whose)) - np.searchsorted(whose, whose)  # (object, rank) of each point
        self.still = (tree.joint[tree.chain[self.link]] < 0) | (tree.chain[self.link] < 0)
        self.base = hulls(*self._padded(self.point, np.ones(self.count, dtype=bool)))

    def weigh(self, weights: Mass | Rough) -> None:
        self.mass, self.center = weights.mass, weights.center
        self.total = np.bincount(self.owner, self.mass, self.count)

    def verdicts(self, whatever: bool, asked: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Which of the objects ``asked`` (B,) bool do not stand, and which do not or, ``whatever`` their joints do, tip over."""
        still = (self.margin(self.tree.turn, self.tree.shift) < 0.0) & asked
        return still, still | self.tipping(asked & ~still) if whatever else still

    # ------------------------------------------------------------ bounds

    def decided(self, known: Rough, whatever: bool) -> tuple[np.ndarray, np.ndarray]:
        """Which objects (B,) do not stand, and which do, ``whatever`` their joints do, by bounds of their masses alone."""
        tree = self.tree
        whose = self.owner[known.link]
        least = self.total - np.bincount(whose, known.taken(known.most, np.ones(len(whose))), self.count)
        least = np.where(least > self.total / 10, least, 1e-30)  # what may be so light is not known
        place = apply(tree.turn[known.link], known.place) + tree.shift[known.link]
        center = self.centers(tree.turn, tree.shift)
        off = place - center[whose]
        far = np.sqrt(dot(off, off)) + known.radius
        moved = np.bincount(whose, known.taken(known.most * far, far), self.count)
        slack = _STEEP * moved / least + _ROUNDING
        margin = self.margin(tree.turn, tree.shift)
        falls, stands = margin < -slack, (margin > slack) & (not whatever)
        undecided = ~(falls | stands)
        if undecided.any():
            at = undecided[whose]
            tips, holds = self._over_edges(center, known.at(at), place[at], whatever, undecided)
            falls, stands = falls | (undecided & tips), stands | (undecided & holds)
        return falls, stands

    def _over_edges(
        self, center: np.ndarray, known: Rough, place: np.ndarray, whatever: bool, asked: np.ndarray
    ) -> tuple[np.ndarray, np.ndarray]:
        """Which of the objects ``asked`` (B,) bool do not stand at rest, and which stand for certain, ``whatever`` their joints do.

        Over an edge of the feet an object tips where the sum of its masses times how far inside they lie, less their height by
        the tangent of the tilt, is negative. Overlaps take away at most what they have and where they have most of it; each
        joint takes as much as it can by itself, and a little more for joints within that have moved what it carries. Below the
        floor a height counts as none, so that the sums without heights are asked, too.
        """
        tree, joints, whose = self.tree, self.tree.joints, self.owner[known.link]
        turn = np.abs(tree.turn[known.link])
        half, spare = apply(turn, known.half), np.zeros(self.count)
        ball, radius = place, known.radius
        values = np.zeros((len(joints.owner), 1, 3))
        if whatever:
            values = self._alone()[1]
            ball, radius = self._travel(known.link, place, known.radius)
            spare = self._nested(values * self.total[joints.owner][:, None, None])
        rests = radius == known.radius
        edge = np.roll(self.base, -1, axis=1) - self.base
        length = np.sqrt(edge[..., 0] ** 2 + edge[..., 1] ** 2)
        real = length > NEAR
        inward = np.stack([-edge[..., 1], edge[..., 0]], axis=-1) / np.where(real, length, 1.0)[..., None]
        stands, tips = real.any(axis=1), np.zeros(self.count, dtype=bool)
        stands[self.owner[self.link[~self.still.all(axis=1)]]] &= not whatever  # feet that move along
        machine = compiled()
        if machine is not None:
            edges = np.nonzero(real & asked[:, None])
            them = Standing(center, self.floor, self.total, spare, joints.owner, values)
            over = (known.row, known.own, place, half, ball, radius, rests, known.most, known.full)
            numbers = TILT, _STEEP, SAMPLED, _ROUNDING
            each = edges[0], self.base[edges], inward[edges]
            over_edges(machine, each, them, Overlaps(whose, *over), numbers, (stands, tips))
            return tips, stands
        for number in range(self.base.shape[1]):
            foot, normal = self.base[:, number], inward[:, number]
            for tilt in (TILT, 0.0):
                own = normal[joints.owner][:, None]
                gain = values[..., 0] * own[..., 0] + values[..., 1] * own[..., 1] - tilt * values[..., 2]
                rest = _beyond(center, foot, normal, self.floor, tilt)
                left = rest + np.bincount(joints.owner, gain.min(axis=1, initial=0.0), self.count)
                # of what rests in a box, no more than the box has; of what moves, all where it counts most
                of = foot[whose], normal[whose], self.floor[whose]
                middle = _beyond(place, *of, tilt)
                wide = np.abs(of[1][:, 0]) * half[:, 0] + np.abs(of[1][:, 1]) * half[:, 1] + tilt * half[:, 2]
                most = np.where(rests, middle + wide, _beyond(ball, *of, tilt) + _STEEP * radius)
                most = np.maximum(most, 0.0)
                lost = known.most * most
                whole = np.where(middle >= wide, middle, (middle + wide) ** 2 / np.maximum(4 * wide, 1e-300))
                lost = np.where(rests & (most > 0.0), np.minimum(lost, known.full * (whole + SAMPLED * wide)), lost)
                gone = np.bincount(whose, known.taken(lost, most), self.count)
                kept = left * self.total - gone - _STEEP * spare
                stands &= ~real[:, number] | (kept > _ROUNDING * self.total)
                if tilt:  # what lies outside of the edge at rest may all be lost
                    out = np.maximum(wide - middle, 0.0)
                    gained = np.bincount(whose, known.taken(known.most * out, out), self.count)
                    tips |= real[:, number] & (rest * self.total + gained < -_ROUNDING * self.total)
        return tips, stands

    def _chord(self) -> np.ndarray:
        """How far (J,) a point that is one metre from the axis of a joint is turned at most."""
        way = np.maximum(np.abs(self.tree.low - self.tree.joints.rest), np.abs(self.tree.high - self.tree.joints.rest))
        return np.where(self.tree.turns, 2.0 * np.sin(np.minimum(way, np.pi) / 2), 0.0)

    def _travel(self, link: np.ndarray, place: np.ndarray, radius: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Balls (n, 3), (n,) that hold balls on links wherever their joints put them, from rest.

        What turns stays within its chord from where it was, and within its distance from the axis.
        """
        tree, chord, place, radius = self.tree, self._chord(), place.copy(), radius.copy()
        way = np.maximum(np.abs(tree.low - tree.joints.rest), np.abs(tree.high - tree.joints.rest))
        along = np.where(tree.slides, 1.0, np.abs(tree.advance)) * np.where(tree.slides | tree.turns, way, 0.0)
        for level in range(tree.chain.shape[1]):
            joint, on = _above(tree, link, level)
            off = place[on] - tree.origin[joint]
            off -= tree.axis[joint] * dot(off, tree.axis[joint])[:, None]
            arm = np.sqrt(dot(off, off))
            near, about = radius[on] + chord[joint] * (arm + radius[on]), arm + radius[on]
            place[on] -= np.where((about < near)[:, None], off, 0.0)
            radius[on] = np.minimum(near, about) + along[joint]
        return place, radius

    def _nested(self, moved: np.ndarray) -> np.ndarray:
        """How much farther (B,), in kg m, joints may take what joints within, each by ``moved`` (J, S, 3), have moved; infinite
        for objects with joints that move others. What is moved along the axis of a turn stays where it is by that."""
        tree, joints, chord = self.tree, self.tree.joints, self._chord()
        wrong, within = np.zeros(len(chord)), np.zeros(len(chord))
        depth_of = (tree.chain[tree.child] >= 0).sum(axis=1)
        for level in distinct(depth_of)[::-1].tolist():  # the innermost first
            at = np.flatnonzero(depth_of == level)
            wrong[at] = chord[at] * within[at]
            for column in range(1, tree.chain.shape[1]):
                above, on = _above(tree, tree.child[at], column)
                own, axis = moved[at[on]], tree.axis[above][:, None]
                own = own - axis * dot(own, axis)[..., None]
                within += np.bincount(above, np.sqrt(dot(own, own)).max(axis=1) + wrong[at[on]], len(chord))
        wrong[~tree.alone] = np.inf
        return np.bincount(joints.owner, wrong, self.count)

    def _padded(self, points: np.ndarray, chosen: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Points (n, 3) of the objects ``chosen`` (B,) bool as (m, K, 2), and which of them stand on the floor (m, K)."""
        at = np.flatnonzero(chosen[self.place[0]])
        whose, rank = self.place[0][at], self.place[1][at]
        place = (np.cumsum(chosen) - 1)[whose], rank
        shape = int(chosen.sum()), int(rank.max(initial=0)) + 1
        flat, valid = np.zeros((*shape, 2)), np.zeros(shape, dtype=bool)
        flat[place] = points[at, :2]
        valid[place] = points[at, 2] <= self.floor[whose] + FLOOR
        return flat, valid

    def centers(self, turn: np.ndarray, shift: np.ndarray) -> np.ndarray:
        """Centres of mass (B, 3) of the objects with their links placed."""
        placed = (apply(turn, self.center) + shift) * self.mass[:, None]
        sums = np.stack([np.bincount(self.owner, placed[:, k], self.count) for k in range(3)], axis=-1)
        return sums / np.where(self.total > 0.0, self.total, 1.0)[:, None]

    def margin(self, turn: np.ndarray, shift: np.ndarray, chosen: np.ndarray | None = None) -> np.ndarray:
        """By how much (B,) the centres of mass lie within what is asked for, negative where they do not; 0 but for the objects
        ``chosen`` (B,) bool, by default all."""
        whose = np.arange(self.count) if chosen is None else np.flatnonzero(chosen)
        base = self.base[whose]
        if not self.still.all() and turn is not self.tree.turn:  # feet that move along
            back = multiply(turn, self.tree.turn.transpose(0, 2, 1))
            from_rest = shift - apply(back, self.tree.shift)
            points = apply(back[self.link], self.point) + from_rest[self.link]
            base = hulls(*self._padded(points, np.isin(np.arange(self.count), whose)))
        found = np.zeros(self.count)
        found[whose] = self._within(base, self.centers(turn, shift)[whose], whose)
        return found

    def _within(self, base: np.ndarray, center: np.ndarray, whose: np.ndarray) -> np.ndarray:
        height = np.maximum(center[:, 2] - self.floor[whose], 0.0)
        return depth(base, center[:, :2]) - TILT * height

    def tipping(self, asked: np.ndarray) -> np.ndarray:
        """Which of the objects ``asked`` (B,) bool tip over for some state of their joints."""
        tree, joints = self.tree, self.tree.joints
        rest = self.centers(tree.turn, tree.shift)
        bad = np.zeros(self.count, dtype=bool)
        values, moved = self._alone()
        moved = rest[joints.owner][:, None] + moved
        own = np.flatnonzero(asked[joints.owner])
        whose = joints.owner[own]
        for number in range(len(_SHARES)):
            bad[whose[self._within(self.base[whose], moved[own, number], whose) < 0.0]] = True
        moves_feet = np.zeros(len(joints.owner), dtype=bool)
        above = tree.chain[self.link]
        above = tree.joint[above[above >= 0]]
        moves_feet[above[above >= 0]] = True
        leading = (~tree.alone | moves_feet) & (asked & ~bad)[joints.owner]
        asking = lead_states(tree, leading, _SHARES[::_APART])
        size = max(1, _BLOCK // max(len(tree.above), 1))
        while block := list(islice(asking, size)):
            poses = tree.batch.pose(np.stack([states for _, states, _ in block]))
            for (lead, _, number), turn, shift in zip(block, *poses, strict=True):
                led = lead >= 0
                bad |= self.margin(turn, shift, led & ~bad) < 0.0
                moved[lead[led], _APART * number] = self.centers(turn, shift)[led]
        off = moved - rest[joints.owner][:, None]
        left = asked & ~bad
        if not left.any():
            return bad
        ways = (self._farthest(off[..., 0] * x + off[..., 1] * y, values) for x, y in _WAYS)
        while together := list(islice(ways, size)):
            for turn, shift in zip(*tree.batch.pose(np.stack(together)), strict=True):
                bad |= self.margin(turn, shift, left & ~bad) < 0.0
        return bad

    def _farthest(self, gain: np.ndarray, values: np.ndarray) -> np.ndarray:
        """Joint values (J,): each joint where it gains most (J, S) of its ``values`` (J, S), at rest where it gains nothing."""
        best = np.argmax(gain, axis=1) if len(gain) else np.zeros(0, dtype=np.int64)
        rows = np.arange(len(best))
        return np.where(gain[rows, best] > 0.0, values[rows, best], self.tree.joints.rest)

    def _alone(self) -> tuple[np.ndarray, np.ndarray]:
        """Values (J, S) of every joint, and how each moves the centre of mass (J, S, 3) by itself with what it carries."""
        tree, joints = self.tree, self.tree.joints
        count = len(joints.owner)
        carried, first = np.zeros(count), np.zeros((count, 3))
        placed = (apply(tree.turn, self.center) + tree.shift) * self.mass[:, None]
        for level in range(tree.chain.shape[1]):
            joint = tree.joint_above(np.arange(len(tree.joint)), level)
            on = np.flatnonzero(joint >= 0)
            carried += np.bincount(joint[on], self.mass[on], count)
            first += np.stack([np.bincount(joint[on], placed[on, k], count) for k in range(3)], axis=-1)
        middle = first / np.where(carried > 0.0, carried, 1.0)[:, None]
        share = carried / np.where(self.total > 0.0, self.total, 1.0)[joints.owner]
        values = tree.low[:, None] + _SHARES * (tree.high - tree.low)[:, None]
        moved = np.zeros((count, len(_SHARES), 3))
        arm = middle - tree.origin
        for number in range(len(_SHARES)):
            by = values[:, number] - joints.rest
            turned = apply(rotation_about(tree.axis, np.where(tree.turns, by, 0.0)), arm) - arm
            slid = tree.axis * (by * (tree.slides + tree.advance))[:, None]
            moved[:, number] = np.where(tree.alone[:, None], (turned + slid) * share[:, None], 0.0)
        return values, moved


def _beyond(point: np.ndarray, foot: np.ndarray, normal: np.ndarray, floor: np.ndarray, tilt: float) -> np.ndarray:
    """How far (k,) points (k, 3) lie beyond edges through ``foot`` (k, 2) along ``normal`` (k, 2), less their height by ``tilt``."""
    off = point[:, :2] - foot
    return off[:, 0] * normal[:, 0] + off[:, 1] * normal[:, 1] - tilt * (point[:, 2] - floor)


def _above(tree: Tree, link: np.ndarray, level: int) -> tuple[np.ndarray, np.ndarray]:
    """The joints so many levels above links (n,), and the places of the links that have one."""
    joint = tree.joint_above(link, level)
    on = np.flatnonzero(joint >= 0)
    return joint[on], on
