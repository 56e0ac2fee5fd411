"""Whether data from a file has the structure that annotations state; if not, where, what is there and what was expected.

Annotations are the plain types, ``tuple[float, float]``, ``list[X]``, ``dict[str, X]``, unions, ``Literal``, dataclasses,
``TypedDict`` and ``Annotated[X, Rule(...)]``. A whole number does for a number; what is not finite is none.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import fields, is_dataclass
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
from .records import dataclass

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


class _Wrong(Exception):
    """A misfit on its way out of the data: ``steps``, such as ``.name`` and ``[2]``, lead to it, the innermost first. Only where something
    is wrong is a place put together: to write the places of data that is right takes longer than to look at it."""

    def __init__(self, expected: str, found: str):
        super().__init__()
        self.expected, self.found = expected, found
        self.steps: list[str] = []

    def at(self, place: str) -> str:
        inner = "".join(reversed(self.steps))
        return place + inner if place else inner.removeprefix(".")


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


Fitter = Callable[[Any], None]
"""Raises _Wrong where a value is not of a structure."""


def fit(value: Any, kind: Any, at: str = "") -> None:
    """Raises Misfit where ``value`` is not of the structure ``kind``."""
    try:
        _fitter(kind)(value)
    except _Wrong as wrong:
        raise Misfit(wrong.at(at), wrong.expected, wrong.found) from None


def _fitter(kind: Any) -> Fitter:
    """What tells whether values are of a structure: an annotation takes longer to read than most values."""
    origin = get_origin(kind)
    if kind is Any:
        return lambda value: None
    if origin is Annotated:
        return _ruled(*get_args(kind))
    if origin in (Required, NotRequired):
        return _fitter(get_args(kind)[0])
    if origin in (Union, UnionType):
        return _one_of(get_args(kind))
    if origin is Literal:
        return _literal(kind)
    if origin is dict:
        return _mapping(*map(_fitter, get_args(kind)))
    if origin in (list, tuple):
        inner = get_args(kind)
        one = origin is list or inner[-1:] == (Ellipsis,)
        return _sequence(origin, _fitter(inner[0])) if one else _row(list(map(_fitter, inner)))
    if is_typeddict(kind):
        return lambda value: _keys(value, kind)
    if kind is None or kind is NoneType:
        return _nothing
    return _number if kind is float else _plain(kind)


def _nothing(value: Any) -> None:
    if value is not None:
        raise _Wrong("nothing", show_value(value))


def _number(value: Any) -> None:
    if isinstance(value, bool) or not isinstance(value, int | float):
        raise _Wrong("a number", show_value(value))
    if not abs(value) <= 1e300:
        raise _Wrong("a finite number", show_value(value))


def _plain(kind: Any) -> Fitter:
    whole, text = kind is int, kind is str

    def fitter(value: Any) -> None:
        if not isinstance(value, kind) or whole and isinstance(value, bool):
            raise _Wrong(_describe_shape(kind), show_value(value))
        if text:
            if not _text(value):
                raise _Wrong("text", show_value(value))
            return
        for name, inner in _record(value.__class__):
            try:
                inner(getattr(value, name))
            except _Wrong as wrong:
                wrong.steps.append(f".{name}")
                raise

    return fitter


@cache
def _record(kind: type) -> tuple[tuple[str, Fitter], ...]:
    """The fields of a record, and what their values have to be; nothing for any other class."""
    if not is_dataclass(kind) or kind in NAMED:
        return ()
    return tuple([(name, _fitter(inner)) for name, inner in hints(kind).items()])


def _literal(kind: Any) -> Fitter:
    options = get_args(kind)

    def fitter(value: Any) -> None:
        if not any([value == option and type(value) is type(option) for option in options]):
            raise _Wrong(_describe_shape(kind), show_value(value))

    return fitter


def _ruled(plain: Any, *notes: Any) -> Fitter:
    inner, rules = _fitter(plain), [note for note in notes if isinstance(note, Rule)]

    def fitter(value: Any) -> None:
        try:
            inner(value)
        except _Wrong:
            if rules and not _within(value, plain):
                raise _Wrong(rules[0].words, show_value(value)) from None
            raise
        for rule in rules:
            if not rule.holds(value):
                raise _Wrong(rule.words, show_value(value))

    return fitter


def _text(value: str) -> bool:
    """Whether a text can be written: half of a surrogate pair is none."""
    try:
        return value.isascii() or bool(value.encode())
    except UnicodeEncodeError:
        return False


def _within(value: Any, kind: Any) -> bool:
    """Whether a value is the right container, so that what is wrong lies inside."""
    return isinstance(value, list | tuple | dict) and isinstance(value, get_origin(kind) or kind)


def _one_of(options: tuple[Any, ...]) -> Fitter:
    fitters = list(map(_fitter, options))
    likely = dict(zip(options, fitters, strict=True))  # what a value of just this class is first taken for

    def fitter(value: Any) -> None:
        inside: _Wrong | None = None
        first = likely.get(type(value))
        for one in fitters if first is None else (first, *fitters):
            try:
                one(value)
                return
            except _Wrong as wrong:
                if wrong.steps:
                    inside = wrong
        raise inside or _Wrong(" or ".join(dict.fromkeys(map(_describe_shape, options))), show_value(value))

    return fitter


def _mapping(key: Fitter, item: Fitter) -> Fitter:
    def fitter(value: Any) -> None:
        if not isinstance(value, dict):
            raise _Wrong(_describe_shape(dict), show_value(value))
        for name, one in value.items():
            key(name)
            try:
                item(one)
            except _Wrong as wrong:
                wrong.steps.append(f".{name}")
                raise

    return fitter


def _sequence(kind: Any, inner: Fitter) -> Fitter:
    def fitter(value: Any) -> None:
        if not isinstance(value, kind):
            raise _Wrong(_describe_shape(kind), show_value(value))
        for place, one in enumerate(value):
            try:
                inner(one)
            except _Wrong as wrong:
                wrong.steps.append(f"[{place}]")
                raise

    return fitter


def _row(inner: list[Fitter]) -> Fitter:
    def fitter(value: Any) -> None:
        if not isinstance(value, tuple):
            raise _Wrong(_describe_shape(tuple), show_value(value))
        if len(value) != len(inner):
            raise _Wrong(f"a list of {len(inner)}", f"a list of {len(value)}")
        for place, (one, of) in enumerate(zip(value, inner, strict=True)):
            try:
                of(one)
            except _Wrong as wrong:
                wrong.steps.append(f"[{place}]")
                raise

    return fitter


def _keys(value: Any, kind: Any) -> None:
    if not isinstance(value, dict):
        raise _Wrong("an object", show_value(value))
    known = hints(kind)
    for name, inner in known.items():
        try:
            if name in value:
                _fitter(inner)(value[name])
            elif get_origin(inner) is not NotRequired:
                raise _Wrong(_describe_shape(inner), "nothing")
        except _Wrong as wrong:
            wrong.steps.append(f".{name}")
            raise
    for name in value:
        if name not in known:
            close = did_you_mean(str(name), known)
            raise _Wrong("no such key" if close is None else f"another key ({close})", f"the key {show_value(name)}")


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
