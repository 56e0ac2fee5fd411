"""Areas, uniform placing and exact normals."""

import math

import numpy as np
import pytest

from artipg_dsl import random
from artipg_dsl.geometry import density, mesh, surface
from artipg_dsl.geometry.patches import find_existing, surfaces
from artipg_dsl.geometry.split import Split
from artipg_dsl.geometry.trial import draw_trial
from artipg_dsl.graph.expr import const, raw, var
from artipg_dsl.graph.formula import compile_formula

from . import shapes
from .shipped import SHIPPED


def inside_of(primitive, params, row, points):
    formula = compile_formula((primitive.inside,), (*primitive.parameters, "p.x", "p.y", "p.z"))
    return formula(*(params[n][row] for n in primitive.parameters), *points.T)[0]


@pytest.mark.parametrize("make", shapes.ALL)
def test_areas_agree_with_a_fine_mesh(make):
    primitive = make()
    params = draw_trial(primitive, 8)
    found = surface.areas(primitive, params)
    for group in mesh.build(primitive, params, steps=192):
        corners = group.vertices[:, group.faces]
        cross = np.cross(corners[:, :, 1] - corners[:, :, 0], corners[:, :, 2] - corners[:, :, 0])
        area = np.sqrt((cross**2).sum(axis=-1)) / 2
        for patch in range(found.shape[1]):
            expected = area[:, group.face_patch == patch].sum(axis=1)
            assert np.allclose(found[group.rows, patch], expected, rtol=2e-3)


def test_exact_areas():
    params = {"radius": np.array([0.3]), "top_radius": np.array([0.1]), "height": np.array([0.5])}
    side, top, bottom = surface.areas(shapes.cylinder(), params)[0]
    assert math.isclose(side, math.pi * 0.4 * math.hypot(0.2, 0.5), rel_tol=1e-13)
    assert math.isclose(top, math.pi * 0.01, rel_tol=1e-13) and math.isclose(bottom, math.pi * 0.09, rel_tol=1e-13)
    params = {
        n: np.array([value]) for n, value in zip(("size.x", "size.y", "size.z", "radius"), (1, 1, 1, 0.1), strict=True)
    }
    corners = surface.areas(shapes.rounded_cuboid(), params)[0][-8:]
    assert np.allclose(corners, math.pi / 2 * 0.01, rtol=1e-12)


def test_area_elements_are_classified():
    nodes = [density.kind(shapes.cylinder(), p).nodes for p in range(3)]
    assert nodes == [(1, 2), (2, 1), (2, 1)]
    rounded = shapes.rounded_cuboid()
    assert density.kind(rounded, 0).nodes == (1, 1)
    corner = density.kind(rounded, len(rounded.patches) - 1)
    assert corner.profile is not None and corner.nodes[0] == 1
    skin = density.kind(shapes.torus_sector(), 0)
    assert skin.profile is None and skin.nodes[0] > 2 and skin.nodes[1] == 1


def saddle():
    """A cuboid whose top is replaced by two wave-shaped sheets: an element that bends along both directions."""
    wave = const(0.2) * shapes.sin(shapes.U * 3.0) * shapes.cos(shapes.V * 2.0)
    position = (shapes.U - 0.5, (shapes.V - 0.5) * var_size(), wave)
    back = (shapes.U - 0.5, (const(0.5) - shapes.V) * var_size(), wave)
    inside = shapes.PZ - const(0.2) * shapes.sin((shapes.PX + 0.5) * 3.0) * shapes.cos(
        (shapes.PY / var_size() + 0.5) * 2.0
    )
    return shapes.cuboid(patches=(shapes.patch("wave", position), shapes.patch("back", back)), inside=inside)


def var_size():
    return shapes.size()[1]


