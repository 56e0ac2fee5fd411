"""Files and folders that appear whole or not at all: written beside their place, then renamed into it."""

from __future__ import annotations

import errno
import glob
import os
import shutil
import signal
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import BinaryIO

from ..errors import FORCE, UserError
from .ends import has_end
from .remote import MARK, Place, Remote

_OLD = "-old"  # of a folder that is being replaced


class ExportError(UserError):
    """Something about the output that the user can put right."""


def explain(error: OSError, path: Place) -> ExportError:
    """An operating system's refusal in words."""
    if isinstance(path, Remote):
        return ExportError(f"cannot write {path}: {error}", "the same command goes on where it was")
    place = Path(error.filename if isinstance(error.filename, str) else path)
    if MARK in place.name:  # the user knows the file by its final name
        place = place.with_name(place.name.split(MARK)[0].removeprefix("."))
    if error.errno in (errno.EACCES, errno.EPERM, errno.EROFS):
        return ExportError(f"no permission to write {place}", "choose another output folder or change its permissions")
    if error.errno == errno.EEXIST and place.is_symlink() and not place.exists():
        there = os.readlink(place)
        return ExportError(
            f"{place} is a link to {there}, which is not there", "make that folder, or choose another one"
        )
    if error.errno in (errno.ENOTDIR, errno.EEXIST):
        return ExportError(f"{place} is in the way: a folder is needed there", "choose another output folder")
    if error.errno == errno.EISDIR:
        return ExportError(f"{place} is a folder, but a file is to be written", "choose another output name")
    if error.errno in (errno.ENOSPC, errno.EDQUOT):
        return ExportError(f"no space left while writing {place}", "free some space, then run the same command again")
    if error.errno == errno.EFBIG:
        return ExportError(
            f"{place} exceeds the size that files may have here", "raise the limit (ulimit -f) or write elsewhere"
        )
    if error.errno == errno.ENAMETOOLONG:
        return ExportError(f"the name {place} is too long for this file system", "choose a shorter output folder")
    return ExportError(f"cannot write {place}: {error.strerror or error}", "choose another output folder")


def _beside(path: Path) -> Path:
    """A hidden sibling that marks itself as unfinished and as belonging to this process."""
    return path.with_name(f".{path.name}{MARK}{os.getpid()}")


def ensure_folder(path: Place) -> Place:
    """The folder ``path``, made with its parents if need be; elsewhere folders come with their files."""
    if isinstance(path, Remote):
        return path
    try:
        path.mkdir(parents=True, exist_ok=True)
    except OSError as error:
        raise explain(error, path) from error
    return path


def is_there(path: Place) -> bool:
    """Whether a file or folder is there. A file without its end is not, which a copy that was broken off leaves: none that is written
    whole is like that."""
    if isinstance(path, Remote) or not path.is_file():
        return path.exists()
    return has_end(path)


def refuse_existing(path: Place, force: bool) -> None:
    if not force and (is_there(path) or path.is_symlink()):
        raise ExportError(f"{path} exists", f"remove it, choose another name, or use {FORCE} to replace it")


def require_place(path: Path, force: bool) -> None:
    """Raises ExportError, before the work, where its result could not be written: a file that is there, or a folder that takes none.
    What killed processes left of it unfinished is removed."""
    if _stream_like(path):
        return
    refuse_existing(path, force)
    if path.is_dir():
        raise explain(OSError(errno.EISDIR, ""), path)
    folder = next(place for place in Path(os.path.realpath(path)).parents if place.exists())
    if not folder.is_dir():
        raise explain(OSError(errno.ENOTDIR, ""), folder)
    if not os.access(folder, os.W_OK):
        raise explain(OSError(errno.EACCES, ""), path)
    place = Path(os.path.realpath(path))
    sweep_unfinished(place.parent, place.name)


def _stream_like(path: Path) -> bool:
    """Whether a path is a device or a pipe, which is written to and cannot be replaced."""
    return path.exists() and not path.is_file() and not path.is_dir()


