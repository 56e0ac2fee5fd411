"""Real objects, how they stand, and what their labels mean, as arguments."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import TYPE_CHECKING, Any

from ..arguments import read_flag
from ..errors import UsageError

if TYPE_CHECKING:
    from ..fit.pose import Frame
    from ..fit.sources import Item
    from ..graph.program import Program


def read_real(
    real: Any, up: str, front: str, unit: str, normalised: bool, tell: Callable[[str], None]
) -> tuple[list[Item], Frame]:
    """Real objects and how they stand; ``tell`` is told what of a folder is left out. Raises UsageError, UserError."""
    from ..fit.given import read_objects
    from ..fit.pose import Frame

    frame = Frame(up, front, unit, read_flag("normalised", normalised))
    return read_objects(real, tell), frame


def read_map(given: Mapping[str, str] | None, program: Program) -> tuple[tuple[str, str], ...]:
    """Names of labels, each with the word of ``semantic`` that it means. Raises UsageError."""
    from ..run.fitting import check_words

    if given is None:
        return ()
    if not isinstance(given, Mapping) or not all(isinstance(one, str) for pair in given.items() for one in pair):
        raise UsageError(f"map is {given!r}", 'it maps names of labels to words of `semantic`: {"Seat_01": "seat"}')
    return check_words(given, program.vocabularies.get("semantic", ()), "map")
