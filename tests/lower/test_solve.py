"""Who yields: small programs whose solutions are known, and the findings of those that have none."""

from __future__ import annotations

import numpy as np
import pytest

from artipg_dsl.graph import expr as E
from artipg_dsl.graph.expr import Column
from artipg_dsl.runtime.batch import Batch
from artipg_dsl.session import Session

HEAD = "apg 1\nuse primitives { Cuboid, Cylinder }\n"


def compiled(text: str) -> Session:
    session = Session.of_text(HEAD + text)
    assert session.lowering is not None, [d.message for d in session.report.diagnostics]
    return session


def sampled(text: str, n: int = 20) -> Batch:
    return compiled(text).sampler.batch(np.arange(n), seed=3)


def category(body: str) -> str:
    return (
        "category C {\n  param w : length in 20cm .. 40cm\n  root part body : Cuboid(size = [w, w, w])\n"
        + body
        + "\n}\n"
    )


def codes(text: str) -> list[str]:
    session = Session.of_text(HEAD + text)
    _ = session.lowering
    return [d.code for d in session.report.diagnostics]


def value(batch: Batch, name: str) -> np.ndarray:
    """The values of a defined or drawn column, by the end of its path."""
    program = batch.program
    columns: list[Column] = [*program.definitions, *(d.column for d in program.draws)]
    column = next(c for c in columns if c.name == name)
    return batch.read([E.col(column)], column.scope)[0]


def box(batch: Batch, path: str) -> tuple[np.ndarray, np.ndarray]:
    """Low and high corners of an unturned part, in the object's frame; one row per instance."""
    parts = batch.parts()
    at = np.array([p == path for p in parts.path])
    return parts.translation[at] + parts.low[at], parts.translation[at] + parts.high[at]


# ---------------------------------------------------------------- systems


def test_explicit_assignment() -> None:
    batch = sampled(category("  part a : Cuboid(size = [1cm, 1cm, 1cm])\n  connect a.back on body.front gap 2mm"))
    body, a = box(batch, "body"), box(batch, "a")
    np.testing.assert_allclose(a[0][:, 0], body[1][:, 0] + 0.002)
    np.testing.assert_allclose(a[0][:, 1], -0.005)  # free: centred on the object's origin


def test_two_faces_determine_place_and_size() -> None:
    batch = sampled(
        category(
            "  part a : Cuboid(size = [1cm, _, 1cm])\n  connect a to body\n"
            "  align a.left = body.left - 1cm\n  align a.right = body.right + 3cm"
        )
    )
    np.testing.assert_allclose(value(batch, "a.size.y"), value(batch, "w") - 0.04)
    np.testing.assert_allclose(box(batch, "a")[0][:, 1], box(batch, "body")[0][:, 1] + 0.03)


def test_nonlinear_equation_isolates_its_unknown() -> None:
    batch = sampled(category("  part a : Cylinder(height = 1cm)\n  connect a to body\n  align a.radius ^ 2 = w * 1cm"))
    np.testing.assert_allclose(value(batch, "a.radius"), np.sqrt(value(batch, "w") * 0.01))


def test_faces_determine_the_radius_of_what_is_by_default_as_wide_above() -> None:
    text = "  part a : Cylinder(height = 1cm)\n  connect a.bottom on body.top fit left, right"
    batch = sampled(category(text))
    np.testing.assert_allclose(value(batch, "a.radius"), value(batch, "w") / 2)
    np.testing.assert_allclose(value(batch, "a.top_radius"), value(batch, "a.radius"))


@pytest.mark.parametrize(
    ("extra", "code"),
    [
        ("  align a.left = body.left\n  align a.right = body.right - 1mm + 0.5 * w", "over-determined"),
        ("  align a.left = body.left\n  align a.left = body.left + 1cm", "contradictory"),
        ("  align a.left = body.left\n  align body.left = a.left", "redundant"),
    ],
)
def test_equations_too_many(extra: str, code: str) -> None:
    assert code in codes(category("  part a : Cuboid(size = [1cm, 1cm, 1cm])\n  connect a to body\n" + extra))


def test_open_size_is_under_determined() -> None:
    assert codes(category("  part a : Cuboid(size = [1cm, _, 1cm])\n  connect a to body")) == ["under-determined"]


