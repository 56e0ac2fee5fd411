"""Programs as text, and their hashes; ``text`` says what the text looks like."""

from __future__ import annotations

import json
from dataclasses import MISSING, fields
from functools import cache
from hashlib import blake2b
from typing import Any

from . import program as P
from .expr import Column, Expr, Scope, show
from .primitive import Primitive
from .text import KEPT, RECORDS, VERSION

_KINDS = frozenset(RECORDS.values())
_LISTS = tuple(word for word in KEPT if word not in ("draw", "materials", "primitives"))


class _Writer:
    def __init__(self, program: P.Program):
        self.program = program
        self.scopes = {s: k for k, s in enumerate(program.scopes)}
        self.columns: dict[Column, int] = {}
        self.exprs: dict[Expr, str] = {}  # as lines name them: %0, %1
        self.lines: list[str] = []
        # lines that are others without places, documentation and comments, which nothing reads back
        self.bare: dict[int, str] = {}

    def emit(self, text: str) -> None:
        self.lines.append(text)

    def item(self, word: str, item: Any, comment: str = "") -> None:
        """A line of a record; its expressions have lines before, which are the same without places."""
        parts = f"{word} {self.marked(item)}".split(_PLACE)
        self.bare[len(self.lines)] = "".join(parts[::2])
        self.emit("".join(parts) + comment)

    def column(self, column: Column) -> str:
        if column not in self.columns:
            self.columns[column] = len(self.columns)
            number = self.columns[column]
            self.emit(f"${number} = {column.kind} @{self.scopes[column.scope]} {json.dumps(column.name)}")
        return f"${self.columns[column]}"

    def expr(self, root: Expr) -> str:
        names, lines = self.exprs, self.lines
        path = [] if root in names else [(root, iter(root.args))]
        while path:  # as `bottom_up` goes, at half the time: of what a check takes, this is much
            node, rest = path[-1]
            for below in rest:
                if below not in names:
                    path.append((below, iter(below.args)))
                    break
            else:
                path.pop()
                words = () if node.value is None else self.payload(node)
                name = f"%{len(names)}"
                lines.append(" ".join([name, "=", node.op, *words, *map(names.__getitem__, node.args)]))
                names[node] = name
        return names[root]

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
        return self.marked(value).replace(_PLACE, "")

    def marked(self, value: Any) -> str:
        """A value as text; places and documentation stand between marks."""
        kind: Any = type(value)
        if kind is Expr:
            return self.exprs.get(value) or self.expr(value)
        if kind is tuple or kind is list:
            return f"[{' '.join(map(self.marked, value))}]"
        if kind is str:
            return _quoted(value)
        if kind in _KINDS:
            words = [f"({kind.__name__}"]
            for name, default, mark in _defaults(kind):
                item = getattr(value, name)
                if item is default or type(item) is type(default) and item == default:
                    continue
                words.append(f"{mark} {name} {self.marked(item)}{mark}")
            return "".join([*words, ")"])
        if isinstance(value, Column):
            return self.column(value)
        if isinstance(value, Scope):
            return f"@{self.scopes[value]}"
        if value is None:
            return "none"
        if isinstance(value, bool):
            return "true" if value else "false"
        assert isinstance(value, int | float), kind
        return repr(value)


_quoted = json.JSONEncoder(ensure_ascii=False).encode  # `dumps` would make one for each text
_PLACE = "\0"  # which no text has that is written


@cache
def _defaults(record: type[Any]) -> tuple[tuple[str, Any, str], ...]:
    """The names of the fields of a record, what each is by default, and the marks around what nothing is computed from."""
    return tuple(
        (
            field.name,
            field.default if field.default_factory is MISSING else field.default_factory(),
            _PLACE if field.name in ("doc", "where") else "",
        )
        for field in fields(record)
    )


def to_text(program: P.Program) -> str:
    """The program as text, which ``from_text`` reads."""
    return write(program)[0]


def digest(program: P.Program) -> str:
    """The hash of what a program computes: places and documentation left out."""
    return write(program)[1]


def primitive_digest(primitive: Primitive) -> str:
    """What tells a primitive from any other, by its formulas."""
    return digest(P.Program("", primitives={primitive.name: primitive}))


def write(program: P.Program) -> tuple[str, str]:
    """The program as text, and the hash of what it computes."""
    writer = _Writer(program)
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
        writer.item("draw", draw, f"  # {draw.column.name}")
    for column, value in program.definitions.items():
        name, found = writer.column(column), writer.expr(value)
        line = f"define {name} {found}"
        writer.bare[len(writer.lines)] = line
        writer.emit(f"{line}  # {column.name} = {show(value, 160)[:160]}")
    for name in _LISTS:
        for item in getattr(program, name):
            writer.item(name, item)
    for kind in ("materials", "primitives"):
        for item in getattr(program, kind).values():
            writer.item(kind, item)
    for name, words in program.vocabularies.items():
        writer.emit(f"vocabulary {json.dumps(name)} {writer.encode(words)}")
    head = [f"apgc {VERSION}", f"program {json.dumps(program.name)}"]
    doc = [f"doc {json.dumps(program.doc, ensure_ascii=False)}"] if program.doc else []
    computed = [writer.bare.get(number, line) for number, line in enumerate(writer.lines)]
    seal = blake2b("\n".join([*head, *computed, ""]).encode(), digest_size=16).hexdigest()
    return "\n".join([*head, *doc, *writer.lines, ""]), seal


def to_words(value: Any) -> str:
    """Expressions and records outside of a program, with what holds them together, as ``from_words`` reads them."""
    writer = _Writer(P.Program(""))
    last = writer.encode(value)
    return "\n".join([*writer.lines, last])
