"""Where `at`, `gap` and `sink` put a part: within the plane of what it is mounted on, and off the side that a face has."""

from __future__ import annotations

import numpy as np
import pytest

from artipg_dsl.runtime.batch import Batch
from artipg_dsl.session import Session

CUBE = "part a : Cuboid(size = [1cm, 1cm, 1cm])"
VANE = "part v : Cuboid(size = [10cm, 10cm, 2cm]) turned 30deg about {axis}\nconnect v to body\nalign v.center = [1cm, 2cm, 30cm]\n"


def session(body: str) -> Session:
    text = f"root part body : Cuboid(size = [30cm, 50cm, 20cm])\n{body}\n"
    return Session.of_text(f"apg 1\nuse primitives {{ Cuboid }}\ncategory T {{\n{text}}}\n")


def made(body: str) -> tuple[Batch, dict[str, int]]:
    batch = session(body).sampler.batch(np.arange(1), seed=1)
    return batch, {name: k for k, name in enumerate(batch.parts().name)}


def foot(body: str) -> np.ndarray:
    """The middle of the bottom of `a`, from the middle of the body."""
    batch, row = made(body)
    parts = batch.parts()
    at = parts.rotation[row["a"]] @ [0, 0, -0.005] + parts.translation[row["a"]]
    return np.asarray(at - parts.translation[row["body"]])


@pytest.mark.parametrize("axis", ["x", "y", "[1, 2, 0]"])
@pytest.mark.parametrize("given", [{"x": 0.03}, {"y": 0.01}, {"z": 0.31}, {"x": 0.03, "y": 0.04}])
def test_at_stays_within_a_tilted_plane(axis: str, given: dict[str, float]) -> None:
    places = ", ".join(f"{name} = {value}m" for name, value in given.items())
    at = foot(f"{VANE.format(axis=axis)}{CUBE}\nconnect a.bottom to v.top at {places}")
    batch, row = made(VANE.format(axis=axis))
    parts = batch.parts()
    turn, middle = parts.rotation[row["v"]], parts.translation[row["v"]] - parts.translation[row["body"]]
    inside = turn.T @ (at - middle)
    assert inside[2] == pytest.approx(0.01)  # on its top
    assert all(at["xyz".index(name)] == pytest.approx(value) for name, value in given.items())
    if len(given) == 1:  # the nearest such place to the middle of the top
        step = at - (middle + turn @ [0, 0, 0.01])
        other = np.cross(turn[:, 2], np.eye(3)["xyz".index(next(iter(given)))])
        assert step @ other == pytest.approx(0)


@pytest.mark.parametrize("place", ["body.front.center", "[15cm, 0, 40cm]", "[15cm, 0, -3cm]"])
def test_at_a_point_stays_within_the_plane(place: str) -> None:
    assert foot(f"{CUBE}\nconnect a.bottom to body.top at {place}").tolist() == pytest.approx([0.15, 0, 0.1])


@pytest.mark.parametrize("places", ["x = 0, y = 0, z = 31cm", "x = 0, z = 31cm"])
def test_a_coordinate_that_the_plane_determines_is_refused(places: str) -> None:
    found = session(f"{VANE.format(axis='y')}{CUBE}\nconnect a.bottom to v.top at {places}")
    assert found.lowering is None and [d.code for d in found.report.diagnostics] == ["plane-across-axes"]


@pytest.mark.parametrize(
    ("stated", "center"),
    [
        ("a.front on body.back - 1cm gap 1mm", [-0.166, 0, 0]),
        ("a.front on body.back - 1cm sink 1mm", [-0.164, 0, 0]),
        ("a.back on body.front + 1cm gap 1mm", [0.166, 0, 0]),
        ("a.top on beneath gap 1mm", [0, 0, -0.116]),
        ("a.front on body.back gap 1mm", [-0.156, 0, 0]),
    ],
)
def test_a_gap_beside_a_sum_is_on_the_side_of_its_face(stated: str, center: list[float]) -> None:
    at = foot(f"let beneath = body.bottom - 1cm\n{CUBE}\nconnect {stated}")
    assert (at + [0, 0, 0.005]).tolist() == pytest.approx(center)


@pytest.mark.parametrize(
    ("shape", "place", "at", "out"),
    [
        ("Cuboid(size = [10cm, 10cm, 10cm])", "front.at(0.25, 0.75)", [0.05, -0.025, 0.025], [1, 0, 0]),
        ("Cuboid(size = [10cm, 10cm, 10cm])", "bottom.at(0.25, 0.75)", [-0.025, -0.025, -0.05], [0, 0, -1]),
        ("Wedge(size = [8cm, 10cm, 10cm], lip = 2cm)", "top.at(0.5, 0.5)", [0, 0, 0.01], [1, 0, 1]),
        (
            "Capsule(radius = 2cm, height = 10cm)",
            "top.at(0, 0.125turn)",
            [0.02 / 2**0.5, 0, 0.03 + 0.02 / 2**0.5],
            [1, 0, 1],
        ),
    ],
)
def test_a_surface_with_the_name_of_a_face_has_places(
    shape: str, place: str, at: list[float], out: list[float]
) -> None:
    body = f"root part body : {shape}\npart a : Cuboid(size = [1cm, 1cm, 1cm])\nconnect a.bottom to body.{place}"
    uses = "use primitives { Cuboid }\nuse solids { Wedge }\nuse rounds { Capsule }"
    batch = Session.of_text(f"apg 1\n{uses}\ncategory T {{\n{body}\n}}\n").sampler.batch(np.arange(1), seed=1)
    parts = batch.parts()
    turn = parts.rotation[1]
    foot = turn @ [0, 0, -0.005] + parts.translation[1] - parts.translation[0]
    np.testing.assert_allclose(foot, at, atol=1e-12)
    np.testing.assert_allclose(turn[:, 2], np.array(out) / np.linalg.norm(out), atol=1e-12)


def test_a_surface_of_another_element_is_told() -> None:
    """Its formulas are those of its own row; a `let` there carries the place."""
    row = "repeat r[i] in 0 ..< 2 split body along y {{\npart p : Cuboid(size = [1cm, 1cm, 5cm])\nconnect p.bottom on body.top\n{let}\n}}"
    far = session(f"{row.format(let='')}\n{CUBE}\nconnect a.bottom to r[last].p.front.at(0.5, 0.5)").examine()
    assert [d.code for d in far.diagnostics if d.severity == "error"] == ["many-elements"]
    told = row.format(let="let spot = p.front.at(0.5, 0.5)")
    np.testing.assert_allclose(
        foot(f"{told}\n{CUBE}\nconnect a.bottom to r[last].spot"), [0.005, 0.125, 0.125], atol=1e-12
    )
