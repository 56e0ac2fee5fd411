"""Trees as data, for files.

A tree is a list of rows, children before their parents: the number of the node's class, where it starts and ends, and its
fields. A field that holds nodes holds the numbers of their rows. Whoever makes a tree of rows is told where they are none: every
field holds what its annotation declares, and every place lies within the text.
"""

from __future__ import annotations

from dataclasses import fields
from functools import cache
from types import NoneType, UnionType
from typing import Any, TypeVar, Union, get_args, get_origin, get_type_hints

from ..source import Source, Span
from . import ast

PLAIN, NODE, SPAN = range(3)  # what a field holds
Field = tuple[str, int, bool, tuple[type, ...], bool, Any]  # see ``_shape``
Tree = TypeVar("Tree", bound=ast.Node)

KINDS: tuple[type[ast.Node], ...] = tuple(
    held for held in vars(ast).values() if isinstance(held, type) and issubclass(held, ast.Node)
)

_SIMPLE = frozenset((str, NoneType, bool, int, float))  # what is its own data
_NUMBERS = {kind: number for number, kind in enumerate(KINDS)}


class _Spoilt(ValueError):
    """Data that is no tree of the text."""


def to_data(tree: ast.Node) -> list[list[Any]]:
    """The rows of a tree, or of a piece of one."""
    rows: list[list[Any]] = []
    numbers: dict[int, int] = {}  # a node may stand in two places, as the ends of a range of one value do

    def data(value: Any) -> Any:
        kind: Any = type(value)
        if kind in _NUMBERS:
            number = numbers.get(id(value))
            if number is None:
                row = [_NUMBERS[kind], value.span.start, value.span.end]
                held = [getattr(value, name) for name in _names(kind)]
                row += [one if type(one) in _SIMPLE else data(one) for one in held]
                number = numbers[id(value)] = len(rows)
                rows.append(row)
            return number
        if kind is tuple:
            return [data(item) for item in value]
        return [value.start, value.end] if kind is Span else value

    data(tree)
    return rows


def from_data(rows: Any, source: Source, kind: type[Tree]) -> Tree:
    """The tree that ``to_data`` made rows of, its places in ``source``. Raises Spoilt, TypeError, ValueError or IndexError."""
    most = len(source.text)
    nodes: list[ast.Node] = []

    def span(start: Any, end: Any) -> Span:
        if type(start) is not int or type(end) is not int or not 0 <= start <= end <= most:
            raise _Spoilt
        return Span(source, start, end)

    def node(number: Any) -> ast.Node:
        if type(number) is not int or number < 0:
            raise _Spoilt
        return nodes[number]  # those before it alone

    for number, start, end, *held in rows:
        made = KINDS[number]
        found: dict[str, Any] = {"span": span(start, end)}
        for (name, what, several, allowed, optional, inner), value in zip(_shape(made), held, strict=True):
            if value is None:
                if not optional:
                    raise _Spoilt
            elif what == NODE:
                if made is ast.Clause:  # what it holds depends on where it stands
                    value = tuple(map(node, value)) if isinstance(value, list) else node(value)
                elif several:
                    value = tuple(map(node, value))
                    if not all(isinstance(item, allowed) for item in value):
                        raise _Spoilt
                    if inner is not None and not all(map(inner, value)):
                        raise _Spoilt
                else:
                    value = node(value)
                    if not isinstance(value, allowed) or inner is not None and not inner(value):
                        raise _Spoilt
            elif what == SPAN:
                value = tuple(span(*pair) for pair in value) if several else span(*value)
            elif several:
                value = tuple(value)
                if not all(type(item) in allowed for item in value):
                    raise _Spoilt
            elif type(value) not in allowed:
                raise _Spoilt
            found[name] = value
        nodes.append(made(**found))
    if not nodes or not isinstance(nodes[-1], kind):
        raise _Spoilt
    return nodes[-1]


_shapes: dict[type[ast.Node], tuple[Field, ...]] = {
    ast.Clause: (("word", PLAIN, False, (str,), False, None), ("value", NODE, False, (), True, None))
}


def _shape(kind: type[ast.Node]) -> tuple[Field, ...]:
    """Of each field but the span: its name, what it holds, whether several, the classes of one, whether it may be missing, and a
    test of what stands in a clause."""
    if kind not in _shapes:
        hints = get_type_hints(kind)
        _shapes[kind] = tuple(_field(field.name, hints[field.name]) for field in fields(kind) if field.name != "span")
    return _shapes[kind]


_inner: dict[type[ast.Node], tuple[str, ...]] = {}


def inner(node: ast.Node) -> tuple[str, ...]:
    """The fields of a node in which nodes stand."""
    kind = type(node)
    found = _inner.get(kind)
    if found is None:
        found = _inner[kind] = tuple(name for name, what, *_ in _shape(kind) if what == NODE)
    return found


@cache
def _names(kind: type[ast.Node]) -> tuple[str, ...]:
    return tuple(name for name, *_ in _shape(kind))


def _field(name: str, hint: Any) -> Field:
    options = _options(hint)
    given = [option for option in options if option is not NoneType]
    several = get_origin(given[0]) is tuple
    if several:
        given = list(_options(get_args(given[0])[0]))
    classes = tuple(get_origin(option) or option for option in given)
    optional = NoneType in options
    if classes == (Span,):
        return name, SPAN, several, classes, optional, None
    if all(issubclass(option, ast.Node) for option in classes):
        clause = get_args(given[0]) if classes == (ast.Clause,) else ()
        return name, NODE, several, classes, optional, _clause_test(clause[0]) if clause else None
    return name, PLAIN, several, classes, optional, None


def _options(hint: Any) -> tuple[Any, ...]:
    return get_args(hint) if get_origin(hint) in (Union, UnionType) else (hint,)


def _clause_test(hint: Any) -> Any:
    """Whether a clause holds what its field declares."""
    if hint is Any:
        return None
    if hint is NoneType or hint is None:
        return lambda clause: clause.value is None
    if get_origin(hint) is tuple:
        inner, *more = get_args(hint)
        length = None if more[-1:] == [Ellipsis] else 1 + len(more)
        return lambda clause: (
            isinstance(clause.value, tuple)
            and length in (None, len(clause.value))
            and all(isinstance(item, inner) for item in clause.value)
        )
    return lambda clause: isinstance(clause.value, hint)
