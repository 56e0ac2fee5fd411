"""The text form of a program: printable, read back to the same program, and what artefacts hold and hashes are of.

One item a line. ``@n`` is a scope, ``$n`` a column, ``%n`` an expression (numbered in the order of dependence); a record
is ``(Name field value ...)`` without the fields that have their default; a list is ``[...]``. ``#`` begins a comment.
"""

from __future__ import annotations

import json
import re
from collections.abc import Callable, Container, Sequence
from dataclasses import MISSING, fields
from functools import cache
from hashlib import blake2b
from itertools import chain
from typing import Any

from ..shapes import Misfit
from . import program as P
from .expr import CROSSING, Column, Expr, Scope, show
from .functions import FUNCTIONS
from .nodes import NodeFault, Nodes, require
from .primitive import Patch, Piece, Primitive
from .reference import Elsewhere, Onward, Under
from .verify import Verifier

_VERSION = 1
_RECORDS = {
    cls.__name__: cls
    for cls in (
        P.Where,
        P.Pose,
        P.Bound,
        P.Limit,
        P.Union,
        P.Draw,
        P.Requirement,
        P.Preference,
        P.Part,
        P.Site,
        P.Link,
        P.Gate,
        P.Joint,
        P.Target,
        P.Label,
        P.Grasp,
        P.Keypoint,
        P.Material,
        P.Allowed,
        P.Closure,
        P.Slot,
        P.Clear,
        P.Stable,
        Primitive,
        Patch,
        Piece,
        Under,
        Elsewhere,
        Onward,
    )
}
_KINDS = frozenset(_RECORDS.values())
_KEPT = {
    "draw": P.Draw,
    "requirements": P.Requirement,
    "preferences": P.Preference,
    "parts": P.Part,
    "links": P.Link,
    "joints": P.Joint,
    "sites": P.Site,
    "labels": P.Label,
    "grasps": P.Grasp,
    "keypoints": P.Keypoint,
    "allowed": P.Allowed,
    "closures": P.Closure,
    "slots": P.Slot,
    "clear": P.Clear,
    "stable": P.Stable,
    "materials": P.Material,
    "primitives": Primitive,
}
_LISTS = tuple(word for word in _KEPT if word not in ("draw", "materials", "primitives"))
_DEEPEST = 64  # lists and records within one another


class TextError(Exception):
    """A text that is no program of this version."""


# ---------------------------------------------------------------- writing


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
    head = [f"apgc {_VERSION}", f"program {json.dumps(program.name)}"]
    doc = [f"doc {json.dumps(program.doc, ensure_ascii=False)}"] if program.doc else []
    computed = [writer.bare.get(number, line) for number, line in enumerate(writer.lines)]
    seal = blake2b("\n".join([*head, *computed, ""]).encode(), digest_size=16).hexdigest()
    return "\n".join([*head, *doc, *writer.lines, ""]), seal


def to_words(value: Any) -> str:
    """Expressions and records outside of a program, with what holds them together, as ``from_words`` reads them."""
    writer = _Writer(P.Program(""))
    last = writer.encode(value)
    return "\n".join([*writer.lines, last])


# ---------------------------------------------------------------- reading

# the most frequent first, and texts in one go; what begins like a text and does not end is a word
_TOKEN = re.compile(r'[^\s()\[\]#"][^\s()\[\]#]*|[()\[\]]|"[^"\\]*(?:\\.[^"\\]*)*"|#[^\n]*|"[^\s()\[\]#]*')
_REFERENCE = re.compile(r"[%@$][0-9]{1,9}")
_WHOLE = re.compile(r"-?[0-9]{1,18}")


def _tokens(line: str) -> list[str]:
    words = _TOKEN.findall(line)
    if words and words[-1][0] == "#":
        words.pop()
    return words


@cache
def _fields(kind: type) -> tuple[frozenset[str], tuple[str, ...]]:
    """The fields of a record, and those that must be given."""
    needed = [f.name for f in fields(kind) if f.default is MISSING and f.default_factory is MISSING]
    return frozenset(f.name for f in fields(kind)), tuple(needed)


