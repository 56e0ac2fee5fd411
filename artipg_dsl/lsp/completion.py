"""What may be written at a place: names that are declared there, members of what stands before a dot, parameters of what is made,
words of a vocabulary, modules and what they declare.

A text that is being typed seldom has a tree at its end, so what stands before the place is read from its characters; names and
types are those of the rest.
"""

from __future__ import annotations

import re
from collections.abc import Iterable, Iterator
from pathlib import Path
from typing import NamedTuple

from ..language import FUNCTIONS, JOINTS, TYPES, WORDS
from ..semantics.alternatives import taken
from ..semantics.check import TypedProgram
from ..semantics.parts import box_member
from ..semantics.scope import BodyScope
from ..semantics.types import UNKNOWN, Type
from ..syntax import ast
from ..syntax.grammar import terminal_words
from ..syntax.words import file_words, statement_words
from .analysis import Analysis
from .lookup import feature, features, inside

_PATH = re.compile(r"((?:[A-Za-z_]\w*(?:\[[^\[\]]*\])?\s*\.\s*)*)(?:[A-Za-z_]\w*)?$")
_QUIET = re.compile(r'"[^"\n]*"?|#[^\n]*')
_CALL = re.compile(r"([A-Za-z_]\w*)\s*$")
_USE = re.compile(r"\buse\s+(?:(\w+)\s*\{[^{}]*)?\w*$")
_JOINT = re.compile(r"\bjoint\s+\w+\s*:\s*\w*$")
_TYPE = re.compile(r"\b(?:param|inherit|out|port|field)\s+[\w\s,\[\]?]+:\s*\w*$")
_BEGIN = re.compile(r"(?:^|[{}])\s*\w*$")
_OPERAND = re.compile(
    r"(?:[-=+*/^(\[,<>|:]|\b(?:in|on|to|at|by|from|and|or|not|if|else|is|where|when|about|along))\s*\w*$"
)


class Suggestion(NamedTuple):
    """``kind`` is what it is in the language: param, part, template, function, keyword ...; ``about`` says more."""

    name: str
    kind: str
    about: str = ""


def complete(analysis: Analysis, offset: int) -> list[Suggestion]:
    """What may stand at a place, each name once, nearest first; nothing inside comments and strings."""
    before = analysis.source.text[:offset]
    line = before.rpartition("\n")[2]
    if _within_quiet(line):
        return []
    found = dict[str, Suggestion]()
    for suggestion in _suggested(analysis, _QUIET.sub(lambda m: " " * len(m[0]), before), offset):
        found.setdefault(suggestion.name, suggestion)
    return list(found.values())


def _within_quiet(line: str) -> bool:
    """Whether the end of a line lies within a comment or a string."""
    last = next((found[0] for found in _QUIET.finditer(line) if found.end() == len(line)), "")
    return last.startswith("#") or last.count('"') == 1


def _suggested(analysis: Analysis, before: str, offset: int) -> Iterator[Suggestion]:
    line = before.rpartition("\n")[2]
    use = _USE.search(before)
    if use is not None:
        yield from _usable(analysis, use[1])
        return
    analysis = analysis.without_line(offset)
    typed, scope = analysis.typed, analysis.scope(offset)
    path = _PATH.search(before)
    if path is not None and path[1]:
        if typed is not None:
            yield from _behind(typed, scope, re.findall(r"[A-Za-z_]\w*(?=\s*(?:\[[^\[\]]*\])?\s*\.)", path[1]), line)
        return
    if scope is None and analysis.around(offset) is None:
        yield from _beginnings(file_words())
        return
    if _JOINT.search(line):
        yield from (Suggestion(name, "keyword") for name in JOINTS)
        return
    if _TYPE.search(line):
        yield from (Suggestion(word.name, "type", word.about) for word in TYPES.values())
        return
    if _BEGIN.search(line):
        yield from _beginnings(statement_words())
        return
    if not _OPERAND.search(line):
        yield from (Suggestion(word, "keyword") for word in _clauses(line))
    yield from _arguments(analysis, before)
    yield from _names(analysis, scope)


