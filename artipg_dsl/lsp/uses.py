"""Where a name is used: the places in some texts that stand for what one place stands for."""

from __future__ import annotations

import re
from collections.abc import Iterable, Iterator
from pathlib import Path

from ..resources import library_dir
from ..semantics.symbols import lineage, name_spans_of, names_of
from ..source import Span
from ..syntax import ast
from ..syntax.walk import walk
from .analysis import Analysis
from .lookup import Found, find

_USE = re.compile(r"(?m)^\s*use\s+(\w+)")
_Place = tuple[Path | None, int]


def uses(analysis: Analysis, offset: int, others: Iterable[Analysis] = ()) -> list[Span]:
    """What stands for the same declarations as the name at a place, these included: in its text, then in the others.

    What is declared in several branches or alternatives, and named for all of them somewhere, is one thing; so is what a role
    states and its templates bind.
    """
    asked = find(analysis, offset)
    if asked is None or not asked.declared:
        return []
    wanted = _places(analysis, asked)
    texts = (analysis, *_reaching(wanted, analysis, others))
    found = list(_named(asked.span.text, texts))
    bound = [places for text in texts for places in _bound(asked.span.text, text)]
    size = 0
    while len(wanted) > size:
        size = len(wanted)
        wanted = wanted.union(*(places for places in (*bound, *(places for _, places in found)) if wanted & places))
    return [span for span, places in found if wanted & places]


def _reaching(places: set[_Place], analysis: Analysis, others: Iterable[Analysis]) -> list[Analysis]:
    """Those of the other texts that can name what is declared at some places: they use its module, or one that does."""
    others = list(others)
    reached = {path.stem for path, _ in places if path is not None}
    if any(path is None or path.is_relative_to(library_dir()) for path, _ in places):
        return others
    used = {each: set(_USE.findall(each.source.text)) for each in (analysis, *others)}
    size = 0
    while len(reached) > size:
        size = len(reached)
        reached |= {Path(each.source.name).stem for each, modules in used.items() if modules & reached}
    return [each for each in others if Path(each.source.name).stem in reached]


def _named(name: str, texts: Iterable[Analysis]) -> Iterator[tuple[Span, set[_Place]]]:
    """What a name stands for at each of its places, and where that is declared."""
    word = re.compile(rf"\b{name}\b")
    for each in texts:
        for found in word.finditer(each.source.text):
            meant = find(each, found.start())
            if meant is not None and meant.span.start == found.start():
                yield Span(each.source, found.start(), found.end()), _places(each, meant)


def _bound(name: str, text: Analysis) -> Iterator[set[_Place]]:
    """For each role that states a name, where it does and where what plays or refines the role declares it, as far as a text knows."""
    symbols = [] if text.typed is None else [s for module in text.typed.modules.values() for s in module.own()]
    for role in (
        symbol for symbol in symbols if symbol.kind == "role" and any(name in names_of(s) for s in symbol.body)
    ):
        yield {
            (text.path_of(span.source), span.start)
            for symbol in symbols
            if role in lineage(symbol)
            for stmt in walk(symbol.decl)
            if isinstance(stmt, ast.Stmt) and stmt is not symbol.decl
            for span in name_spans_of(stmt)
            if span.text == name
        }


def _places(analysis: Analysis, found: Found) -> set[_Place]:
    """Where something is declared, in terms that hold for all texts."""
    return {(analysis.path_of(span.source), span.start) for span in found.declared}
