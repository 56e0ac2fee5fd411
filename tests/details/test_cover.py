"""What another primitive of an object covers stays beneath it, whatever its original was like."""

from __future__ import annotations

import numpy as np
import pytest

import artipg_dsl as apg
from artipg_dsl.api import Samples
from artipg_dsl.details.binding import Real, bind
from artipg_dsl.details.calm import calm
from artipg_dsl.details.cover import SUNK, find_covered
from artipg_dsl.details.displace import displace
from artipg_dsl.details.elements import Solids, elements_of
from artipg_dsl.details.suits import own_suits
from artipg_dsl.details.wear import Wardrobe
from artipg_dsl.export.solids import build_meshes

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
    plate = np.full(4, [batch.program.parts[batch.program.sites[k].part].path for k in elements.site].index("plate"))
    normal = np.tile([1.0, 0.0, 0.0], (4, 1))
    ways = way * normal
    found = find_covered(place, normal, ways, plate, elements, solids, np.full(4, SIZE))
    assert found.tolist() == ([0, 1] if covered else [])
    order = np.array([2, 1, 3, 0])
    assert find_covered(place[order], normal, ways, plate, elements, solids, np.full(4, SIZE)).tolist() == (
        [1, 3] if covered else []
    )


def test_what_faces_the_other_way_is_free() -> None:
    """The back of a pane that lies in its plate cannot show at the plate's front."""
    batch = screen("Cuboid", -0.001).batch
    elements, solids = elements_of(batch), Solids.of(batch.sites())
    pane = np.array([[batch.program.parts[batch.program.sites[k].part].path for k in elements.site].index("pane")])
    place, back, way = (np.array([[x, 0.0, z]]) for x, z in ((FRONT - 0.001, 0.2), (-1.0, 0.0), (0.0008, 0.0)))
    assert not len(find_covered(place, back, way, pane, elements, solids, np.array([SIZE])))
    assert len(find_covered(place, -back, way, pane, elements, solids, np.array([SIZE])))


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
