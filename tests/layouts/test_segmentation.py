"""Part segmentation: files read back without our own reader, faults that it finds, and what is refused."""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np
import pytest

from artipg_dsl import sample
from artipg_dsl.errors import UserError
from artipg_dsl.export.write import ExportError
from artipg_dsl.layouts.clouds import draw
from artipg_dsl.layouts.partnet.parts import Levels, object_parts
from artipg_dsl.layouts.registry import LAYOUTS
from artipg_dsl.layouts.words import vocabulary

from .conftest import Lay, faults, unlike

h5py = pytest.importorskip("h5py", reason="h5py, of the extra hdf5, is not installed")


@pytest.fixture(scope="module")
def text(lay: Lay) -> Path:
    return lay("shapenetpart", "Chair", "Laptop", n=4, shares=(2, 1, 1))


@pytest.fixture(scope="module")
def partnet(lay: Lay) -> Path:
    return lay("partnet-seg", "StorageFurniture", "Kettle", n=4, shares=(2, 1, 1))


def rows(folder: Path, name: str) -> np.ndarray:
    return np.loadtxt(folder / f"{name}.txt")


def test_parts_of_chairs_lie_where_a_chair_has_them(text: Path) -> None:
    listed = json.loads((text / "train_test_split/shuffled_train_file_list.json").read_text())
    assert len(listed) == len(set(listed)) == 4
    chairs = [rows(text, name.removeprefix("shape_data/")) for name in listed if "03001627" in name]
    for chair in chairs:
        assert chair.shape == (2500, 7) and set(chair[:, 6]) <= {12.0, 13.0, 14.0, 15.0}
        back, seat, leg = (chair[chair[:, 6] == k] for k in (12, 13, 14))
        assert seat[:, 1].mean() > leg[:, 1].mean(), "y is up: the seat above the legs"
        if len(back):
            assert back[:, 1].mean() > seat[:, 1].mean(), "and the back above the seat"
            assert back[:, 2].mean() > seat[:, 2].mean(), "the front is -z: a back is behind its seat"
        assert np.abs(np.linalg.norm(chair[:, 3:6], axis=1) - 1).max() < 1e-5
        assert np.linalg.norm(np.ptp(chair[:, :3], axis=0)) == pytest.approx(1, abs=1e-5)
    assert any((chair[:, 6] == 12).any() for chair in chairs)


def test_every_class_has_its_folder_and_every_object_its_list(text: Path) -> None:
    table = [line.split("\t") for line in (text / "synsetoffset2category.txt").read_text().splitlines()]
    assert [name for name, _ in table] == sorted(name for name, _ in table) and len(table) == 16
    assert all((text / synset).is_dir() for _, synset in table)
    counts = [
        len(json.loads((text / f"train_test_split/shuffled_{split}_file_list.json").read_text()))
        for split in ("train", "val", "test")
    ]
    assert counts == [4, 2, 2]
    assert not faults(text)


def test_numbers_of_parts_are_those_of_all_loaders() -> None:
    classes = vocabulary("shapenetpart").classes
    ends = [(data["first"], data["first"] + len(data["parts"])) for data in classes.values()]
    assert ends[0][0] == 0 and ends[-1][1] == 50
    assert all(end == first for (_, end), (first, _) in zip(ends, ends[1:], strict=False))


def test_the_text_and_hdf5_say_the_same(text: Path, lay: Lay) -> None:
    folder = lay("shapenetpart-h5", "Chair", n=4, shares=(4, 0, 0))
    assert not faults(folder)
    listed = (folder / "hdf5_data/train_hdf5_file_list.txt").read_text().split()
    with h5py.File(folder / "hdf5_data" / listed[0]) as file:
        assert file["data"].shape == (4, 2048, 3) and file["data"].dtype == np.float32
        assert set(np.unique(file["label"])) == {4} and set(np.unique(file["pid"])) <= {12, 13, 14, 15}
        back = [(file["pid"][k] == 12).mean() for k in range(4)]
    ours = [(rows(text, f"03001627/Chair7n{k:06d}")[:, 6] == 12).mean() for k in range(4)]
    assert back == pytest.approx(ours, abs=0.06)


