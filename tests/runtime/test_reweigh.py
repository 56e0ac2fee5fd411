"""Priors: what a file says of draws is what is drawn, nothing else changes, and what does not fit is refused in words."""

from __future__ import annotations

import json
import math
from collections.abc import Mapping
from functools import cache
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from artipg_dsl.api import sample
from artipg_dsl.errors import SettingError, UserError
from artipg_dsl.graph.program import Program
from artipg_dsl.graph.reading import TextError, from_text
from artipg_dsl.graph.writing import digest, to_text
from artipg_dsl.run.prior import Prior, PriorFile, apply_prior, list_shipped, read_prior
from artipg_dsl.runtime.batch import Batch
from artipg_dsl.sampling.module import to_module
from artipg_dsl.sampling.sample import Sampler
from artipg_dsl.session import Session

from .test_prior import COUPLED, by_rejection, distance
from .test_prior import sampler as coupled

MANY = 4000
TEXT = """apg 1
use primitives { Cuboid, Cylinder }
role Knob { inherit size : length[3] in [1cm, 1cm, 1cm] .. [2cm, 2cm, 2cm] }
template Flat : Knob { param thick : length in 2mm .. 6mm = 4mm
  part plate : Cuboid(size = [thick, size.y, size.z])
  align plate.back = back
  align plate.center.y = center.y
  align plate.center.z = center.z }
template Block : Knob { param thick : length in 4mm .. 9mm = 5mm
  part body : Cuboid(size = [thick, size.y, size.z])
  align body.back = back
  align body.center.y = center.y
  align body.center.z = center.z }
category Thing {
  param width : length in 10cm .. 30cm = 20cm ~ normal(20cm, 5cm)
  param slope : angle in 10deg .. 80deg = 45deg
  param room : length in 1cm .. 9cm = 2cm ~ uniform(2cm, 6cm)
  param step : length in 1cm .. 5cm = 1cm ~ values(1cm, 2cm, 5cm)
  param tone : choice dark | light | red = dark ~ values(dark, light)
  count rows in 1 .. 6 = 2
  count pins in 1 .. 4 = 1 ~ values(1, 1, 2, 4)
  root part body : Cuboid(size = [width, width, 5cm])
  part knob : Knob = Flat weight 3 | Block | none
  part cap : Cylinder(radius = 2cm, height = 1cm) when width > 20cm | none weight 3
  connect knob.back on body.front at y = body.center.y, z = body.center.z
  connect cap.bottom on body.top
  repeat bar[i] in 0 ..< rows spread body along y {
    part stick : Cuboid(size = [2mm, 2mm, 2mm]) | none
    connect stick.bottom on body.top
  }
}
"""


@pytest.fixture(scope="module")
def program() -> Program:
    return Session.of_text(TEXT).sampler.program


def drawn(program: Program, draws: Mapping[str, Any], count: int = MANY) -> Batch:
    return Sampler(apply_prior(program, Prior(draws))).batch(np.arange(count), 3)


def values(batch: Batch, name: str) -> np.ndarray:
    number = next(k for k, d in enumerate(batch.program.draws) if name in (d.column.name, d.address))
    return batch.state.values[number]


def share(batch: Batch, name: str, option: str) -> tuple[float, int]:
    """How often an option is taken, and of how many rows."""
    draw = next(d for d in batch.program.draws if d.column.name == name)
    found = values(batch, name) == draw.options.index(option)
    return float(found.mean()), len(found)


def close(found: tuple[float, int], wanted: float) -> bool:
    """Within four standard deviations of the binomial law."""
    return abs(found[0] - wanted) <= 4.0 * math.sqrt(wanted * (1.0 - wanted) / found[1]) + 1e-12


# ---------------------------------------------------------------- what is drawn


@pytest.mark.parametrize("wanted", [0.23, "23%", 0, 1.0])
def test_presence(program: Program, wanted: Any) -> None:
    batch = drawn(program, {"knob": wanted})
    present = 0.23 if wanted == "23%" else float(wanted)
    assert close(share(batch, "knob", "none"), 1.0 - present)
    assert close(share(batch, "knob", "Flat"), 0.75 * present)  # among themselves as they were


