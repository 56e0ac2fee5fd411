"""Repair: what is in error is found and moved least, logged with its line, and the same in any batch."""

import re

import numpy as np
import pytest

from artipg_dsl.errors import NoObject, UserError
from artipg_dsl.graph.reading import from_text
from artipg_dsl.graph.writing import to_text
from artipg_dsl.run.job import prepare
from artipg_dsl.run.params import read_values
from artipg_dsl.run.request import Request
from artipg_dsl.runtime.kernels import Kept, State
from artipg_dsl.sampling.clips import Asked
from artipg_dsl.sampling.known import evaluate_again, make_batch, rows_of_draw
from artipg_dsl.sampling.mutate import mutate
from artipg_dsl.sampling.repair import repair
from artipg_dsl.sampling.sample import Sampler
from artipg_dsl.sampling.statistics import Statistics
from artipg_dsl.sampling.trace import Replay, read_traces, trace_lines
from artipg_dsl.sampling.values import Values
from artipg_dsl.session import Session
from artipg_dsl.validity.faults import find_faults

HEAD = "apg 1\nuse primitives { Cuboid }\ncategory Box {\n"
BODY = "  root part body : Cuboid(size = [10cm, 10cm, 10cm])\n"


def sampler_of(*lines: str) -> Sampler:
    return Session.of_text(HEAD + "".join(f"  {line}\n" for line in lines) + BODY + "}\n", "box.apg").sampler


def given(sampler: Sampler, *records: dict) -> Values:
    return read_values(records, sampler.program, "values")


def put_right(sampler: Sampler, *records: dict, statistics: Statistics | None = None):
    statistics = statistics if statistics is not None else Statistics()
    return given(sampler, *records).batch(sampler, np.arange(len(records)), 0, statistics, True)


def log(batch) -> list[dict]:
    return batch.repairs.plain(batch.program)


LENGTHS = [f"param {name} : length in 1cm .. 10cm" for name in "abc"]


def test_a_value_out_of_its_domain_is_clipped_and_told_with_its_line() -> None:
    statistics = Statistics()
    batch = put_right(sampler_of(*LENGTHS), {"a": 5.0, "b": "3cm", "c": -1.0}, statistics=statistics)
    assert batch.drawn(0) == {"a": 0.1, "b": 0.03, "c": 0.01}
    first, second = log(batch)
    assert first == {
        "path": "a",
        "from": 5.0,
        "to": 0.1,
        "how": "clipped",
        "because": "`a` lies outside its range",
        "where": "box.apg:4:3",
    }
    assert second["path"] == "c" and second["where"] == "box.apg:6:3"
    assert statistics.repaired == statistics.failures() == {("domain", 0): 1, ("domain", 2): 1}
    assert statistics.first_valid == 0


def test_a_requirement_clips_the_value_that_is_drawn_last() -> None:
    sampler = sampler_of(*LENGTHS, 'require a + b <= 12cm else "too broad"')
    batch = put_right(sampler, {"a": 0.09, "b": 0.08, "c": 0.02}, {"a": 0.02, "b": 0.08, "c": 0.02})
    assert batch.drawn(0)["b"] == pytest.approx(0.03) and batch.drawn(1)["b"] == 0.08
    (entry,) = log(batch)
    assert (entry["path"], entry["how"], entry["where"]) == ("b", "clipped", "box.apg:7:3")
    assert entry["because"] == "too broad (a + b <= 12cm)"


def test_a_hint_gives_way_before_what_is_drawn_last() -> None:
    sampler = sampler_of(*LENGTHS, 'require a + b <= 12cm else "too broad" repair a')
    batch = put_right(sampler, {"a": 0.09, "b": 0.08, "c": 0.02})
    assert batch.drawn(0)["b"] == 0.08 and 0.0395 < batch.drawn(0)["a"] <= 0.04 + 1e-9
    (entry,) = log(batch)
    assert (entry["path"], entry["how"], entry["from"], entry["where"]) == ("a", "hint", 0.09, "box.apg:7:3")


def test_a_hint_may_name_a_part_or_what_follows_from_others() -> None:
    sampler = sampler_of(
        *LENGTHS,
        "let wide = a + b",
        "part lid : Cuboid(size = [10cm, 10cm, c]) | none",
        "connect lid.bottom on body.top",
        "require wide <= 15cm repair wide",
        "require a <= 5cm or not lid repair lid",
        "require c <= b repair c",
    )
    names = [[sampler.program.draws[k].column.name for k in r.repair] for r in sampler.program.requirements]
    assert [n for n in names if n] == [["a", "b"], ["lid"], ["c"]]
    read = from_text(to_text(sampler.program))
    assert [r.repair for r in read.requirements] == [r.repair for r in sampler.program.requirements]


