"""What is said of how a part stands, and of the alternatives it has, counts for every kind of part: of a template, of a role
with alternatives, of a style, mounted or placed."""

from __future__ import annotations

import numpy as np
import pytest

from artipg_dsl.annotate.annotation import annotate
from artipg_dsl.session import Session

HEAD = """apg 1
use primitives { Cuboid, Cylinder }
use materials { oak, steel }
role R { inherit size : length[3]  port seam : frame }
template A : R { part w : Cuboid(size = size)  port seam = frame(at = front.center, out = x, up = z) }
template B : R { part w : Cuboid(size = size)  port seam = frame(at = front.center, out = x, up = z) }
template U { param form : style R  part h : form(size = [1cm, 2cm, 3cm]) turned 90deg about x }
"""
SIZE = "(size = [1cm, 2cm, 3cm])"
ABOUT_X, ALONG_X, STILL = (0.707, 0.707, 0.0, 0.0), (0.5, 0.5, 0.5, 0.5), (1.0, 0.0, 0.0, 0.0)


def category(body: str) -> str:
    return (
        f"{HEAD}category T {{\n  root part body : Cuboid(size = [50cm, 50cm, 1cm])\n  param c : choice yes | no = yes\n"
        f"{body}\n}}\n"
    )


def standing(body: str, name: str = "p") -> dict[str, set[tuple[float, ...]]]:
    """How a part is turned in each of its templates."""
    batch = Session.of_text(category(body)).sampler.batch(np.arange(10), seed=1)
    found: dict[str, set[tuple[float, ...]]] = {}
    for told in annotate(batch):
        for part in told["parts"]:
            if part["name"] == name:
                turned = np.round(part["quaternion"], 3) * (1 if part["quaternion"][0] >= 0 else -1)
                found.setdefault(part["template"], set()).add(tuple(turned.tolist()))
    return found


@pytest.mark.parametrize(
    ("body", "turned"),
    [
        (f"  style f : R = A\n  part p : f{SIZE} turned 90deg about x", {"A": ABOUT_X}),
        (f"  style f : R = A\n  part p : f{SIZE} along x", {"A": ALONG_X}),
        (f"  style f : R = A | B\n  part p : f{SIZE} turned 90deg about x", {"A": ABOUT_X, "B": ABOUT_X}),
        (f"  style f : R = A turned 90deg about x | B\n  part p : f{SIZE}", {"A": ABOUT_X, "B": STILL}),
        (f"  style f : R = A turned 90deg about x\n  part p : f{SIZE} turned -90deg about x", {"A": STILL}),
        (f"  part p : R{SIZE} = A turned 90deg about x | B along x", {"A": ABOUT_X, "B": ALONG_X}),
        (f"  part p : R{SIZE} turned 90deg about x = A | B", {"A": ABOUT_X, "B": ABOUT_X}),
    ],
    ids=["style", "along", "style of two", "in the style", "in both", "alternatives", "role"],
)
def test_the_turn_counts(body: str, turned: dict[str, tuple[float, ...]]) -> None:
    assert standing(body + "\n  connect p to body") == {name: {at} for name, at in turned.items()}


@pytest.mark.parametrize("given", ["A", "f"])
def test_the_turn_of_a_style_that_is_handed_in(given: str) -> None:
    body = f"  style f : R = A\n  part p : U(form = {given})\n  connect p to body"
    assert standing(body, "p.h") == {"A": {ABOUT_X}}


def test_a_mounted_part_lies_as_it_says() -> None:
    """A face names a side of the box as the part lies: the cylinder stands out of the wall."""
    body = "  part p : Cylinder(radius = 1cm, height = 6cm) along x\n  connect p.back to body.front"
    (told,) = annotate(Session.of_text(category(body)).sampler.batch(np.arange(1), seed=1))
    (p,) = (part for part in told["parts"] if part["name"] == "p")
    assert p["center"][0] == pytest.approx(0.25 + 0.03) and tuple(p["quaternion"]) == pytest.approx(ALONG_X)


@pytest.mark.parametrize(
    "way",
    [
        f"  part p : A{SIZE} when c == yes",
        f"  style f : R = A | B\n  part p : f{SIZE} when c == yes",
        f"  part p : R{SIZE} = A when c == yes | B when c == yes",
    ],
)
def test_an_alternative_is_there_where_its_guard_holds(way: str) -> None:
    batch = Session.of_text(category(way + "\n  connect p to body")).sampler.batch(np.arange(10), seed=1)
    shown = [any(part["name"] == "p" for part in told["parts"]) for told in annotate(batch)]
    assert shown == [batch.drawn(k)["c"] == "yes" for k in range(10)] and 0 < sum(shown) < 10


@pytest.mark.parametrize(
    ("body", "code", "message"),
    [
        (
            f"  part p : A{SIZE} turned 90deg about x\n  connect p.seam to body.top",
            "over-determined",
            "`p` is turned here, but its mount turns with it, so the turn has no effect",
        ),
        (
            f"  part p : A{SIZE} weight 3\n  connect p to body",
            "unknown-clause",
            "a weight has no effect without another alternative",
        ),
        (
            f"  style f : R = A | B\n  part p : f{SIZE} | none\n  connect p to body",
            "wrong-kind",
            "`f` is a style: it cannot be combined with a role or other alternatives",
        ),
        (
            f"  style l : material = oak turned 90deg about x | steel\n  part p : A{SIZE}\n  connect p to body\n  material l on p",
            "unknown-clause",
            "a material takes no arguments and cannot be turned",
        ),
    ],
    ids=["mounted by a port", "a sole weight", "a style among others", "a turned material"],
)
def test_what_would_be_lost_is_refused(body: str, code: str, message: str) -> None:
    session = Session.of_text(category(body))
    assert session.lowering is None
    assert [(d.code, d.message) for d in session.report.diagnostics if d.severity == "error"] == [(code, message)]
