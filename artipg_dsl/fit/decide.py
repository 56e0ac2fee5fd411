"""Choices and counts decided by the whole cloud, where the mean distance cannot tell.

The elements of repeats are put together anew first. Then each other value of each choice and count is tried in copies of what was found,
for which new parts are drawn. Copies are compared with their origin by the points of both, and of the cloud, that lie where they differ. The
most promising ones move their new parts into place, the rest of the object being held, and the object takes all the changes for which the
cloud speaks. Where it gains little by them, changes of much of the object are developed; where nothing changes any more, so is what stands
once: a board on top is unlikely until the height of what it lies on makes room for it.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from ..random import mix
from ..records import dataclass
from ..runtime.batch import Batch
from .arrange import rearranged
from .compare import Candidates, Targets, compare
from .develop import SURE, apart, copied, developed
from .evidence import LARGE, Asked, Change, Clouds, Copies, Evidence, beside, weigh, weigh_again, weigh_change
from .model import Model, Placed
from .refine import refine
from .search import Effort, best_of, replaced, taken, united
from .tries import tries
from .vary import varied

_LITTLE = 3.0 * SURE  # where changes make a cloud likelier by less, large ones are developed as well
_HOPE = 300.0  # what is less likely by more than this is not refined,
_HOPED = 0.6  # nor what is by more than this share of all that speaks against the object
_DOUBT = 1.0  # a candidate has rivals if more than this speaks against it, for each point of a cloud;
_MUCH = 0.5  # one takes its place if less than this share of that speaks against the rival
_ONCE = LARGE / 4.0  # of the surface: what changes less of it is no reason for all else to move
_COUNTS = 2.0  # what the odds of values count beside what points say, which are no witnesses independent of each other
_SLIGHT = 5e-3  # of the surface: what changes more of it needs evidence
_INCLINED = 1.0  # by so much small changes have to be likelier at last,
_EVEN = 6.0  # and by so much where the text has both as often
_LOOKS = 3  # at small changes, as long as some are made
_MOST = 0.75  # of the points,
_CLOUD, _OWN = 6144, 3072  # of which so many tell
_WHOLE = 512  # points of a cloud by which a copy is refined: those of all of it, and of where it differs
_THERE = 256


def decide(
    model: Model, targets: Targets, found: Candidates, effort: Effort, rivals: Candidates | None = None
) -> Candidates:
    """What was found, one candidate of each object, or its rival, with the choices and counts for which the whole clouds speak."""
    own = targets.take(found.target)
    clouds = Clouds(own)
    now, still = replace(found, target=np.arange(len(found))), np.arange(len(found))
    now = replaced(model, now, rearranged(model, own, now, clouds, effort))
    if rivals is not None and len(rivals):
        theirs = replace(rivals, target=np.searchsorted(found.target, rivals.target))
        now = replaced(model, now, _likelier(model, own, now, clouds, theirs, effort))
    looked = np.zeros(0, dtype=np.uint64)
    for number in range(effort.rounds):
        some = taken(model, now, still)
        base = weigh(some.batch, some.target, some.placed, clouds)
        tried = _likeliest(model, some, clouds, base, effort, number)
        if not len(tried.copies.of):
            break
        copies = settled(model, own, some, tried.copies, tried.told, effort)
        change = weigh_again(copies, _origins(model, some, copies), clouds, base, apart(some, copies))
        better, loss = _better(model, some, clouds, base, copies, change)
        last = number + 1 == effort.rounds
        rest = np.flatnonzero((loss > -_LITTLE) | last)
        quiet = better.target[(loss > -SURE) | last]
        every = tried.others.behind(model, copies, change, tried.name)
        at = _promising(every, better.target[rest], quiet, looked, effort)
        rivals, looked = every.candidates(model, at), np.concatenate([looked, every.name[at]])
        grown = developed(model, own, taken(model, better, rest), clouds, rivals, effort)
        sure = np.flatnonzero((loss < -SURE) & ~np.isin(better.target, grown.target))
        changed = united(model, [taken(model, better, sure), grown])
        still = np.sort(changed.target)
        if not len(still):
            break
        now = replaced(model, now, changed)
    return replace(varied(model, own, now, clouds), target=found.target)


def _likelier(
    model: Model, own: Targets, found: Candidates, clouds: Clouds, rivals: Candidates, effort: Effort
) -> Candidates:
    """The rivals of candidates, one for each of the targets ``own``, that explain much more once their elements are put together. Less will
    not do, as choices of the candidates are still to be decided."""
    one = taken(model, found, rivals.target)
    was = weigh(one.batch, one.target, one.placed, clouds).total
    doubtful = np.flatnonzero(was > _DOUBT * clouds.count(one.target))
    if not len(doubtful):
        return taken(model, rivals, doubtful)
    of, every = rivals.target[doubtful], np.arange(len(doubtful))
    mine, new = own.take(of), replace(taken(model, rivals, doubtful), target=every)
    theirs = Clouds(mine)
    new = replaced(model, new, rearranged(model, mine, new, theirs, effort))
    told = weigh(new.batch, every, new.placed, theirs).total
    return taken(model, replace(new, target=of), np.flatnonzero(told < _MUCH * was[doubtful]))


def inclined(model: Model, closely: Targets, found: Candidates, effort: Effort) -> Candidates:
    """The candidates, one of each object, with those small changes for which the clouds speak a little, or nothing speaks but that the text
    has such objects more often. ``closely``: the cloud of each candidate with nearly all of its points, as of fewer a hinge has two. Where an
    object is off, so are its parts. That counts as noise: the mean, or how far most of it is off where that is less, as few points far off make
    up a mean."""
    told = compare(found.batch, np.arange(len(found)), found.placed, closely.first(_CLOUD), _OWN)
    off = np.minimum(found.score, told.within(_MOST))
    clouds = Clouds(replace(closely, noise=np.maximum(closely.noise, off)), closely=True)
    now, still = replace(found, target=np.arange(len(found))), np.arange(len(found))
    for number in range(_LOOKS):
        some = taken(model, now, still)
        better = _inclined(model, closely, some, clouds, effort, effort.rounds + number)
        changed = np.flatnonzero(model.structures(better.batch) != model.structures(some.batch))
        if not len(changed):
            break
        now, still = replaced(model, now, taken(model, better, changed)), better.target[changed]
    return replace(now, target=found.target)


def _inclined(model: Model, own: Targets, found: Candidates, clouds: Clouds, effort: Effort, number: int) -> Candidates:
    """The candidates, one of each object, with the small changes of one round."""
    base = weigh(found.batch, found.target, found.placed, clouds)
    tried = _likeliest(model, found, clouds, base, effort, number, _COUNTS)
    if not len(tried.copies.of):
        return found
    copies, odds = settled(model, own, found, tried.copies, tried.told, effort), tried.odds
    change = weigh_again(copies, _origins(model, found, copies), clouds, base, apart(found, copies))
    slight = change.share <= _SLIGHT
    need = np.where(slight & (odds > 0.0), _INCLINED, np.where(slight & (odds == 0.0), _EVEN, SURE))
    change = replace(change, loss=change.loss + need - _INCLINED)
    odds = np.where(slight, np.maximum(odds, 0.0), 0.0)
    return _better(model, found, clouds, base, copies, change, odds, _INCLINED)[0]


def settled(model: Model, own: Targets, found: Candidates, copies: Copies, told: Asked, effort: Effort) -> Copies:
    """Copies whose new parts have moved to where the cloud has them, all else being held."""
    marked = apart(found, copies).new
    asked = Candidates(copies.batch, np.arange(len(copies.of)), copies.placed, np.zeros(len(copies.of)))
    moved = refine(model, _views(own, copies.target, told), asked, effort.part, marked)
    return replace(copies, batch=moved.batch)


def _origins(model: Model, found: Candidates, copies: Copies) -> Copies:
    """What each copy was made of."""
    return replace(copies, batch=model.assembled([(found.batch, copies.of)]), placed=found.placed.take(copies.of))


def _better(
    model: Model,
    found: Candidates,
    clouds: Clouds,
    base: Evidence,
    copies: Copies,
    change: Change,
    odds: np.ndarray | None = None,
    sure: float = SURE,
) -> tuple[Candidates, np.ndarray]:
    """Each candidate with those of the changes for which the cloud, and ``odds`` (K,), speak that are likeliest together; and by how much it is
    less likely than before. Of changes of much of an object whole candidates tell; where these refuse them, small ones are made."""
    loss, every = np.zeros(len(found)), np.arange(len(found))
    odds = np.zeros(len(change.loss)) if odds is None else odds
    alone = change.loss - odds
    good = np.flatnonzero(alone < -sure)
    if not len(good):
        return found, loss
    good = good[np.lexsort((alone[good], copies.of[good]))]
    of, joined = nested_sets(copies.of[good], change.share[good] <= LARGE)
    made, one = np.nonzero(joined)
    others = model.assembled([(copies.batch, good[one])])
    tried = copied(found, model.merged(model.assembled([(found.batch, of)]), others, made, one), of)
    told = weigh_again(tried, _origins(model, found, tried), clouds, base, apart(found, tried))
    less = np.where(tried.batch.state.failed, np.inf, told.loss - joined @ odds[good])
    some = Candidates(tried.batch, tried.target, tried.placed, np.zeros(len(of)))
    best = _least(of, less)
    large = best[told.share[best] > LARGE]
    if len(large):
        whole = taken(model, some, large)
        less[large] = beside(weigh(whole.batch, whole.target, whole.placed, clouds), base, of[large])
        refused = large[less[large] >= -sure]
        less[(told.share > LARGE) & np.isin(of, of[refused])] = np.inf
        best = _least(of, less)
    best = best[less[best] < -sure]
    loss[of[best]] = less[best]
    every[of[best]] = len(found) + best
    return taken(model, united(model, [found, some]), every), loss


def nested_sets(of: np.ndarray, small: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Of changes (n,) of candidates, the likeliest first: the sets that are tried, as the candidate of each (m,) and which changes it has
    (m, n). These are the likeliest one, two, three and so on of all, and of the ``small`` ones (n,)."""
    found = []
    for at in (np.arange(len(of)), np.flatnonzero(small & np.isin(of, of[~small]))):
        mine = of[at]
        rank = np.arange(len(at)) - np.searchsorted(mine, mine)
        joined = np.zeros((len(at), len(of)), dtype=bool)
        joined[:, at] = (mine[:, None] == mine) & (rank <= rank[:, None])
        found.append((mine, joined))
    return np.concatenate([mine for mine, _ in found]), np.concatenate([joined for _, joined in found])


