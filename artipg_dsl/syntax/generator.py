"""Lark's parser of grammar/apg.lark, kept between runs (see ``cache``).

It makes the tables by which texts are parsed (see ``tables``), and knows what is wrong with a text that has a mistake.
"""

from __future__ import annotations

import io
import json
import pickle
from typing import Any

import lark
from lark import Lark
from lark.common import LexerConf
from lark.lexer import ContextualLexer

from .. import cache
from .layout import Layout

OPTIONS: dict[str, Any] = {
    "parser": "lalr",
    "lexer": "contextual",
    "start": "module",
    "keep_all_tokens": True,
    "maybe_placeholders": False,
}


def generate(text: str, layout: Layout, use_cache: bool) -> Lark:
    """The parser of a grammar, its tokens through a layout."""
    live = {"postlex": layout, "lexer_callbacks": {"COMMENT": layout.comment, "DOC": layout.comment}}
    if not use_cache or cache.folder() is None:
        return _built(text, live)
    entry = cache.key("grammar", text, repr(sorted(OPTIONS.items())), lark.__version__)
    found = _from_cache(entry, live)
    if found is None:
        found = _built(text, live)
        _store(found, entry)
    return found


def _built(text: str, live: dict[str, Any]) -> Lark:
    found = Lark(text, **OPTIONS, **live, _plugins={"ContextualLexer": _unvalidated})
    found.options._plugins.clear()  # not to be kept
    return found


def _unvalidated(conf: LexerConf, *others: Any, **options: Any) -> ContextualLexer:
    """A lexer whose terminals are not compared with one another, which takes four times as long as all else: a test does that once."""
    conf.skip_validation = True
    return ContextualLexer(conf, *others, **options)


def _as_data(tables: Any) -> list[Any]:
    """The tables, which lark saves as a pickle, as JSON: a file is only data. Equal values, of which tables are full, are written
    once: each value is a row, that of a list, tuple or dict names the rows of its items."""
    rows: list[Any] = []
    numbers: dict[str, int] = {}

    def number(value: Any) -> int:
        match value:
            case dict():
                row = ["dict", [number(key) for key in value], [number(held) for held in value.values()]]
            case list() | tuple():
                row = [type(value).__name__, [number(held) for held in value]]
            case _:
                row = value
        text = json.dumps(row)
        if text not in numbers:
            numbers[text] = len(rows)
            rows.append(row)
        return numbers[text]

    number(tables)
    return rows


def _from_data(rows: list[Any]) -> Any:
    found: list[Any] = []
    for row in rows:
        match row:
            case ["dict", keys, values]:
                found.append({found[key]: found[value] for key, value in zip(keys, values, strict=True)})
            case ["list", items]:
                found.append([found[item] for item in items])
            case ["tuple", items]:
                found.append(tuple([found[item] for item in items]))
            case _:
                found.append(row)
    return found[-1]


def _from_cache(entry: str, live: dict[str, Any]) -> Lark | None:
    body = cache.read(entry)
    if body is None:
        return None
    try:
        parser = Lark.__new__(Lark)
        return parser._load(_from_data(json.loads(body)), **live)
    except Exception:  # whatever is wrong with the entry, building the tables anew is the answer
        cache.drop(entry)
        return None


def _store(parser: Lark, entry: str) -> None:
    tables = io.BytesIO()
    parser.save(tables, ("postlex", "lexer_callbacks"))
    cache.write(entry, json.dumps(_as_data(pickle.loads(tables.getvalue())), separators=(",", ":")).encode())
