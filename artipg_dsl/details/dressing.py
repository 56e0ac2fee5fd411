"""Which details objects wear, as a run records it."""

from __future__ import annotations

from dataclasses import dataclass


@dataclass(frozen=True, slots=True)
class Dressing:
    """The ``folder`` that ``apgc bind`` has written, the ``mark`` of what it holds, and the ``strength`` of its details, 0 .. 1.
    ``borrowed``: objects of any origin wear details of any donor, instead of mutants those of what they were made from."""

    folder: str
    mark: str
    strength: float = 1.0
    borrowed: bool = False
