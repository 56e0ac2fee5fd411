"""The order of a symmetry may be a value, and holds where its guard does."""

import numpy as np
import pytest

from artipg_dsl.annotate.poses import symmetry_words
from artipg_dsl.graph.expr import col
from artipg_dsl.session import Session

STAR = """apg 1
use primitives { Cylinder }
use vocabularies { semantic }
category Star {
  count arms in 1 .. 6 = 5
  param oval : choice yes | no
  root part hub : Cylinder(radius = 5cm, height = 1cm)
  repeat arm[i] ring arms about z {
    part tip : Cylinder(radius = 1cm, height = 1cm)
    align tip.center.x = 55mm
    connect tip to hub
  }
  label semantic.body on hub, arm.tip
  SYMMETRY
}
"""


def words(statement: str) -> tuple[list, dict[str, np.ndarray]]:
    """Per object the symmetry of its hub, and the draws by name."""
    batch = Session.of_text(STAR.replace("SYMMETRY", statement)).sampler.batch(np.arange(40), 1)
    draws = batch.program.draws
    drawn = {d.column.name: batch.read([col(d.column)], d.column.scope)[0] for d in draws}
    parts = batch.parts()
    hubs = [path == "hub" for path in parts.path]
    return symmetry_words(parts.symmetry[np.array(hubs)]), drawn


@pytest.mark.parametrize("count", ["arms", "2 * arms"])
def test_the_order_of_a_symmetry_is_a_value(count):
    found, drawn = words(f"symmetry hub : turn {count} about z")
    orders = (drawn["arms"] * (2 if count != "arms" else 1)).astype(int)
    assert found == [None if n == 1 else f"{n} about z" for n in orders]
    assert len(set(found)) >= 5


def test_the_last_symmetry_whose_guard_holds_is_meant():
    found, drawn = words(
        "symmetry hub : turn arms about x\n  when oval == yes { symmetry hub : turn 2 about z } else { symmetry hub : any about z }"
    )
    assert found == ["2 about z" if code == 0 else "any about z" for code in drawn["oval"]]
    assert len(set(found)) == 2


def test_a_symmetry_only_under_a_guard_leaves_the_others_without():
    found, drawn = words("when oval == yes { symmetry hub : turn arms + 1 about z }")
    assert found == [
        f"{n + 1:.0f} about z" if code == 0 else None for n, code in zip(drawn["arms"], drawn["oval"], strict=True)
    ]


def test_an_order_must_be_a_count():
    session = Session.of_text(STAR.replace("SYMMETRY", "symmetry hub : turn 3cm about z"))
    assert session.lowering is None
    assert "turns of a symmetry" in str(session.report.diagnostics[0].message) or "two or more" in str(
        session.report.diagnostics[0].message
    )
