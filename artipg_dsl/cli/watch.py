"""``apgc watch``: check a program whenever it or a module that it may use is saved, and draw it.

A process that stays has loaded what it needs, and has read the library: for an edited program, lowering and its own checks are left.
"""

from __future__ import annotations

import argparse
import sys
import time
from collections.abc import Iterable
from pathlib import Path

from ..diagnostics import CompileError
from ..errors import UsageError, UserError, plural
from ..export.write import require_place
from ..resources import library_dir
from .compile import of_text
from .messages import error, findings, say

_PERIOD = 0.2  # seconds between two looks at the files
_SETTLED = 0.05  # seconds for which they stay as they are before they are read: a file that is being saved may be empty

Seen = dict[Path, tuple[int, int, int]]


def run(options: argparse.Namespace) -> int:
    if options.out is not None:
        require_place(Path(options.out), options.force)
    elif (
        options.number
        or options.only
        or options.seed is not None
        or options.set
        or options.prior
        or options.frame
        or options.force
    ):
        raise UsageError("these options say what is drawn, and nothing is", "add -o FILE, or leave them out")
    session = of_text(options.program)
    if session.path is None or not session.path.is_file():
        findings(session.examine().diagnostics, sys.stdout)
        return 1
    folders = session.path.parent, library_dir()  # where `use` looks
    say(f"watching {session.path}, and the modules it uses: press Ctrl+C to stop")
    seen: Seen | None = None
    try:
        while True:
            now = _settled(folders)
            if now == seen:
                time.sleep(_PERIOD)
                continue
            seen = now
            _look(options)
    except KeyboardInterrupt:
        say("")
        return 0


def _look(options: argparse.Namespace) -> None:
    """Say what is found in the program as it is now, and draw it where nothing is wrong."""
    from ..diagnostics.text import summary  # start-up: for programs that are there

    begun = time.monotonic()
    report = of_text(options.program).examine()
    findings(report.diagnostics, sys.stdout)
    say(f"{time.strftime('%H:%M:%S')}  {summary(report.diagnostics)} ({time.monotonic() - begun:.1f} s)")
    if options.out is not None and not report.failed:
        try:
            _draw(options)
        except UserError as wrong:  # the next text may do better
            error(wrong.message, wrong.hint)
        except CompileError:
            pass  # it has been saved again meanwhile, and the next look tells


def _draw(options: argparse.Namespace) -> None:
    from ..run.painting import paint_with  # start-up: for those who want a picture
    from ..run.progress import Progress
    from ..run.sharing import AUTO
    from ..view.sheet import write_sheet
    from .wanted import open_wanted

    job = open_wanted(options)
    with Progress("drawing") as progress:
        write_sheet(job.batch(), options.out, force=True, progress=progress, paint_all=paint_with(AUTO))
    say(f"          drew {plural(len(job.request.objects), 'object')} to {options.out}")


def _settled(folders: Iterable[Path]) -> Seen:
    """The modules in some folders, once none of them changes."""
    now = _modules(folders)
    while True:
        time.sleep(_SETTLED)
        before, now = now, _modules(folders)
        if now == before:
            return now


def _modules(folders: Iterable[Path]) -> Seen:
    """What tells whether a module has been saved: per file its time, size and number."""
    found: Seen = {}
    for folder in folders:
        for path in folder.glob("*.apg"):
            try:
                told = path.stat()
            except OSError:  # it is being replaced
                continue
            found[path] = told.st_mtime_ns, told.st_size, told.st_ino
    return found
