"""``apgc fit``: files into a folder that sample and mutate accept."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import artipg_dsl as apg

from .helpers import CHEST, Apgc, tree

pytestmark = pytest.mark.usefixtures("searched_once")


@pytest.fixture(scope="module")
def real(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A folder with two chests as clouds, and a file that is none."""
    folder = tmp_path_factory.mktemp("real")
    points = apg.sample(CHEST, n=2, seed=4).points(6000)
    for k in range(2):
        label = (points.semantic[k] == points.semantic[k].max()).astype(int)
        np.savez(
            folder / f"chest{k}.npz",
            points=points.position[k],
            normals=points.normal[k],
            label=label,
            label_names=["Box", "Knob"],
        )
    (folder / "broken.obj").write_text("f 1 2 3\n")
    return folder


def test_a_folder_of_files(apgc: Apgc, real: Path, tmp_path: Path) -> None:
    out = tmp_path / "fitted"
    (tmp_path / "map.json").write_text('{"Knob": "handle"}')
    asked = ("fit", CHEST, real, "-o", out, "--front", "x", "--map", tmp_path / "map.json")
    code, said, err = apgc(*asked)
    assert code == 0 and "2 objects" in err and "1 file could not be read" in err
    assert said.count("fits") == 2 and "broken" in said and "not read" in said
    summary = json.loads((out / "fit.json").read_text())
    assert [one["object"] for one in summary["objects"]] == [0, 1] and len(summary["failed"]) == 1
    record = json.loads((out / "fits" / "chest0.json").read_text())
    assert record["iou"].keys() == {"handle"} and record["distance"]["both"] < 0.5
    assert (out / "pictures" / "chest1.png").read_bytes().startswith(b"\x89PNG")

    assert summary["labels"] == ["Box", "Knob"] and "warning" not in err

    before = tree(out)  # a second run leaves all as it is, and works on nothing
    code, _, _ = apgc(*asked)
    assert code == 0 and tree(out) == before
    code, _, err = apgc(*asked, "--seed", 1, "--up=y")  # nor is it replaced unasked
    assert code == 1 and "other options: the upward axis (auto, now y) and the seed (0, now 1)" in err
    assert "--force" in err and tree(out) == before
    assert apgc("export", out, "--format", "obj")[0] == 0
    exported = tree(out)  # so does it with what has been added
    assert len(exported) > len(before)
    code, _, _ = apgc(*asked)
    assert code == 0 and tree(out) == exported

    code, _, err = apgc("sample", CHEST, "--params", out / "values.jsonl", "-o", tmp_path / "again", "--points", 64)
    assert code == 0 and "2 objects" in err
    code, _, err = apgc("mutate", out, "-o", tmp_path / "mutants", "-n", 2)
    assert code == 0 and "4 objects" in err


def test_what_was_not_fitted_is_no_object_and_is_in_no_way(apgc: Apgc, real: Path, tmp_path: Path) -> None:
    out, wall = tmp_path / "out", tmp_path / "wall.npz"
    code, _, err = apgc("fit", CHEST, real / "broken.obj", "-o", out, "--plain")
    assert code == 1 and "0 objects in" in err and "1 file could not be read" in err
    steps = np.stack(np.meshgrid(np.linspace(-0.4, 0.4, 40), np.linspace(0, 0.01, 40)), axis=-1).reshape(-1, 2)
    np.savez(wall, points=np.insert(steps, 1, 0.001 * np.arange(len(steps)) % 0.01, axis=1))  # a strip, and no chest
    code, said, err = apgc("fit", CHEST, wall, "-o", out, "--plain", "--front", "x", "--at-rest")
    assert code == 1 and "does not fit" in said, (said, err)
    assert "0 objects in" in err and "1 object not among them: without a valid fit" in err


