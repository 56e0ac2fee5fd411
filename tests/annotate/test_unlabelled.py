"""Class 0 is surface that no semantic label speaks of; `check` warns of it, and no shipped category has any."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from artipg_dsl.annotate.annotation import annotate
from artipg_dsl.annotate.cloud import sample_points
from artipg_dsl.diagnostics import Diagnostic
from artipg_dsl.export.partnet.mobility import partnet_files
from artipg_dsl.export.usd import usd_files
from artipg_dsl.robot.robots import Robots
from artipg_dsl.session import Session
from artipg_dsl.source import Source

TEXT = """apg 1
use primitives   { Cuboid, Cylinder }
use materials    { oak }
use vocabularies { semantic }
template Tap {
  part stem : Cylinder(radius = 1cm, height = 3cm)
  part knob : Cylinder(radius = 2cm, height = 3cm)
  connect knob.bottom on stem.top
  label semantic.knob on knob
}
category Block {
  root part body : Cuboid(size = [20cm, 20cm, 4cm])
  param kind : choice plain | carved | gilt
  param depth : length in 1cm .. 4cm
  part tap : Tap
  connect tap.bottom on body.top
  label semantic.base on body
  material oak on body, tap
  SAY
}
"""


def session(said: str) -> Session:
    return Session(Source("block.apg", TEXT.replace("SAY", said)), None)


def warned(said: str) -> list[Diagnostic]:
    made = session(said)
    made.advise()
    return [d for d in made.report.diagnostics if d.code == "missing-label"]


def test_class_0_says_that_nothing_is_said() -> None:
    batch = session("").sampler.batch(np.arange(3), seed=1)
    words = batch.program.vocabularies["semantic"]
    assert words[:2] == ("unlabelled", "body")
    points = sample_points(batch, 256)
    paths = np.array([site.path for site in batch.program.sites])[points.primitive]
    meant = np.select([paths == "body", paths == "tap.knob"], [words.index("base"), words.index("knob")], 0)
    assert np.array_equal(points.semantic, meant) and (points.semantic == 0).any()
    told = {part["path"]: part["semantic"] for part in annotate(batch)[0]["parts"]}
    assert told == {"body": "base", "tap": None, "tap.stem": None, "tap.knob": "knob"}


def test_files_name_no_class_where_there_is_none() -> None:
    robots = Robots(session("").sampler.batch(np.arange(1), seed=1))
    text = usd_files(robots, 0)["object.usda"].decode()
    assert text.count('semantics:labels:class = ["base"]') == 2 and text.count('["knob"]') == 1  # link and mesh
    assert "unlabelled" not in text and text.count("semantics:labels:class") == 3
    assert b'"stem"' in partnet_files(robots, 0)["result.json"]


def test_the_check_names_the_part_and_its_primitives() -> None:
    (found,) = warned("")
    assert found.severity == "warning" and found.message == "`tap.stem` has no semantic label"
    assert found.span is not None and found.span.source.position(found.span.start) == (15, 8)
    (found,) = warned("label semantic.switch on tap.stem.side")
    assert found.message == "`tap.stem` (top, bottom) has no semantic label"


@pytest.mark.parametrize(
    ("said", "covers"),
    [
        ("label semantic.switch on tap", True),
        ("label semantic.switch on tap.stem.side, tap.stem.top, tap.stem.bottom", True),
        ("when kind == plain { label semantic.switch on tap } else { label semantic.lid on tap }", True),
        ("when kind == plain { label semantic.switch on tap }", False),
        ("label semantic.switch on tap where p.z > 0\n  label semantic.lid on tap where not (p.z > 0)", True),
        ("label semantic.switch on tap where p.z > 0\n  label semantic.lid on tap where p.z < -5mm", False),
        ("label semantic.switch on tap where depth < 2cm\n  label semantic.lid on tap where depth >= 2cm", True),
        (
            "when kind == plain or kind == gilt { label semantic.switch on tap }\n  when kind == carved { label semantic.lid on tap }",
            True,
        ),
        (
            "when kind == plain or kind == gilt { label semantic.switch on tap }\n  when kind == gilt { label semantic.lid on tap }",
            False,
        ),
        (
            "part lid : Cuboid(size = [5cm, 5cm, 1cm]) | none\n  connect lid.top on body.bottom\n  label semantic.lid on lid, tap",
            True,
        ),
        (
            "when kind == plain {\n  part lid : Cuboid(size = [5cm, 5cm, 1cm])\n  connect lid.top on body.bottom\n"
            "  label semantic.lid on lid }\n  label semantic.switch on tap",
            True,
        ),
    ],
)
def test_conditions_that_leave_nothing_out_cover(said: str, covers: bool) -> None:
    found = warned(said)
    assert (
        not found
        if covers
        else [d.message for d in found]
        == ["`tap.stem` has a semantic label only under conditions, which need not hold"]
    )
    batch = session(said).sampler.batch(np.arange(40), seed=2)
    assert (sample_points(batch, 128).semantic > 0).all() == covers, "the points say the same"


def test_one_warning_where_nothing_is_labelled() -> None:
    text = "apg 1\nuse primitives { Cuboid }\ncategory Block { root part body : Cuboid(size = [1cm, 1cm, 1cm]) }\n"
    made = Session(Source("block.apg", text), None)
    made.advise()
    assert "no part of `Block` has a semantic label" in [d.message for d in made.report.diagnostics]
    batch = made.sampler.batch(np.arange(2), seed=0)
    assert batch.program.vocabularies["semantic"] == ("unlabelled",)
    assert (sample_points(batch, 16).semantic == 0).all()


def test_the_word_is_reserved(tmp_path: Path) -> None:
    made = Session(Source("a.apg", "apg 1\nvocabulary semantic { body unlabelled }\n"), None)
    _ = made.lowering
    assert [(d.code, d.span and made.source.text[d.span.start : d.span.end]) for d in made.report.diagnostics] == [
        ("reserved-name", "unlabelled")
    ]
