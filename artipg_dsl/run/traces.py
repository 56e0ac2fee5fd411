"""The traces that lie in a folder of mutants, by which they can be made again.

A folder of mutants that repeat a trace keeps the records of it beside its own traces, which are those of its last mutation, and may be
left out: ``replay-<digest>.jsonl``.
"""

from __future__ import annotations

from collections.abc import Iterable
from typing import Any

from ..errors import UserError
from ..export.remote import Place, place_of
from ..export.write import is_there, write_bytes
from ..sampling.mutation import Mutation
from ..sampling.trace import Replay, read_traces

REPLAYS = "replay-*.jsonl"
_AGAIN = "give the command that wrote the folder again"


def keep_replays(folder: Place, mutations: Iterable[Mutation | Replay]) -> list[str]:
    """Write the records that mutations repeat into the folder, where they are not there; the names of their files. Raises ExportError."""
    replays = {_name(step.mark): step for step in mutations if isinstance(step, Replay)}
    for name, step in replays.items():
        if not is_there(folder / name):
            write_bytes(folder / name, step.lines(), force=True)
    return list(replays)


def read_replay(folder: Place, mark: str, unchecked: bool, *, last: bool) -> Replay:
    """The mutation that repeats the records of a digest, which lie in the folder. Folders of before 0.3 hold none: of their ``last``
    mutation the traces say the same. Raises UserError."""
    file = folder / _name(mark)
    if not is_there(file):
        if not last:
            raise UserError(f"{file} is missing, the trace that these objects repeat", _AGAIN)
        return Replay(gather_traces(folder), unchecked)
    found = Replay(gather_traces(file), unchecked)
    if found.mark != mark:
        raise UserError(f"{file} has been changed since these objects were made", f"remove it, then {_AGAIN}")
    return found


def _name(mark: str) -> str:
    return REPLAYS.replace("*", mark)


def gather_traces(place: Place | str) -> dict[int, dict[str, Any]]:
    """The traces in a folder that ``apgc mutate`` wrote, or in one of its files, by number of the object. Raises UserError."""
    place = place_of(place)
    files: list[Place] = sorted(place.glob("trace-*.jsonl"), key=str) if place.is_dir() else [place]
    found: dict[int, dict[str, Any]] = {}
    for file in files:
        try:
            found |= read_traces(file.read_bytes().decode("utf-8"), str(file))
        except (OSError, UnicodeDecodeError) as error:
            raise UserError(f"{file} cannot be read: {getattr(error, 'strerror', None) or error}") from None
    if not found:
        raise UserError(
            f"{place} has no traces", "give a folder that `apgc mutate` has written, or a trace-*.jsonl of it"
        )
    return found