class Reader:
    """Reads items line by line; what it gives out has the right structure, but for what only the whole program tells."""

    def __init__(self, program: P.Program) -> None:
        self.program = program
        self.nodes = Nodes()
        self.verifier = Verifier(program, self.nodes)
        self.scopes: list[Scope] = []
        self.columns: list[Column] = []
        self.exprs: list[Expr] = []
        self.named: dict[str, Expr] = {}  # the same as they are written: %0, %1
        self.texts: dict[str, str] = {}  # by what they are written as; most of them stand there again and again
        self.known: dict[str, list[Any]] = {"%": self.exprs, "@": self.scopes, "$": self.columns}
        self.items: list[tuple[int, Any, int]] = []  # line, record, its number among those of its kind
        self.words: list[str] = []
        self.at = 0

    def next(self) -> str:
        if self.at >= len(self.words):
            raise NodeFault("the line ends too early")
        word = self.words[self.at]
        self.at += 1
        return word

    def ends(self, mark: str) -> bool:
        """Whether the next word is ``mark``, which is then read."""
        if self.at >= len(self.words):
            raise NodeFault(f"the line ends before {mark}")
        found = self.words[self.at] == mark
        self.at += found
        return found

    def expect(self, mark: str) -> None:
        word = self.next()
        if word != mark:
            raise NodeFault(f"expected {mark}, found {word[:40]!r}")

    def value(self, depth: int = 0) -> Any:
        word = self.next()
        known = self.named.get(word)
        if known is not None:
            return known
        if word != "[":
            return self.record(depth + 1) if word == "(" else self.atom(word)
        if depth >= _DEEPEST:
            raise NodeFault("the line is nested too deeply")
        words, named = self.words, self.named
        items: list[Any] = []
        while not self.ends("]"):
            known = named.get(words[self.at])
            if known is None:
                items.append(self.value(depth + 1))
            else:  # an expression, as most items are
                items.append(known)
                self.at += 1
        return tuple(items)

    def record(self, depth: int) -> Any:
        if depth > _DEEPEST:
            raise NodeFault("the line is nested too deeply")
        name = self.next()
        cls = _RECORDS.get(name)
        if cls is None:
            raise NodeFault(f"there is no record {name[:40]!r}")
        return cls(**self.fields(cls, depth))

    def fields(self, cls: type, depth: int, skipped: Container[str] = ()) -> dict[str, Any]:
        """The fields of a record that follow, without those to be ``skipped``."""
        known, needed = _fields(cls)
        found: dict[str, Any] = {}
        while not self.ends(")"):
            key = self.next()
            if key not in known:
                raise NodeFault(f"{cls.__name__} has no field {key[:40]!r}")
            if key in found:
                raise NodeFault(f"the field {key} of {cls.__name__} is given twice")
            if key in skipped:
                self.skip()
                found[key] = None
                continue
            value = self.value(depth)
            as_list = cls is P.Draw and key in ("bounds", "unions", "limits") and isinstance(value, tuple)
            found[key] = list(value) if as_list else value
        missing = [one for one in needed if one not in found]
        if missing:
            raise NodeFault(f"{cls.__name__} has no {', '.join(missing)}")
        return {key: value for key, value in found.items() if key not in skipped} if skipped else found

    def skip(self) -> None:
        """Goes over a value without reading it."""
        depth = 0
        while True:
            word = self.next()
            depth += (word in ("(", "[")) - (word in (")", "]"))
            if depth <= 0:
                return

    def atom(self, word: str) -> Any:
        if word in self.texts:
            return self.texts[word]
        if _REFERENCE.fullmatch(word):
            among, number = self.known[word[0]], int(word[1:])
            if number >= len(among):
                raise NodeFault(f"{word} is not known before this line")
            return among[number]
        if word[0] == '"':
            try:
                text = json.loads(word)
                text.encode()
            except (ValueError, UnicodeEncodeError):
                raise NodeFault(f"{word[:40]} is not text") from None
            self.texts[word] = text
            return text
        if word in ("none", "true", "false"):
            return {"none": None, "true": True, "false": False}[word]
        try:
            return int(word) if _WHOLE.fullmatch(word) else float(word)
        except ValueError:
            raise NodeFault(f"{word[:40]!r} is not a value") from None

    def expression(self) -> Expr:
        op = self.next()
        value: Any = None
        if op == "reduce":
            value = self.next(), self.value()
        elif op in ("const", "col", "var", "rank", "phi") or op in CROSSING:
            value = self.value()
        elif op in ("solve", "root"):
            value = tuple(self.value() for _ in range(2 if op == "solve" else 1))
        args = []
        while self.at < len(self.words):
            args.append(self.value())
        return self.nodes.make(op, value, tuple(args))

    def begin(self, line: str) -> None:
        """Goes to the beginning of a line."""
        self.words, self.at = _tokens(line), 0

    def finish(self) -> None:
        if self.at != len(self.words):
            raise NodeFault(f"there is more after the end of the line: {self.words[self.at :][:1]}")

    def plain(self, line: str, name: str) -> Expr | None:
        """What the line of an expression of this name is, if it is an operation on expressions before, as nearly all lines of a program
        are; None for any other."""
        words, named = line.split(" "), self.named
        if len(words) < 4 or words[2] not in FUNCTIONS or words[1] != "=" or words[0] != name:
            return None
        try:
            args = tuple([named[word] for word in words[3:]])
        except KeyError:
            return None
        made = named[name] = self.nodes.plain(words[2], args)
        return made

    def expression_of(self, line: str, name: str) -> None:
        """Reads the line of an expression of this name."""
        if self.plain(line, name) is None:
            self.begin(line)
            self.expect(name)
            self.expect("=")
            self.named[name] = self.expression()

    def add(self, expr: Expr) -> None:
        self.named[f"%{len(self.exprs)}"] = expr
        self.exprs.append(expr)

    def item(self, line: int) -> None:
        """The item of a line."""
        word, program = self.next(), self.program
        if word[0] in "@$%":
            among = self.known[word[0]]
            if word[1:] != str(len(among)):
                raise NodeFault(f"expected {word[0]}{len(among)}, found {word[:40]}")
            self.expect("=")
            if word[0] == "%":
                self.add(self.expression())
            else:
                among.append(self.column() if word[0] == "$" else self.scope())
        elif word in ("program", "doc"):
            text = self.value()
            require(isinstance(text, str), f"{word} is text")
            setattr(program, "name" if word == "program" else "doc", text)
        elif word == "define":
            column, value = self.value(), self.value()
            self.verifier.definition(column, value)
            program.definitions[column] = value
        elif word in _KEPT:
            item = self.value()
            require(type(item) is _KEPT[word], f"{word} is of records {_KEPT[word].__name__}")
            held = getattr(program, "draws" if word == "draw" else word)
            self.items.append((line, item, len(held)))
            if isinstance(held, list):
                held.append(item)
            else:
                require(isinstance(item.name, str) and item.name not in held, f"{word} must have different names")
                held[item.name] = item
        elif word == "vocabulary":
            name, words = self.value(), self.value()
            self.verifier.vocabulary(name, words)
            program.vocabularies[name] = words
        else:
            raise NodeFault(f"there is no item {word[:40]!r}")
        self.finish()

    def column(self) -> Column:
        kind, scope, name = self.next(), self.value(), self.value()
        column = Column(scope, name, kind)
        self.verifier.column(column)
        return column

    def scope(self) -> Scope:
        kind, name = self.next(), self.value()
        scope = Scope(name, None, kind)
        if self.at < len(self.words):
            self.expect("in")
            scope.parent = self.value()
            self.expect("count")
            scope.count = self.value()
        self.verifier.scope(scope)
        self.program.scopes.append(scope)
        return scope


