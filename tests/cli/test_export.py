"""apgc export: a folder of samples in further formats, and whatever may go wrong with the place they are written to."""

from __future__ import annotations

import errno
import json
import os
import shutil
import subprocess
import sys
from io import FileIO
from pathlib import Path
from typing import IO

import pytest

from artipg_dsl import sample
from artipg_dsl.errors import UserError
from artipg_dsl.export import objects, registry
from artipg_dsl.extras import Package
from artipg_dsl.layouts.registry import LAYOUTS

from .helpers import CHEST, Apgc, command, environment, tree

LIMITED = """
import resource, runpy, sys
resource.setrlimit(resource.RLIMIT_FSIZE, (700, 700))
sys.argv = sys.argv[1:]
runpy.run_module("artipg_dsl", run_name="__main__")
"""


@pytest.fixture
def made(apgc: Apgc, tmp_path: Path) -> Path:
    """Three chests with points and annotations."""
    assert apgc("sample", CHEST, "-n", 3, "--seed", 7, "--points", 16, "-o", tmp_path / "made")[0] == 0
    return tmp_path / "made"


def test_a_folder_of_samples_gets_further_formats(apgc: Apgc, made: Path, tmp_path: Path) -> None:
    before = tree(made)
    code, out, err = apgc("export", made, "--format", "urdf")
    assert (code, out) == (0, "") and "3 objects as urdf" in err
    assert apgc("export", made, "--format", "glb,obj")[0] == 0
    after = tree(made)
    assert all(after[name] == data for name, data in before.items() if name != "manifest.json")
    assert json.loads(after["manifest.json"])["identity"]["formats"] == ["points", "annotation", "urdf", "glb", "obj"]
    at_once = ("sample", CHEST, "-n", 3, "--seed", 7, "--points", 16, "--format", "points,urdf,glb,obj")
    assert apgc(*at_once, "-o", tmp_path / "b")[0] == 0
    whole = tree(tmp_path / "b")
    assert set(whole) == set(after)
    assert all(after[name] == data for name, data in whole.items() if name.startswith("objects/"))


def test_the_command_of_a_folder_still_completes_it_with_further_formats(apgc: Apgc, made: Path) -> None:
    assert apgc("export", made, "--format", "obj")[0] == 0
    before = tree(made)
    (made / "points-00000.npz").unlink()
    shutil.rmtree(made / "objects/000001")
    again = ("sample", CHEST, "-n", 3, "--seed", 7, "--points", 16, "-o", made)
    code, _, err = apgc(*again, "--format", "points,glb")
    assert code == 1 and "made with other options: the formats" in err
    assert apgc(*again)[0] == 0
    assert apgc("export", made, "--format", "obj")[0] == 0
    assert tree(made) == before


def test_folders_without_meshes(apgc: Apgc, made: Path) -> None:
    assert apgc("export", made, "--format", "partnet-mobility", "--no-meshes")[0] == 0
    files = tree(made)
    assert "objects/000000/mobility.urdf" in files and not any("textured_objs" in name for name in files)
    assert json.loads(files["manifest.json"])["identity"]["formats"] == [
        "points",
        "annotation",
        "partnet-mobility.bare",
    ]
    whole = ("points", "annotation", "partnet-mobility")
    for more, named in (
        ((), whole),
        (("--no-meshes", "--force"), (*whole[:2], f"{whole[2]}.bare")),
    ):  # one of the two at a time
        assert apgc("export", made, "--format", "partnet-mobility", *more)[0] == 0
        assert json.loads((made / "manifest.json").read_text())["identity"]["formats"] == [*named]
    for more, words in (
        (("urdf",), "urdf always has meshes"),
        (("points",), "none of the formats has meshes to leave out"),
        (("partnet-mobility", "--triangles", 30), "--no-meshes leaves them out"),
        (("cage",), "cage always has its meshes"),
    ):
        code, _, err = apgc("export", made, "--no-meshes", "--format", *more)
        assert code == 2 and words in err


