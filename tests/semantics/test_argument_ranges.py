"""`check` warns of an argument that lies where its template never draws, as a wrong unit does."""

from pathlib import Path

import pytest

from artipg_dsl.diagnostics import Report
from artipg_dsl.resources import library_dir
from artipg_dsl.semantics.check import check
from artipg_dsl.semantics.modules import Workspace

from .helpers import HEAD, check_text

FOOT = """
template Foot {
  param high : length in 5mm .. 40mm = 20mm
  param plan : length[2] in [1cm, 2cm] .. [3cm, 6cm]
  param tilt : angle
  count pads in 1 .. 4 = 1
  param kind : choice flat | high_
  when kind == flat {
    param rim : length in 1mm .. 3mm = 2mm
  } else {
    param rim : length in 4mm .. 9mm = 5mm
  }
  part block : Cuboid(size = [plan.x, plan.y, high])
}
"""


def warned(folder: Path, arguments: str, head: str = HEAD + FOOT, **modules: str) -> list[tuple[str, str]]:
    text = (
        f"{head}\ncategory Stool {{\n  param wide : length in 1m .. 2m\n  root part seat : Cuboid(size = [wide, 30cm, 3cm])\n"
        f"  part foot : Foot({arguments})\n  connect foot.top on seat.bottom\n}}\n"
    )
    report, _ = check_text(folder, text, **modules)
    assert not report.failed, [str(d.message) for d in report.diagnostics]
    assert all(d.severity == "warning" and d.code == "argument-outside-range" for d in report.diagnostics)
    return [(d.span.text if d.span else "", d.message) for d in report.diagnostics]


@pytest.mark.parametrize(
    ("argument", "range_"),
    [
        ("high = 20m", "5mm .. 40mm"),  # for mm
        ("high = 4mm", "5mm .. 40mm"),
        ("high = 2 * 21mm", "5mm .. 40mm"),
        ("plan = [2cm, 7cm]", "[1cm, 2cm] .. [3cm, 6cm]"),
        ("plan = [wide / 100, 1cm]", "[1cm, 2cm] .. [3cm, 6cm]"),  # one component is known
        ("pads = 5", "1 .. 4"),
    ],
)
def test_an_argument_outside_its_range(tmp_path: Path, argument: str, range_: str) -> None:
    name = argument.split(" = ")[0]
    assert warned(tmp_path, argument) == [(argument, f"`Foot` has `{name}` in {range_}")]


@pytest.mark.parametrize(
    "argument",
    [
        "high = 40mm",
        "high = 0.04m",  # rounding takes nothing out of a range
        "high = wide",  # what is drawn is not known here
        "tilt = 400deg",  # there is no range
        "plan = [1cm, 6cm]",
        "kind = flat, rim = 2mm",
    ],
)
def test_what_may_be_meant(tmp_path: Path, argument: str) -> None:
    assert warned(tmp_path, argument) == []


def test_the_ranges_of_both_branches_count(tmp_path: Path) -> None:
    both = HEAD + FOOT.replace("kind == flat", "pads < 3")
    assert warned(tmp_path, "rim = 5mm", both) == []
    assert warned(tmp_path, "rim = 1cm", both) == [("rim = 1cm", "`Foot` has `rim` in 1mm .. 3mm or 4mm .. 9mm")]


def test_constants_are_those_of_the_file_that_names_them(tmp_path: Path) -> None:
    feet = HEAD + "let most = 40mm\n" + FOOT.replace(".. 40mm", ".. most")
    head = HEAD + "use feet { Foot }\nlet most = 50mm\n"
    assert warned(tmp_path, "high = most", head, feet=feet) == [("high = most", "`Foot` has `high` in 5mm .. most")]
    assert warned(tmp_path, "high = 30mm", head, feet=feet) == []


def test_alternatives_and_roles(tmp_path: Path) -> None:
    head = HEAD + (
        "role Grip {\n  inherit reach : length in 5cm .. 20cm\n}\n"
        "template Bar_ : Grip {\n  param thick : length in 5mm .. 2cm = 1cm\n  part bar : Cuboid(size = [thick, thick, reach])\n}\n"
        "template Foot {\n  param size : length[3]\n  part block : Cuboid(size = size)\n"
        "  part grip : Grip(reach = 9m) = Bar_(thick = 3cm) | Bar_ | none\n  connect grip.bottom on block.top\n}\n"
    )
    assert warned(tmp_path, "size = [1cm, 1cm, 1cm]", head) == [
        ("reach = 9m", "`Grip` has `reach` in 5cm .. 20cm"),
        ("thick = 3cm", "`Bar_` has `thick` in 5mm .. 2cm"),
    ]


@pytest.mark.slow
def test_the_library_keeps_to_its_ranges() -> None:
    report = Report()
    workspace = Workspace(report)  # each file is read once, whoever else imports it
    for path in sorted(library_dir().glob("*.apg")):
        module = workspace.load_file(path)
        assert module is not None
        check(workspace, module, report)
    assert [(d.span and d.span.source.name, d.message) for d in report.diagnostics] == []
