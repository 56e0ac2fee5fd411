"""The trees of texts, each parsed once: by a process, and by all that share a cache (see ``cache``).

Of a tree that was kept, a declaration is made when it is asked for: a program uses a quarter to a half of what the modules that it names
declare.
"""

from __future__ import annotations

import json
from collections.abc import Iterator
from dataclasses import replace
from functools import cached_property
from typing import Any

from .. import cache
from ..diagnostics import Report
from ..garbage import uncollected
from ..source import Source, Span
from . import ast
from .data import KINDS, from_data, to_data

_MOST_TREES = 64
"""So many trees are held: a library is read once by a process, whatever programs use it."""

_WRONG = ValueError, TypeError, IndexError, RecursionError  # what data is that is no tree of the text


class KeptTree:
    """A tree as it was kept: at once what the file uses and what its declarations are called. Raises ``_WRONG``."""

    def __init__(self, body: bytes, source: Source):
        head, *self._rows = body.split(b"\n")
        module, heads = json.loads(head)
        self._module, self._source = from_data(module, source, ast.Module), source
        self.span, self.uses = self._module.span, self._module.uses
        self.heads = tuple(_head(source, *told) for told in heads)
        self._made: list[ast.Decl | None] = [None] * len(self.heads)
        if len(self._rows) != len(self.heads):
            raise ValueError("each declaration has a line")

    def declaration(self, number: int) -> ast.Decl:
        """A declaration, by its place among those of the file."""
        found = self._made[number]
        if found is None:
            head = self.heads[number]
            try:
                with uncollected():
                    found = from_data(json.loads(self._rows[number]), self._source, head.kind)
                if (type(found), found.name, found.name_span) != (head.kind, head.name, head.name_span):
                    raise ValueError(head.name)
            except _WRONG:
                cache.drop(_entry(self._source))
                found = self._anew[number]
            self._made[number] = found
        return found

    @cached_property
    def whole(self) -> ast.Module:
        """The tree with all declarations."""
        return replace(self._module, declarations=tuple(map(self.declaration, range(len(self.heads)))))

    @cached_property
    def _anew(self) -> tuple[ast.Decl, ...]:
        """The declarations of the text, which was parsed before without a mistake."""
        tree = _parsed(self._source, Report())
        assert tree is not None
        return tree.declarations


_trees: dict[tuple[str, str], ast.Module | KeptTree] = {}


def tree_of(source: Source, report: Report) -> ast.Module | KeptTree | None:
    """The tree of a source, or None after reporting why there is none. Equal sources share one tree, with the places in the
    source that was read first: a tree is never changed."""
    key = source.name, source.text
    tree = _trees.pop(key, None) or _recalled(source) or _parsed(source, report)
    if tree is not None:
        while len(_trees) >= _MOST_TREES:
            _trees.pop(next(iter(_trees)), None)
        _trees[key] = tree  # the last to go
    return tree


def _parsed(source: Source, report: Report) -> ast.Module | None:
    from .parse import parse  # start-up: where all trees are kept, no parser is needed

    tree = parse(source, report)
    if tree is not None and cache.folder() is not None:
        cache.write(_entry(source), b"\n".join(_lines(tree)))
    return tree


def _lines(tree: ast.Module) -> Iterator[bytes]:
    """What a KeptTree is made of: the module without its declarations, and their heads; then the rows of each."""
    heads = [[KINDS.index(h.kind), h.name, h.name_span.start, h.name_span.end] for h in tree.heads]
    for data in ([to_data(replace(tree, declarations=())), heads], *map(to_data, tree.declarations)):
        yield json.dumps(data, separators=(",", ":")).encode()


def _head(source: Source, number: Any, name: Any, start: Any, end: Any) -> ast.Head:
    kind = KINDS[number]
    if not issubclass(kind, ast.Decl) or not 0 <= start <= end or source.text[start:end] != name:
        raise ValueError(name)
    return ast.Head(kind, name, Span(source, start, end))


def _recalled(source: Source) -> KeptTree | None:
    body = cache.read(_entry(source)) if cache.folder() is not None else None
    if body is None:
        return None
    try:
        return KeptTree(body, source)
    except _WRONG:
        cache.drop(_entry(source))
        return None


def _entry(source: Source) -> str:
    return cache.key("tree", source.text)
