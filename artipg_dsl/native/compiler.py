"""The machine compiled by the system's compiler or by the one that the package ``ziglang`` brings, kept, and loaded.

What is compiled are files of this package, never text that follows from a program. It is kept beside what else is kept, but is not
shared as that may be: a file of code counts only in a folder and under a name that nobody but its owner can write, and only if its
bytes have the hash that its name says. All else is compiled anew.
"""

from __future__ import annotations

import atexit
import ctypes
import os
import platform
import sys
from hashlib import blake2b
from importlib.util import find_spec
from pathlib import Path

from .. import cache

_SOURCES = [
    Path(__file__).with_name(name)
    for name in (
        "machine.c",
        "layout.c",
        "narrow.c",
        "states.c",
        "turning.c",
        "cells.c",
        "moments.c",
        "overlaps.c",
        "digits.c",
        "gaps.c",
        "wrap.c",
        "points.c",
        "depths.c",
        "leaving.c",
        "shading.c",
        "lots.c",
        "feet.c",
        "covers.c",
    )
]
_HEADERS = [Path(__file__).with_name(name) for name in ("bodies.h", "tape.h")]
# products and sums stay apart: one instruction for both would round once, not twice as NumPy does
_FLAGS = ("-O2", "-std=c11", "-ffp-contract=off", "-fno-math-errno", "-shared", "-fPIC", "-fvisibility=hidden")
_LIBRARIES = ("-lm",)
SECONDS = 120.0  # until a compiler is given up
_KIND = "machine"
_SUFFIX = ".so"  # on Windows too: what has none gets another
_MOST = 1 << 20  # bytes of machines of other versions, and of what killed processes left

_passing: set[Path] = set()  # folders for what is not kept, until it is loaded


class NoMachine(Exception):
    """Why there is no compiled backend."""


def compilers() -> list[list[str]]:
    """The commands of compilers that are there, the one to be tried first first: ``CC``, the system's, that of ``ziglang``."""
    import shutil  # start-up: most processes find the machine compiled

    asked = os.environ.get("CC", "").split()
    found = [[path, *asked[1:]] for path in [shutil.which(asked[0])] if path] if asked else []
    found += [[path] for name in ("cc", "gcc", "clang") if (path := shutil.which(name))]
    if find_spec("ziglang") is not None:
        found.append([sys.executable, "-m", "ziglang", "cc"])
    return found


def folder() -> Path | None:
    """Where compiled code is kept: in the user's own folder, wherever else entries are kept; None where nothing is to be."""
    if cache.folder() is None:
        return None
    home = cache.home()
    return None if home is None else home / "compiled"


def kept() -> Path | None:
    """The compiled machine, if it was kept and can be trusted."""
    place = folder()
    if place is None or not _own(place):
        return None
    start = f"{_KIND}-{_key()}-"
    try:
        names = sorted(name for name in os.listdir(place) if name.startswith(start))
    except OSError:
        return None
    for name in names:
        path = place / name
        try:
            if _own(path) and name == start + _seal(path.read_bytes()) + _SUFFIX:
                return path
        except OSError:
            continue
    return None


def compile_machine() -> Path:
    """Compile the machine and keep it; where it lies. Raises NoMachine."""
    found = compilers()
    if not found:
        raise NoMachine("there is no C compiler: install one, or `pip install artipg_dsl[fast]`")
    try:
        place = _writable_folder()
    except OSError as error:
        raise NoMachine(f"there is no folder to compile in: {error}") from None
    done = False
    try:
        made = _compile(found, place)
        done = True
        return made
    finally:
        if not done:
            _pass(place)


def _writable_folder() -> Path:
    """Where compiled code goes: where it is kept, or into a folder that goes once it is loaded. Raises OSError."""
    import tempfile  # start-up: most runs compile nothing

    place = folder()
    if place is not None:
        try:
            place.mkdir(parents=True, exist_ok=True)
            os.chmod(place, 0o700)
        except OSError:
            place = None
    if place is not None and _own(place):
        return place
    place = Path(tempfile.mkdtemp(prefix="apgc-"))
    _passing.add(place)
    atexit.register(_pass, place)  # the process may end before the compiler does
    return place


def _compile(commands: list[list[str]], place: Path) -> Path:
    """The library that the first of the compilers that works has made, in a folder. Raises NoMachine."""
    import subprocess  # start-up: as above
    import tempfile  # start-up

    said = ""
    for command in commands:
        made = None
        try:
            number, name = tempfile.mkstemp(prefix=".", suffix=".partial", dir=place)
            os.close(number)
            made = Path(name)
            done = subprocess.run(
                [*command, *_FLAGS, *map(str, _SOURCES), "-o", name, *_LIBRARIES],
                stdin=subprocess.DEVNULL,
                capture_output=True,
                text=True,
                errors="replace",
                timeout=SECONDS,
            )
            if done.returncode == 0:
                made.chmod(0o600)
                path = place / f"{_KIND}-{_key()}-{_seal(made.read_bytes())}{_SUFFIX}"
                os.replace(made, path)
                cache.prune(place, _MOST)
                return path
            said = said or f"{' '.join(command)} failed: {done.stderr.strip()[:400] or done.returncode}"
        except subprocess.TimeoutExpired:
            said = said or f"{' '.join(command)} was not done after {SECONDS:.0f} s"
        except OSError as error:
            said = said or f"{' '.join(command)} cannot be run: {error.strerror}"
        finally:
            if made is not None:
                made.unlink(missing_ok=True)
    raise NoMachine(said)


def _pass(place: Path) -> None:
    """Remove a folder for what is not kept."""
    if place in _passing:
        import shutil  # start-up: as above

        _passing.remove(place)
        shutil.rmtree(place, ignore_errors=True)


def load(path: Path) -> ctypes.CDLL:
    """The library in a file; one that cannot be loaded, or is not to be kept, is removed. Raises NoMachine."""
    try:
        return ctypes.CDLL(str(path))
    except OSError as error:
        path.unlink(missing_ok=True)
        raise NoMachine(f"the compiled backend cannot be loaded: {error}") from None
    finally:
        _pass(path.parent)


def _own(path: Path) -> bool:
    """Whether nobody but the user can have written a file or folder."""
    if not hasattr(os, "getuid"):
        return True  # Windows: folders of users are theirs alone
    try:
        seen = path.lstat()
    except OSError:
        return False
    return seen.st_uid == os.getuid() and not seen.st_mode & 0o022 and not path.is_symlink()


def _key() -> str:
    found = blake2b(digest_size=12)
    texts = [source.read_bytes() for source in (*_SOURCES, *_HEADERS)]
    names = [" ".join((*_FLAGS, *_LIBRARIES)), sys.platform, platform.machine()]
    for part in (*texts, *(name.encode() for name in names)):
        found.update(b"%d\n" % len(part))
        found.update(part)
    return found.hexdigest()


def _seal(data: bytes) -> str:
    return blake2b(data, digest_size=20).hexdigest()
