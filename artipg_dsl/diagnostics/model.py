"""The diagnostic and the report that collects them."""

from __future__ import annotations

from typing import Any

from ..records import dataclass
from ..source import Span
from .text import render

Notes = tuple[tuple[Span, str], ...]


@dataclass(frozen=True, slots=True)
class Diagnostic:
    """One finding. ``span`` is None where there is no text to show (a file that is missing).

    ``notes`` are further places that belong to it; ``trace`` the parts through which a template was instantiated,
    outermost first.
    """

    code: str
    message: str
    span: Span | None
    severity: str = "error"
    hint: str | None = None
    notes: Notes = ()
    trace: Notes = ()


class Report:
    """Collects diagnostics; the same finding at the same place counts once, however often a template is used."""

    def __init__(self) -> None:
        self._found: dict[tuple[Any, ...], Diagnostic] = {}

    def add(self, diagnostic: Diagnostic) -> None:
        from .codes import CODES  # start-up: what explains a hundred codes, where most programs have no finding

        if diagnostic.code not in CODES:
            raise KeyError(f"diagnostic code {diagnostic.code!r} is not registered in diagnostics/codes.py")
        span = diagnostic.span
        place = None if span is None else (span.source.name, span.start, span.end)
        self._found.setdefault((diagnostic.code, place, diagnostic.message), diagnostic)

    def error(
        self,
        code: str,
        span: Span | None,
        message: str,
        *,
        hint: str | None = None,
        notes: Notes = (),
        trace: Notes = (),
    ) -> None:
        self.add(Diagnostic(code, message, span, "error", hint, tuple(notes), tuple(trace)))

    def warning(
        self,
        code: str,
        span: Span | None,
        message: str,
        *,
        hint: str | None = None,
        notes: Notes = (),
        trace: Notes = (),
    ) -> None:
        self.add(Diagnostic(code, message, span, "warning", hint, tuple(notes), tuple(trace)))

    def extend(self, other: Report) -> None:
        for diagnostic in other.diagnostics:
            self.add(diagnostic)

    @property
    def diagnostics(self) -> tuple[Diagnostic, ...]:
        """All findings by file, in the order of the text; those without a place first."""

        def place(d: Diagnostic) -> tuple[Any, ...]:
            return ("", -1) if d.span is None else (d.span.source.name, d.span.start)

        return tuple(sorted(self._found.values(), key=place))

    @property
    def failed(self) -> bool:
        return any(d.severity == "error" for d in self._found.values())


class CompileError(Exception):
    """A program has errors; ``report`` holds them. The text is the first message with its place."""

    def __init__(self, report: Report):
        self.report = report
        super().__init__("\n" + render(report.diagnostics, colour=False))
