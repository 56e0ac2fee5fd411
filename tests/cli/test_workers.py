"""Several processes write what one does; what goes wrong in them is reported as usual, and they end with the run."""

from __future__ import annotations

import multiprocessing.spawn
import os
import pickle
import signal
import subprocess
import sys
import threading
import time
from collections.abc import Callable, Iterable
from pathlib import Path

import pytest

from artipg_dsl.errors import NoObject, SettingError, UserError
from artipg_dsl.export import content, objects
from artipg_dsl.export.registry import choose_formats
from artipg_dsl.export.write import ExportError
from artipg_dsl.run import memory, sharing, workers
from artipg_dsl.run.dataset import write_dataset
from artipg_dsl.run.job import Job, open_job
from artipg_dsl.run.output import Output
from artipg_dsl.run.request import read_request
from artipg_dsl.run.sharing import Workers
from artipg_dsl.run.workers import map_each

from .helpers import CHEST, Apgc, command, environment, spawn, tree

STUCK = """apg 1
use primitives { Cuboid }
category Box {
  root part body : Cuboid(size = [4cm, 4cm, 4cm])
  part lid : Cuboid(size = [1cm, 1cm, 1cm])
  align lid.bottom = body.top - 5mm
  joint slide : prismatic body -> lid along x range 0cm .. 1cm
}
"""


