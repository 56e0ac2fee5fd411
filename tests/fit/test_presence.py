"""What labels of real objects say of draws: presence and counts, with how many objects each rests on, and what no draw is found for."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import artipg_dsl as apg
from artipg_dsl.errors import UserError
from artipg_dsl.fit.presence import Presence, measure_presence
from artipg_dsl.run.prior import Prior, apply_prior
from artipg_dsl.runtime.batch import Batch
from artipg_dsl.sampling.sample import Sampler
from artipg_dsl.session import Session
from tests.cli.helpers import CHEST, Apgc

TEXT = """apg 1
use primitives { Cuboid, Cylinder }
vocabulary semantic { base top knob lid foot wheel plate tag rim ghost }
category Thing {
  param width : length in 20cm .. 30cm = 25cm
  count pins in 1 .. 4 = 2
  root part body : Cuboid(size = [width, width, 5cm])
  part cap : Cylinder(radius = 2cm, height = 1cm) | none
  connect cap.bottom on body.top
  part stand : Cuboid(size = [3cm, 3cm, 3cm]) | Cylinder(radius = 2cm, height = 3cm) weight 2 | none
  connect stand.top on body.bottom
  repeat pin[i] in 0 ..< pins spread body along y {
    part nail : Cuboid(size = [2mm, 2mm, 2mm])
    connect nail.bottom on body.top
    part flag : Cuboid(size = [1mm, 1mm, 1mm]) | none
    connect flag.bottom on nail.top
    label semantic.knob on nail
    label semantic.tag on flag
  }
  label semantic.base on body
  label semantic.lid on cap
  when stand is Cuboid { label semantic.foot on stand } else when stand is Cylinder { label semantic.wheel on stand }
}
"""
WORDS = {"their_base": "base", "their_lid": "lid"}


@pytest.fixture(scope="module")
def batch() -> Batch:
    return Sampler(Session.of_text(TEXT).sampler.program).batch(np.arange(60), 2)


def measured(batch: Batch, words: dict[str, str], *objects: str) -> Presence:
    found = measure_presence(batch, [frozenset(names.split()) for names in objects], words)
    apply_prior(batch.program, Prior(found.draws))  # it is always one that fits
    return found


def test_a_part_that_may_be_none(batch: Batch) -> None:
    found = measured(batch, WORDS, *["their_base"] * 6, *["their_base their_lid"] * 3, "other names")
    assert found.draws == {"cap": 0.35}  # (3 + 1/2) / (9 + 1)
    assert found.evidence == {"cap": {"objects": 9, "with": {"lid": 3}}}
    assert found.unmatched == []


def test_none_and_all_rule_nothing_out(batch: Batch) -> None:
    assert measured(batch, WORDS, "their_base").draws == {"cap": 0.25}
    assert measured(batch, WORDS, "their_base their_lid").draws == {"cap": 0.75}


def test_options_of_one_choice_have_words_of_their_own(batch: Batch) -> None:
    words = {"b": "base", "f": "foot", "w": "wheel"}
    found = measured(batch, words, "b f", "b f", "b w", "b", "b", "b", "b", "b", "b")
    assert found.draws == {"stand": {"Cuboid": "25%", "Cylinder": "15%"}}
    assert found.evidence["stand"] == {"objects": 9, "with": {"foot": 2, "wheel": 1}}


def test_shares_that_exceed_one_are_told(batch: Batch) -> None:
    found = measured(batch, {"b": "base", "f": "foot", "w": "wheel"}, *["b f w"] * 9)
    assert found.draws == {"stand": {"Cuboid": "95%"}}
    assert found.unmatched == ["`wheel` is in 9 of 9 objects: what is left of `stand` follows from other words"]


def test_counts_where_each_has_its_name(batch: Batch) -> None:
    words = {"b": "base", "k1": "knob", "k2": "knob", "k3": "knob", "k4": "knob", "k5": "knob"}
    found = measured(batch, words, "b k1", "b k1 k3", "b k2 k3", "b k1 k2 k3 k4 k5", "b")
    assert found.draws == {"pins": {"1": 1.5, "2": 2.5, "3": 0.5, "4": 0.5}}
    assert found.evidence["pins"] == {"objects": 4, "counted": {"1": 1, "2": 2}, "word": "knob"}
    assert found.unmatched == [
        "`knob` is in 4 of 5 objects, and in every sample: no draw leaves it out",
        "1 of 4 objects have 5 of `knob`: `pins` lies in 1 .. 4",
    ]


def test_classes_alone_tell_no_counts(batch: Batch) -> None:
    assert measured(batch, {"b": "base", "k": "knob"}, "b k", "b k").draws == {}


def test_what_no_draw_is_found_for_is_told(batch: Batch) -> None:
    words = {"b": "base", "t1": "tag", "t2": "tag", "g": "ghost"}
    found = measured(batch, words, "b t1 t2", "b g")
    assert found.draws == {}
    assert found.unmatched == [
        "`tag` is in 1 of 2 objects: it is there by `pin.flag`, of which an object has several",
        "no count of the program is the number of `tag`",
        "`ghost` is in no sample, and in 1 of 2 objects",
    ]


def test_labels_that_tell_nothing_are_refused(batch: Batch) -> None:
    with pytest.raises(UserError, match="no real object has a label that the map names"):
        measure_presence(batch, [frozenset({"else"}), frozenset()], WORDS)
    with pytest.raises(UserError, match="objects without it look like objects without labels"):
        measure_presence(batch, [frozenset({"their_lid"})], {"their_lid": "lid"})


# ---------------------------------------------------------------- the command


@pytest.fixture
def apgc(capsys: pytest.CaptureFixture[str]) -> Apgc:
    return Apgc(capsys)


@pytest.fixture(scope="module")
def real(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Chests whose knobs have names of their own."""
    folder = tmp_path_factory.mktemp("real")
    samples = apg.sample(CHEST, numbers=range(20, 26), seed=8)
    points, names = samples.points(3000), samples.batch.program.vocabularies["semantic"]
    for k in range(len(samples)):
        kind, each = points.semantic[k], points.instance[k]
        knob = kind == names.index("handle")
        order = np.unique(each[knob])
        label = np.where(knob, 2 + np.searchsorted(order, each), (kind == names.index("door")).astype(int))
        known = ["trunk", "cover", *(f"knob{i}" for i in range(len(order)))]
        np.savez(folder / f"chest{k}.npz", points=points.position[k], label=label, label_names=known)
    words = {"trunk": "body", "cover": "door", **{f"knob{i}": "handle" for i in range(4)}}
    (folder / "map.json").write_text(json.dumps(words))
    return folder


