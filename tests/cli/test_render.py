"""``apgc render --unchecked`` shows what is wrong with objects that are not valid, and a failed ``render`` says so."""

from __future__ import annotations

from pathlib import Path

from .helpers import CHEST, Apgc

STUCK = """apg 1
use primitives { Cuboid }
category Chest {
  param wide : length in 20cm .. 30cm
  root part body : Cuboid(size = [20cm, wide, 20cm])
  part lid : Cuboid(size = [20cm, wide, 2cm])
  align lid.top = body.top
  joint open : revolute body -> lid about lid.back.bottom range 0deg .. 90deg
}
"""


def test_objects_that_collide_are_drawn_unchecked(apgc: Apgc, tmp_path: Path) -> None:
    program, sheet = tmp_path / "stuck.apg", tmp_path / "sheet.png"
    program.write_text(STUCK)
    code, _, err = apgc("render", program, "-n", 1, "-o", sheet)
    assert code == 1 and not sheet.exists()
    assert (
        "in 25 attempts for object 0;" in err
        and "body and lid collide at rest" in err
        and "`apgc render --unchecked`" in err
    )
    code, _, err = apgc("render", program, "-n", 1, "-o", sheet, "--unchecked", "--tile", 16)
    assert code == 0, err
    assert sheet.read_bytes().startswith(b"\x89PNG")


def test_a_folder_is_drawn_as_it_is(apgc: Apgc, tmp_path: Path) -> None:
    assert apgc("sample", CHEST, "-n", 1, "--points", 16, "-o", tmp_path / "out")[0] == 0
    code, _, err = apgc("render", tmp_path / "out", "--unchecked", "-o", tmp_path / "sheet.png")
    assert code == 2 and "leave out --unchecked" in err
