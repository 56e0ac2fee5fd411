"""What is drawn and what is written: every field reaches the manifest and comes back from it, and nothing else does."""

from __future__ import annotations

import copy
import json
from collections.abc import Iterator
from dataclasses import MISSING, Field, fields, replace
from pathlib import Path
from typing import Any, get_type_hints

import pytest

from artipg_dsl.annotate.cameras import Cameras
from artipg_dsl.annotate.gripper import Gripper
from artipg_dsl.annotate.sampling import Sampling
from artipg_dsl.annotate.states import read_states
from artipg_dsl.details.dressing import Dressing
from artipg_dsl.errors import UsageError
from artipg_dsl.export.content import Content
from artipg_dsl.export.write import ExportError
from artipg_dsl.geometry.resolution import Resolution
from artipg_dsl.graph.program import Program
from artipg_dsl.run import manifest as manifests
from artipg_dsl.run.manifest import Identity, Manifest, build_manifest, describe_difference, read_manifest
from artipg_dsl.run.output import Output, Written, read_content
from artipg_dsl.run.prior import Prior
from artipg_dsl.run.request import Drawn, Made, Request, read_numbers, read_request, read_sampling
from artipg_dsl.run.schema import expand, read_titles, to_runs
from artipg_dsl.sampling.mutation import Mutation
from artipg_dsl.sampling.trace import Replay
from artipg_dsl.session import Session

BOX = """apg 1
use primitives { Cuboid }
category Box {
  param width : length in 10cm .. 20cm
  root part body : Cuboid(size = [width, width, width])
}
"""
MUTATION = Mutation(("cpa",), 3, 0.25, 0.75, "width", True, 2, ((1, 2), (4, 4)), True)
FORMATS = ("points", "annotation", "views")

# of every field, what it is not by default
DRAWN: dict[str, Any] = {
    "source": "Chair",
    "seed": 11,
    "numbers": ((0, 3), (7, 7)),
    "settings": {"width": 0.125, "legs": 4, "back": "Slats"},
    "checked": False,
    "candidates": 48,
    "repair": True,
    "values": ({"width": 0.5, "legs": [1, None]}, {}),
    "mutations": (MUTATION,),
    "program": "a" * 32,
    "prior": Prior({"width": [0.1, 0.15], "tray": 0.23}),
    "turned": -90,
}
CONTENT: dict[str, Any] = {
    "points": Sampling(64, "outside", "blue", "object", "link", (("base", 2.0), ("door", 0.5))),
    "states": read_states("rest,random:3"),
    "motion": True,
    "cameras": Cameras(count=2, width=40, height=30, points=50),
    "gripper": Gripper(stroke=0.1),
    "resolution": Resolution(tolerance=0.001, triangles=5000),
    "details": Dressing("bound", "0123456789abcdef", 0.5, True),
}
SAMPLING: dict[str, Any] = {
    "count": 65,
    "surface": "outside",
    "spread": "blue",
    "per": "link",
    "balance": "semantic",
    "weights": (("door", 3.0),),
}
WRITTEN: dict[str, Any] = {"formats": ("annotation", "glb"), "content": Content(**CONTENT), "shard": 17}


@pytest.fixture(scope="module")
def program() -> Program:
    return Session.of_text(BOX).sampler.program


def usual(field: Field[Any]) -> Any:
    return field.default_factory() if field.default_factory is not MISSING else field.default


def through(program: Program, request: Request, output: Output, folder: Path) -> Manifest:
    """The manifest as it is read again from a folder."""
    folder.mkdir(exist_ok=True)
    (folder / manifests.NAME).write_bytes(manifests.to_text(build_manifest(program, request, output, out=folder)))
    found = read_manifest(folder)
    assert found is not None
    return found


@pytest.mark.parametrize("name", [field.name for field in fields(Request)])
def test_every_field_of_a_request_comes_back(program: Program, tmp_path: Path, name: str) -> None:
    plain = Request("Microwave")
    changed = replace(plain, **{name: DRAWN[name]})
    before, found = (through(program, request, Output(FORMATS), tmp_path / "o") for request in (plain, changed))
    assert found != before, f"{name} does not reach the manifest"
    assert Request.from_manifest(found["identity"], found["source"], tmp_path / "o") == changed


@pytest.mark.parametrize("name", [field.name for field in fields(Output)])
def test_every_field_of_an_output_comes_back(program: Program, tmp_path: Path, name: str) -> None:
    plain = Output(FORMATS)
    changed = replace(plain, **{name: WRITTEN[name]})
    before, found = (through(program, Request("Box"), output, tmp_path / "o") for output in (plain, changed))
    assert found["identity"] != before["identity"], f"{name} does not reach the manifest"
    assert Output.from_manifest(found["identity"]) == changed


