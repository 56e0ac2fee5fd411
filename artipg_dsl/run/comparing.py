"""Real objects read to be compared with samples of a category, which tell how large they are to be."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence

import numpy as np

from ..errors import UserError
from ..fit.likeness import Likeness, measure_likeness
from ..fit.pose import Frame, Posed, pose
from ..fit.presence import Presence, measure_presence
from ..fit.sources import Item
from ..quality.sizes import measure_extents
from ..records import dataclass
from ..runtime.batch import Batch
from .fitting import explain
from .prior import Prior, apply_prior

Progress = Callable[[int, int], None]


@dataclass(frozen=True, slots=True, eq=False)
class Known:
    """R real objects: their ``names``, surfaces, and the labels that are ``seen`` on each; ``labels``: all that they might have. ``lost``: what
    was left out of some, ``failed``: which could not be read, by their names."""

    names: list[str]
    posed: list[Posed]
    seen: list[frozenset[str]]
    labels: list[str]
    lost: dict[str, str]
    failed: dict[str, str]


def read_all(batch: Batch, items: Sequence[Item], frame: Frame, progress: Progress | None = None) -> Known:
    """Real objects beside those of a batch. Raises UserError where none can be read."""
    usual = float(np.median(np.sqrt((measure_extents(batch) ** 2).sum(axis=1))))
    known, labels = Known([], [], [], [], {}, {}), set[str]()
    for number, item in enumerate(items):
        try:
            cloud = item.real.read()
            known.posed.append(pose(cloud, frame, item.real.suffix, usual))
            known.names.append(item.name)
            known.seen.append(frozenset(cloud.names[k] for k in np.unique(cloud.label).tolist() if k >= 0))
            labels.update(cloud.names)
            if cloud.lost:
                known.lost[item.name] = cloud.lost
        except UserError as wrong:
            known.failed[item.name] = explain(wrong)
        if progress:
            progress(number + 1, len(items))
    if not known.posed:
        raise UserError("none of the real objects could be read", next(iter(known.failed.values())))
    known.labels.extend(sorted(labels))
    return known


@dataclass(frozen=True, slots=True, eq=False)
class Comparison:
    """Samples beside real objects: their ``likeness``, in the order of ``names``; ``failed`` has the reason of each that could not be read."""

    batch: Batch
    known: Known
    words: Mapping[str, str]
    likeness: Likeness

    @staticmethod
    def of(batch: Batch, known: Known, words: Mapping[str, str], progress: Progress | None = None) -> Comparison:
        """``words``: which word of ``semantic`` a name of a label means."""
        return Comparison(batch, known, words, measure_likeness(batch, known.posed, words, progress))

    @property
    def names(self) -> list[str]:
        return self.known.names

    @property
    def failed(self) -> dict[str, str]:
        return self.known.failed

    def __repr__(self) -> str:
        found = self.likeness
        far = f", {len(found.far)} far from all" if found.far else ""
        return f"<{self.batch.program.name}: {found.objects} samples beside {len(self.names)} real objects{far}>"

    def presence(self) -> Presence:
        """What the labels say of parts that are there or not and of counts: ``draws`` as a prior takes them. Raises UserError."""
        found = measure_presence(self.batch, self.known.seen, self.words)
        apply_prior(self.batch.program, Prior(found.draws, "what the labels say"))  # what is told can be read
        return found
