"""The formatter: the same program, laid out; what is laid out stays."""

from __future__ import annotations

import os
import random
import re
from pathlib import Path

import pytest

from artipg_dsl.cli.new import starting_point
from artipg_dsl.diagnostics import Report
from artipg_dsl.resources import categories_dir, library_dir
from artipg_dsl.source import Source
from artipg_dsl.syntax.format import format_source

SHIPPED = sorted((*categories_dir().glob("*.apg"), *library_dir().glob("*.apg")))


def laid_out(text: str) -> str:
    report = Report()
    found = format_source(Source("text.apg", text), report)
    assert found is not None, report.diagnostics
    return found


# the others where `apgc fmt --check` runs, as in .ci/run
@pytest.mark.parametrize("path", SHIPPED if os.environ.get("ARTIPG_EVERY") else SHIPPED[::4], ids=lambda p: p.stem)
def test_shipped_text_is_laid_out(path: Path) -> None:
    text = path.read_text(encoding="utf-8")
    assert laid_out(text) == text


def test_starting_point_is_laid_out() -> None:
    assert laid_out(starting_point("Thing")) == starting_point("Thing")


@pytest.mark.slow
@pytest.mark.parametrize("path", SHIPPED[::3], ids=lambda p: p.stem)
def test_disorder(path: Path) -> None:
    """Spaces at the ends of lines, tabs, blank lines, a shift of everything: all of it goes, and nothing else."""
    text = path.read_text(encoding="utf-8")
    draw = random.Random(path.stem)
    lines = [line + draw.choice(("", "", " ", "\t ")) for line in text.split("\n")]
    assert laid_out("\n".join(lines)) == text
    assert laid_out(re.sub(r"^(?=.)", "   ", text, flags=re.MULTILINE)) == text
    assert laid_out("\n\n" + re.sub(r"\n\n", "\n\n\n\n", text) + "\n\n") == text
    assert laid_out(text.replace("\n", "\r\n").replace("\r\n", "\n")) == text
    once = laid_out(re.sub(r" += +", "=", text))
    assert laid_out(once) == once


CASES = {
    "spaces": (
        "category A{\nparam w:length in 1cm..2cm=1cm\nroot part b:Cuboid( size=[ w ,w,w ] )\n}",
        "category A {\n  param w : length in 1cm .. 2cm = 1cm\n  root part b : Cuboid(size = [w, w, w])\n}\n",
    ),
    "aligned": (
        "category A {\n  param w    : length = 1cm      # wide\n  param long : length = 2cm # long\n}\n",
        "category A {\n  param w    : length = 1cm      # wide\n  param long : length = 2cm  # long\n}\n",
    ),
    "continued lines move along": (
        "category A {\n      root part b : B = C weight 2\n                      | D\n}\n",
        "category A {\n  root part b : B = C weight 2\n                  | D\n}\n",
    ),
    "comments": (
        "# a\n\n\n\n# b\ncategory A {\n\n# one\n      # two\n  when x {\n# three\n}\n# four\n}\n# five",
        "# a\n\n# b\ncategory A {\n  # one\n  # two\n  when x {\n    # three\n  }\n  # four\n}\n# five\n",
    ),
    "operators keep theirs": ("let f(a) = a*2 + -a/4 - 1/2turn\n", "let f(a) = a*2 + -a/4 - 1/2turn\n"),
    "a comment behind a brace": (
        "category A {  # what\nwhen x {  # why\nlet a = 1\n}\n}\n",
        "category A {  # what\n  when x {  # why\n    let a = 1\n  }\n}\n",
    ),
    "empty braces": ("category A{}\n", "category A { }\n"),
    "hanging braces": (
        "material m { density 1kg/m3\n               friction 0.5 }\n",
        "material m { density 1kg/m3\n               friction 0.5 }\n",
    ),
}


@pytest.mark.parametrize("name", CASES)
def test_case(name: str) -> None:
    before, after = CASES[name]
    assert laid_out("apg 1\n" + before) == "apg 1\n" + after
    assert laid_out("apg 1\n" + after) == "apg 1\n" + after


def test_what_does_not_parse_is_left_alone() -> None:
    report = Report()
    assert format_source(Source("text.apg", "apg 1\ncategory {"), report) is None
    assert report.failed