@pytest.mark.parametrize(
    ("entry", "wanted"),
    [
        ({"Flat": 1, "none": 3}, {"Flat": 0.25, "Block": 0.0, "none": 0.75}),
        ({"Block": "60%"}, {"Flat": 0.3, "Block": 0.6, "none": 0.1}),
        ({"Flat|none": "20%"}, {"Flat": 0.15, "Block": 0.8, "none": 0.05}),
        ({"Flat": "50%", "Block": "50%"}, {"Flat": 0.5, "Block": 0.5, "none": 0.0}),
    ],
)
def test_weights_and_shares_of_options(program: Program, entry: Any, wanted: dict[str, float]) -> None:
    batch = drawn(program, {"knob": entry})
    for option, part in wanted.items():
        assert close(share(batch, "knob", option), part), option


def test_a_part_in_each_element(program: Program) -> None:
    assert close(share(drawn(program, {"bar.stick": 0.1}), "bar.stick", "none"), 0.9)


@pytest.mark.parametrize("wanted", [0.3, 1.0])
def test_a_condition_of_an_option_stays(program: Program, wanted: float) -> None:
    batch = drawn(program, {"cap": wanted})
    wide = values(batch, "width") > 0.2
    there = values(batch, "cap") == 0
    assert not there[~wide].any()
    assert close((float(there[wide].mean()), int(wide.sum())), wanted)


def test_weights_of_an_option_with_a_condition(program: Program) -> None:
    batch = drawn(program, {"cap": {"Cylinder": 9, "none": 1}})
    wide, there = values(batch, "width") > 0.2, values(batch, "cap") == 0
    assert not there[~wide].any()
    assert close((float(there[wide].mean()), int(wide.sum())), 0.9)


@pytest.mark.parametrize("entry", [{"1": 1, "3": 3}, {"1": "25%", "3": "75%"}, {"3": 3.0, "1": 1, "2": 0}])
def test_weights_of_counts(program: Program, entry: Any) -> None:
    rows = values(drawn(program, {"rows": entry}), "rows")
    assert set(rows.tolist()) == {1.0, 3.0}
    assert close((float((rows == 3).mean()), MANY), 0.75)


def test_a_range_of_counts(program: Program) -> None:
    rows = values(drawn(program, {"rows": "2 .. 3"}), "rows")
    assert set(rows.tolist()) == {2.0, 3.0}
    assert close((float((rows == 2).mean()), MANY), 0.5)


@pytest.mark.parametrize("entry", ["18cm..24cm", [0.18, 0.24], ["180mm", "0.24m"], " 18cm .. 24cm "])
def test_a_range_keeps_the_declared_distribution(program: Program, entry: Any) -> None:
    width = values(drawn(program, {"width": entry}), "width")
    assert width.min() >= 0.18 and width.max() <= 0.24
    usual = values(drawn(program, {}, 20 * MANY), "width")
    assert distance(width, usual[(usual >= 0.18) & (usual <= 0.24)]) < 0.04


@pytest.mark.parametrize(
    ("entry", "low", "high", "middle"),
    [
        ("~ uniform", 0.1, 0.3, 0.2),
        ("~ uniform(12cm, 14cm)", 0.12, 0.14, 0.13),
        ("12cm .. 30cm ~ normal(15cm, 5mm)", 0.12, 0.3, 0.15),
        ("~ lognormal(12cm, 5%)", 0.1, 0.3, 0.12),
        ("~ values(11cm, 13cm, 13cm)", 0.11, 0.13, 0.13),
        ({"11cm": 1, "130mm": 3}, 0.11, 0.13, 0.13),
    ],
)
def test_distributions(program: Program, entry: Any, low: float, high: float, middle: float) -> None:
    width = values(drawn(program, {"width": entry}), "width")
    assert low - 1e-12 <= width.min() and width.max() <= high + 1e-12
    assert abs(float(np.median(width)) - middle) < 0.006