CASES = [
    *((field.name, {field.name: CONTENT[field.name]}) for field in fields(Content)),
    *(
        (
            f"points.{field.name}",
            {
                "points": Sampling(
                    **{field.name: SAMPLING[field.name]} | ({"balance": "semantic"} if field.name == "weights" else {})
                )
            },
        )
        for field in fields(Sampling)
    ),
    ("gripper: any", {"gripper": None}),
]


@pytest.mark.parametrize(("name", "content"), CASES, ids=[name for name, _ in CASES])
def test_every_field_of_what_files_hold_comes_back(
    program: Program, tmp_path: Path, name: str, content: dict[str, Any]
) -> None:
    plain, changed = Output(FORMATS), Output(FORMATS, Content(**content))
    before, found = (through(program, Request("Box"), output, tmp_path / "o") for output in (plain, changed))
    assert found["identity"] != before["identity"], f"{name} does not reach the manifest"
    assert Output.from_manifest(found["identity"]).content == changed.content


@pytest.mark.parametrize("field", fields(Resolution), ids=lambda field: field.name)
def test_every_field_of_a_resolution_comes_back(program: Program, tmp_path: Path, field: Field[Any]) -> None:
    fine = Resolution(**{field.name: {"steps": 48, "tolerance": 0.002, "triangles": 900}[field.name]})
    found = through(program, Request("Box"), Output(FORMATS, Content(resolution=fine)), tmp_path / "o")
    assert found["identity"]["meshes"] and Output.from_manifest(found["identity"]).content.resolution == fine


def test_the_samples_above_differ_from_the_defaults_in_every_field() -> None:
    """Who adds a field says here what it may be, and the tests above tell whether it is written."""
    for record, samples in ((Request, DRAWN), (Output, WRITTEN), (Content, CONTENT), (Sampling, SAMPLING)):
        assert {field.name for field in fields(record)} == samples.keys(), record
        for field in fields(record):
            assert usual(field) is MISSING or samples[field.name] != usual(field), field.name


def test_a_replay_comes_back_with_its_traces(program: Program, tmp_path: Path) -> None:
    record: dict[str, Any] = {"object": 0, "source": 0, "steps": []}
    (tmp_path / "trace-00000.jsonl").write_text(json.dumps(record) + "\n", encoding="utf-8")
    request = Request("Box", mutations=(Replay({0: record}),))
    found = through(program, request, Output(FORMATS), tmp_path)
    again = Request.from_manifest(found["identity"], found["source"], tmp_path)
    assert isinstance(again.mutations[0], Replay) and again.mutations[0].plain() == request.mutations[0].plain()


# ---------------------------------------------------------------- the entries


def test_the_entries_are_those_of_the_two_records_and_the_versions(program: Program) -> None:
    """All keys of the schema are written by one of them, and no key by both."""
    drawn = set(get_type_hints(Drawn))
    written = set(get_type_hints(Written))
    assert not drawn & written
    assert drawn | written | {"artipg_dsl", "numpy"} == set(get_type_hints(Identity))
    full = replace(Output(FORMATS), content=Content(**CONTENT))
    found = build_manifest(program, Request(**DRAWN | {"repair": False}), full)
    assert list(found["identity"]) == list(get_type_hints(Identity)), "all of them, in the order of the file"
    assert list(found["identity"]["made"]) == list(get_type_hints(Made))


def entries(identity: Any) -> Iterator[tuple[tuple[str, ...], str]]:
    """The places of all entries that are compared, with their titles."""
    yield from (((key,), title) for key, title in read_titles(Identity).items())
    yield from ((("made", key), title) for key, title in read_titles(Made).items())


def test_every_entry_has_a_title_and_tells_two_runs_apart(program: Program) -> None:
    full = replace(Output(FORMATS), content=Content(**CONTENT))
    one = build_manifest(program, Request(**DRAWN | {"repair": False}), full)
    assert {place[0] for place, _ in entries(one)} == set(get_type_hints(Identity))
    assert {place[1] for place, _ in entries(one) if place[1:]} == set(get_type_hints(Made))
    assert describe_difference(one, copy.deepcopy(one)) is None
    for place, title in entries(one):
        other: Any = copy.deepcopy(one)
        inside = other["identity"] if len(place) == 1 else other["identity"]["made"]
        inside[place[-1]] = "something else"
        words = describe_difference(one, other)
        assert words is not None and words.startswith(title) and "something else" in words, place


