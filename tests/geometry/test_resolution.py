"""Meshes by chord error and by budget: closed, within the tolerance, no finer than asked, the same in any batch."""

import os

import numpy as np
import pytest

from artipg_dsl.api import sample
from artipg_dsl.errors import UsageError
from artipg_dsl.geometry import mesh, surface
from artipg_dsl.geometry.trial import draw_trial

from .shipped import SHIPPED

EVERY = os.environ.get("ARTIPG_EVERY") == "1"
TOLERANCES = (10.0, 2e-3, 5e-4) if EVERY else (10.0, 5e-4)  # metres; the first: as coarse as it goes


def apart(corners):
    """(k, F, 3): the middles of triangles (k, F, 3, 3)."""
    return corners.sum(axis=2) / 3


@pytest.mark.parametrize("name", SHIPPED)
def test_meshes_are_closed_at_every_tolerance(name):
    primitive = SHIPPED[name]
    params = draw_trial(primitive, 6)
    rows = np.arange(0, len(params[""]), 3 if EVERY else 9)
    some = mesh.take(params, rows)
    exact = mesh.volume_inertia(primitive, some, 96)[0]
    area = surface.areas(primitive, some).sum(axis=1)
    for tolerance in TOLERANCES:  # a plan that does not close is refused by `plan`
        volume, _, _ = mesh.volume_inertia(primitive, some, np.full(len(rows), tolerance))
        assert (volume > 0).all()
        assert (np.abs(volume - exact) < 1.05 * tolerance * area + 0.003 * exact).all()


def test_chords_keep_within_the_tolerance_and_are_not_finer_than_that():
    ball, radius = SHIPPED["Ball"], np.geomspace(0.01, 0.2, 12)
    for tolerance in (2e-3, 1e-4):
        params = {"": np.zeros(12), "radius": radius}
        for group in mesh.build(ball, params, np.full(12, tolerance)):
            corners = group.vertices[:, group.faces]
            size = radius[group.rows][:, None]
            depth = size - np.sqrt((apart(corners) ** 2).sum(axis=-1))
            edges = (corners + np.roll(corners, 1, axis=2)) / 2
            deepest = np.maximum(
                depth.max(axis=1), (size[..., None] - np.sqrt((edges**2).sum(axis=-1))).max(axis=(1, 2))
            )
            assert (deepest <= tolerance).all()
            assert (deepest > 0.3 * tolerance).all() or len(group.faces) <= 8


def test_a_cylinder_takes_the_steps_of_its_own_radius_and_flat_things_take_none():
    params = {
        "": np.zeros(3),
        "radius": np.array([0.01, 0.1, 1.0]),
        "top_radius": np.array([0.01, 0.1, 1.0]),
        "height": np.full(3, 0.5),
    }
    tolerance = 5e-4
    steps = {
        int(r): len(g.faces) // 4
        for g in mesh.build(SHIPPED["Cylinder"], params, np.full(3, tolerance))
        for r in g.rows
    }
    for row, radius in enumerate(params["radius"]):
        needed = np.pi / np.arccos(1 - tolerance / radius)
        assert needed <= steps[row] <= 1.35 * needed
    cuboid = draw_trial(SHIPPED["Cuboid"], 4)
    (group,) = mesh.build(SHIPPED["Cuboid"], cuboid, np.full(len(cuboid[""]), 1e-5))
    assert len(group.faces) == 12


def test_an_instance_is_the_same_alone():
    primitive = SHIPPED["TorusSector"]
    params = draw_trial(primitive, 8)
    tolerance = np.geomspace(1e-3, 1e-2, len(params[""]))
    groups = mesh.build(primitive, params, tolerance)
    assert sorted(r for g in groups for r in g.rows.tolist()) == list(range(len(tolerance)))
    for row in (0, 5, 11):
        together = next(g for g in groups if row in g.rows)
        (alone,) = mesh.build(primitive, mesh.take(params, np.array([row])), tolerance[[row]])
        assert alone.vertices[0].tobytes() == together.vertices[list(together.rows).index(row)].tobytes()
        assert np.array_equal(alone.faces, together.faces)


@pytest.mark.parametrize("budget", [2000, 12000])
def test_an_object_keeps_to_its_triangles_whatever_else_is_in_the_batch(budget):
    many = sample("Kettle", 4, seed=3, checked=False)
    counts = [sum(len(g.faces) for g in scene.geometry.values()) for scene in many.meshes(triangles=budget)]
    assert max(counts) <= budget and min(counts) > 0.6 * budget
    alone = sample("Kettle", numbers=[2], seed=3, checked=False).meshes(triangles=budget)[0]
    assert sum(len(g.faces) for g in alone.geometry.values()) == counts[2]
    loose = many.meshes(triangles=budget, tolerance=0.05)
    assert all(sum(len(g.faces) for g in s.geometry.values()) <= c for s, c in zip(loose, counts, strict=True))


def test_every_mesh_of_an_object_is_watertight_at_a_coarse_and_a_fine_tolerance():
    one = sample("Kettle", 1, seed=3, checked=False)
    sizes = []
    for tolerance in (0.1, 1e-4):
        (scene,) = one.meshes(tolerance=tolerance)
        assert all(g.is_watertight and g.is_winding_consistent and g.volume > 0 for g in scene.geometry.values())
        sizes.append(sum(len(g.faces) for g in scene.geometry.values()))
    assert sizes[0] * 10 < sizes[1]


def test_wishes_that_make_no_sense_are_told():
    with pytest.raises(UsageError, match="tolerance=0"):
        sample("Microwave", checked=False).meshes(tolerance=0.0)
    with pytest.raises(UsageError, match="triangles is 0"):
        sample("Microwave", checked=False).meshes(triangles=0)