PAIR = """template Pair {
  param long : length in 1cm .. 5cm
  param wide : length in 1cm .. 5cm
  part bar : Cuboid(size = [long, wide, 1cm])
}
"""


def test_tie_between_parameters_names_both() -> None:
    text = PAIR + category("  part a : Pair\n  connect a to body\n  align a.long + a.wide = 6cm")
    session = Session.of_text(HEAD + text)
    assert session.lowering is None
    (found,) = session.report.diagnostics
    assert found.code == "tie" and "`a.long`" in found.message and "`a.wide`" in found.message


def test_of_two_positions_the_later_part_yields() -> None:
    batch = sampled(
        category(
            "  part a : Cuboid(size = [1cm, 1cm, 1cm])\n  part b : Cuboid(size = [1cm, 1cm, 1cm])\n"
            "  connect a to body\n  connect b to body\n  align a.center.x = b.center.x + 1cm"
        )
    )
    np.testing.assert_allclose(box(batch, "a")[0][:, 0], -0.005)
    np.testing.assert_allclose(box(batch, "b")[0][:, 0], -0.015)


def test_an_unrelated_equation_changes_nobody_else() -> None:
    first = "  part a : Cuboid(size = [1cm, 1cm, 1cm])\n  part b : Cuboid(size = [1cm, 1cm, 1cm])\n  connect a to body\n  connect b to body\n"
    text = first + "  align a.center.x = b.center.x + 1cm\n"
    more = (
        text
        + "  part c : Cuboid(size = [1cm, _, 1cm])\n  connect c to body\n  align c.left = body.left\n  align c.right = body.right\n"
    )
    plain = {u.column.name: u.reason for _, u in compiled(category(text)).lowering.context.ledger}  # type: ignore[union-attr]
    wider = {u.column.name: u.reason for _, u in compiled(category(more)).lowering.context.ledger}  # type: ignore[union-attr]
    assert plain and all(wider[name] == reason for name, reason in plain.items())


def test_domain_of_a_determined_parameter_is_required() -> None:
    batch = sampled(
        PAIR + category("  part a : Pair(wide = 1cm)\n  connect a to body\n  align a.long = w / 5 - 2cm"), 60
    )
    long = value(batch, "a.long")
    assert (long >= 0.01 - 1e-9).all() and (long <= 0.05 + 1e-9).all()
    np.testing.assert_allclose(long, value(batch, "w") / 5 - 0.02)


# ---------------------------------------------------------------- guards


def test_derived_under_when_and_else() -> None:
    batch = sampled(
        category(
            "  param k : choice one | two = one\n  param d : length in 1cm .. 40cm derived\n"
            "  when k == one { align d = w / 2 } else { align d = w / 4 }\n"
            "  part a : Cuboid(size = [d, 1cm, 1cm])\n  connect a to body"
        ),
        40,
    )
    one = value(batch, "k") == 0
    assert one.any() and (~one).any()
    np.testing.assert_allclose(value(batch, "d"), np.where(one, value(batch, "w") / 2, value(batch, "w") / 4))


def test_branch_parts_and_outer_sizes_are_solved_together() -> None:
    batch = sampled(
        category(
            "  param k : choice one | two = one\n  part a : Cuboid(size = [1cm, _, 1cm])\n  connect a to body\n"
            "  align a.right = body.right\n"
            "  when k == one {\n    part b : Cuboid(size = [1cm, 2cm, 1cm])\n    connect b to body\n"
            "    align b.left = body.left\n    align a.left = b.right\n  } else { align a.left = body.left }"
        ),
        40,
    )
    one = value(batch, "k") == 0
    np.testing.assert_allclose(value(batch, "a.size.y"), value(batch, "w") - np.where(one, 0.02, 0.0))


def test_an_optional_part_takes_its_equations_with_it() -> None:
    batch = sampled(
        category("  part a : Cuboid(size = [1cm, _, 1cm]) | none\n  connect a.back on body.front fit left, right"), 40
    )
    low, _ = box(batch, "a")
    assert 0 < len(low) < 40


