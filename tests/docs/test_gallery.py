"""The worked examples of the gallery are programs without findings, whose first attempts are valid."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from artipg_dsl.sampling.statistics import Statistics
from artipg_dsl.session import Session

GALLERY = Path(__file__).parents[2] / "docs" / "gallery"


@pytest.mark.parametrize(
    "name", ["arm_lamp", "corkscrew", "cymbal_stand", "desk_lamp", "scissor_jack", "venetian_blind"]
)
def test_a_worked_example(name: str) -> None:
    session = Session.of(str(GALLERY / f"{name}.apg"))
    session.advise()
    assert not session.report.diagnostics
    statistics = Statistics()
    session.sampler.batch(np.arange(40), 0, checked=True, statistics=statistics)
    assert statistics.first_valid == 40
