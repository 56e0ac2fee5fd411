"""Mutants from the command line and in Python: written, made again from their folder, told apart."""

import json

import numpy as np
import pytest

import artipg_dsl as apg
from artipg_dsl.cli.main import main
from artipg_dsl.errors import UsageError
from artipg_dsl.sampling.mutation import Mutation

from .helpers import CHEST, tree


def test_mutants_are_written_and_made_again(apgc, tmp_path):
    first, second, plain = tmp_path / "first", tmp_path / "second", tmp_path / "plain"
    for folder, more in (
        (first, ("--mutate", "apa,cpa")),
        (second, ("--mutate", "apa,cpa", "--variant", 1)),
        (plain, ()),
    ):
        code, _, err = apgc("sample", CHEST, "-n", 6, "--seed", 3, "-o", folder, "--points", 64, *more)
        assert code == 0, err
    assert len({tree(f)["points-00000.npz"] for f in (first, second, plain)}) == 3
    again = apg.open_samples(first)
    drawn = [a["drawn"] for a in again.annotations()]
    lines = (first / "annotation-00000.jsonl").read_text(encoding="utf-8").splitlines()
    assert [json.loads(line)["drawn"].keys() for line in lines] == [d.keys() for d in drawn]
    code, _, err = apgc("sample", CHEST, "-n", 6, "--seed", 3, "-o", first, "--points", 64)
    assert code == 1 and "other options" in err


def test_mutants_in_python():
    batch = apg.sample("Microwave", n=12, seed=5)
    mutants = batch.mutate("cpa", only="width")
    assert (mutants["width"] != batch["width"]).all()
    assert (mutants["wall"] == batch["wall"]).all()
    found = mutants.changes(7)
    assert [s.path for s in found if s.how == "changed"] == ["width"]
    assert batch.changes(7) == []
    assert mutants.object(7).drawn == mutants.batch.drawn(7)
    assert mutants.mutate("apa").job.request.mutations[1].operations == ("apa",)


@pytest.mark.parametrize("wrong", ["xpa", "apa,", ""])
def test_unknown_operations(apgc, tmp_path, wrong):
    if wrong:
        code, _, err = apgc("sample", CHEST, "-o", tmp_path / "x", "--mutate", wrong)
        assert code == 2 and "apa, dpa, cpa" in err
    with pytest.raises(UsageError):
        apg.sample("Microwave", n=1).mutate(wrong)


@pytest.fixture(scope="module")
def chest(tmp_path_factory):
    folder = tmp_path_factory.mktemp("chest") / "out"
    assert main(["sample", CHEST, "-n", "5", "--seed", "3", "-o", str(folder), "--points", "32"]) == 0
    return folder


@pytest.mark.parametrize(
    ("wishes", "message"),
    [
        (("--ops", "apa", "--strength", 2), "--strength applies to the steps of cpa, not to apa"),
        (("--ops", "cpa", "--share", 0.2), "--share applies to the templates and counts of apa and dpa, not to cpa"),
        (("--ops", "apa", "--parts", "width,depth"), "there is nothing in width,depth that apa changes"),
        (("--ops", "dpa", "--parts", "wood"), "there is nothing in wood that dpa changes"),
        (("--all",), "--all applies to what --diff shows"),
        (
            ("--replay", "FOLDER", "--ops", "cpa"),
            "a trace already says which mutants there are, so --ops does not apply",
        ),
        (("--replay", "FOLDER", "-n", 2), "so -n does not apply"),
        (("--diff", "a", "b"), "--diff compares what is there and makes nothing, so FOLDER does not apply"),
        (("--ops", "apa,apa"), "the operation apa is given twice"),
        (("--share", "0"), "--share is 0, but one template or count changes at least"),
        (("--format", "annotation", "--points", 8), "--points applies to points"),
    ],
    ids=lambda value: " ".join(map(str, value)) if isinstance(value, tuple) else "",
)
def test_options_that_would_change_nothing_are_refused(apgc, chest, tmp_path, wishes, message):
    wishes = [chest if wish == "FOLDER" else wish for wish in wishes]
    code, _, err = apgc("mutate", chest, *wishes, "-o", tmp_path / "o")
    assert code == 2 and message.replace("FOLDER", str(chest)) in err
    assert not (tmp_path / "o").exists()


