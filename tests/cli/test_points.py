"""apgc sample with points of another surface, spread or density: what is written, and wrong wishes in words."""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np
import pytest

from .helpers import CHEST, ROOT, Apgc, spawn, tree

WISHES = (
    "--points",
    300,
    "--per",
    "link",
    "--spread",
    "blue",
    "--surface",
    "outside",
    "--states",
    "rest,open",
    "--motion",
)


def test_points_per_link_are_written_with_their_meaning(apgc: Apgc, tmp_path: Path) -> None:
    code, _, err = apgc("sample", CHEST, "-n", 3, "-o", tmp_path / "o", *WISHES)
    assert code == 0, err
    manifest = json.loads((tmp_path / "o" / "manifest.json").read_text())
    with np.load(tmp_path / "o" / "points-00000.npz") as arrays:
        rows = len(arrays["object"])
        assert rows > 3 and sorted(set(arrays["object"].tolist())) == [0, 1, 2]
        assert all(len(array) == rows for array in arrays.values())
        assert arrays["points"].shape == arrays["motion"].shape == (rows, 2, 300, 3)
        assert (arrays["link"] == arrays["link"][:, :1]).all()
        assert set(arrays.files) == set(manifest["arrays"])
    assert manifest["arrays"]["points"]["shape"] == "links, 2, 300, 3"
    kept = {name: manifest["identity"][name] for name in ("points", "surface", "spread", "per")}
    assert kept == {"points": 300, "surface": "outside", "spread": "blue", "per": "link"}
    code, _, err = apgc("sample", CHEST, "-n", 3, "-o", tmp_path / "o", "--points", 300)
    assert code == 1 and "the surface that points lie on (outside, now boundary)" in err


@pytest.mark.parametrize("left", [0, 1, 700])
def test_a_shard_that_is_cut_off_is_written_again(apgc: Apgc, tmp_path: Path, left: int) -> None:
    """A copy that was broken off leaves such: the same command, which completes a folder, takes it for missing."""
    again = ("sample", CHEST, "-n", 3, "-o", tmp_path / "o", "--points", 300)
    assert apgc(*again)[0] == 0
    shard = tmp_path / "o" / "points-00000.npz"
    whole = tree(tmp_path / "o")
    shard.write_bytes(shard.read_bytes()[:left])
    assert apgc(*again)[0] == 0
    assert tree(tmp_path / "o") == whole


@pytest.mark.parametrize(
    ("form", "name", "package"),
    [
        ("points.hdf5", "points-00000.h5", "h5py"),
        ("points.zarr", "points-00000.zarr.zip", "zarr"),
        ("points.parquet", "points-00000.parquet", "pyarrow"),
        ("annotation", "annotation-00000.jsonl", "json"),
    ],
)
@pytest.mark.parametrize("left", [4, 60, -3])
def test_so_is_one_of_another_kind(apgc: Apgc, tmp_path: Path, form: str, name: str, package: str, left: int) -> None:
    pytest.importorskip(package)
    again = ("sample", CHEST, "-n", 2, "-o", tmp_path / "o", "--format", form)
    assert apgc(*again)[0] == 0
    whole = tree(tmp_path / "o")
    shard = tmp_path / "o" / name
    shard.write_bytes(shard.read_bytes()[:left])
    assert apgc(*again)[0] == 0
    assert tree(tmp_path / "o") == whole


def test_bytes_do_not_depend_on_the_process(tmp_path: Path) -> None:
    for name, seed in (("a", "1"), ("b", "2")):
        made = spawn("sample", CHEST, "-n", 2, "-o", tmp_path / name, *WISHES, hash_seed=seed)
        assert made.returncode == 0, made.stderr
    assert tree(tmp_path / "a") == tree(tmp_path / "b")


@pytest.mark.parametrize(
    "wishes, message",
    [
        (("--points", "0"), "not a number from 1"),
        (("--points", "many"), "not a whole number"),
        (("--points", "2000000"), "give a number from 1 to 1000000"),
        (("--per", "part"), "there is no --per `part`"),
        (("--spread", "pink"), "there is no --spread `pink`"),
        (("--surface", "outside", "--format", "urdf"), "--surface applies to points"),
        (("--per", "link", "--format", "annotation"), "--per applies to points"),
        (("--points", "100", "--format", "annotation"), "--points applies to points"),
        (("--points", "100", "--tables"), "--points applies to points"),
        (("--states", "open", "--tables"), "--states does not apply to values alone"),
        (("--gripper", "any", "--tables"), "--gripper does not apply to values alone"),
        (("--balance", "semantic", "--weights", "handel=2"), "has no semantic `handel` to weigh"),
        (("--states", "opn=4deg"), "has no joint `opn`"),
        (("--balance", "link", "--format", "annotation"), "--balance applies to points"),
        (("--balance", "link", "--per", "link"), "points are asked for per link and balanced over each link"),
        (("--balance", "class"), "there is no --balance `class`"),
        (("--weights", "handle=2"), "weights of points are given without `balance`"),
        (("--balance", "semantic", "--weights", "handle=many"), "the weight of handle is 'many': a number is needed"),
    ],
    ids=lambda value: " ".join(value) if isinstance(value, tuple) else "",
)
def test_wrong_wishes_are_told_in_words(apgc: Apgc, tmp_path: Path, wishes: tuple[str, ...], message: str) -> None:
    code, _, err = apgc("sample", CHEST, "-n", 1, "-o", tmp_path / "o", *wishes)
    assert code == 2 and message in err
    assert not (tmp_path / "o").exists()


def test_balanced_points_come_with_what_they_stand_for(apgc: Apgc, tmp_path: Path) -> None:
    wishes = ("--points", 200, "--balance", "link", "--weights", "lid=2", "--states", "rest,open")
    code, _, err = apgc("sample", CHEST, "-n", 3, "-o", tmp_path / "o", *wishes)
    assert code == 0, err
    manifest = json.loads((tmp_path / "o" / "manifest.json").read_text())
    assert (manifest["identity"]["balance"], manifest["identity"]["weights"]) == ("link", {"lid": 2.0})
    with np.load(tmp_path / "o" / "points-00000.npz") as arrays:
        assert arrays["area"].shape == (3, 200) and manifest["arrays"]["area"]["unit"] == "m2"
        assert set(arrays.files) == set(manifest["arrays"])
    code, _, err = apgc("sample", CHEST, "-n", 3, "-o", tmp_path / "o", "--points", 200, "--states", "rest,open")
    assert code == 1 and "what points are shared out over (link, now None)" in err
    code, _, err = apgc("mutate", tmp_path / "o", "-o", tmp_path / "m")
    assert code == 0, err
    assert json.loads((tmp_path / "m" / "manifest.json").read_text())["identity"]["balance"] == "link"
    code, _, err = apgc(
        "sample", CHEST, "-n", 1, "-o", tmp_path / "x", "--balance", "semantic", "--weights", "handel=2"
    )
    assert code != 0 and "has no semantic `handel` to weigh" in err


def test_the_programs_of_the_benchmarks_are_sound(apgc: Apgc) -> None:
    files = sorted((ROOT / "benchmarks").glob("*.apg"))
    code, _, err = apgc("check", *files)
    assert code == 0 and files, err
