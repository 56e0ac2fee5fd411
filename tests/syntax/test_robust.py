"""Broken text never breaks the parser: mutated programs give findings with valid places, or parse."""

import random
import re
from pathlib import Path

import pytest

from artipg_dsl.diagnostics import Report
from artipg_dsl.diagnostics.text import render
from artipg_dsl.source import Source
from artipg_dsl.syntax.parse import parse

DESIGN = Path(__file__).parent / "design"
PIECE = re.compile(r'"[^"\n]*"|#[^\n]*|\w+|\s+|[^\w\s]')
NOISE = [
    "{",
    "}",
    "(",
    ")",
    "[",
    "]",
    '"',
    "=",
    "..",
    "..<",
    "->",
    "|",
    ",",
    ".",
    ":",
    "5",
    "5cm",
    "1/2turn",
    "part",
    "when",
    "at",
    "else",
    "none",
    "\n",
    "##",
    "#",
    "%",
    "ö",
    "\x00",
    "\\",
    "_",
    "in",
    "is",
    "-",
    "?",
]


def mutated(text: str, chance: random.Random) -> str:
    pieces = PIECE.findall(text)
    for _ in range(chance.randint(1, 4)):
        at = chance.randrange(len(pieces))
        match chance.randrange(4):
            case 0:
                del pieces[at]
            case 1:
                pieces.insert(at, chance.choice(NOISE))
            case 2:
                other = chance.randrange(len(pieces))
                pieces[at], pieces[other] = pieces[other], pieces[at]
            case 3:
                del pieces[at : at + chance.randint(1, 30)]
    return "".join(pieces)


def check(text: str) -> None:
    report = Report()
    tree = parse(Source("m.apg", text), report)
    assert (tree is None) == report.failed
    for d in report.diagnostics:
        assert d.span is not None and 0 <= d.span.start <= d.span.end <= len(text)
        assert d.message and "None" not in d.message
    render(report.diagnostics, colour=False)


@pytest.mark.some
@pytest.mark.parametrize("seed", range(6))
@pytest.mark.parametrize("path", sorted(DESIGN.glob("*.apg")), ids=lambda p: p.stem)
def test_mutated_programs(path: Path, seed: int) -> None:
    chance = random.Random(f"{path.stem} {seed}")
    text = path.read_text(encoding="utf-8")
    for _ in range(4):
        check(mutated(text, chance))


@pytest.mark.parametrize(
    "text",
    [
        "",
        " ",
        "\n",
        "#",
        "## only a comment",
        "apg",
        "apg 1",
        "{",
        "}",
        "(",
        '"',
        "category",
        "category C",
        "category C {",
        "\x00",
        "let a = " + "(" * 500 + "1" + ")" * 500,
        "let a = " + "(" * 500,
        "let a = 1" + " + 1" * 2000,
        "}" * 50,
        "{" * 50,
        "category C { " + "when a { " * 200 + "} " * 200 + "}",
    ],
    ids=lambda t: repr(t[:12]),
)
def test_odd_texts(text: str) -> None:
    check(text)
