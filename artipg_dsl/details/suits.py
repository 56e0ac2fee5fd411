"""Which element of which donor each element of a batch wears the details of.

A mutant wears those of the object it was made from, by the correspondence of its mutation (``sampling.correspondence``). Any other object
borrows: it draws an order of all donors, by address, so that it is the same in any batch. Each of its elements takes the first of them
that has the same part in the same template, and if none has, the first that has the counterpart by the slot of a role. So an object
wears one donor wherever that has what it needs, and the elements of a template take the next one together.
"""

from __future__ import annotations

from functools import lru_cache
from typing import TYPE_CHECKING

import numpy as np

from .. import random
from ..records import dataclass
from ..sampling.correspondence import counterparts, find_correspondence
from .elements import Elements, elements_of

if TYPE_CHECKING:
    from ..graph.program import Program
    from ..runtime.batch import Batch
    from .record import Details

Levels = tuple[tuple[int, ...], ...]


@dataclass(frozen=True, slots=True, eq=False)
class Suits:
    """The ``elements`` of a batch, and for each (K,) the element of its donor that it wears, -1 for none."""

    elements: Elements
    match: np.ndarray


def own_suits(batch: Batch, stock: Elements, donor: np.ndarray) -> Suits:
    """Those of mutants: ``donor`` (B,) is the number of what each was made from among the owners of ``stock``, -1 for none."""
    elements = elements_of(batch)
    found = find_correspondence(origin(batch), batch)
    before = found.before_site.astype(np.int64), found.before_rank.astype(np.int64)
    return Suits(elements, stock.find(donor[elements.owner], *before))


def borrowed_suits(batch: Batch, details: Details) -> Suits:
    """Those of any objects of the program of the donors. The mutants of an object borrow where it does."""
    elements, several = elements_of(batch), len(details.names)
    order = _order(batch, details.names)
    stock = details.elements
    listed = np.flatnonzero(np.bincount(details.element, minlength=len(stock)) > 0)  # the others have nothing to wear
    shape = several, len(batch.program.sites)
    cell = stock.owner[listed] * shape[1] + stock.site[listed]
    count = np.bincount(cell, minlength=shape[0] * shape[1]).reshape(shape)
    first = np.searchsorted(cell, np.arange(shape[0] * shape[1])).reshape(shape)
    match = np.full(len(elements), -1)
    levels = kin(batch.program)
    for site in np.unique(elements.site).tolist():
        own = np.flatnonzero(elements.site == site)
        objects, place, rows = np.unique(elements.owner[own], return_inverse=True, return_counts=True)
        donor, theirs = _first_of(levels[site], count, order[objects])
        donor, theirs = donor[place], theirs[place]
        several_there = count[donor, theirs]
        # the ends of a row wear the ends of another, the rest what is nearest between
        others = np.maximum(rows[place] - 1, 1)
        row = (2 * elements.rank[own] * (several_there - 1) + others) // (2 * others)
        found = first[donor, theirs] + row
        match[own] = np.where(theirs >= 0, listed[np.where(theirs >= 0, found, 0)], -1) if len(listed) else -1
    return Suits(elements, match)


def origin(batch: Batch) -> Batch:
    """The objects that those of a batch were made from, if they are mutants."""
    return batch.history[0].before if batch.history else batch


def _order(batch: Batch, names: tuple[str, ...]) -> np.ndarray:
    """(B, D): the donors in the order that each object draws. One more donor leaves the order of the others as it is."""
    address = origin(batch).numbers.astype(np.uint64)
    drawn = [random.uniform(random.key(batch.seed, "donors", name), address) for name in names]
    return np.argsort(np.stack(drawn, axis=1), axis=1, kind="stable")


def _first_of(levels: Levels, count: np.ndarray, order: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """For each row of ``order`` (k, D) the first donor that has an element of a site of the first level, or else of the next; and
    which site that is (k,), -1 where no donor has any. ``count`` (D, S): the elements of each donor and site."""
    donor, theirs = np.zeros(len(order), dtype=np.int64), np.full(len(order), -1)
    for sites in levels:
        there = count[:, list(sites)] > 0
        site = np.where(there.any(axis=1), np.array(sites, dtype=np.int64)[np.argmax(there, axis=1)], -1)
        free = theirs < 0
        ranked = site[order]
        pick = np.argmax(ranked >= 0, axis=1)[:, None]
        donor = np.where(free, np.take_along_axis(order, pick, axis=1)[:, 0], donor)
        theirs = np.where(free, np.take_along_axis(ranked, pick, axis=1)[:, 0], theirs)
    return donor, theirs


@lru_cache(maxsize=4)
def kin(program: Program) -> tuple[Levels, ...]:
    """For each site the sites whose details it can wear, the nearest first: itself and its like, that is the same part of the same
    template under the same word of ``semantic``; then the counterparts of all of these by slot."""
    names = [_name(program, number) for number in range(len(program.sites))]
    like: dict[tuple[str, ...], list[int]] = {}
    for number, name in enumerate(names):
        like.setdefault(name, []).append(number)
    stands, found = counterparts(program), []
    for number, name in enumerate(names):
        same = [number, *(other for other in like[name] if other != number)]
        others = dict.fromkeys(other for one in same for other in stands.get(one, ()))
        further = [other for other in others if names[other] != name]
        found.append((tuple(same), tuple(further)) if further else (tuple(same),))
    return tuple(found)


def _name(program: Program, number: int) -> tuple[str, ...]:
    """What a primitive is wherever its template is used: the word of its part, the template, and its path within that."""
    own = program.parts[program.sites[number].part]
    if own.parent < 0:
        return own.word, program.name, own.path, own.template
    above = program.parts[own.parent]
    return own.word or above.word, above.template, own.path.removeprefix(above.path), own.template
