"""What an editor asks, by the Language Server Protocol: an answer each, of the rules in the other files of this folder."""

from __future__ import annotations

import asyncio
from collections import defaultdict
from collections.abc import Callable, Coroutine, Sequence
from typing import Any, TypeVar

from lsprotocol import types as lsp
from pygls.exceptions import JsonRpcException
from pygls.lsp.server import LanguageServer

from ..diagnostics import Report
from ..source import Span
from ..syntax.format import format_source
from .colours import KINDS, colours
from .completion import Suggestion, complete
from .documents import Documents
from .fixes import fixes
from .lookup import find
from .outline import Item, outline
from .rename import Refused, renamed
from .uses import uses

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
_Answer = Callable[..., Coroutine[Any, Any, Any]]
_ANSWERS: list[tuple[str, Any, _Answer]] = []


def make_server() -> LanguageServer:
    """The server with all that it answers; ``start_io`` runs it."""
    server = Documents()
    for method, options, answer in _ANSWERS:
        server.feature(method, options)(answer)  # pygls hands the server in as ``ls``
    return server


def _answers(method: str, options: Any = None) -> Callable[[_Answer], _Answer]:
    """What is asked by this method is answered by the function below."""

    def note(answer: _Answer) -> _Answer:
        _ANSWERS.append((method, options, answer))
        return answer

    return note


@_answers(lsp.TEXT_DOCUMENT_DID_OPEN)
@_answers(lsp.TEXT_DOCUMENT_DID_CHANGE)
async def _changed(ls: Documents, params: lsp.DidOpenTextDocumentParams | lsp.DidChangeTextDocumentParams) -> None:
    await asyncio.gather(*(ls.look(uri) for uri in ls.changed(params.text_document.uri)))


@_answers(lsp.TEXT_DOCUMENT_DID_CLOSE)
async def _closed(ls: Documents, params: lsp.DidCloseTextDocumentParams) -> None:
    await asyncio.gather(*(ls.look(uri) for uri in ls.closed(params.text_document.uri)))


@_answers(lsp.TEXT_DOCUMENT_HOVER)
async def _hover(ls: Documents, params: lsp.HoverParams) -> lsp.Hover | None:
    analysis, offset = ls.at(params)
    found = await ls.do(lambda: find(analysis, offset))
    if found is None:
        return None
    text = f"```apg\n{found.code}\n```" + (f"\n\n{found.about}" if found.about else "")
    return lsp.Hover(lsp.MarkupContent(lsp.MarkupKind.Markdown, text), ls.range(found.span))


@_answers(lsp.TEXT_DOCUMENT_DEFINITION)
async def _definition(ls: Documents, params: lsp.DefinitionParams) -> list[lsp.Location]:
    analysis, offset = ls.at(params)
    found = await ls.do(lambda: find(analysis, offset))
    return [] if found is None else [ls.location(analysis, span) for span in found.declared]


@_answers(lsp.TEXT_DOCUMENT_REFERENCES)
async def _references(ls: Documents, params: lsp.ReferenceParams) -> list[lsp.Location]:
    _, offset = ls.at(params)
    return await ls.do(lambda: ls.uses(params.text_document.uri, offset))


async def _willing(ls: Documents, work: Callable[[], _Given]) -> _Given:
    """What is computed; what is refused is an error that the editor shows."""
    try:
        return await ls.do(work)
    except Refused as refused:
        raise JsonRpcException(str(refused), lsp.LSPErrorCodes.RequestFailed) from None


@_answers(lsp.TEXT_DOCUMENT_PREPARE_RENAME)
async def _prepare(ls: Documents, params: lsp.PrepareRenameParams) -> lsp.PrepareRenamePlaceholder:
    analysis, offset = ls.at(params)
    found = await _willing(ls, lambda: renamed(analysis, offset))
    return lsp.PrepareRenamePlaceholder(ls.range(found.span), found.span.text)


@_answers(lsp.TEXT_DOCUMENT_RENAME, lsp.RenameOptions(prepare_provider=True))
async def _change_name(ls: Documents, params: lsp.RenameParams) -> lsp.WorkspaceEdit:
    _, offset = ls.at(params)
    return await _willing(ls, lambda: ls.rename(params.text_document.uri, offset, params.new_name))


