"""Files to texts. What is wrong with one goes to the report; loading needs no parser."""

from __future__ import annotations

from pathlib import Path

from ..diagnostics import Report
from ..source import Source, Span


def load(path: Path, report: Report, name: str | None = None) -> Source | None:
    """Read a file; what is wrong with it goes to the report. ``name`` is shown in messages instead of the path."""
    shown = name or str(path)
    try:
        data = Path(path).read_bytes()
    except FileNotFoundError:
        report.error(
            "missing-file", None, f"there is no file {shown}", hint="check the path, or name a shipped category"
        )
        return None
    except IsADirectoryError:
        report.error("missing-file", None, f"{shown} is a folder", hint="give the path of an .apg file in it")
        return None
    except OSError as error:
        report.error("missing-file", None, f"{shown} cannot be read: {error.strerror}")
        return None
    try:
        return Source(shown, _as_lines(data.decode("utf-8-sig")))
    except UnicodeDecodeError as error:
        text = _as_lines(data[: error.start].decode("utf-8", "replace")) + "\N{REPLACEMENT CHARACTER}"
        source = Source(shown, text)
        span = Span(source, len(text) - 1, len(text))
        report.error("not-utf8", span, "this file is not UTF-8 text", hint="save the file with UTF-8 encoding")
        return None


def _as_lines(text: str) -> str:
    """The text with the ends of lines of any system as one character."""
    return text.replace("\r\n", "\n").replace("\r", "\n")
