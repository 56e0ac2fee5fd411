"""The Language Server Protocol, spoken over standard input and output (pygls): documents, threads and columns."""

from __future__ import annotations

import asyncio
import threading
from collections import defaultdict
from collections.abc import Callable, Sequence
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path
from typing import TypeVar

from lsprotocol import types as lsp
from pygls import uris
from pygls.exceptions import JsonRpcException
from pygls.lsp.server import LanguageServer

from ..diagnostics import Diagnostic, Report
from ..source import Source, Span
from ..syntax.format import format_source
from ..syntax.load import decode, load
from ..version import __version__
from .analysis import Analysis
from .colours import KINDS, colours
from .completion import Suggestion, complete
from .fixes import fixes
from .lookup import Found, find
from .outline import Item, outline
from .rename import Refused, rename, renamed
from .uses import uses

_PAUSE, _REST = (
    0.15,
    0.35,
)  # seconds without a change after which a text is looked at, and more until objects are made of it
_STACK = 16 << 20  # bytes: the passes go down a tree by a call for each node
_SEVERITIES = {"error": lsp.DiagnosticSeverity.Error, "warning": lsp.DiagnosticSeverity.Warning}
_SYMBOLS = defaultdict(
    lambda: lsp.SymbolKind.Field,
    {
        "category": lsp.SymbolKind.Module,
        "template": lsp.SymbolKind.Class,
        "role": lsp.SymbolKind.Interface,
        "primitive": lsp.SymbolKind.Struct,
        "material": lsp.SymbolKind.Constant,
        "vocabulary": lsp.SymbolKind.Enum,
        "function": lsp.SymbolKind.Function,
        "param": lsp.SymbolKind.Property,
        "count": lsp.SymbolKind.Number,
        "let": lsp.SymbolKind.Variable,
        "part": lsp.SymbolKind.Object,
        "style": lsp.SymbolKind.Enum,
        "joint": lsp.SymbolKind.Event,
        "repeat": lsp.SymbolKind.Array,
    },
)
_COMPLETIONS = defaultdict(
    lambda: lsp.CompletionItemKind.Field,
    {
        "keyword": lsp.CompletionItemKind.Keyword,
        "type": lsp.CompletionItemKind.TypeParameter,
        "constant": lsp.CompletionItemKind.Constant,
        "function": lsp.CompletionItemKind.Function,
        "module": lsp.CompletionItemKind.Module,
        "template": lsp.CompletionItemKind.Class,
        "primitive": lsp.CompletionItemKind.Struct,
        "role": lsp.CompletionItemKind.Interface,
        "material": lsp.CompletionItemKind.Constant,
        "word": lsp.CompletionItemKind.EnumMember,
        "param": lsp.CompletionItemKind.Property,
        "let": lsp.CompletionItemKind.Variable,
        "part": lsp.CompletionItemKind.Variable,
        "parameter": lsp.CompletionItemKind.Property,
    },
)
_Given = TypeVar("_Given")


class _Server(LanguageServer):
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