def test_files_hold_objects_of_all_classes(lay: Lay, monkeypatch: pytest.MonkeyPatch) -> None:
    """As those of the data set do: PointNet's training takes whole batches of each file, and divides by their number."""
    monkeypatch.setattr("artipg_dsl.layouts.shapenetpart._H5_MOST", 5)
    folder = lay("shapenetpart-h5", "Laptop", "Knife", n=8, shares=(7, 1, 0))
    place = folder / "hdf5_data"
    listed = [place / name for name in (place / "train_hdf5_file_list.txt").read_text().split()]
    assert listed == sorted(place.glob("*train*.h5")) and len(listed) == 3
    names: list[str] = []
    for path in listed:
        with h5py.File(path) as file:
            assert 4 <= len(file["data"]) <= 5 and file["label"].shape == (len(file["data"]), 1)
            assert set(file["label"][:, 0].tolist()) == {7, 9}
            for name, label, part in zip(file["name"].asstr()[()], file["label"][:, 0], file["pid"], strict=True):
                assert name.startswith("Knife" if label == 7 else "Laptop")
                assert set(np.unique(part)) <= ({22, 23} if label == 7 else {28, 29})
                names.append(name)
    assert sorted(names) == [f"{name}7n{k:06d}" for name in ("Knife", "Laptop") for k in range(7)]
    assert not list(place.glob("*test*.h5")) and not faults(folder)
    lay("shapenetpart-h5", "Laptop", n=1, shares=(1, 0, 0), folder=folder, force=True)
    assert len(list(place.glob("*train*.h5"))) == 2, (
        "what is no longer listed goes: some loaders read all that there is"
    )
    assert not faults(folder)


def test_colours_and_numbers_of_parts_are_there_for_pointnet(lay: Lay) -> None:
    """Its scripts open these files before they do anything."""
    place = lay("shapenetpart-h5", "Mug", n=1, shares=(1, 0, 0)) / "hdf5_data"
    every = json.loads((place / "overallid_to_catid_partid.json").read_text())
    number = json.loads((place / "catid_partid_to_overallid.json").read_text())
    colours = json.loads((place / "part_color_mapping.json").read_text())
    assert len(every) == len(colours) == 50 and len({tuple(colour) for colour in colours}) == 50
    assert all(len(colour) == 3 and 0 <= min(colour) and max(colour) <= 1 for colour in colours)
    assert [number[f"{synset}_{part}"] for synset, part in every] == list(range(50)) and number["03797390_2"] == 37


def test_what_is_missing_of_another_category_is_told(lay: Lay) -> None:
    """And ``force`` makes it anew, even where its own files cannot be read."""
    folder = lay("shapenetpart-h5", "Laptop", "Mug", n=2, shares=(2, 0, 0))
    (folder / "objects/Mug-0.h5").write_text("none")
    with pytest.raises(ExportError, match="is damaged: objects/Mug-0.h5 is no HDF5 file") as wrong:
        lay("shapenetpart-h5", "Knife", n=1, shares=(1, 0, 0), folder=folder)
    assert "write its category again with --force" in (wrong.value.hint or "")
    (folder / "objects/Mug-0.h5").unlink()
    with pytest.raises(ExportError, match="is damaged: objects/Mug-0.h5 is missing"):
        lay("shapenetpart-h5", "Laptop", n=2, folder=folder, force=True)
    lay("shapenetpart-h5", "Mug", n=2, shares=(2, 0, 0), folder=folder, force=True)
    lay("shapenetpart-h5", "Laptop", n=2, shares=(2, 0, 0), folder=folder, force=True)
    assert not faults(folder)
    stray = folder / "hdf5_data/ply_data_train7.h5"
    stray.write_bytes((folder / "hdf5_data/ply_data_train0.h5").read_bytes())
    assert unlike(folder) == ["hdf5_data/ply_data_train7.h5: in no list, and some loaders read it all the same"]
    stray.rename(folder / "hdf5_data/ply_data_train0.h5").write_bytes(stray.name.encode())
    assert any("ply_data_train0.h5 is no HDF5 file, or not a whole one" in fault for fault in unlike(folder))


