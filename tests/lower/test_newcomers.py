"""Programs that new authors wrote from the documentation alone check, and give objects."""

from pathlib import Path

import numpy as np
import pytest

from artipg_dsl.session import Session

PROGRAMS = sorted((Path(__file__).parents[1] / "data" / "newcomers").glob("*.apg"))


@pytest.mark.slow
@pytest.mark.parametrize("path", PROGRAMS, ids=lambda path: path.stem)
def test_a_program_of_a_new_author_checks_and_gives_objects(path):
    session = Session.of(str(path))
    assert session.lowering is not None, [d.message for d in session.report.diagnostics if d.severity == "error"]
    parts = session.sampler.batch(range(2), 0).parts()
    assert len(parts.path) > 40
    assert np.isfinite(parts.low).all() and np.isfinite(parts.translation).all() and (parts.low <= parts.high).all()
