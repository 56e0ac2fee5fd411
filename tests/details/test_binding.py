"""Details are bound to a structure and worn by it again: what comes back is the real surface."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from scipy.spatial import cKDTree

import artipg_dsl as apg
from artipg_dsl import random
from artipg_dsl.api import Samples
from artipg_dsl.details.assign import ASSIGNMENTS
from artipg_dsl.details.binding import Real, bind
from artipg_dsl.details.elements import Elements, Solids, elements_of
from artipg_dsl.details.measure import distances, spoiled
from artipg_dsl.details.record import Details, join, of_arrays, to_arrays
from artipg_dsl.details.refuse import _depth, find_details
from artipg_dsl.details.suits import own_suits
from artipg_dsl.details.wear import Wardrobe, Worn, wear
from artipg_dsl.errors import UserError
from artipg_dsl.geometry import points as geometry
from artipg_dsl.geometry.pointset import PointSet
from artipg_dsl.runtime.batch import Batch
from tests.cli.helpers import CHEST

ZERO = np.zeros(1, dtype=np.int64)
DEEP = 0.02  # metres, of the waves


@pytest.fixture(scope="module")
def samples() -> Samples:
    return apg.sample(CHEST, n=2, seed=4)


def drawn(samples: Samples, n: int, key: int) -> PointSet:
    batch = samples.batch
    return geometry.sample(
        batch.sites(), len(batch), n, random.key(key, "test"), batch.numbers.astype(np.uint64), outside=True
    )


def wavy(samples: Samples, number: int, n: int = 3000) -> Real:
    """The surface of a sample with waves on it, as that of a real object."""
    made = drawn(samples, n, 3).take((np.full((1, n), number), np.random.default_rng(1).permutation(n)[None]))
    place, normal = made.position[0], made.normal[0]
    depth = DEEP * np.sin(place.sum(axis=1) * 40.0)
    label = made.site[0].astype(np.int64)
    names = tuple(f"link{k}" for k in range(int(label.max()) + 1))
    return Real("wavy", place + depth[:, None] * normal, normal, label, names)


def worn_by(
    batch: Batch, points: PointSet, owner: np.ndarray, wardrobe: Wardrobe, donor: np.ndarray, strength: float = 1.0
) -> Worn:
    """Points in the details of the donors of their objects."""
    return wear(batch, points, owner, wardrobe, own_suits(batch, wardrobe.details.elements, donor), strength)


def test_what_is_bound_is_worn_again(samples: Samples) -> None:
    real = wavy(samples, 0)
    batch = samples.job.batch([0])
    fresh = drawn(samples, 2000, 9).take(ZERO)
    before = distances(real.points, fresh.position[0], real.diagonal)["to_real"]
    floor = distances(real.points[1500:], real.points[:1500], real.diagonal)["to_real"]
    after = {}
    for name in ASSIGNMENTS:
        details = bind(batch, real, 1500, name)
        worn = worn_by(batch, fresh, ZERO, Wardrobe(details, Solids.of(batch.sites())), ZERO)
        after[name] = distances(real.points, worn.position[0], real.diagonal)["to_real"]
        if name == "mutual":
            assert (worn.bound >= 0).mean() > 0.85
            group = fresh.site[0].astype(np.int64)
            found = spoiled(fresh.position[0], fresh.normal[0], group, worn.position[0], worn.normal[0], real.diagonal)
            assert found["torn"] < 0.03 and found["inverted"] < 0.02
    assert next(iter(after)) == "mutual"  # the default
    assert before > 1.1 * floor
    assert after["mutual"] < 0.9 * floor and after["mutual"] < 0.9 * min(
        after["aware"], after["nearest"], after["transport"]
    )


def test_no_strength_is_the_structure(samples: Samples) -> None:
    batch, fresh = samples.job.batch([0]), drawn(samples, 500, 9).take(ZERO)
    wardrobe = Wardrobe(bind(batch, wavy(samples, 0), 1000), Solids.of(batch.sites()))
    bare = worn_by(batch, fresh, ZERO, wardrobe, ZERO, strength=0.0)
    assert np.abs(bare.position - fresh.position).max() < 1e-9
    assert np.abs(bare.normal - fresh.normal).max() < 1e-6
    none = worn_by(batch, fresh, ZERO, wardrobe, -np.ones(1, dtype=np.int64))
    assert (none.bound == -1).all() and np.array_equal(none.position, fresh.position)


def test_frames_carry_vectors_there_and_back(samples: Samples) -> None:
    elements, solids = elements_of(samples.batch), Solids.of(samples.batch.sites())
    chance = np.random.default_rng(0)
    element = chance.integers(len(elements), size=300)
    frames = solids.frames(elements, element, np.zeros(300, dtype=np.int64), chance.random(300), chance.random(300))
    vectors = chance.normal(size=(300, 3))
    assert np.abs(frames.out_of(frames.into(vectors)) - vectors).max() < 1e-12
    turned = elements.turned(element, vectors)
    assert np.abs(elements.local(element, turned) - vectors).max() < 1e-12


def test_details_are_the_same_after_a_file(samples: Samples) -> None:
    details = bind(samples.job.batch([0]), wavy(samples, 0), 1000)
    arrays = to_arrays(details, "hash")
    held = of_arrays(arrays, "wavy.npz", "hash")
    assert held.names == ("wavy",) and held.labels == details.labels
    assert np.abs(held.offset - details.offset).max() < 1e-8
    assert np.array_equal(held.label, details.label) and np.array_equal(held.u, details.u)
    again = to_arrays(held, "hash")
    assert all(np.array_equal(again[name], arrays[name], equal_nan=name == "element_params") for name in arrays)
    with pytest.raises(UserError, match="bound to another program"):
        of_arrays(arrays, "wavy.npz", "other")
    with pytest.raises(UserError, match="no array `offset`"):
        of_arrays({k: v for k, v in arrays.items() if k != "offset"}, "wavy.npz")
    with pytest.raises(UserError, match="is of version 7"):
        of_arrays(arrays | {"version": np.array([7])}, "wavy.npz")
    with pytest.raises(UserError, match="do not belong together"):
        of_arrays(arrays | {"element": arrays["element"] + 1000}, "wavy.npz")


def test_several_donors_are_one_wardrobe(samples: Samples) -> None:
    several = [bind(samples.job.batch([k]), wavy(samples, k), 1000) for k in range(2)]
    several[1] = replace(several[1], labels=tuple(reversed(several[1].labels)))
    both = join(several)
    assert both.labels == several[0].labels and len(both) == sum(map(len, several))
    owner = both.owner
    assert np.array_equal(np.bincount(owner), [len(one) for one in several])
    words = [np.array([*one.labels, ""])[one.label] for one in several]
    assert np.array_equal(np.array([*both.labels, ""])[both.label], np.concatenate(words))
    batch, fresh = samples.batch, drawn(samples, 1000, 9)
    worn = worn_by(batch, fresh, np.arange(2), Wardrobe(both, Solids.of(batch.sites())), np.arange(2))
    found = worn.bound[worn.bound >= 0]
    assert np.array_equal(owner[found], np.nonzero(worn.bound >= 0)[0])
    for k in range(2):  # as if each were alone
        alone = worn_by(samples.job.batch([k]), of_one(fresh, k, samples), ZERO, wardrobe_of(several[k], samples), ZERO)
        assert np.allclose(alone.position[0], worn.position[k], atol=1e-12)


def of_one(points: PointSet, number: int, samples: Samples) -> PointSet:
    """The points of one object, whose rows are counted among its own."""
    first = np.array([np.searchsorted(table.owner, number) for table in samples.batch.sites()])
    mine = points.take(np.array([number]))
    return replace(mine, row=mine.row - first[mine.site])


def wardrobe_of(details: Details, samples: Samples) -> Wardrobe:
    return Wardrobe(details, Solids.of(samples.batch.sites()))


def test_uncovered_structure_stays_bare(samples: Samples) -> None:
    real = wavy(samples, 0)
    high = np.quantile(real.points[:, 2], 0.3)
    kept = real.points[:, 2] < high
    half = replace(real, points=real.points[kept], normals=real.normals[kept], label=real.label[kept])
    batch, fresh = samples.job.batch([0]), drawn(samples, 2000, 9).take(ZERO)
    worn = worn_by(batch, fresh, ZERO, Wardrobe(bind(batch, half, 1500), Solids.of(batch.sites())), ZERO)
    above = fresh.position[0][:, 2] > high + 0.2 * real.diagonal
    assert above.any() and np.array_equal(worn.position[0][above], fresh.position[0][above])
    near = cKDTree(half.points).query(worn.position[0][worn.bound[0] >= 0])[0]
    assert np.quantile(near, 0.95) < 0.08 * real.diagonal


def test_elements_are_found(samples: Samples) -> None:
    elements: Elements = elements_of(samples.batch)
    every = np.arange(len(elements))
    assert np.array_equal(elements.find(elements.owner, elements.site, elements.rank), every)
    missing = elements.find(elements.owner, elements.site, elements.rank + 1000)
    assert (missing == -1).all()


def test_accidents_are_no_details(samples: Samples) -> None:
    """Spikes, a patch that another surface has collapsed onto, and a part of which little was found."""
    batch = samples.job.batch([0])
    solids, fresh = Solids.of(batch.sites()), drawn(samples, 3000, 3).take(ZERO)
    elements, element = elements_of(batch), fresh.site[0].astype(np.int64)
    count = np.bincount(element)
    large = int(np.argmax(count))
    patch = fresh.patch[0].astype(np.int64)
    offset = np.tile([0.003, 0.0, 0.0], (3000, 1))
    details = Details(
        elements, element, patch, fresh.u[0], fresh.v[0], offset, np.tile([1.0, 0.0, 0.0], (3000, 1)),
        np.full(3000, -1), np.zeros(3000, dtype=np.int64), ("wavy",), (), np.array([0.7]),
    )  # fmt: skip
    seen = element, patch
    assert len(find_details(details, solids, seen, 1.0)) == 3000
    spikes = np.arange(0, 3000, 30)
    details.offset[spikes, 0] = 0.05
    kept = find_details(details, solids, seen, 1.0)
    assert not np.isin(spikes, kept).any() and len(kept) > 2850
    details.offset[spikes, 0] = 0.003
    crowd = np.concatenate([np.arange(3000), np.repeat(np.flatnonzero((element == large) & (patch == 0)), 3)])
    kept = crowd[find_details(details.take(crowd), solids, seen, 1.0)]
    assert not ((element == large) & (patch == 0))[kept].any() and (element[kept] != large).any()
    few = np.flatnonzero((element != large) | (np.arange(3000) % 3 == 0))
    kept = few[find_details(details.take(few), solids, seen, 1.0)]
    assert (element[kept] != large).all() and len(kept) == (element != large).sum()
    assert len(find_details(details.take(few[:0]), solids, seen, 1.0)) == 0


def test_the_far_face_of_a_board_is_no_detail_of_the_near_one(samples: Samples) -> None:
    """Of a patch every third point went to the face behind: it goes. Where a whole half did, the board is recessed there: that stays."""
    batch = samples.job.batch([0])
    solids, fresh = Solids.of(batch.sites()), drawn(samples, 3000, 3).take(ZERO)
    elements, element = elements_of(batch), fresh.site[0].astype(np.int64)
    large = int(np.argmax(np.bincount(element)))
    patch = fresh.patch[0].astype(np.int64)
    details = Details(
        elements, element, patch, fresh.u[0], fresh.v[0], np.zeros((3000, 3)), np.tile([1.0, 0.0, 0.0], (3000, 1)),
        np.full(3000, -1), np.zeros(3000, dtype=np.int64), ("board",), (), np.array([0.7]),
    )  # fmt: skip
    face = np.flatnonzero((element == large) & (patch == np.argmax(np.bincount(patch[element == large]))))
    behind, seen = face[::3], (element, patch)
    through = -0.7 * _depth(details, solids)  # metres, to the face behind
    details.offset[behind, 0] = through[behind]
    kept = find_details(details, solids, seen, 1.0)
    assert np.isin(behind, kept).mean() < 0.02 and np.isin(np.setdiff1d(face, behind), kept).mean() > 0.9
    details.offset[face, 0] = np.where(details.u[face] < 0.5, 0.7 * through[face], 0.0)
    kept = find_details(details, solids, seen, 1.0)
    assert np.isin(face[details.u[face] < 0.4], kept).all()
