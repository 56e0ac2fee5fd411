"""Mutants, samples, meshes and pictures wear details that ``apgc bind`` has written."""

from __future__ import annotations

import json
import shutil
from pathlib import Path

import numpy as np
import pytest

import artipg_dsl as apg
from artipg_dsl.cli.main import main

from .helpers import CHEST, Apgc, tree


def raise_surfaces(fitted: Path, folder: Path) -> Path:
    """The same fits, in a folder beside it, of files whose surface lies 8 mm off the structure."""
    from artipg_dsl.fit.sources import mark

    shutil.copytree(fitted, folder)
    for k in range(2):
        file, path = folder / f"chest{k}.npz", folder / "fits" / f"chest{k}.json"
        with np.load(file) as held:
            points, normals = held["points"], held["normals"]
        np.savez(file, points=points + 0.008 * normals, normals=normals)
        path.write_text(json.dumps(json.loads(path.read_text()) | {"file": mark(file)}))
    summary = json.loads((folder / "fit.json").read_text())
    for one in summary["objects"]:
        one["source"] = str(folder / Path(one["source"]).name)
    (folder / "fit.json").write_text(json.dumps(summary))
    return folder


def test_mutants_wear_details(apgc: Apgc, fitted: Path, tmp_path: Path) -> None:
    code, _, _ = apgc("bind", fitted, "-o", tmp_path / "bound", "--points", 500)
    assert code == 0
    asked = ("mutate", fitted, "-n", 2, "--ops", "cpa", "--points", 256, "--details", tmp_path / "bound", "-o")
    code, _, err = apgc(*asked, tmp_path / "mutants")
    assert code == 0 and "4 objects" in err
    with np.load(tmp_path / "mutants" / "points-00000.npz") as held:
        assert held["points"].shape == (4, 256, 3) and held["worn"].mean() > 0.6
        assert (held["real_label"][held["worn"]] == -1).all()  # the files have no labels
        assert held["completed"].dtype == bool and not (held["completed"] & ~held["worn"]).any()
    lines = (tmp_path / "mutants" / "annotation-00000.jsonl").read_text().splitlines()
    told = [json.loads(line)["details"] for line in lines]
    assert [one["donor"] for one in told] == ["chest0", "chest0", "chest1", "chest1"]
    assert all(0 < one["distance"] < 20 and one["worn"] > 0.8 for one in told)
    manifest = json.loads((tmp_path / "mutants" / "manifest.json").read_text())
    assert manifest["identity"]["details"]["strength"] == 1 and "worn" in manifest["arrays"]
    before = tree(tmp_path / "mutants")
    code, _, _ = apgc(*asked, tmp_path / "mutants", "--workers", 2)
    assert code == 0 and tree(tmp_path / "mutants") == before

    code, _, err = apgc(*asked[:-1], "--detail-strength", 0, "-o", tmp_path / "mutants")
    assert code == 1 and "other options: the details" in err
    code, _, err = apgc("mutate", fitted, "--details", fitted, "-o", tmp_path / "others")
    assert code == 1 and "is not a folder of details" in err


@pytest.fixture(scope="module")
def bound(fitted: Path, tmp_path_factory: pytest.TempPathFactory) -> Path:
    folder = tmp_path_factory.mktemp("bound")
    assert main(["bind", str(fitted), "-o", str(folder), "--points", "500"]) == 0
    return folder


@pytest.mark.parametrize(
    ("name", "value", "told"),
    [
        ("label", 7, "its arrays do not belong together"),
        ("u", 3.0, "its arrays do not belong together"),
        ("patch", 90, "are damaged: Chest has no such surfaces"),
        ("element_site", 900, "are damaged: Chest has no such surfaces"),
    ],
)
def test_edited_details(
    apgc: Apgc, fitted: Path, bound: Path, tmp_path: Path, name: str, value: float, told: str
) -> None:
    folder = tmp_path / "bound"
    shutil.copytree(bound, folder)
    with np.load(folder / "chest0.npz") as held:
        arrays = dict(held)
    arrays[name] = np.full_like(arrays[name], value)
    np.savez(folder / "chest0.npz", **arrays)
    code, _, err = apgc("mutate", fitted, "--details", folder, "--points", 64, "-o", tmp_path / "mutants")
    assert code == 1 and told in err and "bind the details again" in err


