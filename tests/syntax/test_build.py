"""A statement whose rule is called like its node is built as the fields of the node say: grammar and node are enough."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

import pytest

from artipg_dsl.source import Source, Span
from artipg_dsl.syntax import build, grammar
from artipg_dsl.syntax.ast import Clause, Expr, NumberExpr, RangeExpr, Stmt


@dataclass(frozen=True, slots=True, kw_only=True)
class TwinDecl(Stmt):
    """``part x : T mirror of y``, had it a word of its own: ``twin x : T of y across z gap 1cm both``."""

    name: str
    name_span: Span
    template: str
    template_span: Span
    of: Expr
    across: Expr | None = None
    range: RangeExpr
    gap: Clause[Expr] | None = None
    both: bool


def test_a_construct_needs_its_rule_and_its_node(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    text = grammar.grammar_path().read_text(encoding="utf-8").replace("| repeat | when", "| repeat | when | twin")
    rule = "twin: TWIN NAME COLON NAME OF expr (ACROSS expr)? IN range place_clause? BOTH?"
    words = "\n".join(f"{word}.1: /{word.lower()}(?![A-Za-z0-9_])/" for word in ("TWIN", "OF", "BOTH"))
    (tmp_path / "apg.lark").write_text(f"{text}\n{rule}\n{words}\n", encoding="utf-8")
    monkeypatch.setattr(grammar, "grammar_path", lambda: tmp_path / "apg.lark")
    monkeypatch.setitem(build.KINDS, "twin", TwinDecl)
    source = Source("try", "apg 1\ncategory C {\n  ## The other one.\n  twin x : T of a.b in 1 .. 2 gap 1cm both\n}")
    tree = grammar.Machine(use_cache=False).tree(source, source.text)
    assert tree is not None
    (category,) = tree.declarations
    (found,) = category.body
    assert isinstance(found, TwinDecl)
    assert (found.name, found.template, found.both, found.across, found.doc) == ("x", "T", True, None, "The other one.")
    assert [found.name_span.column, found.template_span.column, found.of.span.column] == [8, 12, 17]
    assert isinstance(found.range.high, NumberExpr) and found.range.high.value == 2
    assert found.gap is not None and found.gap.word == "gap"


def test_what_begins_a_statement_is_read_from_the_grammar() -> None:
    from artipg_dsl.syntax.words import file_words, statement_words

    assert {"PARAM", "ROOT", "PART", "WHEN_BLOCK", "MATERIAL", "SOLID", "CURVE"} < statement_words()
    assert file_words() == set("USE ROLE TEMPLATE PRIMITIVE CATEGORY MATERIAL VOCABULARY LET".split())
