"""What places a part of several branches may stand behind the ``when``, under a guard of its own or none."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

from artipg_dsl.annotate.annotation import annotate
from artipg_dsl.session import Session

HEAD = "apg 1\nuse primitives { Cuboid }\n"
ROOT = "part body : Cuboid(size = [40cm, 40cm, 1cm])"
CHOICES = "param a : choice yes | no = yes\nparam b : choice red | blue = red"


def objects(body: str, way: str) -> list[tuple[Any, Any]]:
    """Where the parts stand and how the joints go, in eight objects."""
    where = {
        "category": f"category T {{\nroot {ROOT}\n{CHOICES}\n{body}\n}}",
        "repeat": f"category T {{\nroot {ROOT}\nrepeat e[i] in 0 ..< 2 {{\n{CHOICES}\n{body}\n}}\n}}",
        "template": f"template U {{\n{ROOT}\n{CHOICES}\n{body}\n}}\ncategory T {{\nroot part u : U\n}}",
    }
    batch = Session.of_text(HEAD + where[way]).sampler.batch(np.arange(8), seed=2)
    assert {str(batch.drawn(k)) for k in range(8)} > {str(batch.drawn(0))}
    told = annotate(batch)
    return [
        (
            sorted((p["name"], p["center"], p["size"]) for p in t["parts"]),
            [(j["name"], j["range"]) for j in t["joints"]],
        )
        for t in told
    ]


BRANCHES = "when a == yes {{\npart q : Cuboid(size = [1cm, 1cm, 1cm])\n{0}\n}} else {{\npart q : Cuboid(size = [2cm, 2cm, 2cm])\n{0}\n}}\n"
ONE = "when a == yes {{\npart q : Cuboid(size = [1cm, 1cm, 1cm])\n{0}\n}}\n"
PLACED = [
    "connect q.bottom on body.top at center",
    "connect q.bottom on body.top at x = 10cm, y = 3cm",
    "connect q.bottom to body.top",
    "connect q to body\nalign q.bottom = body.top\nalign q.left - 1cm = body.left",
    "joint j : prismatic body.top -> q.bottom at center gap 1mm range 0 .. 2cm",
    "when b == red {\nconnect q.bottom on body.top at center\n} else {\nconnect q.bottom on body.top at x = 5cm, y = 0\n}",
    "when b == red {\njoint j : prismatic body.top -> q.bottom at center range 0 .. 2cm\n} else {\nconnect q.bottom on body.top at center\n}",
    "connect q.bottom on body.top at center\npart r : Cuboid(size = [1cm, 1cm, 1cm])\nconnect r.bottom on q.top at center",
]


@pytest.mark.parametrize("way", ["category", "repeat", "template"])
@pytest.mark.parametrize("said", PLACED)
def test_a_part_of_both_branches_is_placed_behind_them(said: str, way: str) -> None:
    assert objects(BRANCHES.format("") + said, way) == objects(BRANCHES.format(said), way)


@pytest.mark.parametrize("said", [s for s in PLACED if "align" not in s and "part r" not in s])
def test_a_part_of_one_branch_takes_the_statement_with_it(said: str) -> None:
    assert objects(ONE.format("") + said, "category") == objects(ONE.format(said), "category")


def test_what_hangs_on_a_part_of_both_branches_may_stand_before_them() -> None:
    r = "part r : Cuboid(size = [1cm, 1cm, 1cm])\nconnect r to body\n"
    q = BRANCHES.format("connect q.bottom on body.top at center")
    assert objects(r + q + "align r.bottom = q.top", "category")[0][0][2][1][2] == pytest.approx(0.025)
    for (parts, _), (others, _) in zip(
        objects(r + q + "align r.bottom = q.top", "category"),
        objects(q + r + "align r.bottom = q.top", "category"),
        strict=True,
    ):
        assert parts == others
