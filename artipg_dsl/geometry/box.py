"""The stated boxes of primitives, batched."""

from __future__ import annotations

import numpy as np

from ..graph.primitive import Primitive
from .patches import Params, evaluate_rows


def bounds(primitive: Primitive, params: Params) -> tuple[np.ndarray, np.ndarray]:
    """Low and high corners (k, 3) of the instances, in metres and their own frame, unmirrored."""
    values = np.ascontiguousarray(evaluate_rows(primitive, (*primitive.low, *primitive.high), params).T)
    return values[:, :3], values[:, 3:]
