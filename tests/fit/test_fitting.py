"""Objects of a program are found again from clouds of their surfaces."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

import artipg_dsl as apg
from artipg_dsl.api import Samples
from artipg_dsl.fit.fitting import Fitted, fit, usual_size
from artipg_dsl.fit.measure import verdict
from artipg_dsl.fit.model import Changes, Model
from artipg_dsl.fit.pose import Frame, Posed, pose, turn
from artipg_dsl.fit.reading import Cloud
from artipg_dsl.session import Session
from tests.cli.helpers import CHEST

LARGE_KNOBS = Path(CHEST).read_text().replace("[1cm, 2cm, 2cm]", "[6cm, 8cm, 8cm]")


@pytest.fixture(scope="module")
def model() -> Model:
    return Model(Session.of_text(LARGE_KNOBS).sampler)


def clouds(
    samples: Samples, model: Model, *, noise: float = 0.0, missing: float = 0.0, grown: float = 1.0
) -> list[Posed]:
    """The surfaces of samples as posed clouds, with noise in diagonals and what is nearest to one of their points missing."""
    points, chance, found = samples.points(8000), np.random.default_rng(1), []
    for place, normal in zip(points.position, points.normal, strict=True):
        across = np.sqrt((np.ptp(place, axis=0) ** 2).sum())
        away = np.sqrt(((place - place[chance.integers(len(place))]) ** 2).sum(axis=1))
        kept = np.sort(np.argsort(away)[int(missing * len(place)) :])
        at = place[kept] + chance.normal(size=(len(kept), 3)) * noise * across / np.sqrt(3.0)
        cloud = Cloud(grown * at, normal[kept], np.full(len(kept), -1), ())
        frame = Frame(front="x", normalised=grown != 1.0)
        found.append(pose(cloud, frame, ".npz", usual_size(model)))
    return found


def off(found: list[Fitted], samples: Samples, name: str, width: float) -> np.ndarray:
    return np.abs([one.values[name] for one in found] - samples[name]) / width


def test_samples_are_found_again(model: Model) -> None:
    samples = apg.load(LARGE_KNOBS, n=3, seed=5)
    several = clouds(samples, model)
    found = fit(model, several)
    assert [one.values["knobs"] for one in found] == samples["knobs"].astype(int).tolist()
    assert max(off(found, samples, "width", 0.3)) < 0.01
    assert max(off(found, samples, "depth", 0.2)) < 0.01
    assert max(off(found, samples, "share", 0.2)) < 0.02
    assert all(one.told["verdict"] == "fits" and one.told["valid"] for one in found)
    assert max(one.told["distance"]["both"] for one in found) < 0.5
    alone = fit(model, several[1:2])[0]
    assert alone.values == found[1].values and alone.told == found[1].told


@pytest.mark.slow
def test_a_cloud_that_lies_is_set_upright(model: Model) -> None:
    """A file whose upward axis is y, read as others are; unless it is said that z is up."""
    samples = apg.load(LARGE_KNOBS, n=2, seed=5)
    points = samples.points(8000)
    lying, normals = (vectors[1] @ turn("y", "z") for vectors in (points.position, points.normal))
    cloud = Cloud(lying, normals, np.full(len(lying), -1), ())
    found = {}
    for up in ("auto", "any", "z"):
        (one,) = fit(model, [pose(cloud, Frame(up=up), ".npz", usual_size(model))])
        found[up] = one.told["frame"]["up"], one.told["distance"]["both"]
    assert found["auto"] == found["any"] and found["auto"][0] == "y" and found["auto"][1] < 0.1
    assert found["z"][0] == "z" and found["z"][1] > 1.0


@pytest.mark.slow
def test_noise_and_holes_do_not_matter_much(model: Model) -> None:
    samples = apg.load(LARGE_KNOBS, n=3, seed=6)
    found = fit(model, clouds(samples, model, noise=0.01, missing=0.3))
    assert [one.values["knobs"] for one in found] == samples["knobs"].astype(int).tolist()
    assert np.median(off(found, samples, "width", 0.3)) < 0.03


@pytest.mark.slow
def test_a_cloud_without_a_scale(model: Model) -> None:
    samples = apg.load(LARGE_KNOBS, n=2, seed=7)
    found = fit(model, clouds(samples, model, grown=7.0))
    for one, width, depth in zip(found, samples["width"], samples["depth"], strict=True):
        assert one.values["width"] / one.values["depth"] == pytest.approx(width / depth, rel=0.03)
        assert one.told["frame"]["unit"] is None


@pytest.mark.slow
def test_the_matrix_carries_the_cloud_into_the_frame_of_the_object(model: Model) -> None:
    samples = apg.load(LARGE_KNOBS, n=1, seed=8)
    posed = clouds(samples, model)
    one = fit(model, posed)[0]
    matrix = np.array(one.told["to_object"])
    assert np.allclose(posed[0].points @ matrix[:3, :3].T + matrix[:3, 3], one.cloud, atol=1e-6)


def test_the_matrix_holds_whatever_the_size_of_the_file(model: Model) -> None:
    samples = apg.load(LARGE_KNOBS, n=1, seed=8)
    posed = clouds(samples, model, grown=3.7e8)
    one = fit(model, posed)[0]
    matrix = np.array(one.told["to_object"])
    assert np.allclose(posed[0].points @ matrix[:3, :3].T + matrix[:3, 3], one.cloud, atol=1e-6)


@pytest.mark.slow
def test_the_same_again(model: Model) -> None:
    samples = apg.load(LARGE_KNOBS, n=1, seed=9)
    first, second = (fit(model, clouds(samples, model))[0] for _ in range(2))
    assert first.values == second.values and first.told == second.told


def test_a_changed_value_changes_nothing_else(model: Model) -> None:
    batch = model.drawn(np.arange(4), 3)
    number = next(k for k in model.smooth if model.program.draws[k].column.name == "depth")
    moved = model.altered(
        batch, np.array([1, 3]), Changes(np.array([1]), np.array([number]), np.array([3]), np.array([0.3]))
    )
    assert moved.state.values[number].tolist() == [batch.state.values[number][1], 0.3]
    others = [
        k for k in range(len(model.program.draws)) if k != number and not model.program.draws[k].column.scope.parent
    ]
    assert all((moved.state.values[k] == batch.state.values[k][[1, 3]]).all() for k in others)


def test_verdicts() -> None:
    assert [verdict(x) for x in (0.4, 3.0, 12.0)] == ["fits", "rough", "does not fit"]
