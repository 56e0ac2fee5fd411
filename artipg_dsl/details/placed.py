"""Bound details of one object as points in its frame: where they are bound, and where the real surface is."""

from __future__ import annotations

import numpy as np

from ..records import dataclass
from ..runtime.columns import Columns
from .elements import Solids
from .record import Details


@dataclass(frozen=True, slots=True, repr=False)
class BoundPoints(Columns):
    """E points of a structure that details are bound to, with its joints at 0.

    ``position`` (E, 3) metres, on the structure; ``real`` (E, 3), the point of the real surface that belongs to it, and ``normal`` (E, 3) of
    the real surface there. ``label`` (E,) indexes ``labels``, the words of the original for its points, -1 for none. The binding:
    ``primitive`` (site number), ``element`` (which of the object's primitives of that site), ``patch``, ``u``, ``v`` (E,). ``how`` (E,): 0
    of a point of the original; of surface that was hidden, lent by a mirror image (1), a turn (2) or a shift (3) of the primitive.
    """

    position: np.ndarray
    real: np.ndarray
    normal: np.ndarray
    label: np.ndarray
    labels: tuple[str, ...]
    primitive: np.ndarray
    element: np.ndarray
    patch: np.ndarray
    u: np.ndarray
    v: np.ndarray
    how: np.ndarray

    def __len__(self) -> int:
        return len(self.position)


def place(details: Details, solids: Solids) -> BoundPoints:
    """The points of the details of one donor, whose program is made of these solids."""
    elements, on = details.elements, details.element
    frames = solids.frames(elements, on, details.patch, details.u, details.v)
    return BoundPoints(
        position=elements.placed(on, frames.place),
        real=elements.placed(on, frames.place + frames.out_of(details.offset)),
        normal=elements.turned(on, frames.out_of(details.facing)),
        label=details.label,
        labels=details.labels,
        primitive=elements.site[on],
        element=elements.rank[on],
        patch=details.patch,
        u=details.u,
        v=details.v,
        how=details.how,
    )
