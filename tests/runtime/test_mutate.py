"""Mutation: what is kept, what changes, and that mutants are as valid as samples."""

import json
from pathlib import Path

import numpy as np
import pytest

from artipg_dsl.robot.materials import draw_colours
from artipg_dsl.run.counts import explain_exhausted
from artipg_dsl.sampling.correspondence import NONE, REPLICA, SAME, SLOT, find_correspondence
from artipg_dsl.sampling.known import evaluate_again
from artipg_dsl.sampling.mutate import Names, find_structural, mutate
from artipg_dsl.sampling.statistics import Exhausted, Statistics
from artipg_dsl.sampling.trace import compare_batches, replay, trace_lines, trace_objects
from artipg_dsl.session import Session


@pytest.fixture(scope="module")
def batch(microwave):
    return microwave.batch(np.arange(120), seed=2)


def kinds(made):
    return {(s.op, s.how) for s in made}


def test_without_operations_nothing_changes(microwave, batch):
    same = mutate(microwave, batch, operations=())
    assert not any(trace_objects(same)) and not any(compare_batches(batch, same))
    for a, b in zip(batch.sites(), same.sites(), strict=True):
        assert np.array_equal(a.translation, b.translation)


def test_apa_swaps_templates_and_keeps_what_the_role_inherits(microwave, batch):
    mutant = mutate(microwave, batch, operations=("apa",), only="handle")
    number = next(k for k, d in enumerate(microwave.program.draws) if d.address == "handle")
    assert number in find_structural(microwave.program)
    assert (mutant.state.values[number] != batch.state.values[number]).all()
    sizes = [k for k, d in enumerate(microwave.program.draws) if d.address.startswith("handle.size")]
    kept = np.ones(len(batch), dtype=bool)
    for k in sizes:
        kept &= np.abs(mutant.state.values[k] - batch.state.values[k]) < 1e-12
    assert kept.mean() > 0.5  # the others had to adapt to the new template
    other = next(k for k, d in enumerate(microwave.program.draws) if d.address == "width")
    assert np.array_equal(mutant.state.values[other], batch.state.values[other])


def test_dpa_changes_counts_and_kept_ranks_keep_their_draws(microwave, batch):
    mutant = mutate(microwave, batch, operations=("dpa",))
    made = trace_objects(mutant)
    changed = [i for i in range(len(batch)) if ("dpa", "changed") in kinds(made[i])]
    assert len(changed) > 0.75 * sum(any(c == "count" for c in _count_rows(batch, i)) for i in range(len(batch)))
    counts = {d.address for d in microwave.program.draws if d.kind == "count"}
    assert all(s.draw in counts for steps in made for s in steps if s.how == "changed")


def _count_rows(batch, index):
    for draw in batch.program.draws:
        if (batch.owner(draw.column.scope) == index).any():
            yield draw.kind


def test_cpa_stays_within_the_declared_step(microwave, batch):
    mutant = mutate(microwave, batch, operations=("cpa",))
    number, draw = next((k, d) for k, d in enumerate(microwave.program.draws) if d.address == "width")
    assert draw.vary is not None and draw.vary[0]
    before, after = batch.state.values[number], mutant.state.values[number]
    assert (np.abs(after - before) <= draw.vary[1].constant * before + 1e-12).all()
    assert (after != before).all()
    half = mutate(microwave, batch, operations=("cpa",), strength=0.1).state.values[number]
    assert np.abs(half - before).max() < 0.15 * np.abs(after - before).max()


LISTED = """apg 1
use primitives { Cuboid }
category Board {
  param deep : length in 1cm .. 10cm
  param wide : length in 1cm .. 20cm ~ values(2cm, 3cm, 3cm, 6cm, 15cm)
  param high : length in 1cm .. deep ~ values(2cm, 4cm, 6cm) vary 1%
  param rim  : length in 1cm .. 10cm ~ uniform(2cm, 3cm) vary 3cm
  count rows in 1 .. 6 ~ values(1, 2, 4, 6)
  count bars in 1 .. 6 ~ uniform(3, 5)
  require wide + high <= 16cm repair wide
  root part body : Cuboid(size = [deep, wide, high])
}
"""


