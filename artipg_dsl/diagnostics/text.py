"""Diagnostics as text for people: place, excerpt with carets, further places, hint."""

from __future__ import annotations

from collections.abc import Iterable

from ..source import Span
from .model import Diagnostic

COLOURS = {"error": "\x1b[1;31m", "warning": "\x1b[1;33m", "note": "\x1b[1;36m"}
BOLD, RESET, BLUE = "\x1b[1m", "\x1b[0m", "\x1b[34m"


def render(diagnostics: Iterable[Diagnostic], *, colour: bool) -> str:
    """All findings, each with its excerpt; a blank line between them."""
    return "\n\n".join(_one(d, colour) for d in diagnostics)


def summary(diagnostics: Iterable[Diagnostic]) -> str:
    """``2 errors, 1 warning``."""
    found = list(diagnostics)
    errors = sum(d.severity == "error" for d in found)
    warnings = len(found) - errors
    parts = [f"{n} {word}{'' if n == 1 else 's'}" for n, word in ((errors, "error"), (warnings, "warning")) if n]
    return ", ".join(parts) or "no errors"


def _paint(text: str, code: str, colour: bool) -> str:
    return f"{code}{text}{RESET}" if colour else text


def _one(d: Diagnostic, colour: bool) -> str:
    head = _paint(f"{d.severity}[{d.code}]", COLOURS[d.severity], colour)
    lines = [f"{head}: {_paint(d.message, BOLD, colour)}"]
    if d.span is not None:
        lines += _excerpt(d.span, "", colour, first=True)
    for span, text in d.notes:
        lines += _excerpt(span, text, colour)
    for span, text in reversed(d.trace[-4:]):
        lines.append(f"  {_paint('=', BLUE, colour)} {text} ({span})")
    if d.hint:
        lines.append(f"  {_paint('=', BLUE, colour)} help: {d.hint}")
    return "\n".join(lines)


def _excerpt(span: Span, text: str, colour: bool, *, first: bool = False) -> list[str]:
    source = span.source
    line, column = source.position(span.start)
    end_line, end_column = source.position(max(span.start, span.end - 1))
    content = source.line(line).replace("\t", " ")
    width = (end_column if end_line == line else len(content)) - column + 1
    number = str(line)
    gutter = " " * len(number)
    mark = ("^" if first else "-") * max(1, width)
    arrow = _paint("-->" if first else ":::", BLUE, colour)
    return [
        f"{gutter}{arrow} {source.name}:{line}:{column}",
        f"{gutter} |",
        f"{number} | {content}",
        f"{gutter} | {' ' * (column - 1)}{mark}{' ' + text if text else ''}",
    ]
