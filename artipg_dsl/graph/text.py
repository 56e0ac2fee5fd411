"""The text form of a program: printable, read back to the same program, and what artefacts hold and hashes are of.

One item a line. ``@n`` is a scope, ``$n`` a column, ``%n`` an expression (numbered in the order of dependence); a record
is ``(Name field value ...)`` without the fields that have their default; a list is ``[...]``. ``#`` begins a comment.
"""

from __future__ import annotations

import json
import re
from collections.abc import Iterator
from dataclasses import MISSING, fields, is_dataclass
from hashlib import blake2b
from typing import Any

from . import program as P
from .expr import CROSSING, Column, Expr, Scope, raw, show
from .primitive import Patch, Piece, Primitive
from .reference import Elsewhere, Onward, Under

VERSION = 1
RECORDS = {
    cls.__name__: cls
    for cls in (
        P.Where, P.Pose, P.Bound, P.Limit, P.Union, P.Draw, P.Requirement, P.Preference, P.Part, P.Site, P.Link, P.Joint,
        P.Target, P.Label, P.Grasp, P.Keypoint, P.Material, P.Allowed, P.Closure, P.Slot, P.Clear, P.Stable, Primitive, Patch, Piece,
        Under, Elsewhere, Onward,
    )
}  # fmt: skip
LISTS = (
    "requirements", "preferences", "parts", "links", "joints", "sites", "labels", "grasps", "keypoints", "allowed", "closures", "slots",
    "clear", "stable",
)  # fmt: skip


class TextError(Exception):
    """A text that is no program of this version."""


# ---------------------------------------------------------------- writing


class _Writer:
    def __init__(self, program: P.Program, places: bool):
        self.program, self.places = program, places
        self.scopes = {s: k for k, s in enumerate(program.scopes)}
        self.columns: dict[Column, int] = {}
        self.exprs: dict[Expr, int] = {}
        self.lines: list[str] = []

    def emit(self, text: str) -> None:
        self.lines.append(text)

    def column(self, column: Column) -> str:
        if column not in self.columns:
            self.columns[column] = len(self.columns)
            number = self.columns[column]
            self.emit(f"${number} = {column.kind} @{self.scopes[column.scope]} {json.dumps(column.name)}")
        return f"${self.columns[column]}"

    def expr(self, root: Expr) -> str:
        stack = [root]
        while stack:
            node = stack[-1]
            if node in self.exprs:
                stack.pop()
                continue
            missing = [a for a in node.args if a not in self.exprs]
            if missing:
                stack.extend(reversed(missing))
                continue
            stack.pop()
            words = [node.op, *self.payload(node), *(f"%{self.exprs[a]}" for a in node.args)]
            self.exprs[node] = len(self.exprs)
            self.emit(f"%{self.exprs[node]} = {' '.join(words)}")
        return f"%{self.exprs[root]}"

    def payload(self, node: Expr) -> list[str]:
        value = node.value
        if node.op == "const":
            return [self.encode(value)]
        if node.op == "col":
            return [self.column(value)]
        if node.op == "var":
            return [json.dumps(value)]
        if node.op == "phi":
            return ["[" + " ".join(f"@{self.scopes[s]}" for s in value) + "]"]
        if node.op == "reduce":
            return [value[0], f"@{self.scopes[value[1]]}"]
        if isinstance(value, Scope):
            return [f"@{self.scopes[value]}"]
        if node.op in ("solve", "root"):
            return list(map(str, value))
        return []

    def encode(self, value: Any) -> str:
        if isinstance(value, Expr):
            return self.expr(value)
        if isinstance(value, Column):
            return self.column(value)
        if isinstance(value, Scope):
            return f"@{self.scopes[value]}"
        if value is None or isinstance(value, P.Where) and not self.places:
            return "none"
        if isinstance(value, bool):
            return "true" if value else "false"
        if isinstance(value, int | float):
            return repr(value)
        if isinstance(value, str):
            return json.dumps(value, ensure_ascii=False)
        if isinstance(value, tuple | list):
            return "[" + " ".join(map(self.encode, value)) + "]"
        assert is_dataclass(value)
        words = [type(value).__name__]
        for field in fields(value):
            item = getattr(value, field.name)
            default = field.default
            if field.default_factory is not MISSING:
                default = field.default_factory()
            if field.name in ("doc", "where") and not self.places:
                continue
            if default is not MISSING and type(item) is type(default) and item == default:
                continue
            words += [field.name, self.encode(item)]
        return "(" + " ".join(words) + ")"


def to_text(program: P.Program, *, places: bool = True) -> str:
    """The program as text; without ``places`` also without source positions and documentation (for the hash)."""
    writer = _Writer(program, places)
    for number, scope in enumerate(program.scopes):
        if scope.parent is None:
            writer.emit(f"@{number} = {scope.kind} {json.dumps(scope.name)}")
        else:
            assert scope.count is not None
            count = writer.expr(scope.count)
            writer.emit(
                f"@{number} = {scope.kind} {json.dumps(scope.name)} in @{writer.scopes[scope.parent]} count {count}"
            )
    for draw in program.draws:
        writer.column(draw.column)
    for draw in program.draws:
        line = writer.encode(draw)
        writer.emit(f"draw {line}" + (f"  # {draw.column.name}" if places else ""))
    for column, value in program.definitions.items():
        name, found = writer.column(column), writer.expr(value)
        comment = show(value) if places else ""
        writer.emit(f"define {name} {found}" + (f"  # {column.name} = {comment[:160]}" if places else ""))
    for name in LISTS:
        for item in getattr(program, name):
            writer.emit(f"{name} {writer.encode(item)}")
    for kind in ("materials", "primitives"):
        for item in getattr(program, kind).values():
            writer.emit(f"{kind} {writer.encode(item)}")
    for name, words in program.vocabularies.items():
        writer.emit(f"vocabulary {json.dumps(name)} {writer.encode(words)}")
    head = [f"apgc {VERSION}", f"program {json.dumps(program.name)}"]
    if places and program.doc:
        head.append(f"doc {json.dumps(program.doc, ensure_ascii=False)}")
    return "\n".join([*head, *writer.lines, ""])


