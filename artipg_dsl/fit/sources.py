"""Real objects that are to be fitted, in files and in memory: what they are called, and the cloud of each.

Arrays in memory make the same cloud as a file of them, which has the same mark. Either is read when its turn comes, and tells whether it has
changed since.
"""

from __future__ import annotations

from collections.abc import Sequence
from hashlib import blake2b
from pathlib import Path

import numpy as np

from ..errors import UserError
from ..export.containers import npz_bytes
from ..records import dataclass
from .reading import Cloud, Solid, check_cloud, parts_of, read_cloud

MEMORY = "<memory>"  # the source of what is in no file
_LONGEST = 200  # bytes of a name: of a file 255, with what is written beside it


@dataclass(frozen=True, slots=True)
class File:
    """A real object in a file. ``held``: it was fitted from memory, and the file keeps its arrays."""

    path: Path
    held: bool = False

    def __str__(self) -> str:
        return MEMORY if self.held else _in_unicode(str(self.path))

    @property
    def suffix(self) -> str:
        """The kind of file, which tells its upward axis."""
        return self.path.suffix.lower()

    def read(self) -> Cloud:
        """Raises UserError with what is wrong with it."""
        if str(self) != str(self.path) and not self.held:
            raise UserError("its path is not in UTF-8", "rename it: records could not name it")
        return read_cloud(self.path)

    def mark(self) -> str:
        """What it holds, in short; nothing for one that cannot be read."""
        return mark(self.path)

    def require(self, mark: str) -> None:
        """Raises UserError where it is not what once had this mark."""
        if not self.path.exists():
            where = "if it has moved, name it: apgc bind FITTED FILES, in Python open_fitted(FITTED, FILES)"
            raise UserError(f"there is no file {self.path}", where)
        if self.mark() != mark:
            raise UserError(f"{self.path} is not the file that was fitted, or has changed since", "fit it again")

    def bytes(self) -> bytes:
        """What it holds. Raises UserError where it cannot be read."""
        try:
            return self.path.read_bytes()
        except OSError as wrong:
            raise UserError(f"{self.path} cannot be read: {wrong.strerror or wrong}", "fit it again") from None


@dataclass(frozen=True, slots=True, eq=False)
class Held:
    """A real object in memory: the arrays are those of its owner, not copies, as far as they have the right type."""

    name: str
    held: Cloud | Solid

    def __str__(self) -> str:
        return MEMORY

    @property
    def suffix(self) -> str:
        return ""

    def read(self) -> Cloud:
        """Raises UserError with what is wrong with it."""
        one = self.held
        return check_cloud(one if isinstance(one, Cloud) else one.surface(self.name), self.name)

    def mark(self) -> str:
        """What it holds, in short."""
        return blake2b(self.bytes(), digest_size=16).hexdigest()

    def bytes(self) -> bytes:
        """Its arrays as the ``.npz`` that keeps them: read again, it is the same."""
        one = self.held
        if isinstance(one, Cloud):
            arrays = {"points": one.points} | ({} if one.normals is None else {"normals": one.normals})
        else:
            arrays = {"vertices": one.vertices, "faces": one.faces}
        named = {"label": one.label, "label_names": np.array(one.names, dtype=np.str_)} if one.names else {}
        return npz_bytes(arrays | named)

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
    """What a file holds, in short, with those that it is read from; nothing for one that cannot be read."""
    digest = blake2b(digest_size=16)
    try:
        for one in (path, *parts_of(path)):
            with open(one, "rb") as stream:
                while block := stream.read(1 << 20):
                    digest.update(block)
    except OSError:
        return ""
    return digest.hexdigest()


def _in_unicode(text: str) -> str:
    """A path or a name as text can have it: bytes that are not UTF-8 are told as such."""
    return text.encode(errors="surrogateescape").decode(errors="replace")


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
    """A name that none of those ``taken`` is; it is taken then. Of a long one the end is left."""
    plain = _in_unicode(plain).encode()[-_LONGEST:].decode(errors="ignore")
    name, number = plain, 1
    while name in taken:
        number += 1
        name = f"{plain}-{number}"
    taken.add(name)
    return name
