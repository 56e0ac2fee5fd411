"""Between lexer and parser: which line ends count, which words are reserved, what the comments say."""

from __future__ import annotations

import re
from collections.abc import Iterator, Mapping

from .token import Token

_OPENING = {"LPAR", "LSQB"}
_CLOSING = {"RPAR", "RSQB"}

CONTINUES = frozenset(
    "_NL LBRACE COMMA COLON EQUAL BAR ARROW UPTO UNTIL PLUS MINUS STAR SLASH CARET EQUALS UNEQUAL LESS AT_MOST MORE "
    "AT_LEAST AND OR NOT IS IF ON IN TILDE DOT".split()
)
"""Tokens that cannot end a statement: a line end behind one of them does not count."""

_CONTINUED = re.compile(r"(?:[ \t\f\r]*(?:#[^\n]*)?\n)*[ \t\f\r]*(?:\||\{|else(?![A-Za-z0-9_]))")
"""What stands behind a line end that does not count: ``|``, ``{`` or ``else``, comment lines between."""


class Layout:
    """Between lexer and parser, ours or lark's (its postlex stage). ``seen`` are the tokens that the parser got in this parse,
    ``comments`` the others.
    """

    always_accept = ("_NL",)

    def __init__(self) -> None:
        self.text = ""
        self.reserved: Mapping[str, str] = {}
        self.comments: list[Token] = []
        self.seen: list[Token] = []
        self._pending: list[Token] = []
        self._leading: dict[int, str] = {}
        self._trailing: list[Token] = []

    def begin(self, text: str) -> None:
        self.text = text
        self.comments = []
        self.seen = []
        self._pending.clear()
        self._leading.clear()
        self._trailing.clear()

    def comment(self, token: Token) -> Token:
        """Called by the lexer for every comment."""
        self.comments.append(token)
        if token.type == "DOC":
            line_start = self.text.rfind("\n", 0, token.start_pos) + 1
            if self.text[line_start : token.start_pos].strip():
                self._trailing.append(token)
            else:
                self._pending.append(token)
        return token

    def process(self, stream: Iterator[Token]) -> Iterator[Token]:
        """Drops the line ends that do not count and turns reserved words that were read as names into what they are."""
        depth = 0
        last = "_NL"
        reserved, seen = self.reserved, self.seen
        for token in stream:
            kind = token.type
            if kind == "_NL":
                if depth or last in CONTINUES or _CONTINUED.match(self.text, token.end_pos):
                    continue
            elif kind in _OPENING:
                depth += 1
            elif kind in _CLOSING:
                depth -= depth > 0
            elif kind == "NAME" and token.value in reserved:
                token = token.update(reserved[token.value])
            if kind != "_NL" and self._pending:
                self._leading[token.start_pos] = "\n".join(_words(t) for t in self._pending)
                self._pending.clear()
            last = kind
            seen.append(token)
            yield token

    def doc(self, start: int, end: int) -> str:
        """The doc comment of what stands at ``start .. end``: before it, or behind it on its first or last line."""
        leading = self._leading.pop(start, "")
        for index, token in enumerate(self._trailing):
            place = token.start_pos
            if place < start:
                continue
            rest = self.text[end:place] if place >= end else self.text[start:place]
            if "\n" not in rest:
                del self._trailing[index]
                text = _words(token)
                return f"{leading}\n{text}" if leading else text
        return leading


def _words(token: Token) -> str:
    return token.value.lstrip("#").strip()