@pytest.mark.parametrize(
    ("at", "words"),
    [
        ((), "the key 'sed' where no such key"),
        (("identity",), "identity: the key 'sed' where another key (did you mean `seed`?) is expected"),
        (("identity", "made"), "identity.made: the key 'sed' where no such key is expected"),
        (("identity", "gripper"), "identity.gripper: an object where the measures stroke, length,"),
        (("identity", "meshes"), "identity.meshes: the key 'sed' where no such key is expected"),
        (("identity", "views"), "identity.views"),
    ],
)
def test_an_unknown_key_is_refused(program: Program, tmp_path: Path, at: tuple[str, ...], words: str) -> None:
    whole: Any = build_manifest(program, Request("Box"), Output(FORMATS, Content(**CONTENT)))
    inside = whole
    for key in at:
        inside = inside[key]
    inside["sed"] = 1.0
    (tmp_path / manifests.NAME).write_bytes(manifests.to_text(whole))
    with pytest.raises(ExportError) as wrong:
        read_manifest(tmp_path)
    assert wrong.value.message.startswith(f"{tmp_path / manifests.NAME}: {words}"), wrong.value.message


# ---------------------------------------------------------------- made from words


def test_cameras_belong_to_views() -> None:
    assert Output(("points",), Content(cameras=Cameras(count=2))).content.cameras is None
    assert Output(("views",)).content.cameras == Cameras()


def test_numbers_are_runs() -> None:
    assert read_numbers(None, None) == ((0, 0),) and read_numbers(3, None) == ((0, 2),)
    assert read_numbers(None, [7, 5, 6, 2, 7]) == ((2, 2), (5, 7)) == to_runs([2, 5, 6, 7])
    assert expand(((2, 2), (5, 7))).tolist() == [2, 5, 6, 7]
    for n, numbers in ((0, None), (2.5, None), (1, [1]), (None, []), (None, [-1]), (None, [0.5])):
        with pytest.raises(UsageError):
            read_numbers(n, numbers)  # type: ignore[arg-type]


def test_sampling_is_a_number_of_candidates() -> None:
    assert [read_sampling(text) for text in ("sequential", "prior", "prior:16")] == [0, 32, 16]
    for text in ("", "prior:", "prior:1", "prior:0016", "prior:x", "sequential:3"):
        with pytest.raises(UsageError, match="unknown sampling"):
            read_sampling(text)


def test_the_words_of_the_command_line_and_the_values_of_python_make_the_same() -> None:
    words = read_content(weights="door=3", balance="link", views="2", gripper="stroke=10cm", tolerance=0.001)
    plain = read_content(
        weights={"door": 3}, balance="link", views={"views": 2}, gripper=Gripper(stroke=0.1), tolerance=0.001
    )
    assert words == plain and read_content() == Content()


def test_what_cannot_go_together_is_refused() -> None:
    with pytest.raises(UsageError, match="cannot follow the declared distributions"):
        Request("Box", candidates=32, repair=True)
    with pytest.raises(UsageError, match="it maps names to values"):
        read_request("Box", settings=["width=1cm"])  # type: ignore[arg-type]


def test_objects_given_by_their_values_are_numbered_from_0(tmp_path: Path) -> None:
    (tmp_path / "v.json").write_text('[{"width": 0.12}, {"width": null}]', encoding="utf-8")
    for values in (tmp_path / "v.json", [{"width": 0.12}, {"width": None}]):
        request = read_request("Box", values=values, repair=True)
        assert request.numbers == ((0, 1),) and request.values == ({"width": 0.12}, {"width": None})
        assert not request.repair  # they are repaired anyway
        assert read_request("Box", values=values, n=1).numbers == ((0, 0),)
        for more in ({"n": 3}, {"numbers": [0, 2]}):
            with pytest.raises(UsageError, match=r"there is no object 2: .* gives 2, numbered from 0"):
                read_request("Box", values=values, **more)  # type: ignore[arg-type]
        for more in ({"settings": {"width": 0.1}}, {"sampling": "prior"}):
            with pytest.raises(UsageError, match="neither drawn nor set"):
                read_request("Box", values=values, **more)  # type: ignore[arg-type]
    assert read_request("Box", values={"width": 0.12}).numbers == ((0, 0),)


def test_where_nothing_leads_from_one_place_to_another_the_whole_path_stays(
    monkeypatch: pytest.MonkeyPatch, tmp_path: Path
) -> None:
    def apart(*_: object) -> str:
        raise ValueError("path is on mount 'D:', start on mount 'C:'")

    assert manifests.see_from(tmp_path / "out", tmp_path / "scans" / "chair.obj") == "../scans/chair.obj"
    monkeypatch.setattr(manifests.os.path, "relpath", apart)
    assert manifests.see_from(tmp_path, "/scans/chair.obj") == "/scans/chair.obj"
