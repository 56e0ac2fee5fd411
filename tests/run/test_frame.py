"""``--frame``: the same objects, labels and joints, turned; recorded, made again, and what is refused."""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np
import pytest

import artipg_dsl as apg
from artipg_dsl.errors import UserError
from artipg_dsl.run.frame import list_frames, read_frame
from artipg_dsl.run.laying import check_layout
from artipg_dsl.session import categories

CATEGORIES = ("Scissors", "Globe", "Foldingrack", "Faucet", "StorageFurniture", "Chair")
QUARTER = np.array([[0.0, -1.0, 0.0], [1.0, 0.0, 0.0], [0.0, 0.0, 1.0]])  # from x towards y


def frame(folder: Path, **turns: int) -> Path:
    path = folder / "own.json"
    path.write_text(json.dumps({"about": "by hand", "turns": turns}), encoding="utf-8")
    return path


@pytest.mark.parametrize(
    ("name", "degrees", "turn"),
    [("Scissors", 180, QUARTER @ QUARTER), ("Scissors", -90, QUARTER.T), *((name, 90, QUARTER) for name in CATEGORIES)],
)
@pytest.mark.some
def test_everything_is_turned_and_nothing_else_changes(
    name: str, degrees: int, turn: np.ndarray, tmp_path: Path
) -> None:
    plain = apg.sample(name, 4, seed=3)
    turned = apg.sample(name, 4, seed=3, frame=frame(tmp_path, **{name: degrees}))
    a, b = plain.points(512), turned.points(512)
    assert np.allclose(a.position @ turn.T, b.position, atol=1e-12)
    assert np.allclose(a.normal @ turn.T, b.normal, atol=1e-12)
    assert np.allclose(a.npcs, b.npcs, atol=1e-9)
    for same in ("semantic", "instance", "link", "patch", "object"):
        assert np.array_equal(getattr(a, same), getattr(b, same)), same
    for key, said in a.labels.items():
        assert np.array_equal(said, b.labels[key], equal_nan=said.dtype.kind == "f"), key
    mine, theirs = plain.joints(), turned.joints()
    assert np.array_equal(mine.axis @ turn.T, theirs.axis) and np.allclose(
        mine.origin @ turn.T, theirs.origin, atol=1e-15
    )
    assert np.array_equal(mine.low, theirs.low, equal_nan=True)
    assert np.array_equal(mine.high, theirs.high, equal_nan=True)
    for one, other in zip(plain.annotations(), turned.annotations(), strict=True):
        for point, other_point in zip(one["keypoints"], other["keypoints"], strict=True):
            assert np.allclose(turn @ point["point"], other_point["point"], atol=1e-6)


def test_a_folder_keeps_its_frame(tmp_path: Path) -> None:
    apg.sample("Scissors", 3, frame="partnet").to(tmp_path / "o", points=64)
    told = json.loads((tmp_path / "o" / "manifest.json").read_text())
    assert told["identity"]["made"]["turned"] == -90 and "turned by -90 degrees" in told["frame"]
    again = apg.open_samples(tmp_path / "o")
    blades = again.points(256)
    assert np.array_equal(blades.position, apg.sample("Scissors", 3, frame="partnet").points(256).position)
    across, along = np.ptp(again.mutate("cpa").points(256).position[..., :2].reshape(-1, 2), axis=0)
    assert along > across, "mutants lie as their originals"


def test_shipped_frames_name_shipped_categories() -> None:
    assert list_frames() == ["partnet"]
    assert set(read_frame("partnet").turns) <= set(categories())
    assert read_frame("partnet").of("Chair") == read_frame("own").of("Scissors") == 0


@pytest.mark.parametrize(
    ("text", "said", "hint"),
    [
        ('{"turns": {"Globe": 45}}', "turns.Globe: 45 where 0, 90, -90 or 180 degrees is expected", '{"turns"'),
        ('{"turns": {"Glob": 90}}', "says nothing of Globe: it speaks of Glob", "did you mean `Glob`"),
        ('{"turns": {"Safe": 90}}', "says nothing of Globe: it speaks of Safe", 'write "Globe": 0'),
        ('{"turn": {}}', "turn", '{"turns"'),
        ("{", "own.json:1:2: it is not JSON", '{"turns"'),
    ],
)
def test_what_a_file_may_not_say(text: str, said: str, hint: str, tmp_path: Path) -> None:
    path = tmp_path / "own.json"
    path.write_text(text, encoding="utf-8")
    with pytest.raises(UserError) as wrong:
        apg.sample("Globe", 1, frame=path)
    assert said in wrong.value.message and hint in (wrong.value.hint or "")


def test_a_name_that_is_none() -> None:
    with pytest.raises(UserError, match="there is no frame partent") as wrong:
        apg.sample("Globe", 1, frame="partent")
    assert "did you mean `partnet`" in (wrong.value.hint or "")


@pytest.fixture
def blades(tmp_path: Path) -> tuple[np.ndarray, np.ndarray]:
    """Where the blades of scissors lie in PartNet's axes (left, up, front), as the layout has it by itself, and in our frame."""
    h5py = pytest.importorskip("h5py", reason="h5py, of the extra hdf5, is not installed")
    found = []
    for name, frame in (("theirs", None), ("ours", "own")):
        out = apg.sample("Scissors", 2).lay_out(tmp_path / name, "partnet-seg", split="1,0,0", frame=frame)
        assert not check_layout(out).faults
        with h5py.File(next(out.glob("sem_seg_h5/Scissors-1/train*.h5"))) as held:
            classes = (out / "stats/after_merging_label_ids/Scissors-level-1.txt").read_text().splitlines()
            blade = next(k for k, line in enumerate(classes, 1) if "blade" in line)
            found.append(held["data"][0][held["label_seg"][0] == blade].mean(axis=0))
    return found[0], found[1]


def test_a_layout_lies_as_its_data_set(blades: tuple[np.ndarray, np.ndarray]) -> None:
    theirs, ours = blades
    assert np.argmax(np.abs(theirs)) == 0 and theirs[0] < 0, "blades to -x"
    assert np.argmax(np.abs(ours)) == 2 and ours[2] > 0, "blades to the front"
