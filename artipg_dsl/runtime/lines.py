"""The lines of a plan, and the Python that they are.

Long runs of plain operations on one table become tapes, which take less time than code; the bits are the same.
"""

from __future__ import annotations

import re
from collections.abc import Iterable, Iterator, Sequence
from itertools import groupby
from typing import NamedTuple

from ..graph.expr import Scope
from ..graph.formula import NUMPY, Formula
from ..native.tape import Tape

_LONG = 24  # steps from which on a tape takes less time than code
_NAME = re.compile(r"x[0-9]+")


class Step(NamedTuple):
    """One operation on names and literals: a value for each row of a table, or one number for all of them (``scope`` is None)."""

    name: str
    op: str
    arguments: tuple[str, ...]
    scope: Scope | None

    def __str__(self) -> str:
        return f"    {self.name} = {NUMPY[self.op].format(*self.arguments)}"

    def bare(self) -> str:
        """The same without parentheses around the whole, which are a seventh of what it takes to compile."""
        text = NUMPY[self.op].format(*self.arguments)
        return f"    {self.name} = {text[1:-1] if text[0] == '(' else text}"


Argument = str | tuple["Argument", ...]  # a name or a literal as Python has it, or some of them together

# what looks otherwise than a call of a function
_WRITTEN = {"take": "{}[{}]", "ranks": "{}.rank.astype(np.float64)", "widened": "full({}, {}).astype(np.float64)"}


class Call(NamedTuple):
    """What a function makes of names and literals. It has one of the ``names``, or none; a tape, where ``several``, makes one for each."""

    names: tuple[str, ...]
    function: str
    arguments: tuple[Argument, ...]
    several: bool = False
    remark: str = ""  # a comment, on that line whatever it holds: it may come from a file that anyone wrote

    def __str__(self) -> str:
        told = [_shown(argument) for argument in self.arguments]
        text = (
            _WRITTEN[self.function].format(*told)
            if self.function in _WRITTEN
            else f"{self.function}({', '.join(told)})"
        )
        made = f"{', '.join(self.names)}{',' * self.several} = " if self.names else ""
        return f"    {made}{text}{'  # ' + ascii(self.remark)[1:-1] if self.remark else ''}"


def _shown(argument: Argument) -> str:
    if isinstance(argument, str):
        return argument
    return f"({', '.join(map(_shown, argument))}{',' * (len(argument) == 1)})"


def flat(arguments: Argument) -> Iterator[str]:
    """The names and literals of some arguments, in their order."""
    if isinstance(arguments, str):
        yield arguments
        return
    for one in arguments:
        yield from flat(one)


Line = str | Step | Call  # indented


def whole(lines: Iterable[Line], tables: Iterable[str], values: Iterable[str]) -> str:
    """The function ``evaluate`` of some lines, which returns tables and values by their names."""
    head = ['@np.errstate(divide="ignore", invalid="ignore", over="ignore")', "def evaluate(state):"]
    end = ["    crowded(state)", f"    tables = [{', '.join(tables)}]", "    values = ["]
    return "\n".join(
        [*head, *map(str, lines), *end, *[f"        {v}," for v in values], "    ]", "    return tables, values", ""]
    )


def taped(lines: Sequence[Line], values: Sequence[str]) -> tuple[list[Line], dict[str, Formula]]:
    """The same lines with long runs of steps as calls of tapes, and these by name; ``values`` are asked for in the end."""
    parts = [
        part for plain, run in groupby(lines, lambda line: type(line) is Step) for part in _parted(plain, list(run))
    ]
    home = {
        step.name: place for place, (long, part) in enumerate(parts) if long for step in part if isinstance(step, Step)
    }
    asked = set(values)  # names that other lines than those of their tape read
    for place, (_, part) in enumerate(parts):
        for line in part:
            read = _NAME.findall(line) if isinstance(line, str) else flat(line.arguments)
            asked.update([name for name in read if home.get(name, place) != place])
    told: list[Line] = []
    tapes: dict[str, Formula] = {}
    for place, (long, part) in enumerate(parts):
        if not long:
            told += part
            continue
        name = f"tape{place}"
        given, made, tapes[name] = _tape([step for step in part if isinstance(step, Step)], asked)
        if made:
            told.append(Call(tuple(made), name, tuple(given), several=True))
    return told, tapes


def _parted(plain: bool, run: list[Line]) -> Iterator[tuple[bool, list[Line]]]:
    """Some lines in parts, in an order in which they can be run, and whether each is to be a tape: of steps that follow one another
    those of a table read the same table and numbers alone, for anything else has a line of its own."""
    if not plain or len(run) < _LONG:
        yield False, run
        return
    tables: dict[Scope | None, list[Line]] = {None: []}
    for step in run:
        assert isinstance(step, Step)
        tables.setdefault(step.scope, []).append(step)
    for scope, steps in tables.items():
        yield scope is not None and len(steps) >= _LONG, steps


def _tape(steps: list[Step], asked: set[str]) -> tuple[list[str], list[str], Formula]:
    """The names that some steps read, those that they make for others, and the function between them."""
    own = {step.name for step in steps}
    read = dict.fromkeys(argument for step in steps for argument in step.arguments if argument not in own)
    given = [name for name in read if _NAME.fullmatch(name)]
    constants = [text for text in read if not _NAME.fullmatch(text)]
    number = {text: place for place, text in enumerate([*given, *constants, *(step.name for step in steps)])}
    made = [step.name for step in steps if step.name in asked]
    tape = Tape(
        len(given),
        [constant(text) for text in constants],
        [step.op for step in steps],
        [number[argument] for step in steps for argument in step.arguments],
        [number[name] for name in made],
    )
    return given, made, Formula(tape)


def constant(text: str) -> float | bool:
    """What a literal stands for."""
    if text in ("True", "False"):
        return text == "True"
    return float(text.strip("()").replace("np.", ""))
