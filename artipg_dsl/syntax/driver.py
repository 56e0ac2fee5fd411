"""From text to tree by the tables: tokens one by one, each as the parser's state takes them, and the actions of a builder.

It does what lark's parser does with a contextual lexer, at a fifth of its start: where a text has a mistake it says so and no more, and
lark is asked what it is (see ``grammar``).
"""

from __future__ import annotations

import re
from collections.abc import Callable, Iterator
from functools import cache
from typing import Any

from .layout import Layout
from .tables import Tables
from .token import Token

_END = "$END"
Action = Callable[[list[Any]], Any]


class _Mistake(Exception):
    """No token or no rule fits here."""


class Driver:
    """A parser by tables whose rules are built by the methods of ``builder`` that bear their names. Not for two parses at once."""

    def __init__(self, tables: Tables, layout: Layout, builder: object):
        self.layout, self.states = layout, tables["states"]
        self.first, self.last = tables["first"], tables["last"]
        self.words, self.patterns = tables["words"], tables["terminals"]
        self.ignored, self.kept = frozenset(tables["ignored"]), frozenset(layout.always_accept)
        self.any = re.compile("|".join(f"(?P<{name}>{pattern})" for name, pattern in self.patterns))
        self.rules = [
            (name, size, inner, single, single and size == 1 and not inner, _action(builder, action))
            for name, action, size, inner, single in tables["rules"]
        ]
        self._leaps: dict[tuple[int, int, str], int] = {}

    def parse(self, text: str) -> Any:
        """What the builder makes of the whole; None where the text has a mistake."""
        states, values = [self.first], list[Any]()
        try:
            for token in self.layout.process(self._tokens(text, states)):
                self._reduce(token.type, states, values)
                states.append(self.states[states[-1]][token.type])
                values.append(token)
            self._reduce(_END, states, values)
        except _Mistake:
            return None
        return values[-1]

    def _reduce(self, kind: str, states: list[int], values: list[Any]) -> None:
        """Apply the rules that end before a token of this kind, until a state takes it. Raises _Mistake."""
        table, rules, leaps = self.states, self.rules, self._leaps
        while True:
            to = table[states[-1]].get(kind)
            if to is None:
                raise _Mistake
            if to >= 0:
                return
            name, size, inner, single, same, action = rules[~to]
            if same:
                place = states[-2], states[-1], kind
                leap = leaps.get(place)
                if leap is None:
                    leap = leaps[place] = self._leap(*place)
                states[-1] = leap
                continue
            found = values[-size:] if size else []
            if size:
                del states[-size:], values[-size:]
            for k in reversed(inner):
                found[k : k + 1] = found[k]
            values.append(found[0] if single and len(found) == 1 else action(found))
            states.append(table[states[-1]][name])
            if kind is _END and states[-1] == self.last:
                return

    def _leap(self, below: int, state: int, kind: str) -> int:
        """The state that follows ``state`` once all rules are applied by which a level of an expression is the next one alone: a dozen,
        most of the time."""
        while True:
            to = self.states[state].get(kind, 0)
            if to >= 0 or not self.rules[~to][4]:
                return state
            state = self.states[below][self.rules[~to][0]]

    def _tokens(self, text: str, states: list[int]) -> Iterator[Token]:
        """The tokens that the parser is given, one at a time: which they are depends on its state. Raises _Mistake."""
        at, size, words, match = 0, len(text), self.words, self.any.match
        while at < size:
            found = match(text, at)
            if found is None:
                raise _Mistake
            kind, value, end = found.lastgroup or "", found[0], found.end()
            takes = self.states[states[-1]]
            for name in words.get(value, ()):
                if name in takes:
                    kind = name
                    break
            else:
                if kind not in takes and kind not in self.ignored and kind not in self.kept:
                    kind, end = self._other(text, at, takes)
                    value = text[at:end]
            start, at = at, end
            if kind not in self.ignored:
                yield Token(kind, value, start, end)
            elif kind != "BLANK":
                self.layout.comment(Token(kind, value, start, end))

    def _other(self, text: str, at: int, takes: dict[str, int]) -> tuple[str, int]:
        """What else may stand at a place: the first terminal that the state takes, and its end."""
        for name, pattern in self.patterns:
            if name in takes:
                found = _compiled(pattern).match(text, at)
                if found is not None:
                    return name, found.end()
        raise _Mistake


@cache
def _compiled(pattern: str) -> re.Pattern[str]:
    return re.compile(pattern)


def _action(builder: object, action: str) -> Action:
    """The method of a rule; where there is none its children stand in place of the whole."""
    found: Action = getattr(builder, action, list)
    return found
