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


GRIPS = """role Handle { inherit size : length[3] in [1cm, 1cm, 1cm] .. [3cm, 3cm, 12cm] }
template Bar : Handle {
  param share : ratio in 0.2 .. 0.9
  part rod : Cuboid(size = [size.x, size.y, share * size.z])
}
template Plate : Handle { part sheet : Cuboid(size = size) }
role Front { inherit size : length[3] }
template Door : Front {
  param pull : style Handle
  param mode : choice wide | slim
  let broad = 4cm if mode == wide else 1cm
  part leaf : Cuboid(size = size)
  repeat k[i] in 0 ..< 2 spread leaf along y margin 5cm {
    part handle : pull(size = [2cm, broad, 10cm])
    connect handle.back on leaf.front at y = k.center.y, z = leaf.center.z
  }
}
category C {
  root part body : Cuboid(size = [30cm, 30cm, 30cm])
  part door : Front(size = [2cm, 20cm, 20cm]) = HANDED
  connect door.back on body.front
}
"""


def test_a_template_handed_in_is_a_style_of_its_own() -> None:
    session = Session.of_text(HEAD + GRIPS.replace("HANDED", "Door(pull = Bar, mode = slim)"))
    batch = session.sampler.batch(np.arange(20), 1)
    parts = batch.parts()
    rods = np.array([path.endswith("rod") for path in parts.path])
    size = (parts.high - parts.low)[rods].reshape(20, 2, 3)
    np.testing.assert_array_equal(size[:, 0], size[:, 1])  # its parameters are drawn once
    assert len(np.unique(size[:, 0, 2])) == 20
    assert (np.abs(size[:, :, 1] - 0.01) < 1e-12).all()


def test_alternatives_hand_in_templates_and_options_too() -> None:
    text = GRIPS.replace("HANDED", "Door(pull = Bar, mode = slim) | Door(pull = Plate, mode = wide)")
    batch = Session.of_text(HEAD + text).sampler.batch(np.arange(20), 1)
    parts = batch.parts()
    names = {path.rsplit(".")[-1] for path in parts.path}
    assert {"rod", "sheet"} <= names
    handles = np.array([path.endswith("handle") for path in parts.path])
    wide = np.array([template == "Plate" for template in parts.template])[handles]
    np.testing.assert_allclose((parts.high - parts.low)[handles, 1], np.where(wide, 0.04, 0.01))


def test_a_role_cannot_be_handed_in() -> None:
    session = Session.of_text(HEAD + GRIPS.replace("HANDED", "Door(pull = Handle, mode = slim)"))
    assert session.lowering is None
    (found,) = session.report.diagnostics
    assert found.code == "wrong-arguments" and "`Handle` is a role" in found.message
    assert "takes the name of a template or of a style" in (found.hint or "")


def test_a_style_draws_counts_and_words_once():
    template = (
        "role Front { slot face }\n"
        "template Grid : Front {\n"
        "  param look : choice wide | tall\n"
        "  count bars in 1 .. 9\n"
        "  part face : Cuboid(size = [bars * 1cm, 2cm if look == wide else 1cm, 1cm])\n"
        "}\n"
        "template Plain : Front { part face : Cuboid(size = [20cm, 1cm, 1cm]) }\n"
    )
    body = "style grid : Front = Grid weight 4 | Plain\nrepeat door[k] in 0 ..< 3 { part leaf : grid  connect leaf to body }"
    batch = Session.of_text(HEAD + template + ROW + body + "\n}\n").sampler.batch(np.arange(30), 1)
    parts = batch.parts()
    faces = np.array([path.endswith("leaf.face") for path in parts.path])
    sizes = np.round((parts.high - parts.low)[faces][:, :2], 6).reshape(30, 3, 2)
    assert (sizes == sizes[:, :1]).all(), "all leaves of an object are alike"
    assert len(np.unique(sizes[:, 0, 0])) > 5 and len(np.unique(sizes[:, 0, 1])) == 2
