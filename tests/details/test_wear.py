"""Mutants wear the details of what they were made from: stretched, on repeated elements, on primitives of another kind."""

from __future__ import annotations

import numpy as np
import pytest

import artipg_dsl as apg
from artipg_dsl.api import Samples
from artipg_dsl.details.elements import Solids, elements_of
from artipg_dsl.details.maps import Boxes, find_turns, on_map, turn_along
from artipg_dsl.details.record import DIRECT, Details
from artipg_dsl.details.suits import Suits, own_suits
from artipg_dsl.details.wear import Wardrobe, Worn, wear
from artipg_dsl.geometry.pointset import PointSet
from artipg_dsl.geometry.vectors import dot

from .raised import RAISED, surface


@pytest.mark.parametrize("operations", ["cpa", "dpa,cpa", "apa,dpa,cpa"])
def test_mutants_are_raised_as_their_originals(samples: Samples, details: Details, operations: str) -> None:
    batch = samples.mutate(operations, strength=2.0, share=1.0 if "dpa" in operations else 0.5).batch
    points = surface(batch, 1500, 5)
    worn = wear(
        batch,
        points,
        np.arange(2),
        Wardrobe(details, Solids.of(batch.sites())),
        own_suits(batch, details.elements, np.arange(2)),
    )
    found = worn.bound >= 0
    assert found.mean() > 0.9
    way = worn.position - points.position
    height = dot(way, points.normal)[found]
    assert np.abs(np.median(height) - RAISED) < 0.15 * RAISED
    assert np.quantile(np.abs(height - RAISED), 0.8) < RAISED  # but for what a peg hides of the board
    assert np.median(dot(worn.normal, points.normal)[found]) > 0.99
    whose = np.nonzero(found)[0]
    assert np.array_equal(details.owner[worn.bound[found]], whose)


def test_new_rows_copy_the_nearest_and_lost_ones_go(samples: Samples, details: Details) -> None:
    batch = samples.mutate("dpa", share=1.0, only="pegs").batch
    elements, stock = elements_of(batch), details.elements
    match = own_suits(batch, stock, np.arange(2)).match
    assert (match >= 0).all() and np.array_equal(stock.owner[match], elements.owner)
    assert np.array_equal(stock.site[match], elements.site)
    assert not np.array_equal(np.bincount(elements.owner), np.bincount(stock.owner))
    last = np.array(
        [
            stock.rank[(stock.owner == o) & (stock.site == s)].max()
            for o, s in zip(elements.owner, elements.site, strict=True)
        ]
    )
    assert np.array_equal(stock.rank[match], np.minimum(elements.rank, last))


def test_what_is_all_larger_has_larger_details(samples: Samples, details: Details) -> None:
    from artipg_dsl.details.wear import _scales

    normal = np.array([[1.0, 0.0, 0.0]])
    speed, size = np.array([[0.2, -0.3]]), np.array([[0.1, 0.2, 0.3]])
    assert np.allclose(_scales(normal, 2.0 * speed, speed, 2.0 * size, size), 2.0)
    longer = _scales(normal, speed * [1.0, 3.0], speed, size * [1.0, 1.0, 3.0], size)
    assert np.allclose(longer, [[1.0, 1.0, 3.0]])
    thinner = _scales(normal, speed, speed, size * [0.5, 1.0, 1.0], size)
    assert np.allclose(thinner, [[0.5, 1.0, 1.0]])


def test_what_is_much_thinner_has_reliefs_as_thin(samples: Samples, details: Details) -> None:
    batch = samples.batch
    points = surface(batch, 1500, 5)
    wardrobe, suits = (
        Wardrobe(details, Solids.of(batch.sites())),
        own_suits(batch, details.elements, np.arange(len(batch))),
    )
    heights = []
    for factor in (1.0, 10.0):
        boxes = wardrobe.boxes
        wardrobe.boxes = Boxes(factor * boxes.low, factor * boxes.high, boxes.axes)  # of the donors
        worn = wear(batch, points, np.arange(len(batch)), wardrobe, suits)
        height = dot(worn.position - points.position, points.normal)[worn.bound >= 0]
        heights.append(np.median(height))
    assert heights[0] == pytest.approx(RAISED, rel=0.05)
    assert heights[1] == pytest.approx(0.1 * RAISED, rel=0.05)


def box(size: list[float], axes: np.ndarray | None = None) -> Boxes:
    half = np.array([size]) / 2
    return Boxes(-half, half, np.eye(3)[None] if axes is None else axes[None])


def test_places_on_maps() -> None:
    long = box([2.0, 4.0, 20.0])
    assert long.long.all() and not box([2.0, 3.0, 3.0]).long.any() and long.order.tolist() == [[2, 1, 0]]
    top = on_map(long.within(np.array([[1.0, 0.0, 5.0]])), np.array([2]))
    assert np.allclose(top, [[1.0, 0.0, 0.5]])  # half way up the axis
    ball = on_map(long.within(np.array([[0.0, 0.0, 10.0]])), np.array([-1]))
    assert np.allclose(ball, [[0.0, 0.0, 1.0]])


