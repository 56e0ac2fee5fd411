"""Primitives of a kept program whose formulas are read, and verified, when something asks for them.

Most of what a program says are the formulas of its primitives, and one object uses few of these.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import fields
from threading import RLock
from typing import Any

from ..errors import UserError
from ..shapes import Misfit, fit, hints
from .nodes import NodeFault, require
from .primitive import LATER, Primitive, defer
from .program import Program
from .reading import Reader, from_text


def from_kept(text: str, known: str) -> Program:
    """The program of a text that was kept, whose hash is ``known``: as ``from_text`` reads it, but for the formulas of primitives, which
    are read and verified when they are asked for, and raise UserError where they are none."""
    return from_text(text, known, _read_later)


class _Unread:
    """The lines of primitives and of expressions behind those that ``reader`` has read."""

    def __init__(self, reader: Reader, lines: Sequence[str]):
        self.reader, self.first = reader, len(reader.exprs)
        self.lines = [line for line in lines if line[:1] == "%"]
        self.lock = RLock()

    def primitive(self, line: str) -> Primitive:
        """The primitive of a line, without its formulas. Raises NodeFault or Misfit."""
        reader = self.reader
        reader.begin(line)
        for word in ("primitives", "(", "Primitive"):
            reader.expect(word)
        told = reader.fields(Primitive, 1, LATER)
        reader.finish()
        for name, kind in hints(Primitive).items():
            if name in told:
                fit(told[name], kind, name)
        made = defer(told, lambda name: self.formulas(made, line, name))
        reader.verifier.named(made)
        reader.verifier.parameters(made)
        return made

    def formulas(self, primitive: Primitive, line: str, name: str) -> Any:
        """The field ``name`` of the primitive of a line. Raises UserError where it is none."""
        reader = self.reader
        with self.lock:
            try:
                words = self.written(line, name)
                if not words:
                    return next(field.default for field in fields(Primitive) if field.name == name)
                self.fetch(words)
                reader.words, reader.at = words, 0
                found = reader.value()
                reader.verifier.late(primitive, name, found)
            except (NodeFault, Misfit) as error:
                raise UserError(f"a kept program is damaged: {error}", "remove it with `apgc cache clear`") from None
        return found

    def written(self, line: str, name: str) -> list[str]:
        """The words of the field ``name`` of a record; none where it is left out, as it has its default."""
        reader = self.reader
        reader.begin(line)
        reader.at = 3  # behind the name of the record
        while not reader.ends(")"):
            key, begin = reader.next(), reader.at
            reader.skip()
            if key == name:
                return reader.words[begin : reader.at]
        return []

    def fetch(self, words: Sequence[str]) -> None:
        """Reads the expressions that some words of a line name, and what these are made of."""
        named, wanted = self.reader.named, dict[int, str]()
        left = [word for word in words if word[0] == "%"]
        while left:
            word = left.pop()
            if word in named:
                continue
            number = self.number(word)
            if number not in wanted:
                wanted[number] = line = self.lines[number]
                left += [part for part in line.split(" ")[3:] if part[:1] == "%"]
        for number in sorted(wanted):  # what an expression is made of stands before it
            self.reader.expression_of(wanted[number], f"%{number + self.first}")

    def number(self, word: str) -> int:
        """The place of an expression among the lines that are left."""
        number = int(word[1:]) - self.first if word[1:].isdecimal() else -1
        require(0 <= number < len(self.lines), f"{word[:40]} is not known before this line")
        return number


def _read_later(reader: Reader, lines: Sequence[str]) -> None:
    """The primitives of some lines into the program of a reader. Raises NodeFault or Misfit."""
    unread, found = _Unread(reader, lines), reader.program.primitives
    for line in lines:
        if line[:1] != "%":
            made = unread.primitive(line)
            require(made.name not in found, "primitives must have different names")
            found[made.name] = made
