"""A `|` behind which nothing stands, so that the statement below is read as the option or the alternative that is missing."""

from __future__ import annotations

from collections.abc import Sequence
from collections.abc import Set as AbstractSet
from typing import Any

MESSAGE = "nothing stands behind this `|`"
HINT = "write another option or alternative behind it, or remove it"


def find_bar(read: Sequence[Any], text: str, begins: AbstractSet[str]) -> Any | None:
    """The `|` at the end of a line where the last of the tokens ``read`` stands on the next one, which a word of ``begins`` (names
    of terminals) or the end of a block begins; None where there is none."""
    first = len(read) - 1
    while first > 0 and "\n" not in text[read[first - 1].end_pos : read[first].start_pos]:
        first -= 1
    if first < 1 or read[first - 1].type != "BAR":
        return None
    return read[first - 1] if read[first].type == "RBRACE" or read[first].value.upper() in begins else None
