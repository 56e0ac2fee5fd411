"""Objects borrow details: from one donor where it has what they need, by template and slot, then by the slot of a role."""

from __future__ import annotations

import numpy as np
import pytest

import artipg_dsl as apg
from artipg_dsl import random
from artipg_dsl.api import Samples
from artipg_dsl.details.binding import Real, bind
from artipg_dsl.details.elements import Solids
from artipg_dsl.details.record import Details, join
from artipg_dsl.details.suits import borrowed_suits, kin
from artipg_dsl.details.trim import trim
from artipg_dsl.details.wear import Wardrobe, wear
from artipg_dsl.geometry import points as geometry
from artipg_dsl.geometry.vectors import dot
from artipg_dsl.runtime.batch import Batch

RAISED = 0.004  # metres: the real surface of donor k lies off its structure by k + 1 times as much
PROGRAM = """apg 1
use primitives { Cuboid, Cylinder }
vocabulary semantic { board handle peg }
category Rack {
  param width : length in 40cm .. 80cm = 60cm
  count pegs in 1 .. 4 = 2
  root part board : Cuboid(size = [4cm, width, 20cm])
  label semantic.board on board
  part hook : Hook = Bar | Rod | Knob | none
  part lower : Hook = Bar | Rod
  label semantic.handle on hook, lower
  connect hook.bottom on board.top
  connect lower.top on board.bottom
  repeat peg[i] in 0 ..< pegs split board along y {
    part pin : Cuboid(size = [6cm, 3cm, 3cm])
    label semantic.peg on pin
    connect pin.back on board.front
    align pin.center.z = board.center.z
  }
}
role Hook {
  inherit size : length[3] in [2cm, 2cm, 8cm] .. [3cm, 3cm, 12cm]
  slot grip
}
template Bar : Hook { part grip : Cuboid(size = size) }
template Rod : Hook { part grip : Cylinder(radius = size.x / 2, height = size.z) along z }
template Knob : Hook { part grip : Cylinder(radius = size.x / 3, height = size.z) along z }
"""
DONORS = ({"hook": "Bar", "lower": "Bar", "pegs": 2}, {"hook": "Rod", "lower": "Bar", "pegs": 4})


def surface(batch: Batch, n: int, key: int) -> geometry.PointSet:
    address = batch.numbers.astype(np.uint64)
    return geometry.sample(batch.sites(), len(batch), n, random.key(key, "test"), address, outside=True)


@pytest.fixture(scope="module")
def details() -> Details:
    made = []
    for number, settings in enumerate(DONORS):
        batch = apg.load(PROGRAM, n=1, seed=1, set=settings).batch
        found, mixed = surface(batch, 4000, 3), np.random.default_rng(1).permutation(4000)
        normal = found.normal[0][mixed]
        points = found.position[0][mixed] + (number + 1) * RAISED * normal
        made.append(bind(batch, Real(f"rack{number}", points, normal, np.zeros(4000, dtype=np.int64), ("all",)), 2500))
    return join(made)


@pytest.fixture(scope="module")
def objects() -> Samples:
    return apg.load(PROGRAM, n=24, seed=7)


def sites(samples: Samples, path: str) -> list[int]:
    return [k for k, site in enumerate(samples.batch.program.sites) if site.path == path]


def test_like_parts_come_first_then_counterparts(objects: Samples) -> None:
    program = objects.batch.program
    levels = kin(program)
    bar, rod, knob = sites(objects, "hook.grip")
    other_bar, other_rod = sites(objects, "lower.grip")
    assert levels[bar] == ((bar, other_bar), (rod, knob, other_rod))
    assert levels[knob] == ((knob,), (bar, rod))
    assert levels[sites(objects, "board")[0]] == ((sites(objects, "board")[0],),)
    assert levels[sites(objects, "peg.pin")[0]] == ((sites(objects, "peg.pin")[0],),)


