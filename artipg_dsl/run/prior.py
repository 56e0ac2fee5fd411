"""Priors: files of other weights and narrower ranges for the draws of categories, and what they make of a program.

{"about": "...", "draws": {"Microwave": {"tray": 0.23, "handle": {"BarHandle": 3, "none": 1}, "width": "45cm .. 50cm"}}}
"""

from __future__ import annotations

import json
import re
from collections.abc import Mapping, Sequence
from dataclasses import field
from pathlib import Path
from typing import TYPE_CHECKING, Any, NotRequired, TypedDict

from ..arguments import to_plain
from ..diagnostics.suggest import did_you_mean
from ..errors import SettingError, UsageError, UserError
from ..files import parse_json, read_text
from ..graph.feasible import find_conflicts
from ..graph.reweigh import NothingLeft, reweigh
from ..records import dataclass
from ..shapes import Misfit, fit
from .settings import find_draws
from .weights import change_draw

if TYPE_CHECKING:
    from ..graph.program import Program

_FORM = 'write {"draws": {"Microwave": {"tray": 0.23}}}'
_GIVEN = "the prior"  # what messages call one that has no file
_SHIPPED = Path(__file__).resolve().parent / "priors"
Draws = Mapping[str, Any]


class _File(TypedDict):
    """``evidence`` and ``unmatched`` are for readers: where the numbers come from, and what no draw could be found for."""

    about: NotRequired[str]
    draws: dict[str, dict[str, Any]]
    evidence: NotRequired[dict[str, Any]]
    unmatched: NotRequired[dict[str, list[str]]]


@dataclass(frozen=True, slots=True)
class Prior:
    """What is said of each draw of one category, as the file has it; ``name`` is what it is called, ``places`` where it is said."""

    draws: Draws
    name: str = field(default=_GIVEN, compare=False)
    places: Mapping[str, str] = field(default_factory=dict, compare=False, repr=False)

    def of(self, category: str) -> Prior:
        return self

    def show(self) -> str:
        """In words: ``partnet (tray, handle)``."""
        return f"{self.name} ({', '.join(self.draws)})"


@dataclass(frozen=True, slots=True)
class PriorFile:
    """What is said of the draws of each of several categories; ``text`` is the whole file, in which places are looked up."""

    name: str
    categories: Mapping[str, Draws]
    text: str = field(default="", repr=False)
    path: str = ""
    shipped: bool = False

    def show(self) -> str:
        return f"{self.name} ({', '.join(self.categories)})"

    def of(self, category: str) -> Prior:
        """What it says of one category. Raises UserError."""
        if category not in self.categories:
            known = ", ".join(self.categories) or "no category"
            raise UserError(
                f"{self.path or self.name} says nothing of {category}: it speaks of {known}",
                did_you_mean(category, self.categories)
                or ("leave out the prior" if self.shipped else f'write "{category}": {{}} to draw it as declared'),
            )
        draws = self.categories[category]
        return Prior(dict(draws), self.name, {key: self._place(category, key) for key in draws})

    def _place(self, category: str, key: str) -> str:
        """``file:line:column`` of what is said of a draw."""
        at = 0
        for word in ("draws", category, key):
            found = re.compile(re.escape(json.dumps(word, ensure_ascii=False)) + r"\s*:").search(self.text, at)
            if found is None:
                return self.path or self.name
            at = found.start()
        line = self.text.count("\n", 0, at) + 1
        return f"{self.path}:{line}:{at - self.text.rfind(chr(10), 0, at)}"


def list_shipped() -> list[str]:
    """The names of the priors that are shipped."""
    return sorted(path.stem for path in _SHIPPED.glob("*.json"))


def read_prior(given: str | Path | Mapping[str, Any]) -> Prior | PriorFile:
    """A prior by the name of a shipped one, from a file, or from Python: the draws of one category, or what a file holds.

    Raises UsageError, UserError.
    """
    if isinstance(given, Mapping):
        if "draws" in given and isinstance(given["draws"], Mapping):
            return PriorFile(_GIVEN, _checked(to_plain(given), _GIVEN)["draws"])
        return Prior(to_plain(given))
    if not isinstance(given, str | Path):
        raise UsageError(f"a prior is a name, a file or what is said of each draw, not {given!r}", _FORM)
    if not str(given).strip():
        raise UsageError(
            "the name of the prior is empty", f"give a file, or a shipped one: {', '.join(list_shipped())}"
        )
    path = Path(given)
    if isinstance(given, str) and given in list_shipped() and not path.exists():
        path = _SHIPPED / f"{given}.json"
    try:
        text = read_text(path)
    except FileNotFoundError:
        known = list_shipped()
        hint = did_you_mean(str(given), known) or f"the shipped priors are {', '.join(known)}"
        raise UserError(f"there is no prior {given}", hint) from None
    found = _checked(parse_json(text, str(given), _FORM), str(given))
    shipped = path.parent == _SHIPPED
    return PriorFile(path.stem if shipped else path.name, found["draws"], text, str(given), shipped)


def _checked(found: Any, name: str) -> dict[str, Any]:
    try:
        fit(found, _File)
    except Misfit as wrong:
        raise UserError(f"{name}: {wrong}", _FORM) from None
    made: dict[str, Any] = found
    return made


def apply_prior(program: Program, prior: Prior) -> Program:
    """The program whose draws are weighted as the prior says. Raises SettingError where it does not fit the program."""
    changed = {}
    for name, entry in prior.draws.items():
        place = prior.places.get(name, prior.name)
        named: list[int] = []
        try:
            named = find_draws(program, name)
            for k in named:
                if k in changed:
                    raise SettingError(
                        f"`{name}` speaks of `{program.draws[k].column.name}`, which is there already",
                        "leave one of them out",
                    )
                changed[k] = change_draw(program.draws[k], entry)
        except NothingLeft as error:
            raise SettingError(f"{place}: `{name}`: {error}", _apart(program, named)) from None
        except SettingError as error:
            raise SettingError(f"{place}: {error.message}", _apart(program, named) or error.hint) from None
    made = reweigh(program, changed)
    require_objects(made, prior)
    return made


def _apart(program: Program, named: Sequence[int]) -> str | None:
    """How to speak of one of several draws that share a name."""
    if len(named) < 2:
        return None
    shown = ", ".join(f"`{program.draws[k].address}`" for k in named[:3]) + (", ..." if len(named) > 3 else "")
    return f"several alternatives have it: name those that are meant: {shown}"


def require_objects(program: Program, prior: Prior) -> None:
    """Refuse ranges that leave no object at all, whatever else is drawn."""
    for conflict in find_conflicts(program):
        if conflict.certain:
            behind = [program.draws[k].column.name for k in (conflict.draw, *conflict.draws) if k is not None]
            said = [name for name in dict.fromkeys(behind) if name in prior.draws] or list(prior.draws)
            why = [program.requirements[r] for r in (conflict.requirement, *conflict.reasons) if r is not None]
            told = [f"`{' '.join(r.text.split()) or r.message}` ({r.where})" for r in dict.fromkeys(why)]
            raise SettingError(
                f"{prior.places.get(said[0], prior.name)}: {', '.join(f'`{name}`' for name in said)}: no {program.name} is left"
                + (f" under {', '.join(told[:3])}" if told else ""),
                "widen these ranges",
            )
