"""Test values of a primitive while it is lowered: what its formulas are like is asked of them, never assumed.

An operator asks whether a curve is straight, ends on the axis or meets the next one. The answer must hold for every
test value that meets the primitive's requirements.
"""

from __future__ import annotations

from collections.abc import Callable, Hashable, Iterable, Sequence
from typing import Any, TypeVar

import numpy as np

from ... import random
from ...graph import expr as E
from ...graph.expr import Expr
from ...graph.formula import evaluate
from ...graph.substitution import substitute
from ...source import Span
from ...syntax import ast
from ..expressions.env import Env
from ..expressions.evaluate import Evaluator
from ..values.handed import Handed
from ..values.kinds import Vec

_T = TypeVar("_T")
ROWS = 48
CANDIDATES = 64 * ROWS
SMALL = 1e-11  # metres: two places this close are one


class Probe:
    """Rows of test values; every answer is over all of them."""

    def __init__(self, env: Env, span: Span):
        symbol = env.symbol
        assert symbol is not None
        conditions = [
            Evaluator(env).condition(s.condition)
            for s in symbol.body
            if isinstance(s, ast.RequireStmt) and s.condition is not None
        ]
        self._known: dict[Hashable, Any] = {}
        self.values = candidates(env)
        good = np.ones(CANDIDATES, dtype=bool)
        for condition in conditions:
            good &= self(condition)[0].astype(bool)
        kept = np.flatnonzero(good)[:ROWS]
        if not len(kept):
            raise env.context.error(
                "impossible",
                span,
                "no values in the test ranges meet the requirements of this primitive",
                hint="widen the ranges after `test`",
            )
        self.values = {name: value[kept] for name, value in self.values.items()}

    @staticmethod
    def of(values: dict[str, np.ndarray]) -> Probe:
        """Rows of given values."""
        made = object.__new__(Probe)
        made.values, made._known = values, {}
        return made

    def spread(self, name: str, values: tuple[float, ...]) -> Probe:
        """The same rows once for each value of another variable."""
        count = len(next(iter(self.values.values())))
        other = {key: np.tile(column, len(values)) for key, column in self.values.items()}
        return Probe.of({**other, name: np.repeat(np.array(values), count)})

    def once(self, answer: Callable[..., _T], *asked: Hashable) -> _T:
        """``answer(probe, *asked)``, found once: bays and boxes ask the same of the same curves."""
        key = answer, *asked
        if key not in self._known:
            self._known[key] = answer(self, *asked)
        found: _T = self._known[key]
        return found

    def __call__(self, *exprs: Expr) -> np.ndarray:
        """(expressions, rows): their values; nan where a formula has none."""
        with np.errstate(all="ignore"):
            return np.array([np.asarray(v, dtype=np.float64) for v in evaluate(exprs, {**self.values})])

    def along(self, exprs: Sequence[Expr], places: Sequence[float], variable: Expr) -> np.ndarray:
        """(places, expressions, rows): their values where a variable has each of several values, at once."""
        values: dict[str, np.ndarray | float] = {**self.values, str(variable.value): np.array(places)[:, None]}
        with np.errstate(all="ignore"):
            seen = np.stack([np.asarray(v, dtype=np.float64) for v in evaluate(exprs, values)], axis=1)
        if np.isfinite(seen).all():
            return seen
        # 0 times what has no value is 0 where the 0 is written: only a formula of its own at each place tells
        each = [self(*(substitute(e, {variable: E.wrap(place)}) for e in exprs)) for place in places]
        return np.stack(each)

    def zero(self, *exprs: Expr) -> bool:
        """Whether all of the lengths vanish for every test value."""
        return all(e is E.ZERO for e in exprs) or bool((np.abs(self(*exprs)) < SMALL).all())

    def same(self, a: Iterable[Expr], b: Iterable[Expr]) -> bool:
        return self.zero(*(E.sub(x, y) for x, y in zip(a, b, strict=True)))

    def tidy(self, value: Expr) -> Expr:
        """A simpler expression of the same value, where there is one: 0 or a parameter."""
        if value.op in ("const", "var"):
            return value
        seen = self(value)[0]
        if (np.abs(seen) < SMALL).all():
            return E.ZERO
        for name, own in self.values.items():
            if name and (np.abs(seen - own) < SMALL).all():
                return E.var(name)
            if name and (np.abs(seen + own) < SMALL).all():
                return E.neg(E.var(name))
        return value

    def greatest(self, values: list[Expr]) -> Expr:
        """The greatest of the values: without those that another one never falls below."""
        seen = self(*values)
        kept: list[int] = []
        for k in range(len(values)):
            others = [j for j in range(len(values)) if j != k and (j in kept or j > k)]
            if not any((seen[j] >= seen[k] - SMALL / 10).all() for j in others):
                kept.append(k)
        return E.maximum(*(self.tidy(values[k]) for k in kept))


def candidates(env: Env) -> dict[str, np.ndarray]:
    """Values of the parameters over their test ranges."""
    assert env.symbol is not None
    number = np.arange(CANDIDATES, dtype=np.uint64)
    parameters = (s for s in env.symbol.body if isinstance(s, ast.ParamDecl))
    switches = {name for s in parameters if s.type.name == "bool" for name in s.names}
    values: dict[str, np.ndarray] = {"": np.zeros(CANDIDATES)}
    for name, (low, high) in test_ranges(env):
        q = random.uniform(random.key(0, "probe", env.symbol.name, name), number)
        value = low + q * (high - low)
        if name in switches:
            value = np.round(q)
        elif low > 0:  # small ones too: every other row by ratio
            value = np.where(number % 2 == 1, np.clip(low * np.power(high / low, q), low, high), value)
        values[name] = value
    return values


def possible(env: Env, conditions: list[Expr]) -> bool:
    """Whether some of them meet all of the conditions."""
    with np.errstate(all="ignore"):
        return bool(
            np.logical_and.reduce(
                [np.asarray(v, bool) for v in evaluate(conditions, {**candidates(env)})], axis=0
            ).any()
        )


def test_ranges(env: Env) -> Iterable[tuple[str, tuple[float, float]]]:
    """The test range of each scalar parameter of the primitive, as its declaration states it, or a use with a path (see ``Context.tested``)."""
    assert env.symbol is not None
    for statement in env.symbol.body:
        if not isinstance(statement, ast.ParamDecl):
            continue
        if statement.type.name == "curve":
            for name in statement.names:
                path = env.force(name)
                if not isinstance(path, Handed):
                    raise env.context.internal(statement.span, f"`{name}` is not a path")
                yield from zip(path.names, path.tests, strict=True)
            continue
        source = statement.test or statement.domain
        for name in statement.names:
            size = statement.type.size
            for k in range(size or 1):
                ends = [0.0, 1.0] if statement.type.name == "bool" else [0.01, 0.5]
                for side, node in enumerate((source.low, source.high) if source is not None else ()):
                    end = Evaluator(env).value(node)
                    end = end.items[k] if isinstance(end, Vec) else end
                    if isinstance(end, Expr) and end.constant is not None:
                        ends[side] = float(end.constant)
                component = f"{name}.{'xyz'[k]}" if size else name
                yield component, env.context.tested.get(component, (ends[0], ends[1]))
