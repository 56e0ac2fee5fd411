"""Moments by quadrature: exact where a formula is known, the limit of finer meshes, the same bits in any batch."""

import numpy as np
import pytest

from artipg_dsl.geometry import mesh, quadrature
from artipg_dsl.geometry.trial import draw_trial

from .shipped import SHIPPED


def test_a_ball_and_a_cone_have_the_moments_of_the_books():
    radius = np.array([0.02, 0.3])
    volume, centre, inertia = quadrature.volume_inertia(SHIPPED["Ball"], {"": np.zeros(2), "radius": radius})
    assert np.allclose(volume, 4 / 3 * np.pi * radius**3, rtol=1e-13) and np.abs(centre).max() < 1e-14
    assert np.allclose(inertia, (0.4 * volume * radius**2)[:, None, None] * np.eye(3), rtol=1e-12, atol=1e-18)
    height, shift = np.array([0.1, 0.4]), np.array([0.05, -0.2])
    cone = {"": np.zeros(2), "radius": radius, "height": height, "shift": shift}
    volume, centre, inertia = quadrature.volume_inertia(SHIPPED["SkewCone"], cone)
    assert np.allclose(volume, np.pi * radius**2 * height / 3, rtol=1e-13)
    assert np.allclose(centre, np.stack([shift / 4, 0 * shift, -height / 4], axis=1), atol=1e-15)
    # sheared by `shift` per `height`: the moments of the upright cone, and what the shear adds
    square = volume * (3 / 20 * radius**2 + 3 / 80 * shift**2), volume * 3 / 20 * radius**2, volume * 3 / 80 * height**2
    expected = [square[1] + square[2], square[0] + square[2], square[0] + square[1]]
    assert np.allclose(np.diagonal(inertia, axis1=1, axis2=2), np.stack(expected, axis=1), rtol=1e-12)
    assert np.allclose(inertia[:, 0, 2], -volume * 3 / 80 * shift * height, rtol=1e-12)


@pytest.mark.parametrize("name", ["SlantedTube", "PotShell", "Superellipsoid", "EggRing", "TaperedSleeve", "Prism"])
def test_meshes_come_nearer_to_the_quadrature_the_finer_they_are(name):
    primitive = SHIPPED[name]
    params = draw_trial(primitive, 4)
    exact = quadrature.volume_inertia(primitive, params)
    off = []
    for steps in (24, 96):
        made = mesh.volume_inertia(primitive, params, steps)
        scales = np.abs(exact[0]).max(), 0.1, np.abs(exact[2]).max()  # a centre may be 0
        off.append([np.abs(m - e).max() / s for m, e, s in zip(made, exact, scales, strict=True)])
    assert all(fine < max(coarse / 12, 1e-12) for coarse, fine in zip(*off, strict=True))


def test_an_instance_has_the_same_bits_alone():
    primitive = SHIPPED["HollowFrustum"]  # with and without cut faces
    params = draw_trial(primitive, 8)
    every = quadrature.volume_inertia(primitive, params)
    for row in (0, 3, len(params[""]) - 1):
        alone = quadrature.volume_inertia(primitive, mesh.take(params, np.array([row])))
        assert all(a[0].tobytes() == e[row].tobytes() for a, e in zip(alone, every, strict=True))


@pytest.mark.slow
def test_a_bar_whose_curvature_has_cusps_takes_more_places():
    """The rim of spectacles runs along a superellipse. With the places of a smooth patch its volume is 0.3 % off."""
    primitive = SHIPPED["RimSag"]
    params = mesh.take(draw_trial(primitive), np.arange(48, 72))
    volume, _, inertia = quadrature.volume_inertia(primitive, params)
    expected, _, bulges = mesh.volume_inertia(primitive, params, 384)  # 0.02 % too small
    assert np.abs(volume / expected - 1).max() < 2e-3
    assert (np.abs(inertia - bulges).max(axis=(1, 2)) < 2e-3 * np.abs(bulges).max(axis=(1, 2))).all()
    assert set(quadrature._find_times(SHIPPED["EggRing"])) == {(1, 1)}
