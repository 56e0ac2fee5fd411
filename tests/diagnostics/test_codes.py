"""The registry: every code is emitted, explained, exemplified, documented, and its example brings it about."""

import ast
import re
from pathlib import Path

import pytest

import artipg_dsl
from artipg_dsl.cli.main import main
from artipg_dsl.diagnostics import CompileError, Report
from artipg_dsl.diagnostics.codes import CODES, explain
from artipg_dsl.diagnostics.page import COMMAND, page
from artipg_dsl.session import Session
from artipg_dsl.syntax.load import load

ROOT = Path(__file__).parents[2]
PAGE = ROOT / "docs" / "diagnostics.md"

OF_FILES = {"missing-file", "not-utf8", "reversed-text", "import-cycle"}
"""Codes that take files to come about; each has a test below."""

WITHOUT_EXAMPLE = OF_FILES | {"unrelated-rows"}


def found_in(session: Session) -> set[str]:
    """The codes of all findings up to what can be sampled, as ``apgc check`` shows them."""
    try:
        _ = session.sampler
    except CompileError:
        pass
    if not session.report.diagnostics:  # a small example has no materials, which is not what it is about
        session.advise()
    return {d.code for d in session.report.diagnostics}


def spoken() -> dict[str, str]:
    """The codes that the sources name where they report something, each with a file."""
    found = {}
    for path in sorted(Path(artipg_dsl.__file__).parent.rglob("*.py")):
        if path.parent.name == "codes":
            continue
        for node in ast.walk(ast.parse(path.read_text(encoding="utf-8"))):
            if isinstance(node, ast.Constant) and node.value in CODES:
                found[node.value] = path.name
            if isinstance(node, ast.Call) and isinstance(node.func, ast.Attribute) and node.args:
                first = node.args[0]
                if node.func.attr in ("error", "warning") and isinstance(first, ast.Constant):
                    found[str(first.value)] = path.name
    return found


def test_the_codes_of_the_sources_are_those_of_the_registry() -> None:
    emitted = spoken()
    assert {c: f for c, f in emitted.items() if c not in CODES} == {}
    assert set(CODES) - set(emitted) == set()


@pytest.mark.parametrize("name", sorted(CODES))
def test_explanation(name: str) -> None:
    code = CODES[name]
    assert len(code.summary) < 80 and not code.summary.endswith(".")
    sentences = len(re.findall(r"\.(?:\s|$)", code.text))
    assert 3 <= sentences <= 8, "what it means, why, how to mend it"


@pytest.mark.parametrize("name", sorted(set(CODES) - WITHOUT_EXAMPLE))
def test_example(name: str) -> None:
    assert CODES[name].example.startswith("apg 1\n")
    assert found_in(Session.of_text(CODES[name].example, f"{name}.apg")) == {name}


def test_only_what_a_text_cannot_show_has_no_example() -> None:
    assert {c.name for c in CODES.values() if not c.example} == WITHOUT_EXAMPLE


def test_missing_file(tmp_path: Path) -> None:
    assert found_in(Session.of(tmp_path / "gone.apg")) == {"missing-file"}
    assert found_in(Session.of("Microwaev")) == {"missing-file"}
    report = Report()
    load(tmp_path, report)
    (folder,) = report.diagnostics
    assert folder.code == "missing-file" and folder.message.endswith("is a folder")


@pytest.mark.parametrize("character", ["\u202e", "\u2066"])
def test_reversed_text(tmp_path: Path, character: str) -> None:
    path = tmp_path / "turned.apg"
    path.write_text(f"apg 1\n# {character}liam\n", encoding="utf-8")
    report = Report()
    load(path, report)
    (found,) = report.diagnostics
    assert found.code == "reversed-text" and found.span is not None and found.span.words == character
    path.write_text("apg 1\n# \u05e9\u05dc\u05d5\u05dd\n", encoding="utf-8")  # Hebrew runs that way by itself
    report = Report()
    assert load(path, report) is not None and not report.diagnostics


def test_not_utf8(tmp_path: Path) -> None:
    path = tmp_path / "old.apg"
    path.write_bytes("apg 1\n# M\xf6bel\n".encode("latin-1"))
    assert found_in(Session.of(path)) == {"not-utf8"}


def test_import_cycle(tmp_path: Path) -> None:
    (tmp_path / "first.apg").write_text("apg 1\nuse second { b }\nlet a(x) = b(x)\n")
    (tmp_path / "second.apg").write_text("apg 1\nuse first { a }\nlet b(x) = 2 * x\n")
    assert "import-cycle" in found_in(Session.of(tmp_path / "first.apg"))


def test_the_page_is_current(update_golden: bool) -> None:
    if update_golden:
        PAGE.write_text(page(), encoding="utf-8")
    assert PAGE.read_text(encoding="utf-8") == page(), f"run: {COMMAND}"


@pytest.mark.parametrize("name", sorted(CODES))
def test_every_code_is_documented_and_explained(name: str, capsys: pytest.CaptureFixture[str]) -> None:
    assert f"\n### {name}\n" in PAGE.read_text(encoding="utf-8")
    assert main(["explain", name]) == 0
    said = capsys.readouterr().out
    assert said.startswith(f"{name}: {CODES[name].summary}")
    assert all(line in said for line in CODES[name].example.splitlines())


def test_explain_of_no_code(capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["explain", "redundent"]) != 0
    assert "did you mean `redundant`?" in capsys.readouterr().err


def test_unregistered_codes_fail_loudly() -> None:
    with pytest.raises(KeyError, match="no-such-code"):
        Report().error("no-such-code", None, "words")


def test_explain() -> None:
    text = explain("missing-brace")
    assert text is not None and text.startswith("missing-brace: a brace is never closed\n\n")
    assert "    category Stool {\n" in text and max(map(len, text.splitlines())) <= 100
    assert explain("no-such-code") is None
