"""What parts cost is counted as the check meets it, and a part that costs much is named."""

import json
from textwrap import dedent

import numpy as np
import pytest

from artipg_dsl.cli.main import main
from artipg_dsl.diagnostics.codes import CODES
from artipg_dsl.quality.cost import measure_costs
from artipg_dsl.session import Session
from artipg_dsl.validity.bodies import gather
from artipg_dsl.validity.tree import Tree


@pytest.mark.parametrize("category", ["Microwave", "Faucet"])
def test_pieces_and_pairs_are_those_that_the_check_gathers(category):
    batch = Session.of(category).sampler.batch(np.arange(5), 0)
    tree = Tree(batch)
    body = gather(batch, tree.first, tree.turn, tree.shift)
    found = measure_costs(batch)
    assert sum(cost.pieces for cost in found) * 5 == pytest.approx(len(body))
    same = (body.owner[:, None] == body.owner) & (body.link[:, None] != body.link)
    assert sum(cost.pairs for cost in found) * 5 == pytest.approx(same.sum())
    assert [cost.pieces for cost in found] == sorted((cost.pieces for cost in found), reverse=True)


def test_check_names_the_part_and_its_pieces():
    session = Session.of_text(dedent(CODES["expensive-check"].example))
    (told,) = [d for d in session.examine().diagnostics if d.code == "expensive-check"]
    assert "`row.bristle.hair` has 1600 convex pieces" in told.message and told.severity == "warning"


def test_check_names_a_part_of_many_primitives_that_overlap():
    """900 bristles, each of which may share volume with those beside it: few pieces, but much to weigh for `require stable`."""
    text = (
        dedent(CODES["expensive-check"].example)
        .replace("0 ..< 40", "0 ..< 30")
        .replace("[2mm, 2mm, 2cm]", "[20cm, 20cm, 2cm]")
    )
    assert not [d for d in Session.of_text(text).examine().diagnostics if d.code == "expensive-check"]
    stable = text.rstrip().removesuffix("}") + "  require stable\n}\n"
    (told,) = [d for d in Session.of_text(stable).examine().diagnostics if d.code == "expensive-check"]
    assert (
        "`row.bristle.hair` has 900 convex pieces" in told.message and "which `require stable` weighs" in told.message
    )


def test_profile_prints_stages_and_parts(capsys):
    assert main(["profile", "Faucet", "-n", "2", "--json"]) == 0
    found = json.loads(capsys.readouterr().out)
    assert found["compiling"] > 0
    assert {"drawing", "checking", "writing points"} <= set(found["stages"])
    assert all(0 < spent["first"] and 0 < spent["all"] for spent in found["stages"].values())
    assert found["parts"][0]["pieces"] >= found["parts"][-1]["pieces"] > 0
    assert main(["profile", "Faucet", "-n", "2"]) == 0
    shown = capsys.readouterr().out
    assert found["parts"][0]["part"] in shown and "first object" in shown