@pytest.mark.parametrize("make", (*shapes.ALL, saddle))
def test_placing_is_uniform_by_area(make):
    primitive = make()
    params = {name: value[:1] for name, value in draw_trial(primitive, 4).items()}
    count, cells = 40_000, 10
    first, second = random.pair(random.key(11, primitive.name), np.arange(count))
    row = np.zeros(count, dtype=np.int64)
    for patch in range(len(surfaces(primitive))):
        if surface.areas(primitive, params)[0, patch] == 0.0:
            continue
        u, v = surface.place(primitive, patch, params, row, first, second)
        assert u.min() >= 0 and v.min() >= 0 and u.max() <= 1 and v.max() <= 1
        fine = (np.arange(cells * 16) + 0.5) / (cells * 16)
        element = density.grid(density.element_split(primitive, patch), params, *np.meshgrid(fine, fine, indexing="ij"))
        expected = element[0, ..., 0].reshape(cells, 16, cells, 16).sum(axis=(1, 3))
        expected *= count / expected.sum()
        counts = np.histogram2d(u, v, cells, ((0, 1), (0, 1)))[0]
        big = expected > 8
        chi = ((counts - expected)[big] ** 2 / expected[big]).sum()
        assert chi < big.sum() + 6 * math.sqrt(2 * big.sum()), surfaces(primitive)[patch].name


@pytest.mark.parametrize("make", shapes.ALL)
def test_normals_are_unit_and_point_outwards_everywhere(make):
    primitive = make()
    params = draw_trial(primitive, 5)
    count = len(params[""])
    ends = np.array([0.0, 1e-9, 0.3, 0.7, 1.0])
    u, v = (a.ravel() for a in np.meshgrid(ends, ends))
    rows, us, vs = np.repeat(np.arange(count), len(u)), np.tile(u, count), np.tile(v, count)
    there = surface.areas(primitive, params) > 0
    for patch in range(there.shape[1]):
        kept = there[rows, patch]
        position, normal = surface.evaluate(primitive, patch, params, rows[kept], us[kept], vs[kept])
        assert np.allclose((normal**2).sum(axis=-1), 1.0, atol=1e-12)
        size = np.abs(position).max()
        far = 1e-5 * size
        assert (inside_of(primitive, params, rows[kept], position + far * normal) > -1e-3 * far).all()


def test_the_normal_of_a_sphere_octant_is_its_radius():
    primitive = shapes.rounded_cuboid()
    params = {
        n: np.array([value]) for n, value in zip(("size.x", "size.y", "size.z", "radius"), (1, 1, 1, 0.1), strict=True)
    }
    u = np.linspace(0, 1, 50)
    row = np.zeros(50, dtype=np.int64)
    for patch, (sx, sy, sz) in zip(
        range(18, 26), np.array(np.meshgrid([1, -1], [1, -1], [1, -1], indexing="ij")).reshape(3, -1).T, strict=True
    ):
        position, normal = surface.evaluate(primitive, patch, params, row, u, u[::-1])
        assert np.allclose(normal, (position - 0.4 * np.array([sx, sy, sz])) / 0.1, atol=1e-12)


@pytest.mark.parametrize("name", ["HoledPlate", "EllipsoidZone", "SlitPlate", "Ellipsoid", "Torus", "Cylinder"])
def test_normals_at_edges_are_those_slightly_further_in(name):
    """Where an edge is a point, or the end of a sickle, rounding tells no normal: it was the opposite one, too."""
    primitive, fractions = SHIPPED[name], np.array([0.0, 1e-12, 0.13, 0.5, 0.77, 1.0 - 1e-12, 1.0])
    params = draw_trial(primitive)
    there = find_existing(primitive, params)
    u, v = (a.ravel() for a in np.meshgrid(fractions, fractions, indexing="ij"))
    inner = [np.clip(f, 1e-5, 1.0 - 1e-5) for f in (u, v)]
    for patch in range(there.shape[1]):
        row = np.repeat(np.flatnonzero(there[:, patch]), len(u))
        at, within = (
            surface.evaluate(primitive, patch, params, row, *(np.resize(f, len(row)) for f in fs))[1]
            for fs in ((u, v), inner)
        )
        assert np.abs(at - within).max(initial=0.0) < 1e-3


def test_powers_of_a_row_are_the_same_alone_and_among_others():
    split = Split.of(shapes.cylinder(), (raw("pow", (var("p.x"), var("radius"))),), ("p.x",))
    x = np.random.default_rng(1).uniform(0, 3, (2, 400))
    exponents = np.array([[2.0], [0.5]])  # which NumPy has shorter ways for
    both = split.points([exponents], x)[0]
    for row in range(2):
        alone = split.points([exponents[row : row + 1]], x[row : row + 1])[0]
        assert alone.tobytes() == both[row : row + 1].tobytes()
