"""Points of a batch: which surface, how spread, how many of what, and bound again after a change."""

from __future__ import annotations

import io

import numpy as np
import pytest

import artipg_dsl as apg
from artipg_dsl.annotate.cloud import Points, sample_surface
from artipg_dsl.annotate.sampling import Sampling
from artipg_dsl.errors import UsageError, UserError
from artipg_dsl.export.containers import npz_bytes
from artipg_dsl.export.shards import point_arrays
from artipg_dsl.geometry import blue


@pytest.fixture(scope="module")
def samples() -> apg.Samples:
    return apg.sample("Microwave", n=6, seed=3, checked=False)


def same(one: Points, other: Points, rows: np.ndarray) -> None:
    for name in ("position", "normal", "semantic", "instance", "link", "primitive", "element", "patch", "u", "v"):
        assert getattr(one, name)[rows].tobytes() == getattr(other, name).tobytes(), name
    assert all(one.labels[name][rows].tobytes() == other.labels[name].tobytes() for name in one.labels)


def test_points_without_labels_are_the_same(samples: apg.Samples) -> None:
    whole, bare = samples.points(128), sample_surface(samples.batch, Sampling(128))
    for name in ("position", "normal", "instance", "link", "material"):
        assert getattr(whole, name).tobytes() == getattr(bare, name).tobytes(), name


@pytest.mark.parametrize(
    "how",
    [{"per": "link"}, {"per": "semantic", "spread": "blue"}, {"surface": "outside"}, {"spread": "blue"}],
    ids=lambda how: "-".join(how.values()),
)
def test_an_object_has_the_same_points_in_any_batch(samples: apg.Samples, how: dict[str, str]) -> None:
    whole, alone = samples.points(128, **how), samples.object(4).points(128, **how)
    assert whole.position.shape[1] == 128
    same(whole, alone, np.flatnonzero(whole.object == 4))


def numbers(points: Points, per: str) -> np.ndarray:
    if per == "primitive":
        return points.primitive.astype(np.int64) << 32 | points.element
    return getattr(points, per)


@pytest.mark.parametrize("per", ["semantic", "instance", "link", "primitive"])
def test_each_of_what_is_asked_for_has_its_points(samples: apg.Samples, per: str) -> None:
    points, few = samples.points(64, per=per), samples.points(4000)
    row = numbers(points, per)
    assert (row == row[:, :1]).all(), "a row is of one"
    pairs = list(zip(points.object.tolist(), row[:, 0].tolist(), strict=True))
    assert pairs == sorted(set(pairs))
    found = numbers(few, per)
    assert {(k, w) for k in range(len(samples)) for w in found[k].tolist()} <= set(pairs)


def test_points_of_a_part_are_uniform_over_it(samples: apg.Samples) -> None:
    """A link's own points share out over its primitives as those of the object do that lie on it."""
    own, whole = samples.points(20_000, per="link"), samples.points(40_000)
    for row in np.flatnonzero(own.object == 0):
        link = own.link[row, 0]
        chosen = whole.primitive[0][whole.link[0] == link]
        if len(chosen) < 2000:
            continue
        size = int(max(own.primitive[row].max(), chosen.max())) + 1
        a, b = (np.bincount(x, minlength=size) / len(x) for x in (own.primitive[row], chosen))
        assert np.abs(a - b).max() < 4 * np.sqrt(0.25 / len(chosen))


def test_blue_points_keep_apart_and_uniform(samples: apg.Samples) -> None:
    from scipy.spatial import cKDTree

    one = samples.object(0)
    white, spread = one.points(2000), one.points(2000, spread="blue")
    distance = {}
    for name, points in (("white", white), ("blue", spread)):
        position, normal = points.position[0], points.normal[0]
        near, which = cKDTree(position).query(position, k=12)
        facing = (normal[which] * normal[:, None]).sum(axis=-1) > -0.5
        distance[name] = np.where(facing & (near > 0), near, np.inf).min(axis=1)
    assert distance["blue"].min() > 10 * distance["white"].min()
    shares = [np.bincount(p.primitive[0], minlength=400) / 2000 for p in (white, spread)]
    assert np.abs(shares[0] - shares[1]).max() < 0.02
    assert len(np.unique(spread.position[0], axis=0)) == 2000


