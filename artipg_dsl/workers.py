"""Chunks of a run written by several processes: the same bytes, sooner.

A worker gets the job once, plans the program anew, and gives back what it counted. It ends with the run: on Ctrl-C at once, and
when the process that started it is gone.
"""

from __future__ import annotations

import multiprocessing as mp
import os
import signal
import threading
from collections.abc import Iterator
from concurrent.futures import ProcessPoolExecutor
from concurrent.futures.process import BrokenProcessPool
from dataclasses import replace
from typing import TYPE_CHECKING

from .errors import UserError
from .runtime.sample import Statistics

if TYPE_CHECKING:
    from .export.chunk import Chunk
    from .job import Job

INTERRUPTED = 130
_job: Job | None = None  # what this worker works for


def share(job: Job, count: int, chunks: list[Chunk]) -> Iterator[Chunk]:
    """Write the chunks with ``count`` processes and give each back, in their order; the job's statistics take what was counted.

    Raises what the first chunk that fails raises, and UserError where a process dies.
    """
    before = set(mp.active_children())
    # spawned, not forked: libraries that run threads do not outlive a fork, and it is the same on all systems
    pool = ProcessPoolExecutor(
        max(1, min(count, len(chunks))), mp_context=mp.get_context("spawn"), initializer=_begin,
        initargs=(replace(job, statistics=Statistics()),),
    )  # fmt: skip
    try:
        for chunk, counted in zip(chunks, pool.map(_write, chunks), strict=True):
            job.statistics.take(counted)
            yield chunk
    except BrokenProcessPool:
        raise UserError(
            "a worker process died, perhaps for lack of memory",
            "use fewer --workers, or fewer --points or --views; the same command completes what is missing",
        ) from None
    finally:  # after the last chunk nobody works any more; before it, nobody is to go on
        pool.shutdown(wait=False, cancel_futures=True)
        for child in set(mp.active_children()) - before:
            child.terminate()


def _begin(job: Job) -> None:
    global _job
    _job = job
    signal.signal(signal.SIGINT, lambda *_: os._exit(INTERRUPTED))
    parent = mp.parent_process()
    assert parent is not None

    def outlive_nobody() -> None:
        parent.join()
        os._exit(1)

    threading.Thread(target=outlive_nobody, daemon=True).start()


def _write(chunk: Chunk) -> Statistics:
    assert _job is not None
    job = replace(_job, statistics=Statistics())
    chunk.write(job.batch)
    return job.statistics if chunk.counted else Statistics()
