"""A place that `at` names lies on its surface: beyond, the formulas of the surface would give places in the air."""

from __future__ import annotations

import numpy as np
import pytest

from artipg_dsl.sampling.statistics import Statistics
from artipg_dsl.session import Session

USES = "use primitives { Cuboid, Cylinder, HollowFrustum }\nuse cups { Cup, BowlCup }"
BODY = "root part body : Cylinder(radius = 4cm, height = 10cm)\n"
PEG = "part a : Cuboid(size = [1cm, 1cm, 1cm]){}\nconnect a.bottom to {}\n"


def session(body: str, before: str = "") -> Session:
    return Session.of_text(f"apg 1\n{USES}\n{before}category T {{\n{body}}}\n")


def warned(made: Session) -> list[str]:
    """What `check` says of values that are not there."""
    return [d.message for d in made.examine().diagnostics if d.code == "undefined-value"]


def drawn(made: Session, name: str, count: int = 200) -> tuple[list[float], int]:
    """The values of a parameter, and how many attempts they took."""
    counted = Statistics()
    batch = made.sampler.batch(np.arange(count), seed=2, statistics=counted)
    return [float(v) for v in batch.values()[name]], counted.attempts


@pytest.mark.parametrize(
    ("solid", "place"),
    [
        ("Cylinder(radius = 4cm, height = 10cm)", "side.at(0.25turn, z = 5cm)"),  # on the rim
        ("Cylinder(radius = 4cm, height = 10cm)", "side.at(-3.25turn, z = 0)"),  # it goes around
        ("HollowFrustum(radius = 5cm, bore = 4cm, height = 5cm)", "outer.at(0.75turn, z = 1cm)"),
        ("HollowFrustum(radius = 5cm, bore = 4cm, height = 5cm, span = 90deg)", "outer.at(45deg, z = 1cm)"),
        ("HollowFrustum(radius = 5cm, bore = 4cm, height = 5cm, span = 90deg)", "outer.at(330deg, z = 1cm)"),
        ("HollowFrustum(radius = 5cm, bore = 4cm, height = 5cm, span = 90deg)", "start.at(0.5, 0.5)"),
    ],
)
def test_places_on_a_surface_ask_nothing(solid: str, place: str) -> None:
    made = session(f"root part body : {solid}\n" + PEG.format("", f"body.{place}"))
    assert not made.report.failed and warned(made) == []
    assert made.lowering is not None and not made.lowering.context.undefined


def test_an_object_whose_place_lies_beyond_is_drawn_again_and_told() -> None:
    made = session("param h : length in 1cm .. 9cm\n" + BODY + PEG.format("", "body.side.at(0.25turn, z = h)"))
    (message,) = warned(made)
    assert message.startswith("`body.side.at(0.25turn, z = h)` has no value in ")
    assert message.endswith(" attempts at an object: the place lies beyond the surface")
    values, attempts = drawn(made, "h")
    assert max(values) <= 0.05 and max(values) > 0.045  # half the height
    assert attempts > 300


@pytest.mark.parametrize("direct", [True, False])
def test_a_place_counts_where_the_part_exists_that_goes_there(direct: bool) -> None:
    """A part that is not there goes nowhere, be the place named by a `let` or written out."""
    place = "body.side.at(0.25turn, z = h)"
    let = "" if direct else f"let spot = {place}\n"
    peg = PEG.format(" | none", place if direct else "spot")
    made = session("param h : length in 1cm .. 9cm\n" + BODY + let + peg)
    batch = made.sampler.batch(np.arange(200), seed=2)
    alone = np.bincount(batch.parts().owner) == 1
    absent = batch.values()["h"][alone]
    assert len(absent) and absent.max() > 0.06
    assert batch.values()["h"][~alone].max() <= 0.05


SPOT = "let spot = body.side.at(0.25turn, z = h)\n"
PLATE = "part a : Cuboid(size = [1cm, 1cm, 1cm])\nconnect a.back on body.front\nalign a.top = {}\n"
CHOICE = "param kind : choice on_it | apart\n"


@pytest.mark.parametrize(
    ("body", "counts"),
    [
        (PLATE.format("0cm"), "never"),  # nothing reads it
        (CHOICE + "let high = spot.origin.z\n" + PLATE.format("high if kind == on_it else 0cm"), "sometimes"),
        (CHOICE + "let high = spot.origin.z if kind == on_it else 5cm\n" + PLATE.format("high"), "sometimes"),
        (CHOICE + "when kind == on_it {\n" + PEG.format("", "spot") + "}\n", "sometimes"),
        (
            CHOICE + "when kind == on_it {\nrepeat row[i] in 0 ..< 2 {\n" + PEG.format("", "spot") + "}\n}\n",
            "sometimes",
        ),
        (
            "let far = spot.origin.z if h > 9cm else 0cm\n"
            + PLATE.format("far")
            + PEG.format("", "spot").replace("part a", "part b").replace("connect a", "connect b"),
            "always",
        ),
        (PLATE.format("5cm if spot.origin.z > 9cm else spot.origin.z"), "always"),
    ],
)
def test_a_let_that_names_a_place_counts_where_it_is_read(body: str, counts: str) -> None:
    made = session("param h : length in 1cm .. 9cm\n" + BODY + SPOT + body)
    batch = made.sampler.batch(np.arange(100), seed=2)
    values = batch.values()
    there = {
        "never": np.zeros(100, bool),
        "always": np.ones(100, bool),
        "sometimes": np.array([v == "on_it" for v in values.get("kind", ())]),
    }[counts]
    assert (values["h"][there] <= 0.05 + 1e-6).all()
    assert there.all() or values["h"][~there].max() > 0.06


