"""Arguments that reduce over the rows of whoever hands them in, and names that cannot be handed in."""

import numpy as np

from artipg_dsl.session import Session

HEAD = "apg 1\nuse primitives { Cuboid }\n"
LID = "template Lid { param reach : length > 0  part plate : Cuboid(size = [reach, 10cm, 1cm]) }\n"
ROW = """category C {
  root part body : Cuboid(size = [30cm, 30cm, 30cm])
  count n in 2 .. 4 = 3
  repeat s[i] in 0 ..< n { param w : length in 2cm .. 4cm = 3cm }
"""


def reach(body: str, template: str = LID) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Per lid: how far it reaches, the sum over its object's elements, and how many they are."""
    session = Session.of_text(HEAD + template + ROW + body + "\n}\n")
    batch = session.sampler.batch(np.arange(40), 2)
    parts = batch.parts()
    plates = np.array([path.endswith("plate") for path in parts.path])
    drawn = next(k for k, d in enumerate(batch.program.draws) if d.column.name == "s.w")
    owner, widths = batch.owner(batch.program.draws[drawn].column.scope), batch.state.values[drawn]
    total, count = np.bincount(owner, weights=widths), np.bincount(owner)
    at = parts.owner[plates]
    return (parts.high - parts.low)[plates, 0], total[at], count[at]


def test_a_sum_over_the_callers_elements_is_an_argument():
    found, total, _ = reach("part lid : Lid(reach = sum(s.w))\nconnect lid.bottom on body.top")
    np.testing.assert_allclose(found, total)


def test_also_from_within_another_repeat():
    lid = "part lid : Lid(reach = sum(s.w) / n)  connect lid.bottom on body.top"
    found, total, count = reach(f"repeat t[j] in 0 ..< 2 pitch 12cm along y {{ {lid} }}")
    assert len(found) == 80
    np.testing.assert_allclose(found, total / count)


def test_also_under_a_guard_and_in_an_alternative():
    roles = "role Top { }\n" + LID.replace("Lid", "Lid : Top") + LID.replace("Lid", "Board : Top")
    found, total, count = reach(
        "when n >= 3 { part lid : Top = Lid(reach = sum(s.w)) | Board(reach = sum(s.w))  connect lid.bottom on body.top }",
        roles,
    )
    assert set(count.tolist()) == {3, 4}
    np.testing.assert_allclose(found, total)


def test_a_template_is_no_value():
    text = """role Handle { inherit size : length[3] }
template Bar : Handle { part rod : Cuboid(size = size) }
template Door {
  param pull : style Handle
  part leaf : Cuboid(size = [2cm, 20cm, 20cm])
  part handle : pull(size = [2cm, 2cm, 10cm])
  connect handle.back on leaf.front at center
}
category C {
  root part body : Cuboid(size = [30cm, 30cm, 30cm])
  part door : Door(pull = Bar)
  connect door.back on body.front
}
"""
    session = Session.of_text(HEAD + text)
    assert session.lowering is None
    (found,) = session.report.diagnostics
    assert (
        found.code == "wrong-arguments"
        and "`Bar` is a template" in found.message
        and "declare `style" in (found.hint or "")
    )
