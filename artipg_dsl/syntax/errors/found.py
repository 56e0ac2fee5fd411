"""A syntax error in words, and how it calls the token at which the parser stopped."""

from __future__ import annotations

from typing import NamedTuple

from lark import Token

from ...source import Source, Span

Notes = tuple[tuple[Span, str], ...]


class Found(NamedTuple):
    """A syntax error: what to say, and the offset where parsing stopped."""

    code: str
    span: Span
    message: str
    place: int
    hint: str | None = None
    notes: Notes = ()
    fatal: bool = False  # what follows would only be consequences
    line_alone: bool = False  # the statement before is complete
    told: bool = False  # it follows from an error before it


def span_of(token: Token, source: Source, text: str) -> Span:
    if token.type == "$END":
        end = len(text.rstrip())
        return Span(source, max(0, end - 1), end)
    return Span(source, token.start_pos or 0, token.end_pos or 0)


def quoted(token: Token) -> str:
    shown = _shown(token)
    return shown if token.type in ("_NL", "$END") else f"`{shown}`"


def _shown(token: Token) -> str:
    if token.type == "_NL":
        return "the end of the line"
    return "the end of the file" if token.type == "$END" else token.value