def test_a_condition_may_keep_a_place_on_its_surface() -> None:
    chosen = "let high = body.side.at(0.25turn, z = h).origin.z if h <= 5cm else 5cm\n"
    peg = "part a : Cuboid(size = [1cm, 1cm, 1cm])\nconnect a.back on body.front\nalign a.top = high\n"
    made = session("param h : length in 1cm .. 9cm\n" + BODY + chosen + peg)
    assert warned(made) == [] and max(drawn(made, "h")[0]) > 0.06


HALVES = """primitive Halves {{
  param r : length > 0  test 4cm .. 6cm
  surface round  (u in 0 .. 1, v in {0}turn .. {1}turn) = [r * cos(v), r * sin(v), (1/2 - u) * 4cm]
  surface other  (u in 0 .. 1, v in {1}turn .. {0}turn + 1turn) = [r * cos(v), r * sin(v), (1/2 - u) * 4cm]
  surface upper  (u in 0 .. 1, v in {0}turn .. {1}turn) = [u * r * cos(v), u * r * sin(v), 2cm]
  surface upper2 (u in 0 .. 1, v in {1}turn .. {0}turn + 1turn) = [u * r * cos(v), u * r * sin(v), 2cm]
  surface lower  (u in 0 .. 1, v in {0}turn .. {1}turn) = [(1 - u) * r * cos(v), (1 - u) * r * sin(v), -2cm]
  surface lower2 (u in 0 .. 1, v in {1}turn .. {0}turn + 1turn) = [(1 - u) * r * cos(v), (1 - u) * r * sin(v), -2cm]
  inside (p) = max(hypot(p.x, p.y) - r, abs(p.z) - 2cm)
  box = [2 * r, 2 * r, 4cm]
}}
"""


@pytest.mark.parametrize(
    ("turns", "way", "place"),
    [
        ((0.25, 0.75), "y = 3cm", [-0.04, 0.03]),  # past the quarter turn at which the inverse of the sine ends
        ((0.25, 0.75), "y = -3cm", [-0.04, -0.03]),
        ((-0.25, 0.25), "x = 4cm", [0.04, -0.03]),  # of two places that of the lower v
        ((0.5, 1), "x = -3cm", [-0.03, -0.04]),
        ((0, 0.5), "y = 4cm", [0.03, 0.04]),
    ],
)
def test_a_place_is_found_all_along_a_curve_that_turns_back(
    turns: tuple[float, float], way: str, place: list[float]
) -> None:
    made = session(
        "root part body : Halves(r = 5cm)\n" + PEG.format("", f"body.round.at(0.5, {way})"), HALVES.format(*turns)
    )
    assert made.lowering is not None and not made.lowering.context.undefined
    parts = made.sampler.batch(np.arange(2), seed=1).parts()
    foot = parts.translation[1::2] + parts.rotation[1::2] @ [0, 0, -0.005] - parts.translation[::2]
    np.testing.assert_allclose(foot, [[*place, 0]] * 2, atol=1e-9)


def test_of_the_surfaces_of_a_slot_the_one_is_taken_on_which_the_place_lies() -> None:
    """A bowl is round below and upright above: a place below its upright wall lies on the round part."""
    bowl = "root part body : Cup(radius = 6cm, height = 10cm, wall = 3mm) = BowlCup(deep = 0.6, base_share = 0.5, flare = 1)\n"
    made = session("param h : length in 1cm .. 95mm\n" + bowl + PEG.format("", "body.wall_face.at(0turn, z = h)"))
    assert warned(made) == []
    batch = made.sampler.batch(np.arange(60), seed=2)
    parts, tall = batch.parts(), batch.values()["h"]
    foot = parts.translation[2::3] + parts.rotation[2::3] @ [0, 0, -0.005] - parts.translation[::3]
    across = np.sqrt(np.maximum(1 - (1 - tall / 0.06) ** 2, 0))
    radius = np.where(tall < 0.06, 0.03 + 0.03 * across, 0.06)
    np.testing.assert_allclose(foot[:, 2] + 0.05, tall, atol=1e-9)
    np.testing.assert_allclose(foot[:, 0], radius, atol=1e-9)
