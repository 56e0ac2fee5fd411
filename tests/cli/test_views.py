"""apgc sample with joint states, velocities and views: what is written, and wrong wishes in words."""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np
import pytest

from .helpers import CHEST, Apgc, spawn, tree

CAMERAS = {"views": 2, "width": 32, "height": 24, "points": 40}
WISHES = ("--states", "rest,random:2", "--motion", "--points", 16)


@pytest.fixture
def cameras(tmp_path: Path) -> Path:
    path = tmp_path / "cameras.json"
    path.write_text(json.dumps(CAMERAS))
    return path


def test_states_and_views_are_written(apgc: Apgc, tmp_path: Path, cameras: Path) -> None:
    code, _, err = apgc("sample", CHEST, "-n", 3, "-o", tmp_path / "o", *WISHES, "--views", cameras)
    assert code == 0, err
    files = {"manifest.json", "points-00000.npz", "annotation-00000.jsonl", "views-00000.npz"}
    assert set(tree(tmp_path / "o")) == files
    with np.load(tmp_path / "o" / "points-00000.npz") as points, np.load(tmp_path / "o" / "views-00000.npz") as views:
        assert points["points"].shape == points["motion"].shape == (3, 3, 16, 3)
        assert views["depth"].shape == (3, 3, 2, 24, 32) and views["cloud_points"].shape == (3, 3, 2, 40, 3)
    again = apgc("sample", CHEST, "-n", 3, "-o", tmp_path / "o", *WISHES, "--views", cameras)
    assert again[0] == 0
    code, _, err = apgc("sample", CHEST, "-n", 3, "-o", tmp_path / "o", "--points", 16, "--motion", "--views", cameras)
    assert code == 1 and "the joint states (rest,random:2, now rest)" in err


@pytest.mark.slow
def test_bytes_do_not_depend_on_the_process(tmp_path: Path, cameras: Path) -> None:
    for name, seed in (("a", "1"), ("b", "2")):
        made = spawn("sample", CHEST, "-n", 2, "-o", tmp_path / name, *WISHES, "--views", cameras, hash_seed=seed)
        assert made.returncode == 0, made.stderr
    assert tree(tmp_path / "a") == tree(tmp_path / "b")


@pytest.mark.parametrize(
    "wishes, message",
    [
        (("--states", "ajar"), "`ajar` is not a joint state"),
        (("--states", "random:0"), "a number from 1"),
        (("--states", "rest,open=45deg+open=20deg"), "`open=45deg+open=20deg` gives `open` two values"),
        (("--views", "0"), "`views` is 0"),
        (("--views", "cams.json"), "there is no camera file cams.json"),
        (("--motion", "--format", "urdf"), "--motion applies to points"),
    ],
)
def test_wrong_wishes_are_told_before_anything_is_written(
    apgc: Apgc, tmp_path: Path, wishes: tuple[str, ...], message: str
) -> None:
    code, _, err = apgc("sample", CHEST, "-n", 2, "-o", tmp_path / "o", *wishes)
    assert code == 2 and message in err and "help" in err
    assert not (tmp_path / "o").exists()


def test_a_broken_camera_file_is_told_in_words(apgc: Apgc, tmp_path: Path, cameras: Path) -> None:
    cameras.write_text('{"fov": "wide"}')
    code, _, err = apgc("sample", CHEST, "-n", 2, "-o", tmp_path / "o", "--views", cameras)
    assert code == 1 and "cameras.json: `fov`" in err and not (tmp_path / "o").exists()


def test_it_is_told_when_rays_take_longer(
    apgc: Apgc, tmp_path: Path, cameras: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr("artipg_dsl.geometry.rays.best_engine", lambda: "numpy")
    wish = ("sample", CHEST, "-n", 1, "--points", 16)
    code, _, err = apgc(*wish, "-o", tmp_path / "points")
    assert code == 0 and "embree" not in err  # nothing is cast
    code, _, err = apgc(*wish, "-o", tmp_path / "views", "--views", cameras)
    assert code == 0 and "NumPy casts the rays" in err and "artipg_dsl[rays]" in err
    monkeypatch.setattr("artipg_dsl.geometry.rays.best_engine", lambda: "embree")
    code, _, err = apgc(*wish, "-o", tmp_path / "embree", "--views", cameras)
    assert code == 0 and "NumPy" not in err
