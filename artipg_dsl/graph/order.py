"""What expressions are made of, in order: without a call within a call, so that a chain of a thousand parts is no depth."""

from __future__ import annotations

from collections.abc import Callable, Container, Iterable, Iterator

from .expr import Expr


def bottom_up(root: Expr, inner: Callable[[Expr], Iterable[Expr]], known: Container[Expr]) -> Iterator[Expr]:
    """The nodes that ``root`` is made of, and it last: each behind those ``inner`` to it. What is ``known`` is left out with all
    that is below it; who takes the nodes may add them to that. A circle of nodes is broken where it closes."""
    path = [(root, iter(inner(root)))]
    begun = {root}
    while path:
        node, rest = path[-1]
        for below in rest:
            if below not in known and below not in begun:
                begun.add(below)
                path.append((below, iter(inner(below))))
                break
        else:
            path.pop()
            yield node
