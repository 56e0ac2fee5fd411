"""The report and its written forms."""

import io
import json

import pytest

from artipg_dsl.cli.messages import findings
from artipg_dsl.diagnostics import CompileError, Report, did_you_mean, suggest
from artipg_dsl.diagnostics.data import to_json, to_sarif
from artipg_dsl.diagnostics.text import render, summary
from artipg_dsl.source import Source, Span

TEXT = "apg 1\ncategory C {\n\tpart a : B\n  part c : Dd\n}\n"
SOURCE = Source("c.apg", TEXT)


def at(word: str) -> Span:
    start = TEXT.index(word)
    return Span(SOURCE, start, start + len(word))


def example() -> Report:
    report = Report()
    report.error(
        "unknown-template",
        at("Dd"),
        "there is no `Dd`",
        hint="did you mean `B`?",
        notes=((at("B"), "this one"),),
        trace=((at("category"), "in category `C`"),),
    )
    report.warning("redundant", at("part a : B"), "not needed")
    return report


def test_text() -> None:
    assert render(example().diagnostics, colour=False) == (
        "warning[redundant]: not needed\n"
        " --> c.apg:3:2\n"
        "  |\n"
        "3 |  part a : B\n"
        "  |  ^^^^^^^^^^\n"
        "\n"
        "error[unknown-template]: there is no `Dd`\n"
        " --> c.apg:4:12\n"
        "  |\n"
        "4 |   part c : Dd\n"
        "  |            ^^\n"
        " ::: c.apg:3:11\n"
        "  |\n"
        "3 |  part a : B\n"
        "  |           - this one\n"
        "  = in category `C` (c.apg:2:1)\n"
        "  = help: did you mean `B`?"
    )


def test_colour_changes_no_words() -> None:
    import re

    painted = render(example().diagnostics, colour=True)
    assert "\x1b[" in painted
    assert re.sub(r"\x1b\[[0-9;]*m", "", painted) == render(example().diagnostics, colour=False)


def test_a_span_over_several_lines_and_one_at_the_end() -> None:
    report = Report()
    report.error("syntax", Span(SOURCE, TEXT.index("category"), len(TEXT) - 1), "long")
    report.error("syntax", Span(SOURCE, len(TEXT), len(TEXT)), "end")
    lines = render(report.diagnostics, colour=False).splitlines()
    assert lines[3:5] == ["2 | category C {", "  | ^^^^^^^^^^^^ ... to line 5"]
    assert lines[7] == " --> c.apg:6:1" and lines[-1].rstrip() == "  | ^"


def test_one_gutter_for_all_places_of_a_finding() -> None:
    source = Source("long.apg", "\n" * 8 + "part a : B\n\tpart c : D\n")
    first, second = (Span(source, source.text.index(w), source.text.index(w) + 1) for w in ("a :", "c :"))
    report = Report()
    report.error("duplicate-name", second, "twice", notes=((first, "the first of them"),), hint="rename one")
    assert render(report.diagnostics, colour=False).splitlines() == [
        "error[duplicate-name]: twice",
        "  --> long.apg:10:7",
        "   |",
        "10 |  part c : D",
        "   |       ^",
        "  ::: long.apg:9:6",
        "   |",
        " 9 | part a : B",
        "   |      - the first of them",
        "   = help: rename one",
    ]


def test_carets_stand_under_wide_letters_and_tabs() -> None:
    source = Source("wide.apg", '\trequire a else "\u6269\u6563" b\n')
    start = source.text.index(" b") + 1
    report = Report()
    report.error("syntax", Span(source, start, start + 1), "here")
    line, marks = render(report.diagnostics, colour=False).splitlines()[3:5]
    assert line.endswith("b") and marks.index("^") == line.index("b") + 2  # two letters of two columns


def test_a_finding_without_a_place() -> None:
    report = Report()
    report.error("missing-file", None, "there is no file x.apg", hint="check the path")
    assert render(report.diagnostics, colour=False) == (
        "error[missing-file]: there is no file x.apg\n  = help: check the path"
    )


