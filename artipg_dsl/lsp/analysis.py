"""One text as an editor has it: its findings, and its names and types as far as it can be read."""

from __future__ import annotations

from collections.abc import Mapping
from functools import cached_property
from pathlib import Path

from ..diagnostics import Diagnostic, Report
from ..garbage import uncollected
from ..resources import library_dir
from ..semantics.check import TypedProgram, check
from ..semantics.modules import Loader, Workspace
from ..semantics.scope import BodyScope
from ..semantics.symbols import ModuleScope, Symbol
from ..session import Session
from ..source import Source
from ..syntax import ast
from ..syntax.parse import parse_rest
from ..syntax.trees import KeptTree, tree_of
from ..syntax.walk import walk


class Analysis:
    """What there is to say of a text, computed when it is asked for. ``source`` is named by its path; ``texts`` are those of
    all files that the editor has, which count instead of what is saved; ``read`` is what was found when it was read."""

    def __init__(self, source: Source, texts: Mapping[Path, Source], read: Report | None = None):
        self.source, self._texts = source, texts
        self._session = Session(source, None, read, texts)
        self._workspace = self._session.workspace  # made here: two threads ask for it

    @cached_property
    def report(self) -> Report:
        """All findings, as of ``apgc check``."""
        return self._session.examine()

    @property
    def failed(self) -> bool:
        """Whether its names and types, or what they stand in, are wrong: then the rest is not looked at."""
        _ = self._session.typed
        return self._session.report.failed

    @property
    def errors(self) -> list[Diagnostic]:
        """What is wrong with its names and types."""
        return [found for found in self._session.report.diagnostics if found.severity == "error"] if self.failed else []

    def but(self, texts: Mapping[Path, Source]) -> Analysis:
        """The same with some texts in place of those that there are."""
        return Analysis(texts.get(Path(self.source.name), self.source), {**self._texts, **texts})

    @cached_property
    def typed(self) -> TypedProgram | None:
        """The names and types of the text, without the statements that cannot be read; None where nothing can be."""
        if self._session.typed is not None:
            return self._session.typed
        with uncollected():
            workspace = self.workspace(self._rest)
            module = workspace.load_source(self.source)
            return None if module is None else check(workspace, module, workspace.report)

    def workspace(self, loader: Loader | None = None) -> Workspace:
        """Modules as the editor has them, with nothing read yet."""
        return Workspace(Report(), [library_dir()], loader, self._session.read)

    def _rest(self, source: Source, report: Report) -> ast.Module | KeptTree | None:
        return parse_rest(source) if source is self.source else tree_of(source, report)

    def without_line(self, offset: int) -> Analysis:
        """The same but for the line around a place, which may be half a statement that takes the next line for its rest. A line that
        opens or closes a block stays."""
        text = self.source.text
        start, end = text.rfind("\n", 0, offset) + 1, text.find("\n", offset)
        end = len(text) if end < 0 else end
        line = text[start:end]
        if "{" in line or "}" in line:
            return self
        return Analysis(Source(self.source.name, text[:start] + " " * len(line) + text[end:]), self._texts)

    @property
    def module(self) -> ModuleScope | None:
        return None if self.typed is None else self.typed.main

    @property
    def reads(self) -> set[Path]:
        """The files that the findings follow from, and those that were looked for in vain."""
        return {*list(self._workspace.read), *list(self._workspace.absent)}  # as they are now: they may be growing

    def path_of(self, source: Source) -> Path | None:
        """The file of one of the texts that the program uses."""
        if source.name == self.source.name:
            return Path(self.source.name)
        read = self._workspace.read if self.typed is None else self.typed.checker.workspace.read
        return next((path for path, known in read.items() if known.name == source.name), None)

    def around(self, offset: int) -> Symbol | None:
        """The declaration of the file that is around a place."""
        for symbol in [] if self.module is None else self.module.own():
            if symbol.decl.span.holds(offset):
                return symbol
        return None

    def scope(self, offset: int) -> BodyScope | None:
        """The innermost body around a place."""
        symbol = self.around(offset)
        if symbol is None or self.typed is None or not hasattr(symbol.decl, "body"):
            return None
        found = self.typed.checker.scope_of(symbol)
        for stmt in walk(symbol.body):
            if isinstance(stmt, ast.RepeatStmt) and stmt.span.holds(offset) and id(stmt) in found.inner:
                found = found.inner[id(stmt)]
        return found
