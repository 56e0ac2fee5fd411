"""What may be handed in: planes are their coordinate where a number is wanted."""

from __future__ import annotations

import numpy as np
import pytest

import artipg_dsl
from artipg_dsl.session import Session

HEAD = "apg 1\nuse primitives { Cuboid, Cylinder }\n"


@pytest.mark.parametrize(
    ("given", "height"),
    [("9cm - a.top", 0.07), ("a.top", 0.02), ("0 - a.bottom", 0.02), ("a.top + a.top", 0.04), ("-a.bottom", 0.02)],
)
@pytest.mark.parametrize("template", [False, True], ids=["primitive", "template"])
def test_a_plane_is_its_coordinate(given: str, height: float, template: bool) -> None:
    made = f"Post(reach = {given} + 1cm)" if template else f"Cylinder(radius = 1cm, height = {given})"
    session = Session.of_text(
        f"{HEAD}template Post {{\n  param reach : length\n  part rod : Cuboid(size = [1cm, 1cm, reach - 1cm])\n}}\n"
        "category T {\n  root part a : Cuboid(size = [4cm, 4cm, 4cm])\n"
        f"  part b : {made}\n  connect b.bottom on a.top\n}}\n"
    )
    assert session.lowering is not None, session.report.diagnostics
    parts = session.sampler.batch(np.arange(1), seed=0).parts()
    place = parts.path.index("b")
    assert parts.high[place, 2] - parts.low[place, 2] == pytest.approx(height)


def test_an_option_may_depend_on_a_condition() -> None:
    made = artipg_dsl.load(
        f"{HEAD}template Tray {{\n  param shape : choice low | high | middle\n"
        "  when shape == low { part body : Cuboid(size = [1cm, 1cm, 1cm]) }\n"
        "  else when shape == high { part tall : Cuboid(size = [1cm, 1cm, 9cm]) }\n"
        "  else { part mean : Cuboid(size = [1cm, 1cm, 4cm]) }\n}\n"
        "category T {\n  param other : choice low | high | middle\n  count n in 1 .. 3\n"
        "  root part a : Tray(shape = low if n == 1 else high if n == 2 else other)\n}\n",
        n=40,
    )
    parts, heights = made.parts(), {"low": 0.01, "high": 0.09, "middle": 0.04}
    drawn = [made["other"][i] if made["n"][i] == 3 else ("low", "high")[int(made["n"][i]) - 1] for i in range(40)]
    assert set(drawn) == set(heights)
    for owner, path, low, high in zip(parts.owner, parts.path, parts.low, parts.high, strict=True):
        assert "." not in path or high[2] - low[2] == pytest.approx(heights[drawn[owner]])


def test_a_vec_is_drawn_or_has_a_default_like_other_vectors() -> None:
    made = artipg_dsl.load(
        f"{HEAD}template Post {{\n  param lean : vec = [0, 0, 3]\n  part rod : Cuboid(size = [1cm, 1cm, lean.z * 1cm])\n}}\n"
        "category T {\n  param way : vec in [0, 0, 1] .. [0, 0, 2]\n  root part a : Cuboid(size = [4cm, 4cm, way.z * 1cm])\n"
        "  part b : Post\n  connect b.rod.bottom on a.top\n}\n",
        n=20,
    )
    parts = made.parts()
    heights = {p: (parts.high - parts.low)[[q == p for q in parts.path], 2] for p in ("a", "b.rod")}
    assert heights["b.rod"] == pytest.approx(0.03)
    assert (
        heights["a"] == pytest.approx(made["way.z"] * 0.01) and 0.01 <= heights["a"].min() < heights["a"].max() <= 0.02
    )