def test_shapes_of_partnet_are_together(lay: Lay, monkeypatch: pytest.MonkeyPatch) -> None:
    """Its instance segmentation takes whole batches of each file, whatever is listed; rows of all files are the same shapes."""
    monkeypatch.setattr("artipg_dsl.layouts.partnet.files.MOST", 5)
    folder = lay("partnet-seg", "Mug", n=8, shares=(7, 1, 0))
    assert not faults(folder)
    listed = (folder / "ins_seg_h5/Mug/train_files.txt").read_text().split()
    assert listed == ["train-00.h5", "train-01.h5"]
    assert listed == sorted(path.name for path in (folder / "ins_seg_h5/Mug").glob("train-*.h5"))
    names = []
    for file in listed:
        told = json.loads((folder / "ins_seg_h5/Mug" / file).with_suffix(".json").read_text())
        with h5py.File(folder / "ins_seg_h5/Mug" / file) as own, h5py.File(folder / "sem_seg_h5/Mug-1" / file) as sem:
            assert len(own["pts"]) == len(sem["data"]) == len(told) in (3, 4)
            assert (own["pts"][-1] == sem["data"][-1]).all() and (sem["data_num"][()] == 10000).all()
        names += [shape["anno_id"] for shape in told]
    assert sorted(names) == [f"Mug7n{k:06d}" for k in range(7)]
    path = folder / "ins_seg_h5/Mug/train-01.json"
    path.write_text(json.dumps(json.loads(path.read_text())[::-1]))
    assert any("pts differ" in fault for fault in unlike(folder))


def test_a_folder_that_was_spoilt_is_found_out(lay: Lay) -> None:
    folder = lay("shapenetpart", "Laptop", n=2)
    path = folder / "03642806/Laptop7n000001.txt"
    table = np.loadtxt(path)
    spoilt = {
        "numbers of parts of another class": table.copy(),
        "points differ": table.copy(),
        "not (2500, 7)": table[1:],
    }
    spoilt["numbers of parts of another class"][0, 6] = 3
    spoilt["points differ"][:, 1] *= -1  # upside down
    for fault, rows_ in spoilt.items():
        np.savetxt(path, rows_, fmt="%.6f")
        assert any("Laptop7n000001" in found and fault in found for found in unlike(folder)), fault
    path.unlink()
    assert any("cannot be read: 03642806/Laptop7n000001.txt" in found for found in unlike(folder))


def test_partnet_classes_are_those_of_its_levels(partnet: Path) -> None:
    assert not faults(partnet)
    storage = sample("StorageFurniture", n=2, seed=7, checked=False)
    for level, count in (("1", 6), ("2", 18), ("3", 23)):
        place = partnet / f"sem_seg_h5/StorageFurniture-{level}"
        with h5py.File(place / (place / "train_files.txt").read_text().split()[0]) as file:
            data, label, number = file["data"][()], file["label_seg"][()], file["data_num"][()]
        assert data.shape == (2, 10000, 3) and data.dtype == np.float32 and label.dtype == np.uint8
        assert number.tolist() == [10000, 10000] and label.max() <= count
        assert np.linalg.norm(data, axis=-1).max(axis=-1) == pytest.approx([1, 1], abs=1e-5)
        names = (partnet / f"stats/after_merging_label_ids/StorageFurniture-level-{level}.txt").read_text().splitlines()
        assert len(names) == count
    words = storage.batch.program.vocabularies["semantic"]
    ours = [words[k] for k in storage.points(10000).semantic[0]]
    level1 = [
        name.split()[1].rpartition("/")[2]
        for name in open(partnet / "stats/after_merging_label_ids/StorageFurniture-level-1.txt")
    ]
    with h5py.File(partnet / "sem_seg_h5/StorageFurniture-1/train-00.h5") as file:
        theirs = [level1[k - 1] for k in file["label_seg"][0]]
    for our, their in (("body", "cabinet_frame"), ("shelf", "shelf"), ("drawer", "drawer"), ("door", "cabinet_door")):
        assert {t for o, t in zip(ours, theirs, strict=True) if o == our} <= {their}


def test_instances_are_leaves_of_a_tree(partnet: Path) -> None:
    told = json.loads((partnet / "ins_seg_h5/StorageFurniture/train-00.json").read_text())
    with h5py.File(partnet / "ins_seg_h5/StorageFurniture/train-00.h5") as file:
        label, points = file["label"][()], file["pts"][()]
        assert file["rgb"].dtype == np.uint8 and file["nor"].shape == file["pts"].shape
    storage = sample("StorageFurniture", n=2, seed=7, checked=False)
    for i, shape in enumerate(told):
        parts = shape["ins_seg"]
        drawers = [part for part in parts if part["part_name"] == "storage_furniture/cabinet/drawer"]
        joints = storage.joints()
        slides = sum(kind == "prismatic" for kind, owner in zip(joints.kind, joints.owner, strict=True) if owner == i)
        assert len(drawers) == slides
        bottom = next(part for part in parts if part["part_name"].endswith("cabinet_frame/bottom_panel"))
        top = next(part for part in parts if part["part_name"].endswith("cabinet_frame/top_panel"))
        low, high = (points[i][np.isin(label[i], part["leaf_id_list"]), 1].mean() for part in (bottom, top))
        assert low < high


