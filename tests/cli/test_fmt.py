"""apgc fmt."""

from __future__ import annotations

import io
from pathlib import Path

import pytest

from .helpers import Apgc

ROUGH = "apg 1\ncategory A{\nparam w:length = 1cm\n}\n"
SMOOTH = "apg 1\ncategory A {\n  param w : length = 1cm\n}\n"


def test_files(apgc: Apgc, tmp_path: Path) -> None:
    rough, smooth, broken = (tmp_path / f"{name}.apg" for name in ("rough", "smooth", "broken"))
    rough.write_text(ROUGH, encoding="utf-8")
    smooth.write_text(SMOOTH, encoding="utf-8")
    broken.write_text("apg 1\ncategory {", encoding="utf-8")
    assert apgc("fmt", "--check", rough, smooth) == (1, f"{rough}\n", "2 files: 1 would change\n")
    code, out, _ = apgc("fmt", "--diff", rough)
    assert code == 0 and "-param w:length = 1cm" in out and "+  param w : length = 1cm" in out
    assert rough.read_text(encoding="utf-8") == ROUGH
    code, out, err = apgc("fmt", rough, smooth, broken, tmp_path / "absent.apg")
    assert code == 1 and "broken.apg:2" in out and "there is no file" in out and "2 files: 1 changed, 2 skipped" in err
    assert rough.read_text(encoding="utf-8") == SMOOTH
    assert broken.read_text(encoding="utf-8") == "apg 1\ncategory {"
    assert apgc("fmt", "--check", rough, smooth)[0] == 0
    _, out, err = apgc("fmt", "--check", "Chair")
    assert (
        err == "0 files: 0 would change, 1 skipped\n" and "help: check the path; `apgc new NAME --from CATEGORY`" in out
    )


@pytest.mark.parametrize(
    "given", [ROUGH.encode(), b"\xef\xbb\xbf" + ROUGH.encode(), ROUGH.replace("\n", "\r").encode()]
)
def test_stdin_is_read_as_files_are(apgc: Apgc, monkeypatch: pytest.MonkeyPatch, given: bytes) -> None:
    monkeypatch.setattr("sys.stdin", io.TextIOWrapper(io.BytesIO(given), encoding="latin-1"))
    assert apgc("fmt", "-") == (0, SMOOTH, "")


def test_stdin_that_is_no_text(apgc: Apgc, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("sys.stdin", io.TextIOWrapper(io.BytesIO(b"apg 1\n\xff")))
    code, out, _ = apgc("fmt", "-")
    assert code == 1 and "<stdin>:2:1" in out and "this file is not UTF-8 text" in out