def test_another_folder_holds_the_same_objects(apgc: Apgc, made: Path, tmp_path: Path) -> None:
    before = tree(made)
    assert apgc("export", made, "--format", "urdf", "--only", "2", "-o", tmp_path / "robots")[0] == 0
    assert tree(made) == before
    files = tree(tmp_path / "robots")
    assert {name.split("/")[1] for name in files if name.startswith("objects/")} == {"000002"}
    assert apgc("export", made, "--format", "urdf")[0] == 0
    assert tree(made)["objects/000002/object.urdf"] == files["objects/000002/object.urdf"]
    assert apgc("export", tmp_path / "robots", "--format", "glb")[0] == 0  # and it is a folder of samples itself


def test_fresh_objects_of_a_category(apgc: Apgc, made: Path, tmp_path: Path) -> None:
    assert apgc("export", CHEST, "-n", 2, "--seed", 7, "--format", "urdf", "-o", tmp_path / "o")[0] == 0
    assert apgc("export", made, "--format", "urdf")[0] == 0
    fresh = tree(tmp_path / "o")
    assert fresh["objects/000001/object.urdf"] == tree(made)["objects/000001/object.urdf"]


def test_what_is_there_is_kept_unless_forced(apgc: Apgc, made: Path) -> None:
    assert apgc("export", made, "--format", "urdf")[0] == 0
    marked = made / "objects" / "000001" / "object.urdf"
    marked.write_text("mine")
    code, _, err = apgc("export", made, "--format", "urdf")
    assert code == 0 and "were there: --force" in err and marked.read_text() == "mine"
    assert apgc("export", made, "--format", "urdf", "--force")[0] == 0
    assert marked.read_text().startswith("<?xml")
    batch = sample(CHEST, 2, seed=7)
    with pytest.raises(UserError, match="exists"):
        batch.to_urdf(made)
    assert batch.to_glb(made)[1].read_bytes()[:4] == b"glTF" and marked.exists()
    assert [p.name for p in batch.export(made, "urdf,obj", force=True)] == ["000000", "000001"]
    assert [p.name for p in batch.object(1).export(made, "urdf", force=True)] == ["000001"]
    with pytest.raises(UserError, match="samples of other objects: the seed"):
        sample(CHEST, 2, seed=6).export(made, "urdf", force=True)


def test_objects_in_a_format_have_meshes_of_one_kind(apgc: Apgc, tmp_path: Path) -> None:
    """Those of a run that ended early are completed as it began, or written again: all, or none."""
    folder = tmp_path / "o"
    assert apgc("sample", "Bottle", "-n", 3, "--points", 16, "-o", folder)[0] == 0
    assert apgc("export", folder, "--format", "obj", "--tolerance", "5mm", "--only", "0,1")[0] == 0
    before = tree(folder)
    for other in ((), ("--tolerance", "1mm"), ("--only", 2), ("--only", 1, "--force")):
        code, _, err = apgc("export", folder, "--format", "obj", *other)
        assert code == 1 and "has objects as obj with other meshes (tolerance 0.005, now" in err
    assert tree(folder) == before
    assert apgc("export", folder, "--format", "glb")[0] == 0
    assert apgc("export", folder, "--format", "obj", "--tolerance", "5mm")[0] == 0
    manifest = json.loads((folder / "manifest.json").read_text())
    assert manifest["shown"] == {"obj": {"meshes": {"tolerance": 0.005}, "details": None}}
    assert apgc("export", folder, "--format", "obj", "--force")[0] == 0
    assert "shown" not in json.loads((folder / "manifest.json").read_text())
    assert apgc("export", folder, "--format", "obj", "-o", tmp_path / "usual")[0] == 0
    usual, here = tree(tmp_path / "usual"), tree(folder)
    assert all(here[name] == data for name, data in usual.items() if name != "manifest.json")


def test_objects_that_nobody_vouches_for_are_left_alone(apgc: Apgc, tmp_path: Path) -> None:
    (tmp_path / "o" / "objects" / "000000").mkdir(parents=True)
    (tmp_path / "o" / "objects" / "000000" / "object.urdf").write_text("mine")
    code, _, err = apgc("export", CHEST, "-n", 1, "--format", "urdf", "-o", tmp_path / "o")
    assert code == 1 and "holds objects" in err and "--force" in err
    assert (tmp_path / "o" / "objects" / "000000" / "object.urdf").read_text() == "mine"


