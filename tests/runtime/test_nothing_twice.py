"""Counts of what is worked out for a batch: once, whoever asks."""

from __future__ import annotations

from unittest import mock

import numpy as np
import pytest

from artipg_dsl.annotate.annotation import annotate
from artipg_dsl.geometry import pieces
from artipg_dsl.graph import expr as E
from artipg_dsl.robot.robots import Robots
from artipg_dsl.runtime import draws
from artipg_dsl.runtime import plan as plans
from artipg_dsl.sampling.known import evaluate_again, rows_of_draw
from artipg_dsl.session import Session
from artipg_dsl.validity import bodies, mass
from artipg_dsl.validity.faults import find_faults
from artipg_dsl.validity.tree import Tree


@pytest.fixture(scope="module")
def sampler():
    return Session.of("Kettle").sampler


def test_pieces_are_built_once_for_check_gripper_and_exports(sampler) -> None:
    with mock.patch.object(pieces, "clouds", side_effect=pieces.clouds) as built:
        batch = sampler.batch(np.arange(3), seed=1, checked=True)
        before = built.call_count
        with mock.patch.object(bodies, "_gathered", side_effect=bodies._gathered) as gathered:
            annotate(batch)
            assert all(robot.colliders for robot in [Robots(batch)])
        assert built.call_count == before == len({id(table.primitive) for table in batch.sites() if len(table)})
        assert gathered.call_count == 0


def test_faces_are_looked_for_where_pieces_come_near_one_another(sampler) -> None:
    """A tenth of the pieces of a kettle at most; those that get theirs later have the same corners as with faces from the start."""
    asked = []
    fitted = pieces.Cloud.fitted

    def counted(cloud, chosen):
        asked.append(len(chosen))
        return fitted(cloud, chosen)

    batch = sampler.batch(np.arange(3), seed=1)
    tree = Tree(batch)
    with mock.patch.object(pieces.Cloud, "fitted", counted):
        body = find_faults(batch).body
    assert 0 < sum(asked) < len(body) / 10
    body = bodies.gather(batch, tree.first, tree.turn, tree.shift)
    body.ready(np.arange(len(body)))
    with mock.patch.object(pieces.Cloud, "settled", lambda cloud: np.zeros(len(cloud.rows), dtype=bool)):
        whole = bodies._gathered(batch, tree.first, tree.turn, tree.shift)
    whole.ready(np.arange(len(whole)))

    def outlines(of):
        corners = [np.unique(of.corners[k][s], axis=0) for k, s in zip(of.kind, of.slot, strict=True)]
        return sorted((int(link), own.tobytes()) for link, own in zip(of.link, corners, strict=True))

    assert outlines(body) == outlines(whole)


def test_masses_are_worked_out_once(sampler) -> None:
    batch = sampler.batch(np.arange(3), seed=1)
    with mock.patch.object(mass, "link_mass", side_effect=mass.link_mass) as worked:
        for _ in range(2):
            mass.masses(batch)
            assert Robots(batch).mass is not None
    assert worked.call_count == 1


def test_one_plan_serves_all_batches(sampler) -> None:
    """Also of what was not planned: what one batch asked for, others of the program find."""
    scope = sampler.program.scopes[0]
    column = next(draw.column for draw in sampler.program.draws if draw.column.scope is scope)
    wanted = [E.col(column) * 2.0, E.col(column) + 7.0]
    with mock.patch.object(plans, "make_plan", side_effect=plans.make_plan) as made:
        for first in (0, 3, 6):
            batch = sampler.batch(np.arange(first, first + 3), seed=1, checked=True)
            one, two = batch.read(wanted, scope)
            assert np.allclose(one / 2, two - 7) and batch.read(wanted[:1], scope)[0].tolist() == one.tolist()
    assert made.call_count == 1


def test_values_that_are_kept_are_not_drawn(sampler) -> None:
    batch = sampler.batch(np.arange(20), seed=1)
    some = np.array([3, 3, 17, 0])
    with mock.patch.object(draws, "uniform") as drawn:
        again = evaluate_again(batch, some)
    assert drawn.call_count == 0
    for number, draw in enumerate(sampler.program.draws):
        row = rows_of_draw(batch, number, some).row
        assert again.state.values[number].tobytes() == batch.state.values[number][row].tobytes(), draw.address