def test_elimination_reaches_most_of_the_largest_radius() -> None:
    """On a square: the least distance is more than half of what the densest packing has; of white noise next to none."""
    place = np.random.default_rng(2).random((2, 4000, 3))
    place[..., 2] = 0.0
    normal = np.broadcast_to([0.0, 0.0, 1.0], place.shape)
    kept = blue.thin(place, normal, np.ones(2), 1000)
    assert kept.shape == (2, 1000) and (np.diff(kept, axis=1) > 0).all()
    most = 2 * blue.disc_radius(np.ones(1), 1000)[0]
    for points in (place[0][kept[0]], place[1][kept[1]]):
        gaps = np.sqrt(((points[:, None] - points) ** 2).sum(axis=-1)) + np.eye(len(points))
        assert gaps.min() > 0.55 * most
        counts = np.histogram2d(points[:, 0], points[:, 1], 5, ((0, 1), (0, 1)))[0]
        assert ((counts - 40) ** 2 / 40).sum() < 12  # white noise has 24 or so
    alone = blue.thin(place[1:], normal[1:], np.ones(1), 1000)
    assert alone.tobytes() == kept[1:].tobytes()


def test_both_sides_of_a_sheet_are_no_neighbours() -> None:
    place = np.random.default_rng(4).random((1, 800, 3)) * [1.0, 1.0, 0.0]
    normal = np.zeros((1, 800, 3))
    normal[0, :400, 2], normal[0, 400:, 2] = 1.0, -1.0
    both = blue.thin(place, normal, np.full(1, 2.0), 200)[0]
    assert abs((both < 400).sum() - 100) < 15
    assert set(both[both < 400]) <= set(range(400))


def test_a_closed_cavity_is_on_the_boundary_but_not_seen(samples: apg.Samples) -> None:
    words = samples.batch.program.vocabularies["semantic"]
    cavity = words.index("cavity")
    boundary, outside = samples.points(2048), samples.points(2048, surface="outside")
    assert ((boundary.semantic == cavity).mean(axis=1) > 0.1).all()
    assert (outside.semantic == cavity).mean() < 0.005, "but for the rim that shows in the slit"
    for points in (boundary, outside):
        assert points.position.shape == (6, 2048, 3)
    door = [words.index(word) for word in ("door", "frame", "window")]
    front = np.isin(outside.semantic, door) & (outside.normal[..., 0] > 0.9)
    assert front.any(axis=1).all()


def test_a_binding_gives_the_very_same_points(samples: apg.Samples) -> None:
    points = samples.points(300)
    again = samples.rebind(points)
    assert again.bound is not None and again.bound.all()
    same(points, again, np.arange(len(samples)))
    shard = np.load(io.BytesIO(npz_bytes(point_arrays(samples.batch, 300))))
    back = samples.rebind(shard)
    assert np.abs(back.position - points.position).max() < 1e-7
    assert np.array_equal(back.semantic, points.semantic)


def test_a_binding_follows_mutants_and_comes_back(samples: apg.Samples) -> None:
    points = samples.points(300, per="link")
    mutant = samples.mutate("cpa")
    moved = mutant.rebind(points)
    assert moved.bound is not None and moved.bound.all()
    assert 1e-4 < np.abs(moved.position - points.position).max() < 0.2
    assert np.array_equal(moved.semantic, points.semantic), "the classes of parts do not depend on sizes"
    same(points, samples.rebind(moved), np.arange(len(points.object)))
    # on the surface of the mutant: within its own box, and normals are unit
    assert np.abs((moved.normal**2).sum(axis=-1) - 1).max() < 1e-12


