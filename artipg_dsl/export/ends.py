"""Whether a file that was copied or written in parts has its end, told by its kind without the packages that read it."""

from __future__ import annotations

import os
from pathlib import Path
from typing import BinaryIO

_HDF5 = b"\x89HDF\r\n\x1a\n"
_LENGTHS = {0: 40, 1: 44, 2: 28, 3: 28}
"""Where an HDF5 file says how long it is, with addresses of 8 bytes, by the version of its superblock (HDF5 File Format Specification,
III.A)."""
_PARQUET = b"PAR1"


def has_end(path: Path) -> bool:
    """Whether a file is whole as far as its form tells: an archive of arrays has its directory, HDF5 the length that it states, Parquet
    its mark, lines of JSON the end of the last one. Of others, whether they hold anything."""
    size = path.stat().st_size
    if not size:
        return False
    with open(path, "rb") as stream:
        if path.suffix in (".npz", ".zip"):
            from zipfile import is_zipfile  # start-up

            return is_zipfile(stream)
        if path.suffix == ".h5":
            return _stated_length(stream) <= size
        if path.suffix == ".parquet":
            return size > 2 * len(_PARQUET) and _last(stream, len(_PARQUET)) == _PARQUET  # it begins with it, too
        return path.suffix != ".jsonl" or _last(stream, 1) == b"\n"


def _stated_length(stream: BinaryIO) -> float:
    """How long an HDF5 file says it is, in bytes; without end where it does not."""
    start = stream.read(64)
    at = _LENGTHS.get(start[8]) if start.startswith(_HDF5) and len(start) == 64 else None
    return float("inf") if at is None else int.from_bytes(start[at : at + 8], "little")


def _last(stream: BinaryIO, count: int) -> bytes:
    stream.seek(0, os.SEEK_END)
    stream.seek(max(stream.tell() - count, 0))
    return stream.read()