@pytest.mark.parametrize("change", [{"object": "0"}, {"object": None}, {"details": 4}, {"details": "gone.npz"}])
def test_edited_summaries_of_details(
    apgc: Apgc, fitted: Path, bound: Path, tmp_path: Path, change: dict[str, object]
) -> None:
    folder = tmp_path / "bound"
    shutil.copytree(bound, folder)
    summary = json.loads((folder / "bind.json").read_text())
    summary["objects"][0] |= change
    (folder / "bind.json").write_text(json.dumps(summary))
    code, _, err = apgc("mutate", fitted, "--details", folder, "--points", 64, "-o", tmp_path / "mutants")
    assert code == 1 and ("is not a folder of details" in err or "gone.npz cannot be read: No such file" in err)


def test_originals_without_details_are_told(apgc: Apgc, fitted: Path, bound: Path, tmp_path: Path) -> None:
    folder = tmp_path / "bound"
    shutil.copytree(bound, folder)
    summary = json.loads((folder / "bind.json").read_text())
    summary["objects"] = summary["objects"][:1]
    (folder / "bind.json").write_text(json.dumps(summary))
    code, _, err = apgc("mutate", fitted, "--details", folder, "--points", 64, "-o", tmp_path / "mutants")
    assert code == 0 and "has no details of 1 of 2 objects, of 1 for one: what is made of them is bare" in err


@pytest.mark.slow
def test_objects_wear_their_own_if_these_were_bound_to_their_values(
    apgc: Apgc, fitted: Path, bound: Path, tmp_path: Path
) -> None:
    """Points and meshes, of samples and of mutants, by one rule: numbers do not count, nor what a folder wore before."""
    lines = (fitted / "values.jsonl").read_text().splitlines()
    (tmp_path / "turned.jsonl").write_text("\n".join(reversed(lines)))
    drawn, own, turned = (tmp_path / name for name in ("drawn", "own", "turned"))
    sampled = ("sample", CHEST, "--points", 64, "--params")
    assert apgc("sample", CHEST, "-n", 2, "--seed", 5, "--points", 64, "-o", drawn)[0] == 0
    assert apgc(*sampled, fitted / "values.jsonl", "-o", own)[0] == 0
    assert apgc(*sampled, tmp_path / "turned.jsonl", "-o", turned)[0] == 0
    for folder, borrow in ((fitted, False), (own, False), (drawn, True), (turned, True)):
        out = tmp_path / f"mutants-{folder.name}"
        asked = ("--ops", "cpa", "--details", bound, "--points", 64, "-o", out)
        runs = [
            apgc("export", folder, "--format", "obj", "--details", bound, "-o", tmp_path / f"meshes-{folder.name}"),
            apgc("render", folder, "--tile", 48, "--details", bound, "-o", tmp_path / f"{folder.name}.png"),
            apgc("mutate", folder, *asked),
        ]
        assert [code for code, _, _ in runs] == [0, 0, 0]
        assert all(("which borrow them" in err) == borrow for _, _, err in runs)
        for made in (out, tmp_path / f"meshes-{folder.name}"):
            identity = json.loads((made / "manifest.json").read_text())["identity"]
            assert identity["details"].get("borrowed", False) == borrow
        points = apg.open_samples(folder).mutate("cpa").points(64, details=bound).position.astype(np.float32)
        with np.load(out / "points-00000.npz") as held:
            assert np.array_equal(held["points"], points)


@pytest.mark.slow
def test_objects_by_any_prior_borrow_details(apgc: Apgc, fitted: Path, tmp_path: Path) -> None:
    bound = tmp_path / "bound"
    assert apgc("bind", fitted, "-o", bound, "--points", 2048)[0] == 0
    prior = tmp_path / "prior.json"
    prior.write_text('{"draws": {"Chest": {"knobs": {"3": 1}}}}')
    asked = ("sample", CHEST, "-n", 3, "--points", 64, "--prior", prior, "--details", bound, "-o", tmp_path / "out")
    code, _, err = apgc(*asked)
    assert code == 0, err
    plain, worn = (apg.sample(CHEST, 3, prior=prior).points(64, **more) for more in ({}, {"details": bound}))
    assert not np.array_equal(plain.position, worn.position)
    with np.load(tmp_path / "out" / "points-00000.npz") as file:
        assert np.array_equal(file["points"], worn.position.astype(np.float32))


