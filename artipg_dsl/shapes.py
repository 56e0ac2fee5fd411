"""Whether data from a file has the structure that annotations state; if not, where, what is there and what was expected.

Annotations are the plain types, ``tuple[float, float]``, ``list[X]``, ``dict[str, X]``, unions, ``Literal``, dataclasses,
``TypedDict`` and ``Annotated[X, Rule(...)]``. A whole number does for a number; what is not finite is none.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass, fields, is_dataclass
from functools import cache
from types import NoneType, UnionType
from typing import (
    Annotated,
    Any,
    Literal,
    NotRequired,
    Required,
    Union,
    get_args,
    get_origin,
    get_type_hints,
    is_typeddict,
)

from .diagnostics.suggest import did_you_mean

_SHOWN = 40  # characters of a value that messages show


@dataclass(frozen=True, slots=True)
class Rule:
    """What a type alone does not say: in words, and as a test."""

    words: str
    holds: Callable[[Any], bool]


class Misfit(ValueError):
    """``at`` is the place within the data, such as ``identity.numbers[0]``; ``expected`` and ``found`` are words."""

    def __init__(self, at: str, expected: str, found: str):
        super().__init__(f"{at + ': ' if at else ''}{found} where {expected} is expected")
        self.at, self.expected, self.found = at, expected, found


_WORDS: dict[Any, str] = {
    bool: "true or false",
    int: "a whole number",
    float: "a number",
    str: "text",
    NoneType: "nothing",
    list: "a list",
    tuple: "a list",
    dict: "an object",
}
NAMED: dict[type, str] = {}
"""Words for classes of one's own, which are taken as they are."""


def fit(value: Any, kind: Any, at: str = "") -> None:
    """Raises Misfit where ``value`` is not of the structure ``kind``."""
    origin = get_origin(kind)
    if kind is Any:
        return
    if origin is Annotated:
        plain, *notes = get_args(kind)
        rules = [note for note in notes if isinstance(note, Rule)]
        if rules and not _fits(value, plain):
            if _within(value, plain):
                fit(value, plain, at)
            raise Misfit(at, rules[0].words, show_value(value))
        fit(value, plain, at)
        for rule in rules:
            if not rule.holds(value):
                raise Misfit(at, rule.words, show_value(value))
    elif origin in (Required, NotRequired):
        fit(value, get_args(kind)[0], at)
    elif origin in (Union, UnionType):
        _one_of(value, get_args(kind), at)
    elif origin is Literal:
        if not any(value == option and type(value) is type(option) for option in get_args(kind)):
            raise Misfit(at, _describe_shape(kind), show_value(value))
    elif origin in (list, tuple, dict):
        _container(value, origin, get_args(kind), at)
    elif is_typeddict(kind):
        _keys(value, kind, at)
    elif kind is None or kind is NoneType:
        if value is not None:
            raise Misfit(at, "nothing", show_value(value))
    elif kind is float:
        if isinstance(value, bool) or not isinstance(value, int | float):
            raise Misfit(at, "a number", show_value(value))
        if not abs(value) <= 1e300:
            raise Misfit(at, "a finite number", show_value(value))
    elif not isinstance(value, kind) or kind is int and isinstance(value, bool):
        raise Misfit(at, _describe_shape(kind), show_value(value))
    elif kind is str and not _text(value):
        raise Misfit(at, "text", show_value(value))
    elif is_dataclass(value) and type(value) not in NAMED:
        for name, inner in hints(value.__class__).items():
            fit(getattr(value, name), inner, f"{at}.{name}" if at else name)


def _fits(value: Any, kind: Any) -> bool:
    try:
        fit(value, kind)
    except Misfit:
        return False
    return True


def _text(value: str) -> bool:
    """Whether a text can be written: half of a surrogate pair is none."""
    try:
        return value.isascii() or bool(value.encode())
    except UnicodeEncodeError:
        return False


def _within(value: Any, kind: Any) -> bool:
    """Whether a value is the right container, so that what is wrong lies inside."""
    return isinstance(value, list | tuple | dict) and isinstance(value, get_origin(kind) or kind)


def _one_of(value: Any, options: tuple[Any, ...], at: str) -> None:
    inside: Misfit | None = None
    for option in options:
        try:
            return fit(value, option, at)
        except Misfit as wrong:
            if wrong.at != at:
                inside = wrong
    raise inside or Misfit(
        at, " or ".join(dict.fromkeys(_describe_shape(option) for option in options)), show_value(value)
    )


def _container(value: Any, origin: Any, inner: tuple[Any, ...], at: str) -> None:
    if not isinstance(value, origin):
        raise Misfit(at, _describe_shape(origin), show_value(value))
    if origin is dict:
        for key, item in value.items():
            fit(key, inner[0], at)
            fit(item, inner[1], f"{at}.{key}" if at else str(key))
        return
    if origin is tuple and inner[-1:] != (Ellipsis,):
        if len(value) != len(inner):
            raise Misfit(at, f"a list of {len(inner)}", f"a list of {len(value)}")
        for place, (item, one) in enumerate(zip(value, inner, strict=True)):
            fit(item, one, f"{at}[{place}]")
        return
    for place, item in enumerate(value):
        fit(item, inner[0], f"{at}[{place}]")


def _keys(value: Any, kind: Any, at: str) -> None:
    if not isinstance(value, dict):
        raise Misfit(at, "an object", show_value(value))
    known = hints(kind)
    for name, inner in known.items():
        place = f"{at}.{name}" if at else name
        if name in value:
            fit(value[name], inner, place)
        elif get_origin(inner) is not NotRequired:
            raise Misfit(place, _describe_shape(inner), "nothing")
    for name in value:
        if name not in known:
            close = did_you_mean(str(name), known)
            raise Misfit(
                at, "no such key" if close is None else f"another key ({close})", f"the key {show_value(name)}"
            )


@cache
def hints(kind: Any) -> dict[str, Any]:
    """The fields of a record with their annotations."""
    found = get_type_hints(kind, include_extras=True)
    return {field.name: found[field.name] for field in fields(kind)} if is_dataclass(kind) else found


def _describe_shape(kind: Any) -> str:
    """What an annotation asks for."""
    origin = get_origin(kind)
    if origin is Annotated:
        rules = [rule for rule in get_args(kind)[1:] if isinstance(rule, Rule)]
        return rules[0].words if rules else _describe_shape(get_args(kind)[0])
    if origin in (Required, NotRequired):
        return _describe_shape(get_args(kind)[0])
    if origin is Literal:
        options = [str(option) for option in get_args(kind)]
        return options[0] if len(options) == 1 else f"one of {', '.join(options)}"
    if origin in (Union, UnionType):
        return " or ".join(_describe_shape(option) for option in get_args(kind))
    if is_typeddict(kind):
        return "an object"
    return str(NAMED.get(kind) or _WORDS.get(origin or kind) or getattr(kind, "__name__", kind))


def show_value(value: Any) -> str:
    """A value as messages show it."""
    if value is None or isinstance(value, bool):
        return {None: "nothing", True: "true", False: "false"}[value]
    if isinstance(value, float) and not math.isfinite(value):
        return repr(value)
    if isinstance(value, list | tuple | dict) and not value:
        return "an empty object" if isinstance(value, dict) else "an empty list"
    if isinstance(value, list | tuple):
        return "a list"
    if isinstance(value, dict):
        return "an object"
    if isinstance(value, str | int | float):
        text = ascii(value)
        return text if len(text) <= _SHOWN else text[: _SHOWN - 3] + "..."
    return NAMED.get(type(value)) or f"a {type(value).__name__}"
