"""Where a name is used: the places in some texts that stand for what one place stands for."""

from __future__ import annotations

import re
from collections.abc import Iterable, Iterator
from pathlib import Path

from ..source import Span
from .analysis import Analysis
from .lookup import Found, find

_Place = tuple[Path | None, int]


def uses(analysis: Analysis, offset: int, others: Iterable[Analysis] = ()) -> Iterator[Span]:
    """What stands for the same declarations as the name at a place, these included: in its text, then in the others."""
    asked = find(analysis, offset)
    if asked is None or not asked.declared:
        return
    wanted, word = _places(analysis, asked), re.compile(rf"\b{asked.span.text}\b")
    for each in (analysis, *others):
        for found in word.finditer(each.source.text):
            meant = find(each, found.start())
            if meant is not None and meant.span.start == found.start() and wanted & _places(each, meant):
                yield Span(each.source, found.start(), found.end())


def _places(analysis: Analysis, found: Found) -> set[_Place]:
    """Where something is declared, in terms that hold for all texts."""
    return {(analysis.path_of(span.source), span.start) for span in found.declared}
