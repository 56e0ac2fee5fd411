"""Which details objects wear, as a run records it."""

from __future__ import annotations

from dataclasses import field
from typing import TYPE_CHECKING, Any

from ..errors import UsageError
from ..records import dataclass

if TYPE_CHECKING:
    from .record import Donors

SUMMARY = "bind.json"  # of a folder of details
MEMORY = "memory"  # what messages call the folder of details that are in none
BESIDE = "details"  # the folder that these are written to, in that of the objects that wear them


@dataclass(frozen=True, slots=True)
class Dressing:
    """The ``folder`` that ``apgc bind`` has written, the ``mark`` of what it holds, and the ``strength`` of its details, 0 .. 1.
    ``borrowed``: objects of any origin wear details of any donor, instead of mutants those of what they were made from. ``held``: the same
    details where they are at hand; then there may be no folder."""

    folder: str
    mark: str
    strength: float = 1.0
    borrowed: bool = False
    held: Donors | None = field(default=None, repr=False, compare=False)

    def __post_init__(self) -> None:
        if not 0.0 <= self.strength <= 1.0:
            raise UsageError(f"the strength of details is {self.strength}", "give a number from 0 to 1")


def refuse_idle_strength(details: Any, strength: float) -> None:
    """Refuse a strength of no details. Raises UsageError."""
    if details is None and strength != 1.0:
        raise UsageError("detail_strength scales details, and there are none", "give `details`, too")
