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
    written: str  # the text and the example as they stand in the file of the family
    program: str = ""

    @property
    def text(self) -> str:
        return " ".join(self.written.split())

    @property
    def example(self) -> str:
        return dedent(self.program).lstrip("\n")
