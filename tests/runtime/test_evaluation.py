"""Plans line by line and compiled: the same bits, and compiled only if they are run often."""

from __future__ import annotations

import numpy as np
import pytest

from artipg_dsl.runtime import evaluation, kernels
from artipg_dsl.runtime.evaluation import Evaluation
from artipg_dsl.runtime.kernels import State
from artipg_dsl.runtime.lines import Call, Step
from artipg_dsl.session import Session


def _bits(found):
    tables, values = found
    columns = [getattr(t, name) for t in tables for name in ("parent", "rank", "owner", "address", "start", "count")]
    return [(np.asarray(v).dtype, np.shape(v), np.asarray(v).tobytes()) for v in (*columns, *values)]


def _anew(category: str) -> Evaluation:
    plan = Session.of(category).sampler.plan
    made = plan.function
    return Evaluation(made._lines, made._tables, made._values, made._known)


@pytest.mark.parametrize("category", ["Foldingrack", "Lamp", "StorageFurniture"])
def test_the_same_bits_and_faults_before_and_after(category: str, monkeypatch) -> None:
    compiled, plain = [], evaluation.whole
    monkeypatch.setattr(evaluation, "whole", lambda *given: compiled.append(1) or plain(*given))
    made, found = _anew(category), []
    for run in range(evaluation._OFTEN + 2):
        state = State(3, np.arange(20), np.full(20, 1))
        found.append((_bits(made(state)), state.failed.tolist(), state.broken, state.missed))
        assert len(compiled) == (run >= evaluation._OFTEN)
    assert all(one == found[0] for one in found)


def test_what_is_python_already_is_compiled_at_once() -> None:
    lines = [
        "    def f0(x):",
        "        return x + 1.0",
        Call(("x1",), "f0", ("2.0",)),
        Step("x2", "mul", ("x1", "2.0"), None),
    ]
    assert Evaluation(lines, [], ["x2"], vars(kernels))(State(0, np.arange(1), np.zeros(1)))[1] == [6.0]


def test_what_is_put_together_for_a_call_is_as_it_is_written() -> None:
    known = {**vars(kernels), "told": lambda *given: given}
    arguments = ("state", ("0.5", ("x0",), ()), "None", "'it\\'s'", "7", "(-1.0)", "-np.inf", "True")
    lines = [Step("x0", "add", ("1.0", "1.0"), None), Call(("x1",), "told", arguments, remark="x\ny")]
    state = State(0, np.arange(1), np.zeros(1))
    made = Evaluation(lines, [], ["x1"], known)
    for _ in range(evaluation._OFTEN + 1):
        ((found,),) = made(state)[1:]
        assert found == (state, (0.5, (2.0,), ()), None, "it's", 7, -1.0, -np.inf, True)
