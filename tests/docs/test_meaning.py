"""A few sentences of the language reference, in numbers."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
import pytest

from artipg_dsl.runtime.batch import Batch
from artipg_dsl.session import Session

HEAD = "apg 1\nuse primitives { Cuboid, Cylinder }\n"


def batch(body: str, n: int = 60, top: str = "") -> Batch:
    text = f"{HEAD}{top}category Example {{\n  root part body : Cuboid(size = [30cm, 50cm, 20cm])\n{body}\n}}\n"
    return Session.of_text(text).sampler.batch(np.arange(n), seed=5)


def test_uniform_between_two_ends() -> None:
    made = batch("param lip : length in 1cm .. 2cm ~ uniform(12mm, 14mm)\ncount n in 1 .. 9 ~ uniform(3, 5)")
    values = made.values()
    assert values["lip"].min() >= 0.012 and values["lip"].max() <= 0.014 and np.ptp(values["lip"]) > 0.001
    assert set(values["n"].tolist()) == {3.0, 4.0, 5.0}


@pytest.mark.parametrize(
    ("law", "legal"),
    [
        ("param a : length in 1cm .. w ~ values(2cm, 4cm)", lambda a: np.isclose(a, 0.02) | np.isclose(a, 0.04)),
        ("param a : length in 1cm .. w ~ uniform(2cm, 4cm)", lambda a: (a >= 0.02) & (a <= 0.04)),
        (
            "param a : length in 1cm .. 10cm ~ values(2cm, 4cm)\nrequire a >= w",
            lambda a: np.isclose(a, 0.02) | np.isclose(a, 0.04),
        ),
        ("count a in 1 .. floor(w / 1cm) ~ values(2, 4)", lambda a: (a == 2) | (a == 4)),
        ("count a in 1 .. floor(w / 1cm) ~ uniform(2, 4)", lambda a: (a >= 2) & (a <= 4)),
    ],
)
def test_no_value_but_those_of_the_distribution(law: str, legal: Callable[[np.ndarray], np.ndarray]) -> None:
    """Where a range leaves none of them, the object is drawn again."""
    values = batch(f"param w : length in 1cm .. 10cm\n{law}", 500).values()
    assert legal(values["a"]).all() and len(np.unique(values["a"])) > 1


def test_steps_are_shares_or_amounts() -> None:
    made = batch("param a : ratio in 0.1 .. 0.9 vary 0.05\nparam b : ratio in 0.1 .. 0.9 vary 5%")
    assert [draw.vary[0] for draw in made.program.draws if draw.vary is not None] == [False, True]


def test_mimic_takes_a_factor() -> None:
    made = batch(
        "part dial : Cylinder(radius = 2cm, height = 1cm)\n"
        "joint turn : continuous body.top -> dial.bottom gap 1mm\n"
        "part hand : Cylinder(radius = 1cm, height = 1cm)\n"
        "joint follow : continuous body.left -> hand.bottom gap 1mm  mimic -2 * turn / 4",
        n=1,
    )
    joints = made.joints()
    assert joints.mimic.tolist() == [-1, 0] and joints.multiplier.tolist() == [1.0, -0.5]


def test_the_innermost_label_wins() -> None:
    box = "template Block { part core : Cuboid(size = [30cm, 50cm, 20cm]) }\nvocabulary look { plain fine }\n"
    text = (
        f"{HEAD}{box}category Example {{\n  root part body : Block\n"
        "  label look.plain on body\n  label look.fine on body.core where n.z > 0.5\n}\n"
    )
    from artipg_dsl.annotate.cloud import sample_points

    points = sample_points(Session.of_text(text).sampler.batch(np.arange(1), seed=1), 400)
    up = points.normal[0, :, 2] > 0.5
    assert up.any() and (points.labels["look.fine"][0] == up).all() and (points.labels["look.plain"][0] == ~up).all()


def test_the_part_declared_later_yields() -> None:
    made = batch(
        "part first : Cuboid(size = [1cm, 1cm, 1cm])\nconnect first to body\n"
        "part second : Cuboid(size = [1cm, 1cm, 1cm])\nconnect second to body\nalign first.left = second.right",
        n=1,
    )
    parts = made.parts()
    places = dict(zip(parts.name, parts.translation[:, 1].round(9).tolist(), strict=True))
    assert places["first"] == 0.0 and places["second"] == 0.01


def test_objects_stand_on_the_ground() -> None:
    made = batch("part foot : Cylinder(radius = 1cm, height = 7cm)\nconnect foot.top on body.bottom", n=1)
    parts = made.parts()
    assert np.isclose((parts.translation[:, 2] + parts.low[:, 2]).min(), 0.0)