def _least(of: np.ndarray, less: np.ndarray) -> np.ndarray:
    """Places of the least value of each owner."""
    order = np.lexsort((less, of))
    return order[np.unique(of[order], return_index=True)[1]]


@dataclass(frozen=True, slots=True, eq=False)
class _Known:
    """``copies`` (K,) of what was found, each with another value; their ``loss`` (K,), and the ``share`` (K,) of their surface that differs.
    ``name`` (K,): a number for the object and the value, 0 where the draw repeats. ``moved`` (K,): whether new parts have moved into place."""

    copies: Copies
    loss: np.ndarray
    share: np.ndarray
    name: np.ndarray
    moved: np.ndarray

    def behind(self, model: Model, copies: Copies, change: Change, name: np.ndarray) -> _Known:
        """These behind ``copies`` that have moved, of which ``change`` tells."""
        two = copies, self.copies
        of, target = (np.concatenate([getattr(one, column) for one in two]) for column in ("of", "target"))
        batch = model.assembled([(one.batch, np.arange(len(one.of))) for one in two])
        both = Copies(batch, of, target, Placed.joined([one.placed for one in two]))
        loss, share = (np.concatenate([getattr(one, column) for one in (change, self)]) for column in ("loss", "share"))
        return _Known(both, loss, share, np.concatenate([name, self.name]), np.arange(len(of)) < len(copies.of))

    def candidates(self, model: Model, at: np.ndarray) -> Candidates:
        """Some of them as candidates."""
        one = self.copies
        return Candidates(model.assembled([(one.batch, at)]), one.target[at], one.placed.take(at), np.zeros(len(at)))