@pytest.fixture(scope="module")
def listed(tmp_path_factory):
    path = tmp_path_factory.mktemp("listed") / "board.apg"
    path.write_text(LISTED)
    return Session.of(str(path)).sampler


@pytest.mark.parametrize("one", [False, True])
@pytest.mark.parametrize("strength", [0.01, 1.0, 5.0])
def test_numbers_of_a_list_stay_in_it(listed, strength, one):
    """Also where `deep` leaves `high` none of its values, and where a sum is to be put right."""
    batch = listed.batch(np.arange(200), seed=1)
    found = mutate(listed, batch, operations=("dpa", "cpa"), strength=strength, one=one).values()
    lists = {"wide": (0.02, 0.03, 0.06, 0.15), "high": (0.02, 0.04, 0.06), "rows": (1, 2, 4, 6), "bars": (3, 4, 5)}
    for name, values in lists.items():
        assert np.isin(found[name].round(9), values).all(), name
    assert (found["rim"] >= 0.02).all() and (found["rim"] <= 0.03).all()


def test_a_small_step_moves_along_a_list_to_a_neighbour(listed):
    batch = listed.batch(np.arange(200), seed=1)
    mutant = mutate(listed, batch, operations=("cpa",), strength=0.01, only="wide", one=True)
    order = {0.02: 0, 0.03: 1, 0.06: 2}  # 15 cm are too wide beside any `high`
    places = [np.array([order[v] for v in b.values()["wide"].round(9)]) for b in (batch, mutant)]
    assert (np.abs(places[1] - places[0]) == 1).all()
    assert all([s.path for s in steps if s.how == "changed"] == ["wide"] for steps in trace_objects(mutant))


def test_mutants_are_valid_in_their_own_right(microwave, batch):
    statistics = Statistics()
    mutant = mutate(microwave, batch, statistics=statistics)
    assert not mutant.state.failed.any()
    assert statistics.first_valid > 0.9 * len(batch)
    for number, draw in enumerate(microwave.program.draws):
        if draw.kind == "choice":
            continue
        low, high = mutant.read([draw.low, draw.high], draw.column.scope)
        value = mutant.state.values[number]
        assert (value >= low - 1e-9).all() and (value <= high + 1e-9).all()


def test_a_mutant_is_the_same_alone_and_in_a_batch_and_variants_differ(microwave, batch):
    mutant = mutate(microwave, batch, variant=3)
    alone = mutate(microwave, microwave.batch(np.array([37]), seed=2), variant=3)
    assert alone.drawn(0) == mutant.drawn(37)
    assert mutate(microwave, batch, variant=4).drawn(37) != mutant.drawn(37)
    again = mutate(microwave, mutant, variant=3)
    assert again.drawn(37) != mutant.drawn(37)


def test_unrelated_draws_are_left_alone(microwave, batch):
    mutant = mutate(microwave, batch, operations=("cpa",), only="border")
    for made in trace_objects(mutant):
        assert {s.path for s in made if s.how == "changed"} == {"border"}


def test_unknown_operations_are_refused(microwave, batch):
    with pytest.raises(ValueError, match="apa, dpa, cpa"):
        mutate(microwave, batch, operations=("xpa",))


# ---------------------------------------------------------------- traces


def test_traces_say_what_was_done_and_do_it_again(microwave, batch):
    mutant = mutate(microwave, batch)
    records = [json.loads(line) for line in trace_lines(mutant).decode().splitlines()]
    again_made = replay(batch, records)
    for number in range(len(microwave.program.draws)):
        assert again_made.state.values[number].tobytes() == mutant.state.values[number].tobytes()
    assert trace_lines(again_made) == trace_lines(mutant)
    for a, b in zip(mutant.sites(), again_made.sites(), strict=True):
        assert a.translation.tobytes() == b.translation.tobytes()
    order = [[("apa", "dpa", "cpa").index(s.op) for s in made] for made in trace_objects(mutant)]
    assert all(o == sorted(o) for o in order)
    found = {how for made in trace_objects(mutant) for _, how in kinds(made)}
    assert found >= {"changed", "new", "gone", "determined"}


