"""What is said of details once they are bound: how near the structure comes to the real surface without and with them."""

from __future__ import annotations

from collections.abc import Mapping
from typing import TYPE_CHECKING, Any

import numpy as np

from .. import random
from ..geometry import points as geometry
from .binding import Real
from .elements import Solids
from .measure import distances, spoiled
from .record import DIRECT, of_arrays
from .suits import own_suits
from .wear import Wardrobe, wear

if TYPE_CHECKING:
    from ..runtime.batch import Batch


def report(batch: Batch, real: Real, arrays: Mapping[str, np.ndarray], count: int) -> dict[str, Any]:
    """Of one object and its details as they are written, by ``count`` points.

    ``before`` and ``after``: distances of fresh points of the structure, bare and in its details; ``floor``: those of as many points of
    the real surface itself, so that nothing can come nearer; ``torn`` and ``inverted`` shares; ``worn``: the share of the points that
    found a detail.
    """
    details = of_arrays(arrays, real.name)
    address = np.asarray(batch.numbers).astype(np.uint64)
    fresh = geometry.sample(batch.sites(), 1, count, random.key(batch.seed, "worn"), address, outside=True)
    wardrobe = Wardrobe(details, Solids.of(batch.sites()))
    alone = np.zeros(1, dtype=np.int64)
    made = wear(batch, fresh, alone, wardrobe, own_suits(batch, details.elements, alone))
    diagonal = real.diagonal
    group = fresh.site[0].astype(np.int64) * (int(fresh.row.max()) + 1) + fresh.row[0]
    own, others = real.points[-count:], real.points[:-count]
    figures: dict[str, Any] = {
        "before": distances(real.points, fresh.position[0], diagonal),
        "after": distances(real.points, made.position[0], diagonal),
        "floor": distances(others, own, diagonal) if len(others) > count else None,
        **spoiled(fresh.position[0], fresh.normal[0], group, made.position[0], made.normal[0], diagonal),
        "worn": round(float((made.bound >= 0).mean()), 4),
    }
    return {"points": len(details), "completed": int((details.how != DIRECT).sum()), "figures": figures}
