"""Small programs, each about one thing of the language, at every stage between text and object.

``pytest tests/pipeline --update-golden`` writes what is expected anew: read the difference before it is committed.
"""

from __future__ import annotations

from difflib import unified_diff
from itertools import islice

import pytest

from artipg_dsl.graph.reading import from_text
from artipg_dsl.graph.writing import to_text

from .stages import HERE, PROGRAM, compiled, stages

NAMES = sorted(path.parent.name for path in HERE.glob(f"*/{PROGRAM}"))
LINES, LONGEST = 25, 120  # of a program, of a golden
SHOWN = 60  # lines of a difference


@pytest.mark.parametrize("name, stage", [(name, stage) for name in NAMES for stage in stages(name)])
def test_stage(name: str, stage: str, update_golden: bool) -> None:
    path = HERE / name / f"{stage}.txt"
    found = stages(name)[stage](compiled(name))
    if update_golden:
        path.write_text(found, encoding="utf-8")
    expected = path.read_text(encoding="utf-8") if path.exists() else ""
    if found != expected:
        lines = unified_diff(expected.splitlines(), found.splitlines(), "expected", "found", n=2, lineterm="")
        difference = "\n".join(islice(lines, SHOWN))
        pytest.fail(
            f"the {stage} of tests/pipeline/{name}/{PROGRAM} differs:\n\n{difference}\n\n"
            "if that is meant: pytest tests/pipeline --update-golden, and read the difference before it is committed",
            pytrace=False,
        )


@pytest.mark.parametrize("name", NAMES)
def test_nothing_is_found_at_fault(name: str) -> None:
    session = compiled(name)
    program = session.sampler.program
    assert not session.report.diagnostics
    assert to_text(from_text(to_text(program))) == to_text(program)


@pytest.mark.parametrize("name", NAMES)
def test_the_files_stay_small(name: str) -> None:
    """So that a person reads them."""
    sizes = {path.name: len(path.read_text(encoding="utf-8").splitlines()) for path in (HERE / name).iterdir()}
    assert set(sizes) == {PROGRAM, *(f"{stage}.txt" for stage in stages(name))}
    assert sizes.pop(PROGRAM) <= LINES
    assert max(sizes.values()) <= LONGEST, sizes
