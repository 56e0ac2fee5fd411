"""Choices that only rule which options others may have are tried, with twins in the place of what is no longer possible."""

from __future__ import annotations

import numpy as np
import pytest

import artipg_dsl as apg
from artipg_dsl.fit.compare import Candidates
from artipg_dsl.fit.model import Changes, Model
from artipg_dsl.fit.tries import tries

from .test_decide import still

# handles of all plates are of one kind, or those of the left plate of their own; of two plates, one may be missing
KINDS = """
apg 1
use primitives { Cuboid }
role Front { inherit kind : choice low | high  inherit room : length[3]  slot leaf }
template Plate : Front {
  param thick : length in 1cm .. 3cm = 2cm
  part leaf : Cuboid(size = [thick, room.y, room.z])
  part knob : Cuboid(size = [3cm, 3cm, 4cm if kind == low else 12cm])
  connect knob.back on leaf.front
}
category Kinds {
  param kinds   : choice alike | two ~ values(alike, alike, two)
  param of_all  : choice low | high = low
  param of_left : choice low | high = low
  root part base : Cuboid(size = [40cm, 80cm, 2cm])
  part left : Front(room = [5cm, 20cm, 30cm]) = Plate(kind = of_all) when kinds == alike
    | Plate(kind = of_left) when kinds == two
  connect left.bottom on base.top at y = 20cm
  part right : Front(kind = of_all, room = [5cm, 20cm, 30cm]) = Plate | none
  connect right.bottom on base.top at y = -20cm
}
"""


def draw(model: Model, name: str) -> int:
    return next(k for k, one in enumerate(model.program.draws) if one.column.name == name)


def with_values(model: Model, samples: apg.Samples, told: dict[str, float]) -> Candidates:
    every = np.arange(len(samples))
    batch = model.assembled([(samples.batch, every)])
    for name, value in told.items():
        row = np.arange(len(batch.state.values[draw(model, name)]))
        batch = model.altered(
            batch, every, Changes(row, np.full(len(row), draw(model, name)), row, np.full(len(row), value))
        )
    return Candidates(batch, every, still(len(every)), np.zeros(len(every)))


@pytest.fixture(scope="module")
def kinds() -> tuple[apg.Samples, Model]:
    samples = apg.load(KINDS, n=1, seed=1)
    return samples, Model(samples.job.sampler)


def test_what_rules_others_is_tried_beside_what_twins_do_not_share(kinds: tuple[apg.Samples, Model]) -> None:
    samples, model = kinds
    (one,) = model.ruled
    assert one.ruling == draw(model, "kinds") and one.ruling not in model.discrete
    assert sorted(one.apart) == sorted([draw(model, "of_all"), draw(model, "of_left")])
    found = with_values(model, samples, {"kinds": 0.0, "of_all": 0.0, "of_left": 0.0, "right": 0.0})
    thick = [k for k, each in enumerate(model.program.draws) if each.column.name == "left.thick"]
    was = np.concatenate([found.batch.state.values[k] for k in thick])
    told = [batch for batch in tries(model, found.batch, 2, 1) if (batch.draw == one.ruling).any()]
    seen = set()
    for each in told:
        mine = np.flatnonzero(each.draw == one.ruling)
        left, of_all = (each.batch.state.values[draw(model, name)][mine] for name in ("left", "of_all"))
        assert (left == 1.0).all()  # the same template, of the other kind
        seen |= set(of_all.tolist())
        now = model.assembled([(each.batch, mine)])
        assert np.isin(np.concatenate([now.state.values[k] for k in thick]), was).all()  # and as thick
    assert seen == {0.0, 1.0}


def test_a_rarer_value_is_not_tried_where_it_only_hides_a_choice(kinds: tuple[apg.Samples, Model]) -> None:
    """Without the right plate, its handle would be of a kind that nothing shows."""
    samples, model = kinds
    found = with_values(model, samples, {"kinds": 0.0, "right": 1.0})
    assert not any((one.draw == draw(model, "kinds")).any() for one in tries(model, found.batch, 2, 1))
    back = with_values(model, samples, {"kinds": 1.0, "of_left": 0.0, "left": 1.0, "of_all": 1.0, "right": 1.0})
    assert any((one.draw == draw(model, "kinds")).any() for one in tries(model, back.batch, 2, 1))
