"""What is named from another frame keeps its place: elements of repeats from outside, from one another and through parts, in rings,
mirrors and parts that are turned, and what functions and reductions name."""

from __future__ import annotations

import re

import numpy as np
import pytest

from artipg_dsl.annotate.annotation import annotate
from artipg_dsl.annotate.cloud import sample_points
from artipg_dsl.runtime.batch import Batch
from artipg_dsl.session import Session

HEAD = """apg 1
use primitives { Cuboid, Cylinder }
template Rail {
  part bar : Cuboid(size = [2cm, 40cm, 3cm])
  repeat hook[i] in 0 ..< 2 spread bar along y margin 5cm {
    part peg : Cuboid(size = [3cm, 1cm, 1cm])
    connect peg.back on bar.front
    align peg.center.y = hook.center.y
    repeat knob[j] mirror across z {
      part ball : Cuboid(size = [1cm, 1cm, 1cm])
      connect ball.bottom on peg.top
      align ball.center.y = hook.center.y
    }
  }
}
"""
CUBE = "Cuboid(size = [1cm, 1cm, 1cm])"
ROW = f"""repeat q[i] in 0 ..< 2 spread body along y margin 5cm {{
  part s : {CUBE}
  connect s to body
  align s.center = [3cm, q.center.y, 15cm]
}}
"""
PAIR = f"""repeat m[k] mirror across y {{
  part a : {CUBE}
  connect a to body
  align a.center = [20cm, 8cm, 0]
}}
"""
STAR = PAIR.replace("mirror across y", "ring 4 about z")
ROUND = [[0.2, 0.08, 0], [-0.08, 0.2, 0], [-0.2, -0.08, 0], [0.08, -0.2, 0]]  # where those of `STAR` are


def batch(body: str) -> Batch:
    text = f"{HEAD}category T {{\nroot part body : Cuboid(size = [30cm, 50cm, 20cm])\n{body}\n}}\n"
    return Session.of_text(text).sampler.batch(np.arange(1), seed=1)


def centres(body: str, name: str) -> np.ndarray:
    """Where the parts of a name are, from the middle of the body, in the order of their elements."""
    parts = batch(body).parts()
    middle: dict[str, list[np.ndarray]] = {}
    for k, path in enumerate(parts.name):
        turn, shift = parts.rotation[k], parts.translation[k]
        middle.setdefault(re.sub(r"\[\d+\]", "", path), []).append(turn @ ((parts.low[k] + parts.high[k]) / 2) + shift)
    return np.round(np.array(middle[name]) - middle["body"][0], 9)


def put(place: str) -> str:
    return f"part b : {CUBE}\nconnect b to body\nalign b.center = {place}\n"


@pytest.mark.parametrize("form", ["mirror across y", "mirror across z", "ring 3 about z", "ring 3 about x"])
def test_an_element_named_in_a_turned_one_keeps_its_place(form: str) -> None:
    body = f"{ROW}repeat w[k] {form} {{ {put('q[0].s.center')} }}"
    assert (centres(body, "w.b") == [0.03, -0.2, 0.15]).all()


def test_elements_name_one_another() -> None:
    """The one before and one by its number, in rings and mirrors."""
    assert centres(STAR.replace("}\n", "when k > 0 {" + put("previous.a.center") + "}}\n"), "m.b").tolist() == ROUND[:3]
    assert (centres(STAR.replace("}\n", put("m[1].a.center") + "}\n"), "m.b") == ROUND[1]).all()
    assert (centres(PAIR.replace("}\n", put("m[0].a.center") + "}\n"), "m.b") == [0.2, 0.08, 0]).all()
    assert centres(PAIR.replace("}\n", "when k > 0 {" + put("previous.a.center") + "}}\n"), "m.b").tolist() == [
        [0.2, 0.08, 0]
    ]


@pytest.mark.parametrize("turned", ["", " along y", " turned 90deg about z", " turned 30deg about x"])
def test_an_element_of_a_part_is_where_the_part_puts_it(turned: str) -> None:
    rail = f"part r : Rail{turned}\nconnect r to body\nalign r.center = [5cm, 0, 30cm]\n"
    assert np.allclose(centres(rail + put("r.hook[0].peg.center"), "b"), centres(rail, "r.hook.peg")[0])
    assert np.allclose(centres(rail + put("r.hook[1].knob[1].ball.center"), "b"), centres(rail, "r.hook.knob.ball")[3])
    ring = f"{rail}repeat w[k] ring 3 about x {{ {put('r.hook[0].peg.center')} }}"
    assert np.allclose(centres(ring, "w.b"), centres(rail, "r.hook.peg")[0])


