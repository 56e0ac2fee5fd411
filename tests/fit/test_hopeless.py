"""What a category does not match is told after the search: choices of it are not decided."""

from __future__ import annotations

import numpy as np
import pytest

from artipg_dsl.fit import fitting
from artipg_dsl.fit.compare import Candidates
from artipg_dsl.fit.fitting import fit
from artipg_dsl.fit.model import Model
from artipg_dsl.fit.pose import Frame, Posed, pose
from artipg_dsl.fit.reading import Cloud
from artipg_dsl.session import Session

from .test_states import CASE, LITTLE, seen

_LAST = ": choices and numbers"  # what is done in the end


def star() -> Posed:
    """Three thin rods that cross, which no box is like."""
    chance = np.random.default_rng(0)
    along = chance.uniform(-0.15, 0.15, (3000, 3)) * np.repeat(np.eye(3), 1000, axis=0)
    points = along + chance.normal(size=(3000, 3)) * 0.002
    points[:, 2] -= points[:, 2].min()
    return pose(Cloud(points, None, np.full(3000, -1), ()), Frame(front="x", unit="m"), ".npz", 1.0)


@pytest.mark.slow
def test_only_what_may_fit_is_decided(monkeypatch: pytest.MonkeyPatch) -> None:
    decided, told = [], list[str]()

    def decide(model: Model, targets: object, found: Candidates, effort: object, rivals: object) -> Candidates:
        decided.append(found.target.tolist())
        return found

    monkeypatch.setattr(fitting, "decide", decide)
    sampler = Session.of_text(CASE).sampler
    case, strange = seen(0.0)[1], star()
    opened = Model(sampler, opened=True)
    found = fit(Model(sampler), [strange, case, strange], effort=LITTLE, opened=opened, doing=told.append)
    assert [one.told["verdict"] for one in found] == ["does not fit", "fits", "does not fit"]
    assert decided == [[1]]
    assert told == [
        "3 objects",
        *(f"2 objects with {how}" for how in ("other upward axes", "joints anywhere")),
        f"3 objects{_LAST}",
    ]
    assert found[1].told["distance"]["both"] < 1.0
    assert found[0].told["distance"] == found[2].told["distance"]


def test_nothing_may_fit() -> None:
    sampler = Session.of_text(CASE).sampler
    doing: list[str] = []
    (one,) = fit(Model(sampler), [star()], effort=LITTLE, doing=doing.append)
    assert doing == ["1 object", "1 object with other upward axes", f"1 object{_LAST}"]
    assert one.told["verdict"] == "does not fit" and one.told["distance"]["both"] > 5.0