def digest(program: P.Program) -> str:
    """The hash of what a program computes: places and documentation left out."""
    return blake2b(to_text(program, places=False).encode(), digest_size=16).hexdigest()


# ---------------------------------------------------------------- reading

_TOKEN = re.compile(r'\s*(?:(#[^\n]*)|("(?:[^"\\]|\\.)*")|([()\[\]])|([^\s()\[\]#]+))')


def _tokens(line: str) -> Iterator[str]:
    at = 0
    while at < len(line):
        match = _TOKEN.match(line, at)
        if match is None:
            break
        at = match.end()
        if match.group(1) is None:
            yield match.group().strip()


class _Reader:
    def __init__(self) -> None:
        self.scopes: list[Scope] = []
        self.columns: list[Column] = []
        self.exprs: list[Expr] = []
        self.words: list[str] = []
        self.at = 0

    def next(self) -> str:
        word = self.words[self.at]
        self.at += 1
        return word

    def value(self) -> Any:
        word = self.next()
        if word == "[":
            items = []
            while self.words[self.at] != "]":
                items.append(self.value())
            self.at += 1
            return tuple(items)
        if word == "(":
            return self.record()
        return self.atom(word)

    def record(self) -> Any:
        cls = RECORDS[self.next()]
        found: dict[str, Any] = {}
        while self.words[self.at] != ")":
            name = self.next()
            value = self.value()
            found[name] = list(value) if cls is P.Draw and name in ("bounds", "unions", "limits") else value
        self.at += 1
        return cls(**found)

    def atom(self, word: str) -> Any:
        first = word[0]
        if first == "%":
            return self.exprs[int(word[1:])]
        if first == "@":
            return self.scopes[int(word[1:])]
        if first == "$":
            return self.columns[int(word[1:])]
        if first == '"':
            return json.loads(word)
        if word in ("none", "true", "false"):
            return {"none": None, "true": True, "false": False}[word]
        return int(word) if re.fullmatch(r"-?\d+", word) else float(word)

    def expression(self) -> Expr:
        op = self.next()
        if op == "const":
            return raw("const", (), self.value())
        if op in ("col", "var", "rank"):
            value = self.value()
            return raw(op, (), value, value.scope if op == "col" else value if op == "rank" else None)
        value, scope = None, None
        if op == "phi":
            value = self.value()
            scope = value[0].parent
        elif op == "reduce":
            kind, child = self.next(), self.value()
            value, scope = (kind, child), child.parent
        elif op in CROSSING:
            value = self.value()
            scope = value.parent if op == "element" else value
        elif op in ("solve", "root"):
            value = tuple(self.value() for _ in range(2 if op == "solve" else 1))
        args = []
        while self.at < len(self.words):
            args.append(self.value())
        return raw(op, tuple(args), value, scope)


def from_text(text: str) -> P.Program:
    """The program of a text. Raises TextError for anything that is none."""
    lines = text.split("\n")
    if not lines or lines[0].split() != ["apgc", str(VERSION)]:
        raise TextError(f"this is no compiled program of version {VERSION}")
    program, reader = P.Program(""), _Reader()
    for number, line in enumerate(lines[1:], 2):
        reader.words, reader.at = list(_tokens(line)), 0
        if not reader.words:
            continue
        try:
            _item(program, reader)
        except (IndexError, KeyError, ValueError, TypeError, AttributeError) as error:
            raise TextError(f"line {number} of the compiled program cannot be read: {error}") from error
    if not program.scopes:
        raise TextError("the compiled program is empty")
    program.hash = digest(program)
    return program


def _item(program: P.Program, reader: _Reader) -> None:
    word = reader.next()
    if word[0] in "@$%":
        reader.next()  # the equals sign
        if word[0] == "%":
            reader.exprs.append(reader.expression())
        elif word[0] == "$":
            kind, scope, name = reader.next(), reader.value(), reader.value()
            reader.columns.append(Column(scope, name, kind))
        else:
            kind, name = reader.next(), reader.value()
            scope = Scope(name, None, kind)
            if reader.at < len(reader.words):
                reader.next()
                scope.parent = reader.value()
                reader.next()
                scope.count = reader.value()
            reader.scopes.append(scope)
            program.scopes.append(scope)
    elif word == "program":
        program.name = reader.value()
    elif word == "doc":
        program.doc = reader.value()
    elif word == "draw":
        program.draws.append(reader.value())
    elif word == "define":
        column = reader.value()
        program.definitions[column] = reader.value()
    elif word in LISTS:
        getattr(program, word).append(reader.value())
    elif word in ("materials", "primitives"):
        item = reader.value()
        getattr(program, word)[item.name] = item
    elif word == "vocabulary":
        name = reader.value()
        program.vocabularies[name] = reader.value()
    else:
        raise ValueError(f"unknown item {word}")
