"""The traces that lie in a folder of mutants, by which they can be made again."""

from __future__ import annotations

from typing import Any

from ..errors import UserError
from ..export.remote import Place, place_of
from ..sampling.trace import read_traces


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
