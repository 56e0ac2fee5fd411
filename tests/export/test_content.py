"""Shards of joint states, velocities and views: arrays as the manifest says, completed by a second run, told apart."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from artipg_dsl.annotate.annotation import annotate
from artipg_dsl.annotate.cameras import Cameras
from artipg_dsl.annotate.poses import part_poses
from artipg_dsl.annotate.sampling import Sampling
from artipg_dsl.annotate.states import joint_values, read_states
from artipg_dsl.export.content import SHARD, Content
from artipg_dsl.export.registry import choose_formats
from artipg_dsl.export.shards import point_arrays, view_arrays
from artipg_dsl.export.write import ExportError
from artipg_dsl.run.dataset import write_dataset
from artipg_dsl.run.job import prepare
from artipg_dsl.run.output import Output
from artipg_dsl.run.request import Request
from artipg_dsl.sampling.sample import Sampler
from artipg_dsl.session import Session

CAMERAS = Cameras(count=2, width=40, height=30, points=50)
STANDARD = Content()
CONTENT = Content(Sampling(32), read_states("rest,random:2"), motion=True, cameras=CAMERAS)
FORMATS = "points,views"


@pytest.fixture(scope="module")
def sampler() -> Sampler:
    return Session.of("Microwave").sampler


def write(
    sampler: Sampler, out: Path, content: Content = CONTENT, formats: str = FORMATS, n: int = 5
) -> dict[str, Any]:
    return write_dataset(
        prepare(sampler, Request("Microwave", 1, ((0, n - 1),))),
        out,
        Output(tuple(entry.name for entry in choose_formats(formats)), content, shard=3),
    )


@pytest.fixture(scope="module")
def written(sampler: Sampler, tmp_path_factory: pytest.TempPathFactory) -> Path:
    out = tmp_path_factory.mktemp("content") / "o"
    write(sampler, out)
    return out


@pytest.mark.parametrize("shard, key", [("points", "arrays"), ("views", "views")])
def test_arrays_are_as_the_manifest_says(written: Path, shard: str, key: str) -> None:
    described = json.loads((written / "manifest.json").read_text())[key]
    with np.load(written / f"{shard}-00000.npz") as arrays:
        assert set(arrays.files) == set(described)
        drivers = arrays["drivers"].shape[2] if "drivers" in arrays else 0
        sizes = {"objects": 3, "joints": arrays["state"].shape[2], "drivers": drivers}
        for name, array in arrays.items():
            shape = tuple(int(sizes.get(word, word)) for word in described[name]["shape"].split(", "))
            assert (str(array.dtype), array.shape) == (described[name]["dtype"], shape), name
            assert described[name]["text"]


def test_states_of_points_views_and_annotations_are_the_same(written: Path) -> None:
    lines = (written / "annotation-00000.jsonl").read_text().splitlines()
    with np.load(written / "points-00000.npz") as points, np.load(written / "views-00000.npz") as views:
        assert points["state"].tobytes() == views["state"].tobytes()
        for i, text in enumerate(lines):
            told = json.loads(text)
            assert len(told["states"]) == 3
            for k, state in enumerate(told["states"]):
                values = np.array([joint["value"] for joint in state["joints"]])
                assert values == pytest.approx(points["state"][i, k, : len(values)], abs=1e-9)
                assert [len(state[name]) for name in state] == [len(told[name]) for name in state]


def test_an_annotation_tells_what_is_elsewhere_in_each_state(sampler: Sampler) -> None:
    batch = sampler.batch(np.arange(3), seed=1)
    values = joint_values(batch, read_states("rest,open"))
    plain, told = annotate(batch), annotate(batch, values)
    poses, first = part_poses(batch, values[1]), np.searchsorted(batch.parts().owner, np.arange(3))
    for i in range(3):
        assert {k: v for k, v in told[i].items() if k != "states"} == plain[i]
        rest, open_ = told[i]["states"]
        for name, moved in (("parts", "center"), ("grasps", "point"), ("keypoints", "point"), ("joints", "origin")):
            assert [row[moved] for row in rest[name]] == [row[moved] for row in plain[i][name]], name
        door = next(k for k, part in enumerate(plain[i]["parts"]) if part["name"] == "door")
        assert open_["parts"][door]["center"] == pytest.approx(poses.center[first[i] + door], abs=1e-8)
        assert open_["parts"][door]["center"] != rest["parts"][door]["center"]
        for k, grasp in enumerate(plain[i]["grasps"]):
            if grasp["link"] == "door":
                assert open_["grasps"][k]["point"] != rest["grasps"][k]["point"]


def test_an_object_is_the_same_alone(sampler: Sampler) -> None:
    several, alone = sampler.batch(np.arange(4), seed=1), sampler.batch(np.array([2]), seed=1)
    for make in (
        lambda b: point_arrays(b, 32, CONTENT.states, True),
        lambda b: view_arrays(b, CAMERAS, CONTENT.states),
    ):
        mine, theirs = make(alone), make(several)
        for name, array in mine.items():
            other = theirs[name][2]
            other = other[:, : array.shape[2]] if name == "state" else other  # padded to the most joints of a shard
            assert array[0].tobytes() == np.ascontiguousarray(other).tobytes(), name


def test_a_second_run_completes_the_same_bytes(sampler: Sampler, written: Path) -> None:
    path = written / "views-00001.npz"
    before = path.read_bytes()
    path.unlink()
    write(sampler, written)
    assert path.read_bytes() == before


@pytest.mark.parametrize(
    "content, message",
    [
        (Content(Sampling(32), read_states("open"), True, CAMERAS), "the joint states (rest,random:2, now open)"),
        (Content(Sampling(32), CONTENT.states, False, CAMERAS), "velocities of points (True, now False)"),
        (Content(Sampling(32), CONTENT.states, True, Cameras(count=3, width=40, height=30, points=50)), "the cameras"),
    ],
)
def test_other_contents_are_refused(sampler: Sampler, written: Path, content: Content, message: str) -> None:
    with pytest.raises(ExportError) as caught:
        write(sampler, written, content)
    assert message in caught.value.message


def test_cameras_count_only_where_views_are_written(sampler: Sampler, tmp_path: Path) -> None:
    one = write(sampler, tmp_path / "o", CONTENT, "points", n=1)
    assert one["identity"]["views"] is None and "views" not in one
    assert not list((tmp_path / "o").glob("views*"))
    assert write(sampler, tmp_path / "p", STANDARD, "points", n=1)["arrays"].keys().isdisjoint(("motion", "state"))


def test_shards_of_images_stay_handy() -> None:
    assert STANDARD.shard_size() == SHARD == Content(states=read_states("random:9")).shard_size()
    assert Content(cameras=Cameras()).shard_size() == 16
    assert Content(cameras=Cameras(count=1000, width=4000, height=4000)).shard_size() == 1
    assert [f.name for f in choose_formats(None, views=True)] == ["points", "annotation", "views"]
