"""Whether a run is one process's work or several's.

Where nobody says how many, a run calls others once its work is known, or found, to take long. The bytes are the same.
"""

from __future__ import annotations

import math
import os
import time
from collections.abc import Callable, Iterable, Iterator, Sequence
from typing import TypeVar

from ..records import dataclass

AUTO = 0  # workers: one per processor, as soon as that is worth their start
MOST = 512  # processes
LONG = math.inf  # seconds that an item takes: however many are left, others are worth their start
_WORTH = 2.0  # seconds of work that are left then: a process takes about 0.6 to start
T = TypeVar("T")
R = TypeVar("R")


def processors() -> int:
    """How many this process may use."""
    return len(os.sched_getaffinity(0)) if hasattr(os, "sched_getaffinity") else os.cpu_count() or 1


@dataclass(frozen=True, slots=True)
class Workers:
    """Who does the work of a run: ``count`` processes here, or ``AUTO``, of ``memory`` bytes together (None: the usual). With a
    ``cluster``, those of the Dask scheduler at this address, each of ``memory``."""

    count: int = 1
    memory: int | None = None
    cluster: str = ""

    @property
    def are_several(self) -> bool:
        """Whether other processes may take part."""
        return self.cluster != "" or (processors() if self.count == AUTO else self.count) > 1


ONE = Workers()
"""This process alone."""


def share(
    items: Sequence[T],
    workers: int,
    alone: Callable[[T], R],
    others: Callable[[Sequence[T], int], Iterable[R]],
    *,
    most: int | None = None,
    pace: float = 0.0,
) -> Iterator[R]:
    """What ``alone`` makes of each item here, or ``others`` (items, processes) of all that are left, in their order.

    Several ``workers`` begin at once. With ``AUTO`` so do as many as there are processors, ``most`` at most, when what is
    left would take this process alone more than ``_WORTH`` seconds, as those before tell; ``pace``: what an item is known to
    take, seconds. The processes that ``others`` are told to be are this one and those that it starts.
    """
    many = workers or min(processors(), most or processors())
    begun = last = time.monotonic()
    for done, item in enumerate(items):
        left, now = len(items) - done, time.monotonic()
        pace = max(now - last, (now - begun) / done) if done else pace
        if min(many, left) > 1 and (workers or pace * left > _WORTH):
            yield from others(items[done:], min(many, left))
            return
        last = now
        yield alone(item)
