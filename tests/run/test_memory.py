"""Runs of any length in bounded memory: blocks of objects, no object made twice, and the same bytes in any case."""

from __future__ import annotations

import gc
import json
import shutil
import tracemalloc
import weakref
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from artipg_dsl import cache
from artipg_dsl.annotate.sampling import Sampling
from artipg_dsl.errors import UsageError
from artipg_dsl.export.content import Content
from artipg_dsl.export.objects import write_objects
from artipg_dsl.export.registry import FORMATS
from artipg_dsl.export.remote import place_of
from artipg_dsl.export.write import ExportError
from artipg_dsl.robot.pose import link_poses, open_values
from artipg_dsl.robot.robots import Robots
from artipg_dsl.run import memory as memories
from artipg_dsl.run.chunk import Chunk
from artipg_dsl.run.dataset import write_dataset
from artipg_dsl.run.job import Job, open_job
from artipg_dsl.run.memory import Room, read_memory
from artipg_dsl.run.output import Output
from artipg_dsl.run.request import read_request
from artipg_dsl.sampling.statistics import Statistics

CHEST = Path(__file__).parents[1] / "cli" / "programs" / "chest.apg"
OUTPUT = Output(("points", "annotation", "glb"), Content(Sampling(16)), 8)


def tree(folder: Path) -> dict[str, bytes]:
    return {str(p.relative_to(folder)): p.read_bytes() for p in sorted(folder.rglob("*")) if p.is_file()}


def job(n: int, **more: Any) -> Job:
    return open_job(read_request(CHEST, n=n, **more))


@pytest.fixture
def made(monkeypatch: pytest.MonkeyPatch) -> list[int]:
    """The numbers of the objects that are made, as often as they are."""
    found: list[int] = []
    plain = Job.batch

    def batch(self: Job, numbers: Any = None) -> Any:
        found.extend(np.asarray(self.request.objects if numbers is None else numbers).tolist())
        return plain(self, numbers)

    monkeypatch.setattr(Job, "batch", batch)
    return found


@pytest.mark.parametrize(("text", "size"), [("2GB", 2 * 10**9), (" 512 mb", 512 * 10**6), ("1.5GB", 15 * 10**8)])
def test_sizes_are_read(text: str, size: int) -> None:
    assert read_memory(text) == size


@pytest.mark.parametrize("text", ["", "2", "GB", "-1GB", "0GB", "5MB", "nanGB", "1e3GB", "9999999TB", "2 gigs"])
def test_nonsense_is_refused(text: str) -> None:
    with pytest.raises(UsageError, match=r"is not a size|too little|more than there is") as caught:
        read_memory(text)
    assert "MB" in caught.value.hint


def test_blocks_follow_what_objects_have_taken(monkeypatch: pytest.MonkeyPatch) -> None:
    state = {"peak": 150, "now": 100}
    monkeypatch.setattr(memories, "_resident", lambda: state["now"])
    monkeypatch.setattr(memories, "_peak", lambda: state["peak"])
    room = Room(300)
    assert room.begin(1000) == 16  # nothing is known
    state["peak"] = 180
    room.end(16)
    assert room.begin(1000) == 40  # 5 each
    room.end(40)
    assert room.begin(1000) == 100  # at most 2 each: the 40 have not taken more than was taken before
    state["peak"] = 500
    room.end(100)
    assert room.begin(1000) == 50
    state["now"] = 400
    assert room.begin(1000) == 1  # one at a time, whatever there is
    assert room.begin(0) == 0


@pytest.mark.parametrize("said", [None, b"", b"nan", b"10", b"-1 0.1", b"1e9 0.1", b"9" * 40])
def test_a_run_begins_with_as_many_as_another_has_found_room_for(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, said: bytes | None
) -> None:
    monkeypatch.setenv("APGC_CACHE", str(tmp_path / "kept"))
    output, blocks = Output(("points",), Content(Sampling(16)), 80), []
    plain = Room.begin
    monkeypatch.setattr(Room, "begin", lambda room, left: blocks.append(plain(room, left)) or blocks[-1])
    monkeypatch.setattr(memories, "_resident", lambda: 100 << 20)  # whatever the tests before have taken
    monkeypatch.setattr(memories, "_peak", lambda: 150 << 20)
    write_dataset(job(80), tmp_path / "first", output)
    assert blocks == [16, 64]
    (entry,) = (tmp_path / "kept").glob("memory-*")
    if said is not None:
        cache.write(entry.name, said)
    write_dataset(job(80), tmp_path / "second", output)
    assert blocks[2:] == ([80] if said is None else [16, 64])
    assert tree(tmp_path / "first") == tree(tmp_path / "second")
    room = Room(300, entry.name)
    cache.write(entry.name, b"10 0.250000")
    monkeypatch.setattr(memories, "_resident", lambda: 100)
    assert plain(room, 1000) == 10  # half of what there would be room for: other objects may be larger
    assert room.pace() == 0.25


