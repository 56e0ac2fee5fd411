"""Materials: what of their ranges an object draws, from the text to the mass; the shipped ones have real values."""

from __future__ import annotations

import numpy as np
import pytest

from artipg_dsl import load
from artipg_dsl.resources import library_dir
from artipg_dsl.robot.materials import resolve_materials
from artipg_dsl.robot.robots import Robots
from artipg_dsl.session import Session
from artipg_dsl.validity.materials import RANGES, draw_property

TEXT = """apg 1
use primitives { Cuboid }
use vocabularies { semantic }
material ash {
  density 600kg/m3 .. 750kg/m3  static_friction 0.4 .. 0.6  dynamic_friction 0.3 .. 0.5  restitution 0.2 .. 0.4
  colour [0.7, 0.6, 0.5]  metalness 0  roughness 0.5 .. 0.7  transparency 0.1
}
category Block {
  root part body : Cuboid(size = [10cm, 20cm, 30cm])
  part lid : Cuboid(size = [_, _, 1cm])
  connect lid.bottom on body.top fit front, back, left, right
  material ash on body
  label semantic.body on body
  label semantic.lid on lid
}
"""


def test_every_object_draws_from_the_ranges() -> None:
    batch = load(TEXT, n=400, seed=3).batch
    ash = batch.program.materials["ash"]
    assert ash.density == (600.0, 750.0) and ash.roughness == (0.5, 0.7) and ash.transparency == (0.1, 0.1)
    for name in RANGES:
        low, high = getattr(ash, name)
        values = draw_property(batch, ash, name)
        assert values.shape == (400,) and (values >= low).all() and (values <= high).all()
        if low < high:
            shares = np.sort((values - low) / (high - low))
            uniform = (np.arange(400) + 0.5) / 400
            assert np.abs(shares - uniform).max() < 0.08  # Kolmogorov: 1 % of samples of 400 exceed 0.081
    assert (draw_property(batch, ash, "friction_dynamic") < draw_property(batch, ash, "friction_static")).all()
    density, roughness = draw_property(batch, ash, "density"), draw_property(batch, ash, "roughness")
    assert abs(np.corrcoef(density, roughness)[0, 1]) < 0.15


def test_a_draw_belongs_to_object_and_material_alone() -> None:
    whole, one = load(TEXT, n=9, seed=3).batch, load(TEXT, n=9, seed=3).object(7).batch
    ash = whole.program.materials["ash"]
    for name in RANGES:
        assert draw_property(whole, ash, name)[7] == draw_property(one, ash, name)[0]
    assert (draw_property(load(TEXT, n=9, seed=4).batch, ash, "density") != draw_property(whole, ash, "density")).all()


def test_mass_friction_and_looks_follow() -> None:
    batch = load(TEXT, n=4, seed=3).batch
    robots = Robots(batch)
    ash = batch.program.materials["ash"]
    for i, material in enumerate(resolve_materials(batch, ash)):
        (link,) = robots.robot(i).links
        expected = 0.1 * 0.2 * (0.3 * draw_property(batch, ash, "density")[i] + 0.01 * 700)
        assert link.mass == pytest.approx(expected, rel=1e-9)
        body = next(c.material for c in link.colliders if c.material.name == "ash")
        assert all(getattr(body, name) == getattr(material, name) for name in RANGES)
        assert body.friction_static[0] == body.friction_static[1]
        look = next(v.look for v in link.visuals if v.look.name == "ash")
        assert look.roughness == draw_property(batch, ash, "roughness")[i] and look.opacity == pytest.approx(0.9)


def test_parts_without_a_material_are_named() -> None:
    session = Session.of_text(TEXT)
    session.advise()
    (found,) = session.report.diagnostics
    assert (found.code, found.severity) == ("missing-material", "warning")
    assert found.span is not None and found.span.text == "lid"
    assert "`lid`" in found.message and "`body`" not in found.message and "700 kg/m3" in (found.hint or "")
    whole = Session.of_text(TEXT.replace("material ash on body", "material ash on body, lid"))
    whole.advise()
    assert not whole.report.diagnostics


# kg/m3, of handbooks: solids as they are used
REAL = {
    "steel": (7750, 8050),
    "stainless": (7480, 8000),
    "aluminium": (2640, 2840),
    "brass": (8400, 8730),
    "glass": (2400, 2800),
    "white_plastic": (1020, 1080),
    "oak": (600, 900),
    "pine": (400, 600),
    "rubber": (1100, 1250),
    "ceramic": (2200, 2600),
}


def test_shipped_materials_have_real_values() -> None:
    text = (library_dir() / "materials.apg").read_text()
    names = [line.split()[1] for line in text.splitlines() if line.startswith("material ")]
    program = (
        f"apg 1\nuse primitives {{ Cuboid }}\nuse materials {{ {', '.join(names)} }}\ncategory All {{\n"
        f"  style look : material = {' | '.join(names)}\n"
        f"  root part body : Cuboid(size = [1cm, 1cm, 1cm])\n  material look on body\n}}\n"
    )
    made = load(program, n=1).batch.program.materials
    assert set(made) == set(names) and set(REAL) <= set(names)
    for name, material in made.items():
        low, high = REAL.get(name, (50, 9000))
        assert low <= material.density[0] <= material.density[1] <= high, name
        assert all(s > d > 0 for s, d in zip(material.friction_static, material.friction_dynamic, strict=True)), name
        for field in ("restitution", "metalness", "roughness", "transparency"):
            values = getattr(material, field)
            assert 0 <= values[0] <= values[1] <= 1, (name, field)
        assert all(0 <= c <= 1 for colour in material.colour for c in colour)
