"""``apgc export --format LAYOUT`` and ``apgc layout``."""

from __future__ import annotations

import json
import subprocess
import sys
from collections.abc import Iterator
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from artipg_dsl import sample
from artipg_dsl.errors import UsageError, UserError
from artipg_dsl.layouts.entry import Entry
from artipg_dsl.layouts.registry import LAYOUTS
from artipg_dsl.run import laying
from artipg_dsl.run.checksums import keep_names

from .helpers import Apgc, tree


def test_laid_out_and_checked(apgc: Apgc, tmp_path: Path) -> None:
    out = tmp_path / "parts"
    code, _, said = apgc("export", "Laptop", "-n", 4, "--format", "shapenetpart", "--split", "2,1,1", "-o", out)
    assert code == 0 and "4 objects of Laptop as shapenetpart" in said and "2 train, 1 val, 1 test" in said
    assert apgc("layout", out)[0] == 0
    path = out / "03642806/Laptop0n000002.txt"
    path.write_text(path.read_text().replace("28.000000", "29.000000", 1))
    code, shown, said = apgc("layout", out)
    assert code == 1 and "2 faults" in said
    assert shown.splitlines()[0] == "03642806/Laptop0n000002.txt: is not as it was written"


def test_what_loaders_stumble_over_is_told(apgc: Apgc, tmp_path: Path) -> None:
    out = tmp_path / "parts"
    code, _, said = apgc("export", "Laptop", "-n", 2, "--format", "shapenetpart", "-o", out)
    assert code == 0 and "no object is in val or test" in said
    said = apgc("export", "Laptop", "-n", 2, "--format", "shapenetpart", "-o", out, "--split", "1,0,1", "--force")[2]
    assert "no object is in" not in said and "misread" not in said
    assert laying.find_cautions(Path("../all.complete/x"), LAYOUTS["shapenetpart"]) == []
    assert "rename all.complete before" in laying.find_cautions(Path("../all.complete/x"), LAYOUTS["pcn"])[0]
    assert "with `.` in it: rename all.v2" in laying.find_cautions(Path("../all.v2/x"), LAYOUTS["ancsh"])[0]


def test_folders_of_something_else_are_left_alone(apgc: Apgc, tmp_path: Path) -> None:
    samples, parts = tmp_path / "samples", tmp_path / "parts"
    assert apgc("sample", "Laptop", "-n", 1, "--format", "annotation", "-o", samples)[0] == 0
    lay = ("export", "Laptop", "-n", 1, "--format", "shapenetpart", "-o")
    assert apgc(*lay, parts)[0] == 0
    before = tree(tmp_path)
    for force in ((), ("--force",)):
        code, _, said = apgc(*lay, samples, *force)
        assert code == 1 and f"{samples} holds samples" in said and "a layout is a folder of its own" in said
        code, _, said = apgc("sample", "Laptop", "-n", 1, "-o", parts, *force)
        assert code == 1 and f"{parts} holds a layout" in said and "samples go into a folder of their own" in said
    assert tree(tmp_path) == before


@pytest.mark.parametrize(
    ("files", "taken", "told"),
    [
        (["Box/Box0n000003/train.json", "Box/Box0n000003/plys/node-0.ply"], [3], ["no object is in val or test"]),
        ([], [], ["no object is in train or val or test"]),  # a table on which nothing moves has no file
        (["objects/Box-0.h5"], list(range(10)), []),  # files of many objects name none
    ],
)
def test_objects_that_a_layout_leaves_out_do_not_count(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, files: list[str], taken: list[int], told: list[str]
) -> None:
    entry = Entry("Box", 0, np.arange(10))
    (tmp_path / ".layout").mkdir()
    keep_names(tmp_path / ".layout/Box.files", dict.fromkeys([".layout/Box.json", *files], ""))
    monkeypatch.setattr(laying, "entries", lambda _: [entry])
    assert laying.find_taken(tmp_path, LAYOUTS["cage"], entry).tolist() == taken
    assert [words.partition(",")[0] for words in laying.find_cautions(tmp_path, LAYOUTS["cage"])] == told


def test_a_folder_without_unseen_categories_is_told(monkeypatch: pytest.MonkeyPatch) -> None:
    """GAPartNet's training fails at an empty test_inter."""
    seen, unseen = (Entry(name, 0, np.arange(10), shares) for name, shares in (("Box", (8, 1, 1)), ("Door", (0, 0, 1))))
    for known, told in (([seen], 1), ([seen, unseen], 0)):
        monkeypatch.setattr(laying, "entries", lambda _, known=known: known)
        cautions = laying.find_cautions(Path("data"), LAYOUTS["gapartnet"])
        assert sum("no category is in test_inter" in words for words in cautions) == told == len(cautions)


