"""``apgc bind``: the surfaces of real objects into a folder of details."""

from __future__ import annotations

import json
import shutil
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import artipg_dsl as apg

from .helpers import CHEST, Apgc, tree


def fit_one(folder: Path, number: int, name: str = "object") -> Path:
    """A folder as ``apgc fit`` writes it, of one chest whose file is `object.npz`, by default called so, too."""
    from artipg_dsl.export.content import Content
    from artipg_dsl.export.registry import choose_formats
    from artipg_dsl.fit.sources import mark
    from artipg_dsl.run.dataset import write_dataset
    from artipg_dsl.run.output import Output

    samples = apg.sample(CHEST, numbers=[number], seed=4)
    samples = apg.sample(CHEST, values=[samples.object(number).drawn])
    write_dataset(samples.job, folder, Output.of(choose_formats("annotation"), Content()))
    points = samples.points(3000, surface="outside")
    file = folder / "object.npz"
    np.savez(file, points=points.position[0], normals=points.normal[0])
    frame = {"up": "z", "front": "x", "unit": "m"}
    record = {"name": name, "frame": frame, "to_object": np.eye(4).tolist(), "file": mark(file)}
    (folder / "fits").mkdir()
    (folder / "fits" / f"{name}.json").write_text(json.dumps(record))
    objects = [{"object": 0, "name": name, "source": str(file), "verdict": "fits"}]
    (folder / "fit.json").write_text(json.dumps({"category": "Chest", "objects": objects}))
    return folder


def test_an_object_without_a_detail_is_told(apgc: Apgc, tmp_path: Path) -> None:
    code, out, err = apgc("bind", fit_one(tmp_path / "one", 0), "-o", tmp_path / "bound", "--points", 1)
    assert code == 1 and "none of its points has a counterpart on the structure" in out + err


def test_details_that_force_leaves_out_leave_no_files(apgc: Apgc, tmp_path: Path) -> None:
    one, other, out = fit_one(tmp_path / "one", 0), fit_one(tmp_path / "other", 1, "second"), tmp_path / "bound"
    asked = ("-o", out, "--points", 500)
    assert apgc("bind", one, *asked)[0] == 0
    (out / "notes.json").write_text("{}")  # somebody's own
    assert apgc("bind", other, *asked, "--force")[0] == 0
    assert set(tree(out)) == {"bind.json", "notes.json", "records/second.json", "second.npz"}


@pytest.mark.some
@pytest.mark.parametrize("name", ["bind", "records", "details"])
def test_objects_may_be_called_like_what_lies_beside_them(apgc: Apgc, tmp_path: Path, name: str) -> None:
    one, other, out = fit_one(tmp_path / "one", 0, name), fit_one(tmp_path / "other", 1), tmp_path / "bound"
    asked = ("-o", out, "--points", 500)
    assert apgc("bind", one, *asked)[0] == 0
    assert json.loads((out / "bind.json").read_text())["objects"][0]["name"] == name
    before = tree(out)
    assert set(before) == {"bind.json", f"{name}.npz", f"records/{name}.json"}
    assert apgc("bind", one, *asked)[0] == 0 and tree(out) == before
    assert apgc("bind", other, *asked, "--force")[0] == 0
    assert len(tree(out)) == 3 and not (out / f"{name}.npz").exists()


def test_records_beside_the_summary_are_read(apgc: Apgc, tmp_path: Path) -> None:
    """So they lay once: nothing is bound again, and what is takes its place in the folder of records."""
    one, out = fit_one(tmp_path / "one", 0), tmp_path / "bound"
    assert apgc("bind", one, "-o", out, "--points", 500)[0] == 0
    (out / "records" / "object.json").rename(out / "object.json")
    (out / "records").rmdir()
    before, made = tree(out), (out / "object.npz").stat().st_mtime_ns
    assert apgc("bind", one, "-o", out, "--points", 500)[0] == 0
    assert tree(out) == before and (out / "object.npz").stat().st_mtime_ns == made
    assert apgc("bind", one, "-o", out, "--points", 500, "--force")[0] == 0
    assert set(tree(out)) == {"bind.json", "object.npz", "records/object.json"}


def test_details_of_other_objects_are_not_lost(apgc: Apgc, tmp_path: Path) -> None:
    one, other, out = fit_one(tmp_path / "one", 0), fit_one(tmp_path / "other", 1), tmp_path / "bound"
    asked = ("-o", out, "--points", 500)
    assert apgc("bind", one, *asked)[0] == 0
    before = tree(out)
    code, _, err = apgc("bind", other, *asked)
    assert code == 1 and f"holds details of {one / 'object.npz'}" in err and tree(out) == before
    assert apgc("bind", one, *asked)[0] == 0 and tree(out) == before
    (one / "object.npz").rename(tmp_path / "moved.npz")
    assert apgc("bind", one, tmp_path / "moved.npz", *asked)[0] == 0 and tree(out) == before  # the same file elsewhere
    assert apgc("bind", other, *asked, "--force")[0] == 0
    (out / "object.npz").write_bytes(b"")  # emptied by hand
    assert apgc("bind", other, *asked)[0] == 0 and (out / "object.npz").stat().st_size > 0


