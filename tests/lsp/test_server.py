"""The server as an editor sees it: a process of its own, spoken to over its standard input and output."""

import asyncio
import sys

import pytest

from artipg_dsl.cli.main import main

from .texts import SHELVES, STAND

pytest.importorskip("pygls", reason="the language server needs pygls, of the extra `editor`")
from lsprotocol import types as lsp  # noqa: E402
from pygls import uris  # noqa: E402
from pygls.exceptions import JsonRpcException  # noqa: E402
from pygls.lsp.client import LanguageClient  # noqa: E402

SOON = 120  # seconds


class Editor(LanguageClient):
    """An editor that notes the findings it is told."""

    def __init__(self):
        super().__init__("test", "1")
        self.told = asyncio.Queue()
        self.feature(lsp.TEXT_DOCUMENT_PUBLISH_DIAGNOSTICS)(lambda given: self.told.put_nowait(given))

    async def begin(self):
        await self.start_io(sys.executable, "-m", "artipg_dsl", "lsp", "--stdio")
        offered = await self.initialize_async(lsp.InitializeParams(capabilities=lsp.ClientCapabilities()))
        self.initialized(lsp.InitializedParams())
        return offered.capabilities

    async def end(self):
        await self.shutdown_async(None)
        self.exit(None)
        assert await self._server.wait() == 0
        await self.stop()

    def open(self, path, text):
        uri = uris.from_fs_path(str(path))
        self.text_document_did_open(lsp.DidOpenTextDocumentParams(lsp.TextDocumentItem(uri, "apg", 1, text)))
        return lsp.TextDocumentIdentifier(uri)

    def replace(self, document, version, text):
        changed = lsp.VersionedTextDocumentIdentifier(version, document.uri)
        whole = [lsp.TextDocumentContentChangeWholeDocument(text)]
        self.text_document_did_change(lsp.DidChangeTextDocumentParams(changed, whole))

    async def findings(self, document):
        """The next findings that are told of a document."""
        while True:
            given = await self.told.get()
            if given.uri == document.uri:
                return given.diagnostics


def session(steps):
    async def run():
        editor = Editor()
        offered = await editor.begin()
        await steps(editor, offered)
        await editor.end()

    asyncio.run(asyncio.wait_for(run(), SOON))


