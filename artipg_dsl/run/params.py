"""Objects given as values in a file: JSON objects of names and values, one a line or in a list."""

from __future__ import annotations

import json
import math
import sys
from collections.abc import Iterable, Mapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

from ..errors import SettingError, UsageError, UserError
from ..files import parse_json, read_text
from ..sampling.values import Values
from .settings import read_setting, unknown_name

if TYPE_CHECKING:
    from ..graph.program import Draw, Program

_FORM = 'write {"width": 0.5, "handle": "BarHandle"}, one object a line; annotations of samples do, too'


def read_params(values: str | Path | Iterable[Mapping[str, Any]]) -> tuple[tuple[Mapping[str, Any], ...], str]:
    """The objects in a file, or in dictionaries, as names and values, and what messages call them. Raises UserError."""
    if isinstance(values, str | Path):
        try:
            text = read_text(values)
        except FileNotFoundError:
            raise UserError(f"there is no file {values}", _FORM) from None
        return tuple(_parse_entries(text, str(values))), str(values)
    entries = [values] if isinstance(values, Mapping) else list(values) if isinstance(values, Iterable) else [values]
    if not all(isinstance(entry, Mapping) for entry in entries):
        raise UsageError(f"values is {values!r}", 'it is a file, or a dictionary for each object: [{"width": 0.52}]')
    found = tuple(dict(entry) for entry in entries)
    if not found:
        raise UsageError("no objects are given: values is empty")
    return found, "values"


def _parse_entries(text: str, name: str) -> list[Mapping[str, Any]]:
    """The objects that a text holds as plain data: a list, one object, or one a line. Raises UserError."""
    if _is_lines(text):
        lines = enumerate(text.split("\n"), 1)  # no other character ends a line: text may hold them
        found = [parse_json(line, name, _FORM, k) for k, line in lines if line.strip()]
    else:
        whole = parse_json(text, name, _FORM)
        found = whole if isinstance(whole, list) else [whole]
    if not found:
        raise UserError(f"{name} holds no objects", _FORM)
    odd = next((k for k, entry in enumerate(found) if not isinstance(entry, dict)), None)
    if odd is not None:
        raise UserError(f"{name}, object {odd}: {json.dumps(found[odd])[:40]} is no table of names and values", _FORM)
    return found


def _is_lines(text: str) -> bool:
    """Whether a text is an object with more behind it, or nothing at all. What is wrong with the first one is so of the whole."""
    text = text.lstrip()
    try:
        return not text or text[0] == "{" and text[json.JSONDecoder().raw_decode(text)[1] :].strip() != ""
    except (ValueError, RecursionError):
        return False


def read_values(found: Sequence[Mapping[str, Any]], program: Program, name: str) -> Values:
    """The values by draw, as the runtime takes them; text carries its unit, bare numbers are in SI units.

    Numbers may lie outside their domain: the runtime moves them to where they fit. What is no number at all (null, nan) is
    drawn. Raises UserError, SettingError.
    """
    said = [entry["drawn"] if isinstance(entry.get("drawn"), Mapping) else entry for entry in found]
    records = []
    for place, entry in enumerate(said):
        try:
            records.append(_read_record(entry, program))
        except UserError as error:
            raise type(error)(f"{name}, object {place}: {error.message}", error.hint) from None
    return Values(tuple(records), tuple({key: _make_finite(value) for key, value in entry.items()} for entry in said))


def _read_record(entry: Mapping[str, Any], program: Program) -> dict[int, tuple[float, ...]]:
    """The values of one object by draw. Raises UserError, SettingError."""
    record: dict[int, tuple[float, ...]] = {}
    for key, value in entry.items():
        draws = [(k, d) for k, d in enumerate(program.draws) if d.column.name == key]
        if not draws:
            raise unknown_name(program, key)
        items = value if isinstance(value, list) else [value]
        if not items:
            raise UserError(f"`{key}` is an empty list", "leave it out to have it drawn")
        taken, refused = [False] * len(items), None
        for k, draw in draws:  # alternatives that share the name may differ in their options and kinds
            numbers = []
            for place, item in enumerate(items):
                try:
                    numbers.append(_read_number(draw, item))
                    taken[place] = True
                except SettingError as error:
                    numbers.append(math.nan)
                    refused = error
            record[k] = tuple(numbers)
        if refused is not None and not all(taken):
            raise refused
    return record


def _read_number(draw: Draw, item: Any) -> float:
    """A value as the runtime takes it; nan where there is none. Raises SettingError."""
    item = _make_finite(item)
    return math.nan if item is None else read_setting(draw, item, anywhere=True)[0]


def _make_finite(value: Any) -> Any:
    """A value as JSON knows it: null for what is no number, the largest one for what is without end."""
    if isinstance(value, list):
        return [_make_finite(item) for item in value]
    if isinstance(value, int) and abs(value) > sys.float_info.max:
        return sys.float_info.max if value > 0 else -sys.float_info.max
    if not isinstance(value, float) or math.isfinite(value):
        return value
    return None if math.isnan(value) else math.copysign(sys.float_info.max, value)
