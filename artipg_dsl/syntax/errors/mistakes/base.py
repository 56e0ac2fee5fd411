"""What a mistake has."""

from __future__ import annotations

from typing import NamedTuple


class Mistake(NamedTuple):
    """What to say, what to try, and ``sentences`` that contain the mistake: they stand in the body of a category, but for those that begin
    with ``top:``. ``{}`` stands for the offending token."""

    message: str
    hint: str
    sentences: tuple[str, ...]
