"""How far a section that goes along a path reaches, wherever it stands: the greatest of a function of two variables."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from ...graph import expr as E
from ...graph.derive import derive
from ...graph.expr import ONE, ZERO, Expr
from ...graph.substitution import substitute
from .cuts import clamp
from .probe import Probe
from .profiles import FLAT, Span, V, straight, tops

W = E.var("section.w")  # along a curve of the section, as V is along the path
_GRID = 8


def reached(
    probe: Probe, spans: Sequence[Span], place: Expr, side: Expr, up: Expr, *, line: bool, windows: int = 1
) -> list[Expr]:
    """Places of which the highest is the highest of all ``place + side * x + up * y``, x and y on the curves of a section.

    ``place``, ``side``, ``up`` and the curves are formulas over the path's v; the curves themselves run over ``W``. On a
    ``line`` all of them are straight in v; a path that winds has a summit in each of several ``windows``.
    """
    found: list[Expr] = []
    for span in spans:
        x, y = span.position
        height = E.add(place, E.add(E.mul(side, x), E.mul(up, y)))
        corner = substitute(height, {W: ZERO})
        found += [substitute(corner, {V: end}) for end in (ZERO, ONE)] if line else tops(probe, corner, windows)
        if all(straight(probe, _at_end(span, end)) for end in (ZERO, ONE)):
            continue
        for end in (ZERO, ONE):
            found += tops(probe, substitute(height, {V: end, W: V}))
        for k in range(0 if line else windows):
            share = E.mul(E.add(V, E.const(float(k))), E.const(1 / windows))
            found += between(probe, height if windows == 1 else substitute(height, {V: share}))
    return found


def _at_end(span: Span, end: Expr) -> Span:
    """A curve of a section at an end of its path, as a curve of its own."""
    x, y = (substitute(substitute(c, {V: end}), {W: V}) for c in span.position)
    return Span(span.name, (x, y))


def between(probe: Probe, height: Expr) -> list[Expr]:
    """The summit of a function of v and w, where it has one off the edges for some test value."""
    steps = [k / 16 for k in range(17)]
    values = np.stack([probe.along([substitute(height, {V: E.const(v)})], steps, W)[:, 0] for v in steps])
    edges = np.concatenate([values[0], values[-1], values[:, 0], values[:, -1]])
    if not (values.max(axis=(0, 1)) > edges.max(axis=0) + 1e-12).any() and not _leads_in(probe, height, values):
        return []
    v, w = E.const(0.5), E.const(0.5)
    top = substitute(height, {V: v, W: w})
    for i in range(_GRID + 1):
        for j in range(_GRID + 1):
            here = E.const(i / _GRID), E.const(j / _GRID)
            value = substitute(height, {V: here[0], W: here[1]})
            higher = E.call("lt", top, value)
            v, w, top = E.where(higher, here[0], v), E.where(higher, here[1], w), E.maximum(top, value)
    first = [derive(height, name) for name in (V, W)]
    second = [derive(first[0], V), derive(first[0], W), derive(first[1], W)]
    tiny = E.const(-1e-12)
    for _ in range(6):
        at = {V: v, W: w}
        (a, b), (p, q, r) = ([substitute(f, at) for f in group] for group in (first, second))
        spread = E.sub(E.mul(p, r), E.mul(q, q))
        good = E.both(E.call("lt", ZERO, spread), E.call("lt", p, ZERO))
        safe = E.where(good, spread, ONE)
        dv = E.where(good, E.div(E.sub(E.mul(q, b), E.mul(r, a)), safe), E.neg(E.div(a, E.minimum(p, tiny))))
        dw = E.where(good, E.div(E.sub(E.mul(q, a), E.mul(p, b)), safe), E.neg(E.div(b, E.minimum(r, tiny))))
        v, w = (clamp(E.add(t, clamp(d, -1 / _GRID, 1 / _GRID)), 0.0, 1.0) for t, d in ((v, dv), (w, dw)))
    return [substitute(height, {V: v, W: w})]


def _leads_in(probe: Probe, height: Expr, values: np.ndarray) -> bool:
    """Whether a function (17, 17, rows) of v and w rises from its highest place on an edge inwards, for some test value."""
    last = len(values) - 1
    steps = range(last + 1)
    for axis, name in enumerate((V, W)):
        other = (W, V)[axis]
        slope = derive(height, name)
        for end, way in ((0, 1.0), (last, -1.0)):
            at = [substitute(slope, {name: E.const(end / last), other: E.const(k / last)}) for k in steps]
            highest = np.take(values, end, axis=axis) >= values.max(axis=(0, 1))
            if (highest & (way * probe(*at) > FLAT)).any():
                return True
    return False
