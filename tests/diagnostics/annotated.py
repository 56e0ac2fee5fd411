"""Programs with the findings written beside the lines that cause them.

    part x Cuboid          #! 10 syntax: `:` is missing between the name and its type (for example `part door : SlabDoor`)

The number is the column, the hint stands in parentheses. Warnings say so: ``#! 3 warning redundant: ...``. Several findings on one line are
separated by ``#!``. What has no place in the file itself stands on its first line, with a ``-`` for the column.
"""

from __future__ import annotations

import re
from collections.abc import Iterable

from artipg_dsl.diagnostics import Diagnostic
from artipg_dsl.source import Source

_MARK = re.compile(r"[ \t]*#!.*")


def bare(text: str) -> str:
    """The program without its annotations."""
    return "\n".join(_MARK.sub("", line) for line in text.split("\n"))


def annotate(source: Source, diagnostics: Iterable[Diagnostic]) -> str:
    """The program with the findings written beside their lines."""
    lines = source.text.split("\n")
    for d in diagnostics:
        here = d.span is not None and d.span.source.name == source.name
        line, column = source.position(d.span.start) if here else (1, "-")
        severity = "" if d.severity == "error" else f"{d.severity} "
        hint = "" if d.hint is None else f" ({d.hint})"
        lines[line - 1] += f"  #! {column} {severity}{d.code}: {d.message}{hint}"
    return "\n".join(lines)