def test_few_objects_say_nothing_of_what_one_takes(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """The first ones pay for what is made once for a program: neither another run nor a known figure goes by them."""
    monkeypatch.setenv("APGC_CACHE", str(tmp_path))
    state = {"peak": 100}
    monkeypatch.setattr(memories, "_resident", lambda: 100)
    monkeypatch.setattr(memories, "_peak", lambda: state["peak"])

    def run(*peaks: int, of: int) -> list[int]:
        """The blocks of a run of so many objects, after each of which the process has been so large, and the next one."""
        room, state["peak"] = Room(1100, "memory-" + 40 * "0"), 100
        blocks = [room.begin(of)]
        for peak in peaks:
            state["peak"] = peak
            room.end(blocks[-1])
            blocks.append(room.begin(of))
        room.keep()
        return blocks

    assert run(150, of=1) == [1, 1]
    assert run(260, 1000, of=1000) == [16, 100, 111]  # 50 more once, and then 9 each
    assert run(150, of=1) == [1, 1]
    assert run(595, of=1000) == [55, 111], "half of what there would be room for"
    assert run(900, of=20) == [20, 20]
    assert run(of=1000) == [55], "what 100 objects have told holds"


def test_the_time_that_an_object_takes_is_kept(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """Of blocks of some size, the quickest; another run that takes about as long changes nothing."""
    monkeypatch.setenv("APGC_CACHE", str(tmp_path))
    clock = [0.0]
    monkeypatch.setattr(memories.time, "monotonic", lambda: clock[0])

    def run(*blocks: tuple[int, float]) -> float:
        room = Room(10**9, "memory-" + 40 * "0")
        before = room.pace()
        for made, seconds in blocks:
            room.begin(made)
            clock[0] += seconds
            room.end(made)
        room.keep()
        return before

    assert run((16, 8.0)) == 0.0
    assert run((16, 8.0), (64, 6.4), (64, 3.2)) == 0.0, "few objects tell nothing"
    assert run((64, 6.0)) == pytest.approx(0.05)
    assert run((64, 0.64)) == pytest.approx(0.05)
    assert run() == pytest.approx(0.01)


@pytest.mark.parametrize("block", [1, 3])
def test_the_bytes_do_not_depend_on_the_blocks(tmp_path: Path, monkeypatch: pytest.MonkeyPatch, block: int) -> None:
    write_dataset(job(20), tmp_path / "whole", OUTPUT)
    monkeypatch.setattr(Room, "begin", lambda self, left: min(left, block))
    write_dataset(job(20), tmp_path / "blocks", OUTPUT)
    assert tree(tmp_path / "blocks") == tree(tmp_path / "whole")


class Killed(BaseException):
    pass


@pytest.mark.some
@pytest.mark.parametrize("formats", [OUTPUT.formats, ("urdf",)])
def test_a_run_goes_on_where_it_was_killed(tmp_path: Path, made: list[int], formats: tuple[str, ...]) -> None:
    output = Output(formats, OUTPUT.content, 8)
    write_dataset(job(40), tmp_path / "whole", output)
    made.clear()
    plain = Chunk.write

    def dying(self: Chunk, *given: Any) -> None:
        if self.numbers[0] >= 16:
            raise Killed
        plain(self, *given)

    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(Chunk, "write", dying)
        with pytest.raises(Killed):
            write_dataset(job(40), tmp_path / "o", output)
    assert sorted(made) == list(range(16))
    write_dataset(job(40), tmp_path / "o", output)
    assert sorted(made) == list(range(40))  # each once
    assert tree(tmp_path / "o") == tree(tmp_path / "whole")
    write_dataset(job(40), tmp_path / "o", output)
    assert len(made) == 40


@pytest.mark.slow
def test_parts_leave_nothing_to_make(tmp_path: Path, made: list[int]) -> None:
    write_dataset(job(40), tmp_path / "whole", OUTPUT)
    made.clear()
    for k in (1, 2):
        write_dataset(job(40), tmp_path / "o", OUTPUT, part=(k, 2))
    write_dataset(job(40), tmp_path / "o", OUTPUT)
    assert sorted(made) == list(range(40))
    assert tree(tmp_path / "o") == tree(tmp_path / "whole")


def test_a_shard_tells_how_far_it_is(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    heard: list[tuple[int, int]] = []
    output = Output(("points",), Content(Sampling(8)), 64)
    monkeypatch.setattr(Room, "pace", lambda _: 0.4)  # seconds: in eight of them there are twenty
    write_dataset(job(50, checked=False), tmp_path / "o", output, progress=lambda *told: heard.append(told))
    assert heard[-1] == (50, 50) and np.diff([0, *(done for done, _ in heard)]).max() <= 20


def test_a_folder_that_is_removed_meanwhile_is_not_called_whole(tmp_path: Path) -> None:
    out, output, asked = tmp_path / "o", Output(("points",), Content(Sampling(8)), 4), job(8, checked=False)

    def remove(done: int, _: int) -> None:
        if done == 4 and out.exists():
            shutil.rmtree(out)

    with pytest.raises(ExportError, match="files were removed from .*o while"):
        write_dataset(asked, out, output, progress=remove)
    write_dataset(asked.fresh(), out, output)
    write_dataset(asked.fresh(), tmp_path / "other", output)
    assert tree(out) == tree(tmp_path / "other")


def test_counts_come_back_as_they_were() -> None:
    counted = Statistics(3, 2, 7, {1: 2}, {0: 4}, {("a", "b", "j"): 1}, {"it tips over": 2}, 1, {0: 1}, 32, 9, 1.5)
    counted.repaired = {("draw", 1): 2, ("collision", ("a", "b", "")): 1, ("solid", "it tips over"): 3}
    counted.examples = {("a", "b", "j"): "at 3cm"}
    assert Statistics.of(json.loads(json.dumps(counted.plain()))) == counted


@pytest.mark.slow
def test_memory_does_not_grow_with_the_run(tmp_path: Path) -> None:
    """What is held after 25 shards is what was held after 5: no object, and nothing of any, though no garbage is collected."""
    held: list[int] = []

    def heard(done: int, total: int) -> None:
        if done in (40, 200):
            held.append(tracemalloc.get_traced_memory()[0])

    output, asked = Output(("points", "annotation"), Content(Sampling(8)), 8), job(200, checked=False)
    write_dataset(asked, tmp_path / "first", output)  # what is made once for a program
    tracemalloc.start()
    gc.disable()
    try:
        write_dataset(asked.fresh(), tmp_path / "o", output, progress=heard)
    finally:
        gc.enable()
        tracemalloc.stop()
    assert held[1] - held[0] < 100_000, held


FORMATS_OF_OBJECTS = ("urdf", "mjcf", "usd", "glb", "obj", "partnet-mobility")


@pytest.mark.some
@pytest.mark.parametrize("category", ["Microwave", "Foldingrack", "StorageFurniture", "Safe"])
def test_a_batch_goes_with_its_last_use(category: str, tmp_path: Path) -> None:
    """It is in no circle, which would keep hundreds of megabytes until garbage is collected; nor is what formats make of it."""
    asked = open_job(read_request(category, n=2, checked=True))
    content = Content(Sampling(16))
    kept: list[weakref.ref[Any]] = []
    gc.disable()
    try:
        batch = asked.batch()
        for entry in (FORMATS["points"], FORMATS["annotation"], FORMATS["correspondence"]):
            entry.joined([entry.part(batch, content)])
        write_objects(batch, place_of(tmp_path), [FORMATS[name] for name in FORMATS_OF_OBJECTS], only=batch.numbers)
        robots = Robots(batch)
        robot = robots.robot(0)
        link_poses(robot, open_values(robot))
        kept += [weakref.ref(batch), weakref.ref(robots), weakref.ref(batch.sites()[0])]
        del batch, robots, robot
        assert [kind() for kind in kept] == [None] * 3
    finally:
        gc.enable()
