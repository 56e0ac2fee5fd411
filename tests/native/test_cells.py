"""Pieces that several joints move: compiled code says what NumPy says of them, to the last bit."""

import os
from dataclasses import replace

import numpy as np
import pytest

from artipg_dsl.session import Session
from artipg_dsl.validity.bodies import gather
from artipg_dsl.validity.cells import _cloud, _posed, examine_cells
from artipg_dsl.validity.together import Cells, list_ways
from artipg_dsl.validity.tree import Tree

from .machine import bits, needs_compiler

pytestmark = needs_compiler


@pytest.fixture(scope="module", params=["Faucet", "Microwave"] if os.environ.get("ARTIPG_EVERY") else ["Faucet"])
def scene(request):
    """Any pieces of links between which several joints turn or slide, with intervals of all sizes, some of no size."""
    batch = Session.of(request.param).sampler.batch(np.arange(3), 3)
    tree = Tree(batch)
    body = gather(batch, tree.first, tree.turn, tree.shift)
    way = list_ways(tree)
    way = way.at(np.flatnonzero((way.joint >= 0).sum(axis=1) > 1))
    begin, end = (np.searchsorted(body.link, np.arange(len(tree.links.owner)), side=side) for side in ("left", "right"))
    way = way.at(np.flatnonzero((end > begin)[way.first] & (end > begin)[way.second]))
    lots = np.random.Generator(np.random.PCG64(1))
    row = lots.integers(0, len(way.first), 2000)
    piece, other = (
        begin[link] + lots.integers(0, 1 << 30, 2000) % (end - begin)[link]
        for link in (way.first[row], way.second[row])
    )
    joint = way.joint[row]
    start = np.where(joint >= 0, lots.normal(size=joint.shape), 0.0)
    wide = 10.0 ** lots.uniform(-4, 0.6, joint.shape) * (lots.uniform(size=joint.shape) < 0.8)
    stop = start + np.where(joint >= 0, wide, 0.0)
    radius = np.where(joint >= 0, lots.uniform(0.0, 0.5, joint.shape), 0.0)
    return tree, body, way, Cells(row, piece, other, start, stop, radius, np.zeros(2000))


@pytest.mark.parametrize("gap", [None, 0.01])
def test_cells(using, scene, gap):
    tree, body, way, cells = scene
    body = replace(body, gap=None if gap is None else np.full(len(body), gap))
    found = []
    for name in ("numpy", "c"):
        using(name)
        hit, apart, loss, total = examine_cells(tree, body, way, cells)
        found.append([bits(column) for column in (hit, apart, loss, total)])
    assert found[0] == found[1]
    assert (hit.any() or gap is None) and apart.sum() > 20 and not (hit & apart).any()


@pytest.mark.parametrize("name", ["numpy", "c"])
def test_no_state_reaches_farther_than_is_said(using, scene, name):
    """And small intervals not much less far: the direction that is carried back stands for the corners that joints carry."""
    using(name)
    tree, body, way, cells = scene
    half = way.joint.shape[1] // 2
    joint, start, stop = way.joint[cells.row][:, :half], cells.start[:, :half], cells.stop[:, :half]
    lots = np.random.Generator(np.random.PCG64(2))
    ahead = lots.normal(size=(len(joint), 3))
    ahead /= np.linalg.norm(ahead, axis=1)[:, None]
    said = _cloud(tree, body, cells.piece, joint, (start + stop) / 2, (stop - start) / 2, ahead)
    reached = np.full(len(joint), -np.inf)
    shares = [0.0, 0.5, 1.0, *lots.uniform(size=40)]
    for share in shares:
        pose = _posed(tree, joint, start + share * (stop - start))
        for at, corners in body.classes(cells.piece):
            placed = np.einsum("kij,kpj->kpi", pose.turn[at], corners) + pose.shift[at][:, None]
            reached[at] = np.maximum(reached[at], np.einsum("kpi,ki->kp", placed, ahead[at]).max(axis=1))
    assert (reached <= said + 1e-12).all()
    little = (stop - start).max(axis=1) < 1e-2
    assert little.sum() > 20
    assert (said - reached)[little].max() < 0.02
