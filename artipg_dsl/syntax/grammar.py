"""The parser of this process: quick where a text is as the grammar says, and lark's where it is not."""

from __future__ import annotations

from collections.abc import Iterator
from functools import cache, cached_property
from pathlib import Path
from typing import TYPE_CHECKING

from ..resources import grammar_file
from ..source import Source
from . import ast
from .build_module import TreeBuilder
from .driver import Driver
from .layout import Layout
from .tables import read_tables, tables_of
from .token import Token

if TYPE_CHECKING:
    from lark import Lark, UnexpectedInput


class Machine:
    """A parser with its lexical layout and its tree builder. Not for two parses at once."""

    def __init__(self, use_cache: bool = True) -> None:
        self.layout = Layout()
        self.builder = TreeBuilder(self.layout)
        self._text, self._cached = grammar_path().read_text(encoding="utf-8"), use_cache
        self.tables = read_tables(self._text) or tables_of(self.lark)
        self.layout.reserved = self.tables["reserved"]
        self._driver = Driver(self.tables, self.layout, self.builder)

    @cached_property
    def lark(self) -> Lark:
        """Lark's parser of the same grammar."""
        from .generator import generate  # start-up: for texts with mistakes, and a grammar that was changed

        return generate(self._text, self.layout, self._cached)

    def tree(self, source: Source, text: str) -> ast.Module | None:
        """The tree of ``text``, whose spans point into ``source``; None where it has none."""
        self.layout.begin(text)
        self.builder.begin(source)
        found: ast.Module | None = self._driver.parse(text)
        return found

    def loose(self, text: str, start: int, end: int) -> Iterator[Token]:
        """The tokens and comments in ``text[start:end]``, whatever the parser would make of them."""
        for found in self._driver.any.finditer(text, start, end):
            kind, value = found.lastgroup or "", found[0]
            if value.strip():
                yield Token(self.layout.reserved.get(value, kind), value, found.start(), found.end())

    def mistake(self, text: str) -> UnexpectedInput | None:
        """What keeps a text from having a tree, and where; the layout is left as it was there."""
        from lark import UnexpectedInput  # start-up: for texts with mistakes

        self.layout.begin(text)
        try:
            self.lark.parse(text)
        except UnexpectedInput as error:
            return error
        return None


def grammar_path() -> Path:
    """The file that defines the syntax."""
    return grammar_file()


def terminal_words() -> dict[str, str]:
    """Terminal names to words, for all terminals that are a word."""
    return {name: word for word, names in machine().tables["words"].items() for name in names}


def reserved_words() -> frozenset[str]:
    """The words that are never names."""
    return frozenset(machine().layout.reserved)


@cache
def machine() -> Machine:
    """The parser of this process, made at the first call."""
    return Machine()
