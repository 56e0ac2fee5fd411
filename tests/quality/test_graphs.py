"""Kinematic graphs and the distance between them."""

from __future__ import annotations

import itertools

import numpy as np
import pytest

from artipg_dsl.quality.distance import Distance, measure_distance
from artipg_dsl.quality.graphs import Graphs, Subtree, find_graphs

from .programs import CHEST, sampled


def test_graphs_of_a_chest_are_those_one_can_count() -> None:
    _, batch = sampled(CHEST)
    found = find_graphs(batch)
    kind, count = found.kinds
    assert {found.text[k] for k in kind} == {
        "body",
        "body(prismatic drawer)",
        "body(prismatic drawer, prismatic drawer)",
        "body(revolute lid)",
        "body(prismatic drawer, revolute lid)",
        "body(prismatic drawer, prismatic drawer, revolute lid)",
    }
    assert count.sum() == 60 and list(count) == sorted(count, reverse=True)
    assert np.array_equal(found.joints, np.bincount(batch.joints().owner, minlength=60))
    share = count / 60
    assert found.perplexity == pytest.approx(np.exp(-(share * np.log(share)).sum()))


def test_a_graph_does_not_depend_on_the_batch() -> None:
    sampler, batch = sampled(CHEST)
    alone = find_graphs(sampler.batch(np.array([7]), 0))
    together = find_graphs(batch)
    assert alone.text[alone.code[0]] == together.text[together.code[7]]


def test_the_order_of_children_does_not_count() -> None:
    text = """
category Pair {
  count swap in 0 .. 1
  root part body : Cuboid(size = [30cm, 30cm, 30cm])
  when swap == 0 {
    part a : Cuboid(size = [5cm, 5cm, 5cm])
    part b : Cylinder(radius = 2cm, height = 5cm)
    align a.bottom = body.top + 1mm
    align a.left = body.left
    align b.bottom = body.top + 1mm
    align b.right = body.right
    joint one : prismatic body -> a along z range 0 .. 1cm
    joint two : continuous body -> b about b.axis
    label semantic.button on a
    label semantic.dial on b
  } else {
    part d : Cylinder(radius = 2cm, height = 5cm)
    part c : Cuboid(size = [5cm, 5cm, 5cm])
    align c.bottom = body.top + 1mm
    align c.left = body.left
    align d.bottom = body.top + 1mm
    align d.right = body.right
    joint four : continuous body -> d about d.axis
    joint three : prismatic body -> c along z range 0 .. 1cm
    label semantic.button on c
    label semantic.dial on d
  }
  label semantic.body on body
}
"""
    found = find_graphs(sampled(text)[1])
    assert [found.text[k] for k in found.kinds[0]] == ["body(continuous dial, prismatic button)"]


def forest(*trees: tuple) -> Graphs:
    """Graphs from nested tuples (joint, part, child, child, ...)."""
    nodes: list[Subtree] = []

    def code(tree: tuple) -> int:
        joint, part, *children = tree
        node = Subtree(joint, part, tuple(sorted(map(code, children))))
        if node not in nodes:
            nodes.append(node)
        return nodes.index(node)

    codes = np.array([code(tree) for tree in trees])
    return Graphs(tuple(nodes), codes, np.zeros(len(codes), dtype=np.int64))


LEAF, DOOR, HANDLE = ("prismatic", "drawer"), ("revolute", "door"), ("revolute", "handle")


@pytest.mark.parametrize(
    "first, second, distance",
    [
        (("root", "body"), ("root", "body"), 0),
        (("root", "body"), ("root", "body", LEAF), 1),
        (("root", "body", LEAF, DOOR), ("root", "body", DOOR, LEAF), 0),
        (("root", "body", LEAF, LEAF), ("root", "body", DOOR, LEAF), 1),
        (("root", "body", LEAF, LEAF, LEAF), ("root", "body", DOOR), 3),
        (("root", "body", (*DOOR, HANDLE)), ("root", "body", HANDLE), 1),  # the door between is taken out
        (("root", "body", (*DOOR, HANDLE), LEAF), ("root", "frame", DOOR), 3),
        (("root", "body", (*DOOR, HANDLE)), ("root", "body", DOOR, HANDLE), 2),  # the handle goes and comes anew
    ],
)
def test_the_edit_distance_of_small_trees(first: tuple, second: tuple, distance: int) -> None:
    found = forest(first, second)
    a, b = found.code.tolist()
    assert Distance(found).tree(a, b) == Distance(found).tree(b, a) == distance


def test_the_mean_over_all_pairs() -> None:
    one, two = ("root", "body"), ("root", "body", LEAF, LEAF)
    found = forest(one, one, two, two)
    distance = Distance(found)
    expected = np.mean([distance.normalised(a, b) for a, b in itertools.permutations(found.code.tolist(), 2)])
    mean, pairs = measure_distance(found)
    assert mean == pytest.approx(expected) == pytest.approx(2 / 3 * 2 / 3) and pairs == 6
    assert measure_distance(forest(one)) == (0.0, 0)


def test_a_sample_of_pairs_comes_close_to_all() -> None:
    many = [("root", "body", *[LEAF] * (k % 6), *[DOOR] * (k // 6)) for k in range(36)]
    found = forest(*many)
    distance = Distance(found)
    exact = np.mean([distance.normalised(a, b) for a, b in itertools.permutations(found.code.tolist(), 2)])
    mean, pairs = measure_distance(found)
    assert pairs == 400 and mean == pytest.approx(exact, abs=0.04)
    assert measure_distance(found) == (mean, pairs)
