"""What another primitive of an object covers stays beneath it, whatever its original was like."""

from __future__ import annotations

import numpy as np
import pytest

import artipg_dsl as apg
from artipg_dsl.api import Samples
from artipg_dsl.details.binding import Real, bind
from artipg_dsl.details.calm import calm
from artipg_dsl.details.cover import SUNK, hold
from artipg_dsl.details.displace import displace
from artipg_dsl.details.elements import Elements, Solids, elements_of
from artipg_dsl.details.suits import own_suits
from artipg_dsl.details.wear import Wardrobe
from artipg_dsl.robot.solids import build_meshes
from artipg_dsl.runtime.batch import Batch

from .raised import RAISED, surface

PROGRAM = """apg 1
use primitives { Cuboid }
category Screen {
  param gap : length in -10mm .. 5mm = -1mm
  root part plate : Cuboid(size = [2cm, 60cm, 40cm])
  part pane : Cuboid(size = [2mm, 40cm, 20cm]) | none
  connect pane.back on plate.front gap gap
}
"""
FRONT, SIZE = 0.01, np.sqrt(0.02**2 + 0.6**2 + 0.4**2)  # of the plate: where its front lies, and its diagonal


OUT = np.array([1.0, 0.0, 0.0])


def element(batch: Batch, elements: Elements, part: str) -> int:
    return [batch.program.parts[batch.program.sites[k].part].path for k in elements.site].index(part)


def screen(pane: str, gap: float = -0.001) -> Samples:
    return apg.load(PROGRAM, set={"pane": pane, "gap": gap}, checked=False)


@pytest.mark.parametrize(
    ("gap", "way", "covered"),
    [
        (-0.001, 0.003, True),  # out of the pane, whose back lies 1 mm behind the front of the plate
        (0.001, 0.006, True),  # through the pane, which lies before it
        (-0.001, 0.0009, True),  # up to its surface, where the steps of meshes would show it
        (-0.001, -0.003, False),  # out of its back
        (0.004, 0.003, False),
        (-0.01, 0.003, False),  # the plate lies over the pane
    ],
)
def test_ways_out_of_another_primitive(gap: float, way: float, covered: bool) -> None:
    batch = screen("Cuboid", gap).batch
    place = np.array([[FRONT, 0.0, 0.2], [FRONT, 0.1, 0.25], [FRONT, 0.25, 0.2], [FRONT, 0.0, 0.35]])
    elements, solids = elements_of(batch), Solids.of(batch.sites())
    plate = np.full(4, element(batch, elements, "plate"))
    normal = np.tile(OUT, (4, 1))
    ways = way * normal
    found, kept = hold(place, normal, ways, plate, elements, solids, np.full(4, SIZE))
    assert found.tolist() == ([0, 1] if covered else []) and np.allclose(kept, -SUNK * SIZE * OUT)
    order = np.array([2, 1, 3, 0])
    found, _ = hold(place[order], normal, ways, plate, elements, solids, np.full(4, SIZE))
    assert found.tolist() == ([1, 3] if covered else [])


@pytest.mark.parametrize(
    ("gap", "way", "left"),
    [
        (-0.001, -0.003, 0.0),  # into the plate, of which it lies 1 mm before already
        (0.004, -0.008, -(0.006 - SUNK * SIZE)),  # down to the least distance
        (0.004, -0.004, -0.004),
        (0.004, 0.003, 0.003),
    ],
)
def test_what_lies_over_another_does_not_sink_into_it(gap: float, way: float, left: float) -> None:
    batch = screen("Cuboid", gap).batch
    elements, solids = elements_of(batch), Solids.of(batch.sites())
    pane, place = np.array([element(batch, elements, "pane")]), np.array([[FRONT + gap + 0.002, 0.0, 0.2]])
    asked = place, OUT[None], way * OUT[None], pane, elements, solids, np.array([SIZE])
    found, kept = hold(*asked)
    assert len(found) == (left != way) and np.allclose(kept, left * OUT, atol=1e-6)


def test_what_covers_a_place_is_where_it_has_been_moved() -> None:
    """A plate comes out by 3 mm beneath a pane that goes as far, and not beneath one that stays."""
    batch = screen("Cuboid", 0.004).batch
    elements, solids = elements_of(batch), Solids.of(batch.sites())
    both = np.array([element(batch, elements, name) for name in ("plate", "pane")])
    place = np.array([[FRONT, 0.0, 0.2], [FRONT + 0.004, 0.0, 0.2]])
    for pane, held in ((0.008, False), (0.0, True)):
        ways = np.array([0.006, pane])[:, None] * OUT
        found, kept = hold(place, np.stack([OUT, -OUT]), ways, both, elements, solids, np.full(2, SIZE))
        assert (0 in found) == held


def test_what_faces_the_other_way_is_free() -> None:
    """The back of a pane that lies in its plate cannot show at the plate's front."""
    batch = screen("Cuboid", -0.001).batch
    elements, solids = elements_of(batch), Solids.of(batch.sites())
    pane = np.array([element(batch, elements, "pane")])
    place, back, way = (np.array([[x, 0.0, z]]) for x, z in ((FRONT - 0.001, 0.2), (-1.0, 0.0), (0.0008, 0.0)))
    assert not len(hold(place, back, way, pane, elements, solids, np.array([SIZE]))[0])
    assert len(hold(place, -back, way, pane, elements, solids, np.array([SIZE]))[0])


def test_a_plate_does_not_come_out_of_a_pane_that_its_original_lacks() -> None:
    plain, paned = screen("none").batch, screen("Cuboid").batch
    found = surface(plain, 8000, 3)
    points, normal = found.position[0], found.normal[0]
    mixed = np.random.default_rng(1).permutation(len(points))
    raised = Real(
        "plate", (points + RAISED * normal)[mixed], normal[mixed], np.zeros(len(points), dtype=np.int64), ("",)
    )
    details, solids = bind(plain, raised, 4000), Solids.of(plain.sites())
    wardrobe = Wardrobe(calm(Wardrobe(details, solids)), solids)
    tables = paned.sites()
    made = build_meshes(tables, edges=[np.full(len(table), 0.01) for table in tables])
    moved = displace(made, wardrobe, own_suits(paned, details.elements, np.zeros(1, dtype=int)), np.array([SIZE]))
    number = next(k for k, group in enumerate(made) if group.table.path == "plate")
    before, after = made[number].vertices[0], moved[number][0]
    front, across, along = np.isclose(before[:, 0], FRONT), np.abs(before[:, 1]), np.abs(before[:, 2] - 0.2)
    beneath = front & (across < 0.19) & (along < 0.09)
    beside = front & ((across > 0.23) | (along > 0.13)) & (across < 0.28) & (along < 0.18)
    assert beneath.sum() > 100 and np.allclose(after[beneath, 0], FRONT - SUNK * SIZE, atol=1e-4)
    assert beside.sum() > 100 and np.allclose(after[beside, 0], FRONT + RAISED, atol=1e-3)
