"""Kinds of tokens that messages and recovery tell apart, by the names of their terminals."""

from __future__ import annotations

from functools import cache

from .grammar import machine

OPERATORS = frozenset(
    "PLUS MINUS STAR SLASH CARET EQUALS UNEQUAL LESS AT_MOST MORE AT_LEAST AND OR IS ARROW UNTIL UPTO COMMA EQUAL DOT "
    "TILDE COLON IN ON IF".split()
)
"""What stands between two others."""

COMPARISONS = frozenset("EQUALS UNEQUAL LESS AT_MOST MORE AT_LEAST".split())

VALUE = frozenset({"NUMBER", "NAME", "LPAR"})
"""Of what begins a value, enough to know that the parser would take one."""


@cache
def statement_words() -> frozenset[str]:
    """What begins a statement in a body, as the grammar says; `when` is two terminals."""
    return _beginnings("_statement") | {"WHEN"}


@cache
def file_words() -> frozenset[str]:
    """What begins a declaration of a file."""
    return _beginnings("_top")


def _beginnings(rule: str) -> frozenset[str]:
    """The terminals that a rule of the grammar begins with."""
    firsts = {r.expansion[0] for r in machine().lark.rules if r.origin.name == rule}
    return frozenset[str]().union(*({s.name} if s.is_term else _beginnings(s.name) for s in firsts))
