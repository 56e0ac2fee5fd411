"""The grammar's health: strict LALR, the reserved words, units, the cache."""

import pickle
import re
import threading

import pytest
from lark import Lark

from artipg_dsl import cache
from artipg_dsl.syntax import generator
from artipg_dsl.syntax.errors.examples import stop
from artipg_dsl.syntax.errors.mistakes import MISTAKES
from artipg_dsl.syntax.grammar import Machine, grammar_path, machine, reserved_words, terminal_words
from artipg_dsl.syntax.layout import CONTINUES, Layout
from artipg_dsl.syntax.words import OPERATORS, file_words, statement_words
from artipg_dsl.units import UNITS

from .helpers import body_of, prefix, tree_of, without_spans

RESERVED = """
    apg use role template primitive category material vocabulary
    param inherit count let part style slot port joint connect align require prefer allow repeat when
    label grasp keypoint symmetry surface curve piece solid
    in for is else on none and or not if
""".split()
"""The words that may not be names: those that begin statements, and a few within expressions and clauses."""


def test_no_conflicts():
    pytest.importorskip("interegular")
    Lark(grammar_path().read_text(), **generator.OPTIONS, strict=True, postlex=Layout())


def test_reserved_words():
    assert reserved_words() == frozenset(RESERVED)


def test_every_other_word_is_a_name():
    words = set(terminal_words().values()) - reserved_words()
    assert {"at", "range", "box", "field", "close", "root", "weight"} <= words
    for word in sorted(words):
        body = body_of(f"param {word} : length", f"let a = {word} + b.{word}", f"connect {word} to f({word} = 1)")
        assert body[0].names == (word,)
        assert prefix(body[1].value) == f"(+ {word} b.{word})"


def test_tokens_named_outside_the_grammar_exist():
    known = {t.name for t in machine().lark.terminals}
    assert CONTINUES | statement_words() | file_words() | OPERATORS <= known


def test_every_unit_is_one_token():
    for unit in UNITS:
        (let,) = body_of(f"let a = 2.5{unit}")
        assert (let.value.value, let.value.unit) == (2.5, unit)


def test_every_unit_of_the_grammar_is_known():
    (terminal,) = [t for t in machine().lark.terminals if t.name == "QUANTITY"]
    listed = re.search(r"\(\?:(kg[^)]*)\)", terminal.pattern.value)
    assert {unit.replace("\\", "") for unit in listed[1].split("|")} <= set(UNITS)


def test_mistakes_stop_where_no_other_does():
    found = {}
    for mistake in MISTAKES:
        for sentence in mistake.sentences:
            where = stop(machine(), sentence)
            assert where is not None, f"this is no mistake: {sentence}"
            assert found.setdefault(where, mistake) is mistake, f"two messages for {sentence}"


@pytest.fixture
def kept(tmp_path, monkeypatch):
    monkeypatch.setenv("APGC_CACHE", str(tmp_path / "kept"))
    return tmp_path / "kept"


MISTAKEN = "category C { part a : B when c is D | none"


def explains() -> bool:
    """Lark's parser, which is asked about mistakes alone."""
    return Machine().mistake(MISTAKEN) is not None


def parsers(folder):
    return [entry.path for entry in cache.entries(folder) if entry.kind == "grammar"]


@pytest.mark.slow
def test_parser_of_mistakes_is_kept(kept, monkeypatch):
    assert explains()
    (file,) = parsers(kept)
    monkeypatch.setattr(generator, "_built", lambda *_: pytest.fail("the cache was not used"))
    assert explains()
    assert parsers(kept) == [file]


class Runs:
    """What a pickle can hold: a call, made when it is read."""

    def __reduce__(self):
        return pytest.fail, ("an entry of the cache was run",)


# each has the tables made again, which takes seconds
OTHERS = [b"", b"\x80\x05garbage", b"3", b'{"x":1}', b'{"pairs":[["memo",{"pairs":[]}],["data",3]]}']


@pytest.mark.parametrize("content", [pickle.dumps(Runs()), *(pytest.param(c, marks=pytest.mark.slow) for c in OTHERS)])
def test_entry_that_is_no_parser(kept, content):
    assert explains()
    (file,) = parsers(kept)
    cache.write(file.name, content)  # sealed, so that it is read
    assert explains()
    assert cache.read(file.name) != content  # and is made anew


def test_nothing_is_written_where_nothing_is_kept(tmp_path, monkeypatch):
    monkeypatch.setenv("APGC_CACHE", "off")
    monkeypatch.setenv("XDG_CACHE_HOME", str(tmp_path))
    assert explains()
    assert not any(tmp_path.iterdir())


def test_parsing_in_threads():
    text = "category C {\n" + "  param a : length in 1cm .. 2cm  ## doc\n" * 50 + "}\n"
    expected = without_spans(tree_of(text))
    found = []
    threads = [threading.Thread(target=lambda: found.append(without_spans(tree_of(text)))) for _ in range(4)]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join()
    assert found == [expected] * 4
