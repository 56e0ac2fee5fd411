"""An object is the same alone, among others, in another process, and after an interruption."""

from __future__ import annotations

import io
import json
import signal
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest

from .helpers import CHEST, Apgc, environment, spawn, tree

MANY = ("sample", CHEST, "-n", "1100", "--seed", "7", "--points", "16")  # five shards


def one(folder: Path, number: int) -> dict[str, bytes]:
    """Everything written of one object, by name."""
    found: dict[str, bytes] = {}
    for path in sorted(folder.glob("*.npz")):
        with np.load(io.BytesIO(path.read_bytes())) as arrays:
            at = np.flatnonzero(arrays["object"] == number)
            for name in arrays.files:
                if len(at):
                    found[name] = arrays[name][at[0]].tobytes()
    for path in sorted(folder.glob("*.jsonl")):
        for line in path.read_text().splitlines():
            if json.loads(line)["object"] == number:
                found["annotation"] = line.encode()
    return found


@pytest.mark.parametrize("program, n", [(CHEST, 300), ("Microwave", 60)])
def test_object_37_is_the_same_alone_and_among_others(apgc: Apgc, tmp_path: Path, program: str, n: int) -> None:
    made = []
    for k, choice in enumerate((["--only", "37"], ["-n", 38], ["-n", n], ["--only", "12,37..39"])):
        assert apgc("sample", program, "--seed", 7, "--points", 64, "-o", tmp_path / str(k), *choice)[0] == 0
        made.append(one(tmp_path / str(k), 37))
    assert made[0].keys() >= {"points", "normals", "semantic", "u", "annotation"}
    assert all(other == made[0] for other in made[1:])


def test_files_are_the_same_in_processes_with_other_hash_seeds(tmp_path: Path) -> None:
    for seed in ("1", "4242"):
        done = spawn(
            "sample",
            CHEST,
            "-n",
            6,
            "--seed",
            7,
            "--points",
            64,
            "--format",
            "points,urdf,glb",
            "-o",
            tmp_path / seed,
            hash_seed=seed,
        )
        assert done.returncode == 0, done.stderr
    assert tree(tmp_path / "1") == tree(tmp_path / "4242")


def test_shared_work_gives_the_same_files(apgc: Apgc, tmp_path: Path) -> None:
    arguments = ["sample", CHEST, "-n", 600, "--points", 4]
    assert apgc(*arguments, "-o", tmp_path / "whole")[0] == 0
    for k in (2, 1):
        assert apgc(*arguments, "-o", tmp_path / "shared", "--shard", f"{k}/2")[0] == 0
    assert "counts" not in json.loads((tmp_path / "shared" / "manifest.json").read_text())
    assert apgc(*arguments, "-o", tmp_path / "shared")[0] == 0  # nothing is missing; the counts are added
    assert tree(tmp_path / "shared") == tree(tmp_path / "whole")


def test_a_run_completes_what_is_missing(apgc: Apgc, tmp_path: Path) -> None:
    arguments = ["sample", CHEST, "-n", 600, "--points", 4, "--format", "points", "-o", tmp_path / "o"]
    assert apgc(*arguments)[0] == 0
    whole = tree(tmp_path / "o")
    (tmp_path / "o" / "points-00001.npz").unlink()
    kept = (tmp_path / "o" / "points-00000.npz").stat().st_mtime_ns
    assert apgc(*arguments)[0] == 0
    assert tree(tmp_path / "o") == whole
    assert (tmp_path / "o" / "points-00000.npz").stat().st_mtime_ns == kept


@pytest.fixture(scope="module")
def whole(tmp_path_factory: pytest.TempPathFactory) -> dict[str, bytes]:
    """The files of an undisturbed run."""
    out = tmp_path_factory.mktemp("whole") / "o"
    assert spawn(*MANY, "-o", out).returncode == 0
    return tree(out)


# A run that is sent a signal as it is about to give the second shard its name, however fast the machine is. It has no workers
# (those of others are in test_workers), as one of them might write that shard.
INTERRUPTED = """
import os, sys
from artipg_dsl.cli.main import main

def heard(event, arguments):
    if event == "os.rename" and str(arguments[1]).endswith("points-00001.npz"):
        os.kill(os.getpid(), int(sys.argv[1]))

sys.addaudithook(heard)
sys.exit(main(sys.argv[2:]))
"""


@pytest.mark.parametrize("how", [signal.SIGINT, signal.SIGTERM, signal.SIGKILL])
def test_an_interrupted_run_leaves_nothing_partial_and_is_completed(
    tmp_path: Path, whole: dict[str, bytes], how: signal.Signals
) -> None:
    out = tmp_path / "o"
    arguments = [sys.executable, "-c", INTERRUPTED, str(int(how)), *MANY, "--workers", "1", "-o", str(out)]
    run = subprocess.run(arguments, env=environment(), capture_output=True, text=True, timeout=60, check=False)
    told = {signal.SIGINT: 130, signal.SIGTERM: 143}.get(how)
    assert run.returncode == (told or -how), run.stderr
    left = {name: data for name, data in tree(out).items() if not name.startswith(".")}
    assert 0 < sum(name.endswith(".npz") for name in left) < 5
    assert all(
        whole[name] == data for name, data in left.items() if name != "manifest.json" and not name.startswith("counts-")
    )
    if told is not None:
        assert "interrupted" in run.stderr and "Traceback" not in run.stderr
        assert left == tree(out)  # no hidden file either
    again = spawn(*MANY, "-o", out)
    assert again.returncode == 0, again.stderr
    assert tree(out) == whole
