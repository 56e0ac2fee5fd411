"""What a batch system or a closed terminal sends ends a command as Ctrl-C does: files that are begun go, processes end."""

from __future__ import annotations

import signal
import threading
from collections.abc import Iterator
from contextlib import contextmanager
from types import FrameType

_SIGNALS = [getattr(signal, name) for name in ("SIGTERM", "SIGHUP") if hasattr(signal, name)]


class Stopped(KeyboardInterrupt):
    """The command is told to end; ``code`` is the exit code by which shells tell of the signal."""

    def __init__(self, number: int) -> None:
        super().__init__()
        self.code = 128 + number


@contextmanager
def heeding() -> Iterator[None]:
    """While a command runs, the first of these signals raises ``Stopped``, and a second one kills. One that is ignored, as
    under nohup, or that a program around has taken stays as it is."""
    if threading.current_thread() is not threading.main_thread():
        yield
        return
    taken = [number for number in _SIGNALS if signal.getsignal(number) is signal.SIG_DFL]

    def let_go() -> None:
        for number in taken:
            signal.signal(number, signal.SIG_DFL)

    def stop(number: int, _: FrameType | None) -> None:
        let_go()
        raise Stopped(number)

    try:
        for number in taken:
            signal.signal(number, stop)
        yield
    finally:
        let_go()
