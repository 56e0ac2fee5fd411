"""Programs and settings that leave nothing end at once, and tight ones with an answer."""

import numpy as np
import pytest

import artipg_dsl
from artipg_dsl.diagnostics import CompileError
from artipg_dsl.errors import NoObject
from artipg_dsl.sampling.statistics import Exhausted, Statistics
from artipg_dsl.session import Session
from artipg_dsl.validity import validate
from artipg_dsl.validity.faults import find_faults

HEAD = "apg 1\nuse primitives { Cuboid }\ncategory Box {\n"
BODY = "  root part body : Cuboid(size = [10cm, 10cm, 10cm])\n"


def program(*lines: str) -> str:
    return HEAD + BODY + "".join(f"  {line}\n" for line in lines) + "}\n"


def chain(count: int, last: str) -> str:
    """Values of which each is at least a little more than the one before."""
    names = [f"a{k}" for k in range(count)]
    steps = [f"require {b} >= {a} + 1mm" for a, b in zip(names, names[1:], strict=False)]
    return program(*(f"param {n} : length in 1cm .. 10cm" for n in names), *steps, last)


def test_values_that_are_set_against_each_other_end_after_one_attempt() -> None:
    text = program("param a : length in 1cm .. 9cm", "param b : length in 1cm .. 9cm", "require a + 2cm <= b")
    sampler = Session.of_text(text).sampler
    with pytest.raises(Exhausted) as found:
        sampler.batch(np.arange(8), 0, given={0: 0.08})
    assert found.value.attempts == 1 and found.value.statistics.attempts == 8
    assert len(sampler.batch(np.arange(8), 0, given={0: 0.06})) == 8


def test_the_range_of_what_follows_is_told_where_it_leaves_nothing() -> None:
    with pytest.raises(CompileError) as found:
        _ = Session.of_text(
            program("param a : length in 45cm .. 60cm", "param b : length derived in 25cm .. 55cm", "align b = a / 10")
        ).sampler
    assert "and `b`, which follows from it, must lie in its range" in str(found.value)


def test_a_long_contradiction_is_told_with_all_that_leads_to_it() -> None:
    with pytest.raises(CompileError) as found:
        _ = Session.of_text(chain(12, "require a11 <= a0")).sampler
    message = str(found.value)
    assert "impossible" in message and "require a11 <= a0" in message and "require a6 >= a5 + 1mm" in message


def test_a_tight_chain_is_met_at_the_first_attempt() -> None:
    statistics = Statistics()
    sampler = Session.of_text(chain(12, "require a11 <= a0 + 12mm")).sampler
    batch = sampler.batch(np.arange(50), 0, statistics=statistics)
    values = np.stack([batch.values()[f"a{k}"] for k in range(12)])
    assert (np.diff(values, axis=0) >= 0.001 - 2e-9).all() and statistics.first_valid == 50


def test_a_contradiction_within_an_alternative_leaves_the_others() -> None:
    session = Session.of_text(
        "apg 1\nuse primitives { Cuboid }\ntemplate Low {\n  param rise : length in 1cm .. 5cm\n"
        "  part block : Cuboid(size = [20cm, 20cm, rise])\n  require rise >= 6cm\n}\n"
        + HEAD.split("\n", 2)[2]
        + BODY
        + "  part top : Low | none\n  connect top.bottom on body.top\n}\n"
    )
    batch = session.sampler.batch(np.arange(10), 0)
    assert [d.code for d in session.report.diagnostics] == ["impossible"] and not session.report.failed
    assert {batch.drawn(k)["top"] for k in range(10)} == {"none"}


LINKS = """apg 1
use primitives { Cuboid }
category Slide {
  param long : length in 10cm .. 12cm
  root part body : Cuboid(size = [40cm, 20cm, 10cm])
  part drawer : Cuboid(size = [long, 10cm, 10cm])
  joint pull : prismatic body -> drawer along x range 0 .. 5cm
  align drawer.center.x = body.center.x
  align drawer.center.y = body.center.y
  align drawer.bottom = body.top %s
  part wall : Cuboid(size = [1cm, 20cm, 20cm])
  connect wall to body
  align wall.bottom = body.top
  align wall.center.y = body.center.y
  align wall.front = drawer.front + %s
}
"""


@pytest.mark.parametrize(("place", "room"), [("- 1cm", "10cm"), ("+ 0mm", "2cm")], ids=["at rest", "in motion"])
def test_what_always_collides_is_told_early_whatever_the_number_of_objects(place: str, room: str) -> None:
    for objects, most in ((1, 25), (3, 51), (8, 56), (200, 200)):
        statistics = Statistics()
        with pytest.raises(Exhausted):
            Session.of_text(LINKS % (place, room)).sampler.batch(
                np.arange(objects), 0, checked=True, statistics=statistics
            )
        assert statistics.attempts <= most
        assert {joint for _, _, joint in statistics.collided} == ({""} if place == "- 1cm" else {"pull"})


def test_what_collides_often_is_drawn_again_until_it_does_not() -> None:
    statistics = Statistics()
    text = LINKS % ("+ 0mm", "gap")
    text = text.replace("  root", "  param gap : length in 1cm .. 7.4cm\n  root")
    batch = Session.of_text(text).sampler.batch(np.arange(12), 0, checked=True, statistics=statistics)
    assert len(batch) == 12 and statistics.first_valid < 6


def test_objects_that_are_wrong_at_rest_are_not_moved(monkeypatch: pytest.MonkeyPatch) -> None:
    """Loops that cannot close took longest, for objects that were refused anyway."""
    text = LINKS % ("+ 0mm - far", "10cm")
    text = text.replace("  root", "  param far : length in -1cm .. 1cm\n  root")
    swept: list[int] = []
    sliding = validate._sliding
    monkeypatch.setattr(
        validate, "_sliding", lambda tree, body, *rest: swept.extend(body.owner.tolist()) or sliding(tree, body, *rest)
    )
    sampler = Session.of_text(text).sampler
    plain = sampler.batch(np.arange(20), 0)
    wrong = set(validate.find_collisions(plain).objects().tolist())
    assert 4 < len(wrong) < 16
    swept.clear()
    sampler.batch(np.arange(20), 0, checked=True)
    assert find_faults(plain, soon=True).objects().tolist() == sorted(wrong)
    swept.clear()
    find_faults(plain, soon=True)
    assert set(swept) == set(range(20)) - wrong


def refused(text: str) -> NoObject:
    """Why no object of a program is made, as a user is told."""
    with pytest.raises(NoObject) as found:
        artipg_dsl.load(text, n=2)
    return found.value


def test_two_links_of_one_part_are_told_apart_by_what_is_in_it() -> None:
    hook = (
        "template Hook {\n  part eye : Cuboid(size = [2cm, 2cm, 2cm])\n  part pin : Cuboid(size = [1cm, 6cm, 1cm])\n"
        "  align pin.left = eye.left - 1mm\n  joint swing : revolute eye -> pin about pin.left.back range 0deg .. 20deg\n}\n"
    )
    text = program("part hook : Hook", "connect hook.bottom on body.top at center").replace(
        "category", hook + "category"
    )
    assert "`hook.eye` and `hook.pin`" in refused(text).message


def test_what_tips_over_is_told_what_to_try() -> None:
    text = program("part arm : Cuboid(size = [90cm, 2cm, 2cm])", "connect arm.back on body.front", "require stable")
    found = refused(text)
    assert "it tips over" in found.message and found.hint is not None and "broaden what it stands on" in found.hint
