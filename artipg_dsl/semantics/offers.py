"""What the shipped library would offer for a name that a file neither declares nor imports."""

from __future__ import annotations

import re
from collections.abc import Collection, Iterable

from ..diagnostics.suggest import any_of, did_you_mean, suggest
from ..resources import library_dir
from . import foreign

DECLARED = re.compile(r"^(role|template|primitive|material|vocabulary)[ ]+(\w+)", re.MULTILINE)
TEMPLATES = ("role", "template", "primitive")
_NEAR = 6  # names in a hint


def declared_in(name: str) -> str | None:
    """A hint: the import that brings ``name`` in, whatever it is."""
    module = _modules().get(name)
    return None if module is None else f"it is in another module: `use {module} {{ {name} }}`"


def missing(name: str, here: Iterable[str], *kinds: str) -> str | None:
    """A hint: the import that brings ``name`` in, else the nearest of the names ``here``, else the nearest of the library.

    ``kinds`` are those of the library's declarations that would do. The modules are searched as text, not parsed: this runs
    behind an error alone.
    """
    library = _modules(kinds)
    if name in library:
        return f"bring it in: `use {library[name]} {{ {name} }}`"
    here = list(here)
    if alike := kin(name, here):
        return f"did you mean {any_of(alike)}?"
    if alike := kin(name, library):
        return f"did you mean {any_of(alike)}? bring it in, as in `use {library[alike[0]]} {{ {alike[0]} }}`"
    near = did_you_mean(name, here)
    if near is None and (word := suggest(name, library)) is not None:
        near = f"did you mean `{word}`? bring it in: `use {library[word]} {{ {word} }}`"
    if near is None and (alike := _of_one_kind(name, library)):
        near = f"did you mean {any_of(alike)}? bring it in, as in `use {library[alike[0]]} {{ {alike[0]} }}`"
    return near


def kin(name: str, known: Collection[str]) -> list[str]:
    """The names of which ``name`` is a word, and those of materials that are nearest to what others call ``name``: `blue_fabric` and
    `grey_fabric` for `fabric` and for `cloth`."""
    told = foreign.MATERIALS.get(name.lower(), "").split()
    return [word for word in known if word in told or name.lower() in word.split("_")][:_NEAR]


def _of_one_kind(name: str, known: Collection[str]) -> list[str]:
    """The names that have the last word of ``name``, which says what it is: `steel` and `black_steel` for `brushed_steel`."""
    *others, last = name.lower().split("_")
    return [word for word in known if others and last in word.split("_")][:_NEAR]


def nearest(name: str, known: Collection[str]) -> list[str]:
    """The name that resembles ``name`` most; before it those of the same kind, if this has a name of its own: `rubber` for `black_rubber`,
    and `black_tube` after that. Else those of its kind."""
    near, alike = suggest(name, known), _of_one_kind(name, known)
    if near is None or near in alike:
        return alike if near is None else [near]
    return [*(alike if name.lower().split("_")[-1] in alike else []), near]


def module_of(name: str, *kinds: str) -> str | None:
    """The module of the library that declares a name as one of some kinds."""
    return _modules(kinds).get(name)


def _modules(kinds: Collection[str] = ()) -> dict[str, str]:
    """The module of each name that the library declares, of some kinds or all."""
    return {
        word: path.stem
        for path in sorted(library_dir().glob("*.apg"), reverse=True)
        for kind, word in DECLARED.findall(path.read_text(encoding="utf-8"))
        if kind in kinds or not kinds
    }
