"""Points shared out over classes, links, ...: how many go where, what each stands for, and wishes that are refused."""

from __future__ import annotations

import io

import numpy as np
import pytest

import artipg_dsl as apg
from artipg_dsl.annotate.sampling import Sampling, read_weights
from artipg_dsl.annotate.shares import share_out
from artipg_dsl.errors import UsageError
from artipg_dsl.export.containers import npz_bytes
from artipg_dsl.export.shards import point_arrays


@pytest.fixture(scope="module")
def samples() -> apg.Samples:
    return apg.sample("Microwave", n=6, seed=3, checked=False)


@pytest.mark.parametrize("balance", ["semantic", "link", "instance", "primitive"])
def test_each_has_its_share(samples: apg.Samples, balance: str) -> None:
    points, per = samples.points(1024, balance=balance), samples.points(8, per=balance)
    assert points.position.shape == (6, 1024, 3) and np.array_equal(points.object, np.arange(6))
    for k in range(6):
        of = (
            points.primitive[k].astype(np.int64) << 32 | points.element[k]
            if balance == "primitive"
            else getattr(points, balance)[k]
        )
        _, count = np.unique(of, return_counts=True)
        assert len(count) == (per.object == k).sum() and count.sum() == 1024
        assert count.max() - count.min() <= 1


def test_weights(samples: apg.Samples) -> None:
    points = samples.points(1000, balance="semantic", weights={"handle": 3, "door": 0.5})
    words = np.array(samples.batch.program.vocabularies["semantic"])
    for k in range(6):
        names, count = np.unique(words[points.semantic[k]], return_counts=True)
        weight = np.array([{"handle": 3.0, "door": 0.5}.get(name, 1.0) for name in names])
        assert np.abs(count - 1000 * weight / weight.sum()).max() < 1
    again = samples.points(1000, balance="semantic", weights="door=0.5, handle=3")
    assert again.position.tobytes() == points.position.tobytes()


def test_areas_undo_what_balancing_did(samples: apg.Samples) -> None:
    plain, per = samples.points(4096), samples.points(512, per="link")
    for points in (samples.points(4096, balance="semantic"), samples.points(4096, balance="link", weights="body=2")):
        assert points.area is not None and plain.area is not None and per.area is not None
        assert points.area.sum(axis=1) == pytest.approx(plain.area.sum(axis=1), rel=0.02)
        total = [per.area[per.object == k].sum() for k in range(6)]
        assert total == pytest.approx(plain.area.sum(axis=1), rel=0.02)
        for k in range(6):  # the shares of classes in the surface, from either
            size = len(samples.batch.program.vocabularies["semantic"])
            one = np.bincount(points.semantic[k], points.area[k], size) / points.area[k].sum()
            two = np.bincount(plain.semantic[k], minlength=size) / 4096
            assert np.abs(one - two).max() < 0.03


@pytest.mark.parametrize(
    "how",
    [
        {"balance": "semantic"},
        {"balance": "link", "spread": "blue"},
        pytest.param({"balance": "semantic", "surface": "outside"}, marks=pytest.mark.slow),
    ],
)
def test_an_object_has_the_same_points_in_any_batch(samples: apg.Samples, how: dict[str, str]) -> None:
    whole, alone = samples.points(200, **how), samples.object(4).points(200, **how)
    for name in ("position", "semantic", "primitive", "element", "patch", "u", "v", "area"):
        assert getattr(whole, name)[4].tobytes() == getattr(alone, name)[0].tobytes(), name
    of = getattr(whole, how["balance"])
    assert all(set(of[k, :100].tolist()) == set(of[k].tolist()) for k in range(6)), "a prefix is a sample"


def test_blue_points_keep_apart_within_their_share(samples: apg.Samples) -> None:
    from scipy.spatial import cKDTree

    def least(points: object) -> float:
        position, link = points.position[0], points.link[0]  # type: ignore[attr-defined]
        found = [cKDTree(position[link == k]).query(position[link == k], k=2)[0][:, 1] for k in np.unique(link)]
        return float(np.mean([np.quantile(f, 0.05) / np.median(f) for f in found]))

    assert least(samples.points(1500, balance="link", spread="blue")) > 1.5 * least(
        samples.points(1500, balance="link")
    )


def test_quotas() -> None:
    owner = np.array([0, 0, 0, 1, 1, 2])
    assert share_out(owner, np.array([1.0, 1.0, 1.0, 3.0, 1.0, 2.0]), 10).tolist() == [4, 3, 3, 8, 2, 10]
    assert share_out(owner, np.array([1.0, 0.0, 1.0, 0.0, 1.0, 0.1]), 3).tolist() == [2, 0, 1, 0, 3, 3]


def test_shards_hold_what_points_stand_for(samples: apg.Samples) -> None:
    arrays = point_arrays(samples.batch, Sampling(64, balance="link"))
    with np.load(io.BytesIO(npz_bytes(arrays))) as read:
        assert read["area"].dtype == np.float32 and read["area"].shape == (6, 64) and (read["area"] > 0).all()
    assert "area" in point_arrays(samples.batch, Sampling(64, per="link"))
    assert "area" not in point_arrays(samples.batch, 64)


@pytest.mark.parametrize(
    ("wish", "said"),
    [
        ({"balance": "class"}, "it may be semantic, instance, link, primitive"),
        ({"balance": "link", "per": "link"}, "choose one"),
        ({"weights": {"handle": 2}}, "balance may be semantic"),
        ({"balance": "semantic", "weights": "handel=2"}, "did you mean `handle`?"),
        ({"balance": "semantic", "weights": "blade=2"}, "it has body, cavity"),
        ({"balance": "link", "weights": "drawer=2"}, "it has body"),
        ({"balance": "semantic", "weights": "handle"}, "for example handle=3"),
        ({"balance": "semantic", "weights": {"handle": -1}}, "give a number above 0"),
        ({"balance": "semantic", "weights": "handle=nan"}, "give a number above 0"),
        ({"balance": "semantic", "weights": "handle=1,handle=2"}, "give it one"),
    ],
)
def test_wishes_that_contradict_are_refused(samples: apg.Samples, wish: dict, said: str) -> None:
    with pytest.raises(UsageError) as caught:
        samples.points(16, **wish)
    assert said in (caught.value.hint or ""), caught.value


def test_weights_as_text() -> None:
    assert (
        read_weights("knob=2, handle=0.5")
        == read_weights({"handle": 0.5, "knob": 2})
        == (("handle", 0.5), ("knob", 2.0))
    )
    assert read_weights(None) == read_weights("") == ()
