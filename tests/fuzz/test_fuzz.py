"""A few hundred mutated programs and artefacts: the whole run is ``python benchmarks/fuzz.py -n 100000 -o fuzz``."""

from __future__ import annotations

import importlib.util
import json
import random
from pathlib import Path
from types import ModuleType

import pytest

ROOT = Path(__file__).parents[2]
FEW, SMALL = 60, 2000  # cases, characters of a program


@pytest.fixture(scope="module")
def fuzz() -> ModuleType:
    spec = importlib.util.spec_from_file_location("fuzz", ROOT / "benchmarks" / "fuzz.py")
    assert spec is not None and spec.loader is not None
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    return module


def test_nothing_breaks(fuzz: ModuleType, tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    corpus = fuzz.Corpus(5, tmp_path / "compiled", compiled=False)
    corpus.programs = {
        name: text for name, text in corpus.programs.items() if len(text) < SMALL and "library" not in name
    }
    kept = {
        name: text
        for name, text in corpus.programs.items()
        if name.startswith("tests/cli") or name.endswith("tight_chain.apg")
    }
    corpus.compiled = dict(fuzz.artefacts(kept, tmp_path / "compiled"))
    assert len(corpus.programs) > 3 and corpus.compiled
    assert fuzz.fuzz(corpus, FEW, tmp_path) == 0, capsys.readouterr().out
    record = json.loads((tmp_path / "record.json").read_text())
    assert sum(record["outcomes"].values()) == record["next"] == FEW
    assert fuzz.fuzz(corpus, FEW, tmp_path) == 0  # it goes on behind the last: nothing is left


def test_what_breaks_is_told_apart_and_kept(fuzz: ModuleType, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """A traceback, a case that takes too long, one that takes all memory, one that ends the process, a wrong object."""

    def run(name: str, text: str) -> str:
        if text == "0":
            raise KeyError("missing")
        if text == "1":
            while True:
                pass
        if text == "2":
            return str(len(bytearray(2 << 30)))
        if text == "3":
            import os

            os._exit(3)
        return "broken: nan in points" if text == "4" else "fine"

    class Numbers:
        def case(self, number: int) -> tuple[str, str, str]:
            return "program.apg", "nothing", str(number)

    monkeypatch.setattr(fuzz, "run", run)
    monkeypatch.setattr(fuzz, "SECONDS", 0.2)
    assert fuzz.fuzz(Numbers(), 8, tmp_path) == 5
    outcomes = json.loads((tmp_path / "record.json").read_text())["outcomes"]
    assert outcomes == {"traceback": 2, "hang": 1, "crash exit 3": 1, "broken: nan in points": 1, "fine": 3}
    assert {path.read_text() for path in tmp_path.glob("*/*.apg")} == {"0", "1", "2", "3", "4"}


def test_cases_are_the_same_for_the_same_seed(fuzz: ModuleType, tmp_path: Path) -> None:
    one, two = (fuzz.Corpus(3, tmp_path, compiled=False) for _ in range(2))
    cases = [one.case(number) for number in range(40)]
    assert cases == [two.case(number) for number in range(40)]
    assert len({text for _, _, text in cases}) > 35
    for kind in {*fuzz.KINDS, *fuzz.LEGAL}:
        assert any(kind(text, random.Random(1), "other") != text for text in list(one.programs.values())[:3]), kind


def test_mutations_of_compiled_programs_exchange_what_is_of_a_kind(fuzz: ModuleType, tmp_path: Path) -> None:
    small = {
        k: v for k, v in fuzz.Corpus(3, tmp_path, compiled=False).programs.items() if k.endswith("tight_chain.apg")
    }
    ((_, text),) = fuzz.artefacts(small, tmp_path)
    for kind in fuzz.COMPILED:
        found = [kind(text, random.Random(k), "other") for k in range(12)]
        assert any(new != text for new in found), kind


def test_much_of_what_is_done_stays_legal(fuzz: ModuleType, tmp_path: Path) -> None:
    """Mutants that are refused at once say nothing of what is delivered."""
    program = (ROOT / "tests/pipeline/mimic/program.apg").read_text()
    done = [kind(program, random.Random(k), "other") for kind in fuzz.LEGAL for k in range(3)]
    fine = [fuzz.run("mimic.apg", text) == "fine" for text in done]
    assert sum(fine) > len(fine) / 3