def test_the_same_files_as_by_one(apgc: Apgc, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """Shards and counts are one piece, the folders of objects are shared in smaller ones."""
    monkeypatch.setattr(content, "SHARD", 40)
    arguments = ["sample", CHEST, "-n", 50, "--points", 8, "--format", "points,urdf", "--stats", "-o"]
    code, out, err = apgc(*arguments, tmp_path / "one")
    assert code == 0, err
    code, shared, err = apgc(*arguments, tmp_path / "two", "--workers", 2)
    assert code == 0, err
    assert tree(tmp_path / "one") == tree(tmp_path / "two")
    assert out == shared
    for folder, more in ((tmp_path / "one", []), (tmp_path / "two", ["--workers", "2"])):
        assert apgc("mutate", folder, "--only", "0..40", "--format", "glb", "-o", f"{folder}-mutants", *more)[0] == 0
        assert apgc("export", f"{folder}-mutants", "--format", "obj", *more)[0] == 0
    assert tree(tmp_path / "one-mutants") == tree(tmp_path / "two-mutants")


@pytest.mark.parametrize("at", ["draw", "object"])
def test_the_same_command_twice_at_once(apgc: Apgc, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, at: str) -> None:
    """What another process has written meanwhile has the same bytes: neither fails, nor leaves anything behind."""
    again = ["sample", CHEST, "-n", 5, "--points", 8, "--format", "points,annotation,obj", "-o"]
    assert apgc(*again, tmp_path / "one")[0] == 0
    place, name = (Job, "batch") if at == "draw" else (objects, "_write_object")
    original, begun = getattr(place, name), []

    def meanwhile(*arguments, **named):
        if not begun:
            begun.append(spawn(*again, tmp_path / "two"))
        return original(*arguments, **named)

    monkeypatch.setattr(place, name, meanwhile)
    code, _, err = apgc(*again, tmp_path / "two")
    assert begun[0].returncode == 0 and code == 0, err
    assert tree(tmp_path / "one") == tree(tmp_path / "two")


@pytest.fixture
def asked(monkeypatch: pytest.MonkeyPatch) -> list[int]:
    """On two processors: how many chunks were shared, each time that some were."""
    found: list[int] = []

    def write_shared(job, many, chunks, *more):
        found.append(len(chunks))
        return shared(job, many, chunks, *more)

    shared = workers.write_shared
    monkeypatch.setattr(workers, "write_shared", write_shared)
    monkeypatch.setattr(sharing, "processors", lambda: 2)
    return found


@pytest.mark.slow
def test_the_same_files_where_others_go_on(
    apgc: Apgc, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, asked: list[int]
) -> None:
    """Nobody says how many: the first shard is written here, the others are shared."""
    monkeypatch.setattr(sharing, "_WORTH", 0.0)
    monkeypatch.setattr(memory.Room, "pace", lambda room: 0.0)  # another test may have told
    arguments = ["sample", CHEST, "-n", 600, "--points", 8, "--stats", "-o"]
    code, out, err = apgc(*arguments, tmp_path / "auto")
    assert code == 0, err
    assert asked == [2]
    assert apgc(*arguments, tmp_path / "one", "--workers", 1)[:2] == (0, out)
    assert tree(tmp_path / "auto") == tree(tmp_path / "one")


@pytest.mark.slow
def test_what_is_known_to_take_long_is_shared_at_once(
    apgc: Apgc, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, asked: list[int]
) -> None:
    """From the first shard on, unless there is nothing left to do."""
    monkeypatch.setattr(memory.Room, "pace", lambda room: 1.0)
    arguments = ["sample", CHEST, "-n", 600, "--points", 8, "-o", tmp_path / "out"]
    assert apgc(*arguments)[0] == 0 and asked == [3]
    before = tree(tmp_path / "out")
    assert apgc(*arguments)[0] == 0 and asked == [3], "all is there"
    (tmp_path / "out" / "points-00000.npz").unlink()
    assert apgc(*arguments)[0] == 0 and asked == [3, 3]
    assert tree(tmp_path / "out") == before


def test_what_a_worker_meets_is_told_in_words(apgc: Apgc, tmp_path: Path) -> None:
    text = tmp_path / "box.apg"
    text.write_text(STUCK)
    told = [apgc("sample", text, "-n", 300, "-o", tmp_path / n, "--workers", n) for n in ("1", "2")]
    assert told[0][0] == told[1][0] == 1
    assert "no valid Box" in told[1][2] and "body and lid collide" in told[1][2]


@pytest.mark.parametrize("kind", [UserError, ExportError, NoObject, SettingError])
def test_errors_travel_whole(kind: type[UserError]) -> None:
    there = pickle.loads(pickle.dumps(kind("no room", "make some")))
    assert (type(there), there.message, there.hint, str(there)) == (kind, "no room", "make some", "no room (make some)")


@pytest.mark.parametrize("count", ["0", "-1", "many", "100000"])
def test_wrong_counts(apgc: Apgc, tmp_path: Path, count: str) -> None:
    code, _, err = apgc("sample", CHEST, "-o", tmp_path / "o", "--workers", count)
    assert code == 2 and "--workers" in err


@pytest.mark.skipif(not Path("/proc/self/task").exists(), reason="tells children by /proc, which Linux alone has")
@pytest.mark.parametrize("kill", [signal.SIGINT, signal.SIGKILL])
def test_workers_end_with_the_run(tmp_path: Path, kill: signal.Signals) -> None:
    arguments = ["sample", CHEST, "-n", "4000", "--format", "urdf", "--workers", "2"]
    with subprocess.Popen(
        command(*arguments, "-o", tmp_path / "o"), env=environment(), stderr=subprocess.PIPE, start_new_session=True
    ) as run:
        deadline = time.monotonic() + 60
        while not any((tmp_path / "o").glob("objects/*/object.urdf")) and time.monotonic() < deadline:
            time.sleep(0.05)
        children = Path(f"/proc/{run.pid}/task/{run.pid}/children").read_text().split()
        assert len(children) >= 2
        if kill == signal.SIGINT:
            os.killpg(run.pid, kill)  # as a terminal does
        else:
            run.send_signal(kill)
        told = run.communicate(timeout=60)[1].decode()
    assert run.returncode == (130 if kill == signal.SIGINT else -kill)
    assert "Traceback" not in told
    while any(alive(int(child)) for child in children) and time.monotonic() < deadline:
        time.sleep(0.05)
    assert not [child for child in children if alive(int(child))]


def alive(process: int) -> bool:
    try:
        os.kill(process, 0)
    except ProcessLookupError:
        return False
    return Path(f"/proc/{process}/stat").read_text().rpartition(")")[2].split()[0] != "Z"


def ends_by_a_death(work: Callable[[], Iterable[object]]) -> None:
    """Work that is shared ends, within a minute, and says that a process died."""
    told: list[str] = []

    def share() -> None:
        try:
            list(work())
        except UserError as error:
            told.append(error.message)

    run = threading.Thread(target=share, daemon=True)
    run.start()
    run.join(60)
    assert told == ["a worker process died, perhaps for lack of memory"]


def test_workers_that_die_before_they_read_their_task_end_the_run(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """What they are given is larger than a pipe holds, so that to write it to nobody would take for ever."""
    dying = tmp_path / "python"
    dying.write_text(f'#!/bin/sh\ncase "$*" in *spawn_main*) kill -9 $$;; esac\nexec {sys.executable} "$@"\n')
    dying.chmod(0o700)
    monkeypatch.setattr(multiprocessing.spawn, "_python_exe", os.fsencode(dying))
    ends_by_a_death(lambda: map_each(len, ["one", "two"], 2, print, "x" * 1_000_000, here=len))


def test_a_worker_that_dies_at_work_ends_the_run() -> None:
    """Since Python 3.12 its calls are told of it with the pool locked: who then gives it the next would wait for ever."""
    ends_by_a_death(lambda: map_each(os._exit, [3] * 200, 2, here=lambda _: time.sleep(0.05)))


def test_the_process_that_shares_work_does_its_part() -> None:
    """It begins while the others start, nothing is done twice, and results come in their order."""
    here: list[str] = []

    def length(word: str) -> int:
        here.append(word)
        time.sleep(0.02)
        return len(word)

    words = ["x" * k for k in range(300)]
    assert list(map_each(len, words, 2, here=length)) == list(range(300))
    assert here[0] == words[1] and words[0] not in here, "the other one has been given the first"
    assert len(set(here)) == len(here)


def test_progress_goes_by_the_objects_of_all_processes(tmp_path: Path) -> None:
    """Many more steps are told than there are pieces, and none goes back."""
    heard: list[int] = []
    output = Output.of(choose_formats("obj"), content.Content())
    job = open_job(read_request(CHEST, n=96))
    write_dataset(job, tmp_path / "o", output, progress=lambda done, _: heard.append(done), workers=Workers(2))
    assert heard[-1] == 96 and heard == sorted(heard)
    assert len(set(heard)) > 20, "three pieces of 32"


def test_what_fails_here_is_raised_in_its_turn() -> None:
    def fail(word: str) -> int:
        raise UserError(f"{word} fails")

    found = map_each(len, ["one", "two", "three"], 2, here=fail)
    assert next(found) == 3
    with pytest.raises(UserError, match="two fails"):
        next(found)


@pytest.mark.skipif(not hasattr(signal, "SIGHUP"), reason="terminals of Windows send no signal when they are closed")
def test_processes_that_are_started_do_not_mind_a_closed_terminal() -> None:
    with workers._undisturbed():
        assert signal.SIGHUP in signal.pthread_sigmask(signal.SIG_BLOCK, ())
    assert signal.SIGHUP not in signal.pthread_sigmask(signal.SIG_BLOCK, ())


def test_a_worker_that_starts_when_all_is_over_says_nothing(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    class Gone:
        """The process that started the run; as long as the test lasts nobody hears of its end but by asking."""

        def join(self) -> None:
            threading.Event().wait()

        def is_alive(self) -> bool:
            return False

    def leave(code: int) -> None:
        raise SystemExit(code)

    before = signal.getsignal(signal.SIGINT)
    monkeypatch.setattr(workers.mp, "parent_process", Gone)
    monkeypatch.setattr(workers.os, "_exit", leave)
    try:
        with pytest.raises(SystemExit):
            workers._begin(str(tmp_path / "taken_away.task"))
    finally:
        signal.signal(signal.SIGINT, before)
