"""What is pressed or pushed moves: its surface lies across the motion of the joint that the label is of.

``where n.x > 0.5`` on a part that stands ``along x`` is about the part's own x, which lies across: so labels of keys were on their sides.
"""

from __future__ import annotations

import os

import numpy as np
import pytest

from artipg_dsl.quality.dead import look_across
from artipg_dsl.resources import categories_dir
from artipg_dsl.session import Session

MENDED = ["camera", "clock", "coffee_machine", "lamp", "shaver", "toaster"]
WHOLE = {"cart"}  # a cart is pushed by its handle, which folds besides
EVERY = sorted({path.stem for path in categories_dir().glob("*.apg")} - WHOLE)


@pytest.mark.parametrize("category", EVERY if os.environ.get("ARTIPG_EVERY") else MENDED)
def test_what_is_pressed_lies_across_its_way(category: str) -> None:
    batch = Session.of(str(categories_dir() / f"{category}.apg")).sampler.batch(np.arange(8), 1)
    across: dict[tuple[str, int], list[np.ndarray]] = {}
    for ((name, _), joint), found in look_across(batch).items():
        across.setdefault((name, joint), []).append(found)
    shares = {key: float(np.concatenate(found).mean()) for key, found in across.items()}
    names = batch.program.joints
    assert shares or category not in MENDED
    assert not {(word, names[k].path): f"{share:.0%}" for (word, k), share in shares.items() if share < 0.8}
