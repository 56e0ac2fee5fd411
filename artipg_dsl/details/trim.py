"""What objects can borrow of details: that which belongs to the surface, not what makes up for a structure that does not fit.

A mutant has the faults of the structure that its donor was given, and the offsets that make up for them; on another object these become
spikes and tears. So what reaches farther than its primitive is thick goes, and what does not go where its neighbours go.
"""

from __future__ import annotations

import numpy as np

from ..geometry.vectors import dot
from .elements import Solids
from .record import Details
from .refuse import strayed

# offsets are at most as long as the primitive is thick, or this share of its second side if that is more
_THICK, _WIDE = 1.0, 0.3
_APART = 0.012  # diagonals: so far an offset may lie off the median of its neighbours'
_ROUNDS = 2


def trim(details: Details, solids: Solids) -> Details:
    """The points whose offsets other objects can wear."""
    low, high = solids.boxes(details.elements)
    size = np.sort(high - low, axis=1)[details.element]
    length = np.sqrt(dot(details.offset, details.offset))
    found = details.take(np.flatnonzero(length <= np.maximum(_THICK * size[:, 0], _WIDE * size[:, 1])))
    for _ in range(_ROUNDS):
        found = found.take(np.flatnonzero(strayed(found, solids)[0] <= _APART))
    return found