def test_a_trace_is_the_same_in_any_batch(microwave):
    few, alone = (trace_lines(mutate(microwave, microwave.batch(np.arange(first, 9), seed=2))) for first in (0, 8))
    assert few.splitlines()[-1] == alone.splitlines()[-1]


def test_a_trace_ends_where_the_mutant_stands(microwave, batch):
    mutant = mutate(microwave, batch, variant=5)
    for index, made in enumerate(trace_objects(mutant)[:20]):
        last = {s.path: s.after for s in made if s.draw and "[" not in s.path}
        drawn = mutant.drawn(index)
        assert all(drawn.get(path) == value for path, value in last.items() if value is not None or path not in drawn)


def test_an_edited_trace_is_made_as_far_as_it_fits(microwave, batch):
    one = evaluate_again(batch, np.array([4]))
    step = {"op": "cpa", "how": "changed", "path": "width", "from": 0, "to": 9.0, "draw": "width", "at": []}
    made = replay(one, [{"steps": [step]}])
    number = next(k for k, d in enumerate(microwave.program.draws) if d.address == "width")
    assert made.state.values[number] == microwave.program.draws[number].high.constant


# ---------------------------------------------------------------- one value


@pytest.mark.some
@pytest.mark.parametrize("name", ["width", "handle", "handle.size.z", "pad.rows"])
def test_pairs_differ_in_one_value(microwave, batch, name):
    pair = mutate(microwave, batch, only=name, one=True)
    changed = 0
    for index, made in enumerate(trace_objects(pair)):
        purpose = [s for s in made if s.how == "changed"]
        assert not [s for s in made if s.how == "clipped"]
        assert len(purpose) <= 1 and all(s.path == name for s in purpose)
        before, after = batch.drawn(index), pair.drawn(index)
        shared = (before.keys() & after.keys()) - {name}
        for key in shared:  # what only one of two templates has bears the same name now and then
            if not any(s.path.split("[")[0] == key for s in made if s.how in ("new", "gone")):
                assert isinstance(before[key], list) or before[key] == after[key], key
        changed += bool(purpose)
    there = sum(name in batch.drawn(index) for index in range(len(batch)))
    assert changed > 0.9 * there


def test_a_pair_is_the_same_alone_and_in_a_batch(microwave, batch):
    pair = mutate(microwave, batch, only="depth", one=True)
    alone = mutate(microwave, microwave.batch(np.array([37]), seed=2), only="depth", one=True)
    assert alone.drawn(0) == pair.drawn(37)


def test_a_pair_does_not_depend_on_what_can_be_swapped_in_others():
    """Where the handle cannot be swapped, the pair is one of equals, whether or not another object of the batch swaps its own."""
    text = """
    use primitives { Cuboid }
    use handles    { Handle, BarHandle, BowHandle }
    category Front {
      param width : length in 30cm .. 60cm
      part handle : Handle = BarHandle | BowHandle
      require handle is BarHandle or width >= 45cm
      root part slab : Cuboid(size = [3cm, width, 50cm])
      connect handle.back on slab.front at z = slab.center.z, y = slab.center.y
    }"""
    sampler = Session.of_text(text).sampler
    batch = sampler.batch(np.arange(12), seed=0)
    pairs = mutate(sampler, batch, only="handle", one=True)
    swapped = [bool(made) and made[0].path == "handle" for made in trace_objects(pairs)]
    assert 0 < sum(swapped) < 12
    for place, other in enumerate(swapped):
        alone = mutate(sampler, evaluate_again(batch, np.array([place])), only="handle", one=True)
        assert alone.drawn(0) == pairs.drawn(place)
        assert (alone.drawn(0) != batch.drawn(place)) == other


