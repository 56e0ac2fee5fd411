"""Whole programs: the design's examples, the library and the shipped categories pass the check."""

from pathlib import Path

import pytest

from artipg_dsl.diagnostics.text import render
from artipg_dsl.resources import categories_dir, library_dir
from artipg_dsl.semantics.show import show_typed

from .helpers import HEAD, check_file, check_text

PROGRAMS = Path(__file__).parent / "programs"


@pytest.mark.parametrize("path", sorted(PROGRAMS.glob("*_of_design.apg")), ids=lambda p: p.stem)
def test_examples_of_the_design(path):
    report, _ = check_file(path)
    assert render(report.diagnostics, colour=False) == ""


@pytest.mark.slow
@pytest.mark.parametrize(
    "path", sorted([*library_dir().glob("*.apg"), *categories_dir().glob("*.apg")]), ids=lambda p: p.stem
)
def test_shipped_files(path):
    report, _ = check_file(path)
    assert render(report.diagnostics, colour=False) == ""


def test_typed_text(tmp_path):
    text = (
        HEAD
        + """
let gap = 3mm
category Chest {
  param width : length in 30cm .. 60cm
  count rows in 1 .. 3
  root part body : Cuboid
  part pull : Handle = BarHandle | none
  connect pull to body
  repeat row[r] in 0 ..< rows split body along z {
    part board : Cuboid
    connect board in row
    when r > 0 { let above = row.top } else { let first = true }
  }
}
"""
    )
    _, typed = check_text(tmp_path, text)
    shown = show_typed(typed)
    assert shown[: shown.index("module primitives")] == (
        "module main\n"
        "  function gap : a length\n"
        "  category Chest\n"
        "    param width : a length\n"
        "    count rows : a count\n"
        "    root part body : Cuboid\n"
        "    part pull : BarHandle | none\n"
        "    repeat row\n"
        "      part board : Cuboid\n"
        "      let above : a plane  when r > 0\n"
        "      let first : true or false  when not (r > 0)\n"
        "    name body : a part (Cuboid)\n"
        "    name pull : a part (BarHandle)\n"
        "    name rows : a count\n"
        "    name row : an element of a repeat  (the element itself)\n"
        "    name board : a part (Cuboid)  (of the element)\n"
        "    name r : a count  (of the element)\n"
        "    name row.top : a plane  (the element itself)\n"
        "    name true : true or false\n"
        "    name z : a direction (x, -y, ...)\n"
    )


def test_of_the_library_what_is_named_is_checked(tmp_path):
    (tmp_path / "own.apg").write_text("apg 1\nlet wrong = 1cm + 1deg\nlet good = 1cm\n")
    text = "apg 1\nuse own { good }\nuse primitives { Cuboid }\ncategory A { root part body : Cuboid(size = [good, 1cm, 1cm]) }\n"
    report, typed = check_text(tmp_path, text)
    assert [symbol.name for symbol in typed.symbols if symbol.module.name == "primitives"] == ["Cuboid"]
    assert [d.code for d in report.diagnostics] == ["wrong-dimension"]  # what nobody names in a module of one's own
