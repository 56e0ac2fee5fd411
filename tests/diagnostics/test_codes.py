"""The registry: every code is explained, and its example brings it about."""

import ast
from pathlib import Path

import pytest

import artipg_dsl
from artipg_dsl.diagnostics import CODES, Report, explain
from artipg_dsl.session import check_text
from artipg_dsl.source import Source

NOT_BY_ONE_TEXT = {"missing-file", "not-utf8", "import-cycle", "no-category"}
"""Codes that need more than a text to come about."""

WITHOUT_EXAMPLE = NOT_BY_ONE_TEXT | {
    "always-true", "bad-curve", "broken-chain", "circular", "impossible", "leaky-primitive",
    "needs-clearance", "needs-index", "recurrence", "too-many-cases",
    "unrelated-rows",
}  # fmt: skip
"""These have none so far. A new code brings an example."""


@pytest.mark.parametrize("name", sorted(CODES))
def test_example(name: str) -> None:
    code = CODES[name]
    assert code.summary and len(code.text) > 40
    if name in WITHOUT_EXAMPLE:
        assert not code.example, "strike it off the list"
    else:
        found = check_text(Source(f"{name}.apg", code.example)).diagnostics
        assert {d.code for d in found} == {name}


def test_every_code_that_the_compiler_speaks_of_is_registered() -> None:
    spoken = set()
    for path in Path(artipg_dsl.__file__).parent.rglob("*.py"):
        for node in ast.walk(ast.parse(path.read_text(encoding="utf-8"))):
            if isinstance(node, ast.Call) and isinstance(node.func, ast.Attribute) and node.args:
                first = node.args[0]
                if node.func.attr in ("error", "warning") and isinstance(first, ast.Constant):
                    spoken.add(first.value)
    assert len(spoken) > 30 and spoken <= set(CODES)


def test_unregistered_codes_fail_loudly() -> None:
    with pytest.raises(KeyError, match="no-such-code"):
        Report().error("no-such-code", None, "words")


def test_explain() -> None:
    text = explain("missing-brace")
    assert text is not None and text.startswith("missing-brace: a brace is never closed\n\n")
    assert "    category Stool {\n" in text and max(map(len, text.splitlines())) <= 100
    assert explain("no-such-code") is None
