"""What can be wrong with the declaration of a primitive."""

from __future__ import annotations

from ..graph.primitive import Primitive


class PrimitiveError(Exception):
    """A declaration that has no mesh: ``patch`` names the surface at fault (None: the whole primitive)."""

    def __init__(self, primitive: Primitive, patch: str | None, message: str):
        super().__init__(f"{primitive.name}: {f'surface {patch}: ' if patch else ''}{message}")
        self.primitive, self.patch, self.message = primitive, patch, message
