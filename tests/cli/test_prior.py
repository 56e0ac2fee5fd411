"""``--prior``: the same objects whatever the batch and the workers, and again from the folder; another prior is refused."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import pytest

from artipg_dsl import sample
from artipg_dsl.errors import UserError

from .helpers import CHEST, Apgc, tree

DRAWS = {"knobs": {"1": 3, "3": 1}, "wood": {"oak": "90%"}, "width": "45cm .. 50cm", "share": "~ normal(20%, 2%)"}


def prior(folder: Path, draws: Any = DRAWS, name: str = "own.json") -> Path:
    path = folder / name
    path.write_text(json.dumps({"about": "by hand", "draws": {"Chest": draws}}), encoding="utf-8")
    return path


def drawn(folder: Path) -> list[dict[str, Any]]:
    return [json.loads(line)["drawn"] for p in sorted(folder.glob("annotation-*.jsonl")) for line in p.open()]


def test_it_is_drawn_recorded_and_told(apgc: Apgc, tmp_path: Path) -> None:
    code, out, err = apgc(
        *("sample", CHEST, "-n", 40, "--points", 8, "--stats", "--prior", prior(tmp_path), "-o", tmp_path / "o")
    )
    assert code == 0, err
    assert "drawn by the prior own.json (knobs, wood, width, share)" in out
    found = drawn(tmp_path / "o")
    assert all(0.45 <= one["width"] <= 0.5 and one["knobs"] in (1, 3) for one in found)
    assert sum(one["wood"] == "oak" for one in found) > 28
    assert json.loads((tmp_path / "o" / "manifest.json").read_text())["identity"]["made"]["prior"] == DRAWS


def test_the_program_in_the_manifest_is_the_declared_one(apgc: Apgc, tmp_path: Path) -> None:
    for name, more in (("plain", []), ("other", ["--prior", prior(tmp_path)])):
        assert apgc("sample", CHEST, "-n", 2, "--points", 8, *more, "-o", tmp_path / name)[0] == 0
    plain, other = (json.loads((tmp_path / n / "manifest.json").read_text())["identity"] for n in ("plain", "other"))
    assert plain["program"] == other["program"] and "prior" not in plain["made"]
    assert drawn(tmp_path / "plain") != drawn(tmp_path / "other")


@pytest.mark.slow
def test_the_same_files_by_any_number_of_workers(apgc: Apgc, tmp_path: Path) -> None:
    arguments = ["sample", CHEST, "-n", 300, "--points", 8, "--format", "points,annotation,urdf", "--stats"]
    arguments += ["--prior", prior(tmp_path)]
    one, two = (apgc(*arguments, "-o", tmp_path / n, "--workers", n) for n in ("1", "2"))
    assert one[0] == two[0] == 0
    assert one[1] == two[1]
    assert tree(tmp_path / "1") == tree(tmp_path / "2")
    assert apgc(*arguments[:3], 20, *arguments[4:], "-o", tmp_path / "few")[0] == 0
    assert drawn(tmp_path / "few") == drawn(tmp_path / "1")[:20]


def test_a_run_goes_on_and_another_prior_is_refused(apgc: Apgc, tmp_path: Path) -> None:
    arguments = ["sample", CHEST, "-n", 300, "--points", 8, "-o", tmp_path / "o", "--prior"]
    assert apgc(*arguments, prior(tmp_path))[0] == 0
    whole = tree(tmp_path / "o")
    (tmp_path / "o" / "points-00001.npz").unlink()
    assert (
        apgc(*arguments, prior(tmp_path, dict(reversed(DRAWS.items())), "same.json"))[0] == 0
    )  # it counts what it says
    assert tree(tmp_path / "o") == whole
    for more in (["--prior", prior(tmp_path, DRAWS | {"knobs": {"2": 1}}, "other.json")], []):
        code, _, err = apgc(*arguments[:-1], *more)
        assert code == 1 and "made with other options: the prior (" in err
        assert "the compiled program" not in err
    assert tree(tmp_path / "o") == whole


def test_objects_of_a_folder_are_made_again(apgc: Apgc, tmp_path: Path) -> None:
    """Without the file: the manifest holds what it said."""
    path = prior(tmp_path)
    assert apgc("sample", CHEST, "-n", 6, "--points", 8, "-o", tmp_path / "o", "--prior", path)[0] == 0
    assert apgc("export", CHEST, "-n", 6, "--format", "urdf", "-o", tmp_path / "direct", "--prior", path)[0] == 0
    path.unlink()
    assert apgc("export", tmp_path / "o", "--format", "urdf", "-o", tmp_path / "again")[0] == 0
    again, direct = (tree(tmp_path / n) for n in ("again", "direct"))
    assert {k: v for k, v in again.items() if "manifest" not in k} == {
        k: v for k, v in direct.items() if "manifest" not in k
    }
    assert apgc("sample", tmp_path / "o", "-n", 6, "--points", 8, "-o", tmp_path / "more")[0] == 0
    assert drawn(tmp_path / "more") == drawn(tmp_path / "o")


def test_mutants_keep_to_the_prior_and_are_replayed(apgc: Apgc, tmp_path: Path) -> None:
    assert apgc("sample", CHEST, "-n", 12, "--points", 8, "-o", tmp_path / "o", "--prior", prior(tmp_path))[0] == 0
    assert apgc("mutate", tmp_path / "o", "--format", "points,annotation", "-o", tmp_path / "m")[0] == 0
    found = drawn(tmp_path / "m")
    assert all(0.45 <= one["width"] <= 0.5 for one in found)
    assert any(a != b for a, b in zip(found, drawn(tmp_path / "o"), strict=True))
    arguments = ["mutate", tmp_path / "o", "--replay", tmp_path / "m", "--format", "points,annotation"]
    assert apgc(*arguments, "-o", tmp_path / "r")[0] == 0
    assert drawn(tmp_path / "r") == found
    assert apgc("mutate", "--diff", tmp_path / "m", tmp_path / "r")[1] == "no difference\n"
    plain = tmp_path / "plain"
    assert apgc("sample", CHEST, "-n", 12, "--points", 8, "-o", plain)[0] == 0
    code, _, err = apgc("mutate", "--diff", plain, tmp_path / "o")
    assert code == 1 and "other priors" in err


def test_a_category_that_is_drawn_as_declared(apgc: Apgc, tmp_path: Path) -> None:
    """An empty object is no prior: the same bytes as without."""
    assert apgc("sample", CHEST, "-n", 3, "--points", 8, "-o", tmp_path / "a")[0] == 0
    assert apgc("sample", CHEST, "-n", 3, "--points", 8, "-o", tmp_path / "b", "--prior", prior(tmp_path, {}))[0] == 0
    assert tree(tmp_path / "a") == tree(tmp_path / "b")


@pytest.mark.parametrize("how", [["--sampling", "prior:4"], ["--repair"], ["--mutate", "dpa"], ["--set", "depth=30cm"]])
def test_other_ways_to_sample(apgc: Apgc, tmp_path: Path, how: list[str]) -> None:
    arguments = ["sample", CHEST, "-n", 8, "--points", 8, *how, "--prior", prior(tmp_path), "-o", tmp_path / "o"]
    code, _, err = apgc(*arguments)
    assert code == 0, err
    assert all(0.45 <= one["width"] <= 0.5 for one in drawn(tmp_path / "o"))


@pytest.mark.parametrize(
    ("draws", "more", "words"),
    [
        ({"knbos": {"1": 1}}, [], "own.json:1:42: Chest draws no `knbos`"),
        ({"width": [0.1, 0.5]}, [], "own.json:1:42: `width` cannot be 0.1m: it lies in 30cm .. 60cm"),
        ({"width": "45cm .. 50cm"}, ["--set", "width=55cm"], "`width` cannot be 55cm: it lies in 45cm .. 50cm"),
        ({"wood": {"oak": 1}}, ["--set", "wood=pine"], "`wood` cannot be `pine`: its weight is 0"),
        ({"width": "30cm .. 31cm", "height": "39cm .. 40cm"}, [], "no Chest is left under"),
    ],
)
def test_what_is_refused(apgc: Apgc, tmp_path: Path, draws: Any, more: list[str], words: str) -> None:
    code, _, err = apgc("sample", CHEST, "--prior", prior(tmp_path, draws), *more, "-o", tmp_path / "o")
    assert code == 2 and words in err
    assert not more or "own.json says so: set another value" in err
    assert not (tmp_path / "o").exists()


def test_what_the_program_refuses_is_not_laid_to_the_prior(apgc: Apgc, tmp_path: Path) -> None:
    for setting, words in (("width=90cm", "it lies in 30cm .. 60cm"), ("widht=40cm", "did you mean `width`?")):
        code, _, err = apgc("sample", CHEST, "--prior", prior(tmp_path), "--set", setting, "-o", tmp_path / "o")
        assert code == 2 and words in err and "says so" not in err
    code, _, err = apgc("sample", CHEST, "--prior", "", "-o", tmp_path / "o")
    assert code == 2 and "--prior is empty" in err
    with pytest.raises(UserError, match="the name of the prior is empty"):
        sample(CHEST, 1, prior="")


def test_where_nothing_is_drawn(apgc: Apgc, tmp_path: Path) -> None:
    path, values = prior(tmp_path), tmp_path / "values.json"
    values.write_text('{"width": 0.4}')
    code, _, err = apgc("sample", CHEST, "--params", values, "--prior", path, "-o", tmp_path / "p")
    assert code == 2 and "neither drawn nor set" in err
    assert apgc("sample", CHEST, "-n", 2, "--points", 8, "-o", tmp_path / "o")[0] == 0
    for command in (["sample", tmp_path / "o", "-o", tmp_path / "q"], ["export", tmp_path / "o", "--format", "urdf"]):
        code, _, err = apgc(*command, "--prior", path)
        assert code == 2 and "leave out --prior" in err


def test_a_manifest_that_does_not_fit(apgc: Apgc, tmp_path: Path) -> None:
    assert apgc("sample", CHEST, "-n", 2, "--points", 8, "-o", tmp_path / "o", "--prior", prior(tmp_path))[0] == 0
    path = tmp_path / "o" / "manifest.json"
    text = path.read_text()
    for wrong, words in (('"knbos": {', "draws no `knbos`"), ('"knobs": 4, "rest": {', "a range, a distribution")):
        path.write_text(text.replace('"knobs": {', wrong))
        code, _, err = apgc("export", tmp_path / "o", "--format", "urdf")
        assert code == 1 and "manifest.json: " in err and words in err
