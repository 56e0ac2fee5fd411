"""Tables of a batch: numbering, trees, domains, requirements."""

import numpy as np
import pytest

from artipg_dsl.runtime.kernels import State
from artipg_dsl.sampling.statistics import Statistics
from artipg_dsl.session import Session

PLAIN = """
use primitives { Cuboid }
primitive Collar {
  curve skin (v in 0 .. 1) = [5cm, v * 4cm]
  curve lining (v in 0 .. 1) = [4cm, v * 4cm]
  solid = lathe(skin, lining) about z
}
category Rail {
  root part bar : Cuboid(size = [40cm, 10cm, 2cm])
  repeat spot[i] in 0 ..< 3 spread bar along x margin 6cm {
    part collar : Collar
    connect collar.bottom on bar.top at x = spot.center.x, y = 0
  }
}
"""


def test_first_attempts_are_valid(microwave):
    statistics = Statistics()
    microwave.batch(np.arange(2000), seed=11, statistics=statistics)
    assert statistics.first_valid >= 0.99 * statistics.objects


def test_every_draw_lies_in_its_domain(microwave):
    batch = microwave.batch(np.arange(500), seed=4)
    for number, draw in enumerate(batch.program.draws):
        value = batch.state.values[number]
        if draw.kind == "choice":
            assert ((value >= 0) & (value < len(draw.options))).all()
            continue
        low, high = batch.read([draw.low, draw.high], draw.column.scope)
        assert (value >= low - 1e-9).all() and (value <= high + 1e-9).all(), draw.address
        if draw.kind == "count":
            assert (value == np.round(value)).all()


def test_choices_counts_and_lengths_all_vary(microwave):
    batch = microwave.batch(np.arange(500), seed=4)
    for number, draw in enumerate(batch.program.draws):
        value = batch.state.values[number]
        if draw.kind == "choice":
            assert set(value.astype(int).tolist()) == set(range(len(draw.options))), draw.address
        elif len(value) > 20:
            assert len(np.unique(value)) > 1, draw.address


def test_links_form_a_tree_and_joints_match_them(microwave):
    batch = microwave.batch(np.arange(100), seed=5)
    links, joints = batch.links(), batch.joints()
    for owner in range(len(batch)):
        here = links.owner == owner
        mine = joints.owner == owner
        assert links.number[here].tolist() == list(range(here.sum()))
        assert mine.sum() == here.sum() - 1
        assert sorted(joints.child[mine].tolist()) == list(range(1, here.sum()))
        assert len({links.name[k] for k in np.flatnonzero(here)}) == here.sum()
        parents = dict(zip(joints.child[mine].tolist(), joints.parent[mine].tolist(), strict=True))
        for link in range(1, int(here.sum())):
            steps = 0
            while link:
                link, steps = parents[link], steps + 1
                assert steps < 50


def test_parts_form_a_tree_over_their_objects(microwave):
    batch = microwave.batch(np.arange(60), seed=6)
    parts = batch.parts()
    first = np.searchsorted(parts.owner, np.arange(len(batch)))
    inner = parts.parent >= 0
    above = first[parts.owner[inner]] + parts.parent[inner]
    assert (parts.owner[above] == parts.owner[inner]).all()
    for k, up in zip(np.flatnonzero(inner), above, strict=True):
        stem = parts.path[up]
        assert parts.path[k].startswith(stem)


def test_objects_stand_on_the_ground(microwave):
    from artipg_dsl.geometry import box

    batch = microwave.batch(np.arange(50), seed=8)
    lowest = np.full(len(batch), np.inf)
    for table in batch.sites():
        low, high = box.bounds(table.primitive, table.params)
        for x in (low[:, 0], high[:, 0]):
            for y in (low[:, 1], high[:, 1]):
                for z in (low[:, 2], high[:, 2]):
                    corner = np.stack([x, table.mirror * y, z], axis=-1)
                    height = (table.rotation[:, 2] * corner).sum(axis=-1) + table.translation[:, 2]
                    np.minimum.at(lowest, table.owner, height)
    assert np.abs(lowest).max() < 1e-9


def test_what_is_given_is_kept_and_the_rest_adapts(microwave):
    number = next(k for k, d in enumerate(microwave.program.draws) if d.address == "width")
    batch = microwave.batch(np.arange(200), seed=3, given={number: 0.45})
    assert (batch.values()["width"] == 0.45).all()
    free = microwave.batch(np.arange(200), seed=3)
    assert np.array_equal(
        batch.values()["wall"], free.values()["wall"]
    )  # what the width does not bound stays as it was
    assert (batch.values()["height"] <= 0.66 * 0.45 + 1e-9).all()


def test_a_value_that_leaves_no_room_fails_and_is_counted(microwave):
    number = next(k for k, d in enumerate(microwave.program.draws) if d.address == "height")
    state = State(1, np.arange(50), np.zeros(50, dtype=np.int64), {number: 0.6})
    microwave.plan.function(state)
    assert state.failed.all()
    assert sum(state.missed.values()) + sum(state.broken.values()) >= 50


def test_primitives_without_parameters_are_there_as_often_as_others():
    batch = Session.of_text(PLAIN).sampler.batch(np.arange(4), seed=0)
    collars = batch.sites()[1]
    assert collars.primitive.parameters == () and len(collars) == 12
    low, high = collars.boxes()
    assert low[:3] == pytest.approx(np.array([[-0.19, -0.05, 0.02], [-0.05, -0.05, 0.02], [0.09, -0.05, 0.02]]))
    assert (high - low) == pytest.approx(np.tile([0.1, 0.1, 0.04], (12, 1)))
    assert collars.weights[0] == pytest.approx(np.pi * (0.05**2 - 0.04**2) * 0.04)
    pieces = np.bincount(np.concatenate([cloud.rows for cloud in collars.clouds]))
    assert len(pieces) == 12 and pieces[0] > 1 and (pieces == pieces[0]).all()