def test_bars_of_a_back_are_leaves_of_their_own() -> None:
    """The crest and the lower rail, too, which are different primitives of one part."""
    batch = sample("Chair", n=40, seed=1, checked=False).batch
    points, bar = draw(batch, 10000), "chair_back/back_surface/back_surface_horizontal_bar"
    several = 0
    for i, own in enumerate(object_parts(batch, points, Levels.of(batch.program))):
        on = np.isin(own.leaf, [k for k, path in enumerate(own.paths) if path == bar])
        bars = np.stack([points.primitive[i][on], points.element[i][on], own.leaf[on]])
        assert len(np.unique(bars[:2], axis=1).T) == len(np.unique(bars[2])) == len(np.unique(bars, axis=1).T)
        several += len(np.unique(bars[0])) > 1
    assert several


def test_a_category_that_partnet_lacks_has_a_level_of_its_own_words(partnet: Path) -> None:
    names = (partnet / "stats/after_merging_label_ids/Kettle-level-1.txt").read_text().splitlines()
    assert names[0] == "1 kettle/body leaf" and len(names) == len(set(names)) > 3
    with h5py.File(partnet / "sem_seg_h5/Kettle-1/train-00.h5") as file:
        assert file["label_seg"][()].min() >= 1


def test_a_closed_vocabulary_refuses_and_says_what_would_serve() -> None:
    with pytest.raises(UserError, match="no class for Kettle") as refused:
        LAYOUTS["shapenetpart"].term("Kettle")
    hint = refused.value.hint or ""
    assert (
        "Chair, Knife, Lamp, Laptop, Mug, Table have one" in hint
        and "nearest is Mug" in hint
        and "partnet-seg takes any" in hint
    )
    with pytest.raises(UserError, match="no class for Globe") as refused:
        LAYOUTS["shapenetpart"].term("Globe")
    assert "nearest" not in (refused.value.hint or "") and '"class": "..."' in (refused.value.hint or "")
    own = {"Kettle": {"class": "Mug", "parts": {"handle": "handle", "*": "cup"}}}
    term = LAYOUTS["shapenetpart"].term("Kettle", own)
    assert term is not None and term.data["synset"] == "03797390"
    with pytest.raises(UserError, match="no class `Mugg`"):
        LAYOUTS["shapenetpart"].term("Kettle", {"Kettle": {"class": "Mugg"}})
    with pytest.raises(UserError, match="no part `saucer`: its parts are handle, cup"):
        LAYOUTS["shapenetpart"].term("Kettle", {"Kettle": {"class": "Mug", "parts": {"*": "saucer"}}})
    with pytest.raises(UserError, match="takes any category"):
        LAYOUTS["partnet-seg"].term("Kettle", own)


POST = """
apg 1
use primitives { Cuboid }
use vocabularies { semantic }

vocabulary drawn { base }

category Post {
  root part post : Cuboid(size = [10cm, 10cm, 1m])
  label semantic.leg on post
  label drawn.base on post where p.z < -0.1 * size.z
}
"""


def test_a_formula_of_the_program_divides_a_part(tmp_path: Path, lay: Lay) -> None:
    """Annotators may end a part where no part of ours ends: 40 % of the height belong to the base."""
    (tmp_path / "post.apg").write_text(POST)
    own = {"Post": {"class": "Lamp", "parts": {"drawn.base": "base", "leg": "stem"}}}
    folder = lay("shapenetpart", str(tmp_path / "post.apg"), n=2, own=own)
    assert not faults(folder)
    read = rows(folder, "03636649/Post7n000000")
    first, height = LAYOUTS["shapenetpart"].term("Post", own).data["first"], read[:, 1]  # type: ignore[union-attr]
    share = (height - height.min()) / np.ptp(height)
    assert set(read[:, 6]) == {first + 0, first + 3}
    assert np.array_equal(read[:, 6] == first, share < 0.4)