def test_requirement_on_a_choice_removes_its_alternatives() -> None:
    batch = sampled(
        category(
            "  part a : Cuboid(size = [1cm, 1cm, 1cm]) | none\n  connect a.back on body.front\n"
            "  require not a or w >= 30cm"
        ),
        60,
    )
    assert (batch.state.attempt == 0).all()
    there = np.isin(np.arange(60), batch.parts().owner[[p == "a" for p in batch.parts().path]])
    assert there.any() and (value(batch, "w")[there] >= 0.3).all()


# ---------------------------------------------------------------- repeats


def test_nested_splits_fill_their_box() -> None:
    batch = sampled(
        category(
            "  count n in 2 .. 4\n  repeat col[c] in 0 ..< n split body along y gap 1cm {\n    count m in 1 .. 3\n"
            "    repeat cell[r] in 0 ..< m split col along z gap 5mm {\n      part plate : Cuboid\n      connect plate in cell\n    }\n  }"
        ),
        10,
    )
    low, high = box(batch, "col.cell.plate")
    body = box(batch, "body")
    owner = batch.parts().owner[[p == "col.cell.plate" for p in batch.parts().path]]
    for number in range(10):
        mine = owner == number
        np.testing.assert_allclose(low[mine].min(axis=0), body[0][number], atol=1e-12)
        np.testing.assert_allclose(high[mine].max(axis=0), body[1][number], atol=1e-12)


def test_each_keeps_elements_within_limits() -> None:
    batch = sampled(
        category(
            "  repeat row[r] in 0 ..< 4 split body along z weight share gap 1cm each 2cm .. 9cm {\n"
            "    param share : ratio in 1 .. 9 = 1\n    part plate : Cuboid\n    connect plate in row\n  }\n  require w <= 36cm"
        ),
        40,
    )
    low, high = box(batch, "row.plate")
    size = (high - low)[:, 2].reshape(40, 4)
    assert (size >= 0.02 - 1e-9).all() and (size <= 0.09 + 1e-9).all()
    np.testing.assert_allclose(size.sum(axis=1), value(batch, "w") - 0.03)


@pytest.mark.parametrize("weight", ["exp(i / 2)", "(1 if i == 0 else 0)"])
def test_elements_of_very_unequal_weights_fill_their_box(weight: str) -> None:
    """So many elements meet `hi` one after the other that rounds of sharing do not end, and weights of 0 take part in none."""
    batch = sampled(
        category(
            f"  repeat row[i] in 0 ..< 30 split body along z weight {weight} each 2mm .. (w / 30) * 1.001 {{\n"
            "    part plate : Cuboid\n    connect plate in row\n  }\n"
        ),
        4,
    )
    low, high = box(batch, "row.plate")
    size = (high - low)[:, 2].reshape(4, 30)
    np.testing.assert_allclose(size.sum(axis=1), value(batch, "w"), rtol=1e-12)
    assert (size <= value(batch, "w")[:, None] / 30 * 1.001 + 1e-9).all() and (size >= 0.002).all()


def test_gap_is_the_box_before_an_element() -> None:
    batch = sampled(
        category(
            "  repeat col[c] in 0 ..< 3 split body along y gap 2cm {\n"
            "    when col.gap {\n      part wall : Cuboid\n      connect wall in col.gap\n    }\n  }"
        ),
        5,
    )
    low, high = box(batch, "col.wall")
    assert len(low) == 10
    np.testing.assert_allclose((high - low)[:, 1], 0.02)


def test_mirror_makes_two_halves_with_proper_poses() -> None:
    batch = sampled(
        "template T {\n  param size : length[3]\n  part core : Cuboid(size = [1cm, 1cm, 1cm])\n"
        "  repeat half[k] mirror across y {\n    part ear : Cuboid(size = [1cm, 2cm, 3cm])\n    align ear.left = left\n"
        "    joint flap : revolute core -> ear about ear.right.back range 0deg .. 40deg\n  }\n}\n"
        + category("  part t : T(size = [5cm, 10cm, 5cm])\n  connect t to body"),
        4,
    )
    low, high = box(batch, "t.half.ear")
    np.testing.assert_allclose(high[0::2, 1], 0.05)
    np.testing.assert_allclose(low[1::2, 1], -0.05)
    joints = batch.joints()
    np.testing.assert_allclose(joints.axis[0::2] * [1, 1, -1], joints.axis[1::2], atol=1e-12)  # a mirrored turn
    for site in batch.sites():
        np.testing.assert_allclose(np.linalg.det(site.rotation), 1.0)