@pytest.mark.parametrize("gone", [(), ("points-00000.npz", "objects/000001")], ids=["nothing", "some"])
def test_what_a_killed_replacement_left_does_not_pass_for_the_new_objects(
    apgc: Apgc, tmp_path: Path, gone: tuple[str, ...]
) -> None:
    """The manifest goes first, and what it told of may still be there."""
    folder = tmp_path / "o"
    asked = ("sample", CHEST, "-n", 3, "--points", 16, "--format", "points,obj")
    assert apgc(*asked, "-o", folder)[0] == 0
    (folder / "manifest.json").unlink()
    (folder / "mine-00000.npz").write_text("mine")
    for name in gone:
        path = folder / name
        shutil.rmtree(path) if path.is_dir() else path.unlink()
    code, _, err = apgc(*asked, "--seed", 5, "-o", folder)
    assert code == 1 and "holds annotation-00000.jsonl, but there is no manifest.json" in err and "--force" in err
    assert apgc(*asked, "--seed", 5, "-o", folder, "--force")[0] == 0
    assert apgc(*asked, "--seed", 5, "-o", tmp_path / "fresh")[0] == 0
    here, fresh = tree(folder), tree(tmp_path / "fresh")
    assert (folder / "mine-00000.npz").read_text() == "mine" and here.pop("mine-00000.npz")
    assert here == fresh


def test_an_unknown_format_lists_the_known_ones(apgc: Apgc, made: Path) -> None:
    code, _, err = apgc("export", made, "--format", "urfd")
    assert code == 2 and "'urfd'" in err and "did you mean urdf?" in err
    assert all(name in err for name in (*registry.FORMATS, *LAYOUTS))
    assert "no format" in apgc("export", made, "--format", " , ")[2]
    code, _, err = apgc("export", made, "--format", "points")
    assert code == 2 and "apgc sample" in err


