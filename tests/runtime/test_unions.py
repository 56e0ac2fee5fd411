"""Conditional ranges of several intervals: drawn without gaps, by the law of the draw, and never in vain."""

import numpy as np
import pytest

from artipg_dsl.graph.reading import from_text
from artipg_dsl.graph.writing import to_text
from artipg_dsl.runtime import laws
from artipg_dsl.sampling.module import to_module
from artipg_dsl.sampling.mutate import mutate
from artipg_dsl.sampling.sample import Sampler
from artipg_dsl.sampling.statistics import Exhausted, Statistics
from artipg_dsl.session import Session

TWO = "param a : length in 0cm .. 10cm = 2cm\nparam b : length in 0cm .. 10cm = 2cm\n"
COUNTS = "count i in 1 .. 4 = 1\ncount j in 1 .. 4 = 2\n"


def session(body: str) -> Session:
    return Session.of_text(
        "apg 1\nuse primitives { Cuboid }\ncategory C {\n"
        + body
        + "\nroot part body : Cuboid(size = [5cm, 5cm, 1cm])\n}\n"
    )


PROGRAMS = [
    ("abs(a - b) >= 6cm", lambda a, b: abs(a - b) >= 0.06),
    ("abs(a - b) >= 9.9cm", lambda a, b: abs(a - b) >= 0.099),
    ("b <= a or b >= 9cm", lambda a, b: (b <= a) | (b >= 0.09)),
    ("b <= a - 5cm or b >= a + 4.9cm", lambda a, b: (b <= a - 0.05) | (b >= a + 0.049)),
    ("hypot(a - 5cm, b - 5cm) >= 6cm", lambda a, b: np.hypot(a - 0.05, b - 0.05) >= 0.06),
    ("(b - 5cm) * (b - 5cm) >= a * a", lambda a, b: (b - 0.05) ** 2 >= a**2),
    ("(a - 5cm) * (b - 5cm) >= 20cm * 1cm", None),
    (
        "b <= 2cm or b >= 3cm and b <= 4cm or b >= 9cm",
        lambda a, b: (b <= 0.02) | (b >= 0.03) & (b <= 0.04) | (b >= 0.09),
    ),
    ("not (b > 1cm and b < 9.5cm)", lambda a, b: (b <= 0.01) | (b >= 0.095)),
    ("max(a, b) >= 9cm", lambda a, b: np.maximum(a, b) >= 0.09),
    ("a <= 9cm or abs(b - a) >= 8cm", lambda a, b: (a <= 0.09) | (abs(b - a) >= 0.08)),
]


@pytest.mark.parametrize("condition, holds", PROGRAMS, ids=[text for text, _ in PROGRAMS])
def test_every_first_attempt_lies_in_the_union(condition, holds):
    counted, program = Statistics(), session(TWO + f"require {condition}").sampler
    found = program.batch(np.arange(400), 0, statistics=counted)
    if holds is None:
        assert counted.first_valid == 400
        return
    a, b = (found.state.values[k] for k in range(2))
    assert counted.first_valid == 400 and found.program.draws[1].unions
    slack = 1e-8
    assert (holds(a, b) | holds(a, b + slack) | holds(a, b - slack)).all()


def test_the_law_holds_beside_the_gap():
    body = "param b : length in 0cm .. 10cm = 2cm ~ normal(6cm, 2cm)\nrequire abs(b - 5cm) >= 2cm"
    found = session(body).sampler.batch(np.arange(6000), 0).state.values[0]
    rng = np.random.default_rng(0)
    free = rng.normal(0.06, 0.02, 400_000)
    free = free[(free >= 0) & (free <= 0.1) & (abs(free - 0.05) >= 0.02)]
    marks = np.linspace(0, 0.1, 201)
    ours = np.searchsorted(np.sort(found), marks) / len(found)
    assert np.abs(ours - np.searchsorted(np.sort(free), marks) / len(free)).max() < 0.025


def test_uniform_over_the_union_and_weighed_by_it():
    batch = session("param b : length in 0cm .. 10cm = 2cm\nrequire b <= 1cm or b >= 8cm").sampler.batch(
        np.arange(6000), 0
    )
    found = batch.state.values[0]
    assert abs((found <= 0.01).mean() - 1 / 3) < 0.02 and np.allclose(batch.log_weight, np.log(0.3))


@pytest.mark.parametrize("words", ["require i != j", "require i + j != 5", "require i != 2 and j != i"])
def test_whole_numbers_that_differ(words):
    counted = Statistics()
    found = session(COUNTS + words).sampler.batch(np.arange(3000), 0, statistics=counted)
    i, j = found.state.values[0], found.state.values[1]
    assert counted.first_valid == 3000 and ((i + j != 5) if "+" in words else (i != j)).all()
    for one in set(i.tolist()):  # alike among those that are left
        share = np.unique(j[i == one], return_counts=True)[1] / (i == one).sum()
        assert len(share) == 3 and np.abs(share - 1 / 3).max() < 0.06