def test_angles_have_their_units(program: Program) -> None:
    slope = values(drawn(program, {"slope": "20deg .. 30deg"}), "slope")
    assert math.radians(20) <= slope.min() and slope.max() <= math.radians(30)


def test_a_range_beyond_the_declared_distribution_is_cut(program: Program) -> None:
    """``uniform(2cm, 6cm)`` is never below 2 cm, and no other distribution makes it so."""
    for entry in ("1cm .. 3cm", "~ normal(2cm, 1cm)", "1cm .. 3cm ~ normal(1cm, 1cm)"):
        assert values(drawn(program, {"room": entry}), "room").min() >= 0.02
    with pytest.raises(SettingError, match="beside its distribution"):
        apply_prior(program, Prior({"room": {"1cm": 1}}))


def test_values_that_it_is_drawn_from(program: Program) -> None:
    step = values(drawn(program, {"step": {"2cm": 1, "5cm": 4}}), "step")
    assert set(np.round(step, 9).tolist()) == {0.02, 0.05}
    assert close((float((step > 0.03).mean()), MANY), 0.8)
    pins = values(drawn(program, {"pins": {"1": 1, "4": 1}}), "pins")
    assert set(pins.tolist()) == {1.0, 4.0}


def test_one_alternative_by_its_address(program: Program) -> None:
    batch = drawn(program, {"knob=Block/knob.thick": [0.008, 0.009]})
    assert values(batch, "knob=Block/knob.thick").min() >= 0.008
    assert values(batch, "knob=Flat/knob.thick").max() < 0.006 + 1e-12
    both = drawn(program, {"knob.thick": "4mm .. 5mm"})
    for address in ("knob=Block/knob.thick", "knob=Flat/knob.thick"):
        assert 0.004 <= values(both, address).min() and values(both, address).max() <= 0.005


# ---------------------------------------------------------------- nothing else changes


def test_other_draws_stay_as_they_are(program: Program) -> None:
    """Randomness is addressed: objects differ in what the prior speaks of alone."""
    plain, other = drawn(program, {}, 200), drawn(program, {"knob": 0.1}, 200)
    for name in ("width", "rows", "tone", "cap"):
        assert np.array_equal(values(plain, name), values(other, name)), name
    assert not np.array_equal(values(plain, "knob"), values(other, "knob"))


def test_the_program_is_another_one_and_can_be_read_again(program: Program) -> None:
    draws = {"knob": 0.1, "rows": {"1": 1, "3": 3}, "cap": "40%", "width": "18cm .. 24cm ~ normal(20cm, 1cm)"}
    made = apply_prior(program, Prior(draws))
    again = from_text(to_text(made))
    assert made.hash == program.hash  # what is bound to the program fits its objects by any prior
    assert digest(made) == again.hash == digest(apply_prior(program, Prior(draws))) != program.hash
    one, two = (Sampler(p).batch(np.arange(300), 5) for p in (made, again))
    for first, second in zip(one.state.values, two.state.values, strict=True):
        assert np.array_equal(one.state.values[first], two.state.values[second])


def test_a_weighted_law_in_a_text_is_checked(program: Program) -> None:
    text = to_text(apply_prior(program, Prior({"rows": {"1": 1, "3": 3}})))
    assert 'distribution "weighted"' in text
    line = next(line for line in text.split("\n") if "weighted" in line)
    arguments = line[line.index("arguments [") + 11 :].split("]")[0]
    with pytest.raises(TextError, match="as many weights as values"):
        from_text(text.replace(f"[{arguments}]", f"[{arguments.rsplit(' ', 1)[0]}]"))


def test_an_exported_module_draws_the_same(program: Program) -> None:
    made = Sampler(apply_prior(program, Prior({"rows": {"1": 1, "3": 3}, "knob": 0.2})))
    space: dict[str, Any] = {}
    exec(compile(to_module(made.program, "0"), "<module>", "exec"), space)
    state, _, _ = space["evaluate_valid"](range(50), 3)
    batch = made.batch(np.arange(50), 3)
    for number, value in batch.state.values.items():
        assert np.array_equal(state.values[number], value)


