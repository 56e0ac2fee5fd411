"""What all nodes of the tree have in common, and the clauses of statements."""

from __future__ import annotations

from dataclasses import fields
from typing import Any, Generic, TypeVar

from ...records import dataclass
from ...source import Span

Value = TypeVar("Value")


@dataclass(frozen=True, slots=True, kw_only=True)
class Node:
    span: Span


@dataclass(frozen=True, slots=True, kw_only=True)
class Clause(Node, Generic[Value]):
    """A word and what stands behind it: ``to E``, ``fit a, b``, ``range a .. b``; the span is that of both.

    Clauses are fields of their statement, named as their word is (``in_`` and ``from_`` with an underscore). ``word`` is for messages.
    """

    word: str
    value: Value


@dataclass(frozen=True, slots=True, kw_only=True)
class Stmt(Node):
    """``doc`` is the text of the ``##`` comments that stand before (or after, on the line of) a declaration."""

    doc: str = ""


def clause_words(kind: type[Stmt]) -> tuple[str, ...]:
    """The words of the clauses that a statement of this kind may have, as messages list them."""
    return tuple(f.name.rstrip("_") for f in fields(kind) if str(f.type).startswith("Clause["))


def value_of(clause: Clause[Value] | None) -> Value | None:
    """What stands behind the word of a clause; None without it."""
    return None if clause is None else clause.value


def present(*parts: Value | None) -> list[Value]:
    """Those of some parts of a statement that are there."""
    return [part for part in parts if part is not None]


def clauses(statement: Stmt) -> list[Clause[Any]]:
    """The clauses of a statement in the order of the text, known or not."""
    found: list[Clause[Any]] = []
    for field in fields(statement):
        value = getattr(statement, field.name)
        found += [c for c in (value if isinstance(value, tuple) else (value,)) if isinstance(c, Clause)]
    return sorted(found, key=lambda c: c.span.start)