def test_what_is_gone_is_not_bound(samples: apg.Samples) -> None:
    points = samples.points(400)
    mutant = samples.mutate("apa,dpa", share=1.0)
    moved = mutant.rebind(points, mutant.joint_values("rest,open"), motion=True)
    bound = moved.bound
    assert bound is not None and moved.motion is not None and 0.3 < bound.mean() < 1
    assert moved.position.shape == moved.motion.shape == (6, 2, 400, 3)
    for array in (moved.position, moved.normal, moved.motion):
        assert (np.isnan(array).any(axis=-1) == ~bound[:, None]).all()
    assert ((moved.link == -1) == ~bound).all() and not moved.labels["affordance.pull"][~bound].any()
    rest = mutant.rebind(points)
    assert np.array_equal(rest.position[bound], moved.position[:, 0][bound])


def test_points_of_another_program_are_refused(samples: apg.Samples) -> None:
    arrays = point_arrays(samples.batch, 20)
    wrong = [
        ({"primitive": arrays["primitive"] + np.uint16(5000)}, "has no primitive"),
        ({"element": arrays["element"].astype(int) - 5000}, "`element` has -[0-9]+: numbers count from 0"),
        ({"patch": arrays["patch"] + np.uint16(5000)}, "patches that their primitives do not have"),
        ({"u": arrays["u"] + 2}, "beyond 0 .. 1"),
        ({"v": arrays["v"] * np.nan}, "beyond 0 .. 1"),
        ({"u": arrays["u"][:, :3]}, "not of one shape"),
        ({"object": arrays["object"] + 70}, "object 70 is not in the batch"),
    ]
    for change, message in wrong:
        with pytest.raises(UsageError, match=message):
            samples.rebind(arrays | change)
    with pytest.raises(UsageError, match="no array `element`"):
        samples.rebind({name: array for name, array in arrays.items() if name != "element"})
    with pytest.raises(UsageError, match="points of 6 objects on a batch of 1"):
        samples.object(0).rebind(samples.points(5))
    with pytest.raises(UsageError, match="one for each of"):
        samples.points(5, np.zeros(3))


WRONG = [
    ({"n": 0}, "the number of points is 0"),
    ({"n": -5}, "the number of points is -5"),
    ({"n": 2.5}, "a whole number is needed"),
    ({"n": True}, "a whole number is needed"),
    ({"n": 10**9}, "give a number from 1 to 1000000"),
    ({"n": 10, "per": "part"}, "per is 'part'"),
    ({"n": 10, "surface": "inside"}, "boundary, outside"),
    ({"n": 10, "spread": "pink"}, "random, blue"),
]


@pytest.mark.parametrize("how, message", WRONG, ids=[message for _, message in WRONG])
def test_silly_values_are_told_in_words(samples: apg.Samples, how: dict, message: str) -> None:
    with pytest.raises(UsageError, match=message):
        samples.points(**how)


@pytest.mark.parametrize("n", [1, 256, 100_000])
def test_any_density(samples: apg.Samples, n: int) -> None:
    points = samples.object(1).points(n)
    assert points.position.shape == (1, n, 3) and np.isfinite(points.position).all()
    assert len(np.unique(points.position[0], axis=0)) == n
    assert Sampling(n).plain()["points"] == n


def test_an_object_without_surface_is_told_in_words(samples: apg.Samples, monkeypatch: pytest.MonkeyPatch) -> None:
    """Every program has a root part with a solid, so what is buried whole is made up here: all candidates are hidden."""
    from artipg_dsl.geometry import hidden

    monkeypatch.setattr(
        hidden.Occlusion, "flat_hidden", lambda self, g, first, start, count, u, v: np.ones(len(u), bool)
    )
    monkeypatch.setattr(hidden.Occlusion, "loose_hidden", lambda self, cell, *where: np.ones(len(cell), bool))
    with pytest.raises(UserError, match="Microwave 2 has no surface"):
        samples.object(2).points(10)
