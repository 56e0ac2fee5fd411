"""A folder per object: the files of all its formats appear whole or not at all, and what else it holds stays."""

from __future__ import annotations

import os
import shutil
from collections.abc import Callable, Sequence
from typing import TYPE_CHECKING

import numpy as np

from ..geometry.resolution import STANDARD as STANDARD_RESOLUTION
from ..geometry.resolution import Resolution
from .registry import Format
from .remote import Place, Remote
from .write import ExportError, is_there, refuse_existing, replacing_folder, write_remote

if TYPE_CHECKING:
    from ..details.dressing import Dressing
    from ..robot.robots import Robots
    from ..runtime.batch import Batch

OBJECTS = "objects"


def object_folder(out: Place, number: int) -> Place:
    return out / OBJECTS / f"{number:06d}"


def find_lacking(folder: Place, formats: Sequence[Format]) -> list[Format]:
    """Those of the formats whose files an object's folder does not hold. Folders appear whole, so one file tells."""
    return [entry for entry in formats if not is_there(folder / entry.mark)]


def write_objects(
    batch: Batch,
    out: Place,
    formats: Sequence[Format],
    *,
    only: np.ndarray | None = None,
    force: bool = False,
    add: bool = False,
    progress: Callable[[int, int], None] | None = None,
    resolution: Resolution = STANDARD_RESOLUTION,
    details: Dressing | None = None,
) -> None:
    """A folder ``objects/<number>`` with the files of all formats for every object of the batch (or of ``only``).

    ``force``: write what is there again. ``add``: write what is missing and leave the rest alone. ``resolution`` of the meshes,
    and the ``details`` that they wear.
    """
    from ..robot.robots import Robots  # start-up: most samples have no files per object, and it loads fifteen modules

    robots = Robots(
        batch,
        resolution=resolution,
        physics=any(entry.weighs and not entry.seen for entry in formats),
        colliders=not all(entry.seen for entry in formats),
        details=details,
    )
    wanted = set(batch.numbers.tolist() if only is None else only.tolist())
    for i, number in enumerate(batch.numbers.tolist()):
        if number in wanted:
            folder = object_folder(out, number)
            lacking = find_lacking(folder, formats) if add else formats
            try:
                if lacking:
                    _write_object(robots, i, folder, lacking, force=force)
            except ExportError:
                if not add or find_lacking(folder, lacking):
                    raise  # else the same command elsewhere has written it meanwhile, with the same bytes
        if progress:
            progress(i + 1, len(batch))


def _write_object(robots: Robots, i: int, folder: Place, formats: Sequence[Format], *, force: bool) -> None:
    """The files of all formats into the folder of object ``i``, all at once or not at all. Its other files stay."""
    for entry in formats:
        refuse_existing(folder / entry.mark, force)
    files = {name: data for entry in formats for name, data in entry.files(robots, i).items()}
    if isinstance(folder, Remote):
        gone = [name for entry in formats for name in entry.clears]
        _write_elsewhere(folder, files, [entry.mark for entry in formats], gone)
        return
    with replacing_folder(folder, force=True) as partial:
        known = folder.is_dir()
        if known:
            left = shutil.ignore_patterns(*(name for entry in formats for name in entry.clears))
            shutil.copytree(folder, partial, ignore=left, copy_function=_link_or_copy, dirs_exist_ok=True)
        for parent in dict.fromkeys(name.rpartition("/")[0] for name in files):
            (partial / parent).mkdir(parents=True, exist_ok=True)
        for name, data in files.items():
            if known:  # never write into a file that the old folder shares
                (partial / name).unlink(missing_ok=True)
            with open(f"{partial}/{name}", "wb") as stream:  # a hundred of them: a Path for each costs as much again
                stream.write(data)


def _write_elsewhere(folder: Remote, files: dict[str, bytes], tell: Sequence[str], gone: Sequence[str]) -> None:
    """Files where no folder can be renamed: those that ``tell`` that a format is there come last, and go first, with what is ``gone``."""
    for name in tell:
        (folder / name).unlink(missing_ok=True)
    for name in gone:
        (folder / name).remove()
    for name in sorted(files, key=lambda name: name in tell):
        write_remote(folder / name, files[name], force=True)


def _link_or_copy(old: str, new: str) -> None:
    """The same file under another name; a copy on file systems without links."""
    try:
        os.link(old, new)
    except OSError:
        shutil.copy2(old, new)
