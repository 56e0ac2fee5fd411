"""The language reference is right: its examples compile and sample, its lists are those of the compiler."""

from __future__ import annotations

import math
import re
from contextlib import suppress
from pathlib import Path

import numpy as np
import pytest

from artipg_dsl.diagnostics import CompileError
from artipg_dsl.language import JOINTS
from artipg_dsl.language.tables import TABLES
from artipg_dsl.semantics import types
from artipg_dsl.syntax.grammar import reserved_words, terminal_words
from artipg_dsl.units import UNITS

from .fences import Fence, fences, session_of

PAGE = Path(__file__).parents[2] / "docs" / "language.md"
TEXT = PAGE.read_text(encoding="utf-8")
FENCES = fences(PAGE)


@pytest.mark.parametrize("fence", FENCES, ids=lambda f: f"line-{f.line}")
def test_example(fence: Fence) -> None:
    session = session_of(fence, "language.md")
    if fence.code is not None:
        with suppress(CompileError):
            _ = session.sampler
    typed, lowering = session.typed, session.lowering if fence.lowered else None
    found = [(d.severity, d.code, d.message) for d in session.report.diagnostics]
    if fence.code is not None:
        assert [code for severity, code, _ in found if severity == "error"] == [fence.code], found
        return
    assert found == []
    assert typed is not None
    if lowering is not None:
        batch = session.sampler.batch(np.arange(2), seed=1)
        assert len(batch.parts().owner) >= 2
        assert all(np.isfinite(site.translation).all() for site in batch.sites())


def test_there_are_examples_of_everything() -> None:
    """Every statement and every clause word of the grammar stands in an example that compiles."""
    shown = set(re.findall(r"[a-z]+", "\n".join(f.text for f in FENCES if f.code is None)))
    assert sorted((reserved_words() | clause_words()) - shown) == []


def clause_words() -> set[str]:
    return set(terminal_words().values()) - reserved_words()


def listed(mark: str) -> str:
    """What stands between ``<!-- mark -->`` and ``<!-- end -->``."""
    found = re.search(rf"<!-- {mark} -->\n(.*?)<!-- end -->", TEXT, re.DOTALL)
    assert found is not None
    return found[1]


def section(title: str) -> str:
    """The text under a heading, up to the next heading."""
    found = re.search(rf"^#+ {title}\n(.*?)(?=^#)", TEXT, re.MULTILINE | re.DOTALL)
    assert found is not None
    return found[1]


def rows(text: str) -> list[list[str]]:
    """The cells of the first table in a text, without its head."""
    lines = [line for line in text.split("\n") if line.startswith("|")]
    return [[c.strip() for c in re.split(r"(?<!\\)\|", line)[1:-1]] for line in lines[2:]]


def test_words() -> None:
    assert re.findall(r"`(\w+)`", listed("reserved words")) == sorted(reserved_words())
    assert re.findall(r"`(\w+)`", listed("clause words")) == sorted(clause_words())


def test_units() -> None:
    told = {}
    for unit, factor, dimension in rows(listed("units")):
        value = {"pi / 180": math.pi / 180, "2 pi": 2 * math.pi}.get(factor)
        told[unit.strip("`")] = (float(factor) if value is None else value, dimension)
    assert told == {unit: (f, types.dimension_name(d)) for unit, (f, d) in UNITS.items()}


def test_tables(update_golden: bool) -> None:
    """Types, words, functions and members stand there as the tables of the language have them."""
    current = TEXT
    for mark, table in TABLES.items():
        head, begin, rest = current.partition(f"<!-- table {mark} -->\n")
        assert begin, mark
        current = head + begin + table() + "<!-- end -->" + rest.partition("<!-- end -->")[2]
    if update_golden:
        PAGE.write_text(current, encoding="utf-8")
    else:
        assert current == TEXT, "run pytest tests/docs/test_language.py --update-golden, and read the difference"


def test_joint_kinds() -> None:
    assert re.findall(r"^\| `(\w+)` \| [^|]+ \| [^|]+ \|$", section("Kinematics"), re.MULTILINE) == list(JOINTS)
