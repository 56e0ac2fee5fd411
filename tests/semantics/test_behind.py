"""What stands under guards, named behind them; guards that compare the index with the number of elements."""

from __future__ import annotations

from pathlib import Path

import pytest

from .helpers import HEAD, check_text


def errors(folder: Path, body: str) -> list[str]:
    text = f"{HEAD}category T {{\n  root part body : Cuboid(size = [1m, 1m, 1m])\n  param a : choice yes | no = yes\n  count n in 2 .. 4\n"
    report, _ = check_text(folder, f"{text}  {body}\n}}\n")
    return [d.message for d in report.diagnostics if d.severity == "error"]


Q = "part q : Cuboid(size = [1cm, 1cm, w])\n  connect q to body"


def test_what_every_branch_declares_is_known_behind_it(tmp_path: Path) -> None:
    assert errors(tmp_path, "when a == yes { let w = 1cm } else { let w = 2cm }\n  " + Q) == []


@pytest.mark.parametrize(
    ("body", "where"),
    [("when a == yes { let w = 1cm }", "under"), ("when a == yes { } else { let w = 1cm }", "in the `else` of")],
)
def test_where_it_is_declared_is_said(tmp_path: Path, body: str, where: str) -> None:
    expected = f"`w` only exists under a guard: it is declared in line 8 {where} `when a == yes`"
    assert errors(tmp_path, body + "\n  " + Q) == [expected]


@pytest.mark.parametrize(
    ("first", "second"),
    [
        ("i < n - 1", "i == n - 1"),
        ("i != n - 1", "n - 1 == i"),
        ("i >= n - 1", "n - 1 > i"),
        ("n > 2 * i", "n <= 2 * i"),
    ],
)
def test_guards_that_compare_the_same_exclude_each_other(tmp_path: Path, first: str, second: str) -> None:
    part = "part q : Cuboid(size = [1cm, 1cm, 1cm])"
    body = f"repeat e[i] in 0 ..< n {{ {part}\n  when {first} {{ connect q to body }}\n  when {second} {{ connect q to body }} }}"
    assert errors(tmp_path, body) == []