def place(text, word):
    """The line and the column, in UTF-16 units, of a word."""
    line, column = text[: text.index(word)].count("\n"), text.index(word) - text.rfind("\n", 0, text.index(word)) - 1
    before = text.split("\n")[line][:column]
    return lsp.Position(line, len(before.encode("utf-16-le")) // 2)


def test_an_editor_is_told_what_is_wrong_and_how_to_mend_it(texts):
    wrong = STAND.replace("= shelf.top", "= shelv.top")

    async def steps(editor, _):
        document = editor.open(texts.stand, wrong)
        (found,) = await editor.findings(document)
        assert found.message == "there is no `shelv` here\nhelp: did you mean `shelf`?"
        assert (found.code, found.severity, found.source) == ("unknown-name", lsp.DiagnosticSeverity.Error, "apgc")
        assert found.range.start == place(wrong, "shelv.top")
        asked = lsp.CodeActionParams(document, found.range, lsp.CodeActionContext([found]))
        (action,) = await editor.text_document_code_action_async(asked)
        ((uri, (edit,)),) = action.edit.changes.items()
        assert (uri, edit.range, edit.new_text) == (document.uri, found.range, "shelf")
        editor.replace(document, 2, STAND)
        assert list(await editor.findings(document)) == []

    session(steps)


def test_a_change_in_a_module_is_told_where_it_is_used(texts):
    async def steps(editor, _):
        stand = editor.open(texts.stand, STAND)
        assert list(await editor.findings(stand)) == []
        shelves = editor.open(texts.shelves, SHELVES)
        assert list(await editor.findings(stand)) == []
        editor.replace(shelves, 2, SHELVES.replace("Board", "Plank"))
        (found,) = await editor.findings(stand)
        assert found.code == "unknown-import"
        editor.text_document_did_close(lsp.DidCloseTextDocumentParams(shelves))
        assert texts.shelves.read_text() == SHELVES  # which counts again
        assert list(await editor.findings(stand)) == []

    session(steps)


def test_places_are_told_in_the_units_of_the_editor(texts):
    text = STAND.replace("## From floor to board.", "## \N{GRINNING FACE}").replace(
        "label semantic.shelf on shelf",
        'require height > 1cm else "\N{GRINNING FACE}" repair height\n  label semantic.shelf on shelf',
    )

    async def steps(editor, offered):
        assert offered.position_encoding == lsp.PositionEncodingKind.Utf16
        document = editor.open(texts.stand, text)
        await editor.findings(document)
        at = place(text, "repair height")
        hover = await editor.text_document_hover_async(
            lsp.HoverParams(document, lsp.Position(at.line, at.character + 9))
        )
        assert hover.contents.value.startswith("```apg\nparam height : length in 30cm .. 60cm = 40cm\n```")
        assert hover.range.start.character == at.character + 7
        (declared,) = await editor.text_document_definition_async(
            lsp.DefinitionParams(document, place(text, "Board(depth"))
        )
        assert declared.uri == uris.from_fs_path(str(texts.shelves)) and declared.range.start == place(
            SHELVES, "Board {"
        )

    session(steps)


def test_an_editor_is_given_names_old_and_new_an_outline_colours_and_a_layout(texts):
    ragged = STAND.replace("  material oak", "      material   oak").replace("\n", "\r\n")

    async def steps(editor, _):
        document = editor.open(texts.stand, ragged)
        await editor.findings(document)
        asked = lsp.CompletionParams(document, place(STAND, "bottom.back range"))
        offered = await editor.text_document_completion_async(asked)
        assert {"front", "size"} <= {item.label for item in offered}
        asked = lsp.ReferenceParams(lsp.ReferenceContext(True), document, place(STAND, "Board(depth"))
        found = await editor.text_document_references_async(asked)
        assert {each.uri for each in found} == {document.uri, uris.from_fs_path(str(texts.shelves))} and len(found) == 3
        at = place(STAND, "depth =")
        offered = await editor.text_document_prepare_rename_async(lsp.PrepareRenameParams(document, at))
        assert offered.placeholder == "depth" and offered.range.start == at
        made = await editor.text_document_rename_async(lsp.RenameParams(document, at, "deep"))
        assert {uri: len(edits) for uri, edits in made.changes.items()} == {
            document.uri: 1,
            uris.from_fs_path(str(texts.shelves)): 4,
        }
        for refused in (
            editor.text_document_prepare_rename_async(lsp.PrepareRenameParams(document, place(STAND, "Cuboid"))),
            editor.text_document_rename_async(lsp.RenameParams(document, place(STAND, "Cuboid"), "Box")),
        ):
            with pytest.raises(JsonRpcException, match="`Cuboid` is declared in the library"):
                await refused
        (stand,) = await editor.text_document_document_symbol_async(lsp.DocumentSymbolParams(document))
        assert (stand.name, stand.kind) == ("Stand", lsp.SymbolKind.Module)
        assert {"height", "shelf", "leg", "tilt"} <= {inner.name for inner in stand.children}
        tokens = await editor.text_document_semantic_tokens_full_async(lsp.SemanticTokensParams(document))
        lines, shown = ragged.split("\r\n"), []
        line = column = 0
        for down, along, size, _kind, _ in zip(*[iter(tokens.data)] * 5, strict=True):
            line, column = line + down, along if down else column + along
            shown.append(lines[line][column : column + size])
        assert shown[:4] == ["apg", "1", "use", "primitives"] and "tilt" in shown
        asked = lsp.DocumentFormattingParams(document, lsp.FormattingOptions(2, True))
        (edit,) = await editor.text_document_formatting_async(asked)
        assert "\n  material   oak on" in edit.new_text and edit.range.start == lsp.Position(0, 0)

    session(steps)


def test_without_pygls_the_command_says_what_to_install(monkeypatch, capsys):
    monkeypatch.setattr("artipg_dsl.extras.find_spec", lambda _: None)
    assert main(["lsp"]) == 1
    assert "pip install 'artipg_dsl[editor]'" in capsys.readouterr().err
