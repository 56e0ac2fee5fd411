"""What the check does, counted: pairs of convex bodies that are told apart, hulls, plans. Times would say it of one machine alone.

NumPy is asked, whose steps all go through ``collide.separate``; compiled code looks at the same pairs.
"""

from __future__ import annotations

import importlib.util
from collections.abc import Iterator
from pathlib import Path

import numpy as np
import pytest

from artipg_dsl.annotate import interactions
from artipg_dsl.geometry.overlap import Touching
from artipg_dsl.native import backend
from artipg_dsl.runtime import fields
from artipg_dsl.sampling import search
from artipg_dsl.session import Session
from artipg_dsl.validity import stance
from artipg_dsl.validity.bodies import gather
from artipg_dsl.validity.tree import Tree

FAN = Path(__file__).parents[1] / "data" / "newcomers" / "desk_fan.apg"
WHOLE = Path(__file__).parents[2] / "benchmarks" / "whole.py"
# of four objects, a tenth above what they were; where a change makes them fewer, they may be lowered
MOST = {"Microwave": {"pairs": 740, "hulls": 8, "pieces": 10}, "Scissors": {"pairs": 890, "hulls": 0, "pieces": 10}}


@pytest.fixture(autouse=True)
def numpy_alone(monkeypatch) -> Iterator[None]:
    monkeypatch.setenv(backend.VARIABLE, "numpy")
    backend.choose("numpy")
    yield
    monkeypatch.undo()
    backend._state = backend._State()


@pytest.mark.parametrize("category", MOST)
def test_no_more_is_looked_at_than_before(category: str) -> None:
    spec = importlib.util.spec_from_file_location("whole", WHOLE)
    assert spec is not None and spec.loader is not None
    whole = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(whole)
    sampler = Session.of(category).sampler
    sampler.batch(np.arange(4), 1, checked=True).joints()  # what is found once for a program
    found = []
    for count in (4, 8):
        with whole.counting() as counts:
            sampler.batch(np.arange(count), 3, checked=True).joints()
        found.append(counts)
    few, many = found
    assert few["plans"] == many["plans"] == 0
    for name, most in MOST[category].items():
        assert few[name] <= most, name
    assert many["pieces"] <= few["pieces"] + 2, "pieces are made for all objects together"
    assert few["pairs"] < many["pairs"] <= 2.4 * few["pairs"], "the work goes with the number of objects"


@pytest.mark.slow
def test_overlaps_are_measured_where_bounds_do_not_decide(monkeypatch) -> None:
    measured = []
    monkeypatch.setattr(Touching, "measured", lambda *_: measured.append(1))
    batch = Session.of(FAN).sampler.batch(np.arange(24), 7)
    tree = Tree(batch)
    stance.find_falling(tree, gather(batch, tree.first, tree.turn, tree.shift))
    assert not measured, "hundreds of wires overlap one another, and cannot matter"


def test_states_are_looked_at_for_objects_in_question(monkeypatch) -> None:
    batch = Session.of("Table").sampler.batch(np.arange(1000, 1032), 7)
    tree = Tree(batch)
    body, sets = gather(batch, tree.first, tree.turn, tree.shift), []
    plain = stance.hulls
    monkeypatch.setattr(stance, "hulls", lambda points, valid: sets.append(len(points)) or plain(points, valid))
    stance.find_falling(tree, body)
    assert 32 < sum(sets) <= 200, "castors turn in a few of the tables only"


def test_formulas_of_labels_are_split_once(monkeypatch) -> None:
    sampler = Session.of("Microwave").sampler
    interactions.find_interactions(sampler.batch(np.arange(4), 1))
    split: list[int] = []
    plain = fields.row_values
    monkeypatch.setattr(fields, "row_values", lambda formulas: split.append(1) or plain(formulas))
    interactions.find_interactions(sampler.batch(np.arange(4), 1))
    assert not split


def test_affordances_are_looked_for_where_they_may_be(monkeypatch) -> None:
    looked: dict[int, int] = {}
    plain = interactions.spread

    def looks(sites, chosen, first, stop, most):
        looked[most] = sum(int(own.sum()) for own in chosen)
        return plain(sites, chosen, first, stop, most)

    monkeypatch.setattr(interactions, "spread", looks)
    found = interactions.find_interactions(Session.of("Window").sampler.batch(np.arange(16), 7))
    rows = looked.pop(1)
    assert len(found.owner) and rows > 0
    assert looked.get(256, 0) <= rows // 20, "conditions of whole parts and deeper labels need few places"


def test_a_repair_evaluates_many_candidates_at_a_time(monkeypatch) -> None:
    sizes = []
    evaluated = search.Search.evaluated
    monkeypatch.setattr(
        search.Search, "evaluated", lambda own, moves: sizes.append(len(moves.place)) or evaluated(own, moves)
    )
    sampler = Session.of("Scissors").sampler
    assert len(sampler.batch(np.array([521]), 1, checked=True, mend=True).repairs)
    assert sum(sizes) > 30
    assert len(sizes) <= 16, "evaluating one takes as long as evaluating many"