def test_in_any_batch(program: Program) -> None:
    made = Sampler(apply_prior(program, Prior({"rows": {"1": 1, "3": 3}, "knob": 0.2, "cap": 0.5})))
    whole = made.batch(np.arange(64), 9)
    for start in (0, 17, 40):
        part = made.batch(np.arange(start, start + 20), 9)
        for name in ("rows", "knob", "cap", "width"):
            assert np.array_equal(values(whole, name)[start : start + 20], values(part, name))


# ---------------------------------------------------------------- weights of objects

NARROWED = {
    "a": "1cm .. 6cm",
    "b": "~ normal(6cm, 1cm)",
    "n": {"1": 1, "2": 1, "5": 2},
    "d": {"2cm": 1, "4cm": 4, "8cm": 1},
    "kind": {"small": 1, "large": 4},
}


def rejected(count: int) -> dict[str, np.ndarray]:
    """The distributions of ``NARROWED``, restricted to what is valid, drawn independently with NumPy alone."""
    rng = np.random.default_rng(1)
    a, b, c = rng.uniform(0.01, 0.06, count), rng.normal(0.06, 0.01, count), 0.04 * np.exp(0.5 * rng.normal(size=count))
    d = rng.choice([0.02, 0.04, 0.08], count, p=[1 / 6, 4 / 6, 1 / 6])
    n, kind = rng.choice([1, 2, 5], count, p=[0.25, 0.25, 0.5]), rng.choice(2, count, p=[0.2, 0.8])
    ok = (b >= 0.01) & (b <= 0.1) & (c >= 0.01) & (c <= 0.1)
    ok &= (a + b <= 0.09) & (n * a <= 0.2) & (c <= 2 * a) & (d <= a + b) & ((kind == 0) | (n * c >= 0.06))
    return {name: value[ok] for name, value in zip("a b c d n kind".split(), (a, b, c, d, n, kind), strict=True)}


def test_objects_are_weighed_by_the_prior() -> None:
    """The weights of objects lead from what is drawn to the distributions of the prior, not to those declared."""
    batch = Sampler(apply_prior(coupled(COUPLED).program, Prior(NARROWED))).batch(np.arange(20_000), 1)
    weight = np.exp(batch.log_weight)
    wanted, declared = rejected(2_000_000), by_rejection(400_000)
    for name in "a b c d n kind".split():
        assert distance(values(batch, name), wanted[name], weight) < 0.02, name
    assert distance(values(batch, "a"), declared["a"], weight) > 0.1


# ---------------------------------------------------------------- what does not fit