@pytest.mark.parametrize(
    ("name", "layout", "told", "enough"),
    [
        ("Mug", "shapenet55", "test has fewer than 10 objects, and PoinTr's training divides", 10),
        ("Laptop", "ancsh", "test has fewer than 2 objects, and the training divides", 2),
    ],
)
def test_too_few_for_the_training_is_told(
    apgc: Apgc, tmp_path: Path, name: str, layout: str, told: str, enough: int
) -> None:
    """A division by zero otherwise, hours later."""
    if layout == "ancsh":
        pytest.importorskip("h5py", reason="h5py, of the extra hdf5, is not installed")
    made = ("export", name, "--format", layout, "-o", tmp_path / "out", "--split", "0,0,1", "--force", "-n")
    assert told in apgc(*made, enough - 1)[2]
    assert told not in apgc(*made, enough)[2]


@pytest.mark.slow
def test_workers_write_the_same(apgc: Apgc, tmp_path: Path) -> None:
    for name, more in (("one", ()), ("two", ("--workers", 2))):
        assert apgc("export", "Laptop", "-n", 70, "--format", "shapenetpart", "-o", tmp_path / name, *more)[0] == 0
    assert tree(tmp_path / "one") == tree(tmp_path / "two")


def test_samples_are_laid_out_as_they_are(apgc: Apgc, tmp_path: Path) -> None:
    apgc("sample", "Laptop", "-n", 3, "--seed", 5, "-o", tmp_path / "data")
    assert apgc("export", tmp_path / "data", "--format", "shapenetpart", "-o", tmp_path / "parts")[0] == 0
    assert (tmp_path / "parts/03642806/Laptop5n000002.txt").exists()
    assert apgc("layout", tmp_path / "parts")[0] == 0
    code, _, said = apgc("export", tmp_path / "data", "--format", "shapenetpart")
    assert code == 2 and "is a folder of its own" in said


def test_python_writes_the_same(apgc: Apgc, tmp_path: Path) -> None:
    apgc("export", "Laptop", "-n", 3, "--format", "shapenetpart", "--split", "1,1,1", "-o", tmp_path / "typed")
    sample("Laptop", n=3).lay_out(tmp_path / "called", "shapenetpart", split="1,1,1")
    assert tree(tmp_path / "called") == tree(tmp_path / "typed")
    with pytest.raises(UsageError, match="no layout 'shapenetparts'"):
        sample("Laptop").lay_out(tmp_path / "none", "shapenetparts")


@pytest.mark.parametrize(
    ("arguments", "wrong"),
    [
        (("Kettle", "--format", "shapenetpart"), "ShapeNetPart has no class for Kettle"),
        (("Laptop", "--format", "shapenetprt"), "unknown format 'shapenetprt'"),
        (("Laptop", "--format", "shapenetpart,urdf"), "shapenetpart is a layout of its own folder"),
        (("Laptop", "--format", "shapenetpart", "--split", "8,1"), "'8,1' is not a split"),
        (("Laptop", "--format", "shapenetpart", "--split", "0,0,0"), "'0,0,0' is not a split"),
        (("Laptop", "--format", "urdf", "--split", "8,1,1"), "--split is for layouts"),
        (("Laptop", "--format", "shapenetpart", "--tolerance", "1mm"), "shapenetpart has no meshes to choose for"),
        (("Laptop", "--format", "shapenetpart", "--cluster", "local"), "shapenetpart is laid out on this machine"),
        (("Laptop", "--format", "shapenetpart", "--memory", "1GB"), "shapenetpart is laid out on this machine"),
        (("Laptop", "--format", "shapenetpart", "--map", "none.json"), "there is no file none.json"),
    ],
)
def test_what_is_refused(apgc: Apgc, tmp_path: Path, arguments: tuple[str, ...], wrong: str) -> None:
    code, _, said = apgc("export", *arguments, "-o", tmp_path / "out")
    assert code in (1, 2) and wrong in said and "help: " in said
    assert not (tmp_path / "out").exists()


def test_a_folder_elsewhere_is_refused(apgc: Apgc) -> None:
    code, _, said = apgc("export", "Laptop", "--format", "shapenetpart", "-o", "memory://parts")
    assert code == 2 and "memory://parts is not on this machine" in said


@pytest.mark.parametrize("text", ["[]", '{"Kettle": "Mug"}', '{"Kettle": {"class": "Mug", "part": {}}}', "{"])
def test_a_map_that_is_none(apgc: Apgc, tmp_path: Path, text: str) -> None:
    (tmp_path / "map.json").write_text(text)
    code, _, said = apgc(
        "export", "Kettle", "--format", "shapenetpart", "--map", tmp_path / "map.json", "-o", tmp_path / "o"
    )
    assert code == 2 and "is not" in said and '"class"' in said