def test_a_folder_of_details(apgc: Apgc, fitted: Path, tmp_path: Path) -> None:
    out = tmp_path / "bound"
    asked = ("bind", fitted, "-o", out, "--points", 1500)
    code, said, err = apgc(*asked)
    assert code == 0 and "details of 2 objects" in err and "1 object could not be bound" in err
    assert said.count("covered") == 2 and "tower: does not fit" in said
    summary = json.loads((out / "bind.json").read_text())
    first = summary["objects"][0]
    assert first["object"] == 0 and first["worn"] > 0.9 and first["completed"] < 0.5 * first["points"]
    assert (
        abs(first["after"]["to_real"] - first["before"]["to_real"]) < 0.05
    )  # this real surface is that of the structure
    with np.load(out / "chest0.npz") as held:
        assert held["offset"].shape == (first["points"], 3) and held["version"].tolist() == [1]

    with np.load(out / "chest0.npz") as held:
        assert (held["how"] > 0).sum() == first["completed"]

    before = tree(out)  # a second run leaves all as it is; others write the same
    (out / "chest1.npz").unlink()
    code, _, _ = apgc(*asked)
    assert code == 0 and tree(out) == before
    code, _, err = apgc(*asked, "--visible")
    told = "holds details bound with other options: what was hidden completed (True, now False)"
    assert code == 1 and told in err and tree(out) == before
    code, _, _ = apgc(*asked, "--visible", "--force")
    summary = json.loads((out / "bind.json").read_text())
    assert code == 0 and [one["completed"] for one in summary["objects"]] == [0, 0]
    assert summary["options"]["completed"] is False


@pytest.mark.slow
def test_details_follow_objects_that_have_other_numbers_now(apgc: Apgc, fitted: Path, tmp_path: Path) -> None:
    """A file was added to a fit, and all objects after it have moved up."""
    from artipg_dsl.export.content import Content
    from artipg_dsl.export.registry import choose_formats
    from artipg_dsl.run.dataset import write_dataset
    from artipg_dsl.run.output import Output

    before, asked = tmp_path / "before", ("-o", tmp_path / "bound", "--points", 500)
    shutil.copytree(fitted, before)
    samples = apg.sample(CHEST, values=[apg.sample(CHEST, n=2, seed=4).object(1).drawn])
    write_dataset(samples.job, before, Output.of(choose_formats("annotation"), Content()), force=True)
    summary = json.loads((fitted / "fit.json").read_text())
    alone = [one | {"object": 0} for one in summary["objects"] if one["name"] == "chest1"]
    (before / "fit.json").write_text(json.dumps(summary | {"objects": alone}))
    assert apgc("bind", before, *asked)[0] == 0
    assert apgc("bind", fitted, *asked)[0] == 0
    told = json.loads((tmp_path / "bound" / "bind.json").read_text())["objects"]
    assert [(one["name"], one["object"]) for one in told] == [("chest0", 0), ("chest1", 1)]
    assert apgc("bind", fitted, *asked[2:], "-o", tmp_path / "anew")[0] == 0
    assert tree(tmp_path / "bound") == tree(tmp_path / "anew")


@pytest.mark.parametrize("change", [{"object": "x"}, {"object": 7}, {"name": None}, {"source": 3}, None])
def test_edited_summaries_of_fits(apgc: Apgc, fitted: Path, tmp_path: Path, change: dict[str, object] | None) -> None:
    path = fitted / "fit.json"
    kept = path.read_text()
    summary = json.loads(kept)
    if change is None:
        del summary["objects"]
    else:
        summary["objects"][1] |= change
    try:
        path.write_text(json.dumps(summary))
        code, _, err = apgc("bind", fitted, "-o", tmp_path / "bound", "--points", 200)
        assert code == 1 and ("fit.json is damaged" in err or "has no object 7, which its fit.json lists" in err)
        assert "fits only what is missing" in err
    finally:
        path.write_text(kept)


