"""``apgc check``: the findings in programs, as text, JSON or SARIF."""

from __future__ import annotations

import argparse
import sys

from ..diagnostics import CompileError, Diagnostic
from ..session import Session


def run(options: argparse.Namespace) -> int:
    found: dict[Diagnostic, None] = {}
    for name in options.files:
        for diagnostic in examine(name):
            found[diagnostic] = None  # a module that several files use is told of once
    failed = any(d.severity == "error" for d in found)
    if options.json or options.sarif:
        from .. import __version__
        from ..diagnostics.data import to_json, to_sarif

        print(to_sarif(found, __version__) if options.sarif else to_json(found))
    else:
        from ..diagnostics.text import summary
        from .report import findings, say

        findings(found, sys.stdout)
        files = "1 file" if len(options.files) == 1 else f"{len(options.files)} files"
        say(f"{files}: {summary(found)}")
    return 1 if failed else 0


def examine(name: str) -> tuple[Diagnostic, ...]:
    """The findings in one file: those of its text, and of its category as far as it can be put in order."""
    session = Session.of(name)
    if session.lowering is not None:
        try:
            _ = session.sampler
        except CompileError:
            pass  # it has told the report
    return session.report.diagnostics
