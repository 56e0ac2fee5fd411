"""What a code is."""

from __future__ import annotations

from textwrap import dedent

from ...records import dataclass


@dataclass(frozen=True, slots=True)
class Code:
    """``summary`` is one line; ``text`` explains at length; ``example`` is a program that brings the code about.

    ``example`` is empty only where a text alone cannot bring it about (a missing file).
    """

    name: str
    summary: str
    text: str
    example: str = ""

    def __post_init__(self) -> None:
        object.__setattr__(self, "text", " ".join(dedent(self.text).split()))
        object.__setattr__(self, "example", dedent(self.example).lstrip("\n"))