def _last(lines: Sequence[str]) -> tuple[int, int]:
    """From which line on, and before which, there is nothing but primitives and expressions that they alone read."""
    begin = next((k for k, line in enumerate(lines) if line.startswith("primitives ")), len(lines))
    end = begin
    while begin and lines[begin - 1][:1] == "%":
        begin -= 1
    while end < len(lines) and lines[end].startswith(("%", "primitives ")):
        end += 1
    return begin, end


def from_text(text: str, known: str = "", later: Callable[[Reader, Sequence[str]], None] | None = None) -> P.Program:
    """The program of a text, verified; its hash is what is ``known`` of it, or else found. ``later``, if given, takes the lines of the
    primitives and of what they alone read. Raises TextError for anything that is none."""
    lines = text.split("\n")
    if lines[0].split() != ["apgc", str(_VERSION)]:
        raise TextError(f"this is not a compiled program of version {_VERSION}")
    program = P.Program("")
    reader = Reader(program)
    begin, end = (len(lines), len(lines)) if later is None else _last(lines)
    exprs, number = reader.exprs, 0
    try:
        for number, line in chain(enumerate(lines[1:begin], 2), enumerate(lines[end:], end + 1)):
            if line[:1] == "%":
                made = reader.plain(line, f"%{len(exprs)}")
                if made is not None:
                    exprs.append(made)
                    continue
            reader.begin(line)
            if reader.words:
                reader.item(number)
        if later is not None:
            later(reader, lines[begin:end])
        for check in (reader.verifier.shape, reader.verifier.item):
            for at, item, place in reader.items:
                number = at
                check(item, place)
    except (NodeFault, Misfit) as error:
        raise TextError(f"line {number} of the compiled program: {error}") from None
    try:
        reader.verifier.whole()
    except NodeFault as error:
        raise TextError(f"the compiled program is incomplete or damaged: {error}") from None
    program.hash, program.foreign = known or digest(program), True
    return program


def from_words(text: str) -> Any:
    """What ``to_words`` has written, its primitives verified. Raises TextError for anything else."""
    reader = Reader(P.Program(""))
    *lines, last = text.split("\n")
    try:
        for line in lines:
            made = reader.plain(line, f"%{len(reader.exprs)}") if line[:1] == "%" else None
            if made is None:
                reader.begin(line)
                reader.item(0)
            else:
                reader.exprs.append(made)
        reader.begin(last)
        value = reader.value()
        reader.finish()
        for item in value if isinstance(value, tuple) else ():
            if isinstance(item, Primitive):
                reader.verifier.shape(item, 0)
                reader.verifier.item(item, 0)
        return value
    except (NodeFault, Misfit) as error:
        raise TextError(str(error)) from None