def test_the_least_is_that_of_the_places() -> None:
    assert centres(PAIR + put("[min(m.a.center.x), min(m.a.left), 0]"), "b")[0].tolist() == [0.2, -0.075, 0]
    assert centres(STAR + put("[min(m.a.center.x), max(m.a.center.y), 0]"), "b")[0].tolist() == [-0.2, 0.2, 0]
    least = put("[0, min(m.a.center.y), 0]")
    within = f"{PAIR}param c : choice yes | no\nwhen c == yes {{ {least} }} else {{ {least} }}"
    assert centres(within, "b")[0].tolist() == [0, -0.08, 0]


def test_what_a_function_names_keeps_its_place() -> None:
    body = f"let up(h) = body.front.left.top + [0, 0, h]\nrepeat w[k] ring 3 about z {{ {put('up(5cm)')} }}"
    assert (centres(body, "w.b") == [0.15, 0.25, 0.15]).all()


def test_the_gap_before_an_element_keeps_its_place() -> None:
    body = f"""repeat bay[i] in 0 ..< 2 split body along y gap 4cm {{
      repeat w[k] mirror across y {{ when bay.gap {{
        part b : Cuboid(size = [1cm, 1cm, 1cm])
        connect b to body
        align b.center = bay.gap.center + [20cm, 0, 0]
      }} }}
    }}
    {put("[0, 5cm, 40cm]")}"""
    assert (centres(body, "bay.w.b") == [0.2, 0, 0]).all()


@pytest.mark.parametrize(
    "place", ["m[1].a.center", "corner(0)", "r.hook[1].peg.center", "body.front.top.left", "rod.front.center"]
)
def test_formulas_read_elements_and_functions_in_the_frame_of_their_target(place: str) -> None:
    """How far each point of a part that lies on its side is from what is named."""
    apart = ", ".join(f"{place}.{letter} - p.{letter}" for letter in "xyz")
    body = f"""{PAIR}
    part r : Rail along y
    connect r to body
    align r.center = [5cm, 0, 30cm]
    let corner(h) = body.front.left.top + [0, 0, h]
    part rod : Cylinder(radius = 1cm, height = 6cm) along x
    connect rod.back on body.front
    field far : length on rod = hypot({apart})
    """
    at = centres(body + put(place), "b")[0] + [0, 0, 0.1]  # the body stands on the ground
    points = sample_points(batch(body), 2000)
    told = points.labels["field.far"][0]
    known = np.isfinite(told)
    assert known.sum() > 10
    assert np.allclose(told[known], np.linalg.norm(points.position[0][known] - at, axis=1), atol=1e-5)


def test_the_origin_of_a_ring_is_the_point_of_its_axis_nearest_to_that_of_the_scope() -> None:
    axis = "line(at = [10cm, 0, 0], along = [0.6, 0, 0.8])"
    body = f"repeat w[k] ring 2 about {axis} {{ {put('[0, 5cm, 0]')} }}"
    assert centres(body, "w.b").tolist() == [[0.064, 0.05, -0.048], [0.064, -0.05, -0.048]]


ROD = "part rod : Cylinder(radius = 1cm, height = 6cm) along x\nconnect rod.back on body.front\n"


@pytest.mark.parametrize("face", ["body.front", "side", "near(0)", "body.front + 0"])
def test_a_face_in_a_formula_is_the_one_of_the_statement(face: str) -> None:
    """Its target lies on its side: its own z runs to the front."""
    body = f"{ROD}let side = body.front\nlet near(h) = body.front + h\nfield deep : length on rod = {face} - p.z\n"
    points = sample_points(batch(body), 2000)
    told = points.labels["field.deep"][0]
    known = np.isfinite(told)
    assert known.sum() > 10 and np.allclose(told[known], 0.15 - points.position[0][known, 0], atol=1e-6)


