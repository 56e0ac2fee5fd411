"""Lowered primitives as entries of the cache: what lathes, sweeps and lofts are made of takes most of the time that lowering takes.

An entry follows from the texts of the module that declares the primitive and of all that it uses, the name it is given, and the shape of the
paths that are handed in. It holds data alone, which is verified when it is read.
"""

from __future__ import annotations

from collections.abc import Mapping
from functools import lru_cache
from typing import Any

from ... import cache
from ...graph.expr import Expr
from ...graph.interval import Interval
from ...graph.primitive import Primitive
from ...graph.reading import TextError, from_words
from ...graph.writing import primitive_digest, to_words
from ...semantics.symbols import ModuleScope, Symbol
from ...shapes import Misfit, fit
from ..values.handed import Handed
from ..values.kinds import Frame, Line, Value
from .lowered import Condition, Lowered

_Triple = tuple[Expr, Expr, Expr]
_Pair = tuple[Expr, Expr]


def entry_of(symbol: Symbol, title: str, paths: Mapping[str, Handed], tested: Mapping[str, Interval]) -> str | None:
    """The name of the entry of a primitive; None where nothing is kept."""
    if cache.folder() is None:
        return None
    shapes = to_words(
        (
            tuple(
                (name, path.names, tuple((s.word, s.numbers) for s in path.steps), path.tests)
                for name, path in paths.items()
            ),
            tuple((name, *ends) for name, ends in tested.items()),
        )
    )
    return cache.key("solid", _texts(symbol.module), symbol.name, title, shapes)


@lru_cache(maxsize=64)
def _texts(module: ModuleScope) -> str:
    """What tells the texts of a module and of all that it uses from any others."""
    return cache.digest([text for used in module.used() for text in (used.source.name, used.source.text)])


def recall(entry: str) -> Lowered | None:
    """The primitive of an entry; None where there is none, or it is damaged."""
    found = cache.read(entry)
    if found is None:
        return None
    try:
        return _read(from_words(found.decode("utf-8")))
    except (TextError, Misfit, ValueError, TypeError, RecursionError):
        cache.drop(entry)
        return None


def keep(entry: str, lowered: Lowered) -> None:
    """Keep a primitive, unless a port of it is of a kind that is not written."""
    ports = [(name, *told) for name, value in lowered.ports.items() if (told := _told(value)) is not None]
    if len(ports) < len(lowered.ports):
        return
    conditions = tuple((c.holds, c.sides, c.message, c.text, c.bend) for c in lowered.conditions)
    lowered.digest = primitive_digest(lowered.primitive)
    flags = lowered.centred_size, lowered.possible
    held = lowered.primitive, lowered.digest, lowered.names, tuple(ports), conditions, *flags
    cache.write(entry, to_words(held).encode("utf-8"))


def _told(port: Value) -> tuple[Any, ...] | None:
    if type(port) is Frame and not port.on:
        return "frame", port.origin, port.rotation, port.face
    if type(port) is Line and not port.on:
        return "line", port.point, port.direction, port.to
    return None


def _read(held: Any) -> Lowered:
    fit(held, tuple[Primitive, str, tuple[str, ...], tuple[Any, ...], tuple[Any, ...], bool, bool])
    primitive, digest, names, ports, conditions, centred, possible = held
    asked = tuple[Expr, _Pair | None, str, str, _Pair | None]
    for condition in conditions:
        fit(condition, asked)
    made = [Condition(holds, sides, message, text, bend) for holds, sides, message, text, bend in conditions]
    offered = {name: _port(*told) for name, *told in ports}
    return Lowered(primitive, names, offered, made, centred, possible, digest=digest)


def _port(kind: str, *told: Any) -> Value:
    if kind == "frame":
        fit(told, tuple[_Triple, tuple[_Triple, _Triple, _Triple], bool])
        origin, rotation, face = told
        return Frame(origin, rotation, face=face)
    fit((kind, *told), tuple[str, _Triple, _Triple, _Triple | None])
    if kind != "line":
        raise ValueError(kind)
    return Line(*told)
