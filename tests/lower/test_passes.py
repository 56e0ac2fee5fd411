"""The passes of the lowering: each reads what earlier ones give, changes what it says it changes, and leaves a program."""

from __future__ import annotations

from dataclasses import fields

import pytest

from artipg_dsl.graph.program import Draw, Program
from artipg_dsl.graph.reading import from_text
from artipg_dsl.graph.writing import to_text
from artipg_dsl.lower import program as lowering
from artipg_dsl.lower.program import STAGES, Lowering, Pass
from artipg_dsl.session import Session

PASSES = [step for stage in STAGES for step in stage]
EVERYTHING = """apg 1
use primitives { Cuboid }
use materials { oak, steel }
use vocabularies { semantic }

role Lid { inherit size : length[3] in [1cm, 1cm, 1cm] .. [50cm, 50cm, 5cm]   slot leaf   joint motion }
template Flat : Lid {
  part leaf : Cuboid(size = size)
  joint motion : revolute base -> leaf about leaf.back.bottom range 0deg .. 90deg
}
template Thick : Lid {
  part leaf : Cuboid(size = [size.x, size.y, size.z])
  joint motion : revolute base -> leaf about leaf.back.bottom range 0deg .. 60deg
}
category Chest {
  param width : length in 40cm .. 60cm = 50cm
  param depth : length in 20cm .. 40cm = 30cm
  root part body : Cuboid(size = [depth, width, 20cm])
  part lid : Lid(size = [depth, width, 2cm]) = Flat | Thick
  connect lid.bottom on body.top gap 1mm at center
  limit lid.motion 0deg .. 50deg
  repeat foot[k] in 0 ..< 2 spread body along y {
    part peg : Cuboid(size = [2cm, 2cm, 2cm])
    connect peg.top on body.bottom
    align peg.center.x = body.center.x
    align peg.center.y = foot.center.y near peg.center.y = 0
  }
  joint turn : continuous body.left -> knob.bottom at center gap 1mm
  part knob : Cuboid(size = [1cm, 1cm, 1cm])
  joint other : continuous body.right -> dial.bottom at center gap 1mm mimic 2 * turn
  part dial : Cuboid(size = [1cm, 1cm, 1cm])
  require width >= depth else "it is deeper than wide"
  prefer width >= 1.2 * depth
  require stable
  free knob, body
  clear dial from lid by 1mm
  label semantic.lid on lid
  label semantic.body on body
  grasp hold on lid.leaf { at [0, 0, 0]  approach -z  close y  opening 2cm }
  keypoint corner on lid.leaf
  material oak on body, lid, foot
  material steel on knob, dial
}
"""


def snapshot(program: Program) -> dict[str, object]:
    """What each field of a program holds: records are never changed in place, but for the ranges of draws."""

    def held(value: object) -> object:
        if isinstance(value, Draw):
            return id(value), len(value.bounds), len(value.unions), len(value.limits)
        if isinstance(value, dict):
            return tuple((key, held(item)) for key, item in value.items())
        return tuple(map(held, value)) if isinstance(value, list) else value if isinstance(value, str) else id(value)

    return {field.name: held(getattr(program, field.name)) for field in fields(program)}


def watched(text: str, monkeypatch: pytest.MonkeyPatch) -> list[tuple[Pass, set[str]]]:
    """Each pass over a program, and the fields that it changed; the program is verified behind each."""
    found: list[tuple[Pass, set[str]]] = []
    kept: list[object] = []  # so that no address is used twice
    before = snapshot(Program("before"))

    def watch(step: Pass, done: Lowering) -> None:
        nonlocal before
        program = done.program
        kept.append(
            [list(getattr(program, f.name)) for f in fields(program) if isinstance(getattr(program, f.name), list)]
        )
        after = snapshot(program)
        found.append((step, {name for name, value in after.items() if value != before[name]}))
        before = after
        from_text(to_text(program))

    monkeypatch.setattr(lowering, "WATCHERS", [watch])
    session = Session.of_text(text) if "\n" in text else Session.of(text)
    assert session.lowering is not None, session.report.diagnostics
    return found


@pytest.mark.some
@pytest.mark.parametrize("text", [EVERYTHING, "Microwave"], ids=["everything", "microwave"])
def test_a_pass_changes_what_it_gives(text: str, monkeypatch: pytest.MonkeyPatch) -> None:
    steps = watched(text, monkeypatch)
    assert [step for step, _ in steps] == PASSES
    for step, changed in steps:
        assert changed - {"name", "doc"} <= set(step.gives.split()), step.name


def test_every_pass_gives_something(monkeypatch: pytest.MonkeyPatch) -> None:
    """What a pass says that it gives is no guess: over this program it does most of it."""
    given = {name for _, changed in watched(EVERYTHING, monkeypatch) for name in changed}
    assert given >= {name for step in PASSES for name in step.gives.split()} - {"closures"}


def test_what_a_pass_needs_is_there() -> None:
    there = {"scopes"}
    for step in PASSES:
        assert set(step.needs.split()) <= there, step.name
        there |= set(step.gives.split())
    assert there == {field.name for field in fields(Program)} - {"name", "doc", "foreign"}


def test_every_pass_is_explained() -> None:
    assert all(step.run.__doc__ for step in PASSES)