@pytest.mark.parametrize(
    ("parts", "wrong", "hint"),
    [
        ({"handel": "handle", "*": "cup"}, "`handel`, which is no word of Kettle", "did you mean `handle`"),
        ({"body/handel": "handle", "*": "cup"}, "`handel`, which is no word", "did you mean `handle`"),
        (
            {"handle/revolute": "handle", "*": "cup"},
            "`revolute`, which is no word",
            "its words are",
        ),  # points do not move
        ({"*/handle": "handle", "*": "cup"}, r"`\*`, which is no word", "its words are"),
        (
            {"affordance.grap": "handle", "*": "cup"},
            "`affordance.grap`, which is no word",
            "did you mean `affordance.grasp`",
        ),
        ({"semantic.handle": "handle", "*": "cup"}, "`semantic.handle`, which is no word", "`handle` alone"),
    ],
)
def test_a_mistyped_word_of_a_map_is_refused(lay: Lay, parts: dict[str, str], wrong: str, hint: str) -> None:
    with pytest.raises(UserError, match=wrong) as refused:
        lay("shapenetpart", "Kettle", n=1, own={"Kettle": {"class": "Mug", "parts": parts}})
    assert hint in (refused.value.hint or "")


def test_a_map_that_would_change_nothing_is_refused(lay: Lay) -> None:
    with pytest.raises(UserError, match="says nothing of Chair, it maps Chiar") as refused:
        lay("shapenetpart", "Chair", n=1, own={"Chiar": {"class": "Chair", "parts": {"*": "leg"}}})
    assert refused.value.hint == "did you mean `Chiar`?"
    with pytest.raises(
        UserError, match="says nothing of Kettle, it maps Mug"
    ):  # not that it has no class: a map is there
        lay("shapenetpart", "Kettle", n=1, own={"Mug": {"class": "Mug", "parts": {"*": "cup"}}})
    with pytest.raises(UserError, match="pcn has no parts"):
        lay("pcn", "Kettle", n=1, own={"Kettle": {"class": "mug", "parts": {"*": "cup"}}})
    with pytest.raises(UserError, match="takes whole parts, which `affordance.grasp` may divide"):
        lay("cage", "Kettle", n=1, own={"Kettle": {"class": "Table", "parts": {"affordance.grasp": "handle"}}})
    with pytest.raises(UserError, match="`revolut`, which is no word of Kettle") as refused:
        lay("cage", "Kettle", n=1, own={"Kettle": {"class": "Table", "parts": {"lid/revolut": "door"}}})
    assert refused.value.hint == "did you mean `revolute`?"


def test_a_word_without_a_part_is_refused(lay: Lay) -> None:
    own = {"Kettle": {"class": "Mug", "parts": {"body": "cup"}}}
    with pytest.raises(UserError, match="not told what .* of Kettle is"):
        lay("shapenetpart", "Kettle", n=1, own=own)


def test_one_folder_one_layout_and_a_category_once(lay: Lay) -> None:
    folder = lay("shapenetpart", "Laptop", n=3)
    with pytest.raises(ExportError, match="laid out as shapenetpart"):
        lay("partnet-seg", "Laptop", folder=folder)
    with pytest.raises(ExportError, match="already has Laptop"):
        lay("shapenetpart", "Laptop", folder=folder)
    lay("shapenetpart", "Laptop", n=1, folder=folder, force=True)
    assert [path.name for path in (folder / "03642806").iterdir()] == ["Laptop7n000000.txt"]
    assert not faults(folder)


KINDS = {
    "Lamp": {
        "table_or_floor_lamp": {"desk", "table", "floor"},
        "wall_lamp": {"spot", "yoke", "sconce"},
        "ceiling_lamp": {"pendant"},
    },
    "Clock": {
        "pendulum_clock": {"regulator", "cuckoo", "tall"},
        "table_clock": {"round", "square", "desk", "mantel", "alarm"},
    },
}


@pytest.mark.some
@pytest.mark.parametrize("name", sorted(KINDS))
def test_which_tree_an_object_has_is_told_by_what_was_chosen(lay: Lay, name: str) -> None:
    """And its points are of classes of that tree: PartNet numbers those of all trees of a category in one list."""
    folder = lay("partnet-seg", name, n=24, shares=(24, 0, 0))
    assert not faults(folder)
    kinds = sample(name, n=24, seed=7, checked=False)["kind"].tolist()
    want = [next(tree for tree, own in KINDS[name].items() if kind in own) for kind in kinds]
    for level in vocabulary("partnet").classes[name]["levels"]:
        rows_ = (folder / f"stats/after_merging_label_ids/{name}-level-{level}.txt").read_text().splitlines()
        trees = np.array(["", *(row.split()[1].split("/")[1] for row in rows_)])
        with h5py.File(folder / f"sem_seg_h5/{name}-{level}/train-00.h5") as file:
            label = file["label_seg"][()]
        assert [set(trees[own]) - {""} for own in label] == [{tree} for tree in want]
        assert (label > 0).mean() > 0.75
    assert set(want) == set(KINDS[name])
