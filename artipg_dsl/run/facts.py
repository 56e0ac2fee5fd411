"""Facts: what a person knows of real objects, and the program of the objects of which that is true.

{"door_03": {"leaves": 2, "grip": "LeverHandle | DoorKnob", "width": "80cm .. 1m", "column.rows": [3, null, 2]}}
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

from ..arguments import to_plain
from ..diagnostics.suggest import any_of, did_you_mean
from ..errors import SettingError, UsageError, UserError
from ..files import read_json
from ..graph import expr as E
from ..graph.reweigh import NothingLeft, exclude, keep_options, narrow, reweigh
from ..shapes import show_value
from .prior import Prior, require_objects
from .settings import find_draws, read_setting

if TYPE_CHECKING:
    from ..graph.expr import Expr, Scope
    from ..graph.program import Draw, Program

Facts = Mapping[str, Any]

_FORM = 'write {"door_03": {"leaves": 2, "grip": "LeverHandle"}}'
_SHOWN = 4  # names of objects in a message


def read_facts(
    settings: Facts, given: str | Path | Mapping[str, Any] | None, program: Program, names: Sequence[str]
) -> dict[str, Facts]:
    """What is known of objects, by their ``names``: ``settings`` of all, and of each what a file says, or Python. Raises UserError,
    SettingError."""
    if not isinstance(settings, Mapping):
        raise UsageError(f"set is {settings!r}", 'it maps names to values: {"leaves": 2}')
    if not isinstance(given, str | Path | Mapping | None):
        raise UsageError(f"facts is {given!r}", f"{_FORM}, or name a file of it")
    called, found = ("facts", given) if isinstance(given, Mapping) else _read(given)
    if not isinstance(found, Mapping):
        raise UserError(f"{called} is {show_value(found)}, and names no objects", _FORM)
    common, told = to_plain(settings), {}
    if common:
        apply_facts(program, common, "what is set")
    for name, own in to_plain(found).items():
        if name not in names:
            known = any_of(names[:_SHOWN], "and") + (", ..." if names[_SHOWN:] else "")
            hint = did_you_mean(name, names) or f"those to be fitted are {known}"
            raise UserError(f"{called}: no object is called {name}", hint)
        if not isinstance(own, Mapping):
            raise UserError(f"{called}: {name} is {show_value(own)}, and no facts", _FORM)
        told[name] = {**common, **own}
        apply_facts(program, told[name], f"{called}: {name}")
    return {name: told.get(name, common) for name in names if name in told or common}


def _read(path: str | Path | None) -> tuple[str, Any]:
    if path is None:
        return "", {}
    try:
        return str(path), read_json(path, _FORM)
    except FileNotFoundError:
        raise UserError(f"there is no file {path}", _FORM) from None


def apply_facts(program: Program, facts: Facts, said: str) -> Program:
    """The program of the objects of which facts are true; ``said``: where they are said. Raises SettingError.

    A name that several alternatives share speaks of each of them that can have the value; the others are excluded.
    """
    changed: dict[int, Draw] = {}
    for name, entry in facts.items():
        held: dict[int, Draw] = {}
        refused: list[SettingError] = []
        try:
            named = find_draws(program, name)
        except SettingError as error:
            raise SettingError(f"{said}: {error.message}", error.hint) from None
        for k in named:
            try:
                held |= _held(program, {**changed, **held}, k, entry)
            except NothingLeft as error:
                refused.append(SettingError(f"{said}: `{name}`: {error}"))
            except SettingError as error:
                refused.append(SettingError(f"{said}: {error.message}", error.hint))
        if len(refused) == len(named):
            raise refused[-1]
        changed |= {k: exclude(program.draws[k]) for k in named} | held
    made = reweigh(program, changed)
    try:
        require_objects(made, Prior(facts, said))
    except SettingError as error:
        raise SettingError(error.message, "leave one of them out") from None
    return made


def _held(program: Program, changed: Mapping[int, Draw], number: int, entry: Any) -> dict[int, Draw]:
    """A draw with what is said of it, and the counts of elements that lists tell. Raises SettingError, NothingLeft."""
    made = {number: changed.get(number, program.draws[number])}
    repeats = [one for one in made[number].column.scope.ancestors() if one.kind == "repeat"]
    said = [(E.TRUE, entry)]
    for repeat in reversed(repeats):
        for where, one in said:
            if isinstance(one, list | tuple):
                made |= _counted(program, {**changed, **made}, number, repeat, len(one), where)
        said = [each for where, one in said for each in _each(repeat, one, where)]
    for where, one in said:
        if isinstance(one, list | tuple):
            deep = f"has {'a list in a list' if repeats[1:] else 'a list'} at most" if repeats else "has one value"
            raise SettingError(
                f"`{made[number].column.name}` is {show_value(entry)}, but {deep}",
                'write "A | B" for one of several options, "2 .. 4" for a range',
            )
        if one is not None:
            draw = made[number]
            choice = draw.kind == "choice"
            made[number] = (
                keep_options(draw, _options(draw, one), where) if choice else narrow(draw, *_range(draw, one), where)
            )
    return made


def _each(repeat: Scope, entry: Any, where: Expr) -> list[tuple[Expr, Any]]:
    """What is said of each element of a repeat, and where it holds: a list has an entry for each, else it is said of all."""
    if not isinstance(entry, list | tuple):
        return [(where, entry)]
    rank = E.rank(repeat)
    return [(E.both(where, E.call("eq", rank, E.const(float(k)))), one) for k, one in enumerate(entry)]


def _counted(
    program: Program, draws: Mapping[int, Draw], number: int, repeat: Scope, many: int, where: Expr
) -> dict[int, Draw]:
    """A repeat with so many elements. Raises SettingError, NothingLeft."""
    assert repeat.count is not None
    for k, draw in enumerate(program.draws):
        if E.col(draw.column) is repeat.count:
            value, _ = read_setting(draw, many)
            try:
                return {k: narrow(draws.get(k, draw), value, value, where)}
            except NothingLeft:
                raise SettingError(
                    f"`{program.draws[number].column.name}` has {many} elements, but `{draw.column.name}` is told otherwise"
                ) from None
    others = E.negate(E.call("eq", repeat.count, E.const(float(many))))
    return {number: exclude(draws.get(number, program.draws[number]), E.both(where, others))}


def _options(draw: Draw, entry: Any) -> tuple[int, ...]:
    """``A | B``."""
    return tuple(dict.fromkeys(int(read_setting(draw, name.strip())[0]) for name in str(entry).split("|")))


def _range(draw: Draw, entry: Any) -> tuple[float, float]:
    """A value, or ``45cm .. 50cm``, which may reach beyond the domain."""
    low, dots, high = entry.partition("..") if isinstance(entry, str) else (entry, "", "")
    if not dots:
        value, _ = read_setting(draw, entry)
        return value, value
    first, last = (read_setting(draw, end.strip(), anywhere=True)[0] for end in (low, high))
    if first > last:
        raise SettingError(f"`{draw.column.name}`: the range {entry} is empty", "its low end comes first")
    return first, last
