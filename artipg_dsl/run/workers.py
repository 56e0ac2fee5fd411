"""Work shared by several processes: the same bytes, sooner.

What writes the chunks of a run gets its job once, plans the program anew, and gives back what it counted. A worker ends with the
run: on Ctrl-C at once, and when the process that started it is gone.
"""

from __future__ import annotations

import multiprocessing as mp
import os
import signal
import threading
from collections import deque
from collections.abc import Callable, Iterator, Sequence
from concurrent.futures import ProcessPoolExecutor
from concurrent.futures.process import BrokenProcessPool
from contextlib import contextmanager
from itertools import islice
from typing import Any, TypeVar

from ..errors import UserError
from .chunk import Chunk
from .job import Job
from .memory import Room

_AHEAD = 8  # calls for each process that wait, so that none is idle
T = TypeVar("T")
R = TypeVar("R")
_given: tuple[Job, Room] | None = None  # what this worker works for, and the memory that it may take


def write_shared(job: Job, count: int, chunks: list[Chunk], room: Room) -> Iterator[Chunk]:
    """Write the chunks with ``count`` processes, which have ``room`` each, and give each back, in their order.

    Raises what the first chunk that fails raises, and UserError where a process dies.
    """
    for chunk, _ in zip(chunks, map_each(_write, chunks, count, _take, job.fresh(), room), strict=True):
        yield chunk


def map_each(
    function: Callable[[T], R], items: Sequence[T], count: int, begin: Callable[..., None] | None = None, *given: Any
) -> Iterator[R]:
    """``function`` of each item, in their order, called in ``count`` processes that called ``begin(*given)`` first.

    Raises what the first call that fails raises, and UserError where a process dies.
    """
    before = set(mp.active_children())
    # spawned, not forked: libraries that run threads do not outlive a fork, and it is the same on all systems
    pool = ProcessPoolExecutor(
        max(1, min(count, len(items))), mp_context=mp.get_context("spawn"), initializer=_begin, initargs=(begin, given)
    )
    left = iter(items)
    with _undisturbed():  # all processes are started with the first call
        calls = deque(pool.submit(function, item) for item in islice(left, _AHEAD * count))
    done = False
    try:
        while calls:
            made = calls.popleft().result()
            calls.extend(pool.submit(function, item) for item in islice(left, 1))
            yield made
        done = True
    except BrokenProcessPool:
        raise UserError(
            "a worker process died, perhaps for lack of memory",
            "use fewer --workers, or smaller shards; the same command completes what is missing",
        ) from None
    finally:
        for child in set() if done else set(mp.active_children()) - before:  # nobody is to go on
            child.terminate()
        pool.shutdown()


@contextmanager
def _undisturbed() -> Iterator[None]:
    """Processes that are started here do not mind Ctrl-C, from their first step on, and it does not cut short how they start."""
    if threading.current_thread() is not threading.main_thread():
        yield
        return
    before = signal.signal(signal.SIGINT, signal.SIG_IGN)
    try:
        yield
    finally:
        signal.signal(signal.SIGINT, before)


def _begin(begin: Callable[..., None] | None, given: tuple[Any, ...]) -> None:
    signal.signal(signal.SIGINT, signal.SIG_IGN)  # Ctrl-C reaches all of them: who started the run decides
    parent = mp.parent_process()
    assert parent is not None

    def outlive_nobody() -> None:
        parent.join()
        os._exit(1)

    threading.Thread(target=outlive_nobody, daemon=True).start()
    if begin is not None:
        begin(*given)


def _take(job: Job, room: Room) -> None:
    global _given
    _given = job, room


def _write(chunk: Chunk) -> None:
    assert _given is not None
    chunk.write(*_given)
