"""Whether a run is one process's work or several's: by what was asked for, or by how long it takes."""

from __future__ import annotations

from collections.abc import Callable, Sequence

import pytest

from artipg_dsl.run import memory, sharing
from artipg_dsl.run.sharing import AUTO, share


@pytest.fixture
def work(monkeypatch: pytest.MonkeyPatch) -> Callable[..., tuple[list[int], list[tuple[list[int], int]]]]:
    """Ten items of ``each`` seconds on eight processors: which are done here, and which by how many others."""
    clock = [100.0]
    monkeypatch.setattr(sharing.time, "monotonic", lambda: clock[0])
    monkeypatch.setattr(sharing, "processors", lambda: 8)

    def run(
        each: float, workers: int = AUTO, items: int = 10, **more: float
    ) -> tuple[list[int], list[tuple[list[int], int]]]:
        here: list[int] = []
        there: list[tuple[list[int], int]] = []

        def alone(item: int) -> int:
            clock[0] += each
            here.append(item)
            return item

        def others(rest: Sequence[int], many: int) -> Sequence[int]:
            there.append((list(rest), many))
            return rest

        assert list(share(range(items), workers, alone, others, **more)) == list(range(items))
        return here, there

    return run


def test_short_work_is_one_processs(work) -> None:
    assert work(0.1) == (list(range(10)), [])
    assert work(0.1, pace=0.1) == (list(range(10)), [])


def test_others_go_on_where_what_is_left_takes_long(work) -> None:
    assert work(3.0) == ([0], [(list(range(1, 10)), 8)])
    assert work(0.3) == ([0], [(list(range(1, 10)), 8)])
    assert work(1.5, items=2) == ([0, 1], []), "the second takes less than the start of another process is worth"


def test_all_begin_at_once_where_it_is_asked_for_or_known(work) -> None:
    assert work(0.1, workers=3) == ([], [(list(range(10)), 3)])
    assert work(0.1, pace=0.3) == ([], [(list(range(10)), 8)])
    assert work(0.1, pace=sharing.LONG) == ([], [(list(range(10)), 8)])


def test_a_single_item_or_worker_is_alone(work) -> None:
    assert work(100.0, workers=3, items=1) == ([0], [])
    assert work(100.0, workers=1) == (list(range(10)), [])
    assert work(100.0, most=1) == (list(range(10)), [])
    assert work(100.0, items=0) == ([], [])


def test_no_more_than_have_room(work, monkeypatch: pytest.MonkeyPatch) -> None:
    assert work(9.0, most=2) == ([0], [(list(range(1, 10)), 2)])
    assert memory.most_processes(1_000_000_000) == 3
    assert memory.most_processes(100) == 1
    pages = {"SC_PAGE_SIZE": 4096, "SC_PHYS_PAGES": 8_000_000_000 // 4096}
    monkeypatch.setattr(memory.os, "sysconf", pages.__getitem__, raising=False)
    assert memory.most_processes(None) == 7


def test_each_has_half_a_gigabyte_unless_all_are_limited() -> None:
    assert memory.share_of(None, 1) == memory.USUAL
    assert memory.share_of(None, 16) == 512_000_000
    assert memory.share_of(1_000_000_000, 4) == 250_000_000
