"""The tutorial is right: each of its steps compiles, each command says what the page shows."""

from __future__ import annotations

import re
from pathlib import Path

import numpy as np
import pytest

from artipg_dsl.cli.main import main
from artipg_dsl.session import Session

from .tutorial import changed, commands, matches, steps

DOCS = Path(__file__).parents[2] / "docs"
PAGE = DOCS / "authoring.md"
RESULT = DOCS / "gallery" / "desk_lamp.apg"


def test_every_step(tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]) -> None:
    monkeypatch.chdir(tmp_path)
    file = Path("desk_lamp.apg")
    program = ""
    for step in steps(PAGE):
        if step.how == "console":
            for command, expected in commands(step):
                capsys.readouterr()
                main(command)
                out, err = capsys.readouterr()
                err = re.sub(r".*\[[#.]+\] .*\n", "", err)  # progress, which a slow machine shows
                assert matches(expected, out + err), f"line {step.line}: apgc {' '.join(command)}\n{out}{err}"
            file.write_text(program, encoding="utf-8")
            continue
        after = changed(program, step)
        file.write_text(after, encoding="utf-8")
        if step.how != "wrong":
            program = after
    assert program == RESULT.read_text(encoding="utf-8")


def test_the_lamp_is_valid() -> None:
    session = Session.of(RESULT)
    batch = session.sampler.batch(np.arange(40), 0, checked=True)
    session.advise()
    assert not session.report.diagnostics
    assert len(batch.links().owner) >= 5 * 40