def _beginnings(terminals: Iterable[str]) -> Iterator[Suggestion]:
    words = terminal_words()
    return (Suggestion(words[terminal], "keyword") for terminal in sorted(terminals))


def _usable(analysis: Analysis, module: str | None) -> Iterator[Suggestion]:
    """What `use` may name: modules beside the file and in the library, or what a module declares."""
    workspace, folder = analysis.workspace(), Path(analysis.source.name).parent
    if module is None:
        yield from (Suggestion(name, "module") for name in workspace.available(folder))
        return
    found = workspace.locate(module, folder, folder)
    scope = None if found is None else workspace.load_file(*found)
    for symbol in [] if scope is None else scope.own():
        yield Suggestion(symbol.name, symbol.kind, symbol.decl.doc)


def _behind(typed: TypedProgram, scope: BodyScope | None, path: list[str], line: str) -> Iterator[Suggestion]:
    """What may follow a path and its dot."""
    if len(path) == 1 and re.search(r"\blabel\s+\w+\s*\.\s*\w*$", line):
        for word in sorted(typed.checker.vocabularies.get(path[0], ())):
            yield Suggestion(word, "word")
        return
    kind = _type_of(typed, scope, path)
    for entry in inside(typed, kind):
        yield Suggestion(entry.name, entry.kind, entry.node.doc)
    yield from (Suggestion(name, "member", about) for name, about in features(kind).items())


def _type_of(typed: TypedProgram, scope: BodyScope | None, path: list[str]) -> Type:
    """The type of a path of names, as far as it can be told without the place where it stands."""
    entries = [] if scope is None else scope.find(path[0])
    kind = typed.checker.entry_type(entries[0]) if entries else box_member(path[0]) or UNKNOWN
    for name in path[1:]:
        declared = next(inside(typed, kind, name), None)
        kind = typed.checker.entry_type(declared) if declared is not None else feature(kind, name)
    return kind


def _arguments(analysis: Analysis, before: str) -> Iterator[Suggestion]:
    """The parameters of the template in whose parentheses a place lies."""
    depth = 0
    for at in range(len(before) - 1, max(-1, len(before) - 2000), -1):
        depth += (before[at] in ")]") - (before[at] in "([")
        if depth < 0:
            called = _CALL.search(before, 0, at) if before[at] == "(" else None
            symbol = None if called is None or analysis.module is None else analysis.module.find(called[1])
            if symbol is not None and analysis.typed is not None:
                for entry in taken(analysis.typed.checker, symbol):
                    yield Suggestion(entry.name, "parameter", entry.node.doc)
            return


def _names(analysis: Analysis, scope: BodyScope | None) -> Iterator[Suggestion]:
    """What a bare name may stand for."""
    for body in [] if scope is None else scope.chain():
        yield from (Suggestion(entry.name, entry.kind, entry.node.doc) for entry in body.entries)
    for symbol in {} if analysis.module is None else analysis.module.names.values():
        if symbol.kind not in ("category", "vocabulary"):
            yield Suggestion(symbol.name, symbol.kind, symbol.decl.doc)
    yield from (Suggestion(name, "function", forms[0].about) for name, forms in FUNCTIONS.items())
    yield from (Suggestion(word.name, "constant", word.about) for word in WORDS.values())


def _clauses(line: str) -> list[str]:
    """The clauses of the statement that a line begins, behind what is complete."""
    first = re.match(r"\s*(?:root\s+)?(\w+)", line)
    kinds: dict[str, type[ast.Stmt]] = {"joint": ast.JointDecl, "connect": ast.ConnectStmt, "repeat": ast.RepeatStmt}
    kind = kinds.get(first[1]) if first is not None else None
    return list(ast.clause_words(kind)) if kind is not None else []