def test_samples_borrow_details(apgc: Apgc, fitted: Path, tmp_path: Path) -> None:
    bound = tmp_path / "bound"
    code, _, _ = apgc("bind", fitted, "-o", bound, "--points", 1500)
    assert code == 0
    asked = ("sample", CHEST, "-n", 5, "--points", 256, "--seed", 3, "-o")
    code, _, err = apgc(*asked, tmp_path / "out", "--details", bound)
    assert code == 0 and "5 objects" in err
    code, _, _ = apgc(*asked, tmp_path / "bare")
    assert code == 0
    with (
        np.load(tmp_path / "out" / "points-00000.npz") as held,
        np.load(tmp_path / "bare" / "points-00000.npz") as bare,
    ):
        assert held["worn"].mean() > 0.6 and held["real_label"].shape == (5, 256)
        moved = np.linalg.norm(held["points"] - bare["points"], axis=-1)
        assert (moved[~held["worn"]] == 0).all() and moved.max() > 0
        assert all(np.array_equal(held[name], bare[name]) for name in ("semantic", "instance", "patch", "u", "v"))
    lines = (tmp_path / "out" / "annotation-00000.jsonl").read_text().splitlines()
    told = [json.loads(line)["details"] for line in lines]
    assert {one["donor"] for one in told} == {"chest0", "chest1"}
    for one in told:
        assert one["worn"] == pytest.approx(sum(one["donors"].values()), abs=1e-3)
        assert one["donors"][one["donor"]] == max(one["donors"].values()) and 0 < one["distance"] < 50
    manifest = json.loads((tmp_path / "out" / "manifest.json").read_text())
    assert manifest["identity"]["details"]["borrowed"] is True and "real_label" in manifest["arrays"]

    before = tree(
        tmp_path / "out"
    )  # a second run completes, and any other number of processes or objects at a time writes the same
    (tmp_path / "out" / "points-00000.npz").unlink()
    code, _, _ = apgc(*asked, tmp_path / "out", "--details", bound, "--workers", 2)
    assert code == 0 and tree(tmp_path / "out") == before
    code, _, err = apgc(*asked, tmp_path / "out", "--details", bound, "--detail-strength", 0.5)
    assert code == 1 and "other options: the details" in err
    code, _, _ = apgc(
        "sample", CHEST, "--only", 4, "--points", 256, "--seed", 3, "--details", bound, "-o", tmp_path / "one"
    )
    with np.load(tmp_path / "out" / "points-00000.npz") as held, np.load(tmp_path / "one" / "points-00000.npz") as one:
        assert code == 0 and all(np.array_equal(held[name][4:], one[name]) for name in held.files)

    code, _, _ = apgc(
        "mutate", tmp_path / "out", "--ops", "cpa", "-o", tmp_path / "mutants"
    )  # they wear what their originals do
    lines = (tmp_path / "mutants" / "annotation-00000.jsonl").read_text().splitlines()
    assert code == 0 and [json.loads(line)["details"]["donor"] for line in lines] == [one["donor"] for one in told]
    code, _, err = apgc("export", tmp_path / "out", "--format", "shapenetpart", "-o", tmp_path / "parts")
    assert code == 2 and "which shapenetpart does not carry" in err


