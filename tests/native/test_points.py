"""Points on surfaces: compiled code draws, hides and keeps the candidates that NumPy does, to the last bit."""

import numpy as np
import pytest

from artipg_dsl import random
from artipg_dsl.geometry import points
from artipg_dsl.geometry.cells import Cells
from artipg_dsl.geometry.flat import BENT, PLANAR
from artipg_dsl.geometry.pointset import PointSet
from artipg_dsl.geometry.pointset import Pools as PointPools
from artipg_dsl.native import points as native
from artipg_dsl.runtime.fields import Field
from artipg_dsl.session import Session
from artipg_dsl.validity.formulas import _Place

from .machine import bits, needs_compiler

pytestmark = needs_compiler
KEY = random.key(5, "points")
N = 200  # points of a pool


def mixing(pools):
    return random.orders(pools.label.astype(np.uint64), N)


@pytest.mark.parametrize("outside", [False, True])
@pytest.mark.parametrize(
    "name, per, objects", [("Microwave", "instance", 1), ("Kettle", "owner", 3), ("Lamp", "link", 4)]
)
@pytest.mark.some
def test_points_of_pools(using, monkeypatch, name, per, objects, outside):
    """Pools with more points than fit a round, with few, and with none that can be seen."""
    batch, calls = Session.of(name).sampler.batch(np.arange(objects), 2), []
    monkeypatch.setattr(native, "_ROOM", 1)  # there is more than there is room for at first
    monkeypatch.setattr(points, "_ROUNDS", 3)  # those after them are like the third
    words = ("coarse", "near_rows", "near_flat", "near_loose", "keep")
    for word in words:
        original = getattr(native, word)
        monkeypatch.setattr(native, word, lambda *a, of=original, called=word: calls.append(called) or of(*a))
    sites = batch.sites()
    labels = [np.zeros(len(site), dtype=np.int64) if per == "owner" else getattr(site, per) for site in sites]
    address = batch.numbers.astype(np.uint64)
    found = []
    for backend in ("numpy", "c"):
        using(backend)
        assert (backend == "c") or not calls
        found.append(points.sample_pools(sites, labels, objects, N, KEY, address, outside=outside))
        mixed, pools, _ = points.sample_pools(sites, labels, objects, N, KEY, address, outside=outside, order=mixing)
        expected = found[-1][0].take((np.arange(len(pools.label))[:, None], mixing(pools)))
        for field in PointSet.__slots__:
            assert bits(getattr(mixed, field)) == bits(getattr(expected, field)), field
    for field in PointSet.__slots__:
        assert bits(getattr(found[0][0], field)) == bits(getattr(found[1][0], field)), field
    assert bits(found[0][2]) == bits(found[1][2]) and found[0][0].u.shape[1] == N
    assert set(calls) == set(words)


@pytest.mark.parametrize("backend", ["numpy", "c"])
@pytest.mark.parametrize("name", ["Microwave", "Kettle", "Bottle"])
def test_pools_that_get_no_points_change_nothing_for_others(using, name, backend):
    """Rows that lie far from all that get points are left out, and rows that may hide points are not."""
    using(backend)
    sites = Session.of(name).sampler.batch(np.arange(4), 2).sites()
    pools = PointPools.of(sites, [np.asarray(site.rank) + 7 * site.number for site in sites], 4)
    every = np.full(len(pools.owner), 90)
    address = np.arange(4, dtype=np.uint64)
    whole, full, area = points.sample_counts(sites, pools, every, KEY, address)
    asked = np.arange(len(every)) % 5 == 2
    some, some_full, some_area = points.sample_counts(sites, pools, np.where(asked, every, 0), KEY, address)
    assert (some_full[asked] == full[asked]).all() and bits(some_area[asked]) == bits(area[asked])
    for field in PointSet.__slots__:
        seen = [getattr(found, field)[asked & full] for found in (whole, some)]
        assert len(seen[0]) and bits(np.ascontiguousarray(seen[0])) == bits(np.ascontiguousarray(seen[1])), field


@pytest.mark.parametrize("name", ["Microwave", "StorageFurniture"])
def test_what_labels_read_at_points(using, name):
    """Places and directions in the frames of targets, mirrored ones too."""
    batch = Session.of(name).sampler.batch(np.arange(4), 2)
    made = points.sample(batch.sites(), 4, 700, KEY, np.arange(4, dtype=np.uint64))
    told: list[dict] = []
    for backend in ("numpy", "c"):  # once each: the machine is compiled anew
        using(backend)
        told.append({})
        for number, label in enumerate(batch.program.labels):
            for target in label.targets:
                at = np.flatnonzero(made.site == target.site)
                row, scope = made.row.ravel()[at], batch.program.sites[target.site].scope
                names = {name for name in Field.of(label.formulas).names if "." in name}
                place = _Place(batch, target, scope, names, True)
                values = place.variables(row, at, made)
                told[-1] |= {(number, target.site, name): (values[name], place.mirror[row]) for name in names}
    assert told[0].keys() == told[1].keys()
    for key, (values, _) in told[0].items():
        assert bits(values) == bits(told[1][key][0]), key
    assert {key[2] for key, (values, _) in told[0].items() if len(values)} >= {"p.y", "n.x"}
    assert name == "Microwave" or any((mirror < 0).any() for key, (_, mirror) in told[0].items() if key[2] == "p.y")


def test_cells_of_all_shapes_are_looked_at():
    """The objects above have parallelograms, other quads and bent patches."""
    kinds: set[int] = set()
    for name in ("Microwave", "Kettle", "Lamp"):
        sites = Session.of(name).sampler.batch(np.arange(3), 2).sites()
        kinds |= set(Cells(points.block_of(sites, 0, 3)).shape.tolist())
    assert kinds >= {BENT, PLANAR, 0}
