"""Values that only some objects of a batch are given."""

import numpy as np
import pytest

from artipg_dsl.runtime.kernels import State
from artipg_dsl.sampling.known import evaluate_again, make_batch
from artipg_dsl.session import Session

TEXT = """apg 1
use primitives { Cuboid, Cylinder }
category Shelf {
  param width : length in 20cm .. 60cm ~ normal(40cm, 10cm)
  count bays in 1 .. 4
  root part body : Cuboid(size = [30cm, width, 5cm]) | Cylinder(radius = 5cm, height = 5cm) when width > 30cm
  repeat bay[i] in 0 ..< bays {
    param high : length in 5cm .. 20cm
    part post : Cuboid(size = [2cm, 2cm, high])
    align post.bottom = body.top
    align post.center.y = body.center.y + i * 3cm
    connect post to body
    require abs(high - 10cm) > 2cm
  }
  require bays < 4 or width > 30cm
}
"""
FREE = np.nan
GIVEN = {
    "width": [0.25, 0.25, FREE, 0.9, FREE, 0.5, FREE],  # 90 cm is beyond the range
    "bays": [4.0, FREE, 3.0, 2.0, FREE, 9.0, FREE],
    "body": [1.0, FREE, FREE, 1.0, 1.0, 0.0, FREE],  # a cylinder of 25 cm is excluded
    "bay.high": [FREE, 0.15, FREE, FREE, 0.10, 0.15, FREE],  # so are 10 cm
}


@pytest.fixture(scope="module")
def sampler():
    return Session.of_text(TEXT).sampler


@pytest.mark.parametrize("weigh", [False, True])
def test_each_object_is_as_if_it_was_made_alone(sampler, weigh):
    number = {draw.column.name: k for k, draw in enumerate(sampler.program.draws)}
    count = len(GIVEN["width"])

    def made(places):
        given = {number[name]: np.array(values)[places] for name, values in GIVEN.items()}
        if len(places) == 1:  # as a scalar, or not at all
            given = {k: float(value[0]) for k, value in given.items() if not np.isnan(value[0])}
        zeros = np.zeros(len(places), dtype=np.int64)
        return make_batch(sampler.program, sampler.plan, State(3, np.array(places), zeros, given, weigh=weigh))

    together = made(list(range(count)))
    failed = together.state.failed.tolist()
    assert 0 < sum(failed) < count and failed[0] and failed[3] and failed[4] and failed[5]
    missed, faults = dict.fromkeys(number.values(), 0), 0
    for place in range(count):
        alone = made([place])
        assert alone.state.failed.tolist() == [failed[place]]
        assert alone.state.log_weight.tolist() == [together.state.log_weight[place]]
        for k, values in alone.state.values.items():
            owner = together.owner(sampler.program.draws[k].column.scope)
            assert np.array_equal(together.state.values[k][owner == place], values)
        for k, many in alone.state.missed.items():
            missed[k] += many
        faults += sum(len(rows) for found in alone.state.faults.values() for rows in found)
    assert together.state.missed == {k: many for k, many in missed.items() if many}
    assert faults == sum(len(rows) for found in together.state.faults.values() for rows in found)


def test_objects_that_are_evaluated_again_are_given_their_own(sampler):
    number = {draw.column.name: k for k, draw in enumerate(sampler.program.draws)}
    state = State(0, np.arange(3), np.zeros(3, dtype=np.int64), {number["width"]: np.array([0.35, FREE, 0.45])})
    batch = make_batch(sampler.program, sampler.plan, state)
    again = evaluate_again(batch, np.array([2, 1, 2]))
    assert again.state.values[number["width"]].tolist() == batch.state.values[number["width"]][[2, 1, 2]].tolist()
