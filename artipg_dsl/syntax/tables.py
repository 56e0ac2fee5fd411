"""The tables by which texts are parsed, as data: what a state of the parser does with a token, and what the terminals look like.

They are taken from lark's parser of the grammar (see ``generator``) once, and kept between runs (see ``cache``).
"""

from __future__ import annotations

import json
from typing import TYPE_CHECKING, Any, TypedDict

from .. import cache

if TYPE_CHECKING:
    from lark import Lark
    from lark.grammar import Rule

_WORD_ENDS = "(?![A-Za-z0-9_])"
"""What stands in the grammar behind each terminal that is a word."""
_RESERVED_PRIORITY = 2


class Tables(TypedDict):
    """``terminals``: names and patterns of those that are no words, in the order in which they are tried; ``words``: the terminals
    that a word may be, likewise; ``reserved``: words that are never names, and their terminals; ``ignored``: terminals that the
    parser does not see.

    ``states``: per state, by the names of terminals and rules, the next state, or a rule to apply, as its number counted down
    from -1. ``rules``: per rule its name, the name of its action, how many symbols it has, which of these give their children
    in place of themselves, and whether a single child stands for the whole.
    """

    terminals: list[tuple[str, str]]
    words: dict[str, list[str]]
    reserved: dict[str, str]
    ignored: list[str]
    states: list[dict[str, int]]
    rules: list[tuple[str, str, int, list[int], bool]]
    first: int
    last: int


def recall_tables(grammar: str) -> Tables | None:
    """The tables of a grammar as they were kept; None where they are to be made."""
    body = cache.read(_entry(grammar)) if cache.folder() is not None else None
    try:
        found: Tables | None = None if body is None else json.loads(body)
    except ValueError:
        return None
    return found


def tables_of(parser: Lark, grammar: str | None = None) -> Tables:
    """The tables of lark's parser; kept as those of ``grammar`` where it is given."""
    found = _made(parser)
    if grammar is not None:
        cache.write(_entry(grammar), json.dumps(found, separators=(",", ":")).encode())
    return found


def _entry(grammar: str) -> str:
    return cache.key("tables", grammar)


def _made(parser: Lark) -> Tables:
    found = sorted(parser.terminals, key=lambda t: (-t.priority, -t.pattern.max_width, -len(t.pattern.value), t.name))
    words: dict[str, list[str]] = {}
    reserved: dict[str, str] = {}
    terminals: list[tuple[str, str]] = []
    for terminal in found:
        word = terminal.pattern.value.removesuffix(_WORD_ENDS)
        if word != terminal.pattern.value and word.isalpha():
            words.setdefault(word, []).append(terminal.name)
            if terminal.priority == _RESERVED_PRIORITY:
                reserved[word] = terminal.name
        else:
            terminals.append((terminal.name, terminal.pattern.to_regexp()))
    table: Any = parser.parser.parser._parse_table
    numbers = {rule: number for number, rule in enumerate(parser.rules)}
    states: list[dict[str, int]] = []
    for state in range(len(table.states)):
        actions = table.states[state]
        states.append({name: ~numbers[to] if to in numbers else to for name, (_, to) in actions.items()})
    return {
        "terminals": terminals,
        "words": words,
        "reserved": reserved,
        "ignored": list(parser.lexer_conf.ignore),
        "states": states,
        "rules": [_rule(rule) for rule in parser.rules],
        "first": table.start_states["module"],
        "last": table.end_states["module"],
    }


def _rule(rule: Rule) -> tuple[str, str, int, list[int], bool]:
    inner = [k for k, symbol in enumerate(rule.expansion) if not symbol.is_term and symbol.name.startswith("_")]
    single = rule.options.expand1 and rule.alias is None
    return rule.origin.name, rule.alias or rule.origin.name, len(rule.expansion), inner, single
