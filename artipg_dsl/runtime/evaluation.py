"""A plan carried out: line by line at first, by compiled Python once that pays.

To compile a plan takes as long as to run it five to twenty times, and most are run a few times. The bits are the same.
"""

from __future__ import annotations

from ast import literal_eval
from collections.abc import Callable, Iterator, Mapping, Sequence
from operator import attrgetter, getitem, itemgetter
from typing import Any

import numpy as np

from ..native.loops import FUNCTIONS
from .kernels import Rows, State, crowded, full
from .lines import Argument, Call, Line, Step, constant, flat, whole

_OFTEN = 16  # runs from which on compiled Python takes less time, that of compiling it included

_STEPS: dict[str, Callable[..., Any]] = {**FUNCTIONS, "where": np.where}
_WRITTEN: dict[str, Callable[..., Any]] = {
    "take": getitem,
    "ranks": lambda rows: rows.rank.astype(np.float64),
    "widened": lambda rows, value: full(rows, value).astype(np.float64),
}
_quiet = np.errstate(divide="ignore", invalid="ignore", over="ignore")
Values = tuple[list[Rows], list[Any]]


class Evaluation:
    """What some lines make of a state: ``tables`` and ``values`` by their names. ``known`` are the functions that they call."""

    def __init__(self, lines: Sequence[Line], tables: Sequence[str], values: Sequence[str], known: Mapping[str, Any]):
        self._lines, self._tables, self._values, self._known = lines, tables, values, known
        self._runs = 0
        self._run: Callable[[State], Values] | None = None

    def __call__(self, state: State) -> Values:
        if self._run is None:
            written = any([type(line) is str for line in self._lines])  # functions, which are Python
            self._run = (
                self._compiled()
                if written
                else _quiet(_Stepwise(self._lines, self._tables, self._values, self._known).run)
            )
        elif self._runs == _OFTEN:
            self._run = self._compiled()
        self._runs += 1
        return self._run(state)

    def _compiled(self) -> Callable[[State], Values]:
        bare = (line.bare() if type(line) is Step else line for line in self._lines)
        namespace = dict(self._known)
        code = compile(whole(bare, self._tables, self._values), "<plan>", "exec")
        exec(code, namespace)  # no text of a program but literals
        found: Callable[[State], Values] = namespace["evaluate"]
        return found


class _Stepwise:
    """Lines as calls of functions on places of a list: of the state, of literals, of what lines before have made."""

    def __init__(self, lines: Sequence[Line], tables: Sequence[str], values: Sequence[str], known: Mapping[str, Any]):
        self._start: list[Any] = [None]
        self._places = {"state": 0}
        self._calls: list[tuple[Callable[..., Any], int | slice, Callable[[list[Any]], Sequence[Any]]]] = []
        functions = {**known, **_WRITTEN}
        for line in lines:
            if type(line) is Step:
                self._add(_STEPS[line.op], (line.name,), line.arguments)
            elif type(line) is Call:
                self._add(functions[line.function], line.names, line.arguments, line.several)
        self._tables, self._values = self._all(tables), self._all(values)

    def run(self, state: State) -> Values:
        found = self._start.copy()
        found[0] = state
        for function, place, given in self._calls:
            found[place] = function(*given(found))
        crowded(state)
        return list(self._tables(found)), list(self._values(found))

    def _add(
        self, function: Callable[..., Any], names: Sequence[str], arguments: Sequence[Argument], several: bool = False
    ) -> None:
        plain = [one for one in arguments if isinstance(one, str)]
        if len(plain) < len(arguments):
            function, plain = _nested(function, tuple(arguments)), list(flat(tuple(arguments)))
        given, first = self._all(plain), len(self._start)
        self._calls.append((function, slice(first, first + len(names)) if several else first, given))
        self._start += [None] * max(1, len(names))
        self._places.update(zip(names, range(first, len(self._start)), strict=False))

    def _all(self, names: Sequence[str]) -> Callable[[list[Any]], Sequence[Any]]:
        """What fetches names and literals."""
        known = self._places
        places = [known[name] if name in known else self._place(name) for name in names]
        if len(places) > 1:
            return itemgetter(*places)
        first = places[0] if places else 0
        return itemgetter(slice(first, first + len(places)))  # of one place it would give what is there

    def _place(self, name: str) -> int:
        """A new place for a literal, or for a column of a table."""
        if name.endswith(".parent"):
            self._add(attrgetter("parent"), (name,), (name.removesuffix(".parent"),))
        else:
            self._places[name] = len(self._start)
            self._start.append(_literal(name))
        return self._places[name]


def _literal(text: str) -> Any:
    """What a literal stands for: a text, a whole number, nothing, a number or a truth value."""
    return literal_eval(text) if text[0] in "'\"" or text.isdigit() or text == "None" else constant(text)


def _nested(function: Callable[..., Any], arguments: tuple[Argument, ...]) -> Callable[..., Any]:
    """The same function of arguments that are not put together."""

    def built(shape: Argument, given: Iterator[Any]) -> Any:
        return next(given) if isinstance(shape, str) else tuple([built(one, given) for one in shape])

    def call(*given: Any) -> Any:
        return function(*built(arguments, iter(given)))

    return call
