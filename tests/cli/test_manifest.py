"""A manifest with something wrong in it is reported with its key; no command on such a folder ends in a traceback."""

from __future__ import annotations

import copy
import json
import shutil
from collections.abc import Iterator
from pathlib import Path
from typing import Any, get_type_hints

import numpy as np
import pytest

from artipg_dsl.export.content import Content
from artipg_dsl.export.write import ExportError
from artipg_dsl.run import manifest
from artipg_dsl.run.counts import Counts
from artipg_dsl.run.output import Output
from artipg_dsl.run.request import Made, Request

from .helpers import CHEST, Apgc

EVERY = ("text", 1, 0, -1, 10**30, 1.5, float("nan"), None, True, [], [[0]], {}, "../../x", "\0", "\ud800")
CHECKED = {"numbers", "settings"}  # of these, every value that is read at all is tried
EDITS = [
    (("identity", "numbers"), []),
    (("identity", "numbers"), [[10**18, 10**18]]),
    (("identity", "numbers"), "0..1"),
    (("identity", "seed"), -(10**30)),
    (("identity", "program"), ""),
    (("identity", "formats"), ["glb"]),
    (("identity", "settings"), {"widht": 1}),
    (("identity", "settings"), {"width": "wide"}),
    (("identity", "points"), 1),
    (("identity", "made", "mutations"), [{"replay": ""}]),
    (("identity", "made", "values"), [{"width": {}}]),
    (("source",), "o"),
    (("source",), "Microwaev"),
    (("identity", "states"), "open"),
    (("identity",), None),
    (("objects",), 10**9),
    (("shards",), ["../*"]),
]
Path_ = tuple[str | int, ...]


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Two objects with a program beside them, all that a manifest can hold, and mutants of them."""
    from artipg_dsl.cli.main import main

    out = tmp_path_factory.mktemp("set")
    assert main(["compile", CHEST, "-o", str(out / "program.apgc")]) == 0
    made = ["sample", str(out / "program.apgc"), "-n", "2", "--points", "16", "--set", "width=45cm", "--views", "1"]
    assert (
        main([*made, "--states", "rest,open", "--format", "points,glb,views", "--tolerance", "5mm", "-o", str(out)])
        == 0
    )
    assert main(["mutate", str(out), "-o", str(out / "mutants"), "--points", "16"]) == 0
    return out


def places(value: Any, at: Path_ = ()) -> Iterator[Path_]:
    if at:
        yield at
    items = value.items() if isinstance(value, dict) else enumerate(value[:2]) if isinstance(value, list) else ()
    for key, item in items:
        if key != "arrays" and at[:1] != ("vocabularies",):
            yield from places(item, (*at, key))


def changed(whole: dict[str, Any], at: Path_, value: Any, *, remove: bool = False) -> dict[str, Any]:
    made = copy.deepcopy(whole)
    inner = made
    for key in at[:-1]:
        inner = inner[key]
    if remove:
        del inner[at[-1]]
    else:
        inner[at[-1]] = value
    return made


def mutants(whole: dict[str, Any]) -> Iterator[tuple[Path_, dict[str, Any]]]:
    """Every value: of other types, too small, too large, not there; and a key that nobody knows beside it."""
    for at in places(whole):
        for value in EVERY:
            yield at, changed(whole, at, value)
        yield at, changed(whole, at, None, remove=True)
        if isinstance(at[-1], str):
            yield at, changed(whole, (*at[:-1], "unheard_of"), 1)


@pytest.mark.slow
@pytest.mark.parametrize("below", ["", "mutants"])
def test_no_command_ends_in_a_traceback_whatever_the_manifest_says(folder, below, tmp_path, apgc: Apgc) -> None:
    out = tmp_path / "o"
    shutil.copytree(folder, out)
    place = out / below
    whole = json.loads((place / manifest.NAME).read_text(encoding="utf-8"))
    refused, tried = 0, set()
    for at, made in mutants(whole):
        (place / manifest.NAME).write_text(json.dumps(made), encoding="utf-8")
        try:
            manifest.read_manifest(place)
        except ExportError as wrong:
            refused += 1
            assert str(place / manifest.NAME) in wrong.message and wrong.hint, wrong
            key = at[-1] if isinstance(at[-1], str) else at[-2]
            assert str(key) in wrong.message or "key" in wrong.message or "expected" in wrong.message, (
                at,
                wrong.message,
            )
            continue
        if at[0] == "identity" and (at[1] in CHECKED or at[1] not in tried) or at == ("source",):
            tried.add(at[1] if at[1:] else "source")
            code, _, err = apgc("validate", place, "-n", 1, "--states", "random:1")
            assert code in (0, 1, 2) and (code == 0 or err), at
    assert refused > 400 and len(tried) > 8, (refused, tried)


@pytest.mark.parametrize("command", ["export", "mutate", "render", "sample"])
def test_every_command_reads_the_manifest_with_care(folder: Path, tmp_path: Path, command: str, apgc: Apgc) -> None:
    out = tmp_path / "o"
    shutil.copytree(folder, out)
    whole = json.loads((out / manifest.NAME).read_text(encoding="utf-8"))
    arguments = {
        "export": (out, "--format", "obj", "-o", tmp_path / "obj", "-n", 1, "--force"),
        "mutate": (out, "-o", tmp_path / "m", "--only", 0, "--points", 8, "--force"),
        "render": (out, "-n", 1, "--tile", 16, "-o", tmp_path / "p.png"),
        "sample": (out / "program.apgc", "-n", 1, "--points", 8, "-o", out),
    }[command]
    for at, value in EDITS:
        (out / manifest.NAME).write_text(json.dumps(changed(whole, at, value)), encoding="utf-8")
        code, _, err = apgc(command, *arguments)
        assert code in (0, 1, 2) and (code == 0 or err), at


WRONG = {
    ("identity", "numbers"): ([[5, 1]], "identity.numbers: a list where runs of object numbers"),
    ("identity", "seed"): ("7", "identity.seed: '7' where a whole number is expected"),
    ("identity", "formats"): (["poinst"], "identity.formats[0]: 'poinst' where a format is expected"),
    ("identity", "made", "sampling"): ("prior:0", "identity.made.sampling: 'prior:0' where sequential or prior:N"),
    ("identity", "gripper", "stroke"): (-1, "identity.gripper.stroke: -1 where a number from"),
    ("identity", "views", "fov"): (500, "identity.views"),
    ("shards",): (["../x"], "shards: another list where the 1 shards"),
    ("objects",): (3, "objects: 3 where the 2 of identity.numbers is expected"),
    ("manifest",): (1, "manifest: 1 where version 2"),
    ("counts", "failed"): ({"a": "b"}, "counts.failed.a: 'b' where a whole number from 0 on is expected"),
    ("identity", "sed"): (1, "identity: the key 'sed' where another key (did you mean `seed`?) is expected"),
}


@pytest.mark.parametrize(("at", "value", "words"), [(at, *rest) for at, rest in WRONG.items()])
def test_what_is_wrong_is_told_with_its_key(folder: Path, tmp_path: Path, at: Path_, value: Any, words: str) -> None:
    whole = json.loads((folder / manifest.NAME).read_text(encoding="utf-8"))
    (tmp_path / manifest.NAME).write_text(json.dumps(changed(whole, at, value)), encoding="utf-8")
    with pytest.raises(ExportError) as wrong:
        manifest.read_manifest(tmp_path)
    assert wrong.value.message.startswith(f"{tmp_path / manifest.NAME}: {words}"), wrong.value.message


@pytest.mark.parametrize(
    "text", ["", "[", "[]", "3", "null", '"x"', "[" * 100_000, "{}", "\xff", '{"manifest": 2}', "1" * 5000]
)
def test_what_is_no_manifest_at_all_is_told(tmp_path: Path, text: str, apgc: Apgc) -> None:
    (tmp_path / manifest.NAME).write_bytes(text.encode("latin-1"))
    code, _, err = apgc("validate", tmp_path, "-n", 1)
    assert code == 1 and manifest.NAME in err


def test_validate_has_something_to_examine(folder: Path, tmp_path: Path, apgc: Apgc) -> None:
    code, _, err = apgc("validate", folder, "--only", 77)
    assert code == 1 and "there is no object 77" in err
    shutil.copytree(folder, tmp_path / "o")
    whole = json.loads((tmp_path / "o" / manifest.NAME).read_text(encoding="utf-8"))
    whole |= {"objects": 0, "shards": [], "identity": {**whole["identity"], "numbers": []}}
    (tmp_path / "o" / manifest.NAME).write_text(json.dumps(whole), encoding="utf-8")
    code, _, err = apgc("validate", tmp_path / "o")
    assert code == 1 and "there is no object to validate" in err


RECORDS = (manifest.Manifest, manifest.Identity, Made, Counts, Request, Output, Content)
OWN = sorted(
    {name for record in RECORDS for name in get_type_hints(record)} | {"n", "set", "only", "unchecked", "drawn"}
)
REFUSED = {"category", "surface", "frame"}  # words and types of the language


def test_a_parameter_may_be_called_what_the_records_call_their_own(tmp_path: Path, apgc: Apgc) -> None:
    """Every key of the manifest and every field of a record is a parameter here, and all of them are set."""
    names = [name for name in OWN if name not in REFUSED]
    assert len(names) > 50
    values = {name: round(1e-3 + 1e-5 * k, 6) for k, name in enumerate(names)}
    program, out = tmp_path / "box.apg", tmp_path / "o"
    program.write_text(
        "apg 1\nuse primitives { Cuboid }\ncategory Box {\n"
        + "".join(f"  param {name} : length in 1mm .. 2mm\n" for name in names)
        + f"  root part body : Cuboid(size = [{' + '.join(names)}, 4cm, 4cm])\n}}\n",
        encoding="utf-8",
    )
    settings = [word for name in names for word in ("--set", f"{name}={1e3 * values[name]:.6g}mm")]
    assert apgc("sample", program, "-n", 1, "--points", 16, *settings, "-o", out)[0] == 0
    assert apgc("export", out, "--format", "obj")[0] == 0
    drawn = json.loads((out / "annotation-00000.jsonl").read_text(encoding="utf-8"))["drawn"]
    lines = (out / "objects/000000/obj/body.obj").read_text().splitlines()
    corners = np.array([line.split()[1:] for line in lines if line.startswith("v ")], dtype=float)
    assert drawn == {name: pytest.approx(value) for name, value in values.items()}
    assert np.ptp(corners[:, 0]) == pytest.approx(sum(values.values()), abs=1e-5)
    whole = json.loads((out / manifest.NAME).read_text(encoding="utf-8"))
    assert whole["identity"]["settings"] == {name: pytest.approx(value) for name, value in values.items()}
    assert apgc("mutate", out, "-o", tmp_path / "m", "--points", 16)[0] == 0
    assert apgc("validate", tmp_path / "m")[0] == 0
