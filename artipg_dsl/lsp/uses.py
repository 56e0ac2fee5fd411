"""Where a name is used: the places in some texts that stand for what one place stands for."""

from __future__ import annotations

import re
from collections.abc import Iterable, Iterator
from pathlib import Path

from ..source import Span
from .analysis import Analysis
from .lookup import Found, find

_Place = tuple[Path | None, int]


def uses(analysis: Analysis, offset: int, others: Iterable[Analysis] = ()) -> list[Span]:
    """What stands for the same declarations as the name at a place, these included: in its text, then in the others.

    What is declared in several branches or alternatives, and named for all of them somewhere, is one thing.
    """
    asked = find(analysis, offset)
    if asked is None or not asked.declared:
        return []
    wanted, found = _places(analysis, asked), list(_named(asked.span.text, (analysis, *others)))
    size = 0
    while len(wanted) > size:
        size = len(wanted)
        wanted = wanted.union(*(places for _, places in found if wanted & places))
    return [span for span, places in found if wanted & places]


def _named(name: str, texts: Iterable[Analysis]) -> Iterator[tuple[Span, set[_Place]]]:
    """What a name stands for at each of its places, and where that is declared."""
    word = re.compile(rf"\b{name}\b")
    for each in texts:
        for found in word.finditer(each.source.text):
            meant = find(each, found.start())
            if meant is not None and meant.span.start == found.start():
                yield Span(each.source, found.start(), found.end()), _places(each, meant)


def _places(analysis: Analysis, found: Found) -> set[_Place]:
    """Where something is declared, in terms that hold for all texts."""
    return {(analysis.path_of(span.source), span.start) for span in found.declared}
