"""How far long work is, as Python asks to be told."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from contextlib import contextmanager
from typing import TypeAlias

import numpy as np

from ..errors import UsageError

Told: TypeAlias = "bool | Callable[[int, int], None]"  # a line on stderr, or a function of (done, total)


def find_stage(tell: Callable[[int, int], None], doing: str) -> Callable[[str], None]:
    """What is to be called with what is being done, in words after ``doing``, which a line on stderr shows; a function is not told."""
    from ..run.progress import Progress

    return (lambda what: tell.stage(f"{doing} {what}")) if isinstance(tell, Progress) else lambda _: None


@contextmanager
def telling(progress: Told, title: str, doing: str) -> Iterator[Callable[[int, int], None]]:
    """What is to be called with (done, total) while something is ``doing``. Raises UsageError."""
    if callable(progress):
        yield progress
        return
    if not isinstance(progress, bool | np.bool_):
        raise UsageError(f"progress is {progress!r}", "give True for a line on stderr, or a function of (done, total)")
    if not progress:
        yield lambda *_: None
        return
    from ..run.progress import Progress

    with Progress(title) as line:
        line.stage(doing)
        yield line
