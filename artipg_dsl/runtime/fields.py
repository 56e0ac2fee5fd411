"""Formulas of labels and grasps: what depends on the instance is read per row, the rest is a function of points."""

from __future__ import annotations

from collections.abc import Sequence
from functools import lru_cache
from typing import TYPE_CHECKING, Protocol

import numpy as np

from ..graph.expr import Expr, Scope, var, variables
from ..graph.formula import compile_formula, row_values
from ..graph.substitution import substitute_all
from .needs import pose_cells

if TYPE_CHECKING:
    from ..graph.program import Pose, Program
from ..graph.reference import Reference


class FieldReader(Protocol):
    """What annotation needs of a batch: values of expressions in the rows of a scope, and whose rows they are."""

    @property
    def program(self) -> Program: ...

    def __len__(self) -> int: ...

    def read(self, exprs: Sequence[Expr], scope: Scope) -> list[np.ndarray]:
        """One array (rows of ``scope``,) per expression; values of ancestor scopes are gathered."""
        ...

    def owner(self, scope: Scope) -> np.ndarray:
        """The object (0 .. B - 1) of each row of ``scope``, ascending."""
        ...

    def link_numbers(self, scope: Scope, links: Reference) -> np.ndarray:
        """The link number within its object of each row of ``scope``, given a reference to links of the program."""
        ...


class Field:
    """Expressions over the variables ``p.x`` ... ``t`` and columns, split into per-row values and a formula.

    A subexpression without variables is a per-row value: ``inputs`` lists these; the formula reads them as ``#0`` ...
    ``Field.of`` keeps what it has made, since each batch asks for the same ones.
    """

    def __init__(self, exprs: Sequence[Expr]):
        self.inputs = row_values(exprs)
        mapping = {expr: var(f"#{i}") for i, expr in enumerate(self.inputs)}
        self.formulas = substitute_all(exprs, mapping)
        self.names = tuple(sorted(variables(self.formulas)))

    @staticmethod
    def of(exprs: Sequence[Expr]) -> Field:
        return _field(tuple(exprs))

    def __call__(self, inputs: Sequence[np.ndarray], variables: dict[str, np.ndarray]) -> list[np.ndarray]:
        """Values of the expressions; ``inputs`` as in ``self.inputs``, broadcasting with the variables."""
        values = variables | {f"#{i}": value for i, value in enumerate(inputs)}
        shape = np.broadcast_shapes(*(np.shape(v) for v in (*variables.values(), *inputs)))
        results = compile_formula(self.formulas, self.names)(*(values[name] for name in self.names))
        return [np.broadcast_to(np.asarray(r), shape) for r in results]


_field = lru_cache(maxsize=4096)(Field)


def read_pose(reader: FieldReader, pose: Pose, scope: Scope) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Rotation (k, 3, 3), translation (k, 3) and mirror (k,) of a pose in the rows of a scope."""
    values = np.stack([np.asarray(v, dtype=np.float64) for v in reader.read(pose_cells(pose), scope)], axis=-1)
    return values[:, :9].reshape(-1, 3, 3), values[:, 9:12], values[:, 12]


def read_triples(reader: FieldReader, triples: Sequence[Sequence[Expr]], scope: Scope) -> list[np.ndarray]:
    """Vectors (k, 3) in the rows of a scope, one array per triple of expressions."""
    values = reader.read([expr for triple in triples for expr in triple], scope)
    arrays = [np.asarray(v, dtype=np.float64) for v in values]
    return [np.stack(arrays[3 * i : 3 * i + 3], axis=-1) for i in range(len(triples))]
