"""Objects fitted: from clouds to values, a few objects at a time as one batch."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import replace
from typing import Any

import numpy as np

from ..annotate.states import rest_values
from ..errors import plural
from ..geometry.sites import object_boxes
from ..records import dataclass
from ..runtime.batch import Batch
from ..sampling.repair import repair
from .choices import choices_of
from .compare import Candidates, Targets
from .decide import decide, inclined
from .joint_map import Real, map_joints
from .measure import FAR, agreement, distances, roughly, surfaces, verdict
from .model import Model
from .pose import UNITS, Posed, targets, turn
from .refine import refine
from .search import Effort, search, taken, united
from .states import Moved, carried, moved, tables

TOGETHER = 6  # objects that are searched as one batch
_ODD = 1.25  # percent: what is farther off once it has been searched may lie otherwise than its format has it, or not be at rest,
_UPRIGHT = 0.5  # and does lie otherwise where the distance becomes that times this, or less
_NEARER = 0.8  # its joints are moved where the distance becomes that of rest times this, or less
_HOPELESS = 120.0 * FAR  # percent: what is farther off once it has been searched is not looked into further
_FINELY = 6144  # points of a cloud by which numbers are refined at last
_CLOSELY = 32_768  # points of a cloud by which small changes are decided at last
_USUAL = 256  # drawn objects that tell how large those of a category are


@dataclass(frozen=True, slots=True, eq=False)
class Fitted:
    """What is known of one object: ``values`` as a file of parameters has them, ``told`` beside them; its ``cloud`` in the frame of the
    object, for pictures. ``row``: which of the ``batch`` it is; ``states`` (J,): the values of the joints of all of the batch."""

    values: dict[str, Any]
    told: dict[str, Any]
    cloud: np.ndarray
    batch: Batch
    row: int
    states: np.ndarray


def usual_size(model: Model) -> float:
    """The diagonal of common objects of a category, in metres. Raises UserError where none is found."""
    drawn = model.drawn(np.arange(_USUAL), 0)
    if drawn.state.failed.all():  # few are as they are known to be
        drawn = model.valid(Effort().drawn, 0)
    low, high = object_boxes(drawn.sites(), len(drawn))
    across = np.sqrt(((high - low) ** 2).sum(axis=1))
    return float(np.median(across[~drawn.state.failed & np.isfinite(across)]))


def fit(
    model: Model,
    several: Sequence[Posed],
    *,
    seed: int = 0,
    checked: bool = True,
    effort: Effort | None = None,
    words: Mapping[str, str] | None = None,
    opened: Model | None = None,
    doing: Callable[[str], None] = lambda _: None,
) -> list[Fitted]:
    """The objects of a program that come nearest to some clouds, in their order. ``checked``: without links that collide.
    ``words``: which word of the vocabulary ``semantic`` a name of a cloud's labels means; points of different words do not belong
    together. Clouds that fit less well than is usual are looked at with other upward axes, where none was given, and with ``opened``: a
    model of the same program with joints anywhere, unless their noise tells why. ``doing`` hears what is done from then on."""
    effort = effort or Effort()

    def look(how: str, model: Model, asked: dict[int, Posed]) -> dict[int, _Look]:
        if not asked:
            return {}
        doing(f"{plural(len(asked), 'object')}{how}")
        found = _searched(model, list(asked.values()), seed, effort, words)
        return {k: _Look(found, row) for row, k in enumerate(asked)}

    def nearer(how: str, model: Model, asked: dict[int, Posed], share: float) -> dict[int, _Look]:
        return {k: one for k, one in look(how, model, asked).items() if one.off < share * at_rest[k].off}

    at_rest = look("", model, dict(enumerate(several)))
    lying = [k for k, one in at_rest.items() if one.off > _ODD and several[k].others]
    others = {k: replace(several[k], turns=several[k].others) for k in lying}
    at_rest |= nearer(" with other upward axes", model, others, _UPRIGHT)
    rough = [k for k, one in at_rest.items() if one.beyond_noise > _ODD]
    unlike = {k: at_rest[k].posed for k in rough}
    moving = nearer(" with joints anywhere", opened, unlike, _NEARER) if opened else {}
    doing(f"{plural(len(several), 'object')}: choices and numbers")
    found = _all_finished(moving, checked, effort)
    still = {k: one for k, one in at_rest.items() if k not in found or not found[k].told["valid"]}
    for k, fitted in _all_finished(still, checked, effort).items():
        if k not in found or fitted.told["valid"]:
            found[k] = fitted
    return [found[k] for k in range(len(several))]


@dataclass(frozen=True, slots=True, eq=False)
class _Searched:
    """The best candidate of each of ``several`` objects, and how far ``off`` (T,) it is, in percent as ``distances`` has it; the ``rivals``
    of some; ``said``: the words of the points of each."""

    model: Model
    several: Sequence[Posed]
    said: list[np.ndarray]
    asked: Targets
    found: Candidates
    rivals: Candidates
    off: np.ndarray


@dataclass(frozen=True, slots=True, eq=False)
class _Look:
    """One of the objects of a search, that of a ``row``."""

    searched: _Searched
    row: int

    @property
    def off(self) -> float:
        return float(self.searched.off[self.row])

    @property
    def beyond_noise(self) -> float:
        """The same without what the noise of the cloud makes of it."""
        one = self.searched
        return self.off - 100.0 * float(one.asked.noise[one.found.target[self.row]])

    @property
    def posed(self) -> Posed:
        """The cloud, to be looked at again with the same upward axis."""
        one, posed = self.searched, self.searched.several[self.row]
        up, _ = _stands(posed, one.asked, one.found, self.row, self.row)
        return replace(posed, turns=[turn for turn in posed.turns if turn[0] == up])


def _all_finished(looks: dict[int, _Look], checked: bool, effort: Effort) -> dict[int, Fitted]:
    """What is found of the objects of several searches."""
    made: dict[int, Fitted] = {}
    for searched in {id(one.searched): one.searched for one in looks.values()}.values():
        mine = [k for k, one in looks.items() if one.searched is searched]
        rows = np.array([looks[k].row for k in mine], dtype=np.int64)
        made |= dict(zip(mine, _finished(searched, rows, checked, effort), strict=True))
    return made


def _searched(
    model: Model, several: Sequence[Posed], seed: int, effort: Effort, words: Mapping[str, str] | None
) -> _Searched:
    semantic = model.program.vocabularies.get("semantic", ())
    said = [_words(posed, words or {}, semantic) for posed in several]
    asked = targets(several, said, sorted(semantic.index(word) for word in set((words or {}).values())))
    found, rivals = search(model, asked, effort, seed)
    whole, outside = roughly(found.batch, tables(found.batch), found.placed.scale, found.placed.shift)
    off = [
        distances(*_turned(posed, *_stands(posed, asked, found, row, row)), whole[row], outside[row])["both"]
        for row, posed in enumerate(several)
    ]
    return _Searched(model, several, said, asked, found, rivals, np.array(off))


def _stands(posed: Posed, asked: Targets, found: Candidates, row: int, number: int) -> tuple[str, str]:
    """The upward axis and the front of the object ``number`` by the candidate of a row."""
    return posed.turns[found.target[row] - int(np.searchsorted(asked.of, number))]


def _turned(posed: Posed, up: str, front: str) -> tuple[np.ndarray, np.ndarray]:
    matrix = turn(up, front)
    return posed.points @ matrix.T, posed.normals @ matrix.T


def _decided(one: _Searched, at: np.ndarray, effort: Effort) -> Candidates:
    """The candidates of some objects with their choices decided and their numbers refined; those of which nothing is to be hoped as they
    are."""
    model, found = one.model, taken(one.model, one.found, at)
    hopeful = one.off[at] <= _HOPELESS
    if not hopeful.any():
        return found
    likely = taken(model, found, np.flatnonzero(hopeful))
    rivals = taken(model, one.rivals, np.flatnonzero(np.isin(one.rivals.target, likely.target)))
    better = decide(model, one.asked, likely, effort, rivals)
    better = refine(model, one.asked.first(_FINELY), better, effort.last)
    better = inclined(model, _closely(one, better), better, effort)
    both = united(model, [better, taken(model, found, np.flatnonzero(~hopeful))])
    return taken(model, both, np.argsort(both.target, kind="stable"))


def _closely(one: _Searched, found: Candidates) -> Targets:
    """The clouds of some candidates, one each, with all of their points, or nearly."""
    numbers = one.asked.of[found.target].tolist()
    said = [one.said[number] for number in numbers]
    several = [
        replace(one.several[number], turns=[_stands(one.several[number], one.asked, found, row, number)])
        for row, number in enumerate(numbers)
    ]
    return targets(several, said, one.asked.meant.tolist(), _CLOSELY)


def _finished(one: _Searched, at: np.ndarray, checked: bool, effort: Effort) -> list[Fitted]:
    """What is found of the objects of some numbers, ascending."""
    if not len(at):
        return []
    model, asked, found = one.model, one.asked, _decided(one, at, effort)
    semantic = model.program.vocabularies.get("semantic", ())
    outcome = repair(model.sampler, model.at_rest(found.batch), checked=checked)
    batch = outcome.batch
    failed = set(outcome.failed.tolist())
    states, sites, moving = np.zeros(len(batch.joints().owner)), batch.sites(), isinstance(model.program, Moved)
    if moving:
        states = carried(batch, found.batch)
        sites = moved(batch, states)
    low, high = object_boxes(batch.sites(), len(batch))
    whole, outside = surfaces(batch, sites, found.placed.scale, found.placed.shift)
    made = []
    for row, number in enumerate(at.tolist()):
        posed = one.several[number]
        up, front = _stands(posed, asked, found, row, number)
        points, normals = _turned(posed, up, front)
        scale, shift = float(found.placed.scale[row]), found.placed.shift[row]
        apart = distances(points, normals, whole[row], outside[row])
        told: dict[str, Any] = {
            "verdict": verdict(apart["both"]),
            "distance": apart,
            "frame": {"up": up, "front": front, "unit": posed.unit if posed.known else None},
            "to_object": _matrix(turn(up, front) * UNITS[posed.unit] / scale, -shift / scale),
            "size": [round(float(x), 6) for x in high[row] - low[row]],
            "valid": row not in failed,
        }
        if moving:
            own, at_rest = np.flatnonzero(batch.joints().owner == row), rest_values(batch)
            told["joints"] = {
                batch.joints().name[j]: round(float(states[j]), 6) for j in own if states[j] != 0.0 or at_rest[j] != 0.0
            }
        if posed.bodies is not None:
            bodies = posed.bodies.turned(turn(up, front)).placed(scale, shift)
            body = np.append(bodies.of, -1)[posed.label]
            told["joint_map"] = map_joints(batch, states, row, Real((points - shift) / scale, normals, body, bodies))
        told["choices"] = choices_of(batch, row, model.discrete)
        agreed = agreement(points, normals, one.said[number], whole[row], asked.meant, semantic)
        told |= {"iou": agreed} if agreed else {}
        made.append(Fitted(batch.drawn(row), told, (points - shift) / scale, batch, row, states))
    return made


def _words(posed: Posed, words: Mapping[str, str], semantic: tuple[str, ...]) -> np.ndarray:
    """The word of each point of a cloud as a place in the vocabulary, 0 where nothing is said of it."""
    meant = [words.get(name, "") for name in posed.names]
    places = [semantic.index(word) if word in semantic else 0 for word in meant]
    return np.array([*places, 0], dtype=np.int64)[posed.label]


def _matrix(turned: np.ndarray, shift: np.ndarray) -> list[list[float]]:
    """Rows of the matrix (4, 4) that carries points of the file into the frame of the object. Digits are those that tell, not places after
    the point: a file without a scale may be a million times as large as the object."""
    matrix = np.eye(4)
    matrix[:3, :3], matrix[:3, 3] = turned, shift
    return [[float(f"{x:.12g}") for x in row] for row in matrix]
