"""The documents that an editor has open, as the Language Server Protocol speaks of them (pygls): texts, threads and columns."""

from __future__ import annotations

import asyncio
import threading
from collections.abc import Callable
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path
from typing import Protocol, TypeVar

from lsprotocol import types as lsp
from pygls import uris
from pygls.lsp.server import LanguageServer

from ..diagnostics import Diagnostic, Report
from ..source import Source, Span
from ..syntax.load import decode, load
from ..version import __version__
from .analysis import Analysis
from .rename import rename
from .uses import uses

_PAUSE = 0.15  # seconds without a change after which a text is looked at
_REST = 0.35  # and more until objects are made of it
_STACK = 16 << 20  # bytes: the passes go down a tree by a call for each node
_SEVERITIES = {"error": lsp.DiagnosticSeverity.Error, "warning": lsp.DiagnosticSeverity.Warning}
_Given = TypeVar("_Given")


class _Question(Protocol):
    """What an editor asks about a place in a document."""

    text_document: lsp.TextDocumentIdentifier
    position: lsp.Position


class Documents(LanguageServer):
    """The documents that an editor has open, and what is known of each. All that is computed is computed by one thread, in turn:
    a process has one parser."""

    def __init__(self) -> None:
        super().__init__("apgc", __version__)
        threading.stack_size(_STACK)
        self.worker = ThreadPoolExecutor(1)
        self.texts: dict[Path, Source] = {}
        self.analyses: dict[str, Analysis] = {}
        self.told: dict[str, dict[str, list[lsp.Diagnostic]]] = {}  # by document: its findings by file

    async def do(self, work: Callable[[], _Given]) -> _Given:
        return await asyncio.get_running_loop().run_in_executor(self.worker, work)

    # places

    def position(self, source: Source, offset: int) -> lsp.Position:
        """A place as the editor counts: columns in its own units."""
        line = source.position(offset)[0]
        return lsp.Position(
            line - 1, self.workspace.position_codec.client_num_units(source.text[source.start(line) : offset])
        )

    def range(self, span: Span) -> lsp.Range:
        return lsp.Range(self.position(span.source, span.start), self.position(span.source, span.end))

    def offset(self, source: Source, place: lsp.Position) -> int:
        line = min(place.line + 1, source.text.count("\n") + 1)
        text = source.line(line)
        column = self.workspace.position_codec.position_from_client_units([text], lsp.Position(0, place.character))
        return source.start(line) + min(column.character, len(text))

    def at(self, asked: _Question) -> tuple[Analysis, int]:
        """The document that a question is about, and the place in it."""
        analysis = self.analyses[asked.text_document.uri]
        return analysis, self.offset(analysis.source, asked.position)

    # documents

    def path(self, uri: str) -> Path:
        """Where a document lies; one that was never saved is taken to lie where the server runs."""
        known = uris.to_fs_path(uri) if uri.startswith("file:") else None
        return Path(known).resolve() if known else Path.cwd() / f"{uri.rpartition(':')[2]}.apg"

    def changed(self, uri: str) -> list[str]:
        """Take a document as it is now; which documents are to be looked at again."""
        self.texts[self.path(uri)] = self.source(uri, Report())
        return self._anew(uri, [uri])

    def closed(self, uri: str) -> list[str]:
        """Forget a document, as what is saved counts again; which others are to be looked at again."""
        self.texts.pop(self.path(uri), None)
        self.analyses.pop(uri, None)
        self.tell(uri, {})
        return self._anew(uri, [])

    def _anew(self, uri: str, again: list[str]) -> list[str]:
        """Forget what is known of some documents, and of those that follow from the text of another."""
        path = self.path(uri)
        again = [*again, *(other for other, known in self.analyses.items() if other != uri and path in known.reads)]
        for each in again:
            report = Report()
            self.analyses[each] = Analysis(self.source(each, report), dict(self.texts), report)
        return again

    def source(self, uri: str, report: Report) -> Source:
        """The text of a document, read as that of a file is."""
        text = self.workspace.get_text_document(uri).source
        found = decode(text.encode("utf-8", "replace"), str(self.path(uri)), report)
        assert found is not None  # UTF-8 it is
        return found

    async def look(self, uri: str) -> None:
        """Tell the findings in a document once it rests: soon if its names and types are wrong, a little later if objects
        are to be made of it, since questions wait for that."""
        analysis = self.analyses[uri]
        await asyncio.sleep(_PAUSE)
        try:
            if self.analyses.get(uri) is analysis and not await self.do(lambda: analysis.failed):
                await asyncio.sleep(_REST)
            found = await self.do(lambda: self.findings(analysis)) if self.analyses.get(uri) is analysis else None
        except Exception as error:  # whatever is wrong with us, the editor goes on
            shown = f"apgc cannot check this file: {error!r}"
            self.window_show_message(lsp.ShowMessageParams(lsp.MessageType.Error, shown))
            return
        if found is not None and self.analyses.get(uri) is analysis:
            self.tell(uri, found)

    # findings

    def findings(self, analysis: Analysis) -> dict[str, list[lsp.Diagnostic]]:
        """The findings that follow from a document, by file."""
        found: dict[str, list[lsp.Diagnostic]] = {self.uri(analysis, analysis.source): []}
        for diagnostic in analysis.report.diagnostics:
            span = diagnostic.span or Span(analysis.source, 0, 0)
            found.setdefault(self.uri(analysis, span.source), []).append(self.diagnostic(analysis, diagnostic, span))
        return found

    def diagnostic(self, analysis: Analysis, found: Diagnostic, span: Span) -> lsp.Diagnostic:
        places = [*found.notes, *reversed(found.trace)]
        return lsp.Diagnostic(
            range=self.range(span),
            message=found.message + (f"\nhelp: {found.hint}" if found.hint else ""),
            severity=_SEVERITIES[found.severity],
            code=found.code,
            source="apgc",
            related_information=[
                lsp.DiagnosticRelatedInformation(self.location(analysis, place), text) for place, text in places
            ],
        )

    def tell(self, uri: str, found: dict[str, list[lsp.Diagnostic]]) -> None:
        """Send the findings that follow from a document, beside those of the same files that follow from others."""
        files = {*self.told.get(uri, ()), *found}
        self.told[uri] = found
        for file in sorted(files):
            every: list[lsp.Diagnostic] = []
            for each in self.told.values():
                every += [one for one in each.get(file, ()) if one not in every]
            self.text_document_publish_diagnostics(lsp.PublishDiagnosticsParams(file, every))

    def uri(self, analysis: Analysis, source: Source) -> str:
        """The document that a text is of."""
        path = analysis.path_of(source) or Path(analysis.source.name)
        known = (uri for uri in list(self.analyses) if self.path(uri) == path)  # as they are now: another thread asks
        return next(known, None) or uris.from_fs_path(str(path)) or ""

    def others(self, uri: str) -> list[Analysis]:
        """The other documents, and the files beside one."""
        analysis, texts = self.analyses[uri], dict(self.texts)
        others = [known for other, known in list(self.analyses.items()) if other != uri]
        for path in sorted(Path(analysis.source.name).parent.glob("*.apg")):
            source = None if path.resolve() in texts else load(path.resolve(), Report())
            if source is not None:
                others.append(Analysis(source, texts))
        return others

    def uses(self, uri: str, offset: int) -> list[lsp.Location]:
        """Where what stands at a place of a document is used: in it, and in the others."""
        analysis = self.analyses[uri]
        return [self.location(analysis, span) for span in uses(analysis, offset, self.others(uri))]

    def rename(self, uri: str, offset: int, name: str) -> lsp.WorkspaceEdit:
        """What is to be written in which documents for another name. Raises Refused."""
        analysis = self.analyses[uri]
        changes: dict[str, list[lsp.TextEdit]] = {}
        for edit in rename(analysis, offset, name, self.others(uri)):
            here = self.location(analysis, edit.span)
            changes.setdefault(here.uri, []).append(lsp.TextEdit(here.range, edit.text))
        return lsp.WorkspaceEdit(changes)

    def location(self, analysis: Analysis, span: Span) -> lsp.Location:
        return lsp.Location(self.uri(analysis, span.source), self.range(span))