def test_what_no_clipping_puts_right_is_searched_for() -> None:
    """The bound of c is met for few values of b alone: c has no room where b leaves none."""
    sampler = sampler_of(*LENGTHS, 'require a * sin(b / 1cm * 40deg) + 0.05 * c * (b / 1cm) >= 3cm else "odd"')
    batch = put_right(sampler, {"a": 0.02, "b": 0.045, "c": 0.01}, {"a": 0.08, "b": 0.02, "c": 0.05})
    assert not batch.state.failed.any() and batch.drawn(1) == {"a": 0.08, "b": 0.02, "c": 0.05}
    moved = {entry["path"]: entry["how"] for entry in log(batch)}
    assert moved.pop("c", "clipped") == "clipped" and set(moved.values()) == {"search"}
    assert batch.drawn(0)["a"] == 0.02 or batch.drawn(0)["b"] == 0.045  # one of them sufficed


CRATE = """apg 1
use primitives { Cuboid }
category Crate {
  param wide  : length in 10cm .. 30cm
  param reach : length in 5cm .. 40cm
  param far   : length in 5cm .. 40cm
  root part body : Cuboid(size = [20cm, wide, 10cm])
  part rail : Cuboid(size = [60cm, 8cm, 2cm])
  part tray : Cuboid(size = [10cm, 8cm, 4cm])
  part stop : Cuboid(size = [2cm, 8cm, 4cm])
  align rail.back = body.front
  align rail.center.y = body.center.y
  align rail.bottom = body.bottom
  connect rail to body
  align tray.back = body.front + 1mm
  align tray.center.y = body.center.y
  align tray.bottom = rail.top + 1mm
  align stop.back = body.front + 11cm + far
  align stop.center.y = body.center.y
  align stop.bottom = rail.top
  connect stop to body
  joint pull : prismatic body -> tray along x range 0 .. reach
}
"""


def test_links_that_collide_are_kept_apart_by_the_values_behind_them() -> None:
    sampler = Session.of_text(CRATE, "crate.apg").sampler
    statistics = Statistics()
    batch = put_right(
        sampler,
        {"wide": 0.2, "reach": 0.3, "far": 0.25},
        {"wide": 0.2, "reach": 0.2, "far": 0.25},
        statistics=statistics,
    )
    assert not len(find_faults(batch).objects()) and batch.drawn(1) == {"wide": 0.2, "reach": 0.2, "far": 0.25}
    (entry,) = log(batch)
    assert entry["path"] in ("reach", "far") and entry["how"] == "search"
    assert abs(entry["to"] - entry["from"]) < 0.06  # 4.9 cm would do
    assert entry["because"] == "body and tray collide while pull moves" and entry["where"] == "crate.apg:22:3"
    assert list(statistics.repaired.values()) == [1]


def test_two_faults_at_once() -> None:
    sampler = sampler_of(
        *LENGTHS,
        "param d : length in 1cm .. 10cm",
        'require sin(a / 1cm * 60deg) + sin(b / 1cm * 60deg) >= 0.5 else "first" repair a',
        'require cos(c / 1cm * 60deg) + cos(d / 1cm * 60deg) >= 0.5 else "second" repair c',
    )
    records = [{"a": 0.045 + 0.001 * k, "b": 0.045, "c": 0.03, "d": 0.033 + 0.001 * k} for k in range(12)]
    batch = put_right(sampler, *records)
    assert not batch.state.failed.any()
    assert {entry["because"].split(" (")[0] for entry in log(batch)} <= {"first", "second"} | {
        w["because"] for w in log(batch)
    }


def test_nan_and_null_are_drawn_and_infinity_is_the_end() -> None:
    statistics = Statistics()
    values = {"a": float("nan"), "b": float("inf"), "c": None}
    batch = put_right(sampler_of(*LENGTHS), values, statistics=statistics)
    assert statistics.failures() == {("absent", 0): 1, ("domain", 1): 1, ("absent", 2): 1}
    drawn = batch.drawn(0)
    assert 0.01 <= drawn["a"] <= 0.1 and drawn["b"] == 0.1 and 0.01 <= drawn["c"] <= 0.1
    assert [(e["path"], e["from"] is None, e["how"]) for e in log(batch)] == [
        ("a", True, "redrawn"),
        ("b", False, "clipped"),
        ("c", True, "redrawn"),
    ]
    assert log(batch)[0]["because"] == "`a` has no value"


