"""The page of the architecture shows what the stages are expected to make, and names what is there.

A comment before a listing says what it shows: a file of ``tests/pipeline/chest``, from it the lines that begin with one of
some words, or the node of which the first line contains some words.
"""

from __future__ import annotations

import re
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[2]
PAGE = ROOT / "docs" / "architecture.md"
CHEST = ROOT / "tests" / "pipeline" / "chest"
HOUSE = ROOT / "artipg_dsl"
STAGES = ("program.apg", "tree.txt", "typed.txt", "graph.txt", "plan.txt", "sample.txt", "urdf.txt")
LISTING = re.compile(
    r'^<!-- (?P<file>[\w.]+)(?: lines (?P<words>[\w|]+)| from "(?P<begin>[^"]+)")? -->\n(?P<fence>```\w+)\n(?P<text>.*?)^```$',
    re.MULTILINE | re.DOTALL,
)
ROOMS = sorted(path.parent.relative_to(HOUSE).as_posix() for path in HOUSE.rglob("*/__init__.py"))


def excerpt(listing: re.Match[str]) -> str:
    """What a listing is to show."""
    lines = (CHEST / listing["file"]).read_text(encoding="utf-8").splitlines()
    if listing["words"]:
        lines = [line for line in lines if re.match(rf"({listing['words']})\b", line)]
    elif listing["begin"]:
        lines = node(lines, listing["begin"])
    return "".join(line + "\n" for line in lines)


def node(lines: list[str], words: str) -> list[str]:
    """The first line that contains some words, with all that stands below it, an end tag too; less its indentation."""
    first = next(k for k, line in enumerate(lines) if words in line)
    deep = indented(lines[first])
    last = next((k for k in range(first + 1, len(lines)) if indented(lines[k]) <= deep), len(lines))
    last += last < len(lines) and lines[last].lstrip().startswith("</") and indented(lines[last]) == deep
    return [line[deep:] for line in lines[first:last]]


def indented(line: str) -> int:
    return len(line) - len(line.lstrip())


def test_the_page_shows_every_stage(update_golden: bool) -> None:
    page = PAGE.read_text(encoding="utf-8")
    listings = list(LISTING.finditer(page))
    assert [listing["file"] for listing in listings] == list(STAGES)
    current = LISTING.sub(lambda m: m[0].replace(f"{m['fence']}\n{m['text']}", f"{m['fence']}\n{excerpt(m)}"), page)
    if update_golden:
        PAGE.write_text(current, encoding="utf-8")
    else:
        assert page == current, "run pytest tests/pipeline tests/docs/test_architecture.py --update-golden"


TABLES = {"diagnostics/codes", "syntax/errors/mistakes"}  # rooms of entries, which are on the map with what reads them


def test_the_category_has_twelve_lines() -> None:
    assert len((CHEST / "program.apg").read_text(encoding="utf-8").splitlines()) == 12


def rows(heading: str) -> list[list[str]]:
    """The rows of the table under a heading, cell by cell."""
    _, _, rest = PAGE.read_text(encoding="utf-8").partition(f"\n## {heading}\n")
    lines = [line for line in rest.partition("\n## ")[0].splitlines() if line.startswith("|")]
    return [[cell.strip() for cell in line.strip("|").split("|")] for line in lines[2:]]


def test_every_package_is_on_the_map_with_files_that_are_there() -> None:
    found = rows("The packages")
    named = [name for row in found for name in re.findall(r"`([\w/]+)`", row[0])]
    assert sorted(named) == sorted(set(ROOMS) - TABLES)
    for row in found:
        room = re.findall(r"`([\w/.]+)`", row[0])[0]
        for file in re.findall(r"`([\w/.]+)`", row[3]):
            assert any((place / file).is_file() for place in (HOUSE / room, HOUSE)), f"{room}: {file}"


def test_what_is_to_be_changed_is_there() -> None:
    for row in rows("Where to begin"):
        for path in re.findall(r"`((?:\w+/)+\w*(?:\.\w+)?)`", " ".join(row)):
            assert (HOUSE / path).exists() or (ROOT / path).exists(), path


@pytest.mark.parametrize("room", ROOMS)
def test_a_room_says_what_it_is_for(room: str) -> None:
    """Its docstring, which names no file that is not there; the rooms of the house also what comes in and goes out."""
    text = re.match(r'"""(.+?)"""', (HOUSE / room / "__init__.py").read_text(encoding="utf-8"), re.DOTALL)
    assert text is not None
    if "/" not in room:
        assert re.search(r"\bIn\b.*\bOut\b.*\bBegin with\b", text[1], re.DOTALL), (
            f"{room} says what comes in, goes out, where to begin"
        )
    for names in re.findall(r"^    (\w[\w, ]*?)(?:  +\S.*)$", text[1], re.MULTILINE):
        for name in names.split(", "):
            assert (HOUSE / room / name).is_dir() or (HOUSE / room / f"{name}.py").is_file(), f"{room}: {name}"
