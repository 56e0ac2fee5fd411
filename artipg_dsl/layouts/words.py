"""What another vocabulary calls a category and its parts: maps declared in ``words/*.json``, or in a file of the user's.

A vocabulary has ``classes``, each with what the layout needs of it (a synset, numbers of parts). A category is mapped to
one of them, and its words to the parts that the class has: ``"leg": "leg"``, ``"drawer/handle": ...`` for a handle on a link
that is a drawer, ``"door/revolute"`` for a link that moves so, ``"*"`` for every other word. ``"drawn.base"`` is a word of another vocabulary
than ``semantic``: where its labels hold it goes before all others, so that formulas of a program say where parts end.
"""

from __future__ import annotations

import json
from collections.abc import Iterable, Mapping, Sequence
from functools import lru_cache
from pathlib import Path
from typing import TYPE_CHECKING, Any

from ..diagnostics.suggest import did_you_mean
from ..errors import UsageError, UserError
from ..files import read_json
from ..language.kinds import JOINTS
from ..records import dataclass
from ..resources import categories_dir

if TYPE_CHECKING:
    from ..graph.program import Program

REST = "*"  # every word that is not named
_EXAMPLE = '{"Kettle": {"class": "Mug", "parts": {"handle": "handle", "*": "cup"}}}'


@dataclass(frozen=True, slots=True)
class Term:
    """A category in the words of a vocabulary: ``name`` of its class, what the vocabulary says of that ``data``, and the
    part that each of our words is."""

    category: str
    vocabulary: str
    name: str
    data: Mapping[str, Any]
    parts: Mapping[str, Any]

    def formulas(self) -> dict[str, Any]:
        """Parts by words of other vocabularies, ``drawn.base``, in the order of the map: the first that holds wins."""
        return {key: part for key, part in self.parts.items() if "." in key}

    def part(self, word: str, link: str = "") -> Any:
        """The part that a word is, on a link of that word. Raises UserError."""
        for key in (f"{link}/{word}", word, REST):
            if key in self.parts:
                return self.parts[key]
        raise UserError(
            f"{self.vocabulary} is not told what `{word}` of {self.category} is",
            f'--map FILE says it: {{"{self.category}": {{"class": "{self.name}", "parts": {{"{word}": ...}}}}}}',
        )


@dataclass(frozen=True, slots=True)
class Vocabulary:
    """``title`` for messages; ``none``: categories that have no class; ``near``: what would serve for one."""

    title: str
    classes: Mapping[str, Mapping[str, Any]]
    categories: Mapping[str, Mapping[str, Any]]
    near: Mapping[str, str]
    instead: str
    none: Sequence[str] = ()

    def term(self, category: str, own: Mapping[str, Mapping[str, Any]] | None = None) -> Term:
        """A category in these words, ``own`` map before the shipped one. Raises UserError for one that has no class."""
        entry = {**self.categories, **(own or {})}.get(category)
        if entry is None:
            raise UserError(f"{self.title} has no class for {category}", self._serves(category))
        name = entry["class"]
        if name not in self.classes:
            known = did_you_mean(name, self.classes) or f"its classes are {', '.join(self.classes)}"
            raise UserError(f"{self.title} has no class `{name}`", known)
        return Term(category, self.title, name, self.classes[name], entry.get("parts", {}))

    def _serves(self, category: str) -> str:
        shipped = {path.stem.replace("_", "") for path in categories_dir().glob("*.apg")}
        known = [name for name in self.categories if name.lower() in shipped]  # words may be there before the category
        have = f"of the shipped categories {', '.join(known)} have one"
        close = self.near.get(category) or next((name for name in self.classes if name.lower() == category.lower()), "")
        nearest = f"the nearest is {close}: " if close else ""
        form = f'{nearest}--map FILE with {{"{category}": {{"class": "{close or "..."}", "parts": ...}}}} makes it one'
        return "; ".join(filter(None, (have, form, self.instead)))


def check_words(parts: Iterable[str], program: Program, *, divides: bool) -> None:
    """Every key of a user's map says something of the program: a mistyped one would map nothing. ``divides``: points are
    labelled one by one, so that words of other vocabularies count, and how links move does not. Raises UserError."""
    semantic = program.vocabularies.get("semantic", ())
    others = [f"{v}.{w}" for v, words in program.vocabularies.items() if v != "semantic" for w in words[1:]]
    for key in parts:
        name, dot, _ = key.partition(".")
        link, slash, rest = key.partition("/")
        if dot:
            form = f"`{key.partition('.')[2]}` alone is the word of semantic" if name == "semantic" else None
            _find(key, others, program.name, form)
        elif key != REST:
            _find(link, semantic, program.name)
            if slash:
                _find(rest, [*semantic, *([] if divides else JOINTS)], program.name)


def _find(word: str, known: Sequence[str], category: str, form: str | None = None) -> None:
    """A word is a known one. Raises UserError, with the hint ``form`` if there is one."""
    if word not in known:
        hint = form or did_you_mean(word, known) or f"its words are {', '.join(known)}"
        raise UserError(f"--map names `{word}`, which is no word of {category}", hint)


@lru_cache
def vocabulary(name: str) -> Vocabulary:
    """A shipped vocabulary, by the name of its file."""
    from importlib import resources  # start-up

    found = json.loads(
        resources.files("artipg_dsl.layouts").joinpath("words", f"{name}.json").read_text(encoding="utf-8")
    )
    return Vocabulary(
        found["title"],
        found["classes"],
        found["categories"],
        found.get("near", {}),
        found.get("instead", ""),
        tuple(found["none"]),
    )


def read_map(path: str | Path) -> dict[str, dict[str, Any]]:
    """A map of the user's own: ``{"Kettle": {"class": "Mug", "parts": {"handle": ..., "*": ...}}}``. Raises UsageError."""
    try:
        found = read_json(path, f"a map is, say, {_EXAMPLE}")
    except FileNotFoundError:
        raise UsageError(f"there is no file {path}", "--map takes a JSON file") from None
    except UserError as wrong:
        raise UsageError(wrong.message, wrong.hint) from None
    return require_map(found, str(path))


def require_map(found: Any, name: str) -> dict[str, dict[str, Any]]:
    """The same as plain data, which messages call by a name. Raises UsageError."""
    fits = isinstance(found, dict) and all(
        isinstance(entry, dict)
        and isinstance(entry.get("class"), str)
        and isinstance(entry.get("parts", {}), dict)
        and entry.keys() <= {"class", "parts"}
        for entry in found.values()
    )
    if not fits:
        raise UsageError(f"{name} is not a map of words", f"a map is, say, {_EXAMPLE}")
    return dict(found)
