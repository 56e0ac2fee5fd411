"""Real objects that are to be fitted, in files and in memory: what they are called, and the cloud of each.

Arrays in memory make the same cloud as a file of them. Either is read when its turn comes, and tells whether it has changed since.
"""

from __future__ import annotations

from collections.abc import Sequence
from hashlib import blake2b
from pathlib import Path

import numpy as np

from ..errors import UserError
from ..records import dataclass
from .reading import Cloud, Solid, check_cloud, read_cloud

_MEMORY = "<memory>"


@dataclass(frozen=True, slots=True)
class File:
    """A real object in a file."""

    path: Path

    def __str__(self) -> str:
        return str(self.path)

    @property
    def suffix(self) -> str:
        """The kind of file, which tells its upward axis."""
        return self.path.suffix.lower()

    def read(self) -> Cloud:
        """Raises UserError with what is wrong with it."""
        return read_cloud(self.path)

    def mark(self) -> str:
        """What it holds, in short; nothing for one that cannot be read."""
        return mark(self.path)

    def require(self, mark: str) -> None:
        """Raises UserError where it is not what once had this mark."""
        if str(self.path) == _MEMORY:
            raise UserError(
                "it was fitted from memory, and its arrays were not kept", "fit it again, and bind it at once"
            )
        if not self.path.exists():
            raise UserError(f"there is no file {self.path}", "name the files that were fitted: apgc bind FITTED FILES")
        if self.mark() != mark:
            raise UserError(f"{self.path} is not the file that was fitted, or has changed since", "fit it again")


@dataclass(frozen=True, slots=True, eq=False)
class Held:
    """A real object in memory: the arrays are those of its owner, not copies, as far as they have the right type."""

    name: str
    held: Cloud | Solid

    def __str__(self) -> str:
        return _MEMORY

    @property
    def suffix(self) -> str:
        return ""

    def read(self) -> Cloud:
        """Raises UserError with what is wrong with it."""
        if isinstance(self.held, Cloud):
            return check_cloud(self.held, self.name)
        if not len(self.held.faces):
            raise UserError(f"{self.name} has no faces", "give its vertices alone to fit them as points")
        return check_cloud(self.held.cloud(self.name), self.name)

    def mark(self) -> str:
        """What it holds, in short."""
        one = self.held
        arrays = (one.points, one.normals) if isinstance(one, Cloud) else (one.vertices, one.faces)
        digest = blake2b(repr(one.names).encode(), digest_size=16)
        for array in (*arrays, one.label):
            digest.update(b"" if array is None else f"{array.shape}".encode() + np.ascontiguousarray(array).tobytes())
        return digest.hexdigest()

    def require(self, mark: str) -> None:
        """Raises UserError where it is not what once had this mark."""
        if self.mark() != mark:
            raise UserError(f"the arrays of {self.name} have changed since they were fitted", "fit it again")


@dataclass(frozen=True, slots=True)
class Item:
    """A real object, and what its results are called."""

    name: str
    real: File | Held


def mark(path: Path) -> str:
    """What a file holds, in short; nothing for one that cannot be read."""
    digest = blake2b(digest_size=16)
    try:
        with open(path, "rb") as stream:
            while block := stream.read(1 << 20):
                digest.update(block)
    except OSError:
        return ""
    return digest.hexdigest()


def name_files(paths: Sequence[Path]) -> list[Item]:
    """Names of files that are their own: as short as their folders allow."""
    if not paths:
        return []
    parts = [[*path.resolve().parts[1:-1], path.stem] for path in paths]
    shared = 0
    while all(len(p) > shared + 1 and p[shared] == parts[0][shared] for p in parts) and len(paths) > 1:
        shared += 1
    shared = min(shared, min(map(len, parts)) - 1) if len(paths) > 1 else len(parts[0]) - 1
    taken: set[str] = set()
    return [Item(own_name("-".join(part[shared:]), taken), File(path)) for path, part in zip(paths, parts, strict=True)]


def own_name(plain: str, taken: set[str]) -> str:
    """A name that none of those ``taken`` is; it is taken then."""
    name, number = plain, 1
    while name in taken:
        number += 1
        name = f"{plain}-{number}"
    taken.add(name)
    return name
