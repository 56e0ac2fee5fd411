"""Where the files of real objects are: in memory as seen from here, in a folder as seen from that, so that both can be moved together."""

from __future__ import annotations

import os
from collections.abc import Callable, Mapping
from pathlib import Path
from typing import Any

from ..fit.sources import MEMORY
from .manifest import see_from

_LISTS = "objects", "failed"  # of a summary, with a source each


def seen_from(out: Path, told: Mapping[str, Any]) -> dict[str, Any]:
    """A record or a summary as it is written into the folder ``out``."""
    return _mapped(told, lambda source: see_from(out, _place(source)))


def seen_here(out: Path, told: Mapping[str, Any]) -> dict[str, Any]:
    """A record or a summary that was read from the folder ``out``."""

    def here(source: str) -> str:
        place, home = Path(_place(out / source)), Path.cwd()
        if not place.is_file() and os.path.isfile(source):
            return source  # of an earlier version, as the command that wrote it had it
        return str(place.relative_to(home) if place.is_relative_to(home) else place)

    return _mapped(told, here)


def _place(path: Path | str) -> str:
    """The whole path. Folders may be reached through links, but a file that is a link keeps its name, which tells its kind."""
    folder, name = os.path.split(path)
    return os.path.join(os.path.realpath(folder), name)


def _mapped(told: Mapping[str, Any], move: Callable[[str], str]) -> dict[str, Any]:
    moved = dict(told)
    source = moved.get("source")
    if isinstance(source, str) and source != MEMORY and "\0" not in source:
        moved["source"] = move(source)
    for name in _LISTS:
        if isinstance(entries := moved.get(name), list):
            moved[name] = [_mapped(one, move) if isinstance(one, dict) else one for one in entries]
    return moved