def test_names_mean_parts_values_and_rows(microwave, batch):
    draws = {d.column.name: d for d in microwave.program.draws}
    assert Names("handle").of(batch, draws["handle.size.z"]).all()
    assert not Names("hand").of(batch, draws["handle.size.z"]).any()
    assert Names("h*e, tray").of(batch, draws["handle.size.z"]).all()
    assert not Names("").of(batch, draws["width"]).any()


# ---------------------------------------------------------------- variants of one object side by side


def test_variants_side_by_side_are_those_made_alone(microwave, batch):
    together = evaluate_again(batch, np.array([7, 7, 8, 7]))
    many = mutate(microwave, together, variant=np.array([0, 1, 0, -1]))
    for place, variant in ((0, 0), (1, 1)):
        assert many.drawn(place) == mutate(microwave, evaluate_again(batch, np.array([7])), variant=variant).drawn(0)
    assert many.drawn(3) == batch.drawn(7)


def test_a_mutant_has_the_colours_of_its_original(microwave, batch):
    originals = evaluate_again(batch, np.array([7, 7, 9]))
    originals.numbers = np.array([0, 1, 2])
    mutant = mutate(microwave, originals, variant=np.array([-1, 0, 0]))
    for material in microwave.program.materials.values():
        np.testing.assert_array_equal(draw_colours(mutant, material), draw_colours(batch, material)[[7, 7, 9]])


# ---------------------------------------------------------------- correspondence


def test_every_primitive_is_its_own_match(batch):
    table = find_correspondence(batch, batch)
    assert (
        (table.how == SAME).all()
        and (table.site == table.before_site).all()
        and (table.rank == table.before_rank).all()
    )
    np.testing.assert_array_equal(table.position, table.before_position)


def test_new_rows_take_the_nearest_that_was_there(microwave, batch):
    mutant = mutate(microwave, batch, operations=("dpa",))
    table = find_correspondence(batch, mutant)
    replicas = table.how == REPLICA
    assert replicas.any() and (table.site == table.before_site)[replicas].all()
    counts = {}
    for site in batch.sites():
        for owner, rank in zip(site.owner.tolist(), site.rank.tolist(), strict=True):
            counts[owner, site.number] = rank + 1
    for k in np.flatnonzero(replicas).tolist():
        assert table.before_rank[k] < counts[int(table.source[k]), int(table.before_site[k])]


def test_the_nearest_of_a_single_row_of_knobs_is_the_last():
    sampler = Session.of(Path(__file__).parents[1] / "cli" / "programs" / "chest.apg").sampler
    batch = sampler.batch(np.arange(30), seed=1)
    mutant = mutate(sampler, batch, operations=("dpa",))
    knobs = [b.values()["knobs"] for b in (batch, mutant)]
    assert (knobs[0] != knobs[1]).all()
    table = find_correspondence(batch, mutant)
    site = next(k for k, s in enumerate(sampler.program.sites) if s.path == "knob.cap")
    mine = table.site == site
    np.testing.assert_array_equal(
        table.before_rank[mine], np.minimum(table.rank[mine], knobs[0][table.source[mine]] - 1)
    )
    assert set(table.how[mine].tolist()) == {SAME, REPLICA}


def test_slots_carry_over_to_another_template(microwave, batch):
    mutant = mutate(microwave, batch, operations=("apa",), only="handle")
    table = find_correspondence(batch, mutant)
    paths = np.array([s.path for s in microwave.program.sites])
    grips = (table.how == SLOT) & (paths[table.site] == "handle.grip")
    assert grips.any() and (paths[table.before_site[grips]] == "handle.grip").all()
    assert (table.site != table.before_site)[grips].all()
    loose = table.how == NONE
    assert loose.any() and (table.before_site[loose] == -1).all() and np.isnan(table.before_position[loose]).all()


def test_everything_is_no_unknown_name_where_nothing_is_drawn():
    text = "use primitives { Cuboid }\ncategory Slab { root part slab : Cuboid(size = [1cm, 1cm, 1cm]) }"
    sampler = Session.of_text(text).sampler
    assert Names.unknown("*, lid", sampler.program) == ["lid"]
    batch = sampler.batch(np.arange(2), seed=0)
    assert mutate(sampler, batch).drawn(1) == batch.drawn(1) == {}


