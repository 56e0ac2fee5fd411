"""The patches of a primitive as functions of parameters and of fractions 0 .. 1 along u and v.

Indexed patches are spelt out, so a *patch number* counts the surfaces that exist: ``handle[0]``, ``handle[1]``, ...
Formulas are split: what depends on the parameters alone is evaluated once per instance, the rest per point.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from functools import cached_property, lru_cache
from typing import Any

import numpy as np

from ..graph.derive import derive
from ..graph.expr import Expr, const, var
from ..graph.formula import compile_formula
from ..graph.primitive import Patch, Primitive, Triple, triple
from ..graph.substitution import substitute
from ..records import dataclass

U, V = var("u"), var("v")
Params = dict[str, np.ndarray]


@dataclass(frozen=True, eq=False)
class Surface:
    """One patch: ``position`` over fractions of u and v."""

    name: str
    declared: int  # index into Primitive.patches
    guard: Expr | None
    position: Triple

    @cached_property
    def tangents(self) -> tuple[Triple, Triple]:
        """The derivatives by u and by v."""
        du, dv = (triple(derive(e, by) for e in self.position) for by in ("u", "v"))
        return du, dv

    @cached_property
    def cross(self) -> Triple:
        """du x dv, not normalised."""
        du, dv = self.tangents
        return triple(du[(a + 1) % 3] * dv[(a + 2) % 3] - du[(a + 2) % 3] * dv[(a + 1) % 3] for a in range(3))


@lru_cache(maxsize=512)
def surfaces(primitive: Primitive) -> tuple[Surface, ...]:
    """The surfaces of a primitive in order of their patch numbers."""
    found = []
    for declared, patch in enumerate(primitive.patches):
        if patch.count is None:
            found.append(_surface(patch, declared, patch.name, {}))
        for i in range(patch.count or 0):
            found.append(_surface(patch, declared, f"{patch.name}[{i}]", {var("i"): const(i)}))
    return tuple(found)


def _surface(patch: Patch, declared: int, name: str, index: dict[Expr, Expr]) -> Surface:
    u0, u1, v0, v1 = (substitute(e, index) for e in (*patch.u_range, *patch.v_range))
    mapping = {**index, U: u0 + U * (u1 - u0), V: v0 + V * (v1 - v0)}
    position: Triple = triple(substitute(e, mapping) for e in patch.position)
    guard = None if patch.guard is None else substitute(patch.guard, index)
    return Surface(name, declared, guard, position)


class Split:
    """Formulas over the parameters, ``u`` and ``v``, split into a part per instance and a part per point."""

    def __init__(self, primitive: Primitive, exprs: Sequence[Expr], point: Sequence[str] = ("u", "v")):
        self._names = primitive.parameters
        along = 0
        for name in point:
            along |= var(name).reads
        hoisted: dict[Expr, None] = {}
        seen: set[Expr] = set()

        def collect(node: Expr) -> None:
            if node in seen:
                return
            seen.add(node)
            if node.reads & along:
                for arg in node.args:
                    collect(arg)
            elif node.op != "const":
                hoisted[node] = None

        for expr in exprs:
            collect(expr)
        powers = {node.args[1] for node in seen if node.op == "pow"}
        self._exponents = [k for k, node in enumerate(hoisted) if node in powers]
        self._rows = compile_formula(tuple(hoisted), self._names)
        self._points = compile_formula(exprs, point, tuple(hoisted))

    def rows(self, params: Params) -> np.ndarray:
        """(h, k): the values per instance that the formulas need."""
        count = rows_of(params)
        values = self._rows(*(params[n] for n in self._names))
        out = np.empty((len(values), count))
        for row, value in zip(out, values, strict=True):
            row[...] = value
        return out

    def points(self, rows: Sequence[np.ndarray], *point: np.ndarray) -> tuple[Any, ...]:
        """The values at points: ``rows`` gathered to arrays that broadcast with the point variables (fractions).

        Exponents are told for every point: NumPy computes the power of one that is broadcast in another way, by the number of rows.
        """
        given = list(rows)
        if self._exponents:
            shape = np.broadcast_shapes(*(array.shape for array in (*rows, *point)))
            for k in self._exponents:
                if given[k].shape != shape or 0 in given[k].strides:
                    given[k] = np.broadcast_to(given[k], shape).copy(order="C")
        return self._points(*given, *point)


def rows_of(params: Params) -> int:
    """The number of instances; a primitive without parameters is one instance unless ``""`` gives a column."""
    return len(next(iter(params.values()))) if params else 1


@lru_cache(maxsize=4096)
def position_split(primitive: Primitive, patch: int) -> Split:
    """Position of a patch: three values."""
    return Split(primitive, surfaces(primitive)[patch].position)


@lru_cache(maxsize=512)
def inside_split(primitive: Primitive) -> Split:
    """The inside function over p.x, p.y, p.z."""
    return Split(primitive, (primitive.inside,), ("p.x", "p.y", "p.z"))


@lru_cache(maxsize=512)
def tangent_split(primitive: Primitive, patch: int) -> Split:
    """Both tangents of a patch, by fractions: six values."""
    du, dv = surfaces(primitive)[patch].tangents
    return Split(primitive, (*du, *dv))


@lru_cache(maxsize=512)
def parameter_formula(primitive: Primitive, exprs: tuple[Expr, ...]) -> Callable[..., tuple[Any, ...]]:
    """Formulas of the parameters alone, as a function of their columns."""
    return compile_formula(exprs, primitive.parameters)


def evaluate_rows(primitive: Primitive, exprs: Sequence[Expr], params: Params, kind: type = np.float64) -> np.ndarray:
    """(number of expressions, k): formulas of the parameters alone, per instance."""
    values = parameter_formula(primitive, tuple(exprs))(*(params[n] for n in primitive.parameters))
    out: np.ndarray = np.empty((len(exprs), rows_of(params)), dtype=kind)
    for row, value in zip(out, values, strict=True):
        row[...] = value
    return out


def find_existing(primitive: Primitive, params: Params) -> np.ndarray:
    """(k, patches) bool: which patches an instance has."""
    every = surfaces(primitive)
    out = np.ones((len(every), rows_of(params)), dtype=bool)
    guarded = [i for i, s in enumerate(every) if s.guard is not None]
    guards = [s.guard for s in every if s.guard is not None]
    if guarded:
        out[guarded] = evaluate_rows(primitive, guards, params, bool)
    return np.ascontiguousarray(out.T)


def grid(split: Split, params: Params, u: np.ndarray, v: np.ndarray) -> np.ndarray:
    """(k, *shape of u, number of values): formulas at the same fractions on every instance."""
    shape = np.broadcast_shapes(u.shape, v.shape)
    rows = split.rows(params)
    values = split.points([r.reshape(-1, *(1,) * len(shape)) for r in rows], u[None], v[None])
    out = np.empty((rows_of(params), *shape, len(values)))
    for c, value in enumerate(values):
        out[..., c] = value
    return out