@pytest.mark.slow
def test_what_is_known_of_each(apgc: Apgc, real: Path, tmp_path: Path) -> None:
    out, known = tmp_path / "fitted", tmp_path / "known.json"

    def fits(*more: object) -> dict[str, Any]:
        code, _, err = apgc("fit", CHEST, real, "-o", out, "--front", "x", "--plain", *more)
        assert code == 0, err
        return {one["name"]: one for one in json.loads((out / "fit.json").read_text())["objects"]}

    before = fits()
    files = {name: (out / "fits" / f"{name}.json").read_bytes() for name in before}
    found = json.loads(files["chest1"])["drawn"]["knobs"]
    choices = json.loads((out / "choices.json").read_text())
    assert choices.keys() == before.keys() and choices["chest1"] == {"knobs": found}
    assert json.loads(files["chest1"])["choices"] == choices["chest1"]
    other = 1 if found != 1 else 2
    known.write_text(json.dumps({"chest1": {"knobs": other, "wood": "pine"}}))
    now = fits("--facts", known)  # that one is fitted again, the other stays
    assert now["chest0"] == before["chest0"] and now["chest1"]["distance"] != before["chest1"]["distance"]
    assert now["chest1"]["facts"] == {"knobs": other, "wood": "pine"} and "facts" not in now["chest0"]
    assert (out / "fits" / "chest0.json").read_bytes() == files["chest0"]
    record = json.loads((out / "fits" / "chest1.json").read_text())
    assert record["drawn"]["knobs"] == other and record["drawn"]["wood"] == "pine" and record["valid"]
    assert json.loads((out / "facts.json").read_text()) == json.loads(known.read_text())
    assert json.loads((out / "values.jsonl").read_text().splitlines()[1])["drawn"] == record["drawn"]

    whole = tree(out)
    assert fits("--facts", out / "facts.json") == now and tree(out) == whole
    known.write_text(json.dumps({"chest1": {"knobs": other}}))
    assert fits("--facts", known, "--set", "wood=pine")["chest0"]["facts"] == {"wood": "pine"}
    record = json.loads((out / "fits" / "chest1.json").read_text())
    assert record["facts"] == {"wood": "pine", "knobs": other} and record["drawn"]["knobs"] == other
    known.write_text(json.dumps(choices))
    assert all(one["facts"] == choices[name] for name, one in fits("--facts", known).items())
    assert json.loads((out / "choices.json").read_text()) == choices  # what was found is true of what is found
    code, _, err = apgc("fit", CHEST, real, "-o", out, "--front", "x", "--plain")
    assert code == 1 and "holds a fit of chest0 with facts, and none are given now" in err
    assert f"repeat them: --facts {out / 'facts.json'}" in err
    known.write_text('{"chest0": {}, "chest1": {}}')  # taken back
    assert fits("--facts", known) == before and not (out / "facts.json").exists()
    assert {name: (out / "fits" / f"{name}.json").read_bytes() for name in before} == files


@pytest.mark.parametrize(
    ("text", "words", "told"),
    [
        ('{"chest3": {"knobs": 2}}', [], "no object is called chest3 = help: did you mean `chest1`?"),
        ('{"chest1": {"knbos": 2}}', [], "chest1: Chest draws no `knbos` = help: did you mean `knobs`?"),
        ('{"chest1": {"knobs": "7"}}', [], "known.json: chest1: `knobs` cannot be 7: it lies in 1 .. 3"),
        ('{"chest1": [2]}', [], "chest1 is a list, and no facts"),
        ("[2]", [], "known.json is a list, and names no objects"),
        ('{"chest1": {"knobs": 2, "knobs": 3}}', [], "`knobs` is given twice"),
        ("{}", ["--set", "wood=elm"], "what is set: `wood` cannot be `elm`: it is one of oak, pine"),
        ("{}", ["--set", "knobs"], "`knobs` sets nothing"),
        ("{", [], "known.json:1:2: it is not JSON"),
    ],
)
def test_what_cannot_be_known(apgc: Apgc, real: Path, tmp_path: Path, text: str, words: list[str], told: str) -> None:
    (tmp_path / "known.json").write_text(text)
    out = tmp_path / "out"
    code, _, err = apgc("fit", CHEST, real, "-o", out, "--facts", tmp_path / "known.json", *words)
    assert code in (1, 2) and told in " ".join(err.split()) and not out.exists(), err


