"""Text to syntax tree. Errors go to the report, in words; the tree is None when there were any."""

from __future__ import annotations

import gc
import os
import tempfile
from functools import lru_cache
from pathlib import Path
from typing import Any

from lark import Lark, Token, UnexpectedCharacters, UnexpectedInput, UnexpectedToken
from lark.exceptions import LarkError

from ..diagnostics import Report
from ..resources import grammar_file
from ..source import Source, Span
from . import ast, messages
from .build import Builder


def load(path: Path, report: Report, name: str | None = None) -> Source | None:
    """Read a file; what is wrong with it goes to the report."""
    shown = name or str(path)
    try:
        data = path.read_bytes()
    except FileNotFoundError:
        report.error("missing-file", None, f"there is no file {shown}", hint="check the path, or name a shipped category")
        return None
    except IsADirectoryError:
        report.error("missing-file", None, f"{shown} is a folder", hint="name an .apg file in it")
        return None
    except OSError as error:
        report.error("missing-file", None, f"{shown} cannot be read: {error.strerror}")
        return None
    try:
        return Source(shown, data.decode("utf-8-sig").replace("\r\n", "\n"))
    except UnicodeDecodeError as error:
        text = data[: error.start].decode("utf-8", "replace") + "\N{REPLACEMENT CHARACTER}"
        source = Source(shown, text)
        span = Span(source, len(text) - 1, len(text))
        report.error("not-utf8", span, "this is not UTF-8 text", hint="save the file in the encoding UTF-8")
        return None


def parse(source: Source, report: Report) -> ast.Module | None:
    """The tree of a source, or None after reporting why there is none."""
    builder = Builder(source)
    enabled = gc.isenabled()
    gc.disable()  # the tree is kept whole: collecting while it grows only costs time
    try:
        return parser(builder).parse(source.text)  # type: ignore[return-value]
    except UnexpectedInput as error:
        messages.report_error(error, source, report)
        return None
    finally:
        if enabled:
            gc.enable()


def parser(builder: Builder) -> Lark:
    """A parser that builds nodes as it goes and hands comments to the builder."""
    text, cache = grammar_text(), cache_file()
    options: dict[str, Any] = {
        "parser": "lalr", "lexer": "contextual", "keep_all_tokens": True, "maybe_placeholders": False, "transformer": builder,
        "lexer_callbacks": {"WHEN": lambda token: guard_or_when(token, builder.source), "COMMENT": lambda token: note(token, builder)},
    }  # fmt: skip
    if cache is not None:
        try:
            return Lark(text, cache=cache, **options)
        except (OSError, LarkError, EOFError, ValueError, KeyError, AttributeError, TypeError):
            pass  # a cache that cannot be read or written is no reason to fail
    return Lark(text, **options)


@lru_cache(maxsize=1)
def grammar_text() -> str:
    return grammar_file().read_text(encoding="utf-8")


@lru_cache(maxsize=1)
def cache_file() -> str | None:
    """Where the compiled grammar is kept for this user; None where no such folder can be had."""
    base = os.environ.get("XDG_CACHE_HOME") or os.path.join(os.path.expanduser("~"), ".cache")
    for folder in (Path(base) / "artipg_dsl", Path(tempfile.gettempdir()) / "artipg_dsl"):
        try:
            folder.mkdir(parents=True, exist_ok=True)
            if os.access(folder, os.W_OK):
                from hashlib import blake2b

                from lark import __version__ as lark_version

                digest = blake2b(f"{lark_version}\n{grammar_text()}".encode(), digest_size=12).hexdigest()
                return str(folder / f"grammar-{digest}.lark-cache")
        except OSError:
            continue
    return None


def guard_or_when(token: Token, source: Source) -> Token:
    """``when`` at the start of a line, after a brace or after ``else`` opens a block; anywhere else it is a guard."""
    start = token.start_pos or 0
    before = source.text[source.text.rfind("\n", 0, start) + 1 : start].rstrip()
    if before and before[-1] not in "{}" and not before.endswith("else"):
        token.type = "GUARD"
    return token


def note(token: Token, builder: Builder) -> Token:
    builder.comments.append(token)
    return token


__all__ = ["UnexpectedCharacters", "UnexpectedToken", "load", "parse"]
