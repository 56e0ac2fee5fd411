"""``range a .. clearance``: ends known in closed form, that they are the ends everywhere, and what is refused."""

import numpy as np
import pytest

from artipg_dsl.diagnostics.model import CompileError
from artipg_dsl.graph.reading import from_text
from artipg_dsl.graph.writing import to_text
from artipg_dsl.sampling.sample import Sampler
from artipg_dsl.session import Session
from artipg_dsl.validity.faults import find_faults

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
    assert len(find_faults(batch).objects()) == 0


def test_a_turn_ends_at_the_post() -> None:
    """The near face of a post 2 cm wide, 19 to 21 cm from the axis, and the arm's side 1 cm from its middle line."""
    batch = program(TURN).batch(np.arange(50), 0)
    exact = batch.values()["away"] - 2 * np.arctan2(0.01, 0.19)
    assert batch.joints().high == pytest.approx(exact, abs=3e-4)
    assert len(find_faults(batch).objects()) == 0


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
    from artipg_dsl.robot.robots import Robots

    batch = program(SLIDE).batch(np.arange(1), 0)
    assert Robots(batch).robot(0).joints[0].high == batch.joints().high[0] < 0.2


@pytest.mark.parametrize(
    ("text", "why"),
    [
        ("clearance .. 90deg", "only the high end of a range"),
        ("0deg .. clearance mimic lead", "`swing` follows another joint"),
        ("0deg .. clearance all mimic lead", "`swing` follows another joint"),
        ("0deg .. clearance when lead > 5deg", "`swing` waits for another joint"),
        ("0deg .. clearance positions 3", "`swing` has `positions`"),
    ],
)
def test_what_is_not_solved_for_is_refused(text: str, why: str) -> None:
    lead = """
  part other : Cuboid(size = [2cm, 2cm, 2cm])
  align other.top = body.bottom - 1mm
  joint lead : revolute body -> other about line(at = body.center, along = z) range 0deg .. 9deg
"""
    with pytest.raises(CompileError) as caught:
        program(TURN.replace("0deg .. clearance", text) + lead)
    (found,) = caught.value.report.diagnostics
    assert found.code == "needs-clearance" and why in found.message


# ------------------------------------------------------------------ clearance all

ARMS = """
  param away : length in 12cm .. 40cm
  root part body : Cuboid(size = [80cm, 80cm, 2cm])
  repeat arm[k] in 0 ..< 2 {
    part bar : Cuboid(size = [25cm, 2cm, 4cm])
    align bar.bottom = body.top + 1mm
    align bar.center.y = (k - 1/2) * away
    align bar.back = 0
    joint swing : revolute body -> bar about line(at = [0, (k - 1/2) * away, 0], along = z) range -10deg .. clearance all
  }
"""
CRATE = """
  param away : length in 10cm .. 30cm
  param aslant : angle in 20deg .. 70deg
  root part body : Cuboid(size = [80cm, 80cm, 2cm])
  part bar : Cuboid(size = [25cm, 2cm, 4cm])
  align bar.bottom = body.top + 1mm
  align bar.center.y = 0
  align bar.back = 0
  joint swing : revolute body -> bar about line(at = [0, 0, 0], along = z) range 0deg .. clearance all
  part crate : Cuboid(size = [10cm, 4cm, 4cm]) turned aslant about z
  align crate.bottom = body.top + 1mm
  align crate.center.y = away
  align crate.center.x = 0
  joint slide : prismatic body -> crate along x range -20cm .. 20cm
"""
LEVER = """
  part knob : Cuboid(size = [2cm, 12cm, 2cm])
  align knob.bottom = bar.top + 1mm
  align knob.center.x = bar.front - 2cm
  align knob.right = bar.center.y - 1cm
  joint turn : revolute bar -> knob about line(at = [bar.front - 2cm, 0, 0], along = z) range 0deg .. 180deg
"""


