"""From nothing to the best candidates: drawn, chosen by their boxes and clouds, and refined."""

from __future__ import annotations

import numpy as np

from ..geometry.sites import object_boxes
from ..geometry.vectors import corners
from ..records import dataclass
from .compare import Candidates, Targets, clouds, words_of
from .match import features, nearest, squared
from .model import Model, Placed
from .outer import outer
from .refine import Schedule, refine
from .repeats import held
from .states import tables
from .words import OTHER, unlike

_SIZES = 0.15  # what a difference of boxes counts beside one of clouds of equal boxes: diagonals for a factor of e
_RIVAL = 1.5  # a candidate is no rival that is farther off than the best by this factor
_COARSE = 192  # points of a candidate and of a target, where thousands are compared


@dataclass(frozen=True, slots=True)
class Effort:
    """How much is tried: ``drawn`` candidates, of which ``looked`` at for each target; ``kept`` structures are refined by
    ``first``, ``best`` of them by ``more``, two of these by ``near``. Then elements of repeats are put together from ``copies`` of each
    candidate, and every other value of choices and counts is drawn ``lanes`` times, in ``rounds`` at most; of each object ``tried``
    copies are refined by ``part``, and ``developed`` of those that change much by ``whole``, as are ``once`` of what stands once. What is left
    is refined by ``last``."""

    drawn: int = 4000
    looked: int = 500
    kept: int = 24
    best: int = 6
    rounds: int = 6
    lanes: int = 2
    tried: int = 12
    developed: int = 3
    once: int = 6
    copies: int = 64
    first: Schedule = Schedule(5, 384, (0.06, 0.02))
    more: Schedule = Schedule(6, 512, (0.03, 0.008))
    near: Schedule = Schedule(4, 1024, (0.012, 0.006))
    part: Schedule = Schedule(3, 576, (0.03, 0.008))
    whole: Schedule = Schedule(4, 1536, (0.012, 0.004))
    last: Schedule = Schedule(12, 3072, (0.006, 0.0015))


def search(model: Model, targets: Targets, effort: Effort, seed: int = 0) -> tuple[Candidates, Candidates]:
    """The best candidate of each object: one row each; and of some objects a rival, of which a mean distance cannot tell yet: it has repeats
    that the best has not, and their elements are still as they were drawn. Raises UserError where nothing is drawn that can be one."""
    found = _chosen(model, targets, effort, seed)
    found = refine(model, targets.first(512), found, effort.first)
    kept = best(model, found, targets, effort.best)
    others = _rivals(model, found, best(model, kept, targets, 1), targets)
    both = refine(model, targets.first(768), united(model, [kept, others]), effort.more)
    found, others = (taken(model, both, at) for at in np.split(np.arange(len(both)), [len(kept)]))
    found = refine(model, targets.first(1024), best(model, found, targets, 2), effort.near)
    found = best(model, found, targets, 1)
    return found, _rivals(model, others, found, targets)


def _rivals(model: Model, found: Candidates, first: Candidates, targets: Targets) -> Candidates:
    """Of each object the best candidate, if there is one, that has repeats which the ``first``, one of each object, has not, that is seen
    from the same side and not much farther off."""
    own, others = held(model, first.batch), held(model, found.batch)
    at = targets.of[found.target]
    rival = (
        (others & ~own[at]).any(axis=1) & (found.target == first.target[at]) & (found.score < _RIVAL * first.score[at])
    )
    some = np.flatnonzero(rival)
    return taken(model, found, some[best_of(np.zeros(len(some), dtype=np.uint64), at[some], found.score[some], 1)])


def taken(model: Model, found: Candidates, at: np.ndarray) -> Candidates:
    """Some of the candidates."""
    return Candidates(model.assembled([(found.batch, at)]), found.target[at], found.placed.take(at), found.score[at])


def united(model: Model, several: list[Candidates]) -> Candidates:
    """All candidates of several sets."""
    batch = model.assembled([(one.batch, np.arange(len(one))) for one in several])
    placed = Placed.joined([one.placed for one in several])
    target, score = (np.concatenate([getattr(one, name) for one in several]) for name in ("target", "score"))
    return Candidates(batch, target, placed, score)