LOCKED = """apg 1
use primitives { Cuboid, Cylinder }
category Rack {
  root part body : Cuboid(size = [30cm, 60cm, 10cm])
  count n in 1 .. 6
  repeat s[i] in 0 ..< n spread body along y margin 3cm {
    param col : choice red | blue
    count knobs in 1 .. 2
    part p : Cylinder(radius = 1cm, height = 2cm if col == red else 3cm)
    connect p.bottom on body.top at x = 0, y = s.center.y
    when knobs == 2 { require col == red }
  }
}
"""


def test_a_count_that_cannot_change_stays_and_others_are_changed():
    """Of an element that is blue, the only other number of knobs is no valid one: every attempt asked for it again."""
    sampler = Session.of_text(LOCKED).sampler
    batch = sampler.batch(np.arange(40), seed=0)
    mutant = mutate(sampler, batch, operations=("dpa",), checked=True)
    assert not mutant.state.failed.any()
    made = trace_objects(mutant)
    assert all(("dpa", "changed") in kinds(steps) for steps in made)
    few = np.array([3, 17, 39])
    part = mutate(sampler, evaluate_again(batch, few), operations=("dpa",), checked=True)
    assert trace_objects(part) == [made[k] for k in few.tolist()]  # on any size of batch
    records = [json.loads(line) for line in trace_lines(mutant).decode().splitlines()]
    again = replay(batch, records)
    assert not any(compare_batches(mutant, again))


HELD = """apg 1
use primitives { Cuboid, Cylinder }
category Stand {
  root part body : Cuboid(size = [30cm, 30cm, height])
  param height : length in 5cm .. 20cm
  param ending : choice bare | knob
  param foot : choice bare | ring
  when ending == knob {
    require height < 10cm
    part ball : Cylinder(radius = 1cm, height = 2cm)
    connect ball.bottom on body.top
  }
  when foot == ring {
    part hoop : Cylinder(radius = 5cm, height = 1cm)
    connect hoop.top on body.bottom
  }
}
"""


def test_what_cannot_be_swapped_leaves_it_to_what_can():
    """What is kept leaves a high stand no knob: it was said to be swapped, and the mutant was the stand itself."""
    sampler = Session.of_text(HELD).sampler
    batch = sampler.batch(np.arange(60), seed=0)
    top, foot, height = (
        next(k for k, d in enumerate(sampler.program.draws) if d.address == name)
        for name in ("ending", "foot", "height")
    )
    mutant = mutate(sampler, batch, operations=("apa",), share=0.1)
    made = trace_objects(mutant)
    assert all(kinds(steps) == {("apa", "changed")} for steps in made)
    high = (batch.state.values[height] > 0.1) & (batch.state.values[top] == 0)
    assert 5 < high.sum() < 55
    moved = {k: batch.state.values[k] != mutant.state.values[k] for k in (top, foot)}
    assert moved[foot][high].all() and not moved[top][high].any()
    assert moved[top][~high].any() and not (moved[top] & moved[foot]).all()
    few = np.array([1, 20, 59])
    assert trace_objects(mutate(sampler, evaluate_again(batch, few), operations=("apa",), share=0.1)) == [
        made[k] for k in few.tolist()
    ]
    alone = mutate(sampler, batch, operations=("apa",), only="ending")  # and nothing else may: those stay as they are
    assert np.array_equal([not steps for steps in trace_objects(alone)], high)


def test_what_a_mutant_keeps_is_to_blame_where_none_is_valid():
    sampler = Session.of_text(LOCKED.replace("require col == red", "require col == red and n < 3")).sampler
    batch = sampler.batch(np.arange(40), seed=0)
    with pytest.raises(Exhausted) as found:
        mutate(sampler, batch, operations=("dpa",), only="s.knobs", checked=True)
    assert "a mutant keeps" in str(explain_exhausted(sampler.program, found.value, {}, {}, lambda _: 0.0).hint)
