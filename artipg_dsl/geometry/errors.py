"""What can be wrong with the declaration of a primitive."""

from __future__ import annotations

from ..errors import UserError
from ..graph.primitive import Primitive


class PrimitiveError(UserError):
    """A declaration that has no mesh: ``patch`` names the surface at fault (None: the whole primitive), ``words`` say what is wrong.

    The check of a program finds it; who meets it later has a compiled program that was edited.
    """

    def __init__(self, primitive: Primitive, patch: str | None, words: str):
        super().__init__(
            f"{primitive.name}: {f'surface {patch}: ' if patch else ''}{words}", "check the program that declares it"
        )
        self.primitive, self.patch, self.words = primitive, patch, words

    def __reduce__(self) -> tuple[type[UserError], tuple[str, str | None]]:
        return UserError, (self.message, self.hint)
