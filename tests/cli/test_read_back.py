"""Files that are read back, traces and values, with something wrong in them: told, never a traceback."""

from __future__ import annotations

import copy
import json
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import pytest

from .helpers import CHEST, Apgc

EVERY = ("text", -1, 10**400, 1.5, float("nan"), None, True, [], {}, "\ud800")


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    from artipg_dsl.cli.main import main

    out = tmp_path_factory.mktemp("set")
    assert main(["compile", CHEST, "-o", str(out / "chest.apgc")]) == 0
    assert main(["sample", str(out / "chest.apgc"), "-n", "2", "--points", "16", "-o", str(out / "o")]) == 0
    assert main(["mutate", str(out / "o"), "-o", str(out / "m"), "--points", "16", "--unchecked"]) == 0
    return out


def changes(value: Any) -> Iterator[Any]:
    """The value with one thing in it of another type, too large, or not there."""
    items = (
        list(value.items())
        if isinstance(value, dict)
        else list(enumerate(value[:2]))
        if isinstance(value, list)
        else []
    )
    for key, item in items:
        for other in (*EVERY, *changes(item)):
            made = copy.copy(value)
            made[key] = other
            yield made
        made = copy.copy(value)
        del made[key]
        yield made
    if isinstance(value, dict):
        yield {**value, "unheard_of": 1}


@pytest.mark.slow
def test_traces(folder: Path, tmp_path: Path, apgc: Apgc) -> None:
    first, *others = (folder / "m" / "trace-00000.jsonl").read_text(encoding="utf-8").splitlines()
    trace = tmp_path / "trace-00000.jsonl"
    refused = 0
    made = list(changes(json.loads(first)))
    for number, record in enumerate(made):
        trace.write_text("\n".join([json.dumps(record), *others]), encoding="utf-8")
        # what two traces say is compared as text; what they do is done, for some of them
        code, _, err = apgc("mutate", "--diff", trace, folder / "m" / "trace-00000.jsonl")
        assert code in (0, 1) and (code == 0 or "trace" in err)
        refused += code
        if code == 0 and number % 8 == 0:
            replay = (
                "mutate",
                folder / "o",
                "--replay",
                trace,
                "-o",
                tmp_path / "r",
                "--points",
                8,
                "--force",
                "--unchecked",
            )
            code, _, err = apgc(*replay)
            assert code in (0, 1) and (code == 0 or err), record
    assert refused > len(made) / 2


@pytest.mark.parametrize("cut", [1, 20, 100])
def test_a_trace_cut_short(folder: Path, tmp_path: Path, cut: int, apgc: Apgc) -> None:
    text = (folder / "m" / "trace-00000.jsonl").read_text(encoding="utf-8")
    (tmp_path / "trace.jsonl").write_text(text[:-cut], encoding="utf-8")
    code, _, err = apgc(
        "mutate", folder / "o", "--replay", tmp_path / "trace.jsonl", "-o", tmp_path / "r", "--points", 8
    )
    assert code == 0 or "is not a mutation trace" in err


@pytest.mark.slow
def test_files_of_values(folder: Path, tmp_path: Path, apgc: Apgc) -> None:
    annotation = json.loads((folder / "o" / "annotation-00000.jsonl").read_text(encoding="utf-8").splitlines()[0])
    values = tmp_path / "values.json"
    for number, made in enumerate(
        [*changes(annotation["drawn"]), *changes({"drawn": annotation["drawn"]}), [], [[]], [1], "x", None]
    ):
        values.write_text(json.dumps(made), encoding="utf-8")
        if number % 2 and not isinstance(made, dict):
            values.write_text("[" * 100_000, encoding="utf-8")
        code, _, err = apgc(
            "sample",
            folder / "chest.apgc",
            "--params",
            values,
            "--points",
            8,
            "--unchecked",
            "--force",
            "-o",
            tmp_path / "o",
        )
        assert code in (0, 1, 2) and (code == 0 or err), made


def test_arrays_are_written_without_pickles(folder: Path) -> None:
    import numpy as np

    with np.load(folder / "o" / "points-00000.npz", allow_pickle=False) as found:
        assert all(found[name].dtype != object for name in found.files)
    package = Path(__file__).parents[2] / "artipg_dsl"
    reads = [
        line
        for path in package.rglob("*.py")
        for line in path.read_text(encoding="utf-8").splitlines()
        if "np.load(" in line
    ]
    assert reads and all("allow_pickle=False" in line for line in reads)