def test_listed_values_that_differ():
    body = "param d : length in 1cm .. 8cm = 2cm ~ values(2cm, 4cm, 8cm)\nparam e : length in 1cm .. 8cm = 2cm ~ values(2cm, 4cm)\n"
    counted = Statistics()
    session(body + "require d != e").sampler.batch(np.arange(500), 0, statistics=counted)
    assert counted.first_valid == 500


def test_within_a_repeat_each_element_keeps_away():
    body = """param b : length in 0cm .. 10cm = 5cm
      repeat p[i] in 0 ..< 3 { param h : length in 0cm .. 10cm = 5cm
        require abs(h - b) >= 4cm }"""
    counted = Statistics()
    session(body).sampler.batch(np.arange(300), 0, statistics=counted)
    assert counted.first_valid == 300


def test_given_values_defaults_and_mutants_stay_out_of_gaps():
    program = session(TWO + "require abs(a - b) >= 3cm").sampler
    with pytest.raises(Exhausted):
        program.batch(np.arange(2), 0, given={0: 0.02, 1: 0.03})
    assert abs(program.batch(np.arange(1), 0, defaults=True).state.values[1][0] - 0.05) < 1e-12  # 2 cm lies in the gap
    before = program.batch(np.arange(200), 0)
    counted = Statistics()
    after = mutate(program, before, operations=("cpa",), strength=3.0, statistics=counted)
    a, b = after.state.values[0], after.state.values[1]
    assert (np.abs(a - b) >= 0.03 - 1e-8).all() and counted.first_valid == counted.objects


def test_text_form_and_module_have_unions():
    program = session(TWO + COUNTS + "require abs(a - b) >= 3cm\nrequire i != j").sampler.program
    assert to_text(from_text(to_text(program))) == to_text(program)
    space: dict = {}
    exec(compile(to_module(program, "0"), "<module>", "exec"), space)
    state, _, _ = space["evaluate_valid"](range(30), 4)
    batch = Sampler(from_text(to_text(program))).batch(np.arange(30), 4)
    assert all(np.array_equal(state.values[k], batch.state.values[k]) for k in range(4))


def test_an_object_does_not_depend_on_the_batch():
    program = session(TWO + "require abs(a - b) >= 3cm\nrequire hypot(a - 5cm, b - 5cm) >= 3cm").sampler
    whole, alone = program.batch(np.arange(200), 0), program.batch(np.array([150]), 0)
    assert [whole.state.values[k][150] for k in range(2)] == [alone.state.values[k][0] for k in range(2)]


@pytest.mark.parametrize(
    "body, said",
    [
        ("param b : length in 4cm .. 6cm = 5cm\nrequire b <= 3cm or b >= 7cm", "at least 7cm and at most 6cm"),
        (TWO + "require abs(a - b) >= 11cm", "at least 11cm"),
        ("count i in 2 .. 2 = 2\ncount j in 2 .. 2 = 2\nrequire i != j", "can never hold"),
    ],
)
def test_a_union_without_room_is_told(body, said):
    made = session(body)
    assert made.lowering is None
    codes = [d.code for d in made.report.diagnostics]
    assert codes == [*["empty-range"] * body.count("2 .. 2"), "impossible"]
    assert said in made.report.diagnostics[-1].message


def test_gaps_of_unions_overlap_and_nest():
    low = np.zeros(2)
    unions = (
        (True, ((-np.inf, 1.0), (4.0, np.inf))),
        (np.array([True, False]), ((-np.inf, 2.0), (3.0, 3.5), (6.0, np.inf))),
        (True, ((np.nan, np.nan), (np.inf, -np.inf))),  # nothing is known, and an interval that is empty
    )
    gaps = laws.gaps_of(low, unions, False)
    unit = (np.arange(4000) + 0.5) / 4000
    for row, allowed in ((0, [(0, 1), (6, 10)]), (1, [(0, 1), (4, 10)])):
        mine = gaps[0][:, row : row + 1], gaps[1][:, row : row + 1]
        room = laws.Room(low[:1], low[:1] + 10, mine)
        found = laws.EVEN.spread(unit, laws.Room(np.zeros(4000), np.full(4000, 10.0), mine))
        assert (
            ((found[:, None] >= np.array(allowed)[:, 0]) & (found[:, None] <= np.array(allowed)[:, 1]))
            .any(axis=1)
            .all()
        )
        share = (found <= 1).mean()
        assert abs(share - 1 / sum(b - a for a, b in allowed)) < 1e-3
        assert np.allclose(laws.EVEN.measure(room), sum(b - a for a, b in allowed))
        moved = laws.move_out_of_gaps(np.full(1, 1.2), room)
        assert np.allclose(moved, 1.0)