def test_a_count_that_is_too_large_takes_its_list_along() -> None:
    sampler = sampler_of(
        "count n in 1 .. 3", "repeat e[i] in 0 ..< n pitch 2cm along x { param s : length in 1cm .. 2cm }"
    )
    batch = put_right(sampler, {"n": 50, "e.s": [0.011, 0.012, 0.013, 0.014, 9.0]})
    assert batch.drawn(0) == {"n": 3, "e.s": [0.011, 0.012, 0.013]}


def test_what_nothing_puts_right_ends_with_the_three_worst() -> None:
    never = 'require sin({0} / 1cm * 40deg) * cos({0} / 1cm * 40deg) >= 0.6 else "never {0}"'
    sampler = sampler_of(*LENGTHS, "param d : length in 1cm .. 10cm", *(never.format(name) for name in "abcd"))
    job = prepare(sampler, Request("box.apg", values=({"a": 0.05, "b": 0.05, "c": 0.05},)))
    with pytest.raises(NoObject) as found:
        job.batch([0])
    lines = re.findall(r"box.apg:(\d+): never", found.value.message)
    assert len(set(lines)) == 3 and set(lines) <= {"8", "9", "10", "11"}


def test_objects_are_the_same_in_any_batch() -> None:
    sampler = sampler_of(
        *LENGTHS,
        "require a + b <= 12cm repair a",
        'require a * sin(b / 1cm * 40deg) + 0.05 * c * (b / 1cm) >= 2cm else "odd"',
    )
    records = [{"a": 0.01 + 0.007 * k, "b": 0.12 - 0.008 * k, "c": 0.003 * k} for k in range(14)]
    whole = put_right(sampler, *records)
    values, every = given(sampler, *records), whole.values()
    for part in (np.arange(5), np.arange(5, 14), np.array([13, 2])):
        some = values.batch(sampler, part, 0, Statistics(), True)
        assert all(np.array_equal(v, every[k][part]) for k, v in some.values().items())
        assert log(some) == whole.repairs.of(part).plain(sampler.program)


@pytest.mark.parametrize("name", ["Microwave", "Faucet"])
def test_disturbed_objects_become_valid_with_little_change(name: str) -> None:
    sampler = Session.of(name).sampler
    batch = sampler.batch(np.arange(12), 3, checked=True)
    asked = []
    for number, draw in enumerate(sampler.program.draws):
        value = batch.state.values[number]
        if draw.kind == "real":
            low, high = (np.asarray(end, dtype=float) for end in batch.read([draw.low, draw.high], draw.column.scope))
            value = value + 0.1 * (high - low) * np.where(np.arange(len(value)) % 2, 1.0, -1.0)
        asked.append(value)
    numbers = np.arange(len(batch))
    state = State(batch.seed, batch.state.objects, batch.state.attempt)
    for number in range(len(sampler.program.draws)):
        at = rows_of_draw(batch, number, numbers)
        order = np.argsort(at.key, kind="stable")
        still = np.zeros(len(order))
        state.kept[number] = Kept(at.key[order], asked[number][at.row][order], still, still.astype(bool))
    found = repair(sampler, make_batch(sampler.program, sampler.plan, state), Asked.all(batch, asked))
    assert not len(found.failed) and not found.batch.state.failed.any() and not len(find_faults(found.batch).objects())
    assert len(found.repairs) < sum(len(v) for v in asked) / 4


def test_sampling_repairs_instead_of_drawing_again_where_it_is_asked_to() -> None:
    sampler = Session.of_text(CRATE).sampler
    numbers, statistics = np.arange(40), Statistics()
    plain = sampler.batch(numbers, 1, checked=True)
    mended = sampler.batch(numbers, 1, checked=True, mend=True, statistics=statistics)
    valid = plain.state.attempt == 0
    assert 0 < valid.sum() < 40 and statistics.attempts == 40
    assert (mended.state.attempt == 0).all() and not len(find_faults(mended).objects())
    assert np.array_equal(mended.repairs.objects(), np.flatnonzero(~valid))
    for key, value in mended.values().items():
        assert np.array_equal(value[valid], plain.values()[key][valid])
    assert sum(statistics.repaired.values()) == (~valid).sum()
    one = sampler.batch(np.flatnonzero(~valid)[:1], 1, checked=True, mend=True)
    assert log(one) == mended.repairs.of(np.flatnonzero(~valid)[:1]).plain(sampler.program)