def make_server() -> LanguageServer:
    """The server with all that it answers; ``start_io`` runs it."""
    server = _Server()

    @server.feature(lsp.TEXT_DOCUMENT_DID_OPEN)
    @server.feature(lsp.TEXT_DOCUMENT_DID_CHANGE)
    async def changed(params: lsp.DidOpenTextDocumentParams | lsp.DidChangeTextDocumentParams) -> None:
        await asyncio.gather(*(server.look(uri) for uri in server.changed(params.text_document.uri)))

    @server.feature(lsp.TEXT_DOCUMENT_DID_CLOSE)
    async def closed(params: lsp.DidCloseTextDocumentParams) -> None:
        await asyncio.gather(*(server.look(uri) for uri in server.closed(params.text_document.uri)))

    async def found_at(params: lsp.HoverParams | lsp.DefinitionParams) -> tuple[Analysis, Found | None]:
        analysis = server.analyses[params.text_document.uri]
        offset = server.offset(analysis.source, params.position)
        return analysis, await server.do(lambda: find(analysis, offset))

    @server.feature(lsp.TEXT_DOCUMENT_HOVER)
    async def hover(params: lsp.HoverParams) -> lsp.Hover | None:
        _, found = await found_at(params)
        if found is None:
            return None
        text = f"```apg\n{found.code}\n```" + (f"\n\n{found.about}" if found.about else "")
        return lsp.Hover(lsp.MarkupContent(lsp.MarkupKind.Markdown, text), server.range(found.span))

    @server.feature(lsp.TEXT_DOCUMENT_DEFINITION)
    async def definition(params: lsp.DefinitionParams) -> list[lsp.Location]:
        analysis, found = await found_at(params)
        return [] if found is None else [server.location(analysis, span) for span in found.declared]

    @server.feature(lsp.TEXT_DOCUMENT_REFERENCES)
    async def references(params: lsp.ReferenceParams) -> list[lsp.Location]:
        uri = params.text_document.uri
        offset = server.offset(server.analyses[uri].source, params.position)
        return await server.do(lambda: server.uses(uri, offset))

    async def willing(work: Callable[[], _Given]) -> _Given:
        """What is computed; what is refused is an error that the editor shows."""
        try:
            return await server.do(work)
        except Refused as refused:
            raise JsonRpcException(str(refused), lsp.LSPErrorCodes.RequestFailed) from None

    @server.feature(lsp.TEXT_DOCUMENT_PREPARE_RENAME)
    async def prepare(params: lsp.PrepareRenameParams) -> lsp.PrepareRenamePlaceholder:
        analysis = server.analyses[params.text_document.uri]
        offset = server.offset(analysis.source, params.position)
        found = await willing(lambda: renamed(analysis, offset))
        return lsp.PrepareRenamePlaceholder(server.range(found.span), found.span.text)

    @server.feature(lsp.TEXT_DOCUMENT_RENAME, lsp.RenameOptions(prepare_provider=True))
    async def change_name(params: lsp.RenameParams) -> lsp.WorkspaceEdit:
        uri = params.text_document.uri
        offset = server.offset(server.analyses[uri].source, params.position)
        return await willing(lambda: server.rename(uri, offset, params.new_name))

    @server.feature(lsp.TEXT_DOCUMENT_DOCUMENT_HIGHLIGHT)
    async def highlight(params: lsp.DocumentHighlightParams) -> list[lsp.DocumentHighlight]:
        analysis = server.analyses[params.text_document.uri]
        offset = server.offset(analysis.source, params.position)
        found = await server.do(lambda: uses(analysis, offset))
        return [lsp.DocumentHighlight(server.range(span)) for span in found]

    @server.feature(lsp.TEXT_DOCUMENT_COMPLETION, lsp.CompletionOptions(trigger_characters=["."]))
    async def completion(params: lsp.CompletionParams) -> list[lsp.CompletionItem]:
        analysis = server.analyses[params.text_document.uri]
        offset = server.offset(analysis.source, params.position)
        found = await server.do(lambda: complete(analysis, offset))
        return [_item(suggestion, rank) for rank, suggestion in enumerate(found)]

    @server.feature(lsp.TEXT_DOCUMENT_DOCUMENT_SYMBOL)
    async def symbols(params: lsp.DocumentSymbolParams) -> list[lsp.DocumentSymbol]:
        analysis = server.analyses[params.text_document.uri]
        return _symbols(server, await server.do(lambda: outline(analysis)))

    @server.feature(
        lsp.TEXT_DOCUMENT_SEMANTIC_TOKENS_FULL, lsp.SemanticTokensLegend(token_types=list(KINDS), token_modifiers=[])
    )
    async def tokens(params: lsp.SemanticTokensParams) -> lsp.SemanticTokens:
        source = server.analyses[params.text_document.uri].source
        data, line, column = list[int](), 0, 0
        for span, kind in await server.do(lambda: list(colours(source))):
            start, end = server.position(source, span.start), server.position(source, span.end)
            column = column if start.line == line else 0
            size = end.character - start.character
            data += [start.line - line, start.character - column, size, KINDS.index(kind), 0]
            line, column = start.line, start.character
        return lsp.SemanticTokens(data)

    @server.feature(lsp.TEXT_DOCUMENT_FORMATTING)
    async def formatting(params: lsp.DocumentFormattingParams) -> list[lsp.TextEdit]:
        source = server.analyses[params.text_document.uri].source
        text = await server.do(lambda: format_source(source, Report()))
        every = Span(source, 0, len(source.text))
        return [] if text is None or text == source.text else [lsp.TextEdit(server.range(every), text)]

    @server.feature(
        lsp.TEXT_DOCUMENT_CODE_ACTION, lsp.CodeActionOptions(code_action_kinds=[lsp.CodeActionKind.QuickFix])
    )
    async def actions(params: lsp.CodeActionParams) -> list[lsp.CodeAction]:
        uri = params.text_document.uri
        analysis = server.analyses[uri]
        report = await server.do(lambda: analysis.report)
        start, end = (server.offset(analysis.source, place) for place in (params.range.start, params.range.end))
        made = []
        for diagnostic in report.diagnostics:
            for fix in fixes(diagnostic):
                if fix.span.source.name == analysis.source.name and fix.span.start <= end and start <= fix.span.end:
                    edit = lsp.WorkspaceEdit({uri: [lsp.TextEdit(server.range(fix.span), fix.text)]})
                    mended = [server.diagnostic(analysis, diagnostic, fix.span)]
                    kind = lsp.CodeActionKind.QuickFix
                    made.append(lsp.CodeAction(fix.title, kind=kind, diagnostics=mended, edit=edit))
        return made

    return server


def _item(suggestion: Suggestion, rank: int) -> lsp.CompletionItem:
    return lsp.CompletionItem(
        suggestion.name,
        kind=_COMPLETIONS[suggestion.kind],
        detail=suggestion.kind,
        documentation=suggestion.about or None,
        sort_text=f"{rank:04d}",
    )


def _symbols(server: _Server, items: Sequence[Item]) -> list[lsp.DocumentSymbol]:
    return [
        lsp.DocumentSymbol(
            item.name,
            _SYMBOLS[item.kind],
            server.range(item.span),
            server.range(item.name_span),
            detail=item.kind,
            children=_symbols(server, item.inner),
        )
        for item in items
    ]