@_answers(lsp.TEXT_DOCUMENT_DOCUMENT_HIGHLIGHT)
async def _highlight(ls: Documents, params: lsp.DocumentHighlightParams) -> list[lsp.DocumentHighlight]:
    analysis, offset = ls.at(params)
    found = await ls.do(lambda: uses(analysis, offset))
    return [lsp.DocumentHighlight(ls.range(span)) for span in found]


@_answers(lsp.TEXT_DOCUMENT_COMPLETION, lsp.CompletionOptions(trigger_characters=["."]))
async def _completion(ls: Documents, params: lsp.CompletionParams) -> list[lsp.CompletionItem]:
    analysis, offset = ls.at(params)
    found = await ls.do(lambda: complete(analysis, offset))
    return [_item(suggestion, rank) for rank, suggestion in enumerate(found)]


@_answers(lsp.TEXT_DOCUMENT_DOCUMENT_SYMBOL)
async def _symbols(ls: Documents, params: lsp.DocumentSymbolParams) -> list[lsp.DocumentSymbol]:
    analysis = ls.analyses[params.text_document.uri]
    return _outlined(ls, await ls.do(lambda: outline(analysis)))


@_answers(lsp.TEXT_DOCUMENT_SEMANTIC_TOKENS_FULL, lsp.SemanticTokensLegend(token_types=list(KINDS), token_modifiers=[]))
async def _tokens(ls: Documents, params: lsp.SemanticTokensParams) -> lsp.SemanticTokens:
    source = ls.analyses[params.text_document.uri].source
    data, line, column = list[int](), 0, 0
    for span, kind in await ls.do(lambda: list(colours(source))):
        start, end = ls.position(source, span.start), ls.position(source, span.end)
        column = column if start.line == line else 0
        size = end.character - start.character
        data += [start.line - line, start.character - column, size, KINDS.index(kind), 0]
        line, column = start.line, start.character
    return lsp.SemanticTokens(data)


@_answers(lsp.TEXT_DOCUMENT_FORMATTING)
async def _formatting(ls: Documents, params: lsp.DocumentFormattingParams) -> list[lsp.TextEdit]:
    source = ls.analyses[params.text_document.uri].source
    text = await ls.do(lambda: format_source(source, Report()))
    every = Span(source, 0, len(source.text))
    return [] if text is None or text == source.text else [lsp.TextEdit(ls.range(every), text)]


@_answers(lsp.TEXT_DOCUMENT_CODE_ACTION, lsp.CodeActionOptions(code_action_kinds=[lsp.CodeActionKind.QuickFix]))
async def _actions(ls: Documents, params: lsp.CodeActionParams) -> list[lsp.CodeAction]:
    uri = params.text_document.uri
    analysis = ls.analyses[uri]
    report = await ls.do(lambda: analysis.report)
    start, end = (ls.offset(analysis.source, place) for place in (params.range.start, params.range.end))
    made = []
    for diagnostic in report.diagnostics:
        for fix in fixes(diagnostic):
            if fix.span.source.name == analysis.source.name and fix.span.start <= end and start <= fix.span.end:
                edit = lsp.WorkspaceEdit({uri: [lsp.TextEdit(ls.range(fix.span), fix.text)]})
                mended = [ls.diagnostic(analysis, diagnostic, fix.span)]
                kind = lsp.CodeActionKind.QuickFix
                made.append(lsp.CodeAction(fix.title, kind=kind, diagnostics=mended, edit=edit))
    return made


def _item(suggestion: Suggestion, rank: int) -> lsp.CompletionItem:
    return lsp.CompletionItem(
        suggestion.name,
        kind=_COMPLETIONS[suggestion.kind],
        detail=suggestion.kind,
        documentation=suggestion.about or None,
        sort_text=f"{rank:04d}",
    )


def _outlined(ls: Documents, items: Sequence[Item]) -> list[lsp.DocumentSymbol]:
    return [
        lsp.DocumentSymbol(
            item.name,
            _SYMBOLS[item.kind],
            ls.range(item.span),
            ls.range(item.name_span),
            detail=item.kind,
            children=_outlined(ls, item.inner),
        )
        for item in items
    ]
