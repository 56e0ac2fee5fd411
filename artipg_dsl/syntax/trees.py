"""The trees of texts, each parsed once: by a process, and by all that share a cache (see ``cache``)."""

from __future__ import annotations

import json

from .. import cache
from ..diagnostics import Report
from ..garbage import uncollected
from ..source import Source
from . import ast
from .data import from_data, to_data

_MOST_TREES = 64
"""So many trees are held: a library is read once by a process, whatever programs use it."""

_trees: dict[tuple[str, str], ast.Module] = {}


def tree_of(source: Source, report: Report) -> ast.Module | None:
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
        cache.write(_entry(source), json.dumps(to_data(tree), separators=(",", ":")).encode())
    return tree


def _recalled(source: Source) -> ast.Module | None:
    body = cache.read(_entry(source)) if cache.folder() is not None else None
    if body is None:
        return None
    try:
        with uncollected():
            return from_data(json.loads(body), source)
    except (ValueError, TypeError, IndexError, RecursionError):
        cache.drop(_entry(source))
        return None


def _entry(source: Source) -> str:
    return cache.key("tree", source.text)
