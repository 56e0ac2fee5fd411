"""A line on stderr that tells how far a piece of work is, and at which stage."""

from __future__ import annotations

import sys
import time
from threading import Event, Lock, Thread
from typing import TextIO

_WIDTH = 30
OFTEN, SELDOM = (
    1.0,
    20.0,
)  # seconds between lines: drawn again where somebody watches, written one below the other elsewhere


def took(begun: float) -> str:
    """How long a command took that began at ``begun``."""
    return f"({time.monotonic() - begun:.1f} s)"


class Progress:
    """Call it with (done, total); ``stage`` says what is being done; ``close`` wipes the line.

    Where nobody watches (the stream is no terminal) it is silent until work has taken ``SELDOM`` seconds, and then
    writes a line as often as that.
    """

    def __init__(self, title: str, stream: TextIO | None = None):
        self.title, self.stream = title, stream if stream is not None else sys.stderr
        self.live = self.stream.isatty()
        self.begun = time.monotonic()
        self.drawn = 0.0
        self.at = 0, 0
        self.first: tuple[int, float] | None = None  # what was done when counting began, and when that was
        self.moved = self.begun  # when the count last went on
        self.doing = ""
        self._over, self._lock = Event(), Lock()

    def __call__(self, done: int, total: int) -> None:
        self._count(done, total)
        if self.live and total and (time.monotonic() - self.drawn >= 0.1 or done >= total):
            self._draw()

    def stage(self, doing: str, done: int | None = None, total: int = 0) -> None:
        """What is being done from now on; with ``done`` of ``total``, a stage that is counted for itself."""
        new, self.doing = doing != self.doing, doing
        if done is not None:
            if new:
                self.first = None
            self._count(done, total)
        if self.live and (new or time.monotonic() - self.drawn >= 0.1):
            self._draw()

    def _count(self, done: int, total: int) -> None:
        now = time.monotonic()
        if self.first is None:
            self.first = done, now
        if done != self.at[0]:
            self.moved = now
        self.at = done, total

    def _left(self, now: float) -> float | None:
        """The seconds that are left, by how long it took what has been counted; None while that tells nothing: before
        anything is, and once what is under way has taken longer than all that is left should."""
        (done, total), (before, since) = self.at, self.first or (0, now)
        if not before < done < total:
            return None
        left = (self.moved - since) / (done - before) * (total - done) - (now - self.moved)
        return left if left > 0.0 else None

    def line(self) -> str:
        """Title and stage, how much is done, and how long it may take, or has taken where that is not known."""
        (done, total), now = self.at, time.monotonic()
        spent = now - self.begun
        words = f"{self.title}: {self.doing}" if self.doing else self.title
        share = done / total if total else 0.0
        bar = ""
        if total:
            filled = int(_WIDTH * share)
            bar = f" [{'#' * filled}{'.' * (_WIDTH - filled)}] {done}/{total}"
        left = self._left(now)
        time_of = f"  {left:.0f} s left" if left is not None else f"  {spent:.0f} s" if spent >= 1 else ""
        return words + bar + time_of

    def close(self) -> None:
        self._over.set()
        if self.live:
            self._write("\r\x1b[K")

    def _draw(self) -> None:
        self.drawn = time.monotonic()
        self._write("\r\x1b[K" + self.line())

    def _write(self, text: str) -> None:
        with self._lock:
            try:
                self.stream.write(text)
                self.stream.flush()
            except (OSError, ValueError):  # whoever read it is gone
                self._over.set()

    def _watch(self) -> None:
        """While the work is in a long step, tell that it goes on."""
        while not self._over.wait(OFTEN if self.live else SELDOM):
            if self.live:
                self._draw()
            else:
                self._write(self.line() + "\n")

    def __enter__(self) -> Progress:
        Thread(target=self._watch, daemon=True).start()
        return self

    def __exit__(self, *_: object) -> None:
        self.close()
