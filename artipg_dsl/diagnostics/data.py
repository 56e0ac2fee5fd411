"""Diagnostics as data for tools: JSON and SARIF."""

from __future__ import annotations

import json
from collections.abc import Iterable
from typing import Any
from urllib.parse import quote

from ..source import Span
from .codes import CODES
from .model import Diagnostic


def _place(span: Span | None) -> dict[str, Any] | None:
    """File, and line and column from 1 at both ends (the end is behind the last character)."""
    if span is None:
        return None
    line, column = span.source.position(span.start)
    end_line, end_column = span.source.position(span.end)
    return {"file": span.source.name, "line": line, "column": column, "end_line": end_line, "end_column": end_column}


def to_json(diagnostics: Iterable[Diagnostic]) -> str:
    """A JSON list of findings."""
    rows = [
        {
            "code": d.code,
            "severity": d.severity,
            "message": d.message,
            "place": _place(d.span),
            "hint": d.hint,
            "notes": [{"place": _place(s), "message": t} for s, t in d.notes],
            "trace": [{"place": _place(s), "message": t} for s, t in d.trace],
        }
        for d in diagnostics
    ]
    return json.dumps(rows, indent=2)


def to_sarif(diagnostics: Iterable[Diagnostic], version: str) -> str:
    """SARIF 2.1.0, which code hosts and editors read: with each finding its hint, further places and rule."""
    found = list(diagnostics)
    rules = [
        {
            "id": name,
            "shortDescription": {"text": CODES[name].summary},
            "fullDescription": {"text": CODES[name].text},
            "help": {"text": f"apgc explain {name}"},
        }
        for name in sorted({d.code for d in found})
    ]
    results = []
    for d in found:
        text = f"{d.message}. Help: {d.hint}" if d.hint else d.message
        result: dict[str, Any] = {"ruleId": d.code, "level": d.severity, "message": {"text": text}}
        if d.span is not None:
            result["locations"] = [_location(d.span)]
        related = [{**_location(span), "message": {"text": words}} for span, words in (*d.notes, *reversed(d.trace))]
        if related:
            result["relatedLocations"] = related
        results.append(result)
    driver = {"name": "apgc", "version": version, "rules": rules}
    run = {"tool": {"driver": driver}, "columnKind": "unicodeCodePoints", "results": results}
    return json.dumps({"version": "2.1.0", "runs": [run]}, indent=2)


def _location(span: Span) -> dict[str, Any]:
    """A place as SARIF writes it: the file as a relative or absolute reference, the region from 1."""
    where = _place(span)
    assert where is not None
    region = {
        "startLine": where["line"],
        "startColumn": where["column"],
        "endLine": where["end_line"],
        "endColumn": where["end_column"],
    }
    return {"physicalLocation": {"artifactLocation": {"uri": quote(where["file"])}, "region": region}}
