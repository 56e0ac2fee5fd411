"""``apgc check``: the findings in programs, as text, JSON or SARIF."""

from __future__ import annotations

import argparse
import sys

from ..diagnostics import Report
from .compile import of_text


def run(options: argparse.Namespace) -> int:
    report = Report()  # tells of a module once, however many of the files use it
    for name in options.files:
        report.extend(_examine(name))
    found = report.diagnostics
    if options.json or options.sarif:
        from ..diagnostics.data import to_json, to_sarif
        from ..version import __version__

        print(to_sarif(found, __version__) if options.sarif else to_json(found))
    else:
        from ..diagnostics.text import summary
        from ..errors import plural
        from .messages import findings, say

        findings(found, sys.stdout)
        say(f"{plural(len(options.files), 'file')}: {summary(found)}")
    return 1 if report.failed or (options.strict and found) else 0


def _examine(name: str) -> Report:
    """The findings in one file: those of its text, and of its category as far as it can be put in order."""
    return of_text(name).examine()
