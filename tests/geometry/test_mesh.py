"""Meshes: closed by index, outward, exact where the shape is, and the same bits in any batch."""

import math

import numpy as np
import pytest
import trimesh

from artipg_dsl.geometry import box, mesh
from artipg_dsl.geometry.errors import PrimitiveError
from artipg_dsl.geometry.topology import topology
from artipg_dsl.geometry.trial import draw_trial, variants
from artipg_dsl.graph.expr import const

from . import shapes


def params_of(primitive, rows=40):
    return draw_trial(primitive, rows)


@pytest.mark.parametrize("make", shapes.ALL)
def test_meshes_are_closed_and_outward(make):
    primitive = make()
    params = params_of(primitive)
    seen = 0
    for group in mesh.build(primitive, params):
        seen += len(group.rows)
        assert group.faces.dtype == np.int32 and len(group.faces) == len(group.face_patch)
        for vertices in group.vertices[:3]:
            solid = trimesh.Trimesh(vertices, group.faces, process=False)
            assert solid.is_watertight and solid.is_winding_consistent and solid.volume > 0
    assert seen == len(params[""])


@pytest.mark.parametrize("make", shapes.ALL)
def test_moments_agree_with_trimesh(make):
    primitive = make()
    params = params_of(primitive, 6)
    volume, centre, inertia = mesh.volume_inertia(primitive, params)
    for group in mesh.build(primitive, params):
        for row, vertices in list(zip(group.rows, group.vertices, strict=True))[:4]:
            solid = trimesh.Trimesh(vertices * 10, group.faces, process=False)
            scale = np.ptp(vertices, axis=0).max()
            assert math.isclose(volume[row], solid.volume / 1e3, rel_tol=1e-9)
            assert np.allclose(centre[row], solid.center_mass / 10, atol=1e-9 * scale)
            assert np.allclose(inertia[row], solid.moment_inertia / 1e5, atol=1e-7 * volume[row] * scale**2)


def test_exact_volumes_and_inertia_of_a_cuboid():
    sides = np.array([[0.1, 0.2, 0.3], [1.0, 0.01, 0.5]])
    params = dict(zip(("size.x", "size.y", "size.z"), sides.T, strict=True))
    volume, centre, inertia = mesh.volume_inertia(shapes.cuboid(), params)
    assert np.allclose(volume, sides.prod(axis=1), rtol=1e-13)
    assert np.allclose(centre, 0, atol=1e-15)
    square = sides**2
    expected = (
        volume[:, None]
        / 12
        * np.stack([square[:, 1] + square[:, 2], square[:, 2] + square[:, 0], square[:, 0] + square[:, 1]], axis=1)
    )
    assert np.allclose(np.diagonal(inertia, axis1=1, axis2=2), expected, rtol=1e-12)


def test_step_counts_follow_the_angle_and_straight_directions_take_one():
    rounded = shapes.rounded_cuboid()
    params = params_of(rounded, 2)
    assert len(mesh.build(rounded, params, steps=24)[0].faces) == 6 * 2 + 12 * 12 + 8 * (2 * 36 - 6)
    assert len(mesh.build(rounded, params, steps=8)[0].faces) == 6 * 2 + 12 * 4 + 8 * (2 * 4 - 2)
    assert len(mesh.build(shapes.cylinder(), params_of(shapes.cylinder(), 2), steps=4)[0].faces) == 16


@pytest.mark.parametrize("make", shapes.ALL)
def test_one_instance_is_the_same_bits_in_any_batch(make):
    primitive = make()
    params = params_of(primitive, 300)
    count = len(params[""])
    params = {name: np.resize(value, 1000) for name, value in params.items()}
    whole = mesh.volume_inertia(primitive, params)
    vertices = {int(r): v for g in mesh.build(primitive, params) for r, v in zip(g.rows, g.vertices, strict=True)}
    for row in (0, 17, count - 1, 999):
        alone = mesh.take(params, np.array([row]))
        for one, many in zip(mesh.volume_inertia(primitive, alone), whole, strict=True):
            assert one.tobytes() == many[row].tobytes()
        assert mesh.build(primitive, alone)[0].vertices.tobytes() == vertices[row].tobytes()


@pytest.mark.parametrize("make", shapes.ALL)
def test_the_stated_box_is_the_box_of_the_mesh(make):
    primitive = make()
    params = params_of(primitive)
    low, high = box.bounds(primitive, params)
    for group in mesh.build(primitive, params, steps=96):
        extent = np.ptp(group.vertices, axis=1).max(axis=1)[:, None]
        assert (np.abs(group.vertices.min(axis=1) - low[group.rows]) < 2e-3 * extent).all()
        assert (np.abs(group.vertices.max(axis=1) - high[group.rows]) < 2e-3 * extent).all()


def test_a_missing_surface_is_a_leak_that_names_the_neighbour():
    whole = shapes.cylinder()
    with pytest.raises(PrimitiveError, match="edge v end meets no other edge") as caught:
        broken = shapes.cylinder(patches=(whole.patches[0], whole.patches[2]))
        mesh.build(broken, params_of(broken, 2))
    assert caught.value.patch == "side"
    assert "nearest is" in caught.value.message


def test_a_gap_between_surfaces_is_a_leak():
    whole = shapes.cuboid()
    front = whole.patches[0]
    shifted = shapes.patch("front", (front.position[0] + const(1e-6), *front.position[1:]))
    broken = shapes.cuboid(patches=(shifted, *whole.patches[1:]))
    with pytest.raises(PrimitiveError, match="leaks"):
        mesh.build(broken, params_of(broken, 2))


def test_a_surface_declared_twice_is_refused():
    whole = shapes.cuboid()
    broken = shapes.cuboid(patches=(*whole.patches, whole.patches[5]))
    with pytest.raises(PrimitiveError, match="is shared by 3 surfaces"):
        mesh.build(broken, params_of(broken, 2))


def test_partial_and_full_turns_are_two_variants():
    ring = shapes.hollow_frustum()
    found = {sum(flags): topology(ring, flags) for flags in variants(ring)}
    assert sorted(found) == [4, 6]
    assert any(a == b for a, _, b, _, _ in found[4].matches)  # the seam of the full turn
    assert not any(a == b for a, _, b, _, _ in found[6].matches)