@pytest.mark.parametrize(
    ("words", "told"),
    [
        (["nowhere"], "there is no file or folder nowhere\n  = help: give files (.obj"),
        (["--front", "z", "--up", "z", "."], "lie on one axis"),
        (["--normalised", "--unit", "cm", "."], "have no unit"),
        (["--map", "nowhere.json", "{real}"], "there is no file nowhere.json"),
    ],
)
def test_what_is_refused(apgc: Apgc, real: Path, tmp_path: Path, words: list[str], told: str) -> None:
    code, _, err = apgc("fit", CHEST, *[word.format(real=real) for word in words], "-o", tmp_path / "out")
    assert code in (1, 2) and told in err


def test_points_that_are_left_out_are_told(apgc: Apgc, real: Path, tmp_path: Path) -> None:
    held = dict(np.load(real / "chest0.npz"))
    held["points"][::10] = np.nan
    np.savez(tmp_path / "torn.npz", **held)
    code, said, _ = apgc("fit", CHEST, tmp_path / "torn.npz", "-o", tmp_path / "out", "--plain", "--front", "x")
    assert code == 0 and "torn  (600 of 6000 points are no numbers)" in said
    assert json.loads((tmp_path / "out" / "fit.json").read_text())["objects"][0]["lost"]
    code, _, err = apgc("compare", CHEST, tmp_path / "torn.npz", "-n", 8, "--front", "x")
    assert code == 0 and "torn.npz: 600 of 6000 points are no numbers, and were left out" in err


def test_a_word_that_is_none(apgc: Apgc, real: Path, tmp_path: Path) -> None:
    (tmp_path / "map.json").write_text('{"Knob": "handel"}')
    code, _, err = apgc("fit", CHEST, real, "-o", tmp_path / "out", "--map", tmp_path / "map.json")
    assert code == 2 and "no word of `semantic`" in err and "did you mean `handle`?" in err


@pytest.mark.parametrize(
    ("text", "told"),
    [('{"Knob": "handle", "Knob": "body"}', "`Knob` is given twice"), ("{", "is not JSON"), ("[]", "maps no names")],
)
def test_a_map_that_cannot_be_meant(apgc: Apgc, real: Path, tmp_path: Path, text: str, told: str) -> None:
    (tmp_path / "map.json").write_text(text)
    code, _, err = apgc("fit", CHEST, real, "-o", tmp_path / "out", "--map", tmp_path / "map.json")
    assert code == 1 and told in err


def test_a_map_of_labels_that_no_file_has(apgc: Apgc, real: Path, tmp_path: Path) -> None:
    (tmp_path / "map.json").write_text('{"Knob": "handle", "Lid": "door"}')
    asked = ("fit", CHEST, real / "chest0.npz", "-o", tmp_path / "out", "--front", "x", "--plain")
    code, _, err = apgc(*asked, "--map", tmp_path / "map.json")
    assert code == 0 and "no file has a label `Lid`" in err and "their labels are `Box` and `Knob`" in err


@pytest.mark.slow
def test_fits_of_other_files_are_not_lost(apgc: Apgc, real: Path, tmp_path: Path) -> None:
    files = [tmp_path / side / "object.npz" for side in "ab"]
    for k, file in enumerate(files):
        file.parent.mkdir()
        file.write_bytes((real / f"chest{k}.npz").read_bytes())
    out = tmp_path / "fitted"
    asked = ("-o", out, "--front", "x", "--plain")
    assert apgc("fit", CHEST, files[0], *asked)[0] == 0
    before = tree(out)
    code, _, err = apgc("fit", CHEST, files[1], *asked)
    assert code == 1 and f"holds fits of {files[0]}" in err and tree(out) == before
    assert apgc("fit", CHEST, files[1], *asked, "--force")[0] == 0
    files[1].write_bytes(b"nothing")  # no object fits now: what was made of it before is no sample of this folder
    code, said, _ = apgc("fit", CHEST, files[1], *asked)
    assert code == 1 and "not read" in said and not (out / "manifest.json").exists()
    assert not list(out.glob("annotation-*"))
    files[1].unlink()  # of what is not there any more nothing is kept
    assert apgc("fit", CHEST, files[0], *asked)[0] == 0


