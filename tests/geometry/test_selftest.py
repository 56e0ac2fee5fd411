"""The self-test passes honest primitives and names what is wrong with broken ones."""

import pytest

from artipg_dsl.graph.expr import const, maximum, wrap
from artipg_dsl.graph.primitive import Piece

from . import shapes
from .selftest import check_primitive


@pytest.mark.parametrize("make", shapes.ALL)
def test_honest_primitives_pass(make):
    assert check_primitive(make()) == []


def faults(primitive):
    return {(f.check, f.surface) for f in check_primitive(primitive)}


def test_a_missing_cap_leaks():
    whole = shapes.cylinder()
    (finding,) = check_primitive(shapes.cylinder(patches=whole.patches[:2]))
    assert (finding.check, finding.surface) == ("closed", "side")
    assert "edge v start meets no other edge" in finding.message and "leaks" in str(finding)


def test_a_flipped_box_and_a_wrong_box():
    whole = shapes.cuboid()
    assert faults(shapes.cuboid(low=whole.high, high=whole.low)) == {("box", None)}
    tight = tuple(h * 0.9 for h in whole.high)
    assert faults(shapes.cuboid(high=(tight[0], *whole.high[1:]))) == {("box", "front")}
    loose = (whole.high[0] * 1.2, *whole.high[1:])
    (finding,) = check_primitive(shapes.cuboid(high=loose))
    assert "too wide at high x" in finding.message


def test_a_wrong_inside_function():
    x, y, z = shapes.size()
    sides = (shapes.abs_(shapes.PY) - y / 2, shapes.abs_(shapes.PZ) - z / 2)
    assert ("inside", "front") in faults(shapes.cuboid(inside=maximum(shapes.abs_(shapes.PX) - x * 0.45, *sides)))
    (finding,) = check_primitive(shapes.cuboid(inside=-shapes.cuboid().inside))
    assert finding.check == "inside" and "negative far outside the solid" in finding.message


def test_an_inside_function_that_is_off_by_a_little():
    cylinder = shapes.cylinder()
    shifted = faults(shapes.cylinder(inside=cylinder.inside + shapes.var("height") * 1e-5))
    assert {c for c, _ in shifted} == {"inside"}
    steep = faults(shapes.cylinder(inside=cylinder.inside * 3.0))
    assert steep == {("slope", None)}


def test_an_inside_function_that_fills_a_hole():
    """Right on every surface of the ring but full in the middle of the bore."""
    ring = shapes.hollow_frustum()
    core = shapes.hypot(shapes.PX, shapes.PY) - shapes.minimum(shapes.var("bore"), shapes.var("top_bore")) * 0.9
    plug = maximum(core, shapes.abs_(shapes.PZ) - shapes.var("height") / 2)
    wide = ((0.05, 0.1), (0.05, 0.1), (0.03, 0.04), (0.03, 0.04), (0.01, 0.2), (6.0, shapes.TURN))
    assert check_primitive(shapes.hollow_frustum(test=wide)) == []
    assert ("volume", None) in faults(shapes.hollow_frustum(test=wide, inside=shapes.minimum(ring.inside, plug)))


def test_pieces_that_stick_out_or_leave_gaps():
    sleeve = shapes.sleeve()
    assert faults(shapes.sleeve(pieces=())) == {("pieces", "hull")}
    assert faults(shapes.sleeve(pieces=sleeve.pieces[:1])) == {("pieces", None)}
    wall = sleeve.pieces[0]
    bent = Piece("wall_y", tuple((wrap(p[0]) * 1.1, p[1], p[2]) for p in wall.points), wall.count)
    (finding,) = check_primitive(shapes.sleeve(pieces=(bent, sleeve.pieces[1])))
    assert finding.check == "pieces" and finding.surface in ("wall_y[0]", "wall_y[1]")


def test_test_ranges_that_cannot_be_met():
    never = shapes.call("lt", shapes.size()[0], const(0.0))
    (finding,) = check_primitive(shapes.cuboid(requires=(never,)))
    assert "meet its requirements" in finding.message


def test_a_solid_that_is_a_skin_around_its_surfaces():
    """Inside is what lies around the box, not what it encloses: every surface is turned inwards."""
    box = shapes.cuboid().inside
    found = check_primitive(shapes.cuboid(inside=maximum(-box, box - const(0.01))))
    (message,) = (f.message for f in found if f.check == "volume")
    assert "the surfaces enclose what is outside by the inside function" in message
