"""What each word of a text is, for an editor to colour: keywords, types, templates, functions, numbers, comments."""

from __future__ import annotations

from collections.abc import Iterator
from typing import NamedTuple

from ..language import FUNCTIONS, TYPES
from ..source import Source, Span
from ..syntax.parse import tokens_of
from ..syntax.token import Token

KINDS = ("keyword", "type", "class", "function", "property", "variable", "number", "string", "comment")
"""The protocol's names for them."""

_ALWAYS = {
    "COMMENT": "comment",
    "DOC": "comment",
    "STRING": "string",
    "NUMBER": "number",
    "QUANTITY": "number",
    "FRACTION": "number",
}


class Colour(NamedTuple):
    span: Span
    kind: str


def colours(source: Source) -> Iterator[Colour]:
    """The words of a text in their order, operators left out. A span is within one line."""
    tokens = tokens_of(source)
    before = "", ""
    for token, following in zip(tokens, [*tokens[1:], None], strict=True):
        kind = _ALWAYS.get(token.type) or _of_word(token, before, "" if following is None else following.type)
        if kind is not None:
            yield Colour(Span(source, token.start_pos, token.start_pos + len(token.value.rstrip())), kind)
        before = token.type, token.value


def _of_word(token: Token, before: tuple[str, str], following: str) -> str | None:
    """The kind of a word by itself and its neighbours; None for an operator."""
    word = token.value
    if not (word[0].isalpha() or word[0] == "_"):
        return None
    if before[0] == "DOT":
        return "property"
    if token.type not in ("NAME", "WORD"):
        return "keyword"
    if word in TYPES and before[0] in ("COLON", "STYLE"):
        return "type"
    if word[0].isupper():
        return "class"
    return "function" if following == "LPAR" and word in FUNCTIONS else "variable"
