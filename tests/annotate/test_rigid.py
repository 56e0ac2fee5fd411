"""Labels, fields, poses, grasps and keypoints follow any rigid motion, in random joint states, on every shipped shape.

A small program around each template and primitive of the library is compiled twice: with the shape upright, and turned
and shifted as a whole. All that is said of its points must be the same at the same places, and all places and directions
must be carried. A few shapes are tried always, all of them, in eight minutes, with ``ARTIPG_EVERY=1``. Whole categories
are moved in ``test_equivariance.py``.
"""

from __future__ import annotations

import os
from itertools import islice

import numpy as np
import pytest

from annotate.probes import Shipped, shape, shipped
from artipg_dsl import random
from artipg_dsl.annotate.frames import compose, rotate
from artipg_dsl.annotate.grasps import sample_grasps, sample_keypoints
from artipg_dsl.annotate.points import label_points
from artipg_dsl.annotate.poses import part_poses
from artipg_dsl.annotate.states import joint_values, read_states
from artipg_dsl.diagnostics.model import CompileError
from artipg_dsl.geometry import points
from artipg_dsl.runtime.batch import Batch
from artipg_dsl.sampling.statistics import Exhausted
from artipg_dsl.session import Session, categories

OBJECTS, POINTS, STATES = 3, 400, "rest,random:3"
TRIED = 60  # sets of arguments, until one gives valid objects
ALWAYS = ("Cuboid", "DialPad", "Flap", "LeverHandle", "TorusSector")
SHAPES = shipped()
EVERY = os.environ.get("ARTIPG_EVERY") == "1"
# what requires more of its arguments than a probe can guess: the category that it stands in is moved as a whole instead
WITHIN = {
    "CasementFilling": "Window",
    "ClampHalf": "Clip",
    "ClipHalf": "Clip",
    "CupboardBase": "Table",
    "DoorBay": "Refrigerator",
    "DoorHutch": "Table",
    "DrawerBay": "Refrigerator",
    "FlipShades": "Eyeglasses",
    "FrenchBay": "Refrigerator",
    "GangPlate": "Switch",
    "Graduation": "Ruler",
    "KeyGrid": "Remote",
    "Letters": "Keyboard",
    "OvalVessel": "Bottle",
    "RimmedLens": "Eyeglasses",
    "ShelfHutch": "Table",
    "SpectacleFront": "Eyeglasses",
    "SwanNeck": "Faucet",
    "TopCabinet": "WashingMachine",
    "TowerHutch": "Table",
    "TwinBay": "Refrigerator",
}


def probed(tried: Shipped) -> tuple[Batch, Batch]:
    """Objects with the shape upright, and with the same shape moved."""
    wrong: Exception | None = None
    for upright, moved in islice(tried.programs(), TRIED):
        try:
            first, second = (Session.of_text(text).sampler.batch(np.arange(OBJECTS), 1) for text in (upright, moved))
        except (CompileError, Exhausted) as error:
            wrong = error
            continue
        return first, second
    raise AssertionError(f"{tried.name} could not be made: {wrong}")


