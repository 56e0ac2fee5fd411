"""Mutants from the command line and in Python: written, made again from their folder, told apart."""

import json

import pytest

import artipg_dsl as apg
from artipg_dsl.errors import UsageError

from .helpers import CHEST, tree


def test_mutants_are_written_and_made_again(apgc, tmp_path):
    first, second, plain = tmp_path / "first", tmp_path / "second", tmp_path / "plain"
    for folder, more in ((first, ("--mutate", "apa,cpa")), (second, ("--mutate", "apa,cpa", "--variant", 1)), (plain, ())):
        code, _, err = apgc("sample", CHEST, "-n", 6, "--seed", 3, "-o", folder, "--points", 64, *more)
        assert code == 0, err
    assert len({tree(f)["points-00000.npz"] for f in (first, second, plain)}) == 3
    again = apg.open_samples(first)
    drawn = [a["drawn"] for a in again.annotations()]
    lines = (first / "annotation-00000.jsonl").read_text(encoding="utf-8").splitlines()
    assert [json.loads(line)["drawn"].keys() for line in lines] == [d.keys() for d in drawn]
    code, _, err = apgc("sample", CHEST, "-n", 6, "--seed", 3, "-o", first, "--points", 64)
    assert code == 1 and "other options" in err


def test_mutants_in_python():
    batch = apg.sample("Microwave", n=12, seed=5)
    mutants = batch.mutate("cpa", only="width")
    assert (mutants["width"] != batch["width"]).all()
    assert (mutants["wall"] == batch["wall"]).all()
    found = mutants.changes(7)
    assert [c.path for c in found if c.kind == "varied"] == ["width"]
    assert batch.changes(7) == []
    assert mutants.object(7).drawn == mutants.batch.drawn(7)
    assert mutants.mutate("apa").job.mutations[1].operations == ("apa",)


@pytest.mark.parametrize("wrong", ["xpa", "apa,", ""])
def test_unknown_operations(apgc, tmp_path, wrong):
    if wrong:
        code, _, err = apgc("sample", CHEST, "-o", tmp_path / "x", "--mutate", wrong)
        assert code == 2 and "apa, dpa, cpa" in err
    with pytest.raises(UsageError):
        apg.sample("Microwave", n=1).mutate(wrong)
