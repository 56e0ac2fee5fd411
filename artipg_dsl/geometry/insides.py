"""The rows of a block with what their inside functions need."""

from __future__ import annotations

from functools import cached_property

import numpy as np

from .block import Block
from .box import bounds
from .patches import inside_split
from .split import Split


class Insides:
    """Rows that are asked what lies in them: ``shelf`` (R,) of each; ``low`` and ``high`` (3, R) bound it in its own frame."""

    def __init__(self, rows: Block):
        self.rows = rows
        self.poses = rows.rotation, rows.translation, rows.mirror
        self.shelf = np.zeros(len(rows.owner), dtype=np.int16)
        self.low, self.high = np.empty((3, len(rows.owner))), np.empty((3, len(rows.owner)))
        for number, shelf in enumerate(rows.shelves):
            part = slice(shelf.start, shelf.stop)
            corners = bounds(shelf.primitive, shelf.params)
            self.shelf[part] = number
            self.low[:, part], self.high[:, part] = corners[0].T, corners[1].T

    @cached_property
    def inside(self) -> list[Split]:
        """The inside function of each shelf."""
        return [inside_split(s.primitive) for s in self.rows.shelves]

    @cached_property
    def values(self) -> list[np.ndarray]:
        """What it needs of the rows of each shelf."""
        return [split.rows(s.params) for split, s in zip(self.inside, self.rows.shelves, strict=True)]