def test_a_folder_that_is_no_layout(apgc: Apgc, tmp_path: Path) -> None:
    assert "is no folder in a layout" in apgc("layout", tmp_path)[2]
    assert "there is no folder" in apgc("layout", tmp_path / "none")[2]
    (tmp_path / ".layout").mkdir()
    (tmp_path / ".layout/Laptop.json").write_text("{}")
    code, _, said = apgc("layout", tmp_path)
    assert code == 1 and "Laptop.json" in said and "--force" in said


def test_a_word_that_a_map_has_twice(apgc: Apgc, tmp_path: Path) -> None:
    """It would not be told which counts."""
    text = '{"Kettle": {"class": "Mug", "parts": {"handle": "handle", "*": "cup", "handle": "cup"}}}'
    (tmp_path / "map.json").write_text(text)
    map = ("--map", tmp_path / "map.json")
    code, _, said = apgc("export", "Kettle", "--format", "shapenetpart", *map, "-o", tmp_path / "o")
    assert code == 2 and "map.json: `handle` is given twice in one object" in said


def test_a_record_that_cannot_be_read_is_replaced(apgc: Apgc, tmp_path: Path) -> None:
    """As the message advises."""
    out = tmp_path / "out"
    laid = ("-n", 2, "--format", "shapenetpart", "--split", "1,1,0", "-o", out)
    for name in ("Laptop", "Knife"):
        assert apgc("export", name, *laid)[0] == 0
    record = out / ".layout/Laptop.json"
    record.write_text(record.read_text()[:40])
    assert "write Laptop again with --force" in apgc("export", "Knife", *laid, "--force")[2]
    assert apgc("export", "Laptop", *laid)[0] == 1
    assert apgc("export", "Laptop", *laid, "--force")[0] == 0
    assert apgc("layout", out)[0] == 0
    table = next(out.glob("03642806/*.txt"))
    table.write_text("a b c\n")
    assert f"03642806/{table.name}: is not as it was written" in apgc("layout", out)[1]


@pytest.mark.parametrize(
    ("change", "said"),
    [
        ({"category": None}, "category: nothing where text is expected"),
        ({"shares": ["8", 1, 1]}, "shares[0]: '8' where a whole number from 0 to 9999 is expected"),
        ({"shares": [0, 0, 0]}, "where three shares that are not all 0 is expected"),
        ({"map": {"Laptop": {"class": ["Laptop"]}}}, "map is not a map of words"),
        ({"layout": "parts"}, "where one of shapenetpart"),
        ({"words": [1]}, "words: a list where an object is expected"),
        (None, "maximum recursion depth exceeded"),
    ],
    ids=str,
)
def test_a_damaged_record_is_told(apgc: Apgc, tmp_path: Path, change: dict | None, said: str) -> None:
    out = tmp_path / "out"
    assert apgc("export", "Laptop", "-n", 1, "--format", "shapenetpart", "-o", out)[0] == 0
    record = out / ".layout/Laptop.json"
    record.write_text("[" * 100_000 if change is None else json.dumps(json.loads(record.read_text()) | change))
    code, _, err = apgc("layout", out)
    assert code == 1 and f"cannot read {record}" in err and said in err, err


def test_a_spoilt_list_of_files_stops_nobody(apgc: Apgc, tmp_path: Path) -> None:
    out = tmp_path / "out"
    laid = ("export", "Laptop", "-n", 1, "--format", "shapenetpart", "-o", out)
    assert apgc(*laid)[0] == 0
    before = tree(out)
    with (out / ".layout/Laptop.files").open("ab") as listed:
        listed.write(b"\xff\n\n03642806\n../other\n")
    (tmp_path / "other").write_text("")
    assert apgc(*laid, "--force")[0] == 0 and tree(out) == before and (tmp_path / "other").exists()


def test_a_category_that_no_list_takes_leaves_nothing(apgc: Apgc, tmp_path: Path) -> None:
    out = tmp_path / "maniskill"
    refused = ("export", "Microwave", "-n", 1, "--format", "maniskill", "-o", out)
    code, _, said = apgc(*refused)
    assert code == 1 and "no object of Microwave is one that ManiSkill's tasks take" in said
    assert not out.exists()
    out.mkdir()  # a folder of the user's is left where it is
    assert apgc(*refused)[0] == 1 and not list(out.iterdir())
    assert apgc("export", "Faucet", "-n", 2, "--format", "maniskill", "-o", out)[0] == 0
    before = tree(out)
    assert apgc(*refused)[0] == 1
    assert tree(out) == before
    assert apgc("layout", out)[0] == 0


