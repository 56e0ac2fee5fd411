"""Syntax errors in words: what stands there, what was expected, what to try.

First what the lexer cannot read, then what is never closed, then what the tokens before tell, then the table of
mistakes by example, and last what the parser would have taken.
"""

from __future__ import annotations

from typing import cast

from lark import Token, UnexpectedCharacters, UnexpectedInput, UnexpectedToken

from ...source import Source, Span
from .. import dangling
from ..grammar import Machine
from ..words import file_words, statement_words
from .accepted import by_accepts
from .characters import by_character
from .examples import key, table
from .found import Found, quoted, span_of
from .history import by_history
from .stop import Stop
from .unclosed import never_closed_at_end, never_closed_before


def describe(error: UnexpectedInput, tools: Machine, source: Source, text: str) -> Found:
    """What is wrong at the place where the parser stopped."""
    history = cast("list[Token]", list(tools.layout.seen))  # it has seen those of lark
    if isinstance(error, UnexpectedCharacters):
        return by_character(error.pos_in_stream or 0, source, text)
    assert isinstance(error, UnexpectedToken)
    token: Token = error.token
    if token.type != "$END" and history and history[-1].start_pos == token.start_pos:
        history.pop()
    if token.type == "$END":
        found = never_closed_at_end(error, history, source, text)
    elif (bar := dangling.find_bar([*history, token], text, statement_words() | file_words())) is not None:
        at = bar.start_pos or 0
        return Found("syntax", Span(source, at, at + 1), dangling.MESSAGE, at, dangling.HINT)
    else:
        found = never_closed_before(token, history, source) or by_history(Stop(error, history, tools, source, text))
    if found is not None:
        return found
    span = span_of(token, source, text)
    mistake = table(tools).get(key(error))
    if mistake is not None:
        return Found("syntax", span, mistake.message.replace("`{}`", quoted(token)), span.start, mistake.hint)
    return by_accepts(error, history, span)
