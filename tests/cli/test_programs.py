"""Commands about programs: check, compile, ledger, explain, categories."""

from __future__ import annotations

import json
import subprocess
import sys
from pathlib import Path

import pytest

from artipg_dsl.cli import compile as compiling
from artipg_dsl.cli.options.texts import EMITS
from artipg_dsl.diagnostics.codes import CODES

from .helpers import CHEST, ROOT, Apgc, environment, spawn, tree

BROKEN = """apg 1
use primitives { Cuboid }
category Brick {
  param width : length in 10cm .. 20cm = 15cm
  root part body : Cuboid(size = [widht, 10cm, 6])
}
"""


@pytest.fixture
def broken(tmp_path: Path) -> Path:
    path = tmp_path / "brick.apg"
    path.write_text(BROKEN)
    return path


def test_check_accepts_what_is_shipped(apgc: Apgc) -> None:
    # all categories are examined in tests/test_shipped.py, all primitives in tests/geometry/test_library.py
    code, out, err = apgc("check", *sorted((ROOT / "library").glob("[hl]*.apg")), ROOT / "categories" / "window.apg")
    assert (code, out) == (0, "") and "no errors" in err


def test_check_tells_all_errors_with_their_place(apgc: Apgc, broken: Path) -> None:
    code, out, err = apgc("check", CHEST, broken)
    assert code == 1
    assert f"{broken}:5:35" in out and "did you mean `width`?" in out and "missing-unit" in out
    assert "2 files: 2 errors" in err


def test_check_as_json_and_sarif(apgc: Apgc, broken: Path) -> None:
    code, out, _ = apgc("check", broken, "--json")
    found = json.loads(out)
    assert code == 1 and {f["code"] for f in found} == {"unknown-name", "missing-unit"}
    assert found[0]["place"]["line"] == 5 and found[0]["place"]["file"] == str(broken)
    code, out, _ = apgc("check", broken, "--sarif")
    assert code == 1 and len(json.loads(out)["runs"][0]["results"]) == 2
    code, out, _ = apgc("check", CHEST, "--json")
    assert (code, json.loads(out)) == (0, [])


def test_check_fails_for_warnings_only_where_it_is_asked_to(apgc: Apgc, tmp_path: Path) -> None:
    text = "apg 1\nuse primitives { Cuboid }\ncategory Box { root part body : Cuboid(size = [1cm, 1cm, 1cm]) }\n"
    (tmp_path / "box.apg").write_text(text)
    assert apgc("check", tmp_path / "box.apg")[0] == 0
    assert apgc("check", tmp_path / "box.apg", "--strict")[0] == 1
    assert apgc("check", CHEST, "--strict")[0] == 0


def test_check_tells_of_a_module_once(apgc: Apgc, tmp_path: Path) -> None:
    (tmp_path / "sizes.apg").write_text("apg 1\nlet size = 3cmm\n")
    for name in ("one", "two"):
        (tmp_path / f"{name}.apg").write_text("apg 1\nuse sizes { size }\n")
    code, out, _ = apgc("check", tmp_path / "one.apg", tmp_path / "two.apg")
    assert code == 1 and out.count("unknown-unit") == 1


@pytest.mark.parametrize("name", ["nothing.apg", "Mikrowave", "."])
def test_what_cannot_be_read_is_an_error(apgc: Apgc, name: str) -> None:
    code, out, _ = apgc("check", name)
    assert code == 1 and "missing-file" in out and "help:" in out


def test_check_reads_text_that_is_not_utf8(apgc: Apgc, tmp_path: Path) -> None:
    (tmp_path / "latin.apg").write_bytes("apg 1\n# gr\u00fcn\n".encode("latin-1"))
    code, out, _ = apgc("check", tmp_path / "latin.apg")
    assert code == 1 and "not-utf8" in out


@pytest.mark.parametrize("stage", list(EMITS))
def test_compile_shows_every_stage(apgc: Apgc, stage: str) -> None:
    code, out, err = apgc("compile", CHEST, "--emit", stage)
    assert (code, err) == (0, "")
    assert len(out.splitlines()) > 20 and "width" in out


def test_stages_offered_are_the_stages_there_are() -> None:
    assert set(EMITS) == set(compiling.EMITTERS)


