"""Words that mean something everywhere keep their meaning: what would hide one is refused, and reported once."""

from __future__ import annotations

from pathlib import Path

import pytest

from .helpers import HEAD, check_text

WORD, FUNCTION = "a word of the language", "a built-in function"


def errors(folder: Path, body: str) -> list[tuple[str, str]]:
    text = f"{HEAD}category T {{\n  root part body : Cuboid(size = [1m, 1m, 1m])\n  {body}\n"
    along = "  part q : Cylinder(radius = 1cm, height = 5cm) along y\n  connect q to body\n}\n"
    report, _ = check_text(folder, text + along)
    return [(d.code, d.message) for d in report.diagnostics if d.severity == "error"]


@pytest.mark.parametrize(
    ("body", "name", "why"),
    [
        ("let x = 1cm", "x", WORD),
        ("param y : length in 1cm .. 2cm", "y", WORD),
        ("port x = frame(at = body.center, out = x, up = z)", "x", WORD),
        ("slot y = body", "y", WORD),
        ("joint z : fixed body -> r\n  part r : Cuboid(size = [1cm, 1cm, 1cm])", "z", WORD),
        ("let previous(u) = u", "previous", WORD),
        ("let last = 2", "last", WORD),
        ("let pi = 3", "pi", WORD),
        ("let sin(u) = u", "sin", FUNCTION),
        ("let left = 1cm", "left", "a face of the box that every part has"),
        ("let center(u) = u", "center", "a member that every part has"),
    ],
)
def test_a_word_is_not_hidden(tmp_path: Path, body: str, name: str, why: str) -> None:
    assert errors(tmp_path, body) == [("reserved-name", f"`{name}` cannot be declared: it is {why}")]


def test_a_function_may_be_called_like_an_axis(tmp_path: Path) -> None:
    assert errors(tmp_path, "let y(u) = u * 1cm\n  let k = y(2)") == []


@pytest.mark.parametrize("inside", ["part cap : Cuboid(size = [1cm, 1cm, 1cm])  connect cap to body", "let cap = 1cm"])
def test_nothing_in_a_repeat_is_called_like_it(tmp_path: Path, inside: str) -> None:
    found = errors(tmp_path, f"repeat cap[i] in 0 ..< 2 {{ {inside} }}")
    assert found == [("duplicate-name", "`cap` is already the name of the repeat around it")]


@pytest.mark.parametrize("said", ["row * 1cm", "row.index * 1cm", "row.rank * 1cm"])
def test_an_element_is_no_number_and_its_rank_has_a_name(tmp_path: Path, said: str) -> None:
    body = "repeat row in 0 ..< 2 spread body along x {\n    part leg : Cuboid(size = [1mm, 1mm, 1cm + SAID])\n  }"
    text = f"{HEAD}category T {{\n  root part body : Cuboid(size = [1m, 1m, 1m])\n  {body.replace('SAID', said)}\n}}\n"
    report, _ = check_text(tmp_path, text)
    hint = "to compute with its rank, name that: `repeat row[k] in ...`, and write `k`"
    assert hint in [d.hint for d in report.diagnostics if d.code in ("wrong-type", "unknown-member")]
