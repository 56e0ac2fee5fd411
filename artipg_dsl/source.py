"""Source texts and spans: where in which file something stands."""

from __future__ import annotations

from bisect import bisect_right
from dataclasses import field

from .records import dataclass


@dataclass(frozen=True, slots=True, eq=False)
class Source:
    """One text. ``name`` is what diagnostics show (a path as the user wrote it)."""

    name: str
    text: str
    _starts: list[int] = field(default_factory=list, repr=False)

    def position(self, offset: int) -> tuple[int, int]:
        """Line and column of an offset, both counted from 1."""
        line = bisect_right(self._begun(), offset)
        return line, offset - self._starts[line - 1] + 1

    def start(self, line: int) -> int:
        """The offset at which a line counted from 1 begins."""
        return self._begun()[line - 1]

    def _begun(self) -> list[int]:
        if not self._starts:
            self._starts.append(0)
            self._starts.extend(i + 1 for i, c in enumerate(self.text) if c == "\n")
        return self._starts

    def line(self, number: int) -> str:
        """The text of a line counted from 1, without its end."""
        lines = self.text.split("\n")
        return lines[number - 1].rstrip("\r") if 0 < number <= len(lines) else ""


@dataclass(frozen=True, slots=True)
class Span:
    """The characters ``start .. end`` (end excluded) of a source."""

    source: Source
    start: int
    end: int

    @property
    def line(self) -> int:
        return self.source.position(self.start)[0]

    @property
    def column(self) -> int:
        return self.source.position(self.start)[1]

    @property
    def text(self) -> str:
        """What stands there."""
        return self.source.text[self.start : self.end]

    @property
    def words(self) -> str:
        """The same on one line."""
        return " ".join(self.text.split())

    def holds(self, offset: int) -> bool:
        """Whether a place is in it, or at its end."""
        return self.start <= offset <= self.end

    def to(self, other: Span) -> Span:
        """The span from the start of this one to the end of the other."""
        return Span(self.source, self.start, max(self.end, other.end))

    def __str__(self) -> str:
        return f"{self.source.name}:{self.line}:{self.column}"

    def __repr__(self) -> str:
        return f"<{self}>"
