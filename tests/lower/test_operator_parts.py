"""What the primitives of operators are made of: names of surfaces, boxes, parameters, ports."""

import numpy as np
import pytest
from geometry.shipped import SHIPPED

from artipg_dsl.geometry import pieces
from artipg_dsl.geometry.mesh import build, moments
from artipg_dsl.graph.expr import show
from artipg_dsl.lower.solids.primitives import lower_primitive
from artipg_dsl.session import Session

from .operators import BLADE, DOME, FLASK, PLATE, TUBE, curve, load, lowered


def test_the_walls_of_holes_bear_the_names_of_their_curves_and_the_holes_are_empty():
    primitive = lowered(PLATE).primitive
    assert set(primitive.surfaces) == {"skin", "bore", "arch", "sill", "start", "end"}
    params = {"a": np.array([0.2]), "b": np.array([0.12]), "r": np.array([0.008]), "t": np.array([0.005])}
    (group,) = build(primitive, params)
    volume = moments(group.vertices, group.faces)[0]
    holes = np.pi * 0.008**2 * 1.5
    assert volume[0] == pytest.approx((0.2 * 0.12 - holes) * 0.005, rel=2e-3)


def test_surfaces_bear_the_names_of_the_curves():
    assert lowered(DOME).primitive.surfaces == ("start", "dome")
    assert lowered(FLASK).primitive.surfaces == ("base", "side", "rim", "lining", "floor")
    assert lowered(BLADE).primitive.surfaces == ("edge", "spine", "rim", "start", "end")
    assert lowered(TUBE, "neck").primitive.surfaces == ("skin", "start", "end")


def test_a_box_is_as_simple_as_it_can_be():
    primitive = lowered(DOME).primitive
    assert [show(c) for c in primitive.low] == ["-radius", "-radius", "0"]
    assert [show(c) for c in primitive.high] == ["radius", "radius", "rise"]


def test_a_path_becomes_parameters_of_the_primitive():
    found = lowered(TUBE, "neck")
    assert found.primitive.parameters == ("path.0", "path.1", "radius")
    start, end = found.ports["start"], found.ports["end"]
    assert [c.constant for c in start.out] == [0.0, 0.0, -1.0]
    assert [round(c.constant, 9) for c in end.out] == [0.0, 0.0, -1.0]


def test_paths_of_one_shape_share_a_primitive():
    context, module = load(TUBE)
    tube = module.find("Tube")
    first, second, third = (
        lower_primitive(context, tube, {"path": curve(context, module, name)}) for name in ("neck", "other", "bow")
    )
    assert first is second and third is not first
    assert list(context.program.primitives) == ["Tube", "Tube_2"]


def test_two_shapes_of_path_are_two_primitives():
    """A straight bar and a bent one in one object: each site has the formulas of its own."""
    text = """
    use bars { Tube }
    category Bent {
      root part one : Half
      part other : Whole
      connect other to one
    }
    template Half {
      curve way = from([0, 0, 0], x) line(10cm) arc(radius = 5cm, angle = 90deg, towards = z)
      part bar : Tube(path = way, radius = 1cm)
    }
    template Whole {
      param long : length in 20cm .. 30cm = 25cm
      param rise : length in 10cm .. 20cm = 15cm
      curve way = from([0, 0, 0], x) line(long) arc(radius = 5cm, angle = 90deg, towards = z) line(rise)
      part bar : Tube(path = way, radius = 1cm)
    }
    """
    batch = Session.of_text("apg 1\n" + text).sampler.batch(range(2), 0)
    half, whole = batch.sites()
    assert half.primitive.name != whole.primitive.name
    assert len(half.params) == len(half.primitive.parameters) < len(whole.params) == len(whole.primitive.parameters)


def test_pieces_of_a_shallow_dish_lie_within_its_walls():
    """Where its floor meets its flank, the line that closes a step hardly leaves the bore."""
    dish = {
        "foot": 44.24e-3,
        "mouth": 62.24e-3,
        "height": 12e-3,
        "heel": 5e-3,
        "low": 3e-3,
        "wall": 3e-3,
        "ground": 3e-3,
    }
    for group in pieces.build(SHIPPED["CupShell"], {name: np.array([value]) for name, value in dish.items()}):
        assert np.hypot(*group.vertices[..., :2].T).max() < 62.3e-3
        assert group.vertices[..., 2].min() > -1e-9 and group.vertices[..., 2].max() < 12e-3 + 1e-9