def test_mutants_are_repaired_and_tell_it_again_when_replayed() -> None:
    sampler = Session.of_text(
        CRATE.replace("reach : length in 5cm .. 40cm", "reach : length in 5cm .. 40cm vary 20cm")
    ).sampler
    batch = sampler.batch(np.arange(24), 1, checked=True)
    statistics = Statistics()
    mutant = mutate(sampler, batch, operations=("cpa",), checked=True, statistics=statistics)
    assert statistics.first_valid < 24 == statistics.attempts  # none was drawn again
    assert not len(find_faults(mutant).objects()) and "search" in {entry["how"] for entry in log(mutant)}
    assert sum(statistics.repaired.values()) == len(mutant.repairs.objects())
    records = read_traces(trace_lines(mutant).decode(), "trace")
    same = Replay(records).apply(sampler, batch, mutant.numbers, np.zeros(24, dtype=np.int64), Statistics(), True)
    assert log(same) == log(mutant) and trace_lines(same) == trace_lines(mutant)
    assert all(np.array_equal(v, mutant.values()[k]) for k, v in same.values().items())
    alone = mutate(sampler, evaluate_again(batch, mutant.repairs.objects()[:1]), operations=("cpa",), checked=True)
    assert log(alone) == mutant.repairs.of(mutant.repairs.objects()[:1]).plain(sampler.program)


def test_what_mutation_clips_is_told_with_its_requirement() -> None:
    sampler = sampler_of(
        "count n in 1 .. 4", "param a : length in 1cm .. 10cm", 'require a * n <= 12cm else "too many for their width"'
    )
    batch = sampler.batch(np.arange(40), 0)
    mutant = mutate(sampler, batch, operations=("dpa",))
    entries = log(mutant)
    assert entries and {(e["path"], e["how"], e["where"]) for e in entries} == {("a", "clipped", "box.apg:6:3")}
    assert {e["because"] for e in entries} == {"too many for their width (a * n <= 12cm)"}


# ---------------------------------------------------------------- what was drawn, given again


SHARED = """apg 1
use primitives { Cuboid }
use materials { oak, pine }
role Knob { inherit size : length[3] in [1cm, 1cm, 1cm] .. [2cm, 2cm, 2cm]  slot grip }
template Plain : Knob { param rim : length in 1mm .. 4mm  part grip : Cuboid(size = [size.x + rim, size.y, size.z]) }
template Fancy : Knob { param rim : length in 5mm .. 9mm  part grip : Cuboid(size = [size.x + rim, size.y, size.z]) }
category Box {
  param look_at : choice left | right
  root part body : Cuboid(size = [10cm, 60cm, 10cm])
  repeat place[i] in 0 ..< 6 split body.box along y {
    part knob : Knob = Plain | Fancy
    connect knob.grip.bottom on body.top
    align knob.grip.center.y = place.center.y
  }
  style skin : material = oak when look_at == left | pine | oak weight 2 when look_at == right
  material skin on body
}
"""


def test_what_was_drawn_is_the_object_again_also_where_alternatives_share_names():
    sampler = Session.of_text(SHARED, "box.apg").sampler
    drawn = sampler.batch(np.arange(12), 0)
    told = [drawn.drawn(i) for i in range(12)]
    assert all(len(entry["place.knob.rim"]) == len(entry["place.knob"]) == 6 for entry in told)
    assert all(
        (rim < 4.5e-3) == (kind == "Plain")
        for entry in told
        for rim, kind in zip(entry["place.knob.rim"], entry["place.knob"], strict=True)
    )
    again = put_right(sampler, *told)
    assert [again.drawn(i) for i in range(12)] == told and not again.repairs.plain(sampler.program)
    assert {(entry["look_at"], entry["skin"]) for entry in told} >= {("left", "oak"), ("right", "oak")}


def test_an_error_in_values_names_the_file_and_the_object():
    sampler = sampler_of("param width : length in 1cm .. 2cm")
    with pytest.raises(UserError, match=r"values, object 1: width=9 has no unit.*for example width=1\.5cm"):
        given(sampler, {"width": "1cm"}, {"width": "9"})


def test_alternatives_of_one_template_are_told_apart():
    sampler = Session.of_text(
        SHARED.replace("Knob = Plain | Fancy", "Knob = Plain(rim = 1mm) | Plain(rim = 3mm)"), "box.apg"
    ).sampler
    told = [sampler.batch(np.arange(3), 0).drawn(i) for i in range(3)]
    assert {name for entry in told for name in entry["place.knob"]} == {"Plain", "Plain#2"}
    again = put_right(sampler, *told)
    assert [again.drawn(i) for i in range(3)] == told
