"""Pictures painted by several processes: a shot each time, made here and drawn there."""

from __future__ import annotations

from collections.abc import Callable, Iterable
from typing import TYPE_CHECKING

from .sharing import share
from .workers import map_each

if TYPE_CHECKING:
    import numpy as np

    from ..view.sheet import PaintAll, Painter, Shot

_painter: Painter | None = None  # of this worker


def paint_with(workers: int) -> PaintAll:
    """How so many processes paint the pictures of a sheet; with AUTO this one begins (see ``share``)."""

    def paint_all(painter: Painter, count: int, shot: Callable[[int], Shot]) -> Iterable[np.ndarray]:
        return share(
            range(count),
            workers,
            lambda i: painter.paint(shot(i)),
            lambda rest, many: map_each(_paint, map(shot, rest), many, _take, painter, here=painter.paint),
        )

    return paint_all


def _take(painter: Painter) -> None:
    global _painter
    _painter = painter


def _paint(shot: Shot) -> np.ndarray:
    assert _painter is not None
    return _painter.paint(shot)