@pytest.mark.parametrize(
    ("draws", "words"),
    [
        ({"knbo": 0.3}, "Thing draws no `knbo`.*did you mean `knob`"),
        ({"knob": 1.3}, "`knob` is 1.3: how often it is there is needed"),
        ({"knob": "130%"}, "130% is no share"),
        ({"knob": True}, "`knob` is true"),
        ({"knob": {"Flta": 3}}, "`knob` cannot be `Flta`.*did you mean `Flat`"),
        ({"knob": {"Flat": -1}}, "-1 is no weight"),
        ({"knob": {"Flat": 1e300}}, "1e.300 is no weight"),
        ({"knob": {"Flat": float("nan")}}, "nan is no weight"),
        ({"knob": {"Flat": [1]}}, "a list is no weight"),
        ({"rows": {"two": 1}}, "`rows` cannot be `two`: a number is needed"),
        ({"knob": {"Flat": 0}}, "no option is left that has a weight"),
        ({"knob": {}}, "no option is left that has a weight"),
        ({"knob": {"Flat": 3, "none": "20%"}}, "'20%' is no weight.*all are weights"),
        ({"knob": {"Flat": "70%", "none": "60%"}}, "the shares add up to 130%"),
        ({"knob": {"Flat|Block|none": "70%"}}, "the shares add up to 70%"),
        ({"knob": {"Flat|Block": 2}}, r"`Flat\|Block` are several options"),
        ({"knob": {"Flat|Flat": "20%"}}, "`Flat` is there twice"),
        ({"tone": 0.3}, "`tone` is 0.3, but it is one of dark, light, red in every object"),
        ({"tone": {"red": 1}}, "`red` is never drawn: its weight is 0 in the program"),
        ({"tone": {"red": "10%"}}, "`red` is never drawn"),
        ({"width": [0.05, 0.2]}, "`width` cannot be 0.05m: it lies in 10cm .. 30cm"),
        ({"width": "5cm .. 12cm"}, "`width` cannot be 5cm"),
        ({"width": "25cm .. 12cm"}, "the range 25cm .. 12cm is empty"),
        ({"width": "25 .. 28cm"}, "no unit"),
        ({"width": "25cm"}, "a range or a distribution is needed"),
        ({"width": 0.2}, "`width` is 0.2: a range, a distribution or weights of values are needed"),
        ({"width": [0.2, None]}, "nothing is no end of a range"),
        ({"width": [float("nan"), 0.2]}, "cannot be nan"),
        ({"width": [0.1, 10**309]}, "`width`: the number is too large"),
        ({"knob": 10**309}, "how often it is there is needed"),
        ({"width": "~ nromal(20cm, 1cm)"}, "no distribution `nromal`.*did you mean `normal`"),
        ({"width": "~ normal(20cm)"}, "normal: 1 is given"),
        ({"width": "~ normal(20cm, 0cm)"}, "0cm in normal must be above 0"),
        ({"width": "~ normal(20cm, 1deg)"}, "wrong unit"),
        ({"width": {}}, "no value is left that has a weight"),
        ({"rows": {"1.5": 1}}, "not a whole number"),
        ({"rows": {"9": 1}}, "`rows` cannot be 9: it lies in 1 .. 6"),
        ({"rows": {"1": "30%", "2": "30%"}}, "add up to 60%"),
        ({"rows": {"1": 1, "1.0": 2}}, "1.0 is there twice"),
        ({"rows": {"1": 0}}, "no value is left that has a weight"),
        ({"pins": {"3": 1}}, "3 is not one of the values it is drawn from"),
        ({"pins": "~ uniform"}, "it is drawn from single values"),
        ({"step": "3cm .. 4cm"}, "none of its values lies in this range"),
        ({"room": "7cm .. 8cm"}, "this range lies beside its distribution"),
        ({"knob.thick": "2mm .. 5mm"}, "cannot be 2mm.*name those that are meant: `knob=Flat/knob.thick`"),
        ({"knob.thick": "4mm .. 5mm", "knob=Flat/knob.thick": "4mm .. 5mm"}, "which is there already"),
    ],
    ids=str,
)
def test_what_does_not_fit_is_refused(program: Program, draws: Any, words: str) -> None:
    with pytest.raises(SettingError, match="^the prior: .*" + words):
        apply_prior(program, Prior(draws))


def test_ranges_that_leave_no_object_are_refused() -> None:
    text = TEXT.replace("count rows", "require width <= 5 * room\n  count rows")
    program = Session.of_text(text).sampler.program
    with pytest.raises(SettingError, match=r"no Thing is left under `width <= 5 \* room`"):
        apply_prior(program, Prior({"room": "2cm .. 3cm", "width": "16cm .. 20cm"}))


# ---------------------------------------------------------------- files


def written(folder: Path, text: str) -> Path:
    path = folder / "own.json"
    path.write_text(text, encoding="utf-8")
    return path


def test_a_file_tells_where_it_is_wrong(program: Program, tmp_path: Path) -> None:
    path = written(tmp_path, '{"about": "draws",\n "draws": {\n  "Thing": {\n    "rows": {"1": 1},\n    "knbo": 0.3}}}')
    found = read_prior(str(path))
    assert isinstance(found, PriorFile)
    with pytest.raises(SettingError, match=rf"^{path}:5:5: Thing draws no `knbo`"):
        apply_prior(program, found.of("Thing"))
    with pytest.raises(UserError, match="says nothing of Thign: it speaks of Thing.*did you mean `Thing`"):
        found.of("Thign")