def test_a_long_trace_shows_its_innermost_parts() -> None:
    report = Report()
    trace = tuple((at("part a"), f"in `p{k}`") for k in range(6))
    report.error("tie", at("Dd"), "which", trace=trace)
    shown = [line.split(" = ")[1].split(" (")[0] for line in render(report.diagnostics, colour=False).splitlines()[5:]]
    assert shown == ["in `p5`", "in `p4`", "in `p3`", "in `p2`", "and 2 more around it"]


@pytest.mark.parametrize("tty, quiet, painted", [(True, False, True), (True, True, False), (False, False, False)])
def test_colours_only_on_a_terminal(tty: bool, quiet: bool, painted: bool, monkeypatch: pytest.MonkeyPatch) -> None:
    stream = io.StringIO()
    stream.isatty = lambda: tty  # type: ignore[method-assign]
    monkeypatch.delenv("NO_COLOR", raising=False)
    if quiet:
        monkeypatch.setenv("NO_COLOR", "1")
    findings(example().diagnostics, stream)
    assert ("\x1b[" in stream.getvalue()) == painted and "there is no `Dd`" in stream.getvalue()


def test_json_and_sarif_without_a_place() -> None:
    report = Report()
    report.error("missing-file", None, "gone")
    (row,) = json.loads(to_json(report.diagnostics))
    assert row["place"] is None and row["notes"] == [] and row["hint"] is None
    (result,) = json.loads(to_sarif(report.diagnostics, "1.0"))["runs"][0]["results"]
    assert "locations" not in result and result["level"] == "error"


def test_same_finding_counts_once_in_order_of_the_text() -> None:
    report = example()
    report.extend(example())
    report.error("missing-file", None, "gone")
    assert [d.code for d in report.diagnostics] == ["missing-file", "redundant", "unknown-template"]
    assert report.failed and summary(report.diagnostics) == "2 errors, 1 warning"


def test_warnings_do_not_fail() -> None:
    report = Report()
    report.warning("redundant", at("B"), "not needed")
    assert not report.failed


def test_json() -> None:
    first, second = json.loads(to_json(example().diagnostics))
    assert (first["severity"], second["hint"]) == ("warning", "did you mean `B`?")
    assert second["place"] == {"file": "c.apg", "line": 4, "column": 12, "end_line": 4, "end_column": 14}
    assert second["notes"][0]["message"] == "this one" and second["trace"][0]["place"]["line"] == 2


def test_sarif() -> None:
    log = json.loads(to_sarif(example().diagnostics, "1.0"))
    (run,) = log["runs"]
    assert log["version"] == "2.1.0" and {r["id"] for r in run["tool"]["driver"]["rules"]} == {
        "redundant",
        "unknown-template",
    }
    assert run["columnKind"] == "unicodeCodePoints"
    result = run["results"][1]
    assert result["message"]["text"] == "there is no `Dd`. Help: did you mean `B`?"
    assert [r["message"]["text"] for r in result["relatedLocations"]] == ["this one", "in category `C`"]
    assert result["locations"][0]["physicalLocation"]["artifactLocation"] == {"uri": "c.apg"}
    region = result["locations"][0]["physicalLocation"]["region"]
    assert region == {"startLine": 4, "startColumn": 12, "endLine": 4, "endColumn": 14}


def test_compile_error_says_what_is_wrong() -> None:
    assert "there is no `Dd`" in str(CompileError(example()))


def test_suggestions() -> None:
    assert suggest("widht", ["width", "height"]) == "width"
    assert suggest("CUBOID", ["Cuboid", "Cylinder"]) == "Cuboid"
    assert suggest("qqq", ["width"]) is None
    assert did_you_mean("hieght", {"width": 1, "height": 2}) == "did you mean `height`?"
    assert did_you_mean("qqq", []) is None
