"""``apgc sample --sampling`` and what ``--stats`` tells of it."""

from pathlib import Path

import numpy as np

from artipg_dsl.api import open_samples

from .helpers import Apgc

COUPLED = """apg 1
use primitives { Cuboid }
category C {
  param a, b : length in 1cm .. 10cm = 2cm
  require a + b <= 9cm
  prefer a >= b weight 2
  root part body : Cuboid(size = [a, b, 1cm])
}
"""


def test_prior_is_made_again_from_its_folder(apgc: Apgc, tmp_path: Path) -> None:
    program, folder = tmp_path / "coupled.apg", tmp_path / "o"
    program.write_text(COUPLED)
    code, out, _ = apgc("sample", program, "-n", 30, "-o", folder, "--points", 4, "--stats", "--sampling", "prior:16")
    assert code == 0 and "resampled among 16 attempts for each object" in out
    again = open_samples(folder)
    assert again.job.request.candidates == 16 and again.batch.state.attempt.max() > 2
    assert np.isfinite(again.batch.log_weight).all()


def test_preferences_are_counted_apart(apgc: Apgc, tmp_path: Path) -> None:
    program = tmp_path / "coupled.apg"
    program.write_text(COUPLED)
    code, out, _ = apgc("sample", program, "-n", 60, "-o", tmp_path / "o", "--points", 4, "--stats")
    assert code == 0 and "60 objects, 100.0% valid on the first attempt" in out
    assert "valid objects passed over by preference" in out and "coupled.apg:6: prefer a >= b" in out


def test_another_way_is_refused(apgc: Apgc, tmp_path: Path) -> None:
    code, _, err = apgc("sample", "Microwave", "-o", tmp_path / "o", "--sampling", "posterior")
    assert code != 0 and "unknown sampling `posterior`" in err