def test_a_program_without_choices_has_no_mutants_by_apa(apgc, tmp_path):
    program = tmp_path / "block.apg"
    program.write_text(
        "apg 1\nuse primitives { Cuboid }\ncategory Block {\n  param width : length in 1cm .. 2cm\n"
        "  root part body : Cuboid(size = [1cm, width, 1cm])\n}\n"
    )
    assert apgc("sample", program, "-n", 1, "--points", 8, "-o", tmp_path / "blocks")[0] == 0
    code, _, err = apgc("mutate", tmp_path / "blocks", "--ops", "apa", "-o", tmp_path / "o")
    assert code == 2 and "there is nothing in Block that apa changes" in err
    assert not (tmp_path / "o").exists()


def test_a_folder_of_mutants(apgc, chest, tmp_path):
    out = tmp_path / "mutants"
    code, _, err = apgc("mutate", chest, "--ops", "apa,dpa,cpa", "-n", 3, "-o", out)
    assert code == 0 and "15 objects" in err
    files = tree(out)
    assert set(files) == {
        "manifest.json",
        "annotation-00000.jsonl",
        "points-00000.npz",
        "trace-00000.jsonl",
        "correspondence-00000.npz",
    }
    lines = [json.loads(line) for line in files["trace-00000.jsonl"].decode().splitlines()]
    assert [(line["object"], line["source"]) for line in lines] == [(k, k // 3) for k in range(15)]
    assert len({json.dumps(line["steps"]) for line in lines}) == 15
    table = np.load(out / "correspondence-00000.npz")
    assert set(np.unique(table["source"])) == set(range(5)) and set(
        json.loads(files["manifest.json"])["correspondence"]
    ) == set(table.files)
    code, _, err = apgc("mutate", chest, "--ops", "apa,dpa,cpa", "-n", 3, "-o", out)  # nothing is missing
    assert code == 0 and tree(out) == files
    (out / "trace-00000.jsonl").unlink()
    assert apgc("mutate", chest, "--ops", "apa,dpa,cpa", "-n", 3, "-o", out)[0] == 0 and tree(out) == files
    code, _, err = apgc("mutate", chest, "--ops", "cpa", "-n", 3, "-o", out)
    assert code == 1 and "other options" in err
    again = apg.open_samples(out)
    assert again.changes(4) and len(again) == 15


def test_a_trace_is_done_again_to_the_same_bytes(apgc, chest, tmp_path):
    first, second = tmp_path / "first", tmp_path / "second"
    assert apgc("mutate", chest, "-n", 2, "-o", first)[0] == 0
    assert apgc("mutate", chest, "--replay", first, "-o", second)[0] == 0
    a, b = tree(first), tree(second)
    assert a.keys() == {name for name in b if not name.startswith("replay-")}
    assert all(a[name] == b[name] for name in a if name != "manifest.json")
    code, out, _ = apgc("mutate", "--diff", first, second)
    assert code == 0 and out == "no difference\n"
    assert len(apg.open_samples(second)) == 10
    for idle in (("--stats",), ("--shard", "1/2"), ("-o", "third"), ("--workers", 2)):
        code, _, err = apgc("mutate", "--diff", first, second, *idle)
        assert code == 2 and f"makes nothing, so {idle[0]} does not apply" in err
    assert "help: give two folders of samples, or two traces" in apgc("mutate", "--diff", first, "nowhere")[2]
    code, out, _ = apgc("mutate", "--diff", first / "trace-00000.jsonl", second / "trace-00000.jsonl")
    assert code == 0 and out == "no difference\n"


def test_what_repeats_a_trace_is_made_again_wherever_it_goes(apgc, chest, tmp_path):
    """Its records go along: mutants of it have traces of their own, files of another folder have none."""
    first, again, further = tmp_path / "first", tmp_path / "again", tmp_path / "further"
    assert apgc("mutate", chest, "-n", 2, "--points", 16, "-o", first)[0] == 0
    assert apgc("mutate", chest, "--replay", first, "-o", again)[0] == 0
    assert apgc("mutate", again, "--ops", "cpa", "-n", 2, "-o", further)[0] == 0
    wanted = apg.open_samples(first).mutate("cpa", n=2)
    assert apg.open_samples(further).annotations() == wanted.annotations()
    lines = (further / "annotation-00000.jsonl").read_text(encoding="utf-8").splitlines()
    assert [json.loads(line)["drawn"] for line in lines] == [
        a["drawn"] for a in json.loads(json.dumps(wanted.annotations()))
    ]
    for command in (("sample", "--points", 8), ("export", "--format", "obj")):
        out = tmp_path / command[0]
        assert apgc(command[0], again, *command[1:], "-o", out)[0] == 0
        assert apg.open_samples(out).annotations() == apg.open_samples(first).annotations()
    code, _, err = apgc("sample", chest, "--points", 8, "-o", tmp_path / "sample", "--force")
    assert code == 0, err
    assert not list((tmp_path / "sample").glob("replay-*"))
    code, _, err = apgc("export", again, "--format", "partnet-seg", "--split", "1,0,0", "-o", tmp_path / "seg")
    assert code == 0, err
    assert apgc("layout", tmp_path / "seg")[0] == 0


def test_records_that_are_repeated_are_those_of_the_manifest(apgc, chest, tmp_path):
    again, further = tmp_path / "again", tmp_path / "further"
    assert apgc("mutate", chest, "-n", 2, "--points", 16, "-o", tmp_path / "first")[0] == 0
    assert apgc("mutate", chest, "--replay", tmp_path / "first", "-o", again)[0] == 0
    assert apgc("mutate", again, "-o", further)[0] == 0
    (kept,) = further.glob("replay-*.jsonl")
    whole = kept.read_text(encoding="utf-8")
    kept.write_text("".join(whole.splitlines(keepends=True)[:-1]), encoding="utf-8")
    code, _, err = apgc("export", further, "--format", "obj", "-o", tmp_path / "o")
    assert code == 1 and "has been changed since these objects were made" in err
    kept.unlink()
    code, _, err = apgc("export", further, "--format", "obj", "-o", tmp_path / "o")
    assert code == 1 and f"{kept} is missing" in err
    assert apgc("mutate", again, "-o", further)[0] == 0 and kept.read_text(encoding="utf-8") == whole
    first = json.loads((tmp_path / "first" / "trace-00000.jsonl").read_text(encoding="utf-8").splitlines()[0])
    (tmp_path / "one.jsonl").write_text(json.dumps(first), encoding="utf-8")
    code, _, err = apgc("mutate", chest, "--replay", tmp_path / "one.jsonl", "--only", 3, "-o", tmp_path / "x")
    assert code == 1 and "has no mutant of object 3" in err and not (tmp_path / "x").exists()


def test_pairs_that_differ_in_one_value(apgc, chest, tmp_path):
    out = tmp_path / "pairs"
    assert apgc("mutate", chest, "--one", "width", "-o", out)[0] == 0
    drawn = [json.loads(line)["drawn"] for line in (out / "annotation-00000.jsonl").read_text().splitlines()]
    originals = [json.loads(line)["drawn"] for line in (chest / "annotation-00000.jsonl").read_text().splitlines()]
    assert drawn[0::2] == originals
    for one, other in zip(drawn[0::2], drawn[1::2], strict=True):
        assert {k for k in one if one[k] != other[k]} == {"width"} and one.keys() == other.keys()
    code, out_text, _ = apgc("mutate", "--diff", chest, out)
    assert code == 0 and "object 1 of 0" in out_text and "width:" in out_text and "cm ->" in out_text
    code, _, err = apgc("mutate", "--diff", out, chest)
    assert code == 1 and "give the originals first" in err


def test_objects_given_by_their_values(apgc, chest, tmp_path):
    file, out = tmp_path / "values.json", tmp_path / "out"
    file.write_text(json.dumps([{"width": "70cm", "height": 0.5}, {"width": 0.58}]), encoding="utf-8")
    code, _, err = apgc("mutate", CHEST, "--params", file, "--one", "width", "-o", out, "--points", 16)
    assert code == 0
    drawn = [json.loads(line)["drawn"] for line in (out / "annotation-00000.jsonl").read_text().splitlines()]
    assert [d["width"] for d in drawn[0::2]] == [0.6, 0.58] and drawn[0]["height"] == drawn[1]["height"] == 0.4
    assert "values of 1 of 2 originals were changed to make them valid" in err and "`width` lies outside" in err
    assert len(apg.open_samples(out)) == 4
    same = tmp_path / "same"
    from_annotation = ("--params", chest / "annotation-00000.jsonl", "--ops", "cpa", "--points", 16)
    code, _, err = apgc("mutate", CHEST, *from_annotation, "-o", same)
    assert code == 0, err


@pytest.mark.parametrize(
    ("arguments", "said"),
    [
        (("--ops", "xpa"), "there is no operation `xpa`"),
        (("--strength", "-1"), "not a number above 0"),
        (("--share", "2"), "between 0 and 1"),
        (("--variant", "-1"), "the variant is -1"),
        (("--only", "99"), "has no object 99"),
        (("--one", "width", "--parts", "lid"), "--parts cannot be given"),
        (("--one", "width", "--share", "1"), "cannot be given as well"),
        (("--one", "width", "--ops", "cpa"), "cannot be given as well"),
        (("--replay", "nothing.jsonl"), "cannot be read"),
        (("--one", "widht"), "did you mean `width`?"),
        (("--parts", "share,lod"), "Chest draws no `lod`"),
    ],
)
def test_wrong_use_is_told(apgc, chest, tmp_path, arguments, said):
    code, _, err = apgc("mutate", chest, "-o", tmp_path / "x", *arguments)
    assert code in (1, 2) and said in err and not (tmp_path / "x").exists()


def test_values_that_do_not_fit_are_told(apgc, tmp_path):
    file = tmp_path / "values.json"
    for text, said in (
        ('{"widht": 1}', "draws no `widht`"),
        ("[]", "holds no objects"),
        ("{", "is not JSON"),
        ('{"width": "70"}', "has no unit"),
    ):
        file.write_text(text, encoding="utf-8")
        code, _, err = apgc("mutate", CHEST, "--params", file, "-o", tmp_path / "x")
        assert code in (1, 2) and said in err
    assert apgc("mutate", "-o", tmp_path / "x")[0] == 2
    assert apgc("mutate", tmp_path, "-o", tmp_path / "x")[0] == 1


def test_originals_do_not_count_however_the_work_is_divided(chest):
    originals = apg.open_samples(chest).job
    step = Mutation(("cpa",), each=4, sources=originals.request.numbers)
    job = originals.mutated(step, np.arange(4 * len(originals.request.objects)))
    whole, parts = job.fresh(), job.fresh()
    whole.batch()
    for number in job.request.objects:
        parts.batch([number])
    assert whole.counts() == parts.counts() and whole.counts()["objects"] == len(job.request.objects)


@pytest.mark.slow
def test_replay_in_python():
    batch = apg.sample("Microwave", n=3, seed=5)
    mutants = batch.mutate(one="width")
    record = {"object": 1, "source": 1, "steps": [s.plain() for s in mutants.changes(1)]}
    again = batch.replay([record])
    assert again["width"] == mutants["width"][1] and again.numbers.tolist() == [1]
    table = mutants.correspondence()
    assert (table.how == 0).all() and len(table.site) == sum(len(s.owner) for s in mutants.batch.sites())


SLIDER = """apg 1
use primitives { Cuboid }
category Slider {
  param gap   : length in 1cm .. 5cm
  param width : length in 20cm .. 40cm
  root part base : Cuboid(size = [40cm, width, 2cm])
  part carriage  : Cuboid(size = [6cm, width, 3cm])
  part stop      : Cuboid(size = [1cm, width, 5cm])
  joint slide : prismatic base -> carriage along x range 0cm .. 3cm
  align carriage.bottom = base.top + 1mm
  align carriage.back = base.back
  connect stop.bottom on base.top
  align stop.back = carriage.front + gap
}
"""


def test_unchecked_mutants_are_those_of_the_objects_in_the_folder(apgc, tmp_path):
    """Originals that were drawn again, since they collided, stay what they are in the folder."""
    (tmp_path / "slider.apg").write_text(SLIDER, encoding="utf-8")
    folder, out, again = tmp_path / "o", tmp_path / "m", tmp_path / "again"
    assert apgc("sample", tmp_path / "slider.apg", "-n", 12, "--points", 8, "-o", folder)[0] == 0
    originals = apg.open_samples(folder)
    drawn = apg.sample(tmp_path / "slider.apg", 12, checked=False)
    assert (originals["gap"] >= 0.03).all() and (originals["width"] != drawn["width"]).any()
    asked = ("mutate", folder, "--unchecked", "--ops", "cpa", "--parts", "gap", "-n", 3, "--strength", 5, "-o", out)
    assert apgc(*asked)[0] == 0
    mutants = apg.open_samples(out)
    np.testing.assert_array_equal(mutants["width"], np.repeat(originals["width"], 3))
    assert (mutants["gap"] < 0.03).any()
    assert not json.loads((out / "manifest.json").read_text())["counts"]["checked"]
    assert apgc("mutate", folder, "--replay", out, "--unchecked", "-o", again)[0] == 0
    np.testing.assert_array_equal(apg.open_samples(again)["gap"], mutants["gap"])
    assert (again / "points-00000.npz").read_bytes() == (out / "points-00000.npz").read_bytes()


def test_near_duplicates_are_left_out(apgc, chest, tmp_path, monkeypatch):
    from artipg_dsl.quality.duplicates import find_near_duplicates, find_ranges

    asked = ("mutate", chest, "--ops", "cpa", "-n", 30, "--strength", 0.2, "--points", 16)
    assert apgc(*asked, "-o", tmp_path / "every")[0] == 0
    code, said, err = apgc(*asked, "--distinct", "--stats", "-o", tmp_path / "some")
    assert code == 0, err
    ranges = find_ranges(apg.sample(CHEST, n=256, checked=False).batch)
    left_out = [
        find_near_duplicates(
            apg.open_samples(tmp_path / "every", numbers=range(k * 30, k * 30 + 30)).batch, ranges=ranges
        )
        for k in range(5)
    ]
    kept = np.flatnonzero(~np.concatenate(left_out))
    assert 5 <= len(kept) < 150
    manifest = json.loads((tmp_path / "some" / "manifest.json").read_text())
    assert manifest["counts"]["near_duplicates"] == 150 - len(kept) and manifest["objects"] == len(kept)
    assert (
        f"{150 - len(kept)} near-duplicates left out" in said and f"{150 - len(kept)} near-duplicates left out" in err
    )
    with (
        np.load(tmp_path / "some" / "points-00000.npz") as some,
        np.load(tmp_path / "every" / "points-00000.npz") as every,
    ):
        assert np.array_equal(some["object"], kept)
        assert np.array_equal(some["points"], every["points"][kept])

    before = tree(tmp_path / "some")  # completed by any number of processes, and refused without the option
    (tmp_path / "some" / "points-00000.npz").unlink()
    with monkeypatch.context() as patched:
        patched.setattr(
            "artipg_dsl.run.distinct.find_near_duplicates", None
        )  # what a finished folder tells is not found again
        code, _, err = apgc(*asked, "--distinct", "--workers", 2, "-o", tmp_path / "some")
    assert code == 0 and f"{150 - len(kept)} near-duplicates left out" in err
    assert tree(tmp_path / "some") == before
    code, _, err = apgc(*asked, "-o", tmp_path / "some")
    assert code == 1 and "other options: the objects asked for (0" in err
    code, _, err = apgc(*asked, "--only", 3, "--distinct", "-o", tmp_path / "one")  # whatever else is mutated
    assert code == 0 and apg.open_samples(tmp_path / "one").numbers.tolist() == np.flatnonzero(~left_out[3]).tolist()


def test_what_is_not_compared(apgc, chest, tmp_path):
    code, _, err = apgc("mutate", chest, "--one", "width", "--distinct", "-o", tmp_path / "x")
    assert code == 2 and "--distinct does not apply with --one" in err
    code, _, err = apgc("mutate", chest, "--replay", chest, "--distinct", "-o", tmp_path / "x")
    assert code == 2 and "--distinct does not apply with --replay" in err
