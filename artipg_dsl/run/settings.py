"""Parameters that the user fixes: ``width=45cm``, ``handle=BarHandle``, ``pad.rows=5``, checked by their domain."""

from __future__ import annotations

import math
import re
from collections.abc import Iterable, Mapping
from numbers import Real
from typing import TYPE_CHECKING

import numpy as np

from ..diagnostics.suggest import any_of, did_you_mean
from ..errors import SettingError
from ..graph import expr as E
from ..graph.depend import draws_behind
from ..graph.substitution import substitute
from ..units import UNITS

if TYPE_CHECKING:
    from ..graph.program import Draw, Program

Value = float | int | str
Settings = dict[str, Value]

_NUMBER = re.compile(r"\s*([-+]?(?:\d+\.?\d*|\.\d+)(?:[eE][-+]?\d+)?)\s*(\S*)\s*")
_NOUNS = {"m": "a length", "rad": "an angle", "kg": "a mass", "kg/m3": "a density", "s": "a time", "m/s": "a speed"}
_EXAMPLES = {"m": "45cm", "rad": "30deg", "kg": "2kg", "kg/m3": "700kg/m3", "s": "2s", "m/s": "1m/s"}


def split_settings(texts: Iterable[str]) -> dict[str, str]:
    """``["width=45cm", ...]`` as a dictionary. Raises SettingError."""
    found: dict[str, str] = {}
    for text in texts:
        name, equals, value = (piece.strip() for piece in text.partition("="))
        if not equals or not name or not value:
            raise SettingError(f"`{text}` sets nothing", "write a name, an equals sign and a value: width=45cm")
        if found.get(name, value) != value:
            raise SettingError(f"`{name}` is set twice, to {found[name]} and to {value}")
        found[name] = value
    return found


def resolve_settings(program: Program, settings: Mapping[str, Value]) -> tuple[dict[int, float], Settings]:
    """Values by the index of their draw, and the settings in SI units as a manifest keeps them. Raises SettingError.

    Text carries its unit; a bare number is in metres, radians or whatever the SI unit is. A name that several
    alternatives share is set in each of them.
    """
    given: dict[int, float] = {}
    plain: Settings = {}
    for name, value in settings.items():
        draws = {k: d for k, d in enumerate(program.draws) if d.column.name == name}
        if not draws:
            raise unknown_name(program, name)
        refused: SettingError | None = None
        for k, draw in draws.items():
            try:
                number, told = read_setting(draw, value)
                _require_weight(draw, number)
                given[k], plain[name] = number, told
            except SettingError as error:
                refused = error
        if name not in plain:
            assert refused is not None
            raise refused
        for k in draws.keys() - given.keys():  # an alternative that cannot have the value: never chosen with it
            given[k] = math.nan
    for name in plain:
        _require_room(program, given, plain, name)
    return given, plain


def _require_room(program: Program, given: Mapping[int, float], settings: Settings, name: str) -> None:
    """Refuse a setting that no object can have, since others exclude what it belongs to."""
    fixed = {E.col(program.draws[k].column): E.const(value) for k, value in given.items() if not math.isnan(value)}
    blamed: list[str] = []
    for k, draw in enumerate(program.draws):
        if draw.column.name != name or math.isnan(given[k]):
            continue
        counts = [scope.count for scope in draw.column.scope.ancestors() if scope.count is not None]
        closed = next((c for c in counts if substitute(c, fixed).constant == 0.0), None)
        if closed is None:
            return
        blamed += [column.name for column in E.leaves(closed) if column.name in settings]
    others = ", ".join(f"{other}={settings[other]}" for other in sorted(set(blamed)))
    raise SettingError(
        f"no object has `{name}` with {others}" if others else f"no object has `{name}`",
        "leave out one of the settings",
    )


def read_setting(draw: Draw, value: Value, *, anywhere: bool = False) -> tuple[float, Value]:
    """The value of a draw as the runtime takes it, and as a manifest keeps it. Raises SettingError.

    ``anywhere``: outside its domain, too.
    """
    if isinstance(value, np.ndarray) and not value.ndim:
        value = value.item()
    if draw.kind == "choice":
        return _option(draw, value)
    number = (
        _plain(draw, value) if isinstance(value, Real) and not isinstance(value, bool) else _number(draw, str(value))
    )
    if draw.kind == "count" and number != int(number):
        raise SettingError(f"`{draw.column.name}` is a count: {value} is not a whole number")
    low = None if draw.low is None else draw.low.constant
    high = None if draw.high is None else draw.high.constant
    outside = (low is not None and number < low - 1e-9) or (high is not None and number > high + 1e-9)
    if outside and not anywhere:
        raise SettingError(
            f"`{draw.column.name}` cannot be {value}{'' if isinstance(value, str) else draw.unit}: it {_show_domain(draw)}",
            f"see {draw.where}; a program of your own may have another range (apgc new NAME --from CATEGORY)"
            if draw.where
            else None,
        )
    return float(number), int(number) if draw.kind == "count" else float(number)


