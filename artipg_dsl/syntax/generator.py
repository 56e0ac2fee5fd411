"""Lark's parser of grammar/apg.lark, and its cache in the user's cache folder.

It makes the tables by which texts are parsed (see ``tables``), and knows what is wrong with a text that has a mistake. The cache is a
convenience: missing, unreadable, corrupt or read-only, it is made anew or done without.
"""

from __future__ import annotations

import hashlib
import io
import json
import os
import pickle
import sys
import tempfile
from pathlib import Path
from typing import Any

import lark
from lark import Lark

from .layout import Layout

OPTIONS: dict[str, Any] = {
    "parser": "lalr",
    "lexer": "contextual",
    "start": "module",
    "keep_all_tokens": True,
    "maybe_placeholders": False,
}


def generate(text: str, layout: Layout, use_cache: bool = True) -> Lark:
    """The parser of a grammar, its tokens through a layout."""
    live = {"postlex": layout, "lexer_callbacks": {"COMMENT": layout.comment, "DOC": layout.comment}}
    path = _cache_path(text) if use_cache else None
    return _from_cache(path, live) or _built(text, path, live)


def _built(text: str, path: Path | None, live: dict[str, Any]) -> Lark:
    parser = Lark(text, **OPTIONS, **live)
    if path is not None:
        _store(parser, path)
    return parser


def _cache_path(grammar: str) -> Path | None:
    """Where the tables of this grammar belong, for this lark and Python; None where no home is known."""
    key = "\0".join((grammar, repr(sorted(OPTIONS.items())), lark.__version__, sys.version))
    name = f"tables-{hashlib.sha256(key.encode()).hexdigest()[:20]}.json"
    chosen = os.environ.get("XDG_CACHE_HOME") or os.environ.get("LOCALAPPDATA")
    try:
        folder = Path(chosen) if chosen else Path.home() / ".cache"
    except RuntimeError:
        return None
    return folder / "artipg_dsl" / name


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


def _from_cache(path: Path | None, live: dict[str, Any]) -> Lark | None:
    if path is None:
        return None
    try:
        data = _from_data(json.loads(path.read_text(encoding="utf-8")))
        parser = Lark.__new__(Lark)
        return parser._load(data, **live)
    except Exception:  # whatever is wrong with the file, building the tables anew is the answer
        return None


def _store(parser: Lark, path: Path) -> None:
    """Writes beside the place and renames, so that no reader ever sees half a file."""
    temporary = None
    try:
        path.parent.mkdir(parents=True, exist_ok=True)
        tables = io.BytesIO()
        parser.save(tables, ("postlex", "lexer_callbacks"))
        text = json.dumps(_as_data(pickle.loads(tables.getvalue())), separators=(",", ":"))
        with tempfile.NamedTemporaryFile(dir=path.parent, prefix=path.name, delete=False) as file:
            temporary = file.name
            file.write(text.encode("utf-8"))
        os.replace(temporary, path)
    except OSError:
        if temporary is not None and os.path.exists(temporary):
            os.unlink(temporary)