@contextmanager
def replacing_file(path: Path | str, *, force: bool = False) -> Iterator[BinaryIO]:
    """A binary file to write to, which takes the name ``path`` only when the block ends without an exception."""
    path = Path(path)
    if _stream_like(path):
        try:
            with open(path, "wb") as stream:
                yield stream
        except OSError as error:
            raise explain(error, path) from error
        return
    refuse_existing(path, force)
    if path.is_dir():
        raise explain(OSError(errno.EISDIR, ""), path)
    ensure_folder(path.parent)
    path = Path(os.path.realpath(path))  # a link stays one: what it points to is replaced
    partial = _beside(path)
    try:
        with open(partial, "w+b") as stream:  # HDF5 reads what it has written
            yield stream
        if path.exists():
            shutil.copymode(path, partial)
        os.replace(partial, path)
    except OSError as error:
        raise explain(error, path) from error
    finally:  # also after KeyboardInterrupt
        partial.unlink(missing_ok=True) if os.access(path.parent, os.W_OK) else None


@contextmanager
def replacing_folder(path: Path | str, *, force: bool = False) -> Iterator[Path]:
    """An empty folder to fill, which takes the name ``path`` only when the block ends without an exception."""
    path = Path(path)
    refuse_existing(path, force)
    ensure_folder(path.parent)
    partial = _beside(path)
    old = partial.with_name(partial.name + _OLD)
    try:
        shutil.rmtree(partial, ignore_errors=True)
        partial.mkdir()
        yield partial
        if path.is_dir() and not path.is_symlink():
            os.rename(path, old)  # a folder that is not empty cannot be replaced in one step
        elif path.exists():
            path.unlink()
        os.rename(partial, path)
    except OSError as error:
        raise explain(error, path) from error
    finally:
        shutil.rmtree(partial, ignore_errors=True)
        if old.exists() and not path.exists():
            os.rename(old, path)
        shutil.rmtree(old, ignore_errors=True)


def write_bytes(path: Place | str, data: bytes, *, force: bool = False) -> None:
    """The file ``path`` with the contents ``data``, whole or not at all."""
    if isinstance(path, Remote):
        write_remote(path, data, force=force)
        return
    with replacing_file(path, force=force) as stream:
        stream.write(data)


def write_remote(path: Remote, data: bytes, *, force: bool) -> None:
    """The same elsewhere."""
    refuse_existing(path, force)
    try:
        path.write_bytes(data)
    except (OSError, ValueError, RuntimeError) as error:
        raise explain(OSError(str(error)), path) from error


def sweep_unfinished(folder: Place, only: str | None = None) -> None:
    """Remove what a killed process left unfinished in ``folder``, of the file or folder ``only`` alone if a name is given (what a running
    process still writes stays). A folder that it had put aside, and not replaced yet, gets its name back."""
    if isinstance(folder, Remote):  # who writes there is not known here
        return
    for left in folder.glob(f".{'*' if only is None else glob.escape(only)}{MARK}*"):
        name, said = left.name.split(MARK)
        owner, whole = said.removesuffix(_OLD), left.with_name(name.removeprefix("."))
        if not owner.isdigit() or _alive(int(owner)):
            continue
        if said.endswith(_OLD) and not whole.exists():
            os.rename(left, whole)
        else:
            shutil.rmtree(left) if left.is_dir() else left.unlink(missing_ok=True)


def _alive(process: int) -> bool:
    """Whether a process may still write: one that has ended may be listed until its parent asks, in a container for good. Windows has no
    signal that only asks (0 is that of Ctrl-C there), so of other processes nothing is known."""
    if not hasattr(signal, "SIGHUP"):
        return True
    try:
        os.kill(process, 0)
    except ProcessLookupError:
        return False
    except OSError:
        return True
    try:
        state = Path(f"/proc/{process}/stat").read_bytes().rpartition(b")")[2].split()[0]
    except (OSError, IndexError):  # other systems have no such file
        return True
    return state not in (b"Z", b"X")
