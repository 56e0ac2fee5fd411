"""Folders of values alone: everything else is made from them again, the same to the byte, without drawing or checking."""

from __future__ import annotations

import json
import os
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import artipg_dsl.api as apg
import artipg_dsl.sampling.sample as sampling
from artipg_dsl.cli.main import main
from artipg_dsl.errors import UserError
from artipg_dsl.run.resume import reopen

from .helpers import CHEST, tree

CATEGORIES = ["Foldingrack", *["StorageFurniture"] * (os.environ.get("ARTIPG_EVERY") == "1")]


def apgc(*words: Any) -> None:
    assert main([str(word) for word in words]) == 0


def refuse(*_: Any, **__: Any) -> None:
    raise AssertionError("objects are drawn or checked again")


@pytest.fixture
def undrawn(monkeypatch: pytest.MonkeyPatch) -> None:
    """From here on nothing is drawn or checked."""
    monkeypatch.setattr(sampling.Sampler, "batch", refuse)
    monkeypatch.setattr(sampling, "find_faults", refuse)


@pytest.fixture(scope="module", params=CATEGORIES)
def folders(request: pytest.FixtureRequest, tmp_path_factory: pytest.TempPathFactory) -> tuple[Path, Path]:
    """The values of objects, and the objects themselves."""
    out = tmp_path_factory.mktemp(request.param)
    asked = ["sample", request.param, "--seed", 5, "--only", "0..3,40..42"]
    apgc(*asked, "--tables", "-o", out / "tables")
    apgc(*asked, "--points", 64, "--states", "rest,open", "--format", "points,glb", "-o", out / "whole")
    return out / "tables", out / "whole"


@pytest.mark.some
def test_all_files_come_from_the_values(folders: tuple[Path, Path], tmp_path: Path, undrawn: None) -> None:
    tables, whole = folders
    made = ["--points", 64, "--states", "rest,open", "--format", "points,glb"]
    apgc("sample", tables, *made, "-o", tmp_path / "again")
    assert tree(tmp_path / "again") == tree(whole)  # counts of the run, too
    apgc("sample", tables, "--only", "2,41", *made, "-o", tmp_path / "some")
    for name in ("objects/000041/object.glb", "objects/000002/object.glb"):
        assert (tmp_path / "some" / name).read_bytes() == (whole / name).read_bytes()
    apgc("export", tables, "--format", "glb", "-o", tmp_path / "robots")
    assert (tmp_path / "robots/objects/000042/object.glb").exists()


def test_about_a_kilobyte_an_object(tmp_path: Path) -> None:
    apgc("sample", "Microwave", "-n", 64, "--tables", "--unchecked", "-o", tmp_path / "o")
    assert sorted(path.name for path in (tmp_path / "o").iterdir()) == ["manifest.json", "tables-00000.npz"]
    assert (tmp_path / "o/tables-00000.npz").stat().st_size / 64 < 1024


def test_repairs_are_kept(tmp_path: Path, undrawn: None, monkeypatch: pytest.MonkeyPatch) -> None:
    values = tmp_path / "values.json"
    values.write_text(json.dumps([{"width": 9.0}, {}, {"width": 0.01}]))
    with monkeypatch.context() as patch:
        patch.undo()
        for name, more in (("tables", ["--tables"]), ("whole", ["--points", 16])):
            apgc("sample", "Microwave", "--params", values, *more, "-o", tmp_path / name)
    apgc("sample", tmp_path / "tables", "--points", 16, "-o", tmp_path / "again")
    assert tree(tmp_path / "again") == tree(tmp_path / "whole")
    assert b"clipped" in (tmp_path / "again/annotation-00000.jsonl").read_bytes()


def test_mutants_are_made_again(tmp_path: Path) -> None:
    asked = ["sample", CHEST, "-n", 4, "--mutate", "cpa"]
    apgc(*asked, "--tables", "-o", tmp_path / "tables")
    apgc(*asked, "--format", "trace", "-o", tmp_path / "whole")
    apgc("sample", tmp_path / "tables", "--format", "trace", "-o", tmp_path / "again")
    assert tree(tmp_path / "again") == tree(tmp_path / "whole")


FAULTS: dict[str, Callable[[Path, dict[str, np.ndarray]], object]] = {
    "gone": lambda path, _: path.unlink(),
    "empty": lambda path, _: path.write_bytes(b""),
    "short": lambda path, _: path.write_bytes(path.read_bytes()[:300]),
    "one array": lambda path, held: np.save(path.open("wb"), held["values"]),
    "otherwise packed": lambda path, _: path.write_bytes(_with_method(path.read_bytes(), 99)),
    "strange": lambda path, held: np.savez(path, **held | {"values": held["values"] + 1e3}),
    "others": lambda path, held: np.savez(path, **held | {"object": held["object"] + 1}),
    "too few": lambda path, held: np.savez(path, **held | {"drawn": held["drawn"][:-1]}),
    "too many values": lambda path, held: np.savez(path, **held | {"rows": held["rows"] + np.uint16(1)}),
    "a number": lambda path, held: np.savez(path, **held | {"lane": held["lane"][0]}),
    "no repairs": lambda path, held: np.savez(path, **held | {"repairs": np.array([b"{"] * 3)}),
}


def _with_method(archive: bytes, method: int) -> bytes:
    """A zip archive whose directory says that its first member is packed by another method."""
    at = archive.index(b"PK\x01\x02") + 10
    return archive[:at] + method.to_bytes(2, "little") + archive[at + 2 :]


@pytest.mark.parametrize("fault", FAULTS)
def test_values_that_cannot_be_read_are_reported(tmp_path: Path, fault: str) -> None:
    apgc("sample", CHEST, "-n", 3, "--tables", "-o", tmp_path / "o")
    path = tmp_path / "o" / "tables-00000.npz"
    with np.load(path) as held:
        arrays = dict(held)
    FAULTS[fault](path, arrays)
    with pytest.raises(UserError, match="tables-00000.npz"):
        reopen(tmp_path / "o").batch()


@pytest.mark.parametrize(
    ("more", "said"),
    [
        (["--seed", "3"], "already have their seed"),
        (["--unchecked"], "are there already"),
        (["--mutate", "cpa"], "are there already"),
        (["--only", "9"], "there is no object 9"),
    ],
)
def test_objects_of_a_folder_are_not_drawn_otherwise(
    tmp_path: Path, more: list[str], said: str, capsys: pytest.CaptureFixture[str]
) -> None:
    apgc("sample", CHEST, "-n", 3, "--tables", "-o", tmp_path / "o")
    assert main(["sample", str(tmp_path / "o"), *more, "-o", str(tmp_path / "p")]) != 0
    assert said in capsys.readouterr().err
    assert main(["sample", str(tmp_path / "o"), "-o", str(tmp_path / "o")]) == 2


def test_some_objects_of_a_folder_in_python(tmp_path: Path) -> None:
    apgc("sample", CHEST, "-n", 5, "--tables", "-o", tmp_path / "o")
    some = apg.open_samples(tmp_path / "o", numbers=[1, 4])
    assert some.annotations() == apg.sample(CHEST, numbers=[1, 4]).annotations()
    assert some.object(4).annotation == some.annotations()[1]
    with pytest.raises(UserError, match="no object 7"):
        apg.open_samples(tmp_path / "o", numbers=[7])
