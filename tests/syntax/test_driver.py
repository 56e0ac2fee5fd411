"""Texts are parsed by the tables of lark's parser as lark does it: the same trees, and a mistake where lark sees one."""

import os
import random
import subprocess
import sys
from pathlib import Path

import pytest
from lark import UnexpectedInput

from artipg_dsl.diagnostics import Report
from artipg_dsl.resources import categories_dir, library_dir
from artipg_dsl.source import Source
from artipg_dsl.syntax import generator, tables
from artipg_dsl.syntax.build_module import TreeBuilder
from artipg_dsl.syntax.grammar import grammar_path, machine
from artipg_dsl.syntax.layout import Layout
from artipg_dsl.syntax.parse import parse
from artipg_dsl.syntax.token import Token

FORMS = Path(__file__).parent / "design" / "forms.apg"
CUTS = 40  # mistakes made in a text


class Placed(Token):
    line = column = end_line = end_column = 0  # lark gives them to its token for the end


class OurTokens(Layout):
    """A layout that hands lark's parser tokens of ours, which the builder knows."""

    def process(self, stream):
        for token in super().process(stream):
            yield Placed(token.type, token.value, token.start_pos, token.end_pos)


@pytest.fixture(scope="module")
def by_lark():
    """Lark itself with our actions: from a source to its tree; None where it has none."""
    layout = OurTokens()
    builder = TreeBuilder(layout)
    comments = {"COMMENT": layout.comment, "DOC": layout.comment}
    text = grammar_path().read_text(encoding="utf-8")
    live = {"transformer": builder, "postlex": layout, "lexer_callbacks": comments}
    parser = generator._built(text, live)
    layout.reserved = machine().layout.reserved

    def tree(source):
        layout.begin(source.text)
        builder.begin(source)
        try:
            return parser.parse(source.text)
        except UnexpectedInput:
            return None

    return tree


def read(path):
    return Source(path.name, path.read_text(encoding="utf-8"))


def test_trees_are_those_of_lark(by_lark):
    every = sorted(library_dir().glob("*.apg")) + sorted(categories_dir().glob("*.apg"))
    every = every if os.environ.get("ARTIPG_EVERY") else every[::10]
    for path in (FORMS, *every):
        source = read(path)
        assert machine().tree(source, source.text) == by_lark(source), path.name


def test_mistakes_are_those_of_lark(by_lark):
    """Pieces cut out of a text, and put in elsewhere: what is left is a text for both parsers, or for neither."""
    text, pick = FORMS.read_text(encoding="utf-8"), random.Random(3)
    wrong = 0
    for _ in range(CUTS):
        at, to, end = pick.randrange(len(text)), pick.randrange(len(text)), pick.randrange(1, 6)
        spoilt = text[:at] + text[at + end :]
        source = Source("spoilt", spoilt[:to] + text[at : at + end] + spoilt[to:])
        expected = by_lark(source)
        assert machine().tree(source, source.text) == expected
        wrong += expected is None
    assert wrong > CUTS // 2


def test_the_tables_are_those_of_the_grammar(update_golden):
    text = grammar_path().read_text(encoding="utf-8")
    path = grammar_path().with_name("tables.json")
    current = tables.to_json(tables.tables_of(machine().lark), text)
    if update_golden:
        path.write_text(current, encoding="utf-8")
    else:
        assert path.read_text(encoding="utf-8") == current, "run pytest tests/syntax/test_driver.py --update-golden"
    assert tables.to_json(tables.read_tables(text), text) == current


def test_tables_of_another_grammar_are_not_taken():
    text = grammar_path().read_text(encoding="utf-8")
    assert tables.read_tables(text + "\n") is None


def test_lark_is_asked_about_mistakes_alone():
    """A text is parsed without lark, which takes long to start."""
    program = (
        "import sys; from artipg_dsl.syntax.grammar import machine; from artipg_dsl.source import Source;"
        "text = 'category C { part a : B when c is D | none }'; assert machine().tree(Source('', text), text);"
        "print('lark' in sys.modules)"
    )
    found = subprocess.check_output([sys.executable, "-c", program], text=True, env={**os.environ, "APGC_CACHE": "off"})
    assert found.strip() == "False"


def test_a_mistake_is_told_as_lark_sees_it():
    report = Report()
    assert parse(Source("x", "category C { part a B }"), report) is None
    assert [finding.code for finding in report.diagnostics] == ["syntax"]
