"""The examples of a documentation page: its ``apg`` fences, and the program that each stands for."""

from __future__ import annotations

import re
from dataclasses import dataclass
from pathlib import Path

from artipg_dsl.diagnostics import Report
from artipg_dsl.resources import library_dir
from artipg_dsl.semantics.modules import Workspace
from artipg_dsl.session import Session
from artipg_dsl.source import Source
from artipg_dsl.syntax import ast
from artipg_dsl.syntax.parse import parse

_FENCE = re.compile(r"^```apg(?P<mark>[^\n]*)\n(?P<text>.*?)^```$", re.MULTILINE | re.DOTALL)
_DECLARED = re.compile(
    r"^\s*(?:(?:role|template|primitive|category|vocabulary)\s+(\w+)|material\s+(\w+)\s*\{)", re.MULTILINE
)
BODY = "root part body : OpenBox(size = [30cm, 50cm, 25cm], wall = 12mm)"


@dataclass(frozen=True, slots=True)
class Fence:
    """One example. ``mark`` is what follows ``apg`` on the opening line:

    (nothing)       a file, or declarations of one
    as PART         declarations, used as `root part it : PART` of a category
    in category     statements of a category whose root is an open box named `body`
    typed           before one of these: checked for names and types alone
    fails CODE      before one of these: the error that the example brings about
    """

    line: int
    mark: str
    text: str

    @property
    def code(self) -> str | None:
        """The error that is expected."""
        words = self.mark.split()
        return words[1] if words[:1] == ["fails"] else None

    @property
    def lowered(self) -> bool:
        return not self.mark.startswith("typed")

    @property
    def program(self) -> str:
        """The whole file that the example stands for, with what it uses of the library brought in."""
        place = re.sub(r"^(typed|fails \S+)\s*", "", self.mark)
        text = self.text
        if place == "in category":
            text = f"category Example {{\n{BODY}\n{text}}}\n"
        elif place.startswith("as "):
            text = f"{text}\ncategory Example {{\n  root part it : {place[3:]}\n}}\n"
        elif place:
            raise ValueError(f"line {self.line}: there is no mark `{place}`")
        if text.lstrip().startswith("apg "):
            return text
        return f"apg 1\n{imports(text)}{text}"


def fences(page: Path) -> list[Fence]:
    """The examples of a page, in order."""
    text = page.read_text(encoding="utf-8")
    return [Fence(text.count("\n", 0, m.start()) + 1, m["mark"].strip(), m["text"]) for m in _FENCE.finditer(text)]


def imports(text: str) -> str:
    """A line of ``use`` per library module of which ``text`` uses something that it neither declares nor imports itself."""
    words = set(re.findall(r"\w+", text))
    own = {
        *declared(text),
        *re.findall(r"\w+", " ".join(re.findall(r"^use \w+ \{(.*?)\}", text, re.DOTALL | re.MULTILINE))),
    }
    lines = []
    for path in sorted(library_dir().glob("*.apg")):
        used = sorted((words - own).intersection(declared(path.read_text(encoding="utf-8"))))
        if used:
            lines.append(f"use {path.stem} {{ {', '.join(used)} }}\n")
    return "".join(lines)


def declared(text: str) -> list[str]:
    """The names that the top level of a file declares."""
    return [a or b for a, b in _DECLARED.findall(text)]


_TREES: dict[str, ast.Module] = {}  # the library does not change while tests run


def session_of(fence: Fence, name: str) -> Session:
    """The compilation of an example; modules of the library are parsed once for all of them."""
    session = Session.of_text(fence.program, name)
    session.__dict__["workspace"] = Workspace(session.report, [library_dir()], loader=_parsed)
    return session


def _parsed(source: Source, report: Report) -> ast.Module | None:
    if source.text not in _TREES:
        tree = parse(source, report)
        if tree is None:
            return None
        _TREES[source.text] = tree
    return _TREES[source.text]
