"""What was hidden is completed where the details of a primitive follow its symmetries, and stays bare where they do not."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace

import numpy as np
import pytest

import artipg_dsl as apg
from artipg_dsl import random
from artipg_dsl.details.binding import Real, bind
from artipg_dsl.details.completion import lend
from artipg_dsl.details.elements import Solids
from artipg_dsl.details.record import DIRECT, MIRRORED, SHIFTED, TURNED, Details
from artipg_dsl.geometry import points as geometry
from artipg_dsl.runtime.batch import Batch

DEEP = 0.01  # metres, of what is on the surface
BOX = "root part body : Cuboid(size = [20cm, 30cm, 50cm])"
ROD = "root part body : Cylinder(radius = 8cm, height = 50cm) along z"
COVERED = """root part body : Cuboid(size = [20cm, 30cm, 50cm])
  part cover : Cuboid(size = [5cm, 10cm, 50cm])
  align cover.back = body.front
  align cover.left = body.left
  align cover.bottom = body.bottom
  connect cover to body"""

Relief = Callable[[np.ndarray], np.ndarray]


def batch_of(parts: str) -> Batch:
    return apg.load(f"apg 1\nuse primitives {{ Cuboid, Cylinder }}\ncategory Thing {{\n  {parts}\n}}\n").batch


def real(batch: Batch, relief: Relief, n: int = 6000) -> Real:
    """The surface of an object, off the structure by the relief of each place (z from the middle)."""
    made = geometry.sample(batch.sites(), 1, n, random.key(3, "test"), np.zeros(1, dtype=np.uint64), outside=True)
    mixed = np.random.default_rng(1).permutation(n)
    place, normal = made.position[0][mixed], made.normal[0][mixed]
    depth = DEEP * relief(place - [0, 0, 0.25])
    return Real("thing", place + depth[:, None] * normal, normal, np.zeros(n, dtype=np.int64), ("all",))


def told(parts: str, relief: Relief, hidden: Relief) -> tuple[Details, np.ndarray, dict[str, np.ndarray]]:
    """The details of a region that is held out, which of them are lent, and what is lent."""
    batch = batch_of(parts)
    details, solids = bind(batch, real(batch, relief), 4000), Solids.of(batch.sites())
    place = solids.frames(details.elements, details.element, details.patch, details.u, details.v).place
    exact = np.zeros_like(details.offset)  # so that nothing but symmetries is asked for
    exact[:, 0] = DEEP * relief(place)
    details = replace(details, offset=exact)
    out = hidden(place).astype(bool)
    rest, true = details.take(np.flatnonzero(~out)), details.take(np.flatnonzero(out))
    at, lent = lend(rest, solids, (true.element, true.patch, true.u, true.v))
    return true, at, lent


CASES = [
    (BOX, lambda p: np.sin(40 * np.abs(p[:, 1])), lambda p: (p[:, 1] > 0.04) & (p[:, 2] > 0.05), MIRRORED),
    (ROD, lambda p: np.sin(40 * p[:, 2]), lambda p: (p[:, 0] > 0.02) & (p[:, 1] > 0), None),
    (
        ROD,
        lambda p: np.sin(4 * np.arctan2(p[:, 1], p[:, 0]) + 20 * p[:, 2]),
        lambda p: (p[:, 0] > 0.02) & (p[:, 1] > 0),
        TURNED,
    ),
    (
        BOX,
        lambda p: np.sin(2 * np.pi * p[:, 2] / 0.1875) * (1 + 3 * p[:, 1]),
        lambda p: np.abs(p[:, 2] - 0.1) < 0.05,
        SHIFTED,
    ),
]


@pytest.mark.parametrize(("parts", "relief", "hidden", "how"), CASES, ids=["mirror", "band", "spiral", "rows"])
def test_what_follows_a_symmetry_is_lent(parts: str, relief: Relief, hidden: Relief, how: int | None) -> None:
    true, at, lent = told(parts, relief, hidden)
    side = np.abs(true.offset[at, 0]) > 0.2 * DEEP
    assert len(at) > 0.6 * len(true)
    way = lent["offset"] - true.offset[at]
    assert np.abs(way[:, 0]).mean() < 0.25 * np.abs(true.offset[at, 0]).mean()
    assert (np.sign(lent["offset"][side, 0]) == np.sign(true.offset[at][side, 0])).mean() > 0.95
    assert (lent["label"] == 0).all() and (lent["how"] != DIRECT).all()
    assert how is None or (lent["how"] == how).mean() > 0.5


def test_what_follows_none_is_not() -> None:
    def ragged(p: np.ndarray) -> np.ndarray:  # a value of its own for each cell of 2 cm
        cell = np.floor(p / 0.02).astype(np.int64)
        return 2.0 * (np.sin(cell @ np.array([12.9898, 78.233, 37.719])) * 43758.5453 % 1.0) - 1.0

    true, at, _ = told(BOX, ragged, lambda p: (p[:, 1] > 0.04) & (p[:, 2] > 0.05))
    assert len(at) < 0.2 * len(true)


def test_what_another_part_hides_is_completed() -> None:
    batch = batch_of(COVERED)
    relief: Relief = lambda p: np.cos(25 * p[:, 1])  # noqa: E731
    plain = bind(batch, real(batch, relief), 4000, "both")
    whole = bind(batch, real(batch, relief), 4000, "both", completed=True)
    assert (plain.how == DIRECT).all() and np.array_equal(whole.offset[: len(plain)], plain.offset)
    more = whole.take(np.arange(len(plain), len(whole)))
    assert len(more) and (more.how != DIRECT).all()
    solids = Solids.of(batch.sites())
    place = solids.frames(more.elements, more.element, more.patch, more.u, more.v).place
    body = more.elements.site[more.element] == 0
    covered = body & (place[:, 0] > 0.099) & (place[:, 1] > 0.06)
    assert covered.sum() > 30  # the front of the body behind its cover, where its right half tells of the left
    expected = DEEP * np.cos(25 * place[covered, 1])
    assert np.abs(more.offset[covered, 0] - expected).mean() < 0.4 * np.abs(expected).mean()
    assert (body & (place[:, 0] > 0.099) & (np.abs(place[:, 1]) < 0.03)).sum() < 3  # that was seen


def test_a_single_point_tells_of_no_other() -> None:
    """Nor how far points lie apart, so that nothing counts as hidden."""
    batch = batch_of(BOX)
    whole = real(batch, lambda p: np.zeros(len(p)))
    address = batch.numbers.astype(np.uint64)
    (at,) = geometry.sample(batch.sites(), 1, 1, random.key(batch.seed, "details"), address, outside=True).position[0]
    near = np.argsort(((whole.points - at) ** 2).sum(axis=1))
    details = bind(batch, replace(whole, points=whole.points[near], normals=whole.normals[near]), 1, "nearest", True)
    assert len(details) == 1 and (details.how == DIRECT).all()
