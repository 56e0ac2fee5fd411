"""The text form reads back to the same program."""

import numpy as np
import pytest

from artipg_dsl.graph.reading import TextError, from_text
from artipg_dsl.graph.writing import digest, to_text
from artipg_dsl.sampling.sample import Sampler
from artipg_dsl.session import Session


@pytest.fixture(scope="module")
def program():
    return Session.of("Microwave").lowering.program


def test_text_round_trips(program):
    text = to_text(program)
    again = from_text(text)
    assert to_text(again) == text
    assert digest(again) == digest(program) == program.hash


def test_a_label_under_no_guard_round_trips():
    text = """apg 1
use primitives { Cuboid }
use vocabularies { affordance }
category A {
  root part body : Cuboid(size = [1m, 1m, 1m])
  label affordance.lift on body where p.z > 0.2 * size.z
}
"""
    text = to_text(Session.of_text(text).sampler.program)
    assert to_text(from_text(text)) == text


def test_two_alternatives_of_one_template_round_trip():
    text = "use primitives { Cuboid }\ncategory C { root part p : Cuboid(size = [1cm, 1cm, 1cm]) | Cuboid(size = [2cm, 1cm, 1cm]) }"
    told = to_text(Session.of_text("apg 1\n" + text).lowering.program)
    assert '"Cuboid#2"' in told and to_text(from_text(told)) == told


def test_a_switch_that_is_left_at_its_default_round_trips():
    text = """apg 1
use primitives { Cuboid }
template Post {
  param tall : bool = true
  part rod : Cuboid(size = [2cm, 2cm, 9cm])
  when tall { part cap : Cuboid(size = [3cm, 3cm, 1cm])  align cap.bottom = rod.top }
}
category A { root part post : Post }
"""
    text = to_text(Session.of_text(text).sampler.program)
    assert '= bool @0 "post.tall"' in text and to_text(from_text(text)) == text


def test_a_program_read_back_samples_the_same(program):
    numbers = np.arange(40)
    first = Sampler(program).batch(numbers, 3)
    second = Sampler(from_text(to_text(program))).batch(numbers, 3)
    for a, b in zip(first.sites(), second.sites(), strict=True):
        assert np.array_equal(a.translation, b.translation) and np.array_equal(a.link, b.link)


def test_the_hash_is_of_what_is_computed_not_of_comments():
    text = "apg 1\nuse primitives { Cuboid }\ncategory A {\n  root part a : Cuboid(size = [1m, 1m, %s])\n}\n"
    hashes = {}
    for name, body in {"plain": text % "1m", "comment": "# hello\n" + text % "1m", "other": text % "2m"}.items():
        session = Session.of_text(body)
        assert session.lowering is not None, session.report.diagnostics
        hashes[name] = session.lowering.program.hash
    assert hashes["plain"] == hashes["comment"] != hashes["other"]


@pytest.mark.parametrize(
    "broken", ["", "apgc 99\n", "apgc 1\n%0 = const\n", "apgc 1\nnonsense 3\n", 'apgc 1\nprogram "x"\n', "\x00"]
)
def test_what_is_no_program_is_refused(broken):
    with pytest.raises(TextError):
        from_text(broken)


def test_a_text_cut_short_is_refused_or_misses_nothing_it_needs(program):
    lines = to_text(program).split("\n")
    with pytest.raises(TextError):
        from_text("\n".join(lines[:40] + lines[60:]))
