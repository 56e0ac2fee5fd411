"""Fitting, binding and mutating in Python: the values, arrays and bytes of the command line."""

from __future__ import annotations

import json
import pickle
import re
import shutil
import time
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from scipy.spatial import cKDTree

import artipg_dsl as apg
from artipg_dsl.cli.main import main
from artipg_dsl.errors import UsageError, UserError
from artipg_dsl.loaders import Stream
from artipg_dsl.run import fitting
from artipg_dsl.run import progress as lines
from tests.fit.helpers import BOARD

from .helpers import CHEST, tree

MANY = 3000  # points that details are bound by: enough for a surface that meshes can wear
MAP = {"Knob": "handle", "Lid": "door"}  # no object has a lid

pytestmark = pytest.mark.usefixtures("searched_once")


@pytest.fixture(scope="module")
def place(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """What the command line makes of two wavy chests and a file that is none: ``real``, ``fitted``, ``bound``, ``mutants``."""
    folder = tmp_path_factory.mktemp("place")
    real = folder / "real"
    real.mkdir()
    points = apg.sample(CHEST, n=2, seed=4).points(6000, surface="outside")
    for k in range(2):
        label = (points.semantic[k] == points.semantic[k].max()).astype(int)
        waves = 0.006 * np.cos(25.0 * points.position[k][:, 1:2] + 10.0 * points.position[k][:, 2:])
        arrays = {"points": points.position[k] + waves * points.normal[k], "normals": points.normal[k], "label": label}
        np.savez(real / f"chest{k}.npz", **arrays, label_names=["Box", "Knob"])
    (real / "broken.obj").write_text("f 1 2 3\n")
    (folder / "map.json").write_text(json.dumps(MAP))

    def run(*words: object) -> None:
        assert main([str(word) for word in words]) == 0

    fitted, bound = folder / "fitted", folder / "bound"
    run("fit", CHEST, real, "-o", fitted, "--front", "x", "--map", folder / "map.json", "--plain", "--seed", 2)
    run("bind", fitted, "-o", bound, "--points", MANY)
    asked = ("--ops", "cpa", "-n", 2, "--details", bound, "--points", 64)
    run("mutate", fitted, *asked, "-o", folder / "mutants")
    return folder


@pytest.fixture(scope="module")
def fitted(place: Path) -> apg.Fitted:
    """The first chest as arrays, then the folder."""
    with np.load(place / "real" / "chest0.npz") as held:
        arrays = dict(held)
    with pytest.warns(UserWarning, match="no object has a label `Lid`, as map says: their labels are `Box` and `Knob`"):
        return apg.fit_objects(CHEST, [arrays, place / "real"], front="x", map=MAP, seed=2)


@pytest.fixture(scope="module")
def bound(fitted: apg.Fitted) -> apg.Bound:
    return fitted.bind(MANY)


@pytest.fixture(scope="module")
def ours(place: Path) -> apg.Bound:
    """The details of the folder ``bound``, in memory."""
    return apg.open_fitted(place / "fitted").bind(MANY)


def placed(folder: Path) -> dict[str, bytes]:
    """What a folder holds, with the files of real objects as they are, not as seen from it."""

    def whole(found: re.Match[bytes]) -> bytes:
        return b'"source": "%s"' % str((folder / found[1].decode()).resolve()).encode()

    return {name: re.sub(rb'"source": "([^<"]*)"', whole, held) for name, held in tree(folder).items()}


def plain(record: dict[str, Any], *but: str) -> dict[str, Any]:
    return {key: value for key, value in record.items() if key not in ("file", "options", "object", *but)}


def test_records_are_those_of_the_command_line(place: Path, fitted: apg.Fitted) -> None:
    held, *records = fitted.records
    names = ["broken", "chest0", "chest1"]
    told = [plain(json.loads((place / "fitted" / "fits" / f"{name}.json").read_text())) for name in names]
    files = [str(place / "fitted" / one.pop("source")) for one in told]  # which are as seen from there
    assert [plain(record, "source") for record in records] == told
    assert all(Path(file).samefile(record["source"]) for file, record in zip(files, records, strict=True))
    assert plain(held, "name", "source") == plain(told[1], "name"), "arrays are fitted as a file of them"
    assert [one["object"] for one in fitted.records] == [0, None, 1, 2] and fitted.numbers.tolist() == [0, 1, 2]
    assert held["name"] == "object0" and repr(fitted) == "<Chest: 3 objects fitted, 1 not>"
    assert [one["name"] for one in fitted.summary["failed"]] == ["broken"] and fitted.summary["labels"] == [
        "Box",
        "Knob",
    ]


def test_what_is_known_of_an_object(place: Path, fitted: apg.Fitted, tmp_path: Path) -> None:
    original = apg.sample(CHEST, n=2, seed=4)
    for one in fitted:
        true = original.object(int(one.number == 2))
        assert one.verdict == "fits" and one.distance < 1.0 and one.lost == ""
        assert one.drawn == one.record["drawn"] and abs(one["width"][0] - true["width"][0]) < 0.02
        assert one.record["iou"]["handle"] > 0.5
        assert np.allclose(one.to_object, np.eye(4), atol=0.01) and one.posed().tolist() == [0.0]
        found = one.real()
        assert found.labels == ("Box", "Knob") and np.allclose(
            found.points.max(axis=0)[2], one.record["size"][2], atol=0.01
        )
    image = fitted.object(2).overlay(tmp_path / "chest.png", tile=48).read_bytes()
    assert image[:4] == b"\x89PNG" and "chest1, fits" in repr(fitted.object(2))
    one = fitted.object(0)
    moved = apg.FittedObject(one.job, {**one._record, "joints": {"open": 0.5}}, one._item)
    assert moved.posed().tolist() == [0.5] and one.mesh(moved.posed()).extents[2] > one.mesh().extents[2]
    with pytest.raises(UserError, match="there is no object 3: 3 were fitted"):
        fitted.object(3)


def test_folders_are_opened_and_saved(place: Path, fitted: apg.Fitted, tmp_path: Path) -> None:
    again = apg.open_fitted(place / "fitted")
    assert [one.name for one in again] == ["chest0", "chest1"] and again.records[2]["failed"]
    again.save(tmp_path / "same")
    assert placed(tmp_path / "same") == placed(place / "fitted")
    before = tree(tmp_path / "same")
    with pytest.raises(UserError, match="same holds other objects"):
        fitted.save(tmp_path / "same")
    again.save(tmp_path / "same")
    assert tree(tmp_path / "same") == before


@pytest.mark.slow
def test_what_was_fitted_from_memory_is_kept(
    fitted: apg.Fitted, bound: apg.Bound, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    fitted.save(tmp_path / "first")
    (tmp_path / "first").rename(tmp_path / "memory")
    opened = apg.open_fitted(tmp_path / "memory")
    assert [path.name for path in (tmp_path / "memory" / "kept").iterdir()] == ["object0.npz"]
    assert [one.record for one in opened] == [one.record for one in fitted]
    assert opened.summary == fitted.summary
    assert all(np.array_equal(a.real().points, b.real().points) for a, b in zip(opened, fitted, strict=True))
    overlays = [one.object(0).overlay(tmp_path / f"{k}.png", tile=48) for k, one in enumerate((opened, fitted))]
    assert overlays[0].read_bytes() == overlays[1].read_bytes()
    opened.save(tmp_path / "again")
    assert tree(tmp_path / "again") == tree(tmp_path / "memory")

    folders = {name: str(tmp_path / name) for name in ("memory", "python", "opened", "command")}
    bound.save(folders["python"])
    opened.bind(MANY).save(folders["opened"])
    asked = ["bind", folders["memory"], "-o", folders["command"], "--points", str(MANY)]
    assert main(asked) == 0
    assert tree(tmp_path / "python") == tree(tmp_path / "opened") == tree(tmp_path / "command")
    assert main(["bind", folders["memory"], folders["memory"] + "/kept", *asked[2:], "--force"]) == 0, "by its contents"
    capsys.readouterr()
    assert main(["fit", CHEST, str(tmp_path / "0.png"), "-o", folders["memory"]]) == 1
    assert "memory holds fits of" in capsys.readouterr().err, "arrays that nothing else keeps are not dropped unasked"
    (tmp_path / "memory" / "kept" / "object0.npz").unlink()
    with pytest.raises(UserError, match="there is no file .*object0.npz"):
        opened.object(0).real()


def test_arrays_that_have_changed_are_not_kept(place: Path, tmp_path: Path) -> None:
    with np.load(place / "real" / "chest0.npz") as held:
        points = held["points"].copy()
    fitted = apg.fit_objects(CHEST, {"mine": points}, front="x", at_rest=True)
    points += 1.0
    with pytest.raises(UserError, match="the arrays of mine have changed since they were fitted"):
        fitted.save(tmp_path / "out")


@pytest.mark.slow
def test_what_is_known_is_as_on_the_command_line(place: Path, tmp_path: Path) -> None:
    chests = {name: place / "real" / f"{name}.npz" for name in ("chest0", "chest1")}
    facts = {"chest0": {"knobs": np.int64(3)}, "chest1": {"knobs": "1 .. 2", "wood": "oak"}}
    fitted = apg.fit_objects(CHEST, chests, front="x", set={"wood": "pine"}, facts=facts, folder=tmp_path / "ours")
    drawn = [one.drawn for one in fitted]
    assert [(one["knobs"], one["wood"]) for one in drawn] in ([(3, "pine"), (k, "oak")] for k in (1, 2))
    assert fitted.object(0).record["facts"] == {"wood": "pine", "knobs": 3}
    known = tmp_path / "ours" / "facts.json"
    asked = ["fit", CHEST, str(place / "real"), "--front", "x", "--plain", "--facts", str(known)]
    assert main([*asked, "-o", str(tmp_path / "theirs")]) == 0
    told = [json.loads((tmp_path / name / "fits" / "chest0.json").read_text()) for name in ("ours", "theirs")]
    assert told[0]["drawn"] == told[1]["drawn"] and told[0]["facts"] == told[1]["facts"]
    fitted.save(tmp_path / "saved")
    assert apg.open_fitted(tmp_path / "saved").object(1).record["facts"] == facts["chest1"]
    assert (tmp_path / "saved" / "facts.json").read_bytes() == known.read_bytes()


def test_details_are_those_of_the_command_line(
    place: Path, fitted: apg.Fitted, bound: apg.Bound, tmp_path: Path
) -> None:
    assert bound.numbers.tolist() == [0, 1, 2] and repr(bound) == "<Chest: details of 3 objects>"
    with np.load(place / "bound" / "chest0.npz") as held:
        arrays = bound.arrays(0)
        assert all(np.array_equal(arrays[name], held[name]) for name in held.files if name != "name")
    same = apg.open_fitted(place / "fitted").bind(MANY)
    same.save(tmp_path / "bound")
    assert placed(tmp_path / "bound") == placed(place / "bound")
    with pytest.raises(UserError, match="bound holds other objects"):
        bound.save(tmp_path / "bound")
    assert same.summary == json.loads((place / "bound" / "bind.json").read_text())


def test_what_is_told_can_be_changed_without_harm(fitted: apg.Fitted, bound: apg.Bound) -> None:
    fitted.records[0]["distance"].clear()
    fitted.object(0).record["drawn"].clear()
    fitted.summary["options"].clear()
    bound.summary["objects"].clear()
    bound.arrays(0)["offset"][:] = 0.0
    assert fitted.object(0).record["drawn"] and fitted.object(0).distance > 0.0 and fitted.summary["options"]
    assert bound.summary["objects"] and bound.arrays(0)["offset"].any()


def test_bound_points(fitted: apg.Fitted, bound: apg.Bound) -> None:
    points, one = bound.points(1), fitted.object(1)
    assert len(points) == bound.summary["objects"][1]["points"] and points.labels == ("Box", "Knob")
    real = one.real()
    apart = cKDTree(real.points).query(points.real)[0]
    assert np.median(apart[points.how == 0]) < 1e-6, "what is bound are points of the real surface"
    assert (np.sqrt(((points.position - points.real) ** 2).sum(axis=1)) < 0.08).all()
    assert set(points.label.tolist()) <= {-1, 0, 1} and "labels" in repr(points)
    with pytest.raises(UserError, match="there are no details of object 7 .there are those of 0, 1, 2"):
        bound.points(7)


@pytest.mark.slow
def test_mutants_wear_their_own(place: Path, bound: apg.Bound, fitted: apg.Fitted, tmp_path: Path) -> None:
    again = apg.open_fitted(place / "fitted")
    mutants, details = again.mutate("cpa", n=2), again.bind(MANY)
    assert mutants.numbers.tolist() == [0, 1, 2, 3]
    points = mutants.points(64, details=details)
    with np.load(place / "mutants" / "points-00000.npz") as held:
        assert np.array_equal(points.position.astype(np.float32), held["points"])
        assert points.worn is not None and np.array_equal(points.worn >= 0, held["worn"])
    for others, worn in (
        (mutants, place / "bound"),
        (apg.open_samples(place / "mutants"), details),
        (apg.open_samples(place / "mutants"), place / "bound"),
    ):
        assert np.array_equal(others.points(64, details=worn).position, points.position)
    half = mutants.points(64, details=details, detail_strength=0.5).position
    assert not np.array_equal(half, points.position)
    assert np.abs(half - (points.position + mutants.points(64).position) / 2).max() < 0.01
    out = tmp_path / "out"
    for _ in range(2):  # the second time all is there
        mutants.to(out, "points,annotation", points=64, details=details)
    assert placed(out / "details") == placed(place / "bound") and details.folder is None
    for name in ("points-00000.npz", "annotation-00000.jsonl"):
        assert (out / name).read_bytes() == (place / "mutants" / name).read_bytes()
    details_then = tree(out / "details")
    out.rename(tmp_path / "moved")
    assert main(["export", str(tmp_path / "moved"), "--format", "obj"]) == 0, "it has all that its meshes wear"
    with pytest.raises(UserError, match="details holds other objects"):
        mutants.to(tmp_path / "moved", "points,annotation", points=64, details=again.bind(300))
    assert tree(tmp_path / "moved" / "details") == details_then, "what is refused writes nothing"
    details.save(tmp_path / "bound")
    mutants.to(tmp_path / "named", "points,annotation", points=64, details=details)
    assert not (tmp_path / "named" / "details").exists()
    shutil.rmtree(tmp_path / "bound")
    mutants.to(tmp_path / "gone", "points,annotation", points=64, details=details)
    assert placed(tmp_path / "gone" / "details") == placed(place / "bound"), "a folder that is gone is none"
    with pytest.raises(UsageError, match="in no folder of this machine"):
        mutants.to("memory://out", points=64, details=again.bind(300))


def test_objects_of_the_fitted_values_wear_their_own(place: Path, tmp_path: Path) -> None:
    values, bound = place / "fitted" / "values.jsonl", place / "bound"
    asked = [
        "sample",
        CHEST,
        "--params",
        values,
        "--details",
        bound,
        "--points",
        64,
        "--seed",
        2,
        "-o",
        tmp_path / "out",
    ]
    assert main([str(word) for word in asked]) == 0
    samples = apg.sample(CHEST, values=values, seed=2)
    samples.to(tmp_path / "same", points=64, details=bound)
    assert tree(tmp_path / "same") == tree(tmp_path / "out")
    assert np.array_equal(
        samples.points(64, details=bound).position, apg.open_fitted(place / "fitted").points(64, details=bound).position
    )
    donors = [
        json.loads(line)["details"] for line in (tmp_path / "out" / "annotation-00000.jsonl").read_text().splitlines()
    ]
    assert [one["donor"] for one in donors] == ["chest0", "chest1"] and not any("donors" in one for one in donors)


def test_others_borrow(place: Path, ours: apg.Bound, tmp_path: Path) -> None:
    samples = apg.sample(CHEST, n=2, seed=9)
    first, second = (samples.points(64, details=worn) for worn in (ours, place / "bound"))
    assert np.array_equal(first.position, second.position) and first.worn is not None and (first.worn >= 0).any()
    assert np.array_equal(samples.object(1).points(64, details=ours).position[0], first.position[1])
    bare, worn = samples.object(0).mesh(), samples.object(0).mesh(details=ours)
    assert bare.geometry.keys() == worn.geometry.keys() and len(worn.triangles) > len(bare.triangles)
    samples.export(tmp_path / "objects", "obj", details=ours)
    samples.sheet(tmp_path / "sheet.png", details=ours, tile=48)
    with pytest.raises(UserError, match="the details in memory are of objects of Chest, not of Board"):
        apg.load(BOARD).points(8, details=ours)


@pytest.mark.slow
def test_files_that_have_moved_are_named(place: Path, fitted: apg.Fitted, tmp_path: Path) -> None:
    real = tmp_path / "real"
    real.mkdir()
    chest = (place / "real" / "chest0.npz").read_bytes()
    (real / "mine.npz").write_bytes(chest)
    apg.fit_objects(CHEST, real, front="x", at_rest=True, folder=tmp_path / "fitted")
    real.rename(tmp_path / "moved")
    with pytest.raises(UserError, match="there is no file .*mine.npz .if it has moved, name it"):
        apg.open_fitted(tmp_path / "fitted").object(0).real()
    again = apg.open_fitted(tmp_path / "fitted", tmp_path / "moved")
    assert len(again.object(0).real().points) > 1000 and again.bind(300).summary["objects"]
    with pytest.raises(UserError, match="none of these was fitted"):
        apg.open_fitted(tmp_path / "fitted", place / "real" / "chest1.npz")


def test_each_kind_of_folder_is_its_own(
    place: Path, fitted: apg.Fitted, bound: apg.Bound, capsys: pytest.CaptureFixture[str]
) -> None:
    for folder, told in (("fitted", "fitted holds fitted objects"), ("mutants", "mutants holds samples")):
        with pytest.raises(UserError, match=told):
            bound.save(place / folder)
        with pytest.raises(UserError, match=told):
            fitted.bind(300, folder=place / folder)
        assert main(["bind", str(place / "fitted"), "-o", str(place / folder)]) == 1
        assert told in capsys.readouterr().err
    with pytest.raises(UserError, match="bound holds details"):
        fitted.save(place / "bound")
    assert main(["mutate", str(place / "bound"), "-o", str(place / "none")]) == 1
    assert f"objects wear them: apgc mutate FITTED --details {place / 'bound'}" in capsys.readouterr().err
    with pytest.raises(UserError, match="there is no folder .*gone of fitted objects"):
        apg.open_fitted(place / "gone")
    for details in (fitted, 3):
        with pytest.raises(UsageError, match="details is .*or what `bind` of fitted objects gives"):
            fitted.points(64, details=details)  # type: ignore[arg-type]


def test_long_work_tells_how_far_it_is_and_goes_on(
    place: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    with np.load(place / "real" / "chest1.npz") as held:
        chest = {"points": held["points"], "normals": held["normals"]}
    real: dict[str, Any] = {f"none{k}": np.full((9, 3), float(k)) for k in range(6)} | {"chest": chest}
    heard: list[tuple[int, int]] = []

    def ended(done: int, total: int) -> None:
        heard.append((done, total))
        if done == 6:
            raise KeyboardInterrupt

    with pytest.raises(KeyboardInterrupt):
        apg.fit_objects(CHEST, real, front="x", folder=tmp_path / "fitted", progress=ended)
    assert heard == [(0, 7), (6, 7)]
    heard.clear()
    fitted = apg.fit_objects(
        CHEST, real, front="x", folder=tmp_path / "fitted", progress=lambda *told: heard.append(told)
    )
    assert heard == [(6, 7), (7, 7)], "what was done is there"
    monkeypatch.setattr(lines, "SELDOM", 0.01)  # seconds between lines
    search = fitting.fit

    def slowly(*args: Any, doing: Callable[[str], None], **asked: Any) -> Any:
        doing("1 object: choices and numbers")
        time.sleep(0.2)
        return search(*args, doing=doing, **asked)

    monkeypatch.setattr(fitting, "fit", slowly)
    plain = apg.fit_objects(CHEST, real, front="x", workers=1, progress=True)
    said = capsys.readouterr().err
    assert "Chest: fitting 1 object: choices and numbers [####" in said
    assert plain.records == fitted.records
    plain.save(tmp_path / "same")
    assert tree(tmp_path / "same") == tree(tmp_path / "fitted")

    heard.clear()
    bound = fitted.bind(300, folder=tmp_path / "bound", progress=lambda *told: heard.append(told))
    again = fitted.bind(300, folder=tmp_path / "bound", progress=lambda *told: heard.append(told))
    assert heard == [(0, 1), (1, 1), (1, 1)] and bound.folder == tmp_path / "bound"
    memory = plain.bind(300)
    memory.save(tmp_path / "saved")
    assert tree(tmp_path / "saved") == tree(tmp_path / "bound") and memory.summary == again.summary
    assert all(np.array_equal(again.arrays(0)[key], array) for key, array in memory.arrays(0).items())
    with pytest.raises(UserError, match="fitted holds fits of .*chest.npz"):
        apg.fit_objects(CHEST, {"chest": chest["points"] * 1.1}, folder=tmp_path / "fitted")
    with pytest.raises(UserError, match="bound holds details of chest, fitted from memory"):
        apg.open_fitted(place / "fitted").bind(300, folder=tmp_path / "bound")
    for progress in ("yes", 1, None):
        with pytest.raises(UsageError, match="progress is .*give True for a line on stderr, or a function"):
            apg.fit_objects(CHEST, real, progress=progress)  # type: ignore[arg-type]


def test_streams_borrow_what_is_in_memory(place: Path, ours: apg.Bound) -> None:
    streams = [Stream(CHEST, size=4, batch=2, points=64, seed=9, details=worn) for worn in (ours, place / "bound")]
    other = pickle.loads(pickle.dumps(streams[0]))  # as it goes to workers
    for k in range(2):
        here, theirs, there = (stream.batch(k) for stream in (*streams, other))
        assert all(np.array_equal(here[name], theirs[name]) for name in theirs)
        assert all(np.array_equal(here[name], there[name]) for name in there)
    bare = Stream(CHEST, size=4, batch=2, points=64, seed=9).batch(1)
    assert not np.array_equal(bare["points"], here["points"])
    with pytest.raises(UserError, match="the details in memory are of objects of Chest, not of Microwave"):
        Stream("Microwave", details={"Microwave": ours})
    with pytest.raises(UsageError, match="details is 3"):
        Stream(CHEST, details=3)  # type: ignore[arg-type]


def test_what_is_wrong_is_told(place: Path, fitted: apg.Fitted) -> None:
    chest = place / "real" / "chest0.npz"
    for arguments, told in (
        ({"up": "zz"}, "up is 'zz'"),
        ({"up": "z", "front": "-z"}, "they lie on one axis"),
        ({"unit": "cm", "normalised": True}, "objects without a scale have no unit"),
        ({"normalised": "no"}, "normalised is 'no'"),
        ({"map": {"Knob": "handel"}}, "no word of `semantic`"),
        ({"map": ["Knob"]}, "map is"),
        ({"set": ["knobs"]}, "set is"),
        ({"set": {"knobs": 9}}, "what is set: `knobs` cannot be 9"),
        ({"facts": ["knobs"]}, "facts is \\['knobs'\\]"),
        ({"facts": {"chest0": {"wood": "elm"}}}, "facts: chest0: `wood` cannot be `elm`"),
        ({"workers": 0}, "workers is 0"),
        ({"seed": 0.5}, "seed is 0.5"),
        ({"checked": 3}, "checked is 3"),
    ):
        with pytest.raises(UsageError, match=told):
            apg.fit_objects(CHEST, chest, **arguments)  # type: ignore[arg-type]
    with pytest.raises(UsageError, match="a category is a name or a file, not 3"):
        apg.fit_objects(3, chest)  # type: ignore[arg-type]
    with pytest.raises(apg.NothingFits, match="object0 was not fitted") as caught:
        apg.fit_objects(CHEST, np.zeros((3, 3)))
    assert "too few to see a shape" in str(caught.value) and caught.value.records[0]["name"] == "object0"
    for ask, told in (
        (lambda: fitted.bind(assignment="mutal"), "there is no assignment 'mutal' .did you mean `mutual`"),
        (lambda: fitted.bind(0), "points is 0"),
        (lambda: fitted.mutate(n=0), "n is 0"),
        (lambda: fitted.save(3), "a folder is named by"),
        (lambda: fitted.object(0).overlay("chest.jpg"), "written as PNG"),
        (lambda: apg.open_fitted(""), "the name of a folder is empty"),
    ):
        with pytest.raises(UsageError, match=told):
            ask()  # type: ignore[no-untyped-call]
    with pytest.raises(UserError, match="is not a folder of fitted objects"):
        apg.open_fitted(place / "real")


@pytest.mark.slow
def test_several_processes_give_the_same(place: Path) -> None:
    fitted = apg.open_fitted(place / "fitted")
    one, two = (fitted.bind(300, workers=workers) for workers in (1, 2))
    assert one.summary == two.summary and all(
        np.array_equal(one.arrays(1)[key], two.arrays(1)[key]) for key in one.arrays(1)
    )
    with pytest.raises(apg.NothingFits, match="none of 7 objects was fitted") as caught:
        apg.fit_objects(CHEST, [np.full((9, 3), float(k)) for k in range(7)], workers=2)
    assert [record["name"] for record in caught.value.records] == [f"object{k}" for k in range(7)]


def test_samples_beside_real_objects(place: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    out, labels = tmp_path / "own.json", {"Box": "body", "Knob": "handle"}
    (tmp_path / "map.json").write_text(json.dumps(labels))
    asked = ["compare", CHEST, place / "real", "-n", 24, "--front", "x", "--map", tmp_path / "map.json"]
    assert main([str(word) for word in [*asked, "--json", "--prior-out", out]]) == 0
    told = json.loads(capsys.readouterr().out)
    found = apg.sample(CHEST, 24).compare(place / "real", front="x", map=labels)
    assert found.likeness.matching == told["matching"] and found.likeness.back == told["back"]
    assert [one["distance"] for one in told["real"]] == found.likeness.nearest.tolist()
    assert found.names == ["chest0", "chest1"] and "broken.obj" in found.failed["broken"]
    assert repr(found).startswith("<Chest: 24 samples beside 2 real objects")
    assert found.presence().draws == json.loads(out.read_text())["draws"]["Chest"]
    assert found.presence().unmatched == json.loads(out.read_text())["unmatched"]["Chest"]
    with pytest.raises(UserError, match="none of the real objects could be read .object0 has 3 points"):
        apg.sample(CHEST, 24).compare(np.zeros((3, 3)))