def test_vectors_turn_with_normals() -> None:
    x, y, z = (row[None] for row in np.eye(3))
    assert np.allclose(turn_along(2 * x + y, x, x), 2 * x + y)
    assert np.allclose(turn_along(2 * x + y + z, x, y), 2 * y - x + z)
    assert np.allclose(turn_along(2 * x + y, x, -x), -2 * x)
    chance = np.random.default_rng(2)
    one, other, way = chance.normal(size=(3, 100, 3))
    one, other = (v / np.sqrt(dot(v, v))[:, None] for v in (one, other))
    found = turn_along(way, one, other)
    assert np.allclose(dot(found, found), dot(way, way)) and np.allclose(dot(found, other), dot(way, one))
    across = np.cross(one, other)
    assert np.allclose(dot(found, across), dot(way, across)), "about the axis across both"


def test_long_boxes_correspond_by_length_others_by_direction() -> None:
    lying, upright = box([20.0, 4.0, 2.0]), box([2.0, 4.0, 20.0])
    (turn,) = find_turns(lying, upright)
    assert np.array_equal(np.abs(turn) @ [20.0, 4.0, 2.0], [2.0, 4.0, 20.0])
    (turn,) = find_turns(box([3.0, 4.0, 2.0]), box([2.0, 3.0, 4.0]))
    assert np.array_equal(turn, np.eye(3)), "as they stand, whichever is longer"
    reversed_z = np.array(
        [[0.0, 1.0, 0.0], [1.0, 0.0, 0.0], [0.0, 0.0, -1.0]]
    )  # its x is the y of the object, its z points down
    (turn,) = find_turns(box([3.0, 4.0, 2.0], reversed_z), box([2.0, 3.0, 4.0]))
    assert np.array_equal(turn, reversed_z)
    (turn,) = find_turns(lying, box([20.0, 4.0, 2.0], np.diag([-1.0, -1.0, 1.0])))
    assert np.array_equal(turn, np.diag([-1.0, -1.0, 1.0])), "long ones keep their direction, too"


def lent(giver: str, taker: str, way: np.ndarray) -> tuple[PointSet, PointSet, Worn]:
    """Points of the one of two bars, all of which lie off their structure by ``way``, and points of the other that wear it."""
    text = "apg 1\nuse primitives { Cuboid, RoundedCuboid }\ncategory Bars { root part bar : Bar = Giver | Taker }\n"
    text += "role Bar { slot grip }\n" + "".join(
        f"template {name} : Bar {{ part grip : {made} }}\n" for name, made in (("Giver", giver), ("Taker", taker))
    )
    one, other = (apg.load(text, n=1, set={"bar": name}).batch for name in ("Giver", "Taker"))
    solids, found = Solids.of(one.sites()), surface(one, 2000, 3)
    elements, own = elements_of(one), np.zeros(2000, dtype=np.int64)
    columns = own, *(getattr(found, name)[0] for name in ("patch", "u", "v"))
    offset = solids.frames(elements, *columns).into(np.tile(way, (2000, 1)))
    facing = np.tile([1.0, 0.0, 0.0], (2000, 1))
    details = Details(elements, *columns, offset, facing, own, own + DIRECT, ("one",), (), np.array([0.1]))
    points, suits = surface(other, 500, 5), Suits(elements_of(other), np.zeros(1, int))
    return found, points, wear(other, points, np.arange(1), Wardrobe(details, solids), suits)


def test_offsets_are_mirrored_where_axes_are() -> None:
    """An upright bar lends to a lying one of another kind: z and y are exchanged, which is a mirror."""
    way = np.array([0.0, 0.001, 0.002])
    upright, lying = "Cuboid(size = [2cm, 3cm, 10cm])", "RoundedCuboid(size = [2cm, 10cm, 3cm], radius = 1mm)"
    found, points, worn = lent(upright, lying, way)
    moved = (worn.position - points.position)[0]
    flat = (worn.bound[0] >= 0) & (np.abs(points.normal[0]).max(axis=1) > 0.999)
    alike = flat & (found.normal[0][worn.bound[0]] == np.round(points.normal[0][:, [0, 2, 1]])).all(axis=1)
    assert alike.sum() > 300 and np.allclose(moved[alike], way[[0, 2, 1]], atol=2e-5)


@pytest.mark.parametrize(("size", "reach"), [(20, 0.005), (10, 0.0025)])
def test_offsets_are_no_barbs_on_a_primitive_of_another_kind(size: int, reach: float) -> None:
    """A leg whose foot stands out by 2 cm lends to one of another kind: it moves by no more than a quarter of its thickness."""
    thin = f"RoundedCuboid(size = [{size}mm, {size}mm, 40cm], radius = 1mm)"
    _, points, worn = lent("Cuboid(size = [2cm, 2cm, 40cm])", thin, np.array([0.02, 0.0, 0.0]))
    moved = np.linalg.norm((worn.position - points.position)[0][worn.bound[0] >= 0], axis=1)
    assert len(moved) > 400 and np.allclose(moved, reach)


def test_the_inside_of_a_tub_faces_its_middle() -> None:
    tub = box([2.0, 2.0, 2.0])
    right = np.array([[1.0, 0.0, -0.5]])
    assert not tub.inward(right, np.array([[1.0, 0.0, 0.0]])).any() and tub.inward(right, -right).all()
