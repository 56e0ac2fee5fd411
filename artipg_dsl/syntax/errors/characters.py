"""What the lexer cannot read."""

from __future__ import annotations

import re

from ...source import Source, Span
from .foreign import CHARACTERS, MICROMETRES
from .found import Found

_OF_TARGETS = re.compile(r"\s*(label|material|field|connect|joint)\b(?!.*\b(?:where|when)\b)")


def by_character(at: int, source: Source, text: str) -> Found:
    char = text[at]
    span = Span(source, at, at + 1)
    if char == '"':
        line_end = text.find("\n", at)
        whole = Span(source, at, len(text) if line_end < 0 else line_end)
        return Found("unterminated-string", whole, "this text has no closing quote on its line", at, 'end it with `"`')
    if char.isalpha():
        start = at
        while start and (text[start - 1].isalnum() or text[start - 1] == "_"):
            start -= 1
        word = re.compile(r"\w+").match(text, start)
        assert word is not None
        span = Span(source, start, word.end())
        if char in CHARACTERS:
            return Found("syntax", Span(source, at, at + 1), f"`{char}` has no meaning here", at, CHARACTERS[char])
        if unit := word.group().lstrip("0123456789") if word.group()[0].isdigit() else "":
            told = "write it in mm: a micrometre is `0.001mm`" if unit in MICROMETRES else "use mm, cm, m, deg, kg or s"
            return Found("syntax", span, f"there is no unit `{unit}`", start, told)
        return Found(
            "syntax",
            span,
            f"`{word.group()}` is not a valid name",
            start,
            "a name consists of the letters a to z, digits and `_`",
        )
    if char == "&" and (statement := _OF_TARGETS.match(source.line(span.line))):
        said = "targets are separated by commas, as in `on body, lid`"
        once = "a part is attached once, to one place; a `connect` attaches one part"
        hint = said if statement[1] in ("label", "material", "field") else once
        return Found("syntax", span, f"`{char}` has no meaning here", at, hint)
    shown = f"`{char}`" if char.isprintable() else f"the character U+{ord(char):04X}"
    return Found("syntax", span, f"{shown} has no meaning here", at, CHARACTERS.get(char))
