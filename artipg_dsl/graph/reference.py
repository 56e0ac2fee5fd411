"""References to links, and to nodes of the part tree: which row of which definition is meant, seen from a row.

A reference is a tuple of alternatives, of which the first that exists counts: a number is the definition's own row (that
belongs to the asking row); the records below say where else to look. Since alternatives of a part and branches of
``when`` may bring links of their own, one reference commonly holds several numbers of which one has a row there.
"""

from __future__ import annotations

from collections.abc import Iterator

from ..records import dataclass
from .expr import Expr, Scope


@dataclass(frozen=True, slots=True)
class Under:
    """``links``, but only where the guard ``scope`` has a row."""

    scope: Scope
    links: Reference


@dataclass(frozen=True, slots=True)
class Elsewhere:
    """What ``links`` are in an element of ``repeat``: the one of ``rank``, or the one before where that is None.

    Said in the rows of ``scope``, which ``rank`` is an expression of; ``links`` is a reference in the rows of ``repeat``.
    Does not exist where there is no such element.
    """

    scope: Scope
    repeat: Scope
    rank: Expr | None
    links: Reference


@dataclass(frozen=True, slots=True)
class Onward:
    """What goes on from element to element of the repeat ``scope``: where one of ``guards`` has a row, that of the element
    before; elsewhere ``links``."""

    scope: Scope
    guards: tuple[Scope, ...]
    links: Reference


Reference = tuple[int | Under | Elsewhere | Onward, ...]


def definitions_of(reference: Reference) -> tuple[int, ...]:
    """All definitions that a reference may come to, each once."""
    found: dict[int, None] = {}
    for item in reference:
        found.update(dict.fromkeys((item,) if isinstance(item, int) else definitions_of(item.links)))
    return tuple(found)


def ranks_of(reference: Reference) -> Iterator[tuple[Expr, Scope]]:
    """The ranks that a reference reads, each with the scope in whose rows."""
    for item in reference:
        if isinstance(item, int):
            continue
        if isinstance(item, Elsewhere) and item.rank is not None:
            yield item.rank, item.scope
        yield from ranks_of(item.links)
