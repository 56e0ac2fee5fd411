"""The operators make primitives that pass the self-test. ``ARTIPG_EVERY=1`` takes more sections along winding paths."""

import os

import numpy as np
import pytest

from artipg_dsl.geometry.box import bounds
from artipg_dsl.geometry.mesh import build, moments
from artipg_dsl.geometry.split import rows_of
from artipg_dsl.geometry.surface import evaluate
from artipg_dsl.geometry.trial import draw_trial
from artipg_dsl.graph.formula import compile_formula
from artipg_dsl.lower.solids import loft
from artipg_dsl.lower.solids.numbered import Bays, numbered
from artipg_dsl.lower.solids.profiles import SLOPE
from tests.geometry.selftest import check_primitive

from .operators import (
    ARCH,
    BALUSTER,
    BAR,
    BEND,
    BLADE,
    CHANNEL,
    COLUMN,
    DISC,
    DOME,
    DUCT,
    FLASK,
    HANDLE,
    HOOK,
    HORN,
    LEVER,
    PIPE,
    PLATE,
    PLINTH,
    RAM,
    RIBBON,
    ROD,
    SADDLE,
    SHOULDER,
    SIDEWAYS,
    SLAB,
    SPACE,
    SPIRAL,
    SPRING,
    STRAP,
    TUBE,
    TUSK,
    UPRIGHT,
    VASE,
    lowered,
)

EVERY = os.environ.get("ARTIPG_EVERY") == "1"
WINDING = [SPIRAL, TUSK]
ALIKE = [RAM, LEVER, RIBBON, SPRING, STRAP, SIDEWAYS, UPRIGHT, SADDLE]  # other sections along paths of the same kinds


@pytest.mark.parametrize("text", WINDING + [SPACE, *ALIKE] * EVERY, ids=lambda text: text.split()[1].lower())
def test_any_path_takes_any_section(text):
    """In every plane and in space, along `up` and without, over several turns, along formulas."""
    assert check_primitive(lowered(text).primitive, samples=1) == []


def test_an_end_of_a_path_may_be_nearer_than_a_foot_beside_it():
    """Beyond the centre of curvature at an end, where the distance along the path falls and rises within one cut."""
    rod = LEVER.replace("loft(rectangle(2 * w, 3 * w), rectangle(4 * w, w))", "sweep(circle(w))")
    primitive = lowered(rod).primitive
    r, w = 0.04, 0.002
    across, along, up = np.meshgrid(np.linspace(0.5, 1.1, 13), np.linspace(-0.1, 0.1, 9), np.linspace(0.3, 0.8, 11))
    points = r * np.stack([across.ravel(), along.ravel(), up.ravel()], axis=-1)
    t = np.linspace(0.0, np.pi, 20001)
    path = r * np.stack([np.cos(t), np.sin(t), np.sin(t) ** 2], axis=-1)
    expected = np.array([np.sqrt(((path - p) ** 2).sum(axis=-1)).min() for p in points])
    formula = compile_formula((primitive.inside,), (*primitive.parameters, "p.x", "p.y", "p.z"))
    found = formula(r, w, *points.T)[0] / SLOPE.constant + w
    assert found == pytest.approx(expected, rel=1e-3)


@pytest.mark.some
@pytest.mark.parametrize(
    "text",
    [CHANNEL, PLINTH, BEND, DUCT, HORN, HOOK, BALUSTER, SHOULDER, HANDLE, SLAB, VASE, COLUMN],
    ids=lambda text: text.split()[1].lower(),
)
def test_sections_and_outlines_pass_the_self_test(text):
    findings = check_primitive(lowered(text).primitive, samples=2)
    assert findings == []


@pytest.mark.some
@pytest.mark.parametrize(
    ("text", "curves"), [(BALUSTER, 1), (SHOULDER, 1), (HANDLE, 4)], ids=["circles", "ovals", "corners"]
)
def test_a_smooth_loft_has_no_kink_and_reaches_no_further_than_its_sections(text, curves):
    """The normals on both sides of a section agree, which they do not without the word; the box is that of the sections."""
    kinks, boxes = [], []
    for way in (text, text.replace(" smooth", "")):
        primitive = lowered(way).primitive
        params = draw_trial(primitive, 6)
        walls = [k for k, patch in enumerate(primitive.patches) if patch.name not in ("start", "end")]
        row, u = np.repeat(np.arange(rows_of(params)), 9), np.tile(np.linspace(0.0, 1.0, 9), rows_of(params))
        turns = [0.0]
        for low, high in zip(walls, walls[curves:], strict=False):
            below, above = (
                evaluate(primitive, k, params, row, u, np.full_like(u, v))[1] for k, v in ((low, 1.0), (high, 0.0))
            )
            turns.append(np.sqrt(((above - below) ** 2).sum(axis=-1)).max())
        kinks.append(max(turns))
        boxes.append(np.stack(bounds(primitive, params)))
    assert kinks[0] < 1e-6 and kinks[1] > 0.1
    assert boxes[0] == pytest.approx(boxes[1], abs=1e-12)


