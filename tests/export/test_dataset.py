"""Folders of samples: shards, manifest, completion of what is missing, refusal of what does not belong together."""

from __future__ import annotations

import json
import os
import subprocess
import sys
from pathlib import Path
from types import SimpleNamespace

import numpy as np
import pytest

from artipg_dsl.annotate.sampling import Sampling
from artipg_dsl.export.containers import npz_bytes
from artipg_dsl.export.content import Content
from artipg_dsl.export.registry import FORMATS, choose_formats
from artipg_dsl.export.write import ExportError
from artipg_dsl.run import manifest
from artipg_dsl.run.dataset import write_dataset
from artipg_dsl.run.output import Output
from artipg_dsl.run.request import Request
from artipg_dsl.run.schema import expand, to_runs
from artipg_dsl.sampling.statistics import Statistics

from .fake_batch import FakeBatch

COUNTS = {"checked": True, "objects": 5, "first_valid": 5, "attempts": 5, "failed": {}}
SCRIPT = """
import sys, hashlib, tempfile, pathlib
from export.test_dataset import write, tree
with tempfile.TemporaryDirectory() as folder:
    out = pathlib.Path(folder) / "o"
    write(out, 5)
    for name, data in tree(out).items():
        print(name, hashlib.sha256(data).hexdigest())
"""


def sample(numbers: np.ndarray) -> FakeBatch:
    return FakeBatch(len(numbers), first=int(numbers[0]))


def write(  # type: ignore[no-untyped-def]
    out: Path,
    n: int = 5,
    formats: str = "points,urdf,glb",
    *,
    seed: int = 7,
    only: tuple[int, ...] | None = None,
    points: int = 64,
    shard: int = 2,
    sample=sample,
    counts=COUNTS,
    **options,
) -> dict:
    program = FakeBatch(1).program
    request = Request("Cupboard", seed, to_runs(only or range(n)), program=program.hash)
    output = Output(tuple(entry.name for entry in choose_formats(formats)), Content(Sampling(points)), shard)
    job = SimpleNamespace(program=program, request=request, batch=sample, counts=lambda: counts)
    job.statistics, job.tables, job.fresh = Statistics(), None, lambda: job
    return write_dataset(job, out, output, **options)  # type: ignore[arg-type]


def tree(out: Path) -> dict[str, bytes]:
    return {str(p.relative_to(out)): p.read_bytes() for p in sorted(out.rglob("*")) if p.is_file()}


def test_a_data_set_has_its_shards_objects_and_manifest(tmp_path: Path) -> None:
    heard: list[tuple[int, int]] = []
    write(tmp_path / "o", progress=lambda done, total: heard.append((done, total)))
    files = tree(tmp_path / "o")
    assert {"manifest.json", "points-00002.npz", "annotation-00000.jsonl"} <= set(files)
    assert {"objects/000004/object.urdf", "objects/000004/object.glb", "objects/000004/meshes/door_glass.obj"} <= set(
        files
    )
    assert heard[-1] == (5, 5) and heard == sorted(heard)
    assert not [name for name in files if "partial" in name]


def test_arrays_are_as_the_manifest_says(tmp_path: Path) -> None:
    write(tmp_path / "o", formats="points")
    described = json.loads((tmp_path / "o" / "manifest.json").read_text())
    with np.load(tmp_path / "o" / "points-00000.npz") as arrays:
        assert set(arrays.files) == set(described["arrays"])
        for name, array in arrays.items():
            entry = described["arrays"][name]
            assert array.dtype == entry["dtype"], name
            shape = entry["shape"].replace("objects", "2").split(", ")
            assert array.shape == tuple(map(int, shape)), name
        assert arrays["points"].shape == (2, 64, 3) and arrays["affordance.push"].any()
    assert described["vocabularies"]["semantic"] == ["unlabelled", "body", "door", "handle", "button", "grip"]
    assert described["vocabularies"]["affordance"] == ["pull", "push"]
    assert described["vocabularies"]["joints"] == ["open", "press"]
    assert described["identity"]["program"] == "f" * 64 and described["cpu"] and described["objects"] == 5


@pytest.mark.slow
def test_bytes_are_the_same_in_another_process_and_under_another_hash_seed(tmp_path: Path) -> None:
    def run(seed: str) -> str:
        environment = os.environ | {"PYTHONHASHSEED": seed}
        path = os.pathsep.join([str(Path(__file__).parents[1]), str(Path(__file__).parents[2])])
        environment["PYTHONPATH"] = path
        return subprocess.run(
            [sys.executable, "-c", SCRIPT], env=environment, check=True, capture_output=True, text=True
        ).stdout

    first = run("1")
    assert first.count("\n") > 20 and first == run("2")


def test_an_object_is_the_same_from_any_shard(tmp_path: Path) -> None:
    write(tmp_path / "a", 5)
    write(tmp_path / "b", 5, only=(3,), shard=10)
    one = tree(tmp_path / "b")
    all_ = tree(tmp_path / "a")
    assert {n for n in one if n.startswith("objects")} == {n for n in all_ if n.startswith("objects/000003")}
    assert all(all_[name] == data for name, data in one.items() if name.startswith("objects"))
    assert one["annotation-00000.jsonl"] == all_["annotation-00001.jsonl"].splitlines(keepends=True)[1]


