"""Compilations that were made before: what a file compiles to, and the findings in it, as entries of the cache.

An entry is found by the text of the file, its name and folder, and the compiler. It says which other files were read and which
were looked for in vain; where one of them is not as it was, the entry counts for nothing. Findings point into these texts again.
"""

from __future__ import annotations

import json
from collections.abc import Iterable, Mapping
from pathlib import Path
from typing import Any

from . import cache
from .diagnostics import Diagnostic
from .shapes import Misfit, fit
from .source import Source, Span
from .syntax.load import to_text

_SEVERITIES = ("error", "warning")


def _named(kind: str, source: Source, folder: Path) -> str:
    """The name of the entry of a kind for a text in a folder."""
    return cache.key(kind, source.name, str(folder.resolve()), source.text)


def recall(kind: str, source: Source, folder: Path) -> tuple[list[Diagnostic], str] | None:
    """The findings in a text and what else was kept of it; None where nothing holds any more."""
    if cache.folder() is None:
        return None
    name = _named(kind, source, folder)
    body = cache.read(name)
    if body is None:
        return None
    try:
        head, _, rest = body.decode("utf-8").partition("\n")
        held = json.loads(head)
        fit(held["read"], list[list[str]])
        fit(held["absent"], list[str])
        sources = [source]
        for path, shown, seen in held["read"]:
            text = _reading(Path(path))
            if text is None or cache.digest([text]) != seen:
                return None
            sources.append(Source(shown, text))
        if any(Path(path).is_file() for path in held["absent"]):
            return None
        return [_diagnostic(item, sources) for item in held["findings"]], rest
    except (OSError, ValueError, KeyError, TypeError, IndexError, Misfit, RecursionError):
        cache.drop(name)
        return None


def keep(
    kind: str,
    source: Source,
    folder: Path,
    files: Mapping[Path, Source],
    absent: Iterable[Path],
    report: Iterable[Diagnostic],
    rest: str = "",
) -> None:
    """Keep the findings in a text, and what else follows from it: after ``files`` were read, and others were ``absent``."""
    if cache.folder() is None:
        return
    sources = {(source.name, source.text): 0}
    for other in files.values():
        sources.setdefault((other.name, other.text), len(sources))
    read = [[str(path), other.name, cache.digest([other.text])] for path, other in files.items()]
    if len(sources) != len(read) + 1:
        return  # a text that reads itself, which is refused anyway
    try:
        findings = [_numbered(item, sources) for item in report]
    except KeyError:  # a place in a text that was not read as a file
        return
    held = {"read": read, "absent": [str(path) for path in absent], "findings": findings}
    cache.write(_named(kind, source, folder), (json.dumps(held) + "\n" + rest).encode("utf-8", "surrogatepass"))


def _reading(path: Path) -> str | None:
    """The text of a file as the compiler takes it; None where it cannot be read."""
    try:
        return to_text(path.read_bytes())
    except (OSError, UnicodeDecodeError):
        return None


# ---------------------------------------------------------------- findings


def _numbered(found: Diagnostic, sources: Mapping[tuple[str, str], int]) -> list[Any]:
    def place(span: Span) -> list[int]:
        return [sources[span.source.name, span.source.text], span.start, span.end]

    notes, trace = ([[place(span), text] for span, text in held] for held in (found.notes, found.trace))
    span = None if found.span is None else place(found.span)
    return [found.code, found.message, span, found.severity, found.hint, notes, trace]


def _diagnostic(item: Any, sources: list[Source]) -> Diagnostic:
    """Raises where the item is no finding in these sources."""
    from .diagnostics.codes import CODES  # start-up

    fit(item, list)
    code, message, place, severity, hint, notes, trace = item
    fit([code, message, severity, hint or ""], list[str])
    if code not in CODES or severity not in _SEVERITIES:
        raise ValueError(code)

    def span(of: Any) -> Span:
        fit(of, list[int])
        number, start, end = of
        text = sources[number].text
        if number < 0 or not 0 <= start <= end <= len(text):
            raise ValueError(of)
        return Span(sources[number], start, end)

    def spans(held: Any) -> tuple[tuple[Span, str], ...]:
        fit(held, list)
        for _, text in held:
            fit(text, str)
        return tuple((span(of), text) for of, text in held)

    at = None if place is None else span(place)
    return Diagnostic(code, message, at, severity, hint, spans(notes), spans(trace))
