"""Masses where many solids overlap."""

import numpy as np
import pytest

from artipg_dsl.geometry import overlap
from artipg_dsl.session import Session
from artipg_dsl.validity.mass import masses

STEP = 2 * np.pi / 300


CROWD = """apg 1
use primitives { Cylinder }
category Brush {
  root part hub : Cylinder(radius = 6cm, height = 4cm)
  repeat leg[k] ring 300 about line(at = [0, 0, 0], along = z) {
    part rod : Cylinder(radius = 1cm, height = 10cm) along x
    connect rod to hub
    align rod.back = 5cm
  }
}
"""


def test_a_crowd_of_overlapping_solids_weighs_what_it_fills(monkeypatch: pytest.MonkeyPatch) -> None:
    """Three hundred rods of which each lies in some twenty others: against points of the whole, asked one by one."""
    batch = Session.of_text(CROWD).sampler.batch(np.arange(1), 0)
    asked: list[int] = []
    within = overlap._Rows.within
    monkeypatch.setattr(
        overlap._Rows,
        "within",
        lambda self, row, points, held, *near: asked.append(int(held.sum())) or within(self, row, points, held, *near),
    )
    found = masses(batch).mass[0]
    assert sum(asked) < 5e6  # pair by pair 50 million
    x, y, z = (0.32 * overlap.sequence(1 << 20).T - 0.16).T
    turn = np.arctan2(y, x)
    turn -= np.round(turn / STEP) * STEP  # the rods repeat: those nearest to a point hold it or none does
    away, radius = np.hypot(x, y), np.zeros(len(x), dtype=bool)
    for step in range(-20, 21):
        along, across = away * np.cos(turn + step * STEP), away * np.sin(turn + step * STEP)
        radius |= (along > 0.05) & (along < 0.15) & (across**2 + z**2 < 1e-4)
    radius |= (away < 0.06) & (np.abs(z) < 0.02)
    assert found == pytest.approx(700 * radius.mean() * 0.32**3, rel=0.02)