def test_a_missing_package_is_named_with_its_extra(apgc: Apgc, made: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    entry = registry.Format(
        "ply", "a test", robot="urdf:urdf_files", file="x", needs=Package("no_such_module", "ply-io", "ply")
    )
    monkeypatch.setitem(registry.FORMATS, "ply", entry)
    before = tree(made)
    for arguments in (("export", made), ("sample", CHEST, "-n", 1, "-o", made.parent / "p")):
        code, _, err = apgc(*arguments, "--format", "ply")
        assert code == 1 and "ply-io" in err and "pip install 'artipg_dsl[ply]'" in err
    assert tree(made) == before and not (made.parent / "p").exists()


@pytest.mark.parametrize("place", ["file", "file/below"])
def test_a_file_in_the_way(apgc: Apgc, made: Path, tmp_path: Path, place: str) -> None:
    (tmp_path / "file").write_text("x")
    code, _, err = apgc("export", made, "--format", "urdf", "-o", tmp_path / place)
    assert code == 1 and "is a file" in err and "choose another" in err


def test_a_target_that_cannot_be_written(apgc: Apgc, made: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    def refuse(self: Path, *_: object, **__: object) -> None:
        raise PermissionError(errno.EACCES, "Permission denied", str(self))

    with monkeypatch.context() as patch:
        patch.setattr(Path, "mkdir", refuse)
        code, _, err = apgc("export", made, "--format", "urdf", "-o", made.parent / "locked" / "o")
    assert code == 1 and "no permission to write" in err and "locked" in err


def fail_after(patch: pytest.MonkeyPatch, count: int, error: BaseException) -> None:
    """The next ``count`` files of objects are written, then ``error`` strikes in the middle of one."""
    left = [count]

    class Full(FileIO):
        def write(self, data: bytes) -> int:
            super().write(data[: len(data) // 2])
            raise error

    def limited(name: str, mode: str) -> IO[bytes]:
        left[0] -= 1
        return open(name, mode) if left[0] >= 0 else Full(name, mode)

    patch.setattr(objects, "open", limited, raising=False)


@pytest.mark.parametrize("error", [OSError(errno.ENOSPC, "No space left on device"), KeyboardInterrupt()])
@pytest.mark.parametrize("out", [None, "other"])
def test_a_full_disk_or_an_interruption_leaves_whole_objects_and_can_be_resumed(
    apgc: Apgc, made: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, error: BaseException, out: str | None
) -> None:
    assert apgc("export", made, "--format", "urdf,glb", "-o", tmp_path / "whole")[0] == 0
    whole = {name: data for name, data in tree(tmp_path / "whole").items() if name.startswith("objects/")}
    each = len([name for name in whole if name.startswith("objects/000000/")])
    place = ("-o", tmp_path / out) if out else ()
    target = tmp_path / out if out else made
    with monkeypatch.context() as patch:
        fail_after(patch, each + each // 2, error)
        code, _, err = apgc("export", made, "--format", "urdf,glb", *place)
    if isinstance(error, OSError):
        assert code == 1 and "no space left" in err and "run the same command again" in err
    else:
        assert code == 130 and "interrupted" in err
    found = {name: data for name, data in tree(target).items() if name.startswith("objects/")}
    assert found == {name: data for name, data in whole.items() if name.startswith("objects/000000/")}
    assert apgc("export", made, "--format", "urdf,glb", *place)[0] == 0
    found = {name: data for name, data in tree(target).items() if name.startswith("objects/")}
    assert found == whole and not [path for path in target.rglob("*") if "partial" in path.name]


@pytest.mark.skipif(os.name != "posix", reason="limits of file sizes are a POSIX thing")
def test_a_limit_on_file_sizes_is_told_in_words(made: Path) -> None:
    done = subprocess.run(
        # without -B, CPython 3.11 leaves a compiled module cut off at the limit, which no later process can read
        [sys.executable, "-B", "-c", LIMITED, *command("export", made, "--format", "glb")[2:]],
        env=environment(),
        capture_output=True,
        text=True,
        check=False,
    )
    assert done.returncode == 1 and "exceeds the size" in done.stderr and "Traceback" not in done.stderr
    assert not (made / "objects").exists() or not list((made / "objects").iterdir())


def test_a_program_that_has_changed_is_not_passed_off_for_the_old_one(apgc: Apgc, tmp_path: Path) -> None:
    program = tmp_path / "box.apg"
    text = "apg 1\nuse primitives { Cuboid }\ncategory Box {\n  root part body : Cuboid(size = [4cm, 5cm, 6cm])\n}\n"
    program.write_text(text)
    assert apgc("sample", program, "-n", 1, "--points", 4, "-o", tmp_path / "o")[0] == 0
    program.write_text(text.replace("4cm", "7cm"))
    code, _, err = apgc("export", tmp_path / "o", "--format", "urdf")
    assert code == 1 and "has changed" in err
    code, _, err = apgc("export", tmp_path, "--format", "urdf")
    assert code == 1 and "manifest.json" in err


def test_meshes_as_fine_as_asked(apgc: Apgc, tmp_path: Path) -> None:
    fine, coarse = tmp_path / "fine", tmp_path / "coarse"
    assert apgc("sample", "Faucet", "-n", 1, "--format", "glb", "--tolerance", "0.1mm", "-o", fine)[0] == 0
    assert apgc("export", "Faucet", "-n", 1, "--format", "glb", "--triangles", "800", "-o", coarse)[0] == 0
    sizes = [(folder / "objects/000000/object.glb").stat().st_size for folder in (fine, coarse)]
    assert sizes[0] > 2 * sizes[1]
    assert json.loads((fine / "manifest.json").read_text())["identity"]["meshes"] == {"tolerance": 1e-4}
    code, _, err = apgc("sample", "Faucet", "-n", 1, "--format", "glb", "-o", fine)
    assert code == 1 and "the resolution of meshes" in err


@pytest.mark.parametrize(
    "wish, message",
    [
        (("--tolerance", "5"), "'5' is not a length"),
        (("--tolerance", "1nm"), "not a length"),
        (("--tolerance", "0.001mm"), "is not between 0.01mm and 10m"),
        (("--triangles", "0"), "from 1 to"),
        (("--tolerance", "1mm"), "--tolerance and --triangles apply to meshes"),
    ],
)
def test_wishes_about_meshes_that_make_no_sense(
    apgc: Apgc, tmp_path: Path, wish: tuple[str, ...], message: str
) -> None:
    code, _, err = apgc("sample", "Faucet", *wish, "-o", tmp_path / "out")
    assert code == 2 and message in err