def replaced(model: Model, old: Candidates, new: Candidates) -> Candidates:
    """One candidate of each object, in their order: a new one where there is one."""
    both = united(model, [taken(model, old, np.setdiff1d(old.target, new.target)), new])
    return taken(model, both, np.argsort(both.target, kind="stable"))


def best(model: Model, found: Candidates, targets: Targets, count: int) -> Candidates:
    """The ``count`` best structures of each object, one candidate each, the best first."""
    return taken(model, found, best_of(model.structures(found.batch), targets.of[found.target], found.score, count))


def best_of(structure: np.ndarray, owner: np.ndarray, score: np.ndarray, count: int) -> np.ndarray:
    """Places of the best of each structure, ``count`` of each owner, by owner and score."""
    order = np.lexsort((np.arange(len(score)), score, owner))
    pair = np.stack([owner[order].astype(np.uint64), structure[order]])
    _, first = np.unique(pair, axis=1, return_index=True)
    kept = order[np.sort(first)]
    start = np.searchsorted(owner[kept], owner[kept])
    return kept[np.arange(len(kept)) - start < count]


def _chosen(model: Model, targets: Targets, effort: Effort, seed: int) -> Candidates:
    """The best of many drawn candidates for each object: of those whose boxes come nearest, those whose clouds do when their boxes
    are made equal."""
    drawn = model.valid(effort.drawn, seed, effort.looked)
    low, high = object_boxes(tables(drawn), len(drawn))
    size = np.maximum(high - low, 1e-6)
    differ = np.log(size)[None] - np.log(np.maximum(targets.size, 1e-6))[:, None]  # (T, N, 3)
    differ = differ - np.where(targets.known[:, None], 0.0, differ.mean(axis=2))[:, :, None]
    boxes = np.abs(differ).sum(axis=2)
    near = np.argsort(boxes, axis=1, kind="stable")[:, : effort.looked]
    wanted, place = np.unique(near, return_inverse=True)
    looked = model.assembled([(drawn, wanted)])
    points = clouds(looked, _COARSE)
    position, normal = points.position, points.normal
    hidden, word = ~outer(position), words_of(looked, points, targets.meant)
    low, high = corners(position)
    unit = (position - low[:, None]) / np.maximum(high - low, 1e-9)[:, None]
    coarse = targets.first(_COARSE)
    score = np.empty(near.shape)
    one = np.ones((1, 1))
    for number in range(len(targets)):  # of orientations and objects, each a batch of hundreds
        at = place.reshape(near.shape)[number]
        scale = targets.size[number] / targets.diagonal[number]
        cloud = (coarse.points[number] - targets.low[number]) / targets.diagonal[number]
        mine = features(unit[at] * scale, normal[at], one, hidden[at])
        theirs = features(cloud[None], coarse.normals[number][None], one)
        words = word[at], np.broadcast_to(coarse.word[number], (len(at), theirs.shape[1]))
        asked = np.broadcast_to(theirs, (len(at), *theirs.shape[1:]))
        there, here = nearest(mine, asked, words, targets.meant)
        every = np.arange(len(at))[:, None]
        others = unlike(words[0][every, there], words[1]), unlike(words[0], words[1][every, here])
        forth = np.sqrt(squared(mine[every, there] - theirs) + OTHER**2 * others[0])
        back = np.sqrt(squared(mine - theirs[0][here]) + OTHER**2 * others[1])
        back = np.where(hidden[at], 0.0, back).sum(axis=1) / np.maximum((~hidden[at]).sum(axis=1), 1)
        score[number] = forth.mean(axis=1) + back + _SIZES * boxes[number, near[number]]
    target = np.repeat(np.arange(len(targets)), near.shape[1])
    at = place.reshape(near.shape).ravel()
    structure = model.structures(looked)[at]
    kept = best_of(structure, targets.of[target], score.ravel(), effort.kept)
    batch = model.assembled([(looked, at[kept])])
    target = target[kept]
    low, high = low[at[kept]], high[at[kept]]
    known = targets.known[target]
    across = np.sqrt(((high - low) ** 2).sum(axis=1))
    factor = np.where(known, 1.0, targets.diagonal[target] / across)
    middle = (targets.low[target] + targets.high[target]) / 2 - factor[:, None] * (low + high) / 2
    middle[:, 2] = targets.low[target, 2] - factor * low[:, 2]
    return Candidates(batch, target, Placed(factor, middle), score.ravel()[kept])