def test_ring_turns_its_elements_and_their_axes() -> None:
    batch = sampled(
        category(
            "  repeat half[k] ring 2 about x {\n    part arm : Cuboid(size = [1cm, 2cm, 1cm])\n    align arm.bottom = w / 2\n"
            "    joint open : revolute body -> arm about line(at = [0, 0, 0], along = -z) range 0deg .. 20deg mimic previous.open\n  }"
        ),
        4,
    )
    joints = batch.joints()
    np.testing.assert_allclose(joints.axis[0::2], [[0, 0, -1]] * 4, atol=1e-12)
    np.testing.assert_allclose(joints.axis[1::2], [[0, 0, 1]] * 4, atol=1e-12)
    assert (joints.mimic[0::2] == -1).all() and (joints.mimic[1::2] == 0).all()


def test_previous_stacks_elements() -> None:
    batch = sampled(
        category(
            "  repeat stack[i] in 0 ..< 3 {\n    param high : length in 1cm .. 3cm\n    part disc : Cuboid(size = [1cm, 1cm, high])\n"
            "    align disc.bottom = body.top if i == 0 else previous.disc.top\n    connect disc to body\n  }"
        ),
        6,
    )
    low, high = box(batch, "stack.disc")
    low, high = low[:, 2].reshape(6, 3), high[:, 2].reshape(6, 3)
    np.testing.assert_allclose(low[:, 1:], high[:, :-1])


def test_a_recurrence_that_is_no_sum_is_refused() -> None:
    text = category(
        "  repeat stack[i] in 0 ..< 3 {\n    part disc : Cuboid(size = [1cm, 1cm, 1cm])\n"
        "    align disc.bottom = body.top if i == 0 else 2 * previous.disc.top\n    connect disc to body\n  }"
    )
    assert "recurrence" in codes(text)


# ---------------------------------------------------------------- mounts, roles, motion


def test_mount_opposes_out_and_aligns_up() -> None:
    batch = sampled(
        "template Knob {\n  part shaft : Cylinder(radius = 5mm, height = 2cm)\n"
        "  port foot = frame(at = shaft.bottom.center, out = -z, up = x)\n}\n"
        + category("  part k : Knob\n  connect k.foot to body.front at y = 3cm, z = body.center.z + 1cm")
    )
    parts = batch.parts()
    at = np.array([p == "k" for p in parts.path])
    np.testing.assert_allclose(
        parts.rotation[at][:, :, 2], [[1, 0, 0]] * 20, atol=1e-12
    )  # its z points out of the front
    np.testing.assert_allclose(parts.rotation[at][:, :, 0], [[0, 0, 1]] * 20, atol=1e-12)  # its x points up
    np.testing.assert_allclose(parts.translation[at][:, 1], 0.03)


def test_between_solves_pose_and_length() -> None:
    batch = sampled(
        "template Rod {\n  param span : length\n  part bar : Cylinder(radius = 3mm, height = span)\n"
        "  port ends : line = line(at = bar.bottom.center, to = bar.top.center)\n}\n"
        + category("  part r : Rod\n  connect r between body.left.top.front and body.right.top.back facing +z sink 1mm")
    )
    w = value(batch, "w")
    np.testing.assert_allclose(value(batch, "r.span"), np.sqrt(2) * w + 0.002)
    parts = batch.parts()
    at = np.array([p == "r" for p in parts.path])
    along = parts.rotation[at][:, :, 2]
    np.testing.assert_allclose(along, np.tile([-1, -1, 0], (20, 1)) / np.sqrt(2), atol=1e-12)


STYLED = """role Grip {
  inherit long : length in 1cm .. 9cm
  slot bar
}
template Thin : Grip { part bar : Cuboid(size = [1cm, 1cm, long]) }
template Fat : Grip { part bar : Cuboid(size = [3cm, 3cm, long]) }
"""


