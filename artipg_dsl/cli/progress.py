"""A progress bar on stderr, drawn only where somebody watches."""

from __future__ import annotations

import sys
import time
from typing import TextIO

WIDTH = 30


class Progress:
    """Call it with (done, total); ``close`` wipes the line. Silent unless the stream is a terminal."""

    def __init__(self, title: str, stream: TextIO | None = None):
        self.title, self.stream = title, stream if stream is not None else sys.stderr
        self.live = self.stream.isatty()
        self.begun = time.monotonic()
        self.drawn = 0.0

    def __call__(self, done: int, total: int) -> None:
        now = time.monotonic()
        if not self.live or not total or (now - self.drawn < 0.1 and done < total):
            return
        self.drawn = now
        share = done / total
        left = (now - self.begun) * (1 - share) / share if share else 0.0
        bar = "#" * int(WIDTH * share) + "." * (WIDTH - int(WIDTH * share))
        soon = f"  {left:.0f} s left" if 0 < share < 1 else ""
        self.stream.write(f"\r\x1b[K{self.title} [{bar}] {done}/{total}{soon}")
        self.stream.flush()

    def close(self) -> None:
        if self.live:
            self.stream.write("\r\x1b[K")
            self.stream.flush()

    def __enter__(self) -> Progress:
        return self

    def __exit__(self, *_: object) -> None:
        self.close()
