"""Pieces that turn: compiled code says what NumPy says of them, to the last bit."""

from dataclasses import replace

import numpy as np
import pytest

from artipg_dsl.geometry.vectors import dot
from artipg_dsl.native import turning as native
from artipg_dsl.session import Session
from artipg_dsl.validity.bodies import Placed, gather, swept_extent, turn_points
from artipg_dsl.validity.tree import Tree
from artipg_dsl.validity.turns import Turns
from artipg_dsl.validity.validate import find_near_pieces

from .machine import bits, needs_compiler

pytestmark = needs_compiler


@pytest.fixture(scope="module")
def pairs():
    """Any two pieces of faucets, and turns of the one about axes near it, advancing as a screw does."""
    batch = Session.of("Faucet").sampler.batch(np.arange(2), 3)
    tree = Tree(batch)
    body = gather(batch, tree.first, tree.turn, tree.shift)
    lots = np.random.Generator(np.random.PCG64(1))
    piece, other = lots.integers(0, len(body), (2, 4000))
    axis = lots.normal(size=(4000, 3))
    axis /= np.sqrt(dot(axis, axis))[:, None]
    origin = body.low[piece] + 0.05 * lots.normal(size=(4000, 3))
    start = lots.normal(size=4000)
    stop = start + 10.0 ** lots.uniform(-3, 0.9, 4000)
    advance = np.where(lots.uniform(size=4000) < 0.5, 0.0, 0.01)
    return body, Turns(piece, other, axis, origin, start, stop, advance, np.arange(4000))


@pytest.mark.parametrize("name", ["Faucet", "Kettle", "WashingMachine"])
def test_pieces_near_others(using, monkeypatch, name):
    """At rest, and those that a joint moves along left out; there is more than there is room for at first."""
    monkeypatch.setattr(native, "_ROOM", 0)
    batch = Session.of(name).sampler.batch(np.arange(2), 3)
    tree = Tree(batch)
    body = gather(batch, tree.first, tree.turn, tree.shift)
    every, found = np.arange(len(body)), []
    for backend in ("numpy", "c"):
        using(backend)
        told = [find_near_pieces(tree, body, every, body.low - 0.01, body.high, None)]
        told += [
            find_near_pieces(tree, body, piece, body.low[piece] - 0.05, body.high[piece], joint)
            for piece, joint in tree.carried(body, np.ones(len(tree.joints.owner), dtype=bool))
        ]
        found.append([bits(np.asarray(column, dtype=np.int64)) for pair in told for column in pair])
        assert len(told) > 1 and all(len(pair[0]) for pair in told)
    assert found[0] == found[1]


@pytest.mark.parametrize("gap", [None, 0.02])
def test_intervals_of_angles(using, pairs, gap):
    body, turns = pairs
    body = replace(body, gap=None if gap is None else np.full(len(body), gap))
    found = []
    for name in ("numpy", "c"):
        using(name)
        found.append([bits(which) for which in turns.examined(body)])
    assert found[0] == found[1]
    hit, apart = turns.examined(body)
    assert hit.sum() > 100 and apart.sum() > 100 and not (hit & apart).any()


def test_how_far_pieces_reach_while_they_turn(using, pairs):
    body, turns = pairs
    lots = np.random.Generator(np.random.PCG64(2))
    turn = np.linalg.qr(lots.normal(size=(4000, 3, 3)))[0]
    moved = Placed(body, turns.piece, turn, lots.normal(size=(4000, 3)))
    half, direction = lots.uniform(0, np.pi, 4000), lots.normal(size=(4000, 3))
    found = []
    for name in ("numpy", "c"):
        using(name)
        found.append(bits(swept_extent(moved, turns.axis, turns.origin, half, direction)))
    assert found[0] == found[1]


def test_points_that_are_turned(using):
    lots = np.random.Generator(np.random.PCG64(2))
    turn, points, shift = (lots.normal(size=(50, *shape)) for shape in ((3, 3), (7, 3), (3,)))
    found = []
    for name in ("numpy", "c"):
        using(name)
        found.append([bits(turn_points(turn.transpose(0, 2, 1), points[:, ::2], by)) for by in (None, shift)])
    assert found[0] == found[1]
