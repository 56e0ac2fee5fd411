"""A program whose draws have other weights and narrower ranges, and the same of everything else.

What a draw can never be (an option of weight 0, a value outside the range or beside its distribution) it cannot be made to be.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace

from ..language import WEIGHTED
from . import expr as E
from .expr import Expr
from .program import Draw, Program

_SMALL = 1e-9
Group = tuple[int, ...]


class NothingLeft(ValueError):
    """What is wrong, in words."""


def reweigh(program: Program, draws: Mapping[int, Draw]) -> Program:
    """The program with some of its draws (by index) replaced. It keeps its hash: what is bound to its parts fits these, too."""
    return replace(program, draws=[draws.get(k, draw) for k, draw in enumerate(program.draws)])


def exclude(draw: Draw, where: Expr = E.TRUE) -> Draw:
    """A draw that has no value in the rows in which a condition holds: no object is left that has any."""
    if draw.kind == "choice":
        return replace(draw, weights=tuple(E.where(where, E.ZERO, weight) for weight in draw.weights))
    low, high = draw.ends
    return replace(draw, low=E.where(where, E.ONE, low), high=E.where(where, E.ZERO, high))


# ---------------------------------------------------------------- choices


def weigh_options(draw: Draw, weights: Mapping[int, float]) -> Draw:
    """A choice with these weights, by option; options that have none are left out. A condition of an option stays. Raises
    NothingLeft."""
    wanted = [float(weights.get(k, 0.0)) for k in range(len(draw.options))]
    for k, weight in enumerate(wanted):
        _require_possible(draw, (k,), weight)
    return _chosen(draw, [_allowed(old, E.const(new)) for old, new in zip(draw.weights, wanted, strict=True)])


def share_options(draw: Draw, shares: Sequence[tuple[Group, float]], otherwise: Group = ()) -> Draw:
    """A choice in which each group of options has a share, 0 to 1, among them as their weights are; the options of no group have the
    rest. ``otherwise``: what is taken where the conditions of all other options fail, whatever its share. Raises NothingLeft."""
    grouped = {k for group, _ in shares for k in group}
    rest = tuple(k for k in range(len(draw.options)) if k not in grouped)
    for group, share in shares:
        _require_possible(draw, group, share)
    left = 1.0 - sum(share for _, share in shares)
    if left < -_SMALL:
        raise NothingLeft(f"the shares add up to {100 * (1 - left):.6g}%")
    if left > _SMALL and not rest:
        raise NothingLeft(f"the shares add up to {100 * (1 - left):.6g}%, and no other option is left for the rest")
    parts = [*shares, *([(rest, max(left, 0.0))] if rest else [])]
    sums = [E.total(draw.weights[k] for k in group) for group, _ in parts]
    weights = list(draw.weights)
    for n, (group, share) in enumerate(parts):
        # the share, times the sums of the other groups as far as they have any: no division, and no share of a group that is ruled out
        factor = E.const(share) if share > _SMALL else E.ZERO
        for m, (other, more) in enumerate(parts):
            if m != n and more > _SMALL and other:
                factor = E.mul(factor, _unless_none(sums[m]))
        for k in group:
            weights[k] = E.mul(draw.weights[k], factor)
    if otherwise:
        none = E.call("le", E.total(w for k, w in enumerate(weights) if k not in otherwise), E.ZERO)
        for k in otherwise:
            weights[k] = E.where(none, draw.weights[k], weights[k])
    return _chosen(draw, weights)


def keep_options(draw: Draw, group: Group, where: Expr) -> Draw:
    """A choice that is one of some options, by the weights that these have, in the rows in which a condition holds. Raises
    NothingLeft."""
    _require_possible(draw, group, 1.0)
    weights = [w if k in group else E.where(where, E.ZERO, w) for k, w in enumerate(draw.weights)]
    return replace(draw, weights=tuple(weights))


def _require_possible(draw: Draw, group: Group, asked: float) -> None:
    if asked > 0.0 and all(draw.weights[k].constant == 0.0 for k in group):
        named = " | ".join(draw.options[k] for k in group)
        raise NothingLeft(f"`{named}` is never drawn: its weight is 0 in the program")


def _unless_none(total: Expr) -> Expr:
    return E.where(E.call("lt", E.ZERO, total), total, E.ONE)


def _allowed(old: Expr, new: Expr) -> Expr:
    """A new weight where the old one is above 0."""
    return E.where(E.call("lt", E.ZERO, old), new, E.ZERO)


def _chosen(draw: Draw, weights: Sequence[Expr]) -> Draw:
    if all(weight.constant is not None and weight.constant <= 0.0 for weight in weights):
        raise NothingLeft("no option is left that has a weight")
    return replace(draw, weights=tuple(weights))


# ---------------------------------------------------------------- numbers


def narrow(draw: Draw, low: float, high: float, where: Expr = E.TRUE) -> Draw:
    """A number between ``low`` and ``high`` as far as its range and its distribution reach, in the rows in which a condition holds.
    Raises NothingLeft."""
    made = _within_support(draw)
    if draw.distribution == "values":
        known = [a.constant for a in draw.arguments]
        if None not in known and not any(low - _SMALL <= float(v or 0.0) <= high + _SMALL for v in known):
            raise NothingLeft("none of its values lies in this range")
    least, most = E.maximum(made.ends[0], E.const(low)), E.minimum(made.ends[1], E.const(high))
    if least.constant is not None and most.constant is not None and least.constant > most.constant + _SMALL:
        raise NothingLeft("this range lies beside its distribution")
    first, last = made.ends
    return replace(made, low=E.where(where, least, first), high=E.where(where, most, last))


def redistribute(draw: Draw, distribution: str, arguments: Sequence[float]) -> Draw:
    """A number drawn by another law within its range. Raises NothingLeft."""
    if draw.distribution == "values":
        raise NothingLeft("it is drawn from single values, so that it has no other distribution")
    made = _within_support(draw)
    if distribution == "uniform" and arguments:
        made = narrow(made, arguments[0], arguments[1])
        arguments = ()
    return replace(made, distribution=distribution, arguments=tuple(map(E.const, arguments)))


def weigh_values(draw: Draw, weights: Mapping[float, float]) -> Draw:
    """A number that is one of some values, each with a weight; its range ends at the least and the most. Raises NothingLeft."""
    kept = {value: weight for value, weight in sorted(weights.items()) if weight > 0.0}
    if not kept:
        raise NothingLeft("no value is left that has a weight")
    if draw.distribution == "values":
        known = [a.constant for a in draw.arguments]
        for value in kept:
            if None not in known and not any(abs(value - float(v or 0.0)) <= _SMALL for v in known):
                raise NothingLeft(f"{value:.6g} is not one of the values it is drawn from")
    made = narrow(draw, min(kept), max(kept))
    arguments = tuple(E.const(cell) for cell in (*kept, *kept.values()))
    return replace(made, distribution=WEIGHTED, arguments=arguments)


def _within_support(draw: Draw) -> Draw:
    """A draw whose range is no wider than ``uniform(a, b)`` is."""
    if draw.distribution != "uniform" or not draw.arguments:
        return draw
    low, high = draw.ends
    return replace(draw, low=E.maximum(low, draw.arguments[0]), high=E.minimum(high, draw.arguments[1]), arguments=())
