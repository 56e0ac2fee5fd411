"""Memory that a process has had is kept for what it needs next: pages that the system gives anew have to be cleared first, and
arrays of a few megabytes live for a moment only. That took a tenth of a sample.
"""

from __future__ import annotations

import os
from contextlib import suppress

_TRIM, _MMAP = -1, -3  # M_TRIM_THRESHOLD and M_MMAP_THRESHOLD of <malloc.h>
_KEPT = 256 << 20  # what lies unused at the end of the heap is given back beyond this
_LARGE = 32 << 20  # the most that all versions take: larger arrays are mapped, and given back at once


def hold_pages() -> None:
    """Free memory stays with this process, which is ours: a library does not decide this for the programs that import it.

    Nothing happens where the C library is not GNU's, or where the environment says how it allocates.
    """
    # a huge page is cleared as a whole for an array that needs a part of it; NumPy reads this when it is loaded
    os.environ.setdefault("NUMPY_MADVISE_HUGEPAGE", "0")
    if not any(name.startswith("MALLOC_") or name == "GLIBC_TUNABLES" for name in os.environ):
        from ctypes import CDLL  # late: not all commands need it

        with suppress(AttributeError, OSError, TypeError):  # TypeError: Windows has no library of the program itself
            set_option = CDLL(None).mallopt
            set_option(_MMAP, _LARGE)
            set_option(_TRIM, _KEPT)
