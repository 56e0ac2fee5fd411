"""``--frame`` on the command line: what is said of it, and where it is refused."""

from __future__ import annotations

from pathlib import Path

from .helpers import Apgc


def test_a_format_of_another_frame_says_so(apgc: Apgc, tmp_path: Path) -> None:
    asked = ("export", "Scissors", "-n", 1, "--format", "partnet-mobility", "--no-meshes")
    assert "Scissors of the data set lie turned by -90 degrees" in apgc(*asked, "-o", tmp_path / "a")[2]
    for given in ("own", "partnet"):
        code, _, err = apgc(*asked, "--frame", given, "-o", tmp_path / given)
        assert code == 0 and "lie turned" not in err
    assert apgc("export", "Chair", "-n", 1, *asked[4:], "-o", tmp_path / "c")[2].count("\n") == 1


def test_it_is_told_and_not_changed_afterwards(apgc: Apgc, tmp_path: Path) -> None:
    asked = ("sample", "Globe", "-n", 2, "--points", 8, "--stats", "-o", tmp_path / "o")
    assert "turned by -90 degrees about z" in apgc(*asked, "--frame", "partnet")[1]
    code, _, err = apgc(*asked)
    assert code == 1 and "other options: the frame" in err
    code, _, err = apgc("export", tmp_path / "o", "--format", "urdf", "--frame", "own")
    assert code == 2 and "lie as they do" in err and "leave out --frame" in err