def test_fits_that_force_leaves_out_leave_no_files(apgc: Apgc, tmp_path: Path) -> None:
    out, files = tmp_path / "out", [tmp_path / f"{name}.obj" for name in ("one", "other")]
    for file in files:
        file.write_text("f 1 2 3\n")
    apgc("fit", CHEST, files[0], "-o", out)
    (out / "fits" / "notes.json").write_text("{}")  # somebody's own
    (out / "pictures" / "one.png").write_bytes(b"")
    apgc("fit", CHEST, files[1], "-o", out, "--force")
    assert set(tree(out)) == {"fit.json", "fits/notes.json", "fits/other.json", "values.jsonl"}


def test_a_name_that_no_record_can_have_stops_no_other(apgc: Apgc, real: Path, tmp_path: Path) -> None:
    folder, out = tmp_path / "odd", tmp_path / "out"
    folder.mkdir()
    (folder / "chest.npz").write_bytes((real / "chest0.npz").read_bytes())
    try:
        Path(str(folder) + "/b\udcffd.npz").write_bytes(b"nothing")
    except OSError:
        pytest.skip("names are UTF-8 here")
    code, said, err = apgc("fit", CHEST, folder, "-o", out, "--front", "x", "--plain")
    assert code == 0 and "1 object in" in err and "its path is not in UTF-8" in said
    assert [one["name"] for one in json.loads((out / "fit.json").read_text())["failed"]] == ["b\ufffdd"]


def test_samples_are_not_written_over(apgc: Apgc, real: Path, tmp_path: Path) -> None:
    apgc("sample", CHEST, "-n", 1, "--points", 8, "-o", tmp_path)
    before = tree(tmp_path)
    code, _, err = apgc("fit", CHEST, real, "-o", tmp_path)
    assert code == 1 and "holds samples" in err and "a folder of their own" in err and tree(tmp_path) == before


def test_a_folder_of_nothing_but_bad_files(apgc: Apgc, tmp_path: Path) -> None:
    (tmp_path / "a.obj").write_text("")
    code, said, err = apgc("fit", CHEST, tmp_path / "a.obj", "-o", tmp_path / "out")
    assert code == 1 and "not read" in said


def test_a_file_that_changes_while_it_is_fitted_is_fitted_again(
    apgc: Apgc, real: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    from artipg_dsl.run import fitting

    file, out = tmp_path / "chest.npz", tmp_path / "out"
    file.write_bytes((real / "chest0.npz").read_bytes())
    asked = ("fit", CHEST, file, "-o", out, "--front", "x", "--plain")
    fit = fitting.fit

    def change(*given: Any, **more: Any) -> Any:
        file.write_bytes((real / "chest1.npz").read_bytes())
        more["doing"]("1 object")
        return fit(*given, **more)

    said: list[str] = []
    with monkeypatch.context() as patched:
        patched.setattr(fitting, "fit", change)
        patched.setattr("artipg_dsl.cli.fit.Progress.stage", lambda _, doing: said.append(doing))
        assert apgc(*asked)[0] == 0
    assert "fitting 1 object" in said
    first = (out / "values.jsonl").read_text()
    assert apgc(*asked)[0] == 0 and (out / "values.jsonl").read_text() != first


@pytest.mark.parametrize(
    ("key", "value"), [("drawn", None), ("distance", {}), ("valid", "yes"), ("name", "other"), ("source", None)]
)
def test_a_record_that_lacks_something_is_made_again(
    apgc: Apgc, real: Path, tmp_path: Path, key: str, value: object
) -> None:
    out = tmp_path / "out"
    asked = ("fit", CHEST, real / "chest0.npz", "-o", out, "--front", "x", "--plain")
    assert apgc(*asked)[0] == 0
    before, path = tree(out), out / "fits" / "chest0.json"
    record = json.loads(path.read_text())
    if value is None:
        del record[key]
    else:
        record[key] = value
    path.write_text(json.dumps(record))
    picture = out / "pictures" / "chest0.png"
    picture.write_bytes(b"of what was fitted before")
    (out / "fit.json").write_text('{"objects": [{"source": 3}, 5]}')
    assert apgc(*asked)[0] == 0 and tree(out) == before
