"""The patches of a primitive as functions of parameters and of fractions 0 .. 1 along u and v.

Indexed patches are spelt out, so a *patch number* counts the surfaces that exist: ``handle[0]``, ``handle[1]``, ...
Their formulas are split: what depends on the parameters alone is evaluated once per instance, the rest per point.
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
from .split import Params, Split, rows_of

U, V = var("u"), var("v")


@dataclass(frozen=True, eq=False)
class Surface:
    """One patch: the ``index``-th where it is declared for several."""

    name: str
    patch: Patch
    declared: int  # index into Primitive.patches
    index: int | None

    @property
    def _known(self) -> dict[Expr, Expr]:
        return {} if self.index is None else {var("i"): const(self.index)}

    @cached_property
    def guard(self) -> Expr | None:
        """Whether it exists, of the parameters; None where it always does."""
        return None if self.patch.guard is None else substitute(self.patch.guard, self._known)

    @cached_property
    def position(self) -> Triple:
        """Over fractions of u and v."""
        u0, u1, v0, v1 = (substitute(e, self._known) for e in (*self.patch.u_range, *self.patch.v_range))
        mapping = self._known | {U: u0 + U * (u1 - u0), V: v0 + V * (v1 - v0)}
        return triple(substitute(e, mapping) for e in self.patch.position)

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
            found.append(Surface(patch.name, patch, declared, None))
        for i in range(patch.count or 0):
            found.append(Surface(f"{patch.name}[{i}]", patch, declared, i))
    return tuple(found)


@lru_cache(maxsize=4096)
def position_split(primitive: Primitive, patch: int) -> Split:
    """Position of a patch: three values."""
    return Split.kept(primitive, f"position of {patch}", 3, lambda: surfaces(primitive)[patch].position)


@lru_cache(maxsize=512)
def inside_split(primitive: Primitive) -> Split:
    """The inside function over p.x, p.y, p.z."""
    return Split.kept(primitive, "inside", 1, lambda: (primitive.inside,), ("p.x", "p.y", "p.z"))


@lru_cache(maxsize=512)
def tangent_split(primitive: Primitive, patch: int) -> Split:
    """Both tangents of a patch, by fractions: six values."""

    def tangents() -> tuple[Expr, ...]:
        du, dv = surfaces(primitive)[patch].tangents
        return (*du, *dv)

    return Split.kept(primitive, f"tangents of {patch}", 6, tangents)


@lru_cache(maxsize=512)
def _parameter_formula(primitive: Primitive, exprs: tuple[Expr, ...]) -> Callable[..., tuple[Any, ...]]:
    """Formulas of the parameters alone, as a function of their columns."""
    return compile_formula(exprs, primitive.parameters)


def evaluate_rows(primitive: Primitive, exprs: Sequence[Expr], params: Params, kind: type = np.float64) -> np.ndarray:
    """(number of expressions, k): formulas of the parameters alone, per instance."""
    values = _parameter_formula(primitive, tuple(exprs))(*(params[n] for n in primitive.parameters))
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
    shape = u.shape if u.shape == v.shape else np.broadcast_shapes(u.shape, v.shape)
    rows = split.rows(params)
    values = split.points([r.reshape(-1, *(1,) * len(shape)) for r in rows], u[None], v[None])
    out = np.empty((rows_of(params), *shape, len(values)))
    for c, value in enumerate(values):
        out[..., c] = value
    return out
