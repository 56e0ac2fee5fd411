"""Nothing is collected while something large is built that is kept: looking through it again and again only costs time."""

from __future__ import annotations

import gc
from collections.abc import Iterator
from contextlib import contextmanager
from threading import Lock

_LOCK = Lock()
_depth = 0
_was_enabled = False


@contextmanager
def uncollected() -> Iterator[None]:
    """Within it the collector of circular garbage rests; it may be entered again, also by other threads."""
    global _depth, _was_enabled
    with _LOCK:
        if not _depth:
            _was_enabled = gc.isenabled()
            gc.disable()
        _depth += 1
    try:
        yield
    finally:
        with _LOCK:
            _depth -= 1
            if not _depth and _was_enabled:
                gc.enable()
