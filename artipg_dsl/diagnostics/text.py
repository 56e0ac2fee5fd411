"""Diagnostics as text for people: place, excerpt with carets, further places, hint."""

from __future__ import annotations

from collections.abc import Iterable
from typing import TYPE_CHECKING
from unicodedata import combining, east_asian_width

from ..errors import plural, printable
from ..source import Span

if TYPE_CHECKING:
    from .model import Diagnostic

_COLOURS = {"error": "\x1b[1;31m", "warning": "\x1b[1;33m"}
BOLD, RESET, BLUE = "\x1b[1m", "\x1b[0m", "\x1b[34m"
_MOST_TRACE = 4


def render(diagnostics: Iterable[Diagnostic], *, colour: bool) -> str:
    """All findings, each with its excerpt; a blank line between them."""
    return "\n\n".join(_one(d, colour) for d in diagnostics)


def summary(diagnostics: Iterable[Diagnostic]) -> str:
    """``2 errors, 1 warning``."""
    found = list(diagnostics)
    errors = sum(d.severity == "error" for d in found)
    warnings = len(found) - errors
    parts = [plural(n, word) for n, word in ((errors, "error"), (warnings, "warning")) if n]
    return ", ".join(parts) or "no errors"


def _paint(text: str, code: str, colour: bool) -> str:
    return f"{code}{text}{RESET}" if colour else text


def _one(d: Diagnostic, colour: bool) -> str:
    paint = _COLOURS[d.severity]
    lines = [f"{_paint(f'{d.severity}[{d.code}]', paint, colour)}: {_paint(printable(d.message), BOLD, colour)}"]
    shown = [s for s in (d.span, *(s for s, _ in d.notes)) if s is not None]
    gutter = max((len(str(s.line)) for s in shown), default=1)
    if d.span is not None:
        lines += _excerpt(d.span, "", gutter, colour, "^", paint)
    for span, text in d.notes:
        lines += _excerpt(span, text, gutter, colour, "-", BLUE)
    bullet = " " * gutter + " " + _paint("=", BLUE, colour)
    lines += [f"{bullet} {printable(text)} ({span})" for span, text in reversed(d.trace[-_MOST_TRACE:])]
    if len(d.trace) > _MOST_TRACE:
        lines.append(f"{bullet} and {len(d.trace) - _MOST_TRACE} more around it")
    if d.hint:
        lines.append(f"{bullet} help: {printable(d.hint)}")
    return "\n".join(lines)


def _excerpt(span: Span, text: str, gutter: int, colour: bool, mark: str, paint: str) -> list[str]:
    """The first line of a span with a mark below it; of a longer one it says where it ends."""
    source = span.source
    line, column = source.position(span.start)
    end_line, end_column = source.position(max(span.start, span.end - 1))
    content = printable(source.line(line).replace("\t", " "))
    before = content[: column - 1]
    marked = content[column - 1 : end_column if end_line == line else None]
    under = _paint(mark * max(1, _width(marked)), paint, colour)
    if end_line > line:
        under += f" ... to line {end_line}"
    blank = " " * gutter
    return [
        f"{blank}{_paint('-->' if mark == '^' else ':::', BLUE, colour)} {source.name}:{line}:{column}",
        f"{blank} |",
        f"{line:>{gutter}} | {content}",
        f"{blank} | {' ' * _width(before)}{under}{' ' + printable(text) if text else ''}",
    ]


def _width(text: str) -> int:
    """The columns that a text takes in a terminal: two for wide letters, none for combining ones."""
    return sum(0 if combining(c) else 2 if east_asian_width(c) in "WF" else 1 for c in text)
