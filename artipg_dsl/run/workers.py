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
from concurrent.futures import Future, ProcessPoolExecutor, wait
from concurrent.futures.process import BrokenProcessPool
from contextlib import contextmanager, suppress
from itertools import islice
from tempfile import mkstemp
from typing import Any, Generic, TypeVar

from ..errors import UserError
from ..pages import hold_pages
from .chunk import Chunk
from .job import Job
from .memory import Room
from .tally import Tally

_AHEAD = 8  # calls for each process that wait, so that none is idle
T = TypeVar("T")
R = TypeVar("R")
_SECONDS = 0.5  # between two looks at what others have finished
_given: tuple[Job, Room, bool] | None = (
    None  # what this worker works for, the memory that it may take, which chunks count
)
_tally: Tally | None = None  # where this worker counts


def write_shared(
    job: Job, count: int, chunks: Sequence[Chunk], room: Room, tally: Tally, each: bool
) -> Iterator[Chunk]:
    """Write the chunks with ``count`` processes, this one among them, which have ``room`` each, and give each back, in their order.
    ``tally`` counts the objects of all, or of those with files of their own (``each``).

    Raises what the first chunk that fails raises, and UserError where a process dies.
    """

    def here(chunk: Chunk) -> None:
        _count(chunk, job, room, tally if chunk.each or not each else None)

    made = map_each(_write, chunks, count, _take, job.fresh(), room, each, here=here, tally=tally)
    for chunk, _ in zip(chunks, made, strict=True):
        yield chunk


def map_each(
    function: Callable[[T], R],
    items: Iterable[T],
    count: int,
    begin: Callable[..., None] | None = None,
    *given: Any,
    here: Callable[[T], R],
    tally: Tally | None = None,
) -> Iterator[R]:
    """``function`` of each item, in their order, called in ``count`` processes, all but this one of which called ``begin(*given)`` first.
    This one does by ``here`` what no other has begun, as long as it would wait else. ``tally``: where all of them count.

    Raises what the first call that fails raises, and UserError where a process dies.
    """
    before = set(mp.active_children())
    with _task_file(begin, given) as task:
        # spawned, not forked: libraries that run threads do not outlive a fork, and it is the same on all systems
        with _undisturbed():
            pool = ProcessPoolExecutor(
                count - 1, mp_context=mp.get_context("spawn"), initializer=_begin, initargs=(task, tally)
            )
        done = False
        try:
            queue = _Queue(pool, count - 1, function, items)
            with _undisturbed():  # all processes are started with the first call
                queue.give()
            yield from queue.results(here, tally)
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


class _Queue(Generic[T, R]):
    """Items in their order, and the calls that have been made for them.

    A process gets its next item as soon as it is free, while this one is busy too; what nobody has begun can still be done
    by either. Items are made by this thread alone.
    """

    def __init__(self, pool: ProcessPoolExecutor, count: int, function: Callable[[T], R], items: Iterable[T]):
        self.pool, self.free, self.function = pool, count, function
        self.ahead = _AHEAD * (count + 1)
        self.left = iter(items)
        self.ready: deque[T] = deque()
        self.calls: deque[Future[R]] = deque()
        self.lock = threading.RLock()

    def give(self) -> None:
        """Make items ready, and give them to whoever is free."""
        with self.lock:
            self.ready.extend(islice(self.left, self.ahead - len(self.ready) - len(self.calls)))
            self._submit()

    def results(self, here: Callable[[T], R], tally: Tally | None) -> Iterator[R]:
        """What the calls return, in their order."""
        while self.calls or self.ready:
            if self.calls and self.calls[0].done() or not self._do(here):
                while tally is not None and not wait(list(self.calls)[:1], _SECONDS).done:
                    tally.tell()
                yield self.calls.popleft().result()
            self.give()

    def _do(self, here: Callable[[T], R]) -> bool:
        """Do one item in this process; whether there was any that nobody has begun."""
        with self.lock:
            if not self.ready:
                return False
            item, call = self.ready.popleft(), Future[R]()
            self.calls.append(call)
        try:
            call.set_result(here(item))
        except Exception as error:  # it is raised when its turn has come
            call.set_exception(error)
        return True

    def _submit(self) -> None:
        with self.lock:
            while self.free and self.ready:
                self.free -= 1
                item = self.ready.popleft()
                try:
                    call = self.pool.submit(self.function, item)
                except (OSError, ValueError, RuntimeError):  # a process died, so that the pool is closed
                    call = Future()
                    call.set_exception(BrokenProcessPool())
                    self.calls.append(call)
                    return
                self.calls.append(call)
                call.add_done_callback(self._next)

    def _next(self, call: Future[R]) -> None:
        if isinstance(call.exception(), BrokenProcessPool):
            return  # told with the pool locked, which takes no more: to ask would be to wait for ever
        with self.lock:
            self.free += 1
            self._submit()


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
    """Processes that are started here do not mind Ctrl-C or a terminal that is closed, from their first step on, and neither cuts
    short how they start. (One of them keeps the books of Python itself, and complains if another has to replace it.)"""
    if threading.current_thread() is not threading.main_thread():
        yield
        return
    before = signal.signal(signal.SIGINT, signal.SIG_IGN)
    held = signal.pthread_sigmask(signal.SIG_BLOCK, {signal.SIGHUP}) if hasattr(signal, "SIGHUP") else None
    try:
        yield
    finally:
        if held is not None:
            signal.pthread_sigmask(signal.SIG_SETMASK, held)
        signal.signal(signal.SIGINT, before)


def _begin(task: str, tally: Tally | None = None) -> None:
    global _tally
    _tally = tally
    signal.signal(signal.SIGINT, signal.SIG_IGN)  # Ctrl-C reaches all of them: who started the run decides
    parent = mp.parent_process()
    assert parent is not None
    hold_pages()

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


def _take(job: Job, room: Room, each: bool) -> None:
    global _given
    _given = job, room, each


def _write(chunk: Chunk) -> None:
    assert _given is not None
    job, room, each = _given
    _count(chunk, job, room, _tally if chunk.each or not each else None)


def _count(chunk: Chunk, job: Job, room: Room, tally: Tally | None) -> None:
    """Write a chunk, and count its objects."""
    if tally is None:
        chunk.write(job, room)
    else:
        tally.count(len(chunk.numbers), lambda report: chunk.write(job, room, report))