def test_a_full_disk_is_no_fault_of_the_object(
    apgc: Apgc, fitted: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    from artipg_dsl.export.write import ExportError
    from artipg_dsl.run import bindings

    write = bindings.write_bytes

    def refuse(path: Path, data: bytes, **more: Any) -> None:
        if path.suffix == ".npz":
            raise ExportError(f"no space left while writing {path}")
        write(path, data, **more)

    monkeypatch.setattr(bindings, "write_bytes", refuse)
    code, _, err = apgc("bind", fitted, "-o", tmp_path / "bound", "--points", 200, "--workers", 1)
    assert code == 1 and "error: no space left while writing" in err


def test_one_file_stops_no_other(apgc: Apgc, fitted: Path, tmp_path: Path) -> None:
    real = fitted / "chest0.npz"
    kept = real.read_bytes()
    try:
        real.write_bytes(b"nothing")
        code, said, err = apgc("bind", fitted, "-o", tmp_path / "bound", "--points", 500)
        assert code == 0 and "is not the file that was fitted" in said and "details of 1 object" in err
        (tmp_path / "elsewhere.npz").write_bytes(kept)
        code, said, _ = apgc("bind", fitted, tmp_path / "elsewhere.npz", "-o", tmp_path / "bound", "--points", 500)
        assert code == 0 and said.count("covered") == 2
    finally:
        real.write_bytes(kept)


@pytest.mark.parametrize(
    ("key", "value", "told"),
    [
        ("to_object", None, "`to_object` in the record of chest0 is not a matrix"),
        ("to_object", [[1, 0, 0], [0, 1, 0], [0, 0, 1]], "is not a matrix"),
        ("to_object", [["1", 0, 0, 0], [0, 1, 0, 0], [0, 0, 1, 0], [0, 0, 0, 1]], "is not a matrix"),
        ("to_object", [[0, 0, 0, 0], [0, 0, 0, 0], [0, 0, 0, 0], [0, 0, 0, 1]], "is not a matrix"),
        ("to_object", [[1, 0, 0, float("nan")], [0, 1, 0, 0], [0, 0, 1, 0], [0, 0, 0, 1]], "is not a matrix"),
        ("joints", [["open", 1.0]], "`joints` in the record of chest0 is not a number for each name"),
        ("joints", {"open": "wide"}, "`joints` in the record of chest0 is not a number for each name"),
        ("joints", {"nothing": 1.0}, "the object has no joint `nothing`"),
        ("frame", {"up": "z", "front": "-z", "unit": "m"}, "`frame` in the record of chest0 is not two axes"),
        ("frame", None, "the record of chest0 is missing or damaged"),
        ("file", None, "the record of chest0 is missing or damaged"),
    ],
)
def test_edited_records(apgc: Apgc, fitted: Path, tmp_path: Path, key: str, value: object, told: str) -> None:
    path = fitted / "fits" / "chest0.json"
    kept = path.read_text()
    try:
        path.write_text(json.dumps(json.loads(kept) | {key: value}))
        code, said, err = apgc("bind", fitted, "-o", tmp_path / "bound", "--points", 200)
        assert code == 0 and told in said and "details of 1 object" in err
    finally:
        path.write_text(kept)


def test_what_is_refused(apgc: Apgc, fitted: Path, tmp_path: Path) -> None:
    code, _, err = apgc("bind", tmp_path, "-o", tmp_path / "bound")
    assert code == 1 and "is not a folder of fitted objects" in err
    other = tmp_path / "other.npz"
    other.write_bytes(b"another object")
    code, _, err = apgc("bind", fitted, other, "-o", tmp_path / "bound")
    assert code == 1 and f"{other}: none of these was fitted" in err
    code, _, err = apgc("bind", fitted, "-o", fitted)
    assert code == 1 and "holds fitted objects" in err and "a folder of their own" in err


def test_a_category_that_has_changed_since_the_fit_is_named(apgc: Apgc, tmp_path: Path) -> None:
    from artipg_dsl.export.content import Content
    from artipg_dsl.export.registry import choose_formats
    from artipg_dsl.run.dataset import write_dataset
    from artipg_dsl.run.output import Output

    program, folder = tmp_path / "chest.apg", tmp_path / "fitted"
    program.write_text(Path(CHEST).read_text())
    write_dataset(apg.sample(program, n=1).job, folder, Output.of(choose_formats("annotation"), Content()))
    one = {"object": 0, "name": "box", "source": "my box.obj", "verdict": "fits"}
    options = {"frame": {"up": "y", "front": "auto", "unit": "auto", "normalised": True}}
    (folder / "fit.json").write_text(json.dumps({"category": "Chest", "objects": [one], "options": options}))
    text = program.read_text()
    program.write_text(text.replace("1mm", "2mm", 1))
    assert program.read_text() != text
    code, _, err = apgc("bind", folder, "-o", tmp_path / "bound")
    assert code == 1 and "fitted with another text of Chest" in err and "digest" in err
    assert (
        f"fit again: apgc fit {program} " in err
        and f"chest.apg '{folder / 'my box.obj'}' --up=y --normalised --force -o {folder}" in err
    )
    (folder / "facts.json").write_text('{"box": {"knobs": 2}}')  # what is known of them is said again
    assert f"--facts={folder}/facts.json --force -o" in apgc("bind", folder, "-o", tmp_path / "bound")[2]
