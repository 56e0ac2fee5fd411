"""The stated boxes of primitives, batched, and boxes about turned boxes."""

from __future__ import annotations

import numpy as np

from ..graph.primitive import Primitive
from .patches import evaluate_rows
from .split import Params
from .vectors import dot


def bounds(primitive: Primitive, params: Params) -> tuple[np.ndarray, np.ndarray]:
    """Low and high corners (k, 3) of the instances, in metres and their own frame, unmirrored."""
    values = np.ascontiguousarray(evaluate_rows(primitive, (*primitive.low, *primitive.high), params).T)
    return values[:, :3], values[:, 3:]


def turn_boxes(turn: np.ndarray, shift: np.ndarray, low: np.ndarray, high: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Low and high corners (..., 3) of boxes about the boxes ``low`` to ``high`` turned by ``turn`` (..., 3, 3) and shifted."""
    middle, half = (low + high) / 2, (high - low) / 2
    at = [dot(turn[..., i, :], middle) + shift[..., i] for i in range(3)]
    wide = [dot(np.abs(turn[..., i, :]), half) for i in range(3)]
    ends = [(a - w, a + w) for a, w in zip(at, wide, strict=True)]
    return np.stack([end[0] for end in ends], axis=-1), np.stack([end[1] for end in ends], axis=-1)