@pytest.mark.parametrize(
    ("text", "words"),
    [
        ('{"draws": {"Thing": {"knob": }}}', r"own.json:1:30: it is not JSON"),
        ('{"draws": {"Thing": {"knob": 0.1, "knob": 0.2}}}', "`knob` is given twice in one object"),
        ('{"Thing": {"knob": 0.1}}', "nothing where an object is expected"),
        ('{"draws": {}, "darws": {}}', "did you mean `draws`"),
        ('{"draws": {"Thing": 0.1}}', "draws.Thing: 0.1 where an object is expected"),
        ("[]", "an empty list where an object is expected"),
        ("[" * 100_000, "cannot be read"),
    ],
)
def test_files_that_are_none(tmp_path: Path, text: str, words: str) -> None:
    with pytest.raises(UserError, match=words):
        read_prior(written(tmp_path, text))


def test_a_prior_that_is_not_there(tmp_path: Path) -> None:
    with pytest.raises(UserError, match="there is no prior partnot"):
        read_prior("partnot")
    with pytest.raises(UserError, match="cannot be read"):
        read_prior(tmp_path)
    (tmp_path / "binary").write_bytes(b"\xff\xfe\x00\xff")
    with pytest.raises(UserError, match="it is not text"):
        read_prior(tmp_path / "binary")
    with pytest.raises(UserError, match="cannot be read: embedded null byte"):
        read_prior("par\0tnet")


def test_python_gives_the_draws_of_a_category_or_a_file() -> None:
    assert read_prior({"knob": np.float64(0.5), "width": (0.1, 0.2)}) == Prior({"knob": 0.5, "width": [0.1, 0.2]})
    found = read_prior({"draws": {"Thing": {"knob": 0.5}}})
    assert found.of("Thing") == Prior({"knob": 0.5})
    assert json.dumps(dict(found.of("Thing").draws)) == '{"knob": 0.5}'


def test_shipped_priors_fit_their_categories() -> None:
    assert "partnet" in list_shipped()
    for name in list_shipped():
        found = read_prior(name)
        assert isinstance(found, PriorFile)
        for category, draws in found.categories.items():
            apply_prior(Session.of(category).sampler.program, found.of(category))
            assert set(json.loads(found.text)["evidence"][category]) == set(draws)


OBJECTS = 120


@cache
def as_in_the_data_set(category: str) -> list[dict[str, Any]]:
    """What is said of objects that have passed every check."""
    found: list[dict[str, Any]] = sample(category, OBJECTS, prior="partnet").annotations()
    return found


@pytest.mark.parametrize(
    ("category", "words", "wanted"),
    [
        ("Door", {"hinge"}, 0.24),
        ("Microwave", {"tray"}, 0.23),
        ("StorageFurniture", {"foot", "castor"}, 0.52),
        ("StorageFurniture", {"frame"}, 0.72),
        ("StorageFurniture", {"drawer"}, 0.24),
        ("Window", {"handle"}, 0.16),
    ],
)
@pytest.mark.slow
def test_parts_are_as_frequent_as_in_real_objects(category: str, words: set[str], wanted: float) -> None:
    there = [any(part["semantic"] in words for part in each["parts"]) for each in as_in_the_data_set(category)]
    assert close((sum(there) / OBJECTS, OBJECTS), wanted)


@pytest.mark.parametrize(("category", "least"), [("StorageFurniture", 0.9), ("Table", 0.9), ("Bucket", 1.0)])
@pytest.mark.some
def test_nearly_all_have_something_that_moves_as_all_of_the_data_set_have(category: str, least: float) -> None:
    found = as_in_the_data_set(category)
    assert sum(any(joint["type"] != "fixed" for joint in each["joints"]) for each in found) >= least * OBJECTS
