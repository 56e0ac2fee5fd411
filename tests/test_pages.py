"""Freed memory stays with the processes of the command line."""

from __future__ import annotations

import os
import platform
import subprocess
import sys

import pytest

_FRESH = """
import resource, sys
from artipg_dsl.pages import hold_pages
hold_pages()
import numpy as np
def faults():
    before = resource.getrusage(resource.RUSAGE_SELF).ru_minflt
    np.ones(2_000_000)
    return resource.getrusage(resource.RUSAGE_SELF).ru_minflt - before
faults()
print(faults())
"""


def _faults(**more: str) -> int:
    own = {name: value for name, value in os.environ.items() if not name.startswith(("MALLOC_", "NUMPY_", "GLIBC_"))}
    return int(
        subprocess.run(
            [sys.executable, "-c", _FRESH], env=own | more, text=True, capture_output=True, check=True
        ).stdout
    )


@pytest.mark.skipif(platform.libc_ver()[0] != "glibc", reason="other C libraries have no such options")
def test_pages_of_an_array_are_used_again() -> None:
    assert _faults() < 50  # of 3,900 pages


@pytest.mark.skipif(platform.libc_ver()[0] != "glibc", reason="other C libraries have no such options")
def test_what_the_environment_says_of_memory_holds() -> None:
    assert _faults(MALLOC_MMAP_THRESHOLD_="65536", NUMPY_MADVISE_HUGEPAGE="0") > 3000
