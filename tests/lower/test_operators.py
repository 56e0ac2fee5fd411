"""The operators make primitives that pass the self-test. ``ARTIPG_EVERY=1`` takes more sections along winding paths."""

import os

import numpy as np
import pytest

from artipg_dsl.geometry.box import bounds
from artipg_dsl.geometry.mesh import build, moments
from artipg_dsl.geometry.patches import rows_of
from artipg_dsl.geometry.selftest import check_primitive
from artipg_dsl.geometry.surface import evaluate
from artipg_dsl.geometry.trial import draw_trial
from artipg_dsl.graph.formula import compile_formula
from artipg_dsl.lower.solids.profiles import SLOPE

from .operators import (
    ARCH,
    BALUSTER,
    BAR,
    BEND,
    BLADE,
    CHANNEL,
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


@pytest.mark.parametrize(
    "text",
    [CHANNEL, PLINTH, BEND, DUCT, HORN, HOOK, BALUSTER, SHOULDER, HANDLE, SLAB],
    ids=lambda text: text.split()[1].lower(),
)
def test_sections_and_outlines_pass_the_self_test(text):
    findings = check_primitive(lowered(text).primitive, samples=2)
    assert findings == []


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
