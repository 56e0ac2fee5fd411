"""What has been computed before, kept in files for the next process: content-addressed, and never needed.

An entry is named by a hash of everything it follows from, and holds data alone: whoever reads it verifies what it says, and
computes anew where that fails. So the folder may be shared, cut short by a kill, spoilt or deleted at any time. It lies where
the platform keeps caches; ``APGC_CACHE`` names another place, and ``APGC_CACHE=off`` keeps nothing.
"""

from __future__ import annotations

import os
import sys
import time
from collections.abc import Iterable
from functools import cache
from hashlib import blake2b
from importlib.util import find_spec
from pathlib import Path

from .records import dataclass
from .resources import grammar_file

MARK = b"apgc kept 2\n"
MOST = 256 << 20  # bytes; the entries that were read longest ago go first
_LEFT = 0.75  # of these bytes are left after that
_STALE = 3600.0  # seconds after which an unfinished file is of a process that was killed
# one hash in 256 ends so: after its entry the folder is looked through, which takes 10 ms for 1,500 entries
_LOOKED = "00"
SEAL = 32  # bytes before the data: a hash of the name and of the data

_told = False


def folder() -> Path | None:
    """Where entries lie; None where nothing is to be kept, or no home is known."""
    chosen = os.environ.get("APGC_CACHE", "")
    if chosen.strip().lower() in ("off", "0", "no", "false"):
        return None
    if chosen:
        return Path(chosen)
    base = home()
    return None if base is None else base / "kept"


def home() -> Path | None:
    """The folder of this package among the user's own caches; None where no home is known."""
    home = os.environ.get("XDG_CACHE_HOME") or os.environ.get("LOCALAPPDATA")
    try:
        base = Path(home) if home else Path.home() / ("Library/Caches" if sys.platform == "darwin" else ".cache")
    except RuntimeError:
        return None
    return base / "artipg_dsl"


@cache
def stamp() -> str:
    """The compiler: the files of this package and the grammar with their sizes and times, and the versions of what it
    computes with."""
    package = Path(__file__).resolve().parent
    found = [sys.version, sys.platform]
    for folder, folders, names in os.walk(package):
        folders[:] = sorted(name for name in folders if name != "__pycache__")
        for path in [os.path.join(folder, name) for name in sorted(names) if name.endswith(".py")]:
            found.append(_seen(path))
    found.append(_seen(str(grammar_file())))
    for name in ("numpy", "scipy"):  # found without importing them
        spec = find_spec(name)
        version = Path(spec.origin).with_name("version.py") if spec is not None and spec.origin else None
        if version is not None and version.is_file():
            found.append(f"{name} {digest([version.read_text(encoding='utf-8')])}")
    return digest(found)


def _seen(path: str) -> str:
    told = os.stat(path)
    return f"{path} {told.st_size} {told.st_mtime_ns}"


def digest(texts: Iterable[str]) -> str:
    """A hash of texts in their order."""
    found = blake2b(digest_size=20)
    for text in texts:
        data = text.encode("utf-8", "surrogatepass")
        found.update(b"%d\n" % len(data))
        found.update(data)
    return found.hexdigest()


def key(kind: str, *texts: str) -> str:
    """The name of an entry of a kind that follows from texts and the compiler."""
    return f"{kind}-{digest((stamp(), kind, *texts))}"


def read(name: str) -> bytes | None:
    """The data of an entry; None where there is none, or it is not what was written."""
    place = folder()
    if place is None:
        return None
    path = place / name
    try:
        data = path.read_bytes()
        body = data[len(MARK) + SEAL :]
        if data != sealed(name, body):
            path.unlink(missing_ok=True)
            return None
        now = time.time()
        os.utime(path, (now, now))  # what is read stays longest
    except OSError:
        return None
    return body


def drop(name: str) -> None:
    """Remove an entry that does not say what it should."""
    place = folder()
    if place is not None:
        try:
            (place / name).unlink(missing_ok=True)
        except OSError:
            pass


def write(name: str, body: bytes) -> None:
    """Keep an entry, whole or not at all. Where that cannot be, nothing is kept: it is never needed. Of a folder that was asked
    for, that is said on stderr, once.
    """
    place = folder()
    if place is None:
        return
    unfinished = None
    try:
        place.mkdir(parents=True, exist_ok=True)
        beside = place / f".{os.urandom(8).hex()}.partial"
        with open(beside, "xb") as file:
            unfinished = beside
            file.write(sealed(name, body))
        os.replace(beside, place / name)
        unfinished = None
        if name.endswith(_LOOKED):
            prune(place)
    except OSError as error:
        _tell(place, error)
    finally:
        if unfinished is not None:
            try:
                os.unlink(unfinished)
            except OSError:
                pass


def _tell(place: Path, error: OSError) -> None:
    """Say once that nothing is kept; the workers of a run leave that to the process that started them."""
    import multiprocessing  # start-up

    global _told
    if _told or not os.environ.get("APGC_CACHE") or multiprocessing.parent_process() is not None:
        return
    _told = True
    wrong = error.strerror or type(error).__name__
    print(f"nothing is kept in {place}, which APGC_CACHE names: {wrong}", file=sys.stderr, flush=True)


def sealed(name: str, body: bytes) -> bytes:
    """The file of an entry, which tells whether it is whole and has its own name: a folder may be copied by hand."""
    return MARK + blake2b(name.encode() + b"\n" + body, digest_size=SEAL).digest() + body


# ---------------------------------------------------------------- the folder as a whole


@dataclass(frozen=True, slots=True)
class Entry:
    """A file of the cache: when it was last read or written (seconds since 1970), and its size in bytes."""

    path: Path
    used: float
    size: int

    @property
    def kind(self) -> str:
        return self.path.name.partition("-")[0]


def entries(place: Path) -> list[Entry]:
    """The entries of a folder, those used longest ago first; what a killed process has left is removed."""
    found = []
    try:
        with os.scandir(place) as listed:
            for item in listed:
                try:
                    seen = item.stat(follow_symlinks=False)
                    if item.name.endswith(".partial"):
                        if time.time() - seen.st_mtime > _STALE:
                            os.unlink(item.path)
                    elif item.is_file(follow_symlinks=False) and "-" in item.name:
                        found.append(Entry(Path(item.path), seen.st_mtime, seen.st_size))
                except OSError:  # another process was faster
                    continue
    except OSError:
        return []
    return sorted(found, key=lambda entry: (entry.used, entry.path.name))


def prune(place: Path, most: int | None = None) -> None:
    """Remove what was used longest ago, once all entries take more than ``most`` bytes."""
    limit = MOST if most is None else most
    found = entries(place)
    total = sum(entry.size for entry in found)
    if total <= limit:
        return
    for entry in found:
        if total <= _LEFT * limit:
            break
        total -= entry.size
        try:
            entry.path.unlink(missing_ok=True)
        except OSError:
            continue


def clear(found: Iterable[Entry]) -> tuple[int, int]:
    """Remove entries: how many they were, and their bytes."""
    number = total = 0
    for entry in found:
        try:
            entry.path.unlink()
        except OSError:
            continue
        number, total = number + 1, total + entry.size
    return number, total
