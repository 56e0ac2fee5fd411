"""``range a .. clearance``: ends known in closed form, that they are the ends everywhere, and what is refused."""

import numpy as np
import pytest

from artipg_dsl.diagnostics.model import CompileError
from artipg_dsl.graph.text import from_text, to_text
from artipg_dsl.runtime.faults import faults
from artipg_dsl.runtime.sample import Sampler
from artipg_dsl.session import Session

HEAD = "apg 1\nuse primitives { Cuboid }\ncategory Case {\n"
SLIDE = """
  param free : length in 5cm .. 20cm
  root part body : Cuboid(size = [60cm, 40cm, 2cm])
  part wall : Cuboid(size = [2mm, 40cm, 30cm])
  connect wall.bottom on body.top
  part crate : Cuboid(size = [10cm, 10cm, 10cm])
  align crate.bottom = body.top + 1mm
  align crate.back = body.back
  align wall.back = crate.front + free
  joint pull : prismatic body -> crate along x range 0 .. clearance
"""
TURN = """
  param away : angle in 20deg .. 160deg
  root part body : Cuboid(size = [60cm, 60cm, 2cm])
  part post : Cuboid(size = [2cm, 2cm, 10cm]) turned away about z
  align post.center = [0.2m * cos(away), 0.2m * sin(away), 6cm]
  connect post to body
  part arm : Cuboid(size = [25cm, 2cm, 4cm])
  align arm.bottom = body.top + 1mm
  align arm.back = 0
  joint swing : revolute body -> arm about line(at = body.center, along = z) range 0deg .. clearance
"""


def program(body: str) -> Sampler:
    return Session.of_text(HEAD + body + "\n}\n").sampler


def test_a_slide_ends_at_the_wall() -> None:
    batch = program(SLIDE).batch(np.arange(50), 0)
    assert batch.joints().high == pytest.approx(batch.values()["free"] - 1e-5, abs=3e-6)
    assert len(faults(batch).objects()) == 0


def test_a_turn_ends_at_the_post() -> None:
    """The near face of a post 2 cm wide, 19 to 21 cm from the axis, and the arm's side 1 cm from its middle line."""
    batch = program(TURN).batch(np.arange(50), 0)
    exact = batch.values()["away"] - 2 * np.arctan2(0.01, 0.19)
    assert batch.joints().high == pytest.approx(exact, abs=3e-4)
    assert len(faults(batch).objects()) == 0


def test_with_nothing_in_the_way_it_goes_all_the_way() -> None:
    text = TURN.replace("part post", "part far").replace("post", "far").replace("0.2m", "0.29m")
    assert program(text).batch(np.arange(3), 0).joints().high == pytest.approx(2 * np.pi)


def test_limit_goes_as_far_as_the_joint_itself_at_most() -> None:
    text = TURN.replace("0deg .. clearance", "0deg .. 30deg") + "limit swing 0deg .. clearance\n"
    batch = program(text).batch(np.arange(30), 0)
    exact = np.minimum(np.radians(30), batch.values()["away"] - 2 * np.arctan2(0.01, 0.19))
    assert batch.joints().high == pytest.approx(exact, abs=3e-4)


def test_it_survives_compilation_and_is_the_same_alone() -> None:
    sampler = program(TURN)
    whole = sampler.batch(np.arange(8), 3)
    again = Sampler(from_text(to_text(sampler.program))).batch(np.arange(8), 3)
    assert whole.joints().high.tobytes() == again.joints().high.tobytes()
    alone = [sampler.batch(np.array([n]), 3).joints().high[0] for n in range(8)]
    assert alone == whole.joints().high.tolist()


def test_an_annotation_has_the_end_that_was_found() -> None:
    from artipg_dsl.export.robot import Robots

    batch = program(SLIDE).batch(np.arange(1), 0)
    assert Robots(batch).robot(0).joints[0].high == batch.joints().high[0] < 0.2


@pytest.mark.parametrize("text", ["clearance .. 90deg", "0deg .. clearance mimic lead"])
def test_what_is_not_solved_for_is_refused(text: str) -> None:
    lead = """
  part other : Cuboid(size = [2cm, 2cm, 2cm])
  align other.top = body.bottom - 1mm
  joint lead : revolute body -> other about line(at = body.center, along = z) range 0deg .. 9deg
"""
    with pytest.raises(CompileError) as caught:
        program(TURN.replace("0deg .. clearance", text) + lead)
    assert [d.code for d in caught.value.report.diagnostics] == ["needs-clearance"]
