"""Programs in which much stands one within another, or follows one from another: compiled, or told of with a place."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from artipg_dsl.diagnostics import CompileError
from artipg_dsl.session import Session, check_text
from artipg_dsl.source import Source

HEAD = "apg 1\nuse primitives { Cuboid }\ncategory T {\n  root part p0 : Cuboid(size = [1cm, 1cm, 1cm])\n"


def test_a_chain_of_hundreds_of_parts_is_compiled() -> None:
    parts = "".join(
        f"  part p{k + 1} : Cuboid(size = [1cm, 1cm, 1cm])\n  connect p{k + 1}.bottom on p{k}.top\n" for k in range(260)
    )
    batch = Session.of_text(f"{HEAD}{parts}}}\n").sampler.batch(np.arange(1), 0)
    assert batch.parts().translation[:, 2].max() == pytest.approx(2.605)


def test_what_cannot_be_followed_is_told_with_a_place() -> None:
    values = "".join(f"  let a{k + 1} = a{k} * 0.9 + 1mm\n" for k in range(1200))
    session = Session.of_text(f"{HEAD}  param a0 : length in 1cm .. 2cm\n{values}  require a1200 > 1mm\n}}\n", "t.apg")
    with pytest.raises(CompileError) as told:
        _ = session.sampler
    assert [(d.code, str(d.span)) for d in told.value.report.diagnostics] == [("too-deep", "t.apg:3:10")]


@pytest.mark.parametrize(("terms", "codes"), [(190, []), (205, ["too-deep"])])
def test_a_sum_of_many_terms(terms: int, codes: list[str]) -> None:
    text = f"{HEAD}  param k : length in 1mm .. 2mm\n  require {' + '.join(['k'] * terms)} > 1cm\n}}\n"
    found = [d for d in check_text(Source("t.apg", text)).diagnostics if d.severity == "error"]
    assert [d.code for d in found] == codes
    assert all(d.span is not None and d.span.line == 6 for d in found)


def test_guards_within_guards_take_no_time() -> None:
    """Each level had doubled it: 22 took longer than a coffee."""
    text = f"{HEAD}  count k in 1 .. 2\n{'when k > 1 {' * 25}\n  require p0.size.x < 2cm\n{'}' * 25}\n}}\n"
    assert not check_text(Source("t.apg", text)).failed


@pytest.mark.parametrize(
    "text", ["", "\ufeff", "\n \t\n", "# stool\n## a stool\n", "apg 1\nuse primitives { Cuboid }\n"]
)
def test_a_file_that_declares_nothing(tmp_path: Path, text: str) -> None:
    path = tmp_path / "empty.apg"
    path.write_text(text, encoding="utf-8")
    found = [d for d in Session.of(path).examine().diagnostics if d.severity == "error"]
    assert [(d.code, d.span and d.span.line) for d in found] == [("nothing-declared", 1)]
