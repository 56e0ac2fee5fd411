"""How many objects are made together: as many as fit into the memory that a run may take.

What an object takes is measured while the run goes on: by how much the process has grown, at most, since a block of objects was begun.
It is kept between runs (see ``cache``): without it a run begins with few objects, which take nearly as long as many.
The bytes of the files do not depend on it, since an object is the same whatever else is made with it.
"""

from __future__ import annotations

import os
import re
import sys
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
_DOUBT = 2.0  # times what an object took in another run
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
    in another run."""

    memory: int = USUAL
    entry: str = ""
    each: float = 0.0
    known: float = 0.0
    begun: int = 0
    most: int = 0

    def begin(self, left: int) -> int:
        """How many of the objects that are left are made next."""
        self.begun, self.most = _resident(), _peak()
        if not self.each and self.entry and not self.known:
            self.known = _read(self.entry)
        each = self.each or _DOUBT * self.known
        return min(left, max(1, int((self.memory - self.begun) / each)) if each else _FIRST)

    def end(self, made: int) -> None:
        """So many have been made."""
        most = _peak()
        bound = max(1.0, (most - self.begun) / made)  # exact where the process has never been as large
        self.each = bound if most > self.most or not self.each else min(self.each, bound)

    def keep(self) -> None:
        """Write what an object takes, where that is news."""
        if self.entry and self.each and not self.each / _DOUBT < self.known < self.each * _DOUBT:
            self.known = self.each
            cache.write(self.entry, f"{self.each:.0f}".encode())


def _read(entry: str) -> float:
    """What an object took in another run, bytes; 0 where nobody knows."""
    found = cache.read(entry) or b""
    return float(found) if found.isdigit() and len(found) < 16 else 0.0


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