def test_an_object_wears_one_donor_and_only_what_that_lacks_of_another(objects: Samples, details: Details) -> None:
    batch = objects.batch
    suits = borrowed_suits(batch, details)
    elements, stock = suits.elements, details.elements
    assert (suits.match >= 0).all()
    donor = stock.owner[suits.match]
    board = sites(objects, "board")[0]
    main = donor[elements.site == board][elements.owner]  # each has one board
    assert 4 < main[elements.site == board].sum() < 20  # either donor is drawn
    rods = np.isin(elements.site, [sites(objects, "hook.grip")[1], sites(objects, "lower.grip")[1]])
    assert (donor[rods] == 1).all() and (main[rods] == 0).any()  # the first donor has no rod
    assert np.array_equal(donor[~rods], main[~rods])
    same = stock.site[suits.match] == elements.site
    assert same[elements.site == board].all()
    knobs = elements.site == sites(objects, "hook.grip")[2]
    assert knobs.any() and np.isin(stock.site[suits.match[knobs]], sites(objects, "hook.grip")[:2]).all()


def test_rows_are_spread_over_those_of_the_donor(objects: Samples, details: Details) -> None:
    suits = borrowed_suits(objects.batch, details)
    elements, stock = suits.elements, details.elements
    pins = np.flatnonzero(elements.site == sites(objects, "peg.pin")[0])
    several = np.bincount(elements.owner[pins])[elements.owner[pins]]
    theirs = np.array([DONORS[k]["pegs"] for k in stock.owner[suits.match[pins]]])
    rank, worn = elements.rank[pins], stock.rank[suits.match[pins]]
    assert (worn[(rank == 0) & (several > 1)] == 0).all()
    last = (rank == several - 1) & (several > 1)
    assert last.any() and np.array_equal(worn[last], theirs[last] - 1)
    alike = several == theirs
    assert alike.any() and np.array_equal(worn[alike], rank[alike])


def test_objects_borrow_the_same_in_any_batch(objects: Samples, details: Details) -> None:
    whole, some = borrowed_suits(objects.batch, details), objects.job.batch([5, 17])
    alone = borrowed_suits(some, details)
    for k, number in enumerate((5, 17)):
        assert np.array_equal(alone.match[alone.elements.owner == k], whole.match[whole.elements.owner == number])
    mutants = objects.mutate("cpa").batch  # and so do their mutants
    assert np.array_equal(borrowed_suits(mutants, details).match, whole.match)


def test_another_donor_leaves_the_order_of_the_others(objects: Samples, details: Details) -> None:
    from dataclasses import replace

    more = join([details, replace(details.take(np.flatnonzero(details.owner == 0)), names=("rack2", "empty"))])
    before, after = borrowed_suits(objects.batch, details), borrowed_suits(objects.batch, more)
    donor = more.elements.owner[after.match]
    new = donor >= 2
    assert new.any() and not new.all()
    assert np.array_equal(after.match[~new], before.match[~new])


def test_points_are_raised_as_those_of_the_donor(objects: Samples, details: Details) -> None:
    batch = objects.job.batch(np.arange(8))
    points, solids = surface(batch, 1500, 5), Solids.of(batch.sites())
    stock = trim(details, solids)
    assert len(stock) > 0.8 * len(details)
    suits = borrowed_suits(batch, stock)
    worn = wear(batch, points, np.arange(8), Wardrobe(stock, solids), suits)
    found = worn.bound >= 0
    assert found.mean() > 0.85
    height = dot(worn.position - points.position, points.normal)
    same = found & (stock.elements.site[stock.element[worn.bound]] == points.site)
    for donor in range(2):
        mine = same & (stock.owner[worn.bound] == donor)
        assert abs(np.median(height[mine]) - (donor + 1) * RAISED) < 0.25 * (donor + 1) * RAISED


def test_what_makes_up_for_a_misfit_is_not_borrowed(details: Details) -> None:
    solids = Solids.of(apg.load(PROGRAM, n=1, seed=1).batch.sites())
    wrong = np.zeros(len(details), dtype=bool)
    wrong[::25] = True
    spoiled = details.take(np.arange(len(details)))
    spoiled.offset[wrong, 0] += 0.03  # spikes
    left = trim(spoiled, solids)
    assert np.abs(left.offset[:, 0]).max() < 0.025
    assert len(left) > 0.9 * len(trim(details, solids)) - wrong.sum()
    far = details.take(np.arange(len(details)))
    far.offset[:, 0] += 0.5  # together, but farther than anything is thick
    board = np.isin(far.elements.site[far.element], [0])
    assert board.any() and not np.isin(far.elements.site[trim(far, solids).element], [0]).any()
    assert len(trim(details.take(np.zeros(0, dtype=np.int64)), solids)) == 0
