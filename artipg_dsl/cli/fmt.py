"""``apgc fmt``: one layout for programs."""

from __future__ import annotations

import argparse
import difflib
import sys
from pathlib import Path

from ..diagnostics import Report
from ..errors import plural
from ..export.write import write_bytes
from ..syntax.format import format_source
from ..syntax.load import decode, load
from .messages import findings, say

_MISSING = "check the path; `apgc new NAME --from CATEGORY` copies a shipped category into a file"


def run(options: argparse.Namespace) -> int:
    report = Report()
    changed = read = 0
    for name in options.files:
        if name == "-":
            source = decode(sys.stdin.buffer.read(), "<stdin>", report)
        else:
            source = load(Path(name), report, missing=_MISSING)
        text = format_source(source, report) if source is not None else None
        if source is None or text is None:
            continue
        read += 1
        if name == "-" and not (options.check or options.diff):
            sys.stdout.write(text)
        elif text != source.text:
            changed += 1
            _differs(name, source.text, text, options)
    findings(report.diagnostics, sys.stdout)
    if "-" not in options.files:
        done = "would change" if options.check or options.diff else "changed"
        skipped = f", {len(options.files) - read} skipped" if read < len(options.files) else ""
        say(f"{plural(read, 'file')}: {changed} {done}{skipped}")
    return 1 if report.failed or (changed and options.check) else 0


def _differs(name: str, before: str, after: str, options: argparse.Namespace) -> None:
    if options.diff:
        lines = difflib.unified_diff(before.splitlines(True), after.splitlines(True), name, name)
        sys.stdout.writelines(line if line.endswith("\n") else line + "\n" for line in lines)
    elif options.check:
        print(name)
    else:
        write_bytes(name, after.encode(), force=True)
