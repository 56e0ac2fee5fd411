"""Work shared by several machines: the chunks of a run as tasks of a Dask cluster. The same bytes as by one process.

A chunk writes its own files, whole or not at all, and gives nothing back: one that was lost with its worker is done again by another.
"""

from __future__ import annotations

import os
import pickle
from collections import deque
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import replace
from importlib import import_module
from itertools import islice
from pathlib import Path
from typing import Any

from ..errors import UsageError, UserError
from ..export.write import is_there
from ..extras import DASK
from .chunk import Chunk
from .job import Job
from .memory import Room

_LOCAL = "local"
_AHEAD = 4  # tasks for each core that wait
_SHARED = "write to a folder that all of them share, or to an address such as s3://bucket/out"


def write_on_cluster(job: Job, address: str, workers: int, chunks: list[Chunk], room: Room) -> Iterator[Chunk]:
    """Write the chunks by the workers of the Dask scheduler at ``address``, or of a cluster of so many processes here
    (``local``), and give each back, in their order.

    Raises what the first chunk that fails raises, and UserError where there is no such cluster or its workers die.
    """
    with _client(address, workers) as client:
        from distributed import KilledWorker

        # a task and not data: it is done again where its worker is lost
        given = client.submit(_unpack, pickle.dumps((job.fresh(), room)), pure=False)
        left = iter(chunks)

        def submit(count: int) -> list[tuple[Chunk, Any]]:
            return [(c, client.submit(_write, given, _placed(c), pure=False)) for c in islice(left, count)]

        tasks = deque(submit(_AHEAD * max(1, sum(client.ncores().values()))))
        while tasks:
            chunk, task = tasks.popleft()
            try:
                task.result()
            except KilledWorker:
                raise UserError(
                    "workers of the cluster died one after the other, perhaps for lack of memory",
                    "use less --memory, or smaller shards; the same command completes what is missing",
                ) from None
            if chunk.counts and not is_there(chunk.out / chunk.counts):
                raise UserError(f"the workers of the cluster write to another {chunk.out} than is seen here", _SHARED)
            tasks.extend(submit(1))
            yield chunk


def require_cluster(address: str, workers: int) -> None:
    """Raises UserError where Dask is not installed, or no scheduler answers at ``address``, whose processes nobody here counts."""
    if address == _LOCAL:
        _import_dask()
    else:
        if workers > 1:
            raise UsageError(
                f"--workers {workers} does not apply to a cluster that runs elsewhere: {address} has its own workers",
                f"leave out --workers, or write `{_LOCAL}` for a cluster of {workers} processes here",
            )
        with _client(address, 1):
            pass


def _import_dask() -> Any:
    """Raises UserError."""
    DASK.require("--cluster")
    return import_module("distributed")  # loosely typed


@contextmanager
def _client(address: str, workers: int) -> Iterator[Any]:
    """What hands tasks to the cluster. Raises UserError."""
    dask = _import_dask()
    if address == _LOCAL:
        with (
            dask.LocalCluster(
                n_workers=workers, threads_per_worker=1, processes=True, dashboard_address=None, silence_logs=50
            ) as cluster,
            dask.Client(cluster) as client,
        ):
            yield client
        return
    try:
        client = dask.Client(address, timeout=10)
    except (OSError, ValueError) as error:  # TimeoutError is one of them
        raise UserError(
            f"no Dask scheduler answers at {address}: {error}",
            f"write tcp://host:8786, or `{_LOCAL}` for a cluster here",
        ) from None
    with client:
        yield client


def _placed(chunk: Chunk) -> Chunk:
    """The chunk as another process finds it, wherever that was started."""
    return replace(chunk, out=Path(os.path.abspath(chunk.out))) if isinstance(chunk.out, Path) else chunk


def _unpack(given: bytes) -> tuple[Job, Room]:
    return pickle.loads(given)


def _write(given: tuple[Job, Room], chunk: Chunk) -> None:
    chunk.write(*given)
