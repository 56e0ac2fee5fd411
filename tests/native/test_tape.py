"""The compiled machine gives the bits that NumPy gives, whatever the formula and however its arguments lie."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from artipg_dsl.graph.expr import raw, var
from artipg_dsl.graph.formula import SHORT, compile_formula
from artipg_dsl.native import backend, loops
from artipg_dsl.native.tape import Tape

from .machine import bits, needs_compiler

pytestmark = needs_compiler
NAMES = ("a", "b", "c", "d")
TRUTHS = ("lt", "le", "eq", "and", "or", "not")
PLAIN = ("add", "sub", "mul", "div", "min", "max", "atan2", "hypot", "mod", "pow")
CONSTANTS = (0.0, -0.0, 1.0, 2.0, 0.5, -1.0, np.pi, 1e-300, 1e300)
SINGLE = ("neg", "abs", "sqrt", "sin", "cos", "tan", "asin", "acos", "atan", "exp", "log", "floor", "ceil", "sign")


def column(size: int, seed: int) -> np.ndarray:
    """Numbers of all kinds: ordinary ones, huge and tiny ones, noughts of both signs, infinities, no numbers."""
    lots = np.random.Generator(np.random.PCG64(seed))
    many = np.concatenate([lots.normal(size=size), 10.0 ** lots.uniform(-300, 300, size), lots.uniform(-1, 1, size)])
    many[lots.random(len(many)) < 0.02] = 0.0
    for odd in (-0.0, np.inf, -np.inf, np.nan, 2.0):
        many[lots.random(len(many)) < 0.01] = odd
    return lots.permutation(many)[:size]


@st.composite
def expressions(draw):
    """A few expressions over four variables that share what is in them."""
    made = [var(name) for name in NAMES] + [raw("const", (), draw(st.sampled_from(CONSTANTS)))]
    truths = [raw("lt", (made[0], made[1]))]

    def number():
        return draw(st.sampled_from(made))

    for _ in range(draw(st.integers(1, 30))):
        op = draw(st.sampled_from(("plain", "single", "truth", "where")))
        if op == "plain":
            made.append(raw(draw(st.sampled_from(PLAIN)), (number(), number())))
        elif op == "single":
            made.append(raw(draw(st.sampled_from(SINGLE)), (number(),)))
        elif op == "where":
            made.append(raw("where", (draw(st.sampled_from(truths)), number(), number())))
        else:
            name = draw(st.sampled_from(TRUTHS))
            arguments = (draw(st.sampled_from(truths)), draw(st.sampled_from(truths)))
            some = (number(), number()) if name in ("lt", "le", "eq") else arguments
            truths.append(raw(name, some[: 1 if name == "not" else 2]))
    return [made[-1], truths[-1], number(), draw(st.sampled_from(truths)), made[-1]]


SHAPES = [
    ((1500,),) * 4,
    ((129,), (), (129,), (1,)),
    ((1,),) * 4,
    ((1,), (), (1,), (1,)),
    ((1, 1), (1,), (), (1, 1)),
    ((7, 1), (300,), (7, 300), ()),
    ((40, 1), (1, 40), (), (40, 1)),
    ((3, 1, 1), (16, 16), (3, 16, 16), ()),
    ((5, 1), (3,), (5, 3), ()),
    ((0,),) * 4,
]


@settings(max_examples=150, deadline=None)
@given(expressions(), st.sampled_from(SHAPES), st.integers(0, 99))
def test_the_bits_are_those_of_numpy(machine, exprs, shapes, seed):
    values = [column(int(np.prod(shape)), seed + 9 * k).reshape(shape) for k, shape in enumerate(shapes)]
    formula = compile_formula(exprs, NAMES)
    expected = formula.numpy(*values)
    found = formula.tape.run(machine, values)
    with np.errstate(all="ignore"):
        steps = formula.tape.stepwise(values)
    shape = np.broadcast_shapes(*shapes)
    for one, other, third in zip(expected, found or expected, steps, strict=True):
        assert bits(np.broadcast_to(one, shape)) == bits(np.broadcast_to(other, shape))
        assert bits(np.broadcast_to(one, shape)) == bits(np.broadcast_to(third, shape))


def test_most_of_that_is_run_by_the_machine(machine):
    a, b = var("a"), var("b")
    formula = compile_formula([raw("sin", (raw("add", (a, b)),)), raw("lt", (a, b)), a], ("a", "b"))
    for shapes in (((1000,), (1000,)), ((1000,), ()), ((4, 1), (100,)), ((), ())):
        one, two = (column(int(np.prod(shape)), k).reshape(shape) for k, shape in enumerate(shapes))
        assert formula.tape.run(machine, (one, two)) is not None


def test_rows_that_lie_apart_are_read_where_they_are(machine):
    points = column(3000, 1).reshape(-1, 3)
    formula = compile_formula([raw("hypot", (var("x"), var("y")))], ("x", "y"))
    found = formula.tape.run(machine, (points[:, 0], points[:, 1]))
    assert found is not None and bits(found[0]) == bits(formula.numpy(points[:, 0], points[:, 1])[0])


@pytest.mark.parametrize(
    "values", [(np.arange(5), np.arange(5)), (np.ones(5, np.float32),) * 2, (np.ones((2, 1, 2)),) * 2]
)
def test_what_numpy_would_do_otherwise_is_left_to_it(machine, values):
    formula = compile_formula([raw("add", (var("a"), var("b")))], ("a", "b"))
    found = formula.tape.run(machine, values)
    if found is not None:
        assert bits(found[0]) == bits(formula.numpy(*values)[0])
    else:
        assert values[0].dtype != np.float64


def test_a_power_with_exponents_that_are_broadcast_is_left_to_numpy(machine):
    formula = compile_formula([raw("pow", (var("a"), var("b")))], ("a", "b"))
    assert formula.tape.run(machine, (np.ones((3, 1)), np.ones(50))) is None
    assert formula.tape.run(machine, (np.ones(50), 2.0)) is None
    assert formula.tape.run(machine, (np.ones(50), np.ones(50))) is not None
    exponents = np.repeat([[2.0], [0.5], [-1.0]], 50, axis=1)
    for base in (column(3, 1).reshape(3, 1), column(50, 2), column(150, 3).reshape(3, 50)):
        found = formula.tape.run(machine, (base, exponents))
        assert found is not None and bits(found[0]) == bits(formula.numpy(base, exponents)[0])


@pytest.mark.parametrize("shape", [(3, 50), (84, 54), (500, 33), (2, 3000)])
def test_a_power_with_one_exponent_a_row_is_that_of_numpy(machine, shape):
    base, exponents = column(shape[0] * shape[1], 5).reshape(shape), np.resize([-2.0, -0.5, 1.0, -3.0], (shape[0], 1))
    once = raw("pow", (raw("add", (var("c"), raw("const", (), 3.0))), var("b")))  # of two that are the same along a row
    power = raw("pow", (raw("abs", (var("a"),)), raw("neg", (var("b"),))))
    formula = compile_formula([power, once, raw("mul", (once, var("a")))], ("a", "b", "c"))
    for other in (np.abs(column(shape[0], 6)).reshape(-1, 1), 0.7):
        found = formula.tape.run(machine, (base, exponents, other))
        expected = formula.numpy(base, exponents, other)
        assert found is not None and [*map(bits, found)] == [*map(bits, expected)]


def test_a_power_of_one_number_has_the_bits_that_it_has_among_many(machine):
    formula = compile_formula([raw("pow", (var("a"), var("b")))], ("a", "b"))
    base, exponents = np.abs(column(400, 4)), np.resize([2.0, 0.5, -1.0], 400)
    many = formula.numpy(base, exponents)[0]
    alone = [formula.tape.run(machine, (base[k : k + 1], exponents[k : k + 1])) for k in range(400)]
    assert bits(np.concatenate([one[0] for one in alone])) == bits(many)
    assert formula.tape.run(machine, (base[:1], np.broadcast_to(2.0, (1,)))) is None


def test_a_short_formula_is_left_to_numpy(using, monkeypatch):
    using("c")
    short, long = var("a"), var("b")
    for _ in range(SHORT):
        long = raw("sin", (long,))
    monkeypatch.setattr(Tape, "run", lambda self, *_: ("run",) if len(self.steps) >= SHORT else 1 / 0)
    assert compile_formula([raw("sin", (short,))], ("a",))(0.0) == (0.0,)
    assert compile_formula([long], ("b",))(np.zeros(10_000)) == ("run",)


def test_a_formula_of_few_numbers_is_told_to_the_machine_when_it_is_asked_again(using, monkeypatch):
    using("c")
    long = var("c")
    for _ in range(SHORT):
        long = raw("sin", (long,))
    monkeypatch.setattr(Tape, "run", lambda *_: ("run",))
    told = [compile_formula([long], ("c",))(0.0) == ("run",) for _ in range(20)]
    assert not told[0] and told[-1] and told == sorted(told)


def test_every_operation_is_tried_before_it_is_used(machine, monkeypatch):
    assert backend.trial(machine) == []
    loop = loops.loop
    monkeypatch.setattr(loops, "loop", lambda function, kinds: loop(np.cos if function is np.tan else function, kinds))
    assert backend.trial(backend.Machine(machine.library)) == ["tan"]


def test_a_formula_that_reads_an_unknown_name_is_refused():
    with pytest.raises(ValueError, match="reads b"):
        compile_formula([var("b")], ("a",))
