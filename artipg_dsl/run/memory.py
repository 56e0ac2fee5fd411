"""How many objects are made together: as many as fit into the memory that a run may take.

What an object takes is measured while the run goes on: by how much the process has grown, at most, since a block of objects was begun.
It is kept between runs (see ``cache``): without it a run begins with few objects, which take nearly as long as many. So is the time
that an object takes, which tells whether other processes are worth their start. Few objects say more of what is done once, so only
blocks of some size tell another run anything.
The bytes of the files do not depend on it, since an object is the same whatever else is made with it.
"""

from __future__ import annotations

import os
import re
import sys
import time
from pathlib import Path

from .. import cache
from ..errors import UsageError
from ..records import dataclass

USUAL = 2 * 10**9
_ONE = 512_000_000  # what a process among several may take, where nobody limits them
_LEAST = 256_000_000  # Python, NumPy and a program take half of this
_UNITS = {"MB": 10**6, "GB": 10**9, "TB": 10**12}
_MOST = 1 << 50
_FIRST = 16  # objects, of which nothing is known yet
_STEP = 8.0  # seconds after which a run tells how far it is: a block costs hundredths of that beside its objects
_DOUBT = 2.0  # times what an object took in another run
_TELLING = 32  # objects in a block that tells what one takes: fewer say more of what is done once
_SHARD = 0.256  # of the memory is what a shard may hold: there are its arrays, the file, and what they are made of
_STATM = Path("/proc/self/statm")


def read_memory(text: str) -> int:
    """``2GB`` or ``512MB`` as bytes. Raises UsageError."""
    match = re.fullmatch(r"\s*(\d{1,9}(?:\.\d{1,9})?)\s*(MB|GB|TB)\s*", text, re.IGNORECASE)
    if match is None:
        raise UsageError(f"the memory {text!r} is not a size", "write 2GB or 512MB")
    size = int(float(match[1]) * _UNITS[match[2].upper()])
    if not _LEAST <= size <= _MOST:
        raise UsageError(
            f"{text.strip()} of memory is {'too little' if size < _LEAST else 'more than there is'}",
            f"write {_LEAST // 10**6}MB or more: Python and a program take half of that; the default is 2GB",
        )
    return size


def shard_bytes(memory: int) -> int:
    """How large a shard may be."""
    return int(memory * _SHARD)


def share_of(memory: int | None, processes: int) -> int:
    """What each of several processes may take of ``memory`` bytes; None: of the usual, if that is half a gigabyte for each."""
    return (memory or max(USUAL, processes * _ONE)) // processes


def most_processes(memory: int | None) -> int | None:
    """How many processes have room in ``memory`` bytes, None: in half of what the machine has; None where that cannot be told."""
    if memory:
        return max(1, memory // _LEAST)
    try:
        return max(1, os.sysconf("SC_PAGE_SIZE") * os.sysconf("SC_PHYS_PAGES") // 2 // _ONE)
    except (AttributeError, OSError, ValueError):
        return None


@dataclass(slots=True)
class Room:
    """The memory that one process may take, and what an object took of it in the last block, or, as the ``entry`` of the cache says,
    in another run; and the ``seconds`` that an object took in the quickest block, and in another run. ``told``: a block of some
    size has told what an object takes; before that, what another run has found counts for more."""

    memory: int = USUAL
    entry: str = ""
    each: float = 0.0
    told: bool = False
    seconds: float = 0.0
    known: tuple[float, float] | None = None
    begun: int = 0
    most: int = 0
    clock: float = 0.0

    def begin(self, left: int) -> int:
        """How many of the objects that are left are made next."""
        self.begun, self.most, self.clock = _resident(), _peak(), time.monotonic()
        known = _DOUBT * self._known()[0]
        each, pace = self.each if self.told else known or self.each, self.pace()
        soon = max(_FIRST, int(_STEP / pace)) if pace else left
        return min(left, soon, max(1, int((self.memory - self.begun) / each)) if each else _FIRST)

    def end(self, made: int) -> None:
        """So many have been made."""
        most = _peak()
        bound = max(1.0, (most - self.begun) / made)  # exact where the process has never been as large
        tells = made >= _TELLING
        if tells or not self.told:
            fresh = most > self.most or tells > self.told or not self.each
            self.each, self.told = bound if fresh else min(self.each, bound), tells
        if tells:
            spent = (time.monotonic() - self.clock) / made
            self.seconds = min(spent, self.seconds) if self.seconds else spent

    def pace(self) -> float:
        """How long an object is known to take, seconds; 0 where nobody knows."""
        return self.seconds or self._known()[1]

    def keep(self) -> None:
        """Write what an object takes, where that is news."""
        known = self._known()
        found = self.each if self.told else known[0], self.seconds or known[1]
        if self.entry and any(
            new and not new / _DOUBT < old < new * _DOUBT for new, old in zip(found, known, strict=True)
        ):
            self.known = found
            cache.write(self.entry, f"{found[0]:.0f} {found[1]:.6f}".encode())

    def _known(self) -> tuple[float, float]:
        """What an object took in another run: bytes and seconds, 0 where nobody knows."""
        if self.known is None:
            self.known = _read(self.entry) if self.entry else (0.0, 0.0)
        return self.known


def _read(entry: str) -> tuple[float, float]:
    found = re.fullmatch(rb"(\d{1,15}) (\d{1,6}\.\d{1,6})", cache.read(entry) or b"")
    return (float(found[1]), float(found[2])) if found else (0.0, 0.0)


def _resident() -> int:
    """What the process takes now, bytes; where that cannot be told, nothing."""
    try:
        import resource

        return int(_STATM.read_bytes().split()[1]) * resource.getpagesize()
    except (ImportError, OSError):
        return 0


def _peak() -> int:
    """The most that it has taken, bytes."""
    try:
        import resource
    except ImportError:  # Windows has no such thing: as if it were little
        return 0
    most = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss
    return most if sys.platform == "darwin" else most * 1024