@pytest.mark.parametrize(
    ("at", "place"),
    [
        ("[0, 0, size.z / 2]", [0.21, 0, 0]),
        ("body.front.center", [0.15, 0, 0]),
        ("rod.front.center", [0.21, 0, 0]),
        ("body.left.center + [1cm, 0, 0]", [0, 0.26, 0]),
    ],
)
def test_a_keypoint_of_a_part_is_where_its_formula_says(at: str, place: list[float]) -> None:
    (told,) = annotate(batch(f"{ROD}keypoint tip on rod at {at}"))
    (found,) = told["keypoints"]
    assert found["point"] == pytest.approx(np.array(place) + [0, 0, 0.1])


def test_the_directions_of_a_grasp_are_those_of_the_statement() -> None:
    made = batch(
        f"{ROD}grasp pinch on rod {{ at rod.front.center  approach body.back.out  close body.left.out  opening 3cm }}"
    )
    (grasp,) = made.program.grasps
    frame = np.array(made.read([c for row in grasp.frame.rotation for c in row], grasp.scope)).reshape(3, 3)
    for directions, expected in ((grasp.approach, [-1, 0, 0]), (grasp.close, [0, 1, 0])):
        own = np.array(made.read(directions, grasp.scope))[:, 0]
        assert frame @ own == pytest.approx(expected)


def test_the_axes_of_a_slot_are_those_of_its_template_whatever_it_binds() -> None:
    said = []
    for slot in ("slot grip = rod.side", "slot grip = rod"):
        text = f"""{HEAD}role R {{ slot grip }}
        template A : R {{ part rod : Cylinder(radius = 1cm, height = 6cm) along x\n {slot} }}
        category T {{
          root part body : Cuboid(size = [30cm, 50cm, 20cm])
          part u : R = A
          connect u.back on body.front
          field forth : length on u.grip where abs(n.x) < 0.5 = p.x
        }}"""
        points = sample_points(Session.of_text(text).sampler.batch(np.arange(1), seed=1), 4000)
        told = points.labels["field.forth"][0]
        known = np.isfinite(told)
        assert known.sum() > 10 and np.allclose(told[known], points.position[0][known, 0] - 0.18, atol=1e-6)
        said.append(np.ptp(told[known]))
    assert min(said) > 0.05


TILTED = """part v : Cuboid(size = [20cm, 10cm, 2cm]) turned 30deg about y
connect v to body
align v.center = [1cm, 2cm, 40cm]
"""
LONG, HIGH = 0.05 * np.cos(np.pi / 6), 0.05 * np.sin(np.pi / 6)


@pytest.mark.parametrize(
    ("form", "apart"),
    [
        ("in 0 ..< 2 split v along x", [LONG, 0, -HIGH]),
        ("in 0 ..< 2 spread v along x margin 5cm", [LONG, 0, -HIGH]),
        ("fill v along x every 10cm margin 5cm", [LONG, 0, -HIGH]),
        ("in 0 ..< 2 spread v along y margin 3cm", [0, 0.02, 0]),
    ],
)
@pytest.mark.parametrize("placed", ["align b.center = s.center", ""])
def test_elements_of_a_tilted_box_lie_along_it(form: str, apart: list[float], placed: str) -> None:
    """Whether they are placed there, or left to be centred in their element."""
    body = f"{TILTED}repeat s[i] {form} {{\npart b : {CUBE}\nconnect b to body\n{placed}\n}}"
    found, middle = centres(body, "s.b"), np.array([0.01, 0.02, 0.4])
    assert np.allclose(found, [middle - apart, middle + apart])


@pytest.mark.parametrize(
    "stated", ["connect b in v.box", "connect b.left on v.left fit top", "connect b in v.box fit back"]
)
def test_a_part_does_not_fit_into_a_tilted_box(stated: str) -> None:
    text = f"{HEAD}category T {{\nroot part body : Cuboid(size = [30cm, 50cm, 20cm])\n{TILTED}part b : {CUBE}\n{stated}\n}}"
    session = Session.of_text(text)
    assert session.lowering is None and "plane-across-axes" in [d.code for d in session.report.diagnostics]


def test_a_part_fits_between_the_faces_that_are_not_tilted() -> None:
    body = f"{TILTED}part b : Cuboid(size = [1cm, _, 1cm])\nconnect b in v.box fit left, right gap 1cm\n"
    parts = batch(body).parts()
    b = parts.name.index("b")
    assert parts.high[b, 1] - parts.low[b, 1] == pytest.approx(0.08) and centres(body, "b")[0, 1] == pytest.approx(0.02)