@pytest.mark.parametrize("name", ["bay", "section"])
def test_a_parameter_may_be_called_what_a_solid_is_made_of(name):
    solid = f"""
primitive Pot {{
  param {name} : length > 0  test 2cm .. 4cm
  curve foot (u in 0turn .. 1turn) = [{name} * cos(u), 0.8 * {name} * sin(u)]
  curve rim  (u in 0turn .. 1turn) = [0.9 * {name} * cos(u), {name} * sin(u)]
  solid = loft(foot, rim, foot) along z at [0mm, {name}, 3 * {name}]
}}
"""
    assert check_primitive(lowered(solid).primitive, samples=1) == []


@pytest.mark.some
@pytest.mark.parametrize(
    ("text", "groups"),
    [(VASE, 1), (BALUSTER, 1), (SHOULDER, 1), (COLUMN, 3)],
    ids=["vase", "circles", "ovals", "column"],
)
def test_bays_that_differ_in_numbers_are_one_formula_of_the_same_solid(text, groups, monkeypatch):
    """What is inside, and how deep, is the same as with a formula of its own for each bay. Outside, what tells how far it is at least may
    be another number, but has to hold: nothing is nearer than it says."""
    found = []
    monkeypatch.setenv("APGC_CACHE", "off")
    monkeypatch.setattr(loft, "numbered", lambda bays: found.append(numbered(bays)) or found[-1])
    together = lowered(text).primitive
    assert len(found[0]) == groups
    monkeypatch.setattr(loft, "numbered", lambda bays: [Bays((bay,), bay) for bay in bays])
    apart = lowered(text).primitive
    params = draw_trial(together, 40)
    low, high = bounds(together, params)
    rows = np.repeat(np.arange(40), 400)
    share = np.random.default_rng(1).uniform(-0.2, 1.2, (len(rows), 3))
    points = low[rows] + share * (high - low)[rows]
    one, other = (depth(primitive, params, rows, points) for primitive in (together, apart))
    inside = other < 0
    assert inside.mean() > 0.05 and (~inside).mean() > 0.05
    assert one[inside] == pytest.approx(other[inside], rel=1e-3, abs=1e-9)  # steps of Newton's method begin elsewhere
    assert (one[~inside] >= 0.999 * other[~inside] - 1e-9).all()
    for primitive in (together, apart):  # a step as long as is said leads nowhere inside
        away = np.random.default_rng(2).normal(size=points.shape)
        away *= (np.abs(one) / np.sqrt((away**2).sum(axis=-1)))[:, None]
        assert (depth(primitive, params, rows, points + 0.999 * away)[one > 1e-9] > -1e-9).all()


def depth(primitive, params, rows, points):
    formula = compile_formula((primitive.inside,), (*primitive.parameters, "p.x", "p.y", "p.z"))
    return formula(*(params[name][rows] for name in primitive.parameters), *points.T)[0]


def test_a_circle_between_rectangles_is_cut_into_arcs_that_close():
    primitive = lowered(PLINTH.replace("rectangle(b, a)", "circle(b)")).primitive
    assert primitive.surfaces == ("skin", "start", "end") and len(primitive.patches) == 16
    (group,) = build(primitive, draw_trial(primitive, 2))
    volume = moments(group.vertices, group.faces)[0]
    assert (volume > 0).all() and group.vertices.shape[1] > 24


@pytest.mark.parametrize(
    ("text", "path"),
    [(DOME, None), (FLASK, None), (BLADE, None), (ROD, None), (BAR, None), (ARCH, None), (TUBE, "neck"), (PIPE, "bow")],
    ids=["dome", "flask", "blade", "rod", "bar", "arch", "tube", "pipe"],
)
def test_the_self_test_finds_nothing(text, path):
    assert check_primitive(lowered(text, path).primitive, samples=2) == []


@pytest.mark.parametrize("text", [PLATE, DISC], ids=["plate", "disc"])
def test_an_outline_has_any_number_of_holes(text):
    assert check_primitive(lowered(text).primitive, samples=1) == []