def meetings(batch, beyond: float) -> list[int]:
    """The objects that meet themselves anywhere on a grid of all joints, the ends of those that yield moved ``beyond``."""
    from itertools import product

    from artipg_dsl.validity.bodies import gather
    from artipg_dsl.validity.tree import Tree
    from artipg_dsl.validity.validate import find_meetings_in_states

    tree = Tree(batch)
    yields = np.array([joint.whatever for joint in batch.program.joints])[tree.joints.definition]
    high = tree.high + np.where(yields, beyond, 0.0)
    body = gather(batch, tree.first, tree.turn, tree.shift)
    count = int(tree.joints.number.max()) + 1
    found: set[int] = set()
    for shares in product(np.linspace(0, 1, 25 if count == 2 else 9), repeat=count):
        states = tree.low + np.array(shares)[tree.joints.number] * (high - tree.low)
        found |= set(tree.links.owner[next(find_meetings_in_states(tree, body, states[None]))[0]].tolist())
    return sorted(found)


@pytest.mark.some
@pytest.mark.parametrize("text", [ARMS, CRATE, CRATE + LEVER])
def test_whatever_else_is_open_nothing_meets_and_not_much_farther_it_does(text: str) -> None:
    batch = program(text).batch(np.arange(4), 0)
    assert meetings(batch, 0.0) == []
    assert meetings(batch, np.radians(4)) == [0, 1, 2, 3]


def test_two_in_the_way_of_one_another_share_it() -> None:
    """Arms that point away from one another at rest meet, turned towards one another, at equal shares of their ways."""
    text = ARMS.replace("range -10deg .. clearance all", "range 0deg .. 90deg\n    limit swing 0deg .. clearance all")
    text = text.replace("along = z", "along = [0, 0, 1 - 2 * k]").replace("12cm .. 40cm", "16cm .. 30cm")
    batch = program(text).batch(np.arange(6), 0)
    high = batch.joints().high.reshape(6, 2)
    assert high[:, 0] == pytest.approx(high[:, 1])
    assert meetings(batch, 0.0) == [] and (high < np.radians(90)).all()


def test_clearance_all_survives_compilation_and_is_the_same_alone() -> None:
    sampler = program(CRATE + LEVER)
    whole = sampler.batch(np.arange(4), 3)
    again = Sampler(from_text(to_text(sampler.program))).batch(np.arange(4), 3)
    assert whole.joints().high.tobytes() == again.joints().high.tobytes()
    alone = [sampler.batch(np.array([n]), 3).joints().high.tobytes() for n in range(4)]
    assert b"".join(alone) == whole.joints().high.tobytes()


def test_a_joint_that_others_leave_no_way_makes_an_object_invalid() -> None:
    """The crate passes before the arm: nothing that the arm yields lets it by."""
    text = CRATE.replace("align crate.center.y = away", "align crate.center.y = 0").replace(
        "align crate.center.x = 0", "align crate.center.x = 30cm + away"
    )
    batch = program(text.replace("-20cm .. 20cm", "-25cm .. 20cm")).batch(np.arange(3), 0)
    assert [fault.words.split(": ", 1)[1] for fault in find_faults(batch).others] == [
        "the range of `swing` is empty: something is in the way from the start when other joints are open"
    ]


def test_clear_all_looks_at_all_states() -> None:
    fixed = CRATE.replace("clearance all", "60deg").replace("10cm .. 30cm", "22cm .. 22cm")
    loose = program(fixed.replace("-20cm", "15cm").replace("range 15cm", "range 0cm") + "clear bar from crate by 1mm\n")
    bound = program(fixed.replace("-20cm", "0cm") + "clear bar from crate by 1mm all\n")
    assert find_faults(loose.batch(np.arange(2), 0)).others == ()
    words = [fault.words for fault in find_faults(bound.batch(np.arange(2), 0)).others]
    assert len(words) == 1 and words[0].endswith("does not hold while several joints move")
    apart = program(fixed.replace("60deg", "20deg") + "clear bar from crate by 1mm all\n")
    assert find_faults(apart.batch(np.arange(2), 0)).others == ()
