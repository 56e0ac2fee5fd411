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


SIZED = """apg 1
use primitives { Cuboid }
role Grip { inherit size : length[3] in [3cm, 1cm, 3cm] .. [6cm, 3cm, 40cm]  slot rod }
template Bar : Grip { part rod : Cuboid(size = size) }
template Bow : Grip { part rod : Cuboid(size = size) }
"""


def test_the_size_of_a_part_is_what_its_alternatives_say() -> None:
    text = (
        SIZED
        + """category C {
  root part body : Cuboid(size = [10cm, 2m, 1m])
  style pull : Grip = Bar(size = [5cm, 2cm, 30cm]) | Bow(size = [4cm, 2cm, 20cm])
  part grip : pull
  align grip.top = body.top
  connect grip.back on body.front
  require grip.size.z <= 25cm
}
"""
    )
    parts = Session.of_text(text).sampler.batch(np.arange(20), 1).parts()
    grips = np.array([path == "grip" for path in parts.path])
    assert {t for t, own in zip(parts.template, grips, strict=True) if own} == {"Bow"}
    np.testing.assert_allclose((parts.high - parts.low)[grips], [[0.04, 0.02, 0.2]] * 20)
    np.testing.assert_allclose((parts.translation + parts.high)[grips, 2], 1.0)


RANGED = """apg 1
use primitives { Cuboid }
role Leaf { inherit size : length[3]  slot board }
template Sunk : Leaf {
  param sunk : length in 1mm .. 0.3 * size.y
  part board : Cuboid(size = [size.x - sunk, size.y, size.z])
}
category C {
  root part body : Cuboid(size = [10cm, 2m, 10cm])
  style leaf : Leaf = Sunk
"""


def depths(body: str) -> np.ndarray:
    """How far the boards of 20 objects are sunk, and how wide they are: (20, boards, 2)."""
    parts = Session.of_text(RANGED + body + "}\n").sampler.batch(np.arange(20), 1).parts()
    boards = np.array([path.endswith("board") for path in parts.path])
    return (parts.high - parts.low)[boards].reshape(20, -1, 3)[..., :2]


def test_a_range_that_is_that_of_all_parts_is_drawn_in_once() -> None:
    pair = "".join(f"part {name} : leaf(size = [10cm, 8mm, 20cm])\n" for name in ("one", "two"))
    found = depths(pair + "connect one.bottom on body.top\nconnect two.bottom on one.top\n")
    np.testing.assert_array_equal(found[:, 0], found[:, 1])
    assert len(np.unique(found[:, 0, 0])) == 20


def test_a_range_that_follows_from_a_part_is_drawn_in_for_each() -> None:
    one, two = "part one : leaf(size = [10cm, 5cm, 20cm])", "part two : leaf(size = [10cm, 1cm, 20cm])"
    apart = f"{one}\n{two}\nconnect one.bottom on body.top\nconnect two.bottom on one.top\n"
    split = """repeat w[i] in 0 ..< 2 split body along y {
    part board_ : leaf(size = [10cm, _, 20cm])
    align board_.right = w.right
    align board_.left = w.right + 4cm * (i + 1)
    connect board_.bottom on body.top
  }
"""
    for body in (apart, split):
        sunk, wide = 0.1 - depths(body)[..., 0], depths(body)[..., 1]
        assert (sunk >= 0.001 - 1e-9).all() and (sunk <= 0.3 * wide + 1e-9).all(), body
        assert (sunk[:, 0] != sunk[:, 1]).all()
