"""What the commands say: findings of the compiler, and errors of the user."""

from __future__ import annotations

import os
import sys
from collections.abc import Iterable
from typing import TYPE_CHECKING, TextIO

from ..errors import printable

if TYPE_CHECKING:
    from ..diagnostics import Diagnostic

RED, BLUE, RESET = "\x1b[1;31m", "\x1b[34m", "\x1b[0m"


def _coloured(stream: TextIO) -> bool:
    return stream.isatty() and "NO_COLOR" not in os.environ


def say(text: str) -> None:
    """A word to whoever watches: on stderr, so that stdout holds results alone."""
    print(text, file=sys.stderr, flush=True)


def error(message: str, hint: str | None) -> None:
    red, blue, reset = (RED, BLUE, RESET) if _coloured(sys.stderr) else ("", "", "")
    say(f"{red}error{reset}: {printable(message)}" + (f"\n  {blue}={reset} help: {printable(hint)}" if hint else ""))


def findings(diagnostics: Iterable[Diagnostic], stream: TextIO) -> None:
    from ..diagnostics.text import render

    text = render(diagnostics, colour=_coloured(stream))
    if text:
        print(text, file=stream, flush=True)
