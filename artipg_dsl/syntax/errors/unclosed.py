"""Brackets and braces that are never closed."""

from __future__ import annotations

from lark import Token, UnexpectedToken

from ...source import Source, Span
from ..recover import opening_brace
from ..words import file_words, statement_words
from .found import Found

_ALSO_VALUES = frozenset("OUT BOX INSIDE CLOSE FREE CLEAR FIELD LIMIT".split())  # words that may stand in brackets
_PAIRS = {"LPAR": "(", "LSQB": "["}


def never_closed_at_end(error: UnexpectedToken, history: list[Token], source: Source, text: str) -> Found | None:
    bracket = open_bracket(history)
    if bracket is not None:
        return _never_closed(bracket, source)
    at = opening_brace(text)
    if at is None:
        return None
    accepted = error.accepts or set()
    if "RBRACE" not in accepted and not _may_end(history, accepted):
        return None
    return brace_never_closed(at, source)


def _may_end(history: list[Token], accepted: set[str]) -> bool:
    return not history or history[-1].type in ("_NL", "LBRACE", "RBRACE") or "_NL" in accepted


def never_closed_before(token: Token, history: list[Token], source: Source) -> Found | None:
    """A statement begins, or a block ends, within brackets."""
    bracket = open_bracket(history)
    begins = token.type in (statement_words() | file_words()) - _ALSO_VALUES
    if bracket is not None and token.type == "LBRACE" and history[-1].type in ("EQUAL", "COMMA", "LPAR", "LSQB"):
        start = token.start_pos or 0
        return Found(
            "syntax",
            Span(source, start, start + 1),
            "a vector is written in square brackets",
            start,
            "write `[x, y, z]`",
        )
    if bracket is not None and (begins and first_on_line(token, source) or token.type in ("LBRACE", "RBRACE")):
        return _never_closed(bracket, source)
    if bracket is not None and token.type in ("RPAR", "RSQB") and (bracket.type == "LPAR") != (token.type == "RPAR"):
        return _never_closed(bracket, source)
    return None


def _never_closed(bracket: Token, source: Source) -> Found:
    start = bracket.start_pos or 0
    closing = {"(": ")", "[": "]"}[bracket.value]
    return Found(
        "missing-bracket",
        Span(source, start, start + 1),
        "this bracket is never closed",
        start,
        f"add the missing `{closing}`",
    )


def brace_never_closed(at: int, source: Source) -> Found:
    return Found(
        "missing-brace", Span(source, at, at + 1), "this brace is never closed", at, "add the missing `}`", fatal=True
    )


def open_bracket(history: list[Token]) -> Token | None:
    """The innermost round or square bracket that is open behind these tokens."""
    stack: list[Token] = []
    for token in history:
        if token.type in _PAIRS:
            stack.append(token)
        elif token.type in ("RPAR", "RSQB") and stack:
            stack.pop()
        elif token.type in ("LBRACE", "RBRACE"):
            stack.clear()
    return stack[-1] if stack else None


def first_on_line(token: Token, source: Source) -> bool:
    start = token.start_pos or 0
    return not source.text[source.text.rfind("\n", 0, start) + 1 : start].strip()