@dataclass(frozen=True, slots=True, eq=False)
class _Tried:
    """The ``copies`` (K,) of what was found, each with another value, that are likeliest as drawn; the points of clouds that tell of them; what
    speaks for them besides: the ``odds`` (K,); and their ``name`` (K,), as ``_Known`` has it. ``others``, as drawn, of draws that do not
    repeat."""

    copies: Copies
    told: Asked
    odds: np.ndarray
    name: np.ndarray
    others: _Known


def _promising(known: _Known, rest: np.ndarray, quiet: np.ndarray, looked: np.ndarray, effort: Effort) -> np.ndarray:
    """Places of what is developed: of the objects ``rest`` the most promising large changes among those that have moved, and of those that
    are ``quiet`` also changes of what stands once, but for those ``looked`` at before."""
    target, name, share = known.copies.target, known.name, known.share
    large = np.flatnonzero(known.moved & (share > LARGE) & np.isin(target, rest))
    large = _first(large, target, known.loss, effort.developed)
    once = (name > 0) & (share > _ONCE) & np.isin(target, quiet) & ~np.isin(name, looked)
    once[large] = False
    at = np.concatenate([large, _first(np.flatnonzero(once), target, known.loss, effort.once)])
    return at[np.argsort(~known.moved[at], kind="stable")]


