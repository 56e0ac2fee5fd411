"""What a text consists of for the parser."""

from __future__ import annotations


class Token:
    """A piece of a text: the name of its terminal, what is written, and where."""

    __slots__ = ("type", "value", "start_pos", "end_pos")

    def __init__(self, kind: str, value: str, start: int, end: int):
        self.type, self.value, self.start_pos, self.end_pos = kind, value, start, end

    def update(self, kind: str) -> Token:
        """The same piece as another terminal."""
        return Token(kind, self.value, self.start_pos, self.end_pos)
