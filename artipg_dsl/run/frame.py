"""Frames: files of how objects of another collection lie against ours, by category, in quarter turns about the vertical.

{"about": "...", "turns": {"Scissors": -90}}
"""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import Annotated, NotRequired, TypedDict

from ..diagnostics.suggest import did_you_mean
from ..errors import UsageError, UserError
from ..files import parse_json, read_text
from ..records import dataclass
from ..shapes import Misfit, Rule, fit

TURNS = Rule("0, 90, -90 or 180 degrees", lambda value: value in (0, 90, -90, 180))
_SHIPPED = Path(__file__).resolve().parent / "frames"
_FORM = 'write {"turns": {"Scissors": -90}}'
OWN = "own"  # the frame that the program has


@dataclass(frozen=True, slots=True)
class Frame:
    """How many degrees the objects of each category are turned by, from x towards y. A ``shipped`` one names those alone that it
    turns; ``name`` is what it is called."""

    turns: Mapping[str, int]
    name: str
    shipped: bool = False

    def of(self, category: str) -> int:
        """Degrees. Raises UserError where a file does not speak of the category."""
        if category in self.turns or self.shipped:
            return self.turns.get(category, 0)
        known = ", ".join(self.turns) or "no category"
        raise UserError(
            f"{self.name} says nothing of {category}: it speaks of {known}",
            did_you_mean(category, self.turns) or f'write "{category}": 0 where it lies so already',
        )


class _File(TypedDict):
    about: NotRequired[str]
    turns: dict[str, Annotated[int, TURNS]]


def list_frames() -> list[str]:
    """The names of the frames that are shipped."""
    return sorted(path.stem for path in _SHIPPED.glob("*.json"))


def read_frame(given: str | Path) -> Frame:
    """A frame: ``own``, the name of a shipped one, or a file. Raises UsageError, UserError."""
    if not isinstance(given, str | Path):
        raise UsageError(
            f"a frame is a name or a file, not {given!r}", f"the frames are {', '.join([OWN, *list_frames()])}"
        )
    if given == OWN:
        return Frame({}, OWN, shipped=True)
    path = Path(given)
    if isinstance(given, str) and given in list_frames() and not path.exists():
        path = _SHIPPED / f"{given}.json"
    try:
        found = parse_json(read_text(path), str(given), _FORM)
    except FileNotFoundError:
        known = [OWN, *list_frames()]
        hint = did_you_mean(str(given), known) or f"the frames are {', '.join(known)}, or a file"
        raise UserError(f"there is no frame {given}", hint) from None
    try:
        fit(found, _File)
    except Misfit as wrong:
        raise UserError(f"{given}: {wrong}", _FORM) from None
    return Frame(found["turns"], str(given), shipped=path.parent == _SHIPPED)