def test_an_object_that_is_refused_midway_leaves_nothing(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    layout = LAYOUTS["cage"]
    whole = layout.files

    def refuse(*asked: object) -> Iterator[tuple[str, bytes]]:
        yield next(iter(whole(*asked)))
        raise UserError("the second object is refused")

    monkeypatch.setattr(type(layout), "files", lambda self, *asked: refuse(*asked))
    with pytest.raises(UserError, match="refused"):
        sample("StorageFurniture", n=2).lay_out(tmp_path / "cage", "cage")
    assert not (tmp_path / "cage").exists()


def test_a_killed_run_has_listed_what_it_leaves(tmp_path: Path) -> None:
    """Nothing is done after a run that is killed, so its files are known as soon as they are there."""
    layout, seen = replace(LAYOUTS["shapenetpart"], chunk=1), []
    listed = tmp_path / ".layout" / "Laptop.files"

    def look(done: int, total: int) -> None:
        seen.append((done, sum((tmp_path / name).exists() for name in listed.read_text().splitlines())))

    laying.write_layout(sample("Laptop", n=3).job, tmp_path, layout, progress=look)
    assert seen == [(1, 1), (2, 2), (3, 3)]


def test_what_is_interrupted_midway_is_not_found_by_loaders(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """They take all files of a folder, those of an object that is no longer asked for, too."""
    layout = LAYOUTS["shapenet55"]
    whole = layout.files

    def interrupt(*asked: object) -> Iterator[tuple[str, bytes]]:
        yield next(iter(whole(*asked)))
        raise KeyboardInterrupt

    with monkeypatch.context() as broken:
        broken.setattr(type(layout), "files", lambda self, *asked: interrupt(*asked))
        with pytest.raises(KeyboardInterrupt):
            sample("Laptop", n=2, seed=1).lay_out(tmp_path, "shapenet55")
    sample("Laptop", n=2).lay_out(tmp_path, "shapenet55")
    assert {path.name for path in (tmp_path / "shapenet_pc").iterdir()} == {
        f"03642806-Laptop0n00000{k}.npy" for k in range(2)
    }


KILLED = """
import os, sys
from artipg_dsl import sample
from artipg_dsl.run import laying

whole = laying.write_bytes

def write(path, data, *, force):
    if path.name.endswith("2.npy"):
        path.with_name(f".{path.name}.partial-{os.getpid()}").write_bytes(data[:100])
        os._exit(9)
    whole(path, data, force=force)

laying.write_bytes = write
sample("Laptop", n=3, seed=1).lay_out(sys.argv[1], "shapenet55")
"""


def test_what_a_killed_run_was_writing_goes(tmp_path: Path) -> None:
    """Whole or not: loaders that take all files of a folder would read it, under whatever name."""
    assert subprocess.run([sys.executable, "-c", KILLED, tmp_path]).returncode == 9
    assert len(list((tmp_path / "shapenet_pc").iterdir())) == 3
    sample("Laptop", n=1).lay_out(tmp_path, "shapenet55")
    assert [path.name for path in (tmp_path / "shapenet_pc").iterdir()] == ["03642806-Laptop0n000000.npy"]
    assert sorted(path.name for path in (tmp_path / ".layout").iterdir()) == ["Laptop.files", "Laptop.json", "lists"]


def test_a_category_that_is_written_again_is_in_no_list_meanwhile(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    out = tmp_path / "parts"
    for category in ("Laptop", "Chair"):
        sample(category, n=3).lay_out(out, "shapenetpart", split="1,1,1")
    listed = "\n".join(path.read_text() for path in out.rglob("shuffled_*.json"))
    assert "Laptop0n" in listed and "Chair0n" in listed

    def interrupt(piece: laying.Piece, job: object) -> list[str]:
        raise KeyboardInterrupt

    with monkeypatch.context() as broken:
        broken.setattr(laying.Piece, "write", interrupt)
        with pytest.raises(KeyboardInterrupt):
            sample("Laptop", n=2).lay_out(out, "shapenetpart", split="1,1,0", force=True)
    listed = "\n".join(path.read_text() for path in out.rglob("shuffled_*.json"))
    assert "Laptop0n" not in listed and "Chair0n" in listed
    assert not list(out.rglob("Laptop0n*"))
    sample("Laptop", n=2).lay_out(out, "shapenetpart", split="1,1,0")  # as if it had never been there
    assert len(list(out.rglob("Laptop0n*"))) == 2
