"""Files to texts. What is wrong with one goes to the report; loading needs no parser."""

from __future__ import annotations

import re
from pathlib import Path

from ..diagnostics import Report
from ..source import Source, Span

_TURNING = re.compile("[\u202a-\u202e\u2066-\u2069]")
"""The embeddings, overrides and isolates of the Unicode Bidirectional Algorithm (UAX 9, 2)."""


def load(
    path: Path, report: Report, name: str | None = None, *, missing: str = "check the path, or name a shipped category"
) -> Source | None:
    """Read a file; what is wrong with it goes to the report. ``name`` is shown in messages instead of the path; ``missing``: what to try
    where there is none."""
    shown = name or str(path)
    try:
        data = Path(path).read_bytes()
    except FileNotFoundError:
        report.error("missing-file", None, f"there is no file {shown}", hint=missing)
        return None
    except IsADirectoryError:
        report.error("missing-file", None, f"{shown} is a folder", hint="give the path of an .apg file in it")
        return None
    except OSError as error:
        report.error("missing-file", None, f"{shown} cannot be read: {error.strerror}")
        return None
    return decode(data, shown, report)


def decode(data: bytes, name: str, report: Report) -> Source | None:
    """The text that bytes are; what is wrong with them goes to the report."""
    try:
        return _shown_as_read(Source(name, to_text(data)), report)
    except UnicodeDecodeError as error:
        text = _as_lines(data[: error.start].decode("utf-8", "replace")) + "\N{REPLACEMENT CHARACTER}"
        source = Source(name, text)
        span = Span(source, len(text) - 1, len(text))
        report.error("not-utf8", span, "this file is not UTF-8 text", hint="save the file with UTF-8 encoding")
        return None


def _shown_as_read(source: Source, report: Report) -> Source:
    """Report what makes a text look different from what is read."""
    found = _TURNING.search(source.text)
    if found:
        report.error(
            "reversed-text",
            Span(source, found.start(), found.end()),
            f"the invisible character U+{ord(found.group()):04X} changes the order in which text is shown",
            hint="delete it: scripts that run from right to left need none",
        )
    return source


def to_text(data: bytes) -> str:
    """The text of a program in UTF-8, without a byte order mark. Raises UnicodeDecodeError."""
    return _as_lines(data.decode("utf-8-sig"))


def _as_lines(text: str) -> str:
    """The text with the ends of lines of any system as one character."""
    return text.replace("\r\n", "\n").replace("\r", "\n")
