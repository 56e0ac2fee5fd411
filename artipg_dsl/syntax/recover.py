"""Going on after a syntax error: the statement that holds it is blanked out, and the rest is parsed again."""

from __future__ import annotations

import re
from functools import cache

from .words import file_words, statement_words

_QUIET = re.compile(r'"(?:[^"\\\n]|\\[^\n])*"?|#[^\n]*')
_ELSE = re.compile(r"\s*else\b[^{}]*\{")  # the branch of a `when` that is gone goes with it
_TOP = re.compile(r"(?m)^(?:use|role|template|primitive|category|vocabulary)(?![A-Za-z0-9_])")


@cache
def _begins() -> re.Pattern[str]:
    """A line that begins a statement or ends a block."""
    words = "|".join(sorted(name.lower() for name in statement_words() | file_words()))
    return re.compile(rf"(?m)^[ \t]*(?:{words})(?![A-Za-z0-9_])|^[ \t]*\}}")


def _quiet(text: str) -> str:
    """The text with comments and strings blanked, for looking at braces."""
    return _QUIET.sub(lambda m: " " * len(m.group()), text)


def without_statement(text: str, place: int, line_alone: bool) -> str | None:
    """``text`` with the statement around ``place`` blanked; None where there is nothing sensible left to parse.

    A statement runs from the last line that begins like one to the next; with ``line_alone`` it is just its line.
    A block that it opens goes with it.
    """
    plain = _quiet(text)
    start = plain.rfind("\n", 0, place) + 1
    for match in _begins().finditer(plain):
        if match.start() > place or line_alone:
            break
        if match.group().strip() != "}":
            start = match.start()
    line_end = plain.find("\n", place)
    following = _begins().search(plain, line_end) if line_end >= 0 else None
    stop = following.start() if following is not None else len(text)
    if line_alone and line_end >= 0:
        stop = line_end
    end = _after_blocks(plain, start, stop)
    while end is not None and (otherwise := _ELSE.match(plain, end)):
        end = _after_blocks(plain, start, otherwise.end())
    if end is None or not plain[start:end].strip():
        return None
    return text[:start] + re.sub(r"[^\n]", " ", text[start:end]) + text[end:]


def _after_blocks(plain: str, start: int, end: int) -> int | None:
    """The end of what is blanked, so that its braces are balanced."""
    depth, index = 0, start
    while index < len(plain) and (index < end or depth > 0):
        if plain[index] == "{":
            depth += 1
        elif plain[index] == "}":
            if depth == 0:
                return index
            depth -= 1
        index += 1
    return index if depth == 0 else None


def opening_brace(text: str) -> int | None:
    """The brace that is never closed, None where all are.

    The braces alone only tell that one is missing. Where a block's closing brace stands further left than the line
    that opens it, or a declaration of the file begins at the left edge within a block, that block is the one.
    """
    plain = _quiet(text)
    stack: list[int] = []
    culprit: int | None = None
    for match in re.finditer(r"[{}]|" + _TOP.pattern.removeprefix("(?m)"), plain, re.M):
        if match.group() == "{":
            stack.append(match.start())
        elif match.group() == "}":
            if stack:
                opened = stack.pop()
                if culprit is None and _indent(plain, match.start()) < _indent(plain, opened):
                    culprit = opened
        elif stack and culprit is None:
            culprit = stack[-1]
    if not stack:
        return None
    return stack[-1] if culprit is None else culprit


def _indent(plain: str, place: int) -> int:
    start = plain.rfind("\n", 0, place) + 1
    line = plain[start:].split("\n", 1)[0]
    return len(line) - len(line.lstrip())
