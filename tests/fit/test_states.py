"""Joints of real objects are found where they are, and the surface is carried back for its details."""

from __future__ import annotations

from unittest import mock

import numpy as np
import pytest

import artipg_dsl as apg
from artipg_dsl.details.binding import Real
from artipg_dsl.errors import UserError
from artipg_dsl.fit.fitting import Fitted, fit
from artipg_dsl.fit.model import Model
from artipg_dsl.fit.pose import Frame, Posed, pose
from artipg_dsl.fit.reading import Cloud
from artipg_dsl.fit.real import closed
from artipg_dsl.fit.search import Effort
from artipg_dsl.fit.states import can_open, moved
from artipg_dsl.geometry import points as geometry
from artipg_dsl.random import key
from artipg_dsl.sampling import known
from artipg_dsl.session import Session

CASE = """apg 1
use primitives { Cuboid }
use vocabularies { semantic }
use materials { oak }
category Case {
  param wide : length in 20cm .. 40cm = 30cm
  param deep : length in 15cm .. 25cm = 20cm
  param high : length in 5cm .. 10cm = 8cm
  root part tub : Cuboid(size = [deep, wide, high])
  part lid : Cuboid(size = [deep, wide, 2cm])
  align lid.bottom = tub.top
  joint open : revolute tub -> lid about lid.back.bottom range 0deg .. 110deg
  label semantic.body on tub
  label semantic.lid on lid
  material oak on tub, lid
}
"""
LITTLE = Effort(drawn=600, looked=200, kept=8, best=3, rounds=1, tried=8)


@pytest.fixture(scope="module")
def models() -> tuple[Model, Model]:
    sampler = Session.of_text(CASE).sampler
    return Model(sampler), Model(sampler, opened=True)


def seen(value: float, seed: int = 5) -> tuple[apg.Samples, Posed]:
    """A sample with its lid at an angle, and its cloud."""
    samples = apg.load(CASE, n=1, seed=seed)
    sites = moved(samples.batch, np.array([value]))  # with what an open lid shows
    points = geometry.sample(sites, 1, 8000, key(0, "seen"), np.zeros(1, np.uint64), outside=False)
    order = np.random.default_rng(0).permutation(8000)
    cloud = Cloud(points.position[0][order], points.normal[0][order], np.full(8000, -1), ())
    return samples, pose(cloud, Frame(front="x", unit="m"), ".npz", 1.0)


def off(one: Fitted, samples: apg.Samples) -> float:
    return max(
        abs(one.values[name] - samples[name][0]) / width
        for name, width in (("wide", 0.2), ("deep", 0.1), ("high", 0.05))
    )


@pytest.mark.slow
def test_an_open_lid_is_found(models: tuple[Model, Model]) -> None:
    samples, posed = seen(1.1)
    (at_rest,) = fit(models[0], [posed], effort=LITTLE)
    (one,) = fit(models[0], [posed], effort=LITTLE, opened=models[1])
    assert "joints" not in at_rest.told and at_rest.told["verdict"] != "fits"
    assert one.told["joints"]["open"] == pytest.approx(1.1, abs=0.005)
    assert one.told["distance"]["both"] < 0.1 and off(one, samples) < 0.01
    assert one.told["valid"] and set(one.values) == {"wide", "deep", "high"}


def test_a_lid_that_is_ajar_is_found_though_a_closed_one_fits(models: tuple[Model, Model]) -> None:
    _, posed = seen(0.3)
    (at_rest,) = fit(models[0], [posed], effort=LITTLE)
    (one,) = fit(models[0], [posed], effort=LITTLE, opened=models[1])
    assert at_rest.told["verdict"] == "fits" and one.told["joints"]["open"] == pytest.approx(0.3, abs=0.02)


def test_what_fits_at_rest_is_left_there(models: tuple[Model, Model]) -> None:
    _, posed = seen(0.0)
    (one,) = fit(models[0], [posed], effort=LITTLE, opened=models[1])
    assert "joints" not in one.told and one.told["verdict"] == "fits"


def test_joints_are_drawn_after_all_else(models: tuple[Model, Model]) -> None:
    plain, opened = (model.drawn(np.arange(50), 3) for model in models)
    for number in range(len(plain.program.draws)):
        assert np.array_equal(plain.state.values[number], opened.state.values[number])
    (values,) = (opened.state.values[number] for number in opened.program.states.values())
    assert (values[::2] == 0.0).all() and 5 < (values[1::2] > 0.0).sum() < 20


def test_loops_and_followers_are_not_opened() -> None:
    assert can_open(Session.of_text(CASE).sampler.program)
    assert not can_open(Session.of("Foldingrack").sampler.program)


def test_rests_are_told_without_what_is_in_the_way() -> None:
    """Where joints that go on end is for solids to tell, which takes most of a minute for a cupboard."""
    sampler = Session.of_text(CASE.replace("110deg", "clearance")).sampler
    with mock.patch.object(known, "limit_joints") as limited:
        Model(sampler)
    assert limited.call_count == 0


def test_the_surface_is_carried_back_to_rest() -> None:
    samples, posed = seen(1.1)
    real = Real("case", posed.points, posed.normals, posed.label, posed.names)
    back = closed(samples.batch, real, {"open": 1.1})
    top = samples.points(4000).position[..., 2].max()
    assert np.quantile(back.points[:, 2], 0.999) == pytest.approx(top, abs=1e-3)
    assert real.points[:, 2].max() > top + 0.1
    with pytest.raises(UserError, match="no joint `door`"):
        closed(samples.batch, real, {"door": 1.0})


def test_what_rests_elsewhere_is_fitted_at_rest() -> None:
    text = CASE.replace("range 0deg .. 110deg", "range 0deg .. 110deg rest 60deg")
    model, samples = Model(Session.of_text(text).sampler), apg.load(text, n=1, seed=5)
    sites = moved(samples.batch, np.array([np.deg2rad(60.0)]))
    points = geometry.sample(sites, 1, 8000, key(0, "seen"), np.zeros(1, np.uint64), outside=False)
    order = np.random.default_rng(0).permutation(8000)
    cloud = Cloud(points.position[0][order], points.normal[0][order], np.full(8000, -1), ())
    (one,) = fit(model, [pose(cloud, Frame(front="x", unit="m"), ".npz", 1.0)], effort=LITTLE)
    assert one.told["verdict"] == "fits" and one.told["joints"]["open"] == pytest.approx(np.deg2rad(60.0))
    assert off(one, samples) < 0.02


def test_where_a_joint_rests_is_fitted() -> None:
    """A number that moves the surface only by the joint which rests there is a number like others."""
    text = CASE.replace("  root part", "  param stand : angle in 20deg .. 100deg\n  root part").replace(
        "110deg\n", "110deg rest stand\n"
    )
    model, (_, posed) = Model(Session.of_text(text).sampler), seen(1.1)
    (one,) = fit(model, [posed], effort=LITTLE)
    assert one.values["stand"] == pytest.approx(1.1, abs=0.005)
    assert one.told["distance"]["both"] < 0.1
