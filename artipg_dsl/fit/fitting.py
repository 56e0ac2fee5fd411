"""Objects fitted: from clouds to values, a few objects at a time as one batch."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from ..annotate.states import rest_values
from ..geometry.sites import object_boxes
from ..runtime.batch import Batch
from ..sampling.repair import repair
from .decide import decide
from .measure import agreement, distances, surfaces, verdict
from .model import Model
from .pose import UNITS, Posed, targets, turn
from .refine import refine
from .search import Effort, search
from .states import Moved, carried, moved

TOGETHER = 6  # objects that are searched as one batch
_NEARER = 0.8  # joints are moved where the distance becomes that of rest times this, or less
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
    """The diagonal of common objects of a category, in metres."""
    drawn = model.drawn(np.arange(_USUAL), 0)
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
) -> list[Fitted]:
    """The objects of a program that come nearest to some clouds, in their order. ``checked``: without links that collide.
    ``words``: which word of the vocabulary ``semantic`` a name of a cloud's labels means; points of different words do not belong
    together. ``opened``: a model of the same program with joints anywhere, for clouds that nothing at rest fits."""
    found = _fit(model, several, seed, checked, effort, words)
    rough = [k for k, one in enumerate(found) if one.told["verdict"] != verdict(0.0)]
    if opened is None or not rough:
        return found
    for k, other in zip(rough, _fit(opened, [several[k] for k in rough], seed, checked, effort, words), strict=True):
        if other.told["distance"]["both"] < _NEARER * found[k].told["distance"]["both"] and (
            other.told["valid"] or not found[k].told["valid"]
        ):
            found[k] = other
    return found


def _fit(
    model: Model,
    several: Sequence[Posed],
    seed: int,
    checked: bool,
    effort: Effort | None,
    words: Mapping[str, str] | None,
) -> list[Fitted]:
    semantic = model.program.vocabularies.get("semantic", ())
    said = [_words(posed, words or {}, semantic) for posed in several]
    asked = targets(several, said, sorted(semantic.index(word) for word in set((words or {}).values())))
    effort = effort or Effort()
    found = search(model, asked, effort, seed)
    found = decide(model, asked, found, effort)
    found = refine(model, asked.first(2048), found, effort.last)
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
    for row, posed in enumerate(several):
        mine = found.target[row] - int(np.searchsorted(asked.of, row))
        up, front = posed.turns[mine]
        matrix = turn(up, front)
        points, normals = posed.points @ matrix.T, posed.normals @ matrix.T
        scale, shift = float(found.placed.scale[row]), found.placed.shift[row]
        apart = distances(points, normals, whole[row], outside[row])
        told: dict[str, Any] = {
            "verdict": verdict(apart["both"]),
            "distance": apart,
            "frame": {"up": up, "front": front, "unit": posed.unit if posed.known else None},
            "to_object": _matrix(matrix * UNITS[posed.unit] / scale, -shift / scale),
            "size": [round(float(x), 6) for x in high[row] - low[row]],
            "valid": row not in failed,
        }
        if moving:
            own, at_rest = np.flatnonzero(batch.joints().owner == row), rest_values(batch)
            told["joints"] = {
                batch.joints().name[j]: round(float(states[j]), 6) for j in own if states[j] != 0.0 or at_rest[j] != 0.0
            }
        agreed = agreement(points, said[row], whole[row], semantic)
        told |= {"iou": agreed} if agreed else {}
        made.append(Fitted(batch.drawn(row), told, (points - shift) / scale, batch, row, states))
    return made


def _words(posed: Posed, words: Mapping[str, str], semantic: tuple[str, ...]) -> np.ndarray:
    """The word of each point of a cloud as a place in the vocabulary, 0 where nothing is said of it."""
    meant = [words.get(name, "") for name in posed.names]
    places = [semantic.index(word) if word in semantic else 0 for word in meant]
    return np.array([*places, 0], dtype=np.int64)[posed.label]


def _matrix(turned: np.ndarray, shift: np.ndarray) -> list[list[float]]:
    """Rows of the matrix (4, 4) that carries points of the file into the frame of the object."""
    matrix = np.eye(4)
    matrix[:3, :3], matrix[:3, 3] = turned, shift
    return [[round(float(x), 9) for x in row] for row in matrix]
