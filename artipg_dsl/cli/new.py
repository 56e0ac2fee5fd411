"""``apgc new``: a file to start a category from, or a copy of one that is there."""

from __future__ import annotations

import argparse
import re
import shlex
from pathlib import Path

from ..diagnostics import CompileError
from ..errors import UsageError
from ..export.write import require_place, write_bytes
from ..language import reserved_name
from ..session import Session
from ..syntax import ast
from ..syntax.grammar import reserved_words
from .arguments import STREAM
from .messages import say


def run(options: argparse.Namespace) -> int:
    name = _checked(options.name)
    path = Path(options.out or f"{snake(name)}.apg")
    if options.out != STREAM and path.suffix != ".apg":
        inside = path.is_dir() or not path.name
        better = path / f"{snake(name)}.apg" if inside else path.with_suffix(".apg")
        raise UsageError(f"{path} is {'a folder' if inside else 'not the name of a program'}", f"write {better}")
    text = starting_point(name) if options.source is None else _copied(name, options.source)
    if re.search(rf"^use .*\b{name}\b", text, re.MULTILINE):
        raise UsageError(
            f"a category cannot be called `{name}` here: the file to start from uses the library's `{name}`",
            "choose another name",
        )
    if options.out == STREAM:
        print(text, end="")
        return 0
    require_place(path, options.force)
    write_bytes(path, text.encode(), force=options.force)
    typed = shlex.quote(str(path))
    say(f"wrote {path}, a complete category to start from\n  apgc check {typed}\n  apgc render {typed}")
    return 0


def starting_point(name: str) -> str:
    """The text of a category called ``name`` that compiles and samples as it is."""
    from jinja2 import Environment, PackageLoader, StrictUndefined

    environment = Environment(
        loader=PackageLoader("artipg_dsl.cli"), undefined=StrictUndefined, autoescape=False, keep_trailing_newline=True
    )
    return environment.get_template("category.apg.j2").render(name=name)


def _copied(name: str, source: str) -> str:
    """The text of a category, by name or file, called ``name``. Raises CompileError, UsageError."""
    session = Session.of(source)
    tree = session.tree
    category = None if tree is None else next((d for d in tree.declarations if isinstance(d, ast.CategoryDecl)), None)
    if session.report.failed:
        raise CompileError(session.report)
    if category is None:
        raise UsageError(f"{source} declares no category", "name a category, such as --from Microwave")
    span = category.name_span
    return span.source.text[: span.start] + name + span.source.text[span.end :]


def _checked(name: str) -> str:
    """``name`` if a category may be called so."""
    why = "a word of the language" if name in reserved_words() else reserved_name(name)
    if why is not None:
        raise UsageError(f"a category cannot be called `{name}`: it is {why}", "choose another name")
    if not re.fullmatch(r"[A-Z][A-Za-z0-9]*", name):
        words = [w for w in re.split(r"[^A-Za-z0-9]+", name.removesuffix(".apg")) if w]
        better = "".join(w[:1].upper() + w[1:] for w in words)
        if not name.isascii() or not re.fullmatch(r"[A-Z][A-Za-z0-9]*", better) or reserved_name(better):
            better = "a name such as DeskLamp"
        raise UsageError(
            f"`{name}` cannot name a category: it takes letters a to z and digits, and each word begins with a capital",
            f"write {better}",
        )
    return name


def snake(name: str) -> str:
    """``DeskLamp`` as the name of a file: ``desk_lamp``."""
    return re.sub(r"(?<=[a-z0-9])(?=[A-Z])|(?<=[A-Z])(?=[A-Z][a-z])", "_", name).lower()
