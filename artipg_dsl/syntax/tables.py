"""The tables by which texts are parsed, as data: what a state of the parser does with a token, and what the terminals look like.

They are taken from lark's parser of the grammar (see ``generator``) and lie beside it in ``tables.json``, where most states share what they
take: a test writes the file, and tells when it is not that of the grammar.
"""

from __future__ import annotations

import json
from typing import TYPE_CHECKING, Any, TypedDict

from ..cache import digest
from ..resources import grammar_file

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


def read_tables(grammar: str) -> Tables | None:
    """The tables of a grammar as they lie beside it; None where the file is of another text."""
    try:
        found = json.loads(grammar_file().with_name("tables.json").read_text(encoding="utf-8"))
    except OSError:
        return None
    return _unfolded(found) if found["grammar"] == digest([grammar]) else None


def to_json(tables: Tables, grammar: str) -> str:
    """The file of the tables of a grammar, a line for each item of a list."""
    groups: dict[tuple[str, ...], int] = {}  # the symbols that a state treats alike, which many states share
    states = []
    for takes in tables["states"]:
        alike: dict[int, list[str]] = {}
        for name, to in takes.items():
            alike.setdefault(to, []).append(name)
        states.append([[to, groups.setdefault(tuple(names), len(groups))] for to, names in alike.items()])
    told = {"grammar": digest([grammar]), **tables, "groups": [" ".join(names) for names in groups], "states": states}
    return "{\n" + ",\n".join(f"{json.dumps(key)}: {_lines(value)}" for key, value in told.items()) + "\n}\n"


def _lines(value: object) -> str:
    if not isinstance(value, list):
        return json.dumps(value)
    return "[\n" + ",\n".join(json.dumps(item, separators=(",", ":")) for item in value) + "\n]"


def _unfolded(told: Any) -> Tables:
    groups = [names.split() for names in told.pop("groups")]
    told["states"] = [{name: to for to, group in state for name in groups[group]} for state in told["states"]]
    del told["grammar"]
    found: Tables = told
    return found


def tables_of(parser: Lark) -> Tables:
    """The tables of lark's parser; rules and states are numbered by what they are like, as lark's numbers differ from run to run."""
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
    rules = sorted(parser.rules, key=lambda rule: (*_rule(rule)[:2], [symbol.name for symbol in rule.expansion]))
    numbers = {rule: ~number for number, rule in enumerate(rules)}
    places = {table.start_states["module"]: 0}  # lark's number of a state: ours, in the order they are reached
    states: list[dict[str, int]] = []
    waiting = list(places)
    for state in waiting:
        row: dict[str, int] = {}
        for name, (_, to) in sorted(table.states[state].items()):
            if to not in numbers and to not in places:
                places[to] = len(places)
                waiting.append(to)
            row[name] = numbers[to] if to in numbers else places[to]
        states.append(row)
    return {
        "terminals": terminals,
        "words": words,
        "reserved": reserved,
        "ignored": sorted(parser.lexer_conf.ignore),
        "states": states,
        "rules": [_rule(rule) for rule in rules],
        "first": 0,
        "last": places[table.end_states["module"]],
    }


def _rule(rule: Rule) -> tuple[str, str, int, list[int], bool]:
    inner = [k for k, symbol in enumerate(rule.expansion) if not symbol.is_term and symbol.name.startswith("_")]
    single = rule.options.expand1 and rule.alias is None
    return rule.origin.name, rule.alias or rule.origin.name, len(rule.expansion), inner, single
