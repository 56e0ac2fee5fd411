"""Folders elsewhere: any file system of fsspec by its address, ``s3://bucket/folder``, with as much of ``Path`` as a folder of samples needs.

A file is there whole or not at all: stores of objects put one in a single step; elsewhere it is written beside its place and moved there.
"""

from __future__ import annotations

import os
import re
from collections.abc import Iterator
from fnmatch import fnmatchcase
from pathlib import Path, PurePosixPath
from typing import Any

from ..errors import UserError
from ..extras import FSSPEC

MARK = ".partial-"
_ADDRESS = re.compile(r"([a-z][a-z0-9+.-]+)://(.*)", re.IGNORECASE | re.DOTALL)
_IN_ONE_STEP = ("s3", "s3a", "gs", "gcs", "az", "abfs", "abfss", "adl", "oci", "oss", "hf", "memory")
_PROCESS = "memory"  # what this one alone sees


class Remote:
    """An address below that of a file system."""

    def __init__(self, address: str):
        self.address = address.rstrip("/")

    def __str__(self) -> str:
        return self.address

    def __repr__(self) -> str:
        return f"Remote({self.address!r})"

    def __eq__(self, other: object) -> bool:
        return isinstance(other, Remote) and other.address == self.address

    def __hash__(self) -> int:
        return hash(self.address)

    def __truediv__(self, name: str) -> Remote:
        return Remote(f"{self.address}/{name}")

    @property
    def name(self) -> str:
        return PurePosixPath(self.address).name

    @property
    def private(self) -> bool:
        """Whether no other process sees it."""
        return self.address.startswith(f"{_PROCESS}://")

    @property
    def _place(self) -> tuple[Any, str]:
        """The file system and the path in it. Raises UserError."""
        FSSPEC.require(self)
        from fsspec.core import url_to_fs

        try:
            return url_to_fs(self.address)
        except (
            ImportError,
            ValueError,
            OSError,
        ) as error:  # its package is missing, nobody knows it, it cannot be reached
            raise UserError(
                f"cannot reach {self}: {error}", "install what fsspec needs for it, or give a folder"
            ) from None

    def exists(self) -> bool:
        files, path = self._place
        return files.exists(path)

    def is_dir(self) -> bool:
        files, path = self._place
        return files.isdir(path)

    def is_file(self) -> bool:
        files, path = self._place
        return files.isfile(path)

    def is_symlink(self) -> bool:
        return False

    def iterdir(self) -> Iterator[Remote]:
        files, path = self._place
        names = sorted(PurePosixPath(found).name for found in files.ls(path, detail=False)) if files.isdir(path) else []
        return (self / name for name in names)

    def glob(self, pattern: str) -> list[Remote]:
        """What lies in it by a name of this form."""
        return [found for found in self.iterdir() if fnmatchcase(found.name, pattern)]

    def read_bytes(self) -> bytes:
        files, path = self._place
        return files.cat_file(path)

    def write_bytes(self, data: bytes) -> None:
        """The file, whole or not at all."""
        files, path = self._place
        if self.address.partition("://")[0].lower() in _IN_ONE_STEP:
            files.pipe_file(path, data)
            return
        folder, _, name = path.rpartition("/")
        beside = f"{folder}/.{name}{MARK}{os.getpid()}"
        files.makedirs(folder, exist_ok=True)
        try:
            files.pipe_file(beside, data)
            files.mv(beside, path)
        finally:
            if files.exists(beside):
                files.rm(beside)

    def unlink(self, missing_ok: bool = False) -> None:
        files, path = self._place
        if not missing_ok or files.exists(path):
            files.rm(path)

    def remove(self) -> None:
        """The folder with all that is in it, if it is there."""
        files, path = self._place
        if files.exists(path):
            files.rm(path, recursive=True)


Place = Path | Remote


def is_same(one: Place, other: Place) -> bool:
    """Whether both are one folder."""
    if isinstance(one, Remote) or isinstance(other, Remote):
        return one == other
    return one.resolve() == other.resolve()


def place_of(name: str | Path | Remote) -> Place:
    """A folder by its name or address; ``file://`` is one here. Raises UsageError for what is neither."""
    if not isinstance(name, Remote):
        from ..arguments import read_path  # start-up: NumPy

        read_path("a folder", name, '"microwaves"')
    match = _ADDRESS.fullmatch(str(name))
    if match is None or isinstance(name, Path):
        return name if isinstance(name, Remote) else Path(name)
    return Path(match[2]) if match[1].lower() in ("file", "local") else Remote(str(name))