def test_python_borrows_the_same(apgc: Apgc, fitted: Path, tmp_path: Path) -> None:
    from artipg_dsl.loaders import Stream

    bound = tmp_path / "bound"
    assert apgc("bind", fitted, "-o", bound, "--points", 500)[0] == 0
    code, _, _ = apgc("sample", CHEST, "-n", 3, "--points", 64, "--details", bound, "-o", tmp_path / "out")
    samples = apg.sample(CHEST, n=3)
    samples.to(tmp_path / "same", points=64, details=bound)
    assert code == 0 and tree(tmp_path / "same") == tree(tmp_path / "out")
    points = samples.points(64, details=bound)
    with np.load(tmp_path / "out" / "points-00000.npz") as held:
        assert points.worn is not None and np.array_equal(points.worn >= 0, held["worn"])
        stream = Stream(CHEST, size=3, batch=3, points=64, details=bound)
        assert np.array_equal(stream.batch(0)["points"], held["points"])
        bare = Stream(CHEST, size=3, batch=3, points=64, details={CHEST: bound}, detail_strength=0.0)
        assert np.allclose(bare.batch(0)["points"], samples.points(64).position, atol=1e-6)
    with pytest.raises(apg.errors.UsageError, match="which cameras do not see|what a camera sees"):
        Stream(CHEST, "completion", size=3, details=bound)
    with pytest.raises(apg.errors.UsageError, match="details for Mug, which is not streamed"):
        Stream(CHEST, size=3, details={"Mug": bound})
    with pytest.raises(apg.errors.UsageError, match="strength of details is 2"):
        samples.points(64, details=bound, detail_strength=2)
    with pytest.raises(apg.errors.UsageError, match="worn by points and meshes"):
        samples.to(tmp_path / "other", "annotation", details=bound)


def test_what_cannot_be_borrowed(apgc: Apgc, fitted: Path, tmp_path: Path) -> None:
    bound, out = tmp_path / "bound", tmp_path / "out"
    assert apgc("bind", fitted, "-o", bound, "--points", 500)[0] == 0
    code, _, err = apgc("sample", CHEST, "--details", tmp_path / "none", "-o", out)
    assert code == 1 and "there is no folder" in err
    code, _, err = apgc("sample", "Mug", "--details", bound, "-o", out)
    assert code == 1 and "are of objects of Chest, not of Mug" in err and "apgc fit Mug" in err
    code, _, err = apgc("sample", CHEST, "--details", bound, "--detail-strength", 2, "-o", out)
    assert code == 2 and "2 is not between 0 and 1" in err
    code, _, err = apgc("sample", CHEST, "--detail-strength", 0.5, "-o", out)
    assert code == 2 and "add --details DIR" in err
    code, _, err = apgc("mutate", fitted, "--detail-strength", 0.5, "-o", out)
    assert code == 2 and "add --details DIR" in err
    code, _, err = apgc("sample", CHEST, "--details", bound, "--format", "tables", "-o", out)
    assert code == 2 and "add points or glb to --format" in err
    (bound / "chest0.npz").write_bytes(b"nothing")
    code, _, err = apgc("sample", CHEST, "--details", bound, "-o", out)
    assert code == 1 and "chest0.npz cannot be read" in err and not out.exists()


def test_meshes_wear_details(apgc: Apgc, fitted: Path, tmp_path: Path) -> None:
    bound, out = tmp_path / "bound", tmp_path / "out"
    assert apgc("bind", fitted, "-o", bound, "--points", 500)[0] == 0
    asked = ("mutate", fitted, "-n", 1, "--ops", "cpa", "--points", 64, "--details", bound, "-o", out)
    assert apgc(*asked)[0] == 0
    assert apgc("export", out, "--format", "urdf,glb")[0] == 0
    assert apgc("export", out, "--format", "urdf,glb", "--bare", "-o", tmp_path / "bare")[0] == 0
    worn, bare = (tree(folder / "objects" / "000001") for folder in (out, tmp_path / "bare"))
    solid = [name for name in worn if "collision" in name or name.startswith("object_physics")]
    assert solid and all(worn[name] == bare[name] for name in solid)  # what collides is the structure
    assert len(worn["object.glb"]) > 3 * len(bare["object.glb"])
    assert (
        b"<!-- the surface in details of real objects" in worn["object.urdf"] and b"details" not in bare["object.urdf"]
    )
    manifest = json.loads((out / "manifest.json").read_text())
    assert "in details of real objects" in manifest["surfaces"]["glb"]
    assert manifest["identity"]["details"]["folder"] == "../bound"

    code, _, err = apgc("export", out, "--format", "glb", "--bare", "--only", 0, "--force")
    assert code == 1 and "show the surface in details" in err  # the others would still wear them
    assert apgc("export", out, "--format", "glb", "--bare", "--force")[0] == 0
    assert tree(out / "objects" / "000001")["object.glb"] == bare["object.glb"]
    manifest = json.loads((out / "manifest.json").read_text())
    assert "the structure, without" in manifest["surfaces"]["glb"] and "in details" in manifest["surfaces"]["urdf"]
    for path in (out / "objects").glob("*/object.glb"):
        path.unlink()  # as after a run that failed: what none has is no other surface
    assert apgc("export", out, "--format", "glb")[0] == 0

    moved = tmp_path.with_name(
        f"{tmp_path.name}-moved"
    )  # both folders together, as deep as before; then the details elsewhere
    moved.mkdir()
    out.rename(moved / "out")
    bound.rename(moved / "bound")
    asked = ("export", moved / "out", "--format", "obj", "--force", "-o")
    assert apgc(*asked, tmp_path / "first")[0] == 0
    (moved / "bound").rename(tmp_path / "elsewhere")
    code, _, err = apgc(*asked, tmp_path / "second")
    assert code == 1 and "there is no folder" in err and "--details says where it is" in err
    assert apgc(*asked, tmp_path / "second", "--details", tmp_path / "elsewhere")[0] == 0
    assert tree(tmp_path / "first" / "objects") == tree(tmp_path / "second" / "objects")


