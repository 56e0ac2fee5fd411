"""A name has the value that it has where it is written, wherever that is lowered."""

from __future__ import annotations

import re
from pathlib import Path

import numpy as np
import pytest

from artipg_dsl.cli.main import main
from artipg_dsl.lower.expressions.evaluate import Evaluator
from artipg_dsl.session import Session

HEAD = """apg 1
use primitives { Cuboid }
material oak { density 600kg/m3 }
material ash { density 700kg/m3 }
vocabulary semantic { leaf }
"""
BODY = "  root part body : Cuboid(size = [10cm, 50cm, 50cm])\n"


ROWS = f"""
role Row {{ inherit size : length[3]   slot leaf   joint motion }}
template Drawers : Row {{
  repeat row[i] in 0 ..< 2 split box along y {{
    part leaf : Cuboid(size = [1cm, 10cm, 10cm])
    joint motion : prismatic base -> leaf along x range 0cm .. 5cm
  }}
}}
category C {{
{BODY}  part drawers : Row(size = [10cm, 50cm, 50cm]) = Drawers
  connect drawers.back on body.front at center
  part lid : Cuboid(size = [1cm, 1cm, 1cm])
  joint slide : prismatic body -> lid.bottom along x range 0cm .. 5cm #
  label semantic.leaf on drawers.leaf
}}
"""


def lowered(text: str) -> Session:
    session = Session.of_text(HEAD + text)
    assert session.lowering is not None, session.report.diagnostics
    return session


def test_arguments_in_a_style_are_those_of_where_the_style_stands() -> None:
    session = lowered(f"""
role Knob {{ inherit size : length[3] in [1cm, 1cm, 1cm] .. [2cm, 2cm, 2cm] }}
template Round : Knob {{ param w : length   part disc : Cuboid(size = [w, 1cm, 1cm]) }}
template Door {{
  param pull : style Knob
  let w = 9cm
  part slab : Cuboid(size = [w, 20cm, 20cm])
  part knob : pull
  connect knob.back on slab.front
}}
category C {{
{BODY}  let w = 1.5cm
  style knobs : Knob = Round(w = w)
  part door : Door(pull = knobs)
  connect door.back on body.front
}}
""")
    parts = session.sampler.batch(np.arange(1), seed=0).parts()
    disc = parts.path.index("door.knob.disc")
    assert abs(parts.high[disc, 0] - parts.low[disc, 0] - 0.015) < 1e-12


def test_a_slot_and_a_joint_may_be_bound_in_a_repeat() -> None:
    program = lowered(ROWS).sampler.program
    (label,) = program.labels
    assert [program.parts[program.sites[t.site].part].path for t in label.targets] == ["drawers.row.leaf"]


def test_one_joint_follows_one() -> None:
    session = Session.of_text(HEAD + ROWS.replace("5cm #", "5cm  mimic drawers.motion #"))
    assert session.lowering is None
    (found,) = session.report.diagnostics
    assert found.code == "many-elements" and found.message.startswith("`drawers.motion` is a joint of every element")


def test_a_material_may_be_handed_in() -> None:
    template = "template Box {\n  param made : material\n  part case : Cuboid(size = [1cm, 1cm, 1cm])\n  material made on case\n}\n"
    use = "category C {{\n{0}  style look : material = oak | ash\n  part chest : Box({1})\n  connect chest.back on body.front\n}}\n"
    for given, materials in (("made = oak", {"oak"}), ("made = look", {"oak", "ash"})):
        program = lowered(template + use.format(BODY, given)).sampler.program
        assert set(program.materials) >= materials
        assert {name for site in program.sites for name, _ in site.materials} == materials
    default = template.replace("made : material", "made : material = ash")
    program = lowered(default + use.format(BODY, "")).sampler.program
    assert {name for site in program.sites for name, _ in site.materials} == {"ash"}


def test_what_the_checker_should_have_found_is_a_fault_of_the_compiler(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    file = tmp_path / "c.apg"
    file.write_text(f"{HEAD}category C {{\n{BODY}  let deep = body.size.x\n}}\n", encoding="utf-8")
    monkeypatch.setenv("APGC_CACHE", "off")  # what is kept would need no meaning
    monkeypatch.setattr(Evaluator, "meant", lambda self, meaning: None)
    assert main(["check", str(file)]) == 1
    told = capsys.readouterr().err
    assert re.match(r"error: [\w/]+\.apg:\d+:\d+: `\w+` has no value here\n", told)
    assert "a fault of apgc" in told and "Traceback" not in told