def follows(name: str) -> None:
    first, second = probed(shape(name))
    assert [first.drawn(i) for i in range(OBJECTS)] == [second.drawn(i) for i in range(OBJECTS)]

    parts = first.parts()
    here = np.array([part.split(".")[0] == "probed" for part in parts.path])
    root = np.flatnonzero([part == "probed" for part in parts.path])
    a, b = parts, second.parts()
    turn = compose(b.rotation[root], np.swapaxes(a.rotation[root], 1, 2))  # of each object
    shift = b.translation[root] - rotate(turn, a.translation[root])
    assert np.abs(turn - np.eye(3)).max() > 0.5 and np.abs(shift).max() > 0.1

    def carried(owner: np.ndarray, places: np.ndarray) -> np.ndarray:
        return rotate(turn[owner], places) + shift[owner]

    # the same places on the primitives have the same labels; `touch` is no vocabulary of the library: labels within win
    made = points.sample(first.sites(), OBJECTS, POINTS, random.key(5, "points"), first.numbers.astype(np.uint64))
    position, normal = points.evaluate(second.sites(), made)
    at = np.isin(made.site, [k for k, site in enumerate(first.program.sites) if site.path.split(".")[0] == "probed"])
    owner = np.broadcast_to(np.arange(OBJECTS)[:, None], made.site.shape)[at]
    assert at.any(axis=1).all()
    assert position[at] == pytest.approx(carried(owner, made.position[at]), abs=1e-9)
    assert normal[at] == pytest.approx(rotate(turn[owner], made.normal[at]), abs=1e-9)
    there = points.PointSet(made.site, made.row, made.patch, made.u, made.v, position, normal)
    one, two = label_points(first, first.sites(), made), label_points(second, second.sites(), there)
    assert np.array_equal(one.semantic, two.semantic)
    assert one.fields["touch.push"][at].any() and one.fields["field.height"][at].any()
    for field, values in one.fields.items():
        other = two.fields[field]
        if field == "field.corner":
            values = np.where(at[..., None], rotate(turn[:, None], values.astype(np.float64)), np.nan)
            assert other == pytest.approx(values, rel=1e-5, abs=1e-5, nan_ok=True)
        elif values.dtype == bool:
            assert np.array_equal(values, other), field
        else:
            assert other == pytest.approx(values, abs=1e-6, nan_ok=True), field

    # poses, grasps, keypoints, joints and points in every joint state
    tilts = "ball" in first.joints().kind  # about the first axis square to its own, which another is where it is turned
    states = [joint_values(batch, read_states("rest" if tilts else STATES)) for batch in (first, second)]
    assert np.array_equal(states[0], states[1])
    links = np.searchsorted(first.links().owner, np.arange(OBJECTS))
    grasps = [sample_grasps(batch) for batch in (first, second)]
    keys = [sample_keypoints(batch) for batch in (first, second)]
    assert len(keys[0].owner) >= OBJECTS and len(grasps[0].owner) >= 5 * OBJECTS
    assert grasps[1].opening == pytest.approx(grasps[0].opening, abs=1e-12)
    site_link = np.concatenate([table.link for table in first.sites()])
    starts = np.cumsum([0, *(len(table) for table in first.sites())])
    link = links[owner] + site_link[starts[made.site[at]] + made.row[at]]
    for values in states[0]:
        p, q = part_poses(first, values), part_poses(second, values)
        whose = a.owner[here]
        assert q.size[here] == pytest.approx(p.size[here], abs=1e-9)
        assert q.center[here] == pytest.approx(carried(whose, p.center[here]), abs=1e-9)
        assert q.rotation[here] == pytest.approx(compose(turn[whose], p.rotation[here]), abs=1e-9)
        moves = [batch.pose(values) for batch in (first, second)]
        (point, frame, _), (carried_point, carried_frame, _) = (
            g.moved(links, *m) for g, m in zip(grasps, moves, strict=True)
        )
        assert carried_point == pytest.approx(carried(grasps[0].owner, point), abs=1e-9)
        assert carried_frame == pytest.approx(compose(turn[grasps[0].owner], frame), abs=1e-9)
        tips, shown = (
            rotate(m[0][links[k.owner] + k.link], k.point) + m[1][links[k.owner] + k.link]
            for k, m in zip(keys, moves, strict=True)
        )
        assert shown == pytest.approx(carried(keys[0].owner, tips), abs=1e-9)
        before, after = (
            rotate(m[0][link], places[at]) + m[1][link]
            for m, places in zip(moves, (made.position, position), strict=True)
        )
        assert after == pytest.approx(carried(owner, before), abs=1e-9)


@pytest.mark.some
@pytest.mark.parametrize("name", [name for name in SHAPES if name in ALWAYS or EVERY and name not in WITHIN])
def test_a_shape_carries_what_is_said_of_it(name: str) -> None:
    follows(name)


def test_the_shapes_tried_are_shipped() -> None:
    assert {*ALWAYS, *WITHIN} <= set(SHAPES) and set(WITHIN.values()) <= set(categories()) and len(SHAPES) > 100
