"""Plans with long runs of operations as tapes: less code, the same bits."""

from __future__ import annotations

import numpy as np
import pytest

from artipg_dsl.graph.expr import Scope
from artipg_dsl.graph.formula import NUMPY
from artipg_dsl.runtime import draws, kernels, newton
from artipg_dsl.runtime.kernels import State
from artipg_dsl.runtime.lines import Step, taped
from artipg_dsl.session import Session


@pytest.fixture(scope="module", params=["Kettle", "Table"])
def plan(request):
    return Session.of(request.param).sampler.plan


def _values(function, count: int, attempt: int):
    tables, values = function(State(7, np.arange(count), np.full(count, attempt)))
    return [(np.asarray(v).dtype.kind, np.shape(v), np.asarray(v).tobytes()) for v in values], [t.size for t in tables]


@pytest.mark.some
def test_tapes_give_the_bits_of_the_code_that_is_shown(plan) -> None:
    namespace = {**vars(kernels), **vars(draws), "solve_roots": newton.solve_roots}
    exec(plan.source, namespace)
    for count, attempt in [(0, 0), (1, 0), (1, 1), (5, 2), (300, 3), *((2, k) for k in range(20))]:
        assert _values(plan.function, count, attempt) == _values(namespace["evaluate"], count, attempt)


def test_long_runs_are_no_code(plan) -> None:
    lines, tapes = taped(plan.lines, plan.values)
    told = sum(isinstance(line, Step) for line in lines)
    steps = sum(isinstance(line, Step) for line in plan.lines)
    assert tapes and sum(len(tape.tape.steps) for tape in tapes.values()) == steps - told > 0
    assert all(line.op in NUMPY for line in plan.lines if isinstance(line, Step))


def test_a_step_of_one_number_and_a_table_each_are_told_apart() -> None:
    """Steps on two tables stand among one another; what one number is for all comes first, whatever reads it."""
    one, two = Scope("one", None, "root"), Scope("two", None, "root")
    lines = [Step("x2", "add", ("x0", "1.0"), one), Step("x3", "mul", ("x1", "(-2.0)"), two)]
    lines += [Step("x4", "sub", ("3.0", "np.inf"), None), Step("x5", "min", ("x2", "x4"), one)]
    lines += [Step(f"x{6 + k}", "add", (f"x{5 + k if k else 5}", "0.5"), one) for k in range(30)]
    lines += [Step(f"x{40 + k}", "mul", ("x3" if not k else f"x{39 + k}", "0.5"), two) for k in range(30)]
    told, tapes = taped([*lines, "    keep(x35)"], ["x69"])
    assert [str(line).strip().partition(" = ")[0] for line in told] == ["x4", "x35,", "x69,", "keep(x35)"]
    x0, x1, x4 = np.array([1.0, 2.0]), np.array([4.0]), 3.0 - np.inf
    first, second = tapes.values()
    assert first(x0, x4)[0].tolist() == [x4 + 15.0] * 2
    assert second(x1)[0].tolist() == [-8.0 * 0.5**30]
