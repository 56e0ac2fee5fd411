"""`check` tells parts inside others, of which nothing is seen: all of a part, or one half of a mirror."""

from __future__ import annotations

import tracemalloc
from textwrap import dedent

import numpy as np
import pytest

from artipg_dsl.diagnostics.codes import CODES
from artipg_dsl.session import Session
from artipg_dsl.validity.buried import find_buried

BODY = "param wide : length in 30cm .. 40cm\nroot part body : Cuboid(size = [30cm, wide, 20cm])\n"
POST = "part post : Cuboid(size = [10cm, 16cm, 20cm])\nconnect post.bottom on body.top\nalign post.center.y = {}\n"
HALVES = "repeat side[i] mirror across y {{\npart ear : Cuboid(size = [1cm, 1cm, 1cm])\nconnect ear to body\n{}\n}}\n"
OVER = "align ear.center.z = body.top + 5cm\n"


def buried(text: str) -> list[tuple[str, str]]:
    uses = "use primitives { Cuboid, HollowFrustum }\nuse bodies { OpenBox }"
    report = Session.of_text(f"apg 1\n{uses}\ncategory T {{\n{BODY}{text}}}\n").examine()
    assert not report.failed
    found = [d for d in report.diagnostics if d.code == "buried"]
    return [(d.span.text.split(" ")[0] if d.span else "", d.message) for d in found]


@pytest.mark.parametrize("at", ["center.y = 3cm", "left = body.left"])  # deep inside, and flush with its side
def test_a_part_within_another_is_told(at: str) -> None:
    told = buried(f"part peg : Cuboid(size = [2cm, 2cm, 2cm])\nconnect peg to body\nalign peg.{at}\n")
    assert told == [("peg", "nothing of `peg` is seen: it lies inside `body`, in every object examined")]


@pytest.mark.parametrize("at", ["left = body.left + 1mm", "bottom = body.top"])
def test_what_is_seen_is_not_told(at: str) -> None:
    assert buried(f"part peg : Cuboid(size = [2cm, 2cm, 2cm])\nconnect peg to body\nalign peg.{at}\n") == []


def test_a_part_in_a_hollow_is_not_told() -> None:
    text = "part jar : OpenBox(size = [30cm, 30cm, 20cm], wall = 1cm)\nconnect jar.bottom on body.top\n"
    pane = "part pane : Cuboid(size = [2cm, 2cm, 2cm])\nconnect pane to jar\nalign pane.center = jar.center\n"
    assert buried(text + pane) == []
    ring = "part ring : HollowFrustum(radius = 9cm, bore = 8cm, height = 2cm)\nconnect ring.bottom on body.top\n"
    disc = "part bar : Cuboid(size = [17cm, 1cm, 1cm])\nconnect bar to ring\nalign bar.center = ring.center\n"
    assert buried(ring + disc) == []  # both ends lie in the ring


def test_a_part_that_lies_within_in_some_objects_is_not_told() -> None:
    text = "part peg : Cuboid(size = [2cm, 2cm, 2cm])\nconnect peg to body\nalign peg.left = body.center.y + 17cm\n"
    assert buried(text) == []


def test_the_half_of_a_mirror_that_lies_within_is_told() -> None:
    """The post stands to the left of the plane, and the ear is stated beside its left side: its image comes into the post."""
    ear = HALVES.format(OVER + "align ear.center.y = 3cm")
    assert buried(POST.format("-6cm") + ear) == [
        ("ear", "one of the two halves of `side.ear` lies inside `post`, in every object examined")
    ]
    assert buried(POST.format("0") + HALVES.format(OVER + "align ear.right = 8cm")) == []


def test_some_elements_of_a_row_that_lie_within_are_told() -> None:
    pegs = "repeat row[i] in 0 ..< 3 spread body along y margin 2cm {\npart peg : Cuboid(size = [2cm, 2cm, 2cm])\n"
    text = pegs + "connect peg.bottom on body.top\nalign peg.center.y = row.center.y\n}\n"
    assert buried(POST.format("0") + text) == [
        ("peg", "some elements of `row.peg` lie inside `post`, in every object examined")
    ]


def test_of_many_parts_only_neighbours_are_compared() -> None:
    mat = Session.of_text(dedent(CODES["expensive-check"].example)).sampler.batch(np.arange(4), 0)
    mat.sites()
    tracemalloc.start()
    assert find_buried(mat) == {}
    most = tracemalloc.get_traced_memory()[1]
    tracemalloc.stop()
    assert most < 6400 * 6400 / 4, "a byte for every fourth pair"
