"""Copies of candidates beside what they were made of; and those developed that are less likely only because the rest does not yet fit them.

A casement is less likely than a fixed sash while the frame around it has the size that fits the fixed one. So, where the cloud speaks for no
change as such, all numbers of the copies that change much are refined, and those of their origin, and whole candidates are compared.
"""

from __future__ import annotations

import numpy as np

from ..runtime.batch import Batch
from .compare import Candidates, Targets
from .evidence import Clouds, Copies, beside, weigh
from .focus import Differing, differing, lifted
from .model import Model
from .refine import refine
from .search import Effort, taken, united

SURE = 12.0  # natural logarithms by which a change has to be more likely


def copied(found: Candidates, batch: Batch, of: np.ndarray) -> Copies:
    """A ``batch`` of copies of candidates, placed so that most of what they share with these stands where it stood: objects stand on the
    ground, which a sill or feet push all else up from."""
    placed = found.placed.take(of)
    return Copies(batch, of, found.target[of], placed.moved(lifted(found.batch, batch, of)))


def apart(found: Candidates, copies: Copies, within: np.ndarray | None = None) -> Differing:
    """Where copies differ from what they were made of, as both are placed; by more than ``within`` (K,) metres of clouds, if that is given."""
    scale = copies.placed.scale
    by = (copies.placed.shift - found.placed.shift[copies.of]) / scale[:, None]
    return differing(found.batch, copies.batch, copies.of, by, None if within is None else within / scale)


def developed(
    model: Model, own: Targets, found: Candidates, clouds: Clouds, others: Candidates, effort: Effort
) -> Candidates:
    """Those of the candidates that become likelier as one of the ``others``, which are their copies with a change of much of them, once all
    numbers of both are refined: in this form."""
    target = others.target
    still = np.flatnonzero(np.isin(found.target, target))
    if not len(target):
        return taken(model, found, still)
    both = refine(model, own.first(2048), united(model, [taken(model, found, still), others]), effort.whole)
    told, count = weigh(both.batch, both.target, both.placed, clouds), len(still)
    loss = beside(told.take(slice(count, None)), told.take(slice(count)), np.searchsorted(found.target[still], target))
    order = np.lexsort((loss, target))
    first = order[np.unique(target[order], return_index=True)[1]]
    return taken(model, both, count + first[loss[first] < -SURE])
