"""A choice can be weighted, as counts are: `~ values(...)` with a word repeated."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
import pytest

from artipg_dsl.session import Session

TEXT = """apg 1
use primitives { Cuboid }
template Seat {
  param edge : choice sharp | soft | worn ~ values(soft, soft, soft, worn)
  part slab : Cuboid(size = [30cm, 30cm, 3cm])
}
category Stool {
  param shape : choice round | square | oval = oval ~ values(square, oval, oval, oval)
  root part seat : Seat
}
"""


def test_words_are_as_likely_as_they_are_repeated() -> None:
    batch = Session.of_text(TEXT, "stool.apg").sampler.batch(np.arange(2000), seed=5)
    drawn = {d.column.name: batch.state.values[k].astype(int) for k, d in enumerate(batch.program.draws)}
    for name, shares in (("shape", (0, 0.25, 0.75)), ("seat.edge", (0, 0.75, 0.25))):
        found = np.bincount(drawn[name], minlength=3) / 2000
        assert np.allclose(found, shares, atol=0.03), (name, found)


def test_a_word_of_weight_0_is_not_drawn() -> None:
    sampler = Session.of_text(TEXT, "stool.apg").sampler
    number = next(k for k, d in enumerate(sampler.program.draws) if d.column.name == "shape")
    assert not (sampler.batch(np.arange(200), seed=1).state.values[number] == 0).any()


def test_the_default_of_a_choice_is_what_it_says() -> None:
    """Where defaults are asked for, and unless the default has no weight or is ruled out there."""
    text = TEXT.replace("~ values(square, oval, oval, oval)", "") + "# {}"
    ruled = text.replace("root part", "require shape == square\n  root part")
    none = TEXT.replace("= oval ~ values(square, oval, oval, oval)", "= oval ~ values(square, round)")
    for program, expected in ((text, "oval"), (ruled, "square"), (none, "round")):
        batch = Session.of_text(program, "stool.apg").sampler.batch(np.arange(1), seed=5, defaults=True)
        assert batch.drawn(0)["shape"] == expected
        assert batch.drawn(0)["seat.edge"] == "soft"  # without a default, the first that may be drawn


@pytest.mark.parametrize("condition", ["lid == cup", "not (lid != cup)"])
def test_choices_are_compared_by_name(condition: str) -> None:
    """Their options may stand in another order, and not all of them need be those of both."""
    text = TEXT.replace(
        "root part",
        f"""param lid : choice red | blue | green
  param cup : choice blue | grey | red
  require {condition}
  root part""",
    )
    batch = Session.of_text(text, "stool.apg").sampler.batch(np.arange(60), seed=1)
    found = {d.column.name: (d.options, batch.state.values[k].astype(int)) for k, d in enumerate(batch.program.draws)}
    lid, cup = ([options[code] for code in codes] for options, codes in (found["lid"], found["cup"]))
    assert lid == cup and set(lid) == {"red", "blue"}


@pytest.mark.parametrize(
    ("within", "required", "holds"),
    [
        ("", "require leg[0].shade == dark", lambda found: found[0] == 0),
        ("", "require sum(leg.one) == 1", lambda found: (found == 0).sum() == 1),
        ("when i > 0 { require shade != previous.shade }", "", lambda found: (found[1:] != found[:-1]).all()),
    ],
    ids=["an element", "the sum of all", "the one before"],
)
def test_a_requirement_on_other_rows_leaves_a_choice_to_each(
    within: str, required: str, holds: Callable[[np.ndarray], bool]
) -> None:
    text = f"""apg 1
use primitives {{ Cuboid }}
category Stool {{
  root part seat : Cuboid(size = [30cm, 30cm, 3cm])
  repeat leg[i] in 0 ..< 4 spread seat along y margin 2cm {{
    param shade : choice dark | pale | white
    let one = 1 if shade == dark else 0
    part rod : Cuboid(size = [2cm, 2cm, 20cm])
    connect rod.top on seat.bottom at x = 0, y = leg.center.y
    {within}
  }}
  {required}
}}
"""
    each = Session.of_text(text, "stool.apg").sampler.batch(np.arange(60), seed=1).state.values[0].reshape(60, 4)
    assert all(holds(found) for found in each) and len(np.unique(each, axis=0)) > 12