def test_compile_writes_to_a_file(apgc: Apgc, tmp_path: Path) -> None:
    code, out, _ = apgc("compile", CHEST, "--emit", "typed", "-o", tmp_path / "chest.txt")
    assert (code, out) == (0, "")
    assert "category Chest" in (tmp_path / "chest.txt").read_text()
    code, _, err = apgc("compile", CHEST, "-o", tmp_path / "chest.txt")
    assert code == 1 and "chest.txt exists" in err and "--force" in err
    assert apgc("compile", CHEST, "-o", tmp_path / "chest.txt", "--force")[0] == 0
    assert "category Chest" not in (tmp_path / "chest.txt").read_text()


def test_a_compiled_program_samples_the_same_without_the_parser(apgc: Apgc, tmp_path: Path) -> None:
    assert apgc("compile", CHEST, "-o", tmp_path / "chest.apgc")[0] == 0
    for program in (CHEST, tmp_path / "chest.apgc"):
        out = tmp_path / Path(program).suffix
        assert spawn("sample", program, "-n", 5, "--seed", 7, "--points", 32, "-o", out).returncode == 0
    written, again = tree(tmp_path / ".apg"), tree(tmp_path / ".apgc")
    assert written.keys() == again.keys()
    assert all(written[name] == again[name] for name in written if name != "manifest.json")
    code = "import sys; from artipg_dsl.run.job import open_job; from artipg_dsl.run.request import Request"
    code += f"; open_job(Request({str(tmp_path / 'chest.apgc')!r})).batch([3])"
    code += "; assert not {'lark', 'artipg_dsl.lower', 'artipg_dsl.syntax'} & sys.modules.keys()"
    subprocess.run([sys.executable, "-c", code], env=environment(), check=True)


def test_a_broken_compiled_program(apgc: Apgc, tmp_path: Path) -> None:
    path = tmp_path / "chest.apgc"
    apgc("compile", CHEST, "-o", path)
    text = path.read_text()
    for broken in (
        "",
        "apgc 99\n",
        text.replace("draw", "drawn", 1),
        text[: len(text) // 2],
        text.replace("0.6", "0.7"),
        "\x00\xff",
    ):
        path.write_text(broken, encoding="latin-1")
        code, _, err = apgc("sample", path, "-o", tmp_path / "o")
        assert code == 1 and "chest.apgc" in err
    assert apgc("sample", tmp_path / "none.apgc")[0] == 1
    assert apgc("check", path)[0] == 2


def test_compile_reports_errors_and_writes_nothing(apgc: Apgc, broken: Path, tmp_path: Path) -> None:
    code, out, err = apgc("compile", broken, "--emit", "graph", "-o", tmp_path / "brick.txt")
    assert (code, out) == (1, "") and "unknown-name" in err
    assert not (tmp_path / "brick.txt").exists()


def test_ledger_tells_what_determines_a_part(apgc: Apgc) -> None:
    code, out, _ = apgc("ledger", CHEST, "lid")
    assert code == 0 and "align lid.bottom = trunk.top + 1mm" in out and "chest.apg:23" in out
    assert "knob.cap" not in out and "knob.cap" in apgc("ledger", CHEST)[1]


def test_ledger_of_alternatives_names_them(apgc: Apgc) -> None:
    assert "with door = SlabDoor" in apgc("ledger", "Microwave", "door")[1]


def test_ledger_of_no_part(apgc: Apgc) -> None:
    code, _, err = apgc("ledger", CHEST, "lit")
    assert code == 1 and "did you mean `lid`?" in err
    assert apgc("ledger", ROOT / "library" / "doors.apg")[0] == 1


def test_explain(apgc: Apgc) -> None:
    code, out, _ = apgc("explain", "missing-unit")
    assert code == 0 and CODES["missing-unit"].summary in out
    assert all(name in apgc("explain")[1] for name in CODES)
    code, _, err = apgc("explain", "mising-unit")
    assert code == 1 and "did you mean `missing-unit`?" in err


def test_categories_are_listed_with_their_story(apgc: Apgc) -> None:
    code, out, _ = apgc("categories")
    assert code == 0
    assert len(out.splitlines()) == len(list((ROOT / "categories").glob("*.apg")))
    assert any(line.startswith("Microwave  ") and "countertop" in line for line in out.splitlines())