def test_a_style_is_drawn_once() -> None:
    batch = sampled(
        STYLED
        + category(
            "  style pull : Grip = Thin | Fat\n  repeat col[c] in 0 ..< 3 split body along y {\n"
            "    part grip : pull\n    connect grip to body\n    align grip.center.z = col.center.z\n  }"
        ),
        30,
    )
    low, high = box(batch, "col.grip.bar")
    size = (high - low).reshape(30, 3, 3)
    np.testing.assert_allclose(size, size[:, :1].repeat(3, axis=1))
    assert len(np.unique(size[:, 0, 0].round(6))) == 2 and len(np.unique(size[:, 0, 2])) == 30


def test_alternatives_that_move_differently() -> None:
    batch = sampled(
        "role Sash {\n  inherit size : length[3]\n  slot leaf\n  joint motion\n}\n"
        "template Slide : Sash {\n  part leaf : Cuboid(size = size)\n  joint motion : prismatic base -> leaf along y range 0 .. size.y\n}\n"
        "template Swing : Sash {\n  part leaf : Cuboid(size = size)\n"
        "  joint motion : revolute base -> leaf about leaf.left.back range 0deg .. 90deg\n}\n"
        + category("  part s : Sash(size = [1cm, w, w]) = Slide | Swing\n  connect s.back on body.front gap 1mm"),
        40,
    )
    joints = batch.joints()
    assert len(joints.owner) == 40 and set(joints.kind) == {"prismatic", "revolute"}
    sliding = np.array([kind == "prismatic" for kind in joints.kind])
    np.testing.assert_allclose(joints.axis[sliding], np.tile([0, 1, 0], (sliding.sum(), 1)))
    np.testing.assert_allclose(joints.axis[~sliding], np.tile([0, 0, 1], ((~sliding).sum(), 1)))


LID = """template Lid {
  param size : length[3]
  part plate : Cuboid(size = size)
  port seat = frame(at = bottom.center, out = -z, up = x)
  joint motion : revolute base -> plate about plate.left.back range 0deg .. 90deg
}
"""

SEATED = "  part lid : Lid(size = [w, w, 1cm])\n  connect lid.seat to body.top gap 1mm\n"


def test_limit_narrows_a_motion() -> None:
    batch = sampled(LID + category(SEATED + "  limit lid.motion 5deg .. 120deg"))
    joints = batch.joints()
    np.testing.assert_allclose(joints.low, np.radians(5.0))
    np.testing.assert_allclose(joints.high, np.radians(90.0))
    np.testing.assert_allclose(joints.rest, np.radians(5.0))


def test_a_clearance_at_the_low_end_is_checked_but_not_sampled() -> None:
    from artipg_dsl.diagnostics import CompileError

    session = compiled(LID + category(SEATED + "  limit lid.motion clearance .. 5deg"))
    with pytest.raises(CompileError):
        _ = session.sampler
    (found,) = [d for d in session.report.diagnostics if d.severity == "error"]
    assert found.code == "needs-clearance" and found.span is not None


def test_a_joint_in_one_branch_and_a_rigid_hold_in_the_other() -> None:
    batch = sampled(
        category(
            "  param k : choice one | two = one\n  part a : Cuboid(size = [1cm, 1cm, 1cm])\n"
            "  when k == one { joint slide : prismatic body -> a on body.front gap 1mm along x range 0cm .. 2cm } "
            "else { connect a.back on body.front }"
        ).replace("-> a on", "-> a.back on"),
        40,
    )
    one = value(batch, "k") == 0
    assert len(batch.joints().owner) == one.sum() and 0 < one.sum() < 40
    links = batch.parts().link[[p == "a" for p in batch.parts().path]]
    np.testing.assert_array_equal(links, one.astype(int))


@pytest.mark.parametrize("condition", ["n < 3", "3 > n", "n + 1 < 4", "2 * n < 2 * 3", "n <= 2"])
def test_strict_comparisons_of_whole_numbers_leave_the_end_out(condition: str) -> None:
    top = "  part top : Cuboid(size = [n * 1cm, 1cm, 1cm])\n  connect top.bottom on body.top"
    text = category(f"  count n in 1 .. 5\n  require {condition}\n{top}")
    assert set(value(sampled(text, 60), "n")) == {1.0, 2.0}
