"""Samples of a category beside clouds: of its own objects, of others, and of what cannot be read."""

import json
from pathlib import Path

import numpy as np
import pytest

import artipg_dsl as apg
from artipg_dsl.cli.main import main
from tests.cli.helpers import CHEST

N = 4


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Chests 0 .. 3, labelled in other words, and a ball."""
    into = tmp_path_factory.mktemp("real")
    samples = apg.sample(CHEST, n=N)
    points = samples.points(6000)
    words = {"trunk": "body", "cover": "door", "knob": "handle"}
    names = samples.batch.program.vocabularies["semantic"]
    for k in range(N):
        label = np.array([list(words.values()).index(names[c]) for c in points.semantic[k]])
        np.savez(
            into / f"chest{k}.npz",
            points=points.position[k],
            normals=points.normal[k],
            label=label,
            label_names=list(words),
        )
    ball = np.random.default_rng(0).normal(size=(6000, 3))
    np.savez(into / "xball.npz", points=0.2 * ball / np.linalg.norm(ball, axis=1, keepdims=True))
    (into / "map.json").write_text(json.dumps(words))
    return into


def compare(capsys: pytest.CaptureFixture[str], *arguments: object) -> dict:
    assert main(["compare", CHEST, *map(str, arguments), "--json"]) == 0
    return json.loads(capsys.readouterr().out)


def test_its_own_objects_are_near_and_a_ball_is_far(folder: Path, capsys: pytest.CaptureFixture[str]) -> None:
    found = compare(capsys, folder, "-n", 12, "--front=x", "--map", folder / "map.json")
    chests, ball = found["real"][:N], found["real"][N]
    assert [one["nearest"] for one in chests] == list(range(N))
    assert max(one["distance"] for one in chests) < 2.2 < 4.5 < ball["distance"]
    assert found["far"] == [ball["name"]]
    assert found["coverage"] >= 0.8 and found["objects"] == 12 and found["failed"] == []
    sizes = {one["name"]: one for one in found["ranges"]}
    width = apg.sample(CHEST, n=12)["width"]
    assert sizes["width"]["ours"][1] == pytest.approx(np.median(width), abs=1e-6)
    assert sizes["width/height"]["real"][0] > 0.5
    words = {one["word"]: one for one in found["words"]}
    assert set(words) == {"body", "door", "handle"}
    assert all(one["present"] == [1.0, 1.0] for one in words.values())
    assert words["body"]["share"][0] == pytest.approx(words["body"]["share"][1], abs=0.08)


def test_without_a_scale_there_are_ratios_alone(folder: Path, capsys: pytest.CaptureFixture[str]) -> None:
    found = compare(capsys, folder / "chest0.npz", "-n", 6, "--front=x", "--normalised")
    assert [one["name"] for one in found["ranges"]] == ["width/height", "depth/height"]
    assert found["between"] is None and found["far"] == [] and found["words"] == []


def test_the_front_is_found(folder: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    points = np.load(folder / "chest1.npz")["points"]
    np.savez(tmp_path / "turned.npz", points=points @ np.array([[0.0, -1, 0], [1, 0, 0], [0, 0, 1]]))
    found = compare(capsys, tmp_path, "-n", 6)
    assert found["real"][0]["front"] == "-y" and found["real"][0]["nearest"] == 1


def test_bad_files_are_listed_and_none_is_an_error(
    folder: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    (tmp_path / "broken.npz").write_bytes(b"nothing")
    found = compare(capsys, folder / "chest0.npz", tmp_path / "broken.npz", "-n", 4, "--front=x")
    assert len(found["real"]) == 1 and "cannot be read as npz" in found["failed"][0]["reason"]
    assert main(["compare", CHEST, str(tmp_path / "broken.npz"), "-n", "4"]) == 1
    assert "none of the real objects could be read" in capsys.readouterr().err
    assert main(["compare", CHEST, str(folder / "chest0.npz"), "-n", "4", "--front=x"]) == 0
    assert "real objects that samples come least near to" in capsys.readouterr().out
