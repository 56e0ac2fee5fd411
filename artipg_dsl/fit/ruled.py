"""Choices of which no surface tells, as they only rule which options others may have: whether handles are of one kind or of two.

Where such a choice takes another value, some options are no longer possible. But another option may be the same template with other
arguments, its twin: a drawer whose handle is of the other kind.
"""

from __future__ import annotations

from collections.abc import Sequence
from itertools import permutations

import numpy as np

from ..graph.depend import draws_behind
from ..graph.expr import Expr, leaves
from ..graph.program import Draw, Program
from ..graph.scopes import Scope
from ..records import dataclass


@dataclass(frozen=True, slots=True, eq=False)
class Ruled:
    """What the choice ``ruling`` rules. ``twins``: choices, and of each of their options the twin, -1 where it has none. ``same``: pairs of
    draws, in a twin and in the other, that have one name. ``apart``: the choices that stand once and shape one twin and not the other."""

    ruling: int
    twins: list[tuple[int, np.ndarray]]
    same: list[tuple[int, int]]
    apart: list[int]


def ruling_of(program: Program, discrete: Sequence[int], behind: Sequence[int]) -> list[int]:
    """The choices on which the weights of ``discrete`` draws depend, and no surface: none of those ``behind`` one."""
    weights = [weight for k in discrete for weight in program.draws[k].weights]
    return [k for k in draws_behind(program, weights) if k not in set(behind) and program.draws[k].kind == "choice"]


def ruled_by(program: Program, discrete: Sequence[int], ruling: Sequence[int]) -> list[Ruled]:
    """What those choices rule that have twins among what they rule."""
    draws = program.draws
    twinned = {k: twin for k in discrete if (twin := _twins(draws[k].options)).max(initial=-1) >= 0} if ruling else {}
    behind = {k: set(draws_behind(program, draws[k].weights)) for k in twinned}
    found = []
    for number in ruling:
        mine = [k for k in twinned if number in behind[k]]
        if mine:
            same = [pair for k in mine for pair in _same(program, k)]
            apart = [
                one for k in mine for one in _apart(program, k) if one in set(discrete) and _chosen_once(draws[one])
            ]
            found.append(Ruled(number, [(k, twinned[k]) for k in mine], same, apart))
    return found


def _twins(options: tuple[str, ...]) -> np.ndarray:
    """(n,) of each option another one of the same template, -1 where there is none."""
    names = [option.partition("#")[0] for option in options]
    others = ([k for k, one in enumerate(names) if one == name and k != own] for own, name in enumerate(names))
    return np.array([other[0] if other else -1 for other in others], dtype=np.int64)


def _scopes(program: Program, number: int) -> list[list[Scope]]:
    """The scopes of the options of a choice, those of one template together where there are several."""
    column = program.draws[number].column
    found: dict[str, list[Scope]] = {}
    for scope in program.scopes:
        if scope.parent is column.scope and scope.count is not None and column in leaves(scope.count):
            found.setdefault(scope.name, []).append(scope)
    return [several for several in found.values() if len(several) > 1]


def _same(program: Program, number: int) -> list[tuple[int, int]]:
    found = []
    for several in _scopes(program, number):
        inside = [[k for k, one in enumerate(program.draws) if one.column.scope.within(scope)] for scope in several]
        told = {k: (program.draws[k].column.name, program.draws[k].kind) for k in sum(inside, [])}
        found += [(a, b) for one, other in permutations(inside, 2) for a in one for b in other if told[a] == told[b]]
    return found


def _apart(program: Program, number: int) -> list[int]:
    found: set[int] = set()
    for several in _scopes(program, number):
        behind = [set(draws_behind(program, _shape(program, scope))) for scope in several]
        found |= behind[0].union(*behind) - behind[0].intersection(*behind)
    return sorted(found)


def _shape(program: Program, within: Scope) -> list[Expr]:
    """What says which primitives there are within a scope, and how large: where they stand depends on all others, as on the lowest one."""
    sites = [site for site in program.sites if site.scope.within(within)]
    found = [cell for site in sites for cell in site.parameters]
    return found + [one.count for site in sites for one in site.scope.ancestors() if one.count is not None]


def _chosen_once(draw: Draw) -> bool:
    return draw.kind == "choice" and all(one.kind != "repeat" for one in draw.column.scope.ancestors())
