"""Folders give the items that were written, by the names of a stream."""

import pickle
import shutil
from pathlib import Path

import numpy as np
import pytest

import artipg_dsl as apg
from artipg_dsl.errors import UserError
from artipg_dsl.loaders import Jitter, Stored, Stream


def test_items_are_objects_in_their_states(folders: list[Path]) -> None:
    stored = Stored(folders, "pose")
    assert len(stored) == 5 * 2 + 3 and stored.categories == ["Chest", "Box"]
    batch, file = stored.take([0, 1, 9, 10]), np.load(folders[0] / "points-00000.npz")
    assert batch["object"].tolist() == [0, 0, 4, 0] and batch["category"].tolist() == [0, 0, 0, 1]
    np.testing.assert_array_equal(
        batch["points"][:3], [file["points"][0, 0], file["points"][0, 1], file["points"][4, 1]]
    )
    np.testing.assert_array_equal(batch["npcs"][1], file["npcs"][0])
    np.testing.assert_array_equal(batch["motion"][2], file["motion"][4, 1])


@pytest.mark.parametrize("task", ["segmentation", "pose", "affordance"])
def test_a_stream_gives_the_same(folders: list[Path], chest: Path, task: str) -> None:
    stream = Stream(chest, task, size=5, batch=5, points=64, seed=3).batch(0)
    stored = Stored(folders[0], task).take(range(0, 10, 2))
    assert list(stream) == list(stored)
    for name, values in stream.items():
        assert stored[name].dtype == values.dtype
        np.testing.assert_array_equal(stored[name], values, err_msg=name)


def test_words_of_several_categories(folders: list[Path]) -> None:
    stored = Stored(folders, "affordance")
    assert stored.words["affordance"] == ["contain", "lift", "push"]
    said = stored.take([0, 10])["affordance"].any(axis=1)
    assert said.tolist() == [[False, False, True], [True, True, False]]


def test_completion_pairs_each_view_with_its_object(folders: list[Path]) -> None:
    stored, file = Stored(folders, "completion"), np.load(folders[0] / "views-00000.npz")
    assert len(stored) == 5 * 2 * 2 + 3 * 2
    batch = stored.take([3, 20])
    np.testing.assert_array_equal(batch["partial"][0], file["cloud_points"][0, 1, 1])
    assert batch["object"].tolist() == [0, 0] and batch["category"].tolist() == [0, 1]


def test_transforms_follow_item_and_epoch(folders: list[Path]) -> None:
    stored = Stored(folders, transforms=[Jitter()])
    np.testing.assert_array_equal(stored.take([2, 4])["points"][1], stored.take([4])["points"][0])
    assert not np.array_equal(stored.take([4], epoch=1)["points"], stored.take([4])["points"])


def test_items_are_whole_numbers_of_some_folder(folders: list[Path]) -> None:
    stored = Stored(folders)
    for items, epoch, told in (([1.5], 0, "an item is 1.5"), ([0], -1, "epoch is -1"), ([0], 2**32, "epoch is 4")):
        with pytest.raises(UserError, match=told):
            stored.take(items, epoch)  # type: ignore[arg-type]
    for wrong in (0, slice(0, 2), np.zeros((1, 1), dtype=int)):
        with pytest.raises(UserError, match="give their numbers"):
            stored.take(wrong)  # type: ignore[arg-type]
    with pytest.raises(UserError, match="no folder to read"):
        Stored([])
    with pytest.raises(UserError, match="folders is None"):
        Stored(None)  # type: ignore[arg-type]
    with pytest.raises(UserError, match="chests is named twice"):
        Stored([folders[0], str(folders[0])])


def test_what_is_missing_is_named(folders: list[Path], chest: Path, tmp_path: Path) -> None:
    with pytest.raises(UserError, match="manifest.json"):
        Stored(tmp_path)
    with pytest.raises(IndexError, match="13 items"):
        Stored(folders).take([13])
    apg.sample(chest, n=1).to(tmp_path / "few", "points", points=32)
    with pytest.raises(UserError, match="--motion"):
        Stored(tmp_path / "few", "pose")
    with pytest.raises(UserError, match="--views"):
        Stored(tmp_path / "few", "completion")
    shard = apg.sample(chest, n=1).to(tmp_path / "cut", "points", points=32) / "points-00000.npz"
    shard.write_bytes(shard.read_bytes()[:300])
    with pytest.raises(UserError, match="points-00000.npz cannot be read"):
        Stored(tmp_path / "cut")
    np.save(shard.open("wb"), np.zeros(3))
    with pytest.raises(UserError, match="points-00000.npz cannot be read: it is no archive of arrays"):
        Stored(tmp_path / "cut")
    apg.sample(chest, n=2).to(tmp_path / "links", "points", points=32, per="link")
    with pytest.raises(UserError, match="points of 4 things for 2 objects"):
        Stored(tmp_path / "links")
    with pytest.raises(UserError, match="32 and 64 points"):
        Stored([folders[0], tmp_path / "few"])


def test_views_of_other_objects_are_told(folders: list[Path], tmp_path: Path) -> None:
    path = shutil.copytree(folders[1], tmp_path / "boxes") / "views-00000.npz"
    views = dict(np.load(path))
    np.savez(path, **{name: array[1:] for name, array in views.items()})  # as a run that was ended has left them
    with pytest.raises(UserError, match="views of 2 of its 3 objects"):
        Stored(tmp_path / "boxes", "completion")
    np.savez(path, **views | {"cloud_points": views["cloud_points"][:, :, :9]})
    with pytest.raises(UserError, match="9 and 2048 points in their views"):
        Stored([folders[0], tmp_path / "boxes"], "completion")


def test_a_copy_reads_the_folders_itself(folders: list[Path]) -> None:
    stored = Stored(folders, "affordance")
    sent = pickle.dumps(stored)
    assert len(sent) < stored.take([0])["points"].nbytes * len(stored)
    copy = pickle.loads(sent).take([3, 11])
    for name, values in stored.take([3, 11]).items():
        np.testing.assert_array_equal(copy[name], values)
