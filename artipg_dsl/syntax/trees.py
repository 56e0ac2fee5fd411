"""The trees of texts, each parsed once: by a process, and by all that share a cache (see ``cache``).

Of a tree that was kept, a declaration is made when it is asked for: a program uses a quarter to a half of what the modules that it names
declare. So it is for a file of the shipped library of which nothing was kept: its declarations begin at the beginning of a line, as the
formatter writes them, and each is parsed when it is asked for.
"""

from __future__ import annotations

import json
import re
from collections.abc import Iterator
from dataclasses import replace
from functools import cached_property
from typing import Any

from .. import cache
from ..diagnostics import CompileError, Report
from ..garbage import uncollected
from ..source import Source, Span
from . import ast
from .data import KINDS, from_data, to_data

_MOST_TREES = 64
"""So many trees are held: a library is read once by a process, whatever programs use it."""

_WRONG = ValueError, TypeError, IndexError, RecursionError  # what data is that is no tree of the text

_DECLARES: dict[str, type[ast.Decl]] = {
    "role": ast.RoleDecl,
    "template": ast.TemplateDecl,
    "primitive": ast.PrimitiveDecl,
    "material": ast.MaterialDecl,
    "vocabulary": ast.VocabularyDecl,
    "let": ast.FunctionDecl,
}
_HEAD = re.compile(rf"^(?:(?:#[^\n]*)?\n)*({'|'.join(_DECLARES)})[ ]+(\w+)", re.MULTILINE)
"""The first line of a declaration, with the comments before it."""
_UNUSUAL = re.compile(r"^[ \t]+(?:role|template|primitive|vocabulary|material[ ]+\w+[ ]*\{)|^category", re.MULTILINE)
"""What begins elsewhere, or stands in no library."""


class KeptTree:
    """A tree whose declarations are made when they are asked for: of ``rows`` as they were kept, or else of their text. At once there
    are what the file uses and what its declarations are called."""

    def __init__(self, module: ast.Module, heads: tuple[ast.Head, ...], rows: list[bytes]):
        self._module, self._source, self._rows = module, module.span.source, rows
        self.span, self.uses, self.heads = module.span, module.uses, heads
        self.parsed = False  # whether a declaration was parsed that is not kept yet
        self._made: list[ast.Decl | None] = [None] * len(heads)

    @property
    def complete(self) -> bool:
        """Whether no declaration has to be parsed any more."""
        return all(self._rows)

    def declaration(self, number: int) -> ast.Decl:
        """A declaration, by its place among those of the file. Raises CompileError where its text has a mistake."""
        found = self._made[number]
        if found is None:
            head, row = self.heads[number], self._rows[number]
            try:
                with uncollected():
                    found = from_data(json.loads(row), self._source, head.kind) if row else self._parse(number)
                if (type(found), found.name, found.name_span) != (head.kind, head.name, head.name_span):
                    raise ValueError(head.name)
            except _WRONG:
                cache.drop(_entry(self._source))
                found = self._anew[head.name]
            self._made[number] = found
        return found

    def _parse(self, number: int) -> ast.Decl:
        """A declaration of its text. Raises ValueError where that is not one."""
        from .parse import parse_piece  # start-up: as below

        begin, *rest = self._begins[number:]
        tree = parse_piece(self._source, begin, rest[0] if rest else len(self._source.text))
        if tree is None or len(tree.declarations) != 1 or tree.uses:
            raise ValueError(number)
        if cache.folder() is not None:
            self._rows[number], self.parsed = _row(tree.declarations[0]), True
        return tree.declarations[0]

    @cached_property
    def _begins(self) -> list[int]:
        return [found.start() for found in _HEAD.finditer(self._source.text)]

    @cached_property
    def whole(self) -> ast.Module:
        """The tree with all declarations."""
        return replace(self._module, declarations=tuple(map(self.declaration, range(len(self.heads)))))

    @cached_property
    def _anew(self) -> dict[str, ast.Decl]:
        """The declarations of the text by their names."""
        report = Report()
        tree = _parsed(self._source, report)
        if tree is None:
            raise CompileError(report)
        return {decl.name: decl for decl in tree.declarations}

    def keep(self) -> None:
        """Keep what was parsed since it was read."""
        if self.parsed:
            self.parsed = False
            cache.write(_entry(self._source), b"\n".join([_first(self._module, self.heads), *self._rows]))


