"""Where the parser stopped: the token, those before it, and what it would have taken."""

from __future__ import annotations

from functools import cached_property

from lark import Token, UnexpectedToken

from ...source import Source
from ..grammar import Machine
from ..words import VALUE, file_words, statement_words
from .found import Found, Notes, span_of


class Stop:
    """``before``: the tokens before; ``text``: what the parser has read of the ``source``, with statements that were wrong blanked."""

    def __init__(self, error: UnexpectedToken, before: list[Token], tools: Machine, source: Source, text: str):
        self.token: Token = error.token
        self.before, self.tools, self.source, self.text = before, tools, source, text
        self.accepted: set[str] = error.accepts or set()
        self.span = span_of(self.token, source, text)

    @property
    def values(self) -> bool:
        """Whether a value may stand here."""
        return self.accepted >= VALUE

    @cached_property
    def opener(self) -> Token | None:
        """The word that begins the statement, the condition of a label or that of a value, whichever is nearest."""
        begins = statement_words() | file_words() | {"WHERE", "IF"}
        return next((t for t in reversed(self.before) if t.type in begins), None)

    def within(self, *types: str) -> bool:
        """Whether the nearest opener is one of these."""
        return self.opener is not None and self.opener.type in types

    def since(self, word: Token) -> set[str]:
        """The types of the tokens from a word on."""
        at = next(k for k, token in enumerate(self.before) if token is word)  # tokens of equal texts are equal
        return {t.type for t in self.before[at:]}

    def follows(self, *types: str) -> bool:
        """Whether these are the last tokens."""
        return [t.type for t in self.before[-len(types) :]] == list(types)

    def touches(self, last: Token) -> bool:
        """Whether nothing is between the token before and this one."""
        return last.end_pos == self.token.start_pos

    def found(self, message: str, hint: str | None = None, code: str = "syntax", notes: Notes = ()) -> Found:
        """An error at this token."""
        return Found(code, self.span, message, self.span.start, hint, notes)

    def found_at(self, token: Token, message: str, hint: str) -> Found:
        """An error at a token before."""
        span = span_of(token, self.source, self.text)
        return Found("syntax", span, message, span.start, hint)
