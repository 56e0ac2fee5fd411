"""Syntax errors in words."""

from __future__ import annotations

from typing import NamedTuple

from lark import UnexpectedCharacters, UnexpectedInput, UnexpectedToken

from ..source import Source, Span
from .grammar import Machine
from .recover import opening_brace


class Found(NamedTuple):
    """A syntax error: what to say, and the offset where parsing stopped."""

    code: str
    span: Span
    message: str
    place: int
    hint: str | None = None
    notes: tuple[tuple[Span, str], ...] = ()


def describe(error: UnexpectedInput, tools: Machine, source: Source, text: str) -> Found:
    """What is wrong at the place where the parser stopped."""
    if isinstance(error, UnexpectedToken) and error.token.type != "$END":
        token = error.token
        span = Span(source, token.start_pos or 0, token.end_pos or 0)
        return Found("syntax", span, f"`{token}` cannot stand here", span.start)
    if isinstance(error, UnexpectedCharacters):
        at = error.pos_in_stream
        if text[at] == '"':
            return Found("unterminated-string", Span(source, at, at + 1), "this text has no closing quote on its line", at)
        return Found("syntax", Span(source, at, at + 1), f"`{text[at]}` cannot stand here", at)
    at = opening_brace(text)
    if at is not None:
        return Found("missing-brace", Span(source, at, at + 1), "this brace is never closed", at, "add the missing `}`")
    end = len(text.rstrip())
    return Found("syntax", Span(source, end, end), "the text ends too early", end)
