"""Paths that are handed to a primitive: the steps of a path, with its numbers as parameters."""

from __future__ import annotations

import re
from typing import TYPE_CHECKING, Any

from ...graph import expr as E
from ...graph.expr import Expr
from ...records import dataclass

if TYPE_CHECKING:
    from ..solids.curves import Curve


@dataclass(frozen=True, slots=True)
class Step:
    """A word of a path with its numbers: from (at, along), line (length), arc (radius, angle, towards), formula."""

    word: str
    numbers: tuple[Expr, ...]


@dataclass(frozen=True, slots=True, eq=False)
class Handed:
    """A path as a parameter: its steps over variables ``names``, whose values are ``scalars``; ``key`` is its shape."""

    curve: Curve
    steps: tuple[Step, ...]
    names: tuple[str, ...]
    scalars: tuple[Expr, ...]
    tests: tuple[tuple[float, float], ...]

    @property
    def key(self) -> tuple[Any, ...]:
        return tuple((s.word, s.numbers) for s in self.steps), self.tests

    def in_words(self, text: str) -> str:
        """A message with the formulas of the author where it has variables."""
        for name, value in zip(self.names, self.scalars, strict=True):
            told = (
                E.show(value, 40).removeprefix("(").removesuffix(")")
                if value.op in ("add", "sub")
                else E.show(value, 40)
            )
            text = re.sub(rf"(?<![\w.]){re.escape(name)} = ", f"{told} = ".replace("\\", r"\\"), text)
        return text
