"""Clouds brought into the frame of programs: outer surface, normals, axes, unit."""

from __future__ import annotations

import numpy as np
import pytest
import trimesh
from scipy.spatial import cKDTree

from artipg_dsl.errors import UsageError, UserError
from artipg_dsl.fit.outer import Screens, outer, spacing
from artipg_dsl.fit.pose import Frame, pose, targets, turn
from artipg_dsl.fit.reading import Cloud
from artipg_dsl.fit.real import read_real
from artipg_dsl.fit.sources import Held


def box(size: list[float], count: int = 6000) -> tuple[np.ndarray, np.ndarray]:
    mesh = trimesh.creation.box(size)
    points, face = trimesh.sample.sample_surface(mesh, count, seed=1)
    return np.asarray(points), mesh.face_normals[face]


def test_what_lies_inside_is_left_out() -> None:
    (outside, _), (inside, _) = box([1.0, 1.0, 1.0]), box([0.5, 0.5, 0.5])
    seen = outer(np.concatenate([outside, inside])[None])[0]
    assert seen[: len(outside)].all() and seen[len(outside) :].mean() < 0.01


def test_a_target_hides_what_few_points_of_a_candidate_do_not() -> None:
    """A tray a tenth below the top, in a candidate of 500 points, beside a target of 6,000."""
    (target, _), (outside, _) = box([1.0, 1.0, 1.0]), box([1.0, 1.0, 1.0], 300)
    tray = box([0.8, 0.8, 0.02], 200)[0] + [0.0, 0.0, 0.4]
    every = np.concatenate([outside, tray])[None].repeat(2, axis=0)
    every[1, 300:, 2] += 0.2  # above the target
    clouds = np.stack([box([3.0, 3.0, 3.0])[0], target])
    seen = Screens(clouds, spacing(clouds)).outer(every, np.array([1, 1]))
    assert outer(every)[0, 300:].mean() > 0.5 and seen[0, 300:].mean() < 0.1
    assert seen[:, :300].mean() > 0.9 and seen[1, 300:].mean() > 0.9


def test_clouds_of_single_precision_are_read_as_they_are() -> None:
    points, normals = box([0.3, 0.4, 0.5])
    told = points.astype(np.float32), normals.astype(np.float32), np.full(len(points), -1), ()
    single = pose(Cloud(*told), Frame(), ".npz", 0.7)
    double = pose(Cloud(told[0].astype(np.float64), told[1].astype(np.float64), *told[2:]), Frame(), ".npz", 0.7)
    assert single.points.dtype == single.normals.dtype == np.float64
    assert np.array_equal(single.points, double.points) and np.array_equal(single.normals, double.normals)


@pytest.mark.parametrize("size", [0.01, 50.0])
def test_what_was_fitted_is_bound_whatever_its_size(size: float) -> None:
    points, normals = box([size, size, size])
    matrix = np.eye(4).tolist()
    record = {"name": "one", "file": "", "frame": {"up": "z", "front": "x", "unit": "m"}, "to_object": matrix}
    real = read_real(Held("one", Cloud(points, normals, np.full(len(points), -1), ())), record)
    assert np.allclose(np.ptp(real.points, axis=0), size, rtol=0.01)


@pytest.mark.parametrize("known", [True, False])
def test_normals_face_outwards(known: bool) -> None:
    points, normals = box([0.3, 0.4, 0.5])
    cloud = Cloud(points, -normals if known else None, np.full(len(points), -1), ())  # a mesh that is inside out
    posed = pose(cloud, Frame(front="x"), ".obj", 0.7)
    outward = (posed.points * posed.normals).sum(axis=1) > 0
    assert outward.mean() > (0.999 if known else 0.97)  # at edges they are uncertain


@pytest.mark.parametrize("noise", [0.0, 0.001, 0.005])
def test_noise_tilts_normals_little_and_is_measured(noise: float) -> None:
    """Noise of as much as neighbours lie apart; far from edges, where a normal is that of a face."""
    points, normals = box([0.3, 0.4, 0.5], 12_000)
    at = points + np.random.default_rng(0).normal(size=points.shape) * noise
    posed = pose(Cloud(at, None, np.full(len(at), -1), ()), Frame(front="x", unit="m"), ".npz", 0.7)
    true = normals[cKDTree(at).query(posed.points)[1]]
    within = np.sort(np.abs(posed.points) / [0.15, 0.2, 0.25], axis=1)[:, 1] < 0.8
    turned = np.degrees(np.arccos(np.clip((posed.normals * true).sum(axis=1)[within], -1.0, 1.0)))
    assert np.median(turned) < 8.0
    target = targets([posed])
    assert abs(target.noise[0] * target.diagonal[0] - noise) < 0.25 * noise + 1e-6


def test_axes_come_to_stand_where_programs_have_them() -> None:
    assert (turn("y", "z") @ [0, 1, 0] == [0, 0, 1]).all() and (turn("y", "z") @ [0, 0, 1] == [1, 0, 0]).all()
    assert np.linalg.det(turn("-y", "x")) == 1.0
    assert Frame().turns(".glb") == [("y", front) for front in ("x", "-x", "z", "-z")]
    assert Frame(front="-y").turns(".obj") == [("z", "-y")]
    with pytest.raises(UsageError):
        Frame(up="z", front="-z")


def test_all_upward_axes_are_tried_where_that_is_asked_for_or_nothing_else_fits() -> None:
    every = Frame(up="any").turns(".obj")
    assert len(set(every)) == 24 and Frame(up="any").others(".obj") == []
    assert set(Frame().turns(".obj") + Frame().others(".obj")) == set(every)
    assert Frame(up="z").others(".obj") == []
    assert Frame(up="any", front="x").turns(".obj") == [(up, "x") for up in ("y", "-y", "z", "-z")]


def test_the_unit_is_what_the_sizes_of_the_category_suggest() -> None:
    points, normals = box([300.0, 400.0, 500.0])
    cloud = Cloud(points, normals, np.full(len(points), -1), ())
    posed = pose(cloud, Frame(front="x"), ".stl", 0.7)
    assert posed.unit == "mm" and np.allclose(targets([posed]).size[0], [0.3, 0.4, 0.5], atol=1e-3)
    assert pose(cloud, Frame(front="x", unit="cm"), ".stl", 0.7).unit == "cm"
    feet = Cloud(points / 304.8, normals, cloud.label, ())  # as metres three times as long as usual
    posed = pose(feet, Frame(front="x"), ".stl", 0.7)
    assert posed.unit == "m" and "2.3 m with m as unit, that of usual objects 0.7 m" in posed.doubt
    posed = pose(feet, Frame(front="x", unit="ft"), ".stl", 0.7)
    assert posed.doubt == "" and np.allclose(targets([posed]).size[0], [0.3, 0.4, 0.5], atol=1e-3)
    assert pose(cloud, Frame(front="x", normalised=True), ".stl", 0.7).unit == "m"


@pytest.mark.parametrize(("scale", "unit"), [(1e-6, "auto"), (1e6, "auto"), (1.0, "mm")])
def test_what_is_far_too_small_or_large_is_refused(scale: float, unit: str) -> None:
    points, _ = box([0.3, 0.4, 0.5])
    cloud = Cloud(points * scale, None, np.full(len(points), -1), ())
    with pytest.raises(UserError, match="that of usual objects 0.7 m"):
        pose(cloud, Frame(front="x", unit=unit), ".stl", 0.7)
    assert pose(cloud, Frame(front="x", normalised=True), ".stl", 0.7).unit == "m"
