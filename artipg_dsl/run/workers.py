"""Work shared by several processes: the same bytes, sooner.

What writes the chunks of a run gets its job once, plans the program anew, and gives back what it counted. A worker ends with the
run: on Ctrl-C at once, and when the process that started it is gone.
"""

from __future__ import annotations

import multiprocessing as mp
import os
import pickle
import signal
import threading
from collections import deque
from collections.abc import Callable, Iterable, Iterator, Sequence
from concurrent.futures import Future, ProcessPoolExecutor
from concurrent.futures.process import BrokenProcessPool
from contextlib import contextmanager, suppress
from itertools import islice
from tempfile import mkstemp
from typing import Any, TypeVar

from ..errors import UserError
from .chunk import Chunk
from .job import Job
from .memory import Room

_AHEAD = 8  # calls for each process that wait, so that none is idle
T = TypeVar("T")
R = TypeVar("R")
_given: tuple[Job, Room] | None = None  # what this worker works for, and the memory that it may take


def write_shared(job: Job, count: int, chunks: Sequence[Chunk], room: Room) -> Iterator[Chunk]:
    """Write the chunks with ``count`` processes, which have ``room`` each, and give each back, in their order.

    Raises what the first chunk that fails raises, and UserError where a process dies.
    """
    for chunk, _ in zip(chunks, map_each(_write, chunks, count, _take, job.fresh(), room), strict=True):
        yield chunk


def map_each(
    function: Callable[[T], R], items: Iterable[T], count: int, begin: Callable[..., None] | None = None, *given: Any
) -> Iterator[R]:
    """``function`` of each item, in their order, called in ``count`` processes that called ``begin(*given)`` first.

    Raises what the first call that fails raises, and UserError where a process dies.
    """
    before = set(mp.active_children())
    with _task_file(begin, given) as task:
        # spawned, not forked: libraries that run threads do not outlive a fork, and it is the same on all systems
        pool = ProcessPoolExecutor(count, mp_context=mp.get_context("spawn"), initializer=_begin, initargs=(task,))
        left = iter(items)
        done = False
        try:
            with _undisturbed():  # all processes are started with the first call
                calls = deque(_submit(pool, function, item) for item in islice(left, _AHEAD * count))
            while calls:
                made = calls.popleft().result()
                calls.extend(_submit(pool, function, item) for item in islice(left, 1))
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


def _submit(pool: ProcessPoolExecutor, function: Callable[[T], R], item: T) -> Future[R]:
    try:
        return pool.submit(function, item)
    except (
        OSError,
        ValueError,
    ) as error:  # a process died, so that the pool closed what another one was about to be given
        raise BrokenProcessPool from error


@contextmanager
def _task_file(begin: Callable[..., None] | None, given: tuple[Any, ...]) -> Iterator[str]:
    """A file of what every worker begins with. What a process is started with goes through a pipe instead: to write more
    than the pipe holds to a process that has died takes for ever."""
    handle, path = mkstemp(prefix="apgc-", suffix=".task")
    try:
        with os.fdopen(handle, "wb") as file:
            pickle.dump((begin, given), file)
        yield path
    finally:
        os.unlink(path)


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


def _begin(task: str) -> None:
    signal.signal(signal.SIGINT, signal.SIG_IGN)  # Ctrl-C reaches all of them: who started the run decides
    parent = mp.parent_process()
    assert parent is not None

    def outlive_nobody() -> None:
        parent.join()
        with suppress(OSError):  # another worker was sooner
            os.unlink(task)
        os._exit(1)

    threading.Thread(target=outlive_nobody, daemon=True).start()
    try:
        with open(task, "rb") as file:
            begin, given = pickle.load(file)
    except FileNotFoundError:
        if parent.is_alive():
            raise
        os._exit(1)  # the run ended while this worker started, and another one has taken the task away
    if begin is not None:
        begin(*given)


def _take(job: Job, room: Room) -> None:
    global _given
    _given = job, room


def _write(chunk: Chunk) -> None:
    assert _given is not None
    chunk.write(*_given)
