"""Programs from their text, of which nothing is taken on trust; ``text`` says what it looks like."""

from __future__ import annotations

import json
import re
from collections.abc import Callable, Container, Sequence
from copyreg import pickle
from dataclasses import MISSING, fields
from functools import cache
from itertools import chain
from typing import Any

from ..shapes import Misfit
from . import program as P
from .expr import CROSSING, Column, Expr, Scope
from .functions import FUNCTIONS
from .nodes import NodeFault, Nodes, require
from .primitive import Primitive
from .text import KEPT, RECORDS, VERSION
from .verify import Verifier
from .writing import digest, to_text

_DEEPEST = 64  # lists and records within one another


class TextError(Exception):
    """A text that is no program of this version."""


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
        self.atoms: dict[str, Any] = {}  # by what they are written as; most of them stand there again and again
        self.known: dict[str, list[Any]] = {"%": self.exprs, "@": self.scopes, "$": self.columns}
        self.items: list[tuple[int, Any, int]] = []  # line, record, its number among those of its kind
        self.words: list[str] = []
        self.at = 0

    def next(self) -> str:
        try:
            word = self.words[self.at]
        except IndexError:
            raise NodeFault("the line ends too early") from None
        self.at += 1
        return word

    def ends(self, mark: str) -> bool:
        """Whether the next word is ``mark``, which is then read."""
        try:
            found = self.words[self.at] == mark
        except IndexError:
            raise NodeFault(f"the line ends before {mark}") from None
        self.at += found
        return found

    def expect(self, mark: str) -> None:
        word = self.next()
        if word != mark:
            raise NodeFault(f"expected {mark}, found {word[:40]!r}")

    def value(self, depth: int = 0) -> Any:
        word = self.next()
        known = self.named.get(word) or self.atoms.get(word)  # an expression is never false
        if known is not None:
            return known
        if word != "[":
            return self.record(depth + 1) if word == "(" else self.atom(word)
        if depth >= _DEEPEST:
            raise NodeFault("the line is nested too deeply")
        words, named, atoms = self.words, self.named, self.atoms
        items: list[Any] = []
        while not self.ends("]"):
            word = words[self.at]
            known = named.get(word) or atoms.get(word)
            if known is None:
                items.append(self.value(depth + 1))
            else:  # as nearly all items are
                items.append(known)
                self.at += 1
        return tuple(items)

    def record(self, depth: int) -> Any:
        if depth > _DEEPEST:
            raise NodeFault("the line is nested too deeply")
        name = self.next()
        cls = RECORDS.get(name)
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
        """What a word says that is read for the first time, and again where it says nothing."""
        if word == "none":
            return None
        found = self.atoms[word] = self._atom(word)
        return found

    def _atom(self, word: str) -> Any:
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
            return text
        if word in ("true", "false"):
            return word == "true"
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
        elif word in KEPT:
            item = self.value()
            require(type(item) is KEPT[word], f"{word} is of records {KEPT[word].__name__}")
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
    if lines[0].split() != ["apgc", str(VERSION)]:
        raise TextError(f"this is not a compiled program of version {VERSION}")
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


def _to_pickle(program: P.Program) -> tuple[Callable[[str, str], P.Program], tuple[str, str]]:
    return _from_pickle, (to_text(program), program.hash)


def _from_pickle(text: str, found: str) -> P.Program:
    program = from_text(text)
    program.hash = found
    return program


pickle(P.Program, _to_pickle)  # to another process goes the text: nodes of expressions are known by identity
