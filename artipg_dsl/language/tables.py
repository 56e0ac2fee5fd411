"""The tables of the language in Markdown, as they stand in the reference: ``pytest tests/docs/test_language.py --update-golden``."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from functools import partial
from itertools import groupby

from .functions import FORMS
from .kinds import DISTRIBUTIONS, JOINTS, OPERATORS, Kind
from .members import MEMBERS
from .words import TYPES, WORDS


def types() -> str:
    """Names of types, one row for those that mean the same; what may be declared in spite of them is marked."""
    rows = groupby(TYPES.values(), key=lambda word: (word.about, word.free))
    shown = ((" ".join(f"`{w.name}`" for w in found), about, "yes" * free) for (about, free), found in rows)
    return _table(("type", "values", "may be declared"), shown)


def words() -> str:
    return _table(("word", "meaning"), ((f"`{word.name}`", word.about) for word in WORDS.values()))


def functions() -> str:
    """One row per form; ``?`` marks what may be left out."""
    return _table(("function", "what it gives"), ((f"`{form}`", form.about) for form in FORMS))


def members() -> str:
    """Types and what stands after a dot behind them."""
    heads = {"box": "`part`, `slot`, `box`, element of a repeat"}
    return _table(
        ("of", "members"),
        ((heads.get(of, f"`{of}`"), " ".join(f"`{name}`" for name in found)) for of, found in MEMBERS.items()),
    )


def kinds(head: tuple[str, ...], table: Mapping[str, Kind]) -> str:
    """One row or more for each kind of a statement."""
    return _table(head, (tuple(row.split(" | ")) for kind in table.values() for row in kind.about.split("\n")))


TABLES = {
    "types": types,
    "words": words,
    "functions": functions,
    "members": members,
    "distributions": partial(kinds, ("distribution", "meaning"), DISTRIBUTIONS),
    "operators": partial(kinds, ("operator", "clauses", "makes"), OPERATORS),
    "joints": partial(kinds, ("kind", "axis", "range"), JOINTS),
}
"""By the mark that stands before a table in the reference."""


def _table(head: tuple[str, ...], rows: Iterable[tuple[str, ...]]) -> str:
    lines = [head, *rows]
    texts = ["| " + " | ".join(cell.replace("|", "\\|") for cell in row) + " |\n" for row in lines]
    return texts[0] + "|---" * len(head) + "|\n" + "".join(texts[1:])
