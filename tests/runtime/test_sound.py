"""What is handed out are numbers, also where a program has lost the requirements that see to it."""

from __future__ import annotations

import pytest

from artipg_dsl.errors import UserError
from artipg_dsl.run.job import prepare
from artipg_dsl.run.request import Request
from artipg_dsl.sampling.sample import Sampler
from artipg_dsl.session import Session

TEXT = """apg 1
use primitives { Cuboid }
category Box {
  param q : ratio in -1 .. 1
  root part body : Cuboid(size = [9cm, 9cm, 9cm])
  part lid : Cuboid(size = [9cm, 9cm, 1cm])
  connect lid.bottom on body.top
  align lid.center.y = 1cm * sqrt(q)
}
"""


def test_a_program_without_its_requirements_hands_out_nothing() -> None:
    lowering = Session.of_text(TEXT, "box.apg").lowering
    assert lowering is not None
    program = lowering.program
    made = prepare(Sampler(program), Request("box.apg", checked=False)).batch(range(8))
    assert made.state.attempt.any()
    program.requirements.clear()
    with pytest.raises(UserError, match="it has a number that is not finite"):
        prepare(Sampler(program), Request("box.apg", checked=False)).batch(range(8))
