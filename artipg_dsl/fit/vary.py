"""Numbers moved by large parts of their ranges, like choices: what moves a surface along itself has no gradient.

The legs of a cupboard are 4 cm too short. No point of them is off, and the ends of the true ones are too far away to count. So numbers that
least squares do not hold are tried elsewhere, and all others follow so that what these do hold stays where it is: as the legs grow, the
cupboard grows too, and stands lower. Copies are weighed by whole clouds, as those with other choices are.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from ..geometry.runs import runs
from ..records import dataclass
from .compare import Candidates, Compared, Targets, compare
from .develop import SURE, apart
from .evidence import LARGE, Clouds, Copies, Evidence, weigh, weigh_again, weigh_change
from .model import Changes, Freedoms, Model, Placed
from .products import crossed
from .refine import PLACE, derivatives, equations
from .search import replaced

_BY = (0.12, 0.36), (0.06, 0.18)  # of their ranges numbers are moved, up and down, in two rounds
_FIRM = 1e-2  # diagonals: a number whose range moves what least squares hold by more than this, at the root mean square, is held by them
_SHOWN = 3e-3  # diagonals: a visible point that its range moves by less stays,
_PART = 0.12  # and if it moves more of them than this, copies have too few points to judge it
_SMALL = 5e-4  # diagonals: numbers that would follow by less stay; where primitives differ by less, least squares will mend it
_WEAK = 1e-6  # what holds followers that nothing depends on where they are
_POINTS, _WIDTH = 1536, 0.006  # by which it is told what least squares hold
_BLOCK = 96  # copies at a time
_MOST = 12  # numbers of an object that are moved together, at most


def varied(model: Model, own: Targets, found: Candidates, clouds: Clouds) -> Candidates:
    """The candidates, one for each of the targets ``own``, with those numbers elsewhere for which the clouds speak."""
    now = found
    for by in _BY:
        found = _likelier(model, own, found, clouds, np.array(by))
        if not len(found):
            break
        now = replaced(model, now, found)
    return now


def _likelier(model: Model, own: Targets, found: Candidates, clouds: Clouds, by: np.ndarray) -> Candidates:
    """Those of the candidates that become likelier by moving numbers ``by`` some of their ranges, moved."""
    ways = Ways.of(model, own, found)
    at, moves = ways.tried(by)
    of, base = ways.free.owner[at], weigh(found.batch, found.target, found.placed, clouds)
    loss = np.full(len(at), np.inf)
    for start in range(0, len(at), _BLOCK):
        part = slice(start, start + _BLOCK)
        copies = ways.copies(model, found, of[part], moves[part])
        loss[part] = _loss(model, own, found, clouds, base, copies, again=False)
    good = np.flatnonzero(loss < -SURE)
    good = good[np.lexsort((loss[good], at[good]))]
    good = good[np.unique(at[good], return_index=True)[1]]  # of each number one value
    good = good[np.lexsort((loss[good], of[good]))]
    rank = np.arange(len(good)) - np.searchsorted(of[good], of[good])
    good, rank = good[rank < _MOST], rank[rank < _MOST]
    sums = np.zeros((len(found), _MOST, ways.way.shape[1]))
    sums[of[good], rank] = moves[good]
    sums = sums.cumsum(axis=1)  # the likeliest, the likeliest two, three and so on
    joined = ways.copies(model, found, of[good], sums[of[good], rank])
    loss = _loss(model, own, found, clouds, base, joined, again=True)
    order = np.lexsort((loss, of[good]))
    best = order[np.unique(of[good][order], return_index=True)[1]]
    best = best[loss[best] < -SURE]
    placed = joined.placed.take(best)
    return Candidates(model.assembled([(joined.batch, best)]), joined.target[best], placed, np.zeros(len(best)))


def _loss(
    model: Model, own: Targets, found: Candidates, clouds: Clouds, base: Evidence, copies: Copies, *, again: bool
) -> np.ndarray:
    """(K,) by how much copies are less likely than what they were made of; inf where they do not differ, or cannot be, or where they differ
    by too much for their few points, unless they are weighed ``again``, with as many points of both."""
    within = _SMALL * own.diagonal[copies.target]
    anywhere = apart(found, copies, within).anywhere(len(copies.of)) & ~copies.batch.state.failed
    some, loss = np.flatnonzero(anywhere), np.full(len(copies.of), np.inf)
    if not len(some):
        return loss
    less = Copies(
        model.assembled([(copies.batch, some)]), copies.of[some], copies.target[some], copies.placed.take(some)
    )
    change = apart(found, less, within[some])
    if again:
        origins = replace(less, batch=model.assembled([(found.batch, less.of)]), placed=found.placed.take(less.of))
        loss[some] = weigh_again(less, origins, clouds, base, change).loss
    else:
        told = weigh_change(less, clouds, base, change)
        loss[some] = np.where(told.share <= LARGE, told.loss, np.inf)
    return loss


@dataclass(frozen=True, slots=True, eq=False)
class Ways:
    """How all of a candidate follows one of its numbers, ``free`` (n,). ``way`` (n, P): a shift along three axes (metres), a scale, and all
    numbers (ranges), as this one moves by its range; ``reach`` (n, P): how far each of these moves any point, in diagonals. ``held`` (n,): how
    far what least squares hold is moved, in diagonals; ``part`` (n,) of the visible points is moved."""

    free: Freedoms
    way: np.ndarray
    reach: np.ndarray
    held: np.ndarray
    part: np.ndarray

    @staticmethod
    def of(model: Model, own: Targets, found: Candidates) -> Ways:
        targets, free = own.first(2048), model.freedoms(found.batch)
        now = compare(found.batch, found.target, found.placed, targets, _POINTS)
        none, every = np.zeros((len(found), 0, 3, _POINTS)), np.ones(len(found), dtype=bool)
        steps = derivatives(model, found.batch, now, free, none, every)
        matrix, _ = equations(targets, found.target, found.placed, now, free, steps, np.full(len(found), _WIDTH))
        way, reach = (np.zeros((len(free), matrix.shape[1])) for _ in range(2))
        held, part = np.zeros(len(free)), np.zeros(len(free))
        many = np.bincount(free.owner, minlength=len(found))
        for k in range(len(found)):  # one at a time, since others beside it would change how it is rounded
            mine, size = np.flatnonzero(free.owner == k), PLACE + many[k]
            inverse = np.linalg.inv(matrix[k, :size, :size] + _WEAK * np.eye(size))
            own_part = np.diag(inverse)[PLACE:]
            way[mine, :size] = inverse[PLACE:] / own_part[:, None]
            rest = _WEAK * (way[mine] ** 2).sum(axis=1)
            held[mine] = np.sqrt(np.maximum(1.0 / own_part - rest, 0.0))
            moved = found.placed.scale[k] * steps[k, : many[k]]
            diagonal = targets.diagonal[found.target[k]]
            reach[mine, :size] = _reach(moved, diagonal)
            part[mine] = _part(way[mine, :size], moved, now, k, diagonal)
        return Ways(free, way, reach, held, part)

    def tried(self, by: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Numbers (m,), each moved up and down ``by`` some of its range, as far as there is room; how all of its candidate moves (m, P)."""
        free = self.free
        some = np.flatnonzero((self.held < _FIRM) & (self.part > 0.0) & (self.part < _PART))
        at, by = np.repeat(some, 2 * len(by)), np.tile(np.concatenate([-by, by]), len(some))
        value = np.clip(free.value[at] + by * free.width[at], free.low[at], free.high[at])
        far = (value - free.value[at]) / free.width[at]
        at_far = np.unique(np.stack([at, far])[:, np.abs(far) > 0.3 * np.abs(by).min(initial=1.0)], axis=1)
        at, far = at_far[0].astype(np.int64), at_far[1]
        return at, self.moves(at, far)

    def moves(self, at: np.ndarray, by: np.ndarray) -> np.ndarray:
        """(m, P) how all moves as numbers ``at`` (m,) move ``by`` (m,) their ranges; what would follow by little stays."""
        moves = self.way[at] * by[:, None]
        return np.where(np.abs(moves) * self.reach[at] < _SMALL, 0.0, moves)

    def copies(self, model: Model, found: Candidates, of: np.ndarray, moves: np.ndarray) -> Copies:
        """Copies of candidates ``of`` which (m,), in which all moves so (m, P)."""
        free = self.free
        many = np.bincount(free.owner, minlength=len(found))
        row, copy = runs((np.cumsum(many) - many)[of], many[of]), np.repeat(np.arange(len(of)), many[of])
        step = moves[copy, PLACE + free.place[row]]
        moved = np.flatnonzero(step)
        row, copy = row[moved], copy[moved]
        value = np.clip(free.value[row] + step[moved] * free.width[row], free.low[row], free.high[row])
        batch = model.altered(found.batch, of, Changes(copy, free.draw[row], free.row[row], value))
        placed = found.placed.take(of)
        placed = Placed(placed.scale * np.exp(moves[:, PLACE - 1]), placed.shift + moves[:, : PLACE - 1])
        return Copies(batch, of, found.target[of], placed)


def _reach(moved: np.ndarray, diagonal: float) -> np.ndarray:
    """(P,) how far a shift of a metre, a scale of e and each number move any point, in diagonals; ``moved`` (numbers, 3, n) by the latter."""
    numbers = np.sqrt((moved**2).sum(axis=1)).max(axis=1, initial=0.0) / diagonal
    return np.concatenate([np.full(PLACE - 1, 1.0 / diagonal), [1.0], numbers])


def _part(way: np.ndarray, moved: np.ndarray, now: Compared, k: int, diagonal: float) -> np.ndarray:
    """(m,) what part of the visible points of a candidate is moved in each of some ways (m, P)."""
    seen = np.flatnonzero(~now.hidden[k])
    points = np.moveaxis(moved[:, :, seen], 0, -1).reshape(3 * len(seen), len(moved))
    off = crossed(way[:, PLACE:], points).reshape(len(way), 3, len(seen)) + way[:, : PLACE - 1, None]
    far = np.sqrt((off**2).sum(axis=1)) / diagonal
    return np.asarray((far > _SHOWN).sum(axis=1) / max(len(seen), 1))
