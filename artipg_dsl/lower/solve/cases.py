"""Which combinations of guards can occur: the cases under which a block of equations is matched."""

from __future__ import annotations

import math
from collections.abc import Iterable, Mapping, Sequence
from itertools import product

from ...graph import expr as E
from ...graph.expr import Column, Expr
from ...graph.program import Draw

_MOST_CASES = 64
_MOST_TRIALS = 1 << 14
_COMPARISONS = {"eq": lambda a, b: a == b, "le": lambda a, b: a <= b, "lt": lambda a, b: a < b}


class TooManyCases(Exception):
    """More combinations of guards than are worth matching one by one."""


def _atoms(guards: Iterable[Expr]) -> list[Expr]:
    """The conditions out of which ``and``, ``or`` and ``not`` make the guards, in the order of first use."""
    found: dict[Expr, None] = {}
    stack = list(reversed(list(guards)))
    while stack:
        node = stack.pop()
        if node.op in ("and", "or", "not"):
            stack.extend(reversed(node.args))
        elif node.op != "const":
            found[node] = None
    return list(found)


def subject(atom: Expr) -> tuple[Expr, float, bool] | None:
    """``x op constant`` as (x, the constant, whether x stands on the left); None for other conditions."""
    if atom.op not in _COMPARISONS:
        return None
    a, b = atom.args
    if b.constant is not None and a.constant is None:
        return a, float(b.constant), True
    if a.constant is not None and b.constant is None:
        return b, float(a.constant), False
    return None


def trials(node: Expr, constants: Sequence[float], draws: Mapping[Column, Draw]) -> list[float]:
    """Values of an expression that tell its comparisons with the constants apart."""
    if node.op == "col" and (draw := draws.get(node.value)) is not None and draw.kind == "choice":
        return [float(k) for k in range(len(draw.options))]
    marks = sorted(set(constants))
    draw = draws.get(node.value) if node.op == "col" else None
    if node.op == "rank" or draw is not None and draw.kind == "count":
        low = 0.0 if draw is None or draw.low is None else draw.low.constant
        high = None if draw is None or draw.high is None else draw.high.constant
        near = {float(w) for m in marks for w in (math.floor(m) - 1, math.floor(m), math.ceil(m), math.ceil(m) + 1)}
        possible = sorted(w for w in near if (low is None or w >= low) and (high is None or w <= high))
        return possible or [low or 0.0]
    between = [0.5 * (a + b) for a, b in zip(marks[:-1], marks[1:], strict=True)]
    return sorted({*marks, *between, marks[0] - 1.0, marks[-1] + 1.0})


def evaluate(node: Expr, values: Mapping[Expr, bool]) -> bool:
    if node.op == "const":
        return bool(node.value)
    if node.op == "not":
        return not evaluate(node.args[0], values)
    if node.op in ("and", "or"):
        left, right = (evaluate(a, values) for a in node.args)
        return left and right if node.op == "and" else left or right
    return values[node]


def combinations(guards: Sequence[Expr], draws: Iterable[Draw]) -> list[tuple[bool, ...]]:
    """The truth values that the guards can have together, without repetition. Raises TooManyCases."""
    known = {d.column: d for d in draws}
    groups: dict[Expr, list[Expr]] = {}
    for atom in _atoms(guards):
        found = subject(atom)
        groups.setdefault(atom if found is None else found[0], []).append(atom)
    choices: list[list[dict[Expr, bool]]] = []
    total = 1
    for node, members in groups.items():
        if members == [node]:
            options = [{node: False}, {node: True}]
        else:
            split = [subject(m) for m in members]
            options = []
            for value in trials(node, [s[1] for s in split if s is not None], known):
                truths = {}
                for member, found in zip(members, split, strict=True):
                    assert found is not None
                    pair = (value, found[1]) if found[2] else (found[1], value)
                    truths[member] = _COMPARISONS[member.op](*pair)
                if truths not in options:
                    options.append(truths)
        choices.append(options)
        total *= len(options)
    if total > _MOST_TRIALS:
        raise TooManyCases
    result: dict[tuple[bool, ...], None] = {}
    for pick in product(*choices):
        values = {k: v for part in pick for k, v in part.items()}
        result[tuple(evaluate(g, values) for g in guards)] = None
    if len(result) > _MOST_CASES:
        raise TooManyCases
    return list(result)


def covered(guards: Sequence[Expr], draws: Iterable[Draw], within: Expr = E.TRUE) -> bool:
    """Whether one of the guards holds in every case in which ``within`` does; False where that is too much to try."""
    try:
        return all(any(held) for there, *held in combinations([within, *guards], draws) if there)
    except TooManyCases:
        return False


def condition(guards: Sequence[Expr], truth: Sequence[bool]) -> Expr:
    """The conjunction that says that the guards have these truth values."""
    return E.all_of(guard if holds else E.negate(guard) for guard, holds in zip(guards, truth, strict=True))
