"""Kinds of arguments: counts, numbers of objects, parts of a run. A wrong one is argparse's to report."""

from __future__ import annotations

import re
from argparse import ArgumentTypeError

from ..errors import UsageError

_MOST = 100_000_000
STREAM = "-"  # standard output, where one file of text is written


def positive(text: str) -> int:
    """A whole number from 1 on."""
    number = whole(text)
    if not 0 < number <= _MOST:
        raise ArgumentTypeError(f"{text} is not a number from 1 to {_MOST}")
    return number


def whole(text: str) -> int:
    try:
        return int(text)
    except ValueError:
        raise ArgumentTypeError(f"{text!r} is not a whole number") from None


def random_states(text: str) -> int:
    """``random:K``, as other commands call K random joint states."""
    name, _, count = text.partition(":")
    if name != "random" or not count:
        raise ArgumentTypeError(f"{text!r} is not a number of random joint states: write random:64")
    return positive(count)


def amount(text: str) -> float:
    """A number above 0."""
    try:
        number = float(text)
    except ValueError:
        raise ArgumentTypeError(f"{text!r} is not a number") from None
    if not 0 < number < float("inf"):
        raise ArgumentTypeError(f"{text} is not a number above 0")
    return number


def fraction(text: str) -> float:
    """A number from 0 to 1."""
    try:
        number = float(text)
    except ValueError:
        raise ArgumentTypeError(f"{text!r} is not a number") from None
    if not 0 <= number <= 1:
        raise ArgumentTypeError(f"{text} is not between 0 and 1")
    return number


def tolerance(text: str) -> float:
    """``0.5mm``: how far a mesh may lie off its surface, in metres."""
    from ..geometry.resolution import COARSEST, FINEST

    match = re.fullmatch(r"\s*(\d+\.?\d*|\.\d+)\s*(mm|cm|m)\s*", text)
    if match is None:
        raise ArgumentTypeError(f"{text!r} is not a length: write 0.5mm or 1cm")
    length = float(match.group(1)) * {"mm": 1e-3, "cm": 1e-2, "m": 1.0}[match.group(2)]
    if not FINEST <= length <= COARSEST:
        raise ArgumentTypeError(f"{text.strip()} is not between {1000 * FINEST:g}mm and {COARSEST:g}m")
    return length


def numbers(text: str) -> list[int]:
    """``37``, ``37,40..45``: numbers of objects, both ends of a range included, ascending."""
    found: set[int] = set()
    for piece in text.split(","):
        match = re.fullmatch(r"\s*(\d+)\s*(?:\.\.\s*(\d+)\s*)?", piece)
        if match is None:
            raise ArgumentTypeError(
                f"{piece.strip()!r} is not an object number: write 37 or 40..45, separated by commas"
            )
        first = int(match.group(1))
        last = int(match.group(2) or first)
        if last < first:
            raise ArgumentTypeError(f"{piece.strip()} is empty: it ends before it begins")
        if last >= 2**63 or last - first >= _MOST:
            raise ArgumentTypeError(f"{piece.strip()} is too large")
        found.update(range(first, last + 1))
    return sorted(found)


def folder(text: str) -> str:
    """A folder to write to: standard output is none."""
    if text == STREAM:
        raise ArgumentTypeError(
            "- means standard output, but a folder is needed: give its name (./- for a folder named -)"
        )
    return text


def picture(text: str) -> str:
    """A picture to write: a terminal is no place for one."""
    if text == STREAM:
        raise ArgumentTypeError("- means standard output, but a picture needs a file: give a name that ends in .png")
    if not text.lower().endswith(".png"):
        raise ArgumentTypeError(
            f"the picture is a PNG, and {text} is not the name of one: choose a name that ends in .png"
        )
    return text


def part(text: str) -> tuple[int, int]:
    """``2/8``: the second of eight parts."""
    match = re.fullmatch(r"(\d+)/(\d+)", text.strip())
    if match is None or not 1 <= int(match.group(1)) <= int(match.group(2)):
        raise ArgumentTypeError(f"{text!r} is not a part of a run: write 2/8 for the second of eight")
    return int(match.group(1)), int(match.group(2))


def workers(text: str) -> int:
    """``4`` processes, or ``auto``: as many as there are processors, where that pays."""
    from ..run.sharing import AUTO, MOST

    if text.strip() == "auto":
        return AUTO
    number = whole(text)
    if not 0 < number <= MOST:
        raise ArgumentTypeError(f"{text} is neither a number from 1 to {MOST} nor `auto`")
    return number


def memory(text: str) -> int:
    """``2GB``: how much memory a run may take, in bytes."""
    from ..run.memory import read_memory

    try:
        return read_memory(text)
    except UsageError as wrong:
        raise ArgumentTypeError(f"{wrong.message} ({wrong.hint})") from None