def _first(at: np.ndarray, target: np.ndarray, loss: np.ndarray, count: int) -> np.ndarray:
    """Of some places ``at``, the ``count`` of each target that are least unlikely."""
    at = at[np.lexsort((loss[at], target[at]))]
    return at[np.arange(len(at)) - np.searchsorted(target[at], target[at]) < count]


def _likeliest(
    model: Model, found: Candidates, clouds: Clouds, base: Evidence, effort: Effort, number: int, counts: float = 0.0
) -> _Tried:
    """The likeliest copies as drawn, ``counts`` being what the odds of values count."""
    batches: list[Batch] = []
    asked: list[Asked] = []
    stood = [found.placed.take(np.zeros(0, dtype=np.int64))]
    owners, losses, places = [np.zeros(0, dtype=np.int64)], [np.zeros(0)], [np.zeros(0, dtype=np.uint64)]
    odds, shares, names = [np.zeros(0)], [np.zeros(0)], [np.zeros(0, dtype=np.uint64)]
    single = np.array([not found.batch.rowmap.ranks(draw.column.scope) for draw in model.program.draws])
    for one in tries(model, found.batch, effort.lanes, 1 + number * effort.lanes):
        copies = copied(found, one.batch, one.of)
        change = weigh_change(copies, clouds, base, apart(found, copies))
        stood.append(copies.placed)
        batches.append(one.batch)
        asked.append(change.told)
        owners.append(one.of)
        losses.append(np.where(change.share <= LARGE, change.loss, np.inf) if clouds.closely else change.loss)
        places.append(one.places(each=clouds.closely))
        odds.append(counts * one.odds)
        shares.append(change.share)
        name = mix(mix(found.target[one.of].astype(np.uint64), one.draw), one.value.view(np.uint64))
        names.append(np.where(single[one.draw], name, np.uint64(0)))
    of, loss, place, more, share, name = (
        np.concatenate(column) for column in (owners, losses, places, odds, shares, names)
    )
    loss = np.asarray(loss - more)
    structure = np.concatenate([np.zeros(0, dtype=np.uint64), *map(model.structures, batches)])
    told = Asked.joined(asked or [Asked.none()])
    hopeful = np.flatnonzero(loss < np.maximum(_HOPE, _HOPED * base.total[of]))
    first = hopeful[best_of(place[hopeful], of[hopeful], loss[hopeful], len(hopeful))]
    at = first[best_of(structure[first], of[first], loss[first], effort.tried)]
    once = np.flatnonzero((name > 0) & (loss < base.total[of]))
    once = np.setdiff1d(once[best_of(name[once], of[once], loss[once], len(once))], at)
    copies, others = (
        Copies(_picked(model, found, batches, some), of[some], found.target[of[some]], Placed.joined(stood).take(some))
        for some in (at, once)
    )
    still = np.zeros(len(once), dtype=bool)
    return _Tried(copies, told.take(at), more[at], name[at], _Known(others, loss[once], share[once], name[once], still))


def _picked(model: Model, found: Candidates, batches: list[Batch], at: np.ndarray) -> Batch:
    """The copies at some places of several batches, one after the other."""
    begin = np.cumsum([0, *map(len, batches)])
    which = np.searchsorted(begin, at, side="right") - 1
    places = [np.flatnonzero(which == k) for k in np.unique(which).tolist()]
    parts = [(batches[which[mine[0]]], at[mine] - begin[which[mine[0]]]) for mine in places]
    return model.assembled(parts, places) if parts else model.assembled([(found.batch, at)])


def _views(targets: Targets, target: np.ndarray, told: Asked) -> Targets:
    """For each copy the points of its cloud that it is refined by: some of all of them, and of those where it differs."""
    own = targets.take(target)
    near = (np.arange(_THERE) < told.many[:, None]) & told.asked[:, :_THERE]
    there = np.where(near, told.some[:, :_THERE], _WHOLE + np.arange(_THERE))
    whole = np.broadcast_to(np.arange(_WHOLE), (len(target), _WHOLE))
    at, every = np.concatenate([whole, there], axis=1), np.arange(len(target))[:, None]
    fewer = np.sqrt(own.points.shape[1] / _WHOLE)
    apart = own.apart[every, at]
    apart[:, :_WHOLE] *= fewer
    apart[:, _WHOLE:] *= np.where(near, np.sqrt(np.maximum(told.many / _THERE, 1.0))[:, None], fewer)
    columns = {name: getattr(own, name)[every, at] for name in ("points", "normals", "word")}
    return replace(own, apart=apart, **columns)