_trees: dict[tuple[str, str], ast.Module | KeptTree] = {}


def tree_of(source: Source, report: Report) -> ast.Module | KeptTree | None:
    """The tree of a source, or None after reporting why there is none. Equal sources share one tree, with the places in the
    source that was read first: a tree is never changed."""
    held = _held(source)
    if isinstance(held, KeptTree) and not held.complete:
        held = None  # it may have mistakes that are yet to be found
    return _hold(source, held or _parsed(source, report))


def shipped_tree(source: Source, report: Report) -> ast.Module | KeptTree | None:
    """The same of a file of the shipped library. It had no mistakes when it was made; one that it has now is told when its declaration
    is asked for."""
    return _hold(source, _held(source) or _scanned(source) or _parsed(source, report))


def _held(source: Source) -> ast.Module | KeptTree | None:
    return _trees.pop((source.name, source.text), None) or _recalled(source)


def _hold(source: Source, tree: ast.Module | KeptTree | None) -> ast.Module | KeptTree | None:
    if tree is not None:
        while len(_trees) >= _MOST_TREES:
            _trees.pop(next(iter(_trees)), None)
        _trees[source.name, source.text] = tree  # the last to go
    return tree


def keep_parsed() -> None:
    """Keep the declarations that were parsed one by one."""
    for tree in tuple(_trees.values()):
        if isinstance(tree, KeptTree):
            tree.keep()


def _scanned(source: Source) -> KeptTree | None:
    """The tree of a file whose declarations are yet to be parsed; None where they do not stand as the formatter writes them."""
    from .parse import parse_piece  # start-up: as below

    found = list(_HEAD.finditer(source.text))
    if not found or _UNUSUAL.search(source.text) or "\nuse " in source.text[found[0].start() :]:
        return None
    module = parse_piece(source, 0, found[0].start())
    if module is None:
        return None
    heads = tuple(ast.Head(_DECLARES[one[1]], one[2], Span(source, one.start(2), one.end(2))) for one in found)
    return KeptTree(module, heads, [b""] * len(heads))


def _parsed(source: Source, report: Report) -> ast.Module | None:
    from .parse import parse  # start-up: where all trees are kept, no parser is needed

    tree = parse(source, report)
    if tree is not None and cache.folder() is not None:
        cache.write(_entry(source), b"\n".join(_lines(tree)))
    return tree


def _lines(tree: ast.Module) -> Iterator[bytes]:
    """What a KeptTree is made of: the module without its declarations, and their heads; then the rows of each."""
    yield _first(replace(tree, declarations=()), tree.heads)
    yield from map(_row, tree.declarations)


def _first(module: ast.Module, heads: tuple[ast.Head, ...]) -> bytes:
    told = [[KINDS.index(h.kind), h.name, h.name_span.start, h.name_span.end] for h in heads]
    return json.dumps([to_data(module), told], separators=(",", ":")).encode()


def _row(tree: ast.Decl) -> bytes:
    return json.dumps(to_data(tree), separators=(",", ":")).encode()


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
        head, *rows = body.split(b"\n")
        module, told = json.loads(head)
        heads = tuple(_head(source, *one) for one in told)
        if len(rows) != len(heads):
            raise ValueError("each declaration has a line")
        return KeptTree(from_data(module, source, ast.Module), heads, rows)
    except _WRONG:
        cache.drop(_entry(source))
        return None


def _entry(source: Source) -> str:
    return cache.key("tree", source.text)