def test_a_prior_is_written_and_can_be_sampled_by(apgc: Apgc, real: Path, tmp_path: Path) -> None:
    out = tmp_path / "own.json"
    asked: tuple[Any, ...] = ("compare", CHEST, real, "-n", 12, "--front=x", "--map", real / "map.json")
    code, _, err = apgc(*asked, "--prior-out", out)
    assert code == 0 and f"{out}: 1 draw from 6 labelled objects" in err
    held = json.loads(out.read_text())
    knobs = apg.sample(CHEST, numbers=range(20, 26), seed=8)["knobs"]
    assert held["draws"]["Chest"]["knobs"] == {str(c): (knobs == c).sum() + 0.5 for c in (1, 2, 3)}
    assert held["evidence"]["Chest"]["knobs"]["objects"] == 6
    assert apgc("sample", CHEST, "-n", 2, "--points", 8, "--prior", out, "-o", tmp_path / "o")[0] == 0
    before = out.read_bytes()
    code, _, err = apgc(*asked, "--prior-out", out)
    assert code == 1 and "exists" in err
    assert apgc(*asked, "--prior-out", out, "--force")[0] == 0 and out.read_bytes() == before


@pytest.mark.parametrize(
    ("more", "words"),
    [
        (["--prior-out", "own.json"], "add --map FILE"),
        (["--prior-out", "-"], "name it"),
        (["--force"], "--force replaces the file of --prior-out"),
    ],
)
def test_what_is_refused_early(apgc: Apgc, real: Path, more: list[str], words: str) -> None:
    code, _, err = apgc("compare", CHEST, real, "-n", 4, *more)
    assert code == 2 and words in err


def test_a_map_of_labels_that_nothing_has_is_told_of(apgc: Apgc, real: Path, tmp_path: Path) -> None:
    (tmp_path / "map.json").write_text('{"Trunk": "body"}')
    asked = ("compare", CHEST, real / "chest0.npz", "-n", 4, "--front=x", "--map")
    code, _, err = apgc(*asked, tmp_path / "map.json")
    assert code == 0 and f"as {tmp_path / 'map.json'} says: their labels are" in err
    assert "no real object" not in apgc(*asked, real / "map.json")[2]