def _option(draw: Draw, value: Value) -> tuple[float, Value]:
    name = str(value)
    if name not in draw.options:
        known = ", ".join(draw.options)
        raise SettingError(
            f"`{draw.column.name}` cannot be `{name}`: it is one of {known}", did_you_mean(name, draw.options)
        )
    return float(draw.options.index(name)), name


def _require_weight(draw: Draw, number: float) -> None:
    if draw.kind == "choice" and draw.weights[int(number)].constant == 0.0:
        raise SettingError(f"`{draw.column.name}` cannot be `{draw.options[int(number)]}`: its weight is 0")


def _plain(draw: Draw, value: Real) -> float:
    """A number of Python's or NumPy's. Raises SettingError for one that is not finite, or larger than those of 64 bits."""
    try:
        number = float(value)
    except OverflowError:
        raise SettingError(f"`{draw.column.name}`: the number is too large", _example(draw)) from None
    if not math.isfinite(number):
        raise SettingError(f"`{draw.column.name}` cannot be {number}: a number is needed", _example(draw))
    return number


def _number(draw: Draw, text: str) -> float:
    name, unit = draw.column.name, draw.unit
    if ".." in text:
        raise SettingError(
            f"`{name}` cannot be a range, {text}: a setting is one value", "a prior narrows ranges: see --prior"
        )
    match = _NUMBER.fullmatch(text)
    if match is None:
        raise SettingError(f"`{name}` cannot be `{text}`: a number is needed", _example(draw))
    number, written = float(match.group(1)), match.group(2)
    if written not in UNITS and written:
        fitting = [u for u, (_, dimension) in UNITS.items() if u and dimension == UNITS[unit or "%"][1]]
        raise SettingError(
            f"`{written}` in {name}={text} is not a unit",
            did_you_mean(written, (u for u in UNITS if u)) or f"write {', '.join(fitting)} after the number",
        )
    if not math.isfinite(number):
        raise SettingError(f"`{name}` cannot be {text}: the number is too large")
    wanted = UNITS[unit][1] if unit else UNITS["%"][1]
    factor, dimension = UNITS[written] if written else (1.0, UNITS["%"][1])
    if dimension == wanted or (number == 0 and not written):
        return number * factor
    noun = _NOUNS.get(unit, "a number without a unit" if not unit else f"in {unit}")
    if not written:
        raise SettingError(f"{name}={text} has no unit: `{name}` is {noun}", _example(draw))
    raise SettingError(f"{name}={text} has the wrong unit: `{name}` is {noun}", _example(draw))


def _example(draw: Draw) -> str:
    """A setting of a draw that is in its domain, if that is known."""
    known = [end.constant for end in (draw.low, draw.high) if end is not None and end.constant is not None]
    if not known:
        shown = _EXAMPLES.get(draw.unit, "3" if draw.kind == "count" else f"1{draw.unit}" if draw.unit else "0.5")
    else:
        middle = sum(known) / len(known)
        shown = show_value(float(int(middle) if draw.kind == "count" else middle), draw.unit)
    return f"for example {draw.column.name}={shown}"


def find_draws(program: Program, name: str) -> list[int]:
    """The draws of a name, which several alternatives may share, or the one of an address. Raises SettingError where there is none."""
    named = [k for k, draw in enumerate(program.draws) if draw.column.name == name]
    named = named or [k for k, draw in enumerate(program.draws) if draw.address == name]
    if not named:
        raise unknown_name(program, name)
    return named


def unknown_name(program: Program, name: str) -> SettingError:
    """What is wrong with a name that no draw has, and what to write instead."""
    names = list(dict.fromkeys(d.column.name for d in program.draws))
    inside = [n for n in names if n.startswith(name + ".")]
    settled = [e for c, e in program.definitions.items() if c.name == name or c.name.startswith(name + ".")]
    if settled and not inside:
        behind = list(dict.fromkeys(program.draws[k].column.name for k in draws_behind(program, settled)))
        shown = f"{any_of(behind[:6])}{' or others' * (len(behind) > 6)}, from which it follows; " if behind else ""
        hint = f"set {shown or 'what determines it; '}`apgc ledger` shows how"
        return SettingError(f"`{name}` follows from other values: it cannot be set", hint)
    if inside:
        shown = ", ".join(inside[:6]) + (", ..." if len(inside) > 6 else "")
        return SettingError(f"`{name}` is not one value", f"set one of {shown}")
    hint = did_you_mean(name, names) or (f"these can be set: {', '.join(names)}" if names else "it draws nothing")
    return SettingError(f"{program.name} draws no `{name}`", hint)


def _show_domain(draw: Draw) -> str:
    """``lies in 40cm .. 60cm``; an end that depends on other values is left out."""
    low, high = (
        None if e is None or e.constant is None else show_value(float(e.constant), draw.unit)
        for e in (draw.low, draw.high)
    )
    return f"is at least {low}" if high is None else f"is at most {high}" if low is None else f"lies in {low} .. {high}"


def show_value(value: float, unit: str) -> str:
    """A value in the unit that people use for its size."""
    if unit == "m":
        unit = "mm" if abs(value) < 0.01 else "cm" if abs(value) < 1 else "m"
    elif unit == "rad":
        unit = "deg"
    number = value / UNITS[unit][0] if unit else value
    return f"{number:.6g}{unit}"