def test_a_second_run_completes_what_is_missing_and_nothing_else(tmp_path: Path) -> None:
    write(tmp_path / "o")
    before = tree(tmp_path / "o")
    (tmp_path / "o" / "points-00001.npz").unlink()
    for path in (tmp_path / "o" / "objects" / "000004").rglob("*.*"):
        path.unlink()
    (tmp_path / "o" / "objects" / "000004" / "meshes").rmdir()
    (tmp_path / "o" / "objects" / "000004").rmdir()
    asked: list[int] = []

    def counted(numbers: np.ndarray) -> FakeBatch:
        asked.extend(numbers.tolist())
        return sample(numbers)

    write(tmp_path / "o", sample=counted)
    assert asked == [2, 3, 4] and tree(tmp_path / "o") == before
    write(tmp_path / "o", sample=counted)
    assert asked == [2, 3, 4]


def test_files_that_were_emptied_are_missing(tmp_path: Path) -> None:
    write(tmp_path / "o")
    before = tree(tmp_path / "o")
    for name in (
        "points-00001.npz",
        "annotation-00000.jsonl",
        "objects/000004/object.urdf",
        "objects/000000/object.glb",
    ):
        (tmp_path / "o" / name).write_bytes(b"")
    write(tmp_path / "o")
    assert tree(tmp_path / "o") == before


def test_an_interrupted_run_leaves_only_whole_things(tmp_path: Path) -> None:
    def interrupted(numbers: np.ndarray) -> FakeBatch:
        if numbers[-1] == 4:  # of the third shard, however many are made at a time: that is a matter of memory
            raise KeyboardInterrupt
        return sample(numbers)

    with pytest.raises(KeyboardInterrupt):
        write(tmp_path / "o", sample=interrupted)
    halfway = tree(tmp_path / "o")
    assert "points-00001.npz" in halfway and "points-00002.npz" not in halfway
    write(tmp_path / "o")
    write(tmp_path / "whole")
    assert tree(tmp_path / "o") == tree(tmp_path / "whole")


def test_other_options_are_refused_with_words_unless_forced(tmp_path: Path) -> None:
    write(tmp_path / "o", 5)
    (tmp_path / "o" / "notes.txt").write_text("mine")
    with pytest.raises(ExportError) as caught:
        write(tmp_path / "o", 5, seed=8)
    assert "the seed (7, now 8)" in caught.value.message and "--force" in caught.value.hint
    with pytest.raises(ExportError, match="the number of points"):
        write(tmp_path / "o", 5, points=32)
    write(tmp_path / "o", 2, formats="points", seed=8, force=True)
    assert set(tree(tmp_path / "o")) == {"manifest.json", "notes.txt", "points-00000.npz", "annotation-00000.jsonl"}
    assert manifest.read_manifest(tmp_path / "o")["identity"]["seed"] == 8  # type: ignore[index]


def test_a_folder_with_something_else_named_manifest_is_left_alone(tmp_path: Path) -> None:
    (tmp_path / "manifest.json").write_text("[]")
    with pytest.raises(ExportError, match="not a manifest"):
        write(tmp_path)
    (tmp_path / "manifest.json").write_text("{")
    with pytest.raises(ExportError, match="cannot read"):
        write(tmp_path)
    assert sorted(p.name for p in tmp_path.iterdir()) == ["manifest.json"]


def test_counts_of_the_run_reach_the_manifest(tmp_path: Path) -> None:
    counts = {
        "checked": True,
        "objects": 2,
        "first_valid": 1,
        "attempts": 2,
        "failed": {"too long": 1},
        "repaired": {"too long": 1},
    }
    assert write(tmp_path / "o", 2, counts=counts)["counts"] == counts
    assert manifest.read_manifest(tmp_path / "o")["counts"] == counts  # type: ignore[index]


def test_unknown_formats_list_the_known_ones() -> None:
    with pytest.raises(ExportError) as caught:
        choose_formats("points,stl")
    assert "'stl'" in caught.value.message and all(name in caught.value.hint for name in FORMATS)
    with pytest.raises(ExportError):
        choose_formats("")
    assert [f.name for f in choose_formats(None)] == ["points", "annotation"]
    assert [f.name for f in choose_formats(["glb", "urdf"])] == ["annotation", "urdf", "glb"]


def test_npz_is_plain_and_its_bytes_depend_on_the_contents_alone(tmp_path: Path) -> None:
    arrays = {"b": np.arange(6.0).reshape(2, 3).T, "a": np.array([True])}
    data = npz_bytes(arrays)
    assert data == npz_bytes(arrays)
    (tmp_path / "x.npz").write_bytes(data)
    with np.load(tmp_path / "x.npz") as loaded:
        assert loaded.files == ["b", "a"] and (loaded["b"] == arrays["b"]).all()


def test_spans_of_numbers() -> None:
    assert to_runs([0, 1, 2, 5, 7, 8]) == ((0, 2), (5, 5), (7, 8)) and to_runs([]) == ()
    assert expand(to_runs([0, 1, 2, 5, 7, 8])).tolist() == [0, 1, 2, 5, 7, 8] and expand(()).tolist() == []
