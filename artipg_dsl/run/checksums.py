"""Records of what has been written: a line for each file, its checksum and its name, as ``b2sum`` has them.

The last line seals those above, so that a record that has lost some or says something else is noticed. Names without checksums
are those of a record that is being written, or that an older version has.
"""

from __future__ import annotations

import re
from collections.abc import Iterator, Mapping
from hashlib import blake2b, file_digest
from pathlib import Path

from ..export.write import write_bytes

_BYTES = 16
_LINE = re.compile(rf"([0-9a-f]{{{2 * _BYTES}}})  (.+)")
_SEAL = "# "


def checksum(data: bytes) -> str:
    """Of the contents of a file."""
    return blake2b(data, digest_size=_BYTES).hexdigest()


def checksum_of(path: Path) -> str:
    """Of a file. Raises OSError."""
    with open(path, "rb") as stream:
        return file_digest(stream, lambda: blake2b(digest_size=_BYTES)).hexdigest()


def read_names(record: Path) -> dict[str, str]:
    """The checksums of a record by name, "" where there is none, as far as it can be read: a spoilt one names nothing that is there."""
    text = record.read_text(encoding="utf-8", errors="replace") if record.exists() else ""
    lines = [line for line in text.splitlines() if not line.startswith(_SEAL)]
    found = ((_LINE.fullmatch(line), line) for line in lines)
    return {match[2] if match else line: match[1] if match else "" for match, line in found}


def keep_names(record: Path, names: Mapping[str, str], *, whole: bool = True) -> None:
    """Write a record, sealed where it is ``whole``. Raises ExportError."""
    body = "".join(sorted(f"{held}  {name}\n" if held else f"{name}\n" for name, held in names.items()))
    seal = f"{_SEAL}{checksum(body.encode())}\n" if whole else ""
    write_bytes(record, (body + seal).encode(), force=True)


def damage(folder: Path, record: str, *, sealed: bool) -> Iterator[tuple[str, str]]:
    """What of a folder is not as one of its records has it: (file, what is wrong), each once. ``sealed``: the record has to be, even if
    it has no checksums."""
    path = folder / record
    if not path.is_file():
        yield record, "the file is missing"
        return
    lines, names = path.read_bytes().splitlines(keepends=True), read_names(path)
    if (sealed or any(names.values())) and lines[-1:] != [f"{_SEAL}{checksum(b''.join(lines[:-1]))}\n".encode()]:
        yield record, "is damaged: it has lost some of its lines, or says something else"
        return
    for name, held in names.items():
        if wrong := _damage(folder / name, held):
            yield name, wrong


def _damage(path: Path, held: str) -> str:
    if not path.is_file():
        return "the file is missing"
    if not held or checksum_of(path) == held:
        return ""
    return "is not as it was written" if path.stat().st_size else "is empty"