@pytest.mark.slow
def test_pictures_wear_details(apgc: Apgc, fitted: Path, tmp_path: Path) -> None:
    fitted, bound = raise_surfaces(fitted, fitted.with_name(f"{tmp_path.name}-raised")), tmp_path / "bound"
    assert apgc("bind", fitted, "-o", bound, "--points", 3000)[0] == 0
    asked = ("render", fitted, "-n", 1, "--tile", 48, "-o")
    assert apgc(*asked, tmp_path / "worn.png", "--details", bound)[0] == 0
    assert apgc(*asked, tmp_path / "none.png", "--details", bound, "--detail-strength", 0)[0] == 0
    assert (tmp_path / "worn.png").read_bytes() != (tmp_path / "none.png").read_bytes()
    code, _, err = apgc(*asked, tmp_path / "other.png", "--details", bound, "--bare")
    assert code == 2 and "leave out --bare or --details" in err
    code, _, err = apgc("export", CHEST, "--format", "glb", "--detail-strength", 0.5, "-o", tmp_path / "out")
    assert code == 2 and "scales details" in err


@pytest.mark.slow
def test_fits_are_bound_from_anywhere_and_moved_with_their_files(
    apgc: Apgc, fitted: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    here, asked = tmp_path / "here", ("--points", 500)
    shutil.copytree(fitted, here / "fitted")
    (here / "scans").mkdir()
    for k in range(2):
        (here / "fitted" / f"chest{k}.npz").rename(here / "scans" / f"chest{k}.npz")
    monkeypatch.chdir(here)
    fit = ("fit", CHEST, "scans", "-o", "fitted", "--front", "x", "--plain", "--force")
    assert apgc(*fit)[0] == 0
    whole = tree(here / "fitted")
    summary = json.loads((here / "fitted" / "fit.json").read_text())
    assert [one["source"] for one in summary["objects"]] == ["../scans/chest0.npz", "../scans/chest1.npz"]
    monkeypatch.chdir(tmp_path)  # the same command from elsewhere
    again = [str(here / word) if word in ("scans", "fitted") else word for word in fit[:-1]]
    assert apgc(*again)[0] == 0 and tree(here / "fitted") == whole
    assert apgc("bind", "here/fitted", "-o", "here/bound", *asked)[0] == 0
    bound = tree(here / "bound")
    here.rename(tmp_path / "there")
    assert apgc("bind", "there/fitted", "-o", "there/bound", *asked, "--force")[0] == 0
    assert tree(tmp_path / "there" / "bound") == bound
    (tmp_path / "there" / "scans" / "chest0.npz").unlink()
    code, out, err = apgc("bind", "there/fitted", "-o", "there/again", *asked)
    assert code == 0 and "there is no file there/scans/chest0.npz" in out + err
