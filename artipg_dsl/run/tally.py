"""How many objects of a run are finished, by all of its processes together."""

from __future__ import annotations

import multiprocessing as mp
from collections.abc import Callable
from typing import Any


class Tally:
    """``done`` objects are finished by the process that made it, which tells ``heard`` of those of all. Another process gets it as it is
    started, and tells nobody.
    """

    def __init__(self, done: int, heard: Callable[[int], None]):
        self.done, self.heard = done, heard
        self._others = mp.get_context("spawn").Value("q", 0)
        self._here = True

    def __getstate__(self) -> dict[str, Any]:
        return {"_others": self._others, "_here": False}

    def __setstate__(self, state: dict[str, Any]) -> None:
        self._others, self._here = state["_others"], state["_here"]

    def count(self, objects: int, work: Callable[[Callable[[int, int], None]], None]) -> None:
        """Do some work on so many objects, which is told how to report (done, of) them."""
        told = 0

        def report(done: int, _: int) -> None:
            nonlocal told
            self._add(done - told)
            told = done

        work(report)
        self._add(objects - told)

    def _add(self, objects: int) -> None:
        if self._here:
            self.done += objects
            self.tell()
        else:
            with self._others.get_lock():
                self._others.value += objects

    def tell(self) -> None:
        """Tell of what all have finished by now. What others write is read without their lock: one may have died with it."""
        self.heard(self.done + self._others.get_obj().value)
