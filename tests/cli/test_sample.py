"""apgc sample and render: folders, what is fixed, wrong input, statistics."""

from __future__ import annotations

import json
import re
from pathlib import Path

import numpy as np
import pytest

from artipg_dsl.cli.arguments import numbers
from artipg_dsl.version import __version__

from .helpers import CHEST, Apgc, tree

SMALL = ("--points", "32")


def annotations(folder: Path) -> list[dict]:
    return [json.loads(line) for path in sorted(folder.glob("*.jsonl")) for line in path.read_text().splitlines()]


def test_a_part_of_a_run_tells_how_many_objects_are_in_it(apgc: Apgc, tmp_path: Path) -> None:
    for part, told in (("1/2", "3 objects"), ("2/2", "0 objects")):
        code, _, err = apgc("sample", CHEST, "-n", 3, "--points", 8, "--shard", part, "-o", tmp_path / "o")
        assert code == 0 and f"{told} in {tmp_path / 'o'}, part {part[0]} of 2" in err


def test_sample_writes_shards_and_manifest(apgc: Apgc, tmp_path: Path) -> None:
    code, out, err = apgc("sample", CHEST, "-n", 5, "--seed", 7, "-o", tmp_path / "o", *SMALL)
    assert (code, out) == (0, "") and "5 objects in" in err
    assert set(tree(tmp_path / "o")) == {"manifest.json", "points-00000.npz", "annotation-00000.jsonl"}
    manifest = json.loads((tmp_path / "o" / "manifest.json").read_text())
    assert manifest["category"] == "Chest" and manifest["counts"]["objects"] == 5
    assert len(manifest["identity"]["program"]) >= 16
    assert np.load(tmp_path / "o" / "points-00000.npz")["points"].shape == (5, 32, 3)


def test_formats_per_object(apgc: Apgc, tmp_path: Path) -> None:
    assert apgc("sample", CHEST, "-n", 2, "--format", "urdf,glb", "-o", tmp_path / "o")[0] == 0
    files = tree(tmp_path / "o")
    assert {"objects/000001/object.urdf", "objects/000001/object.glb"} <= set(files)
    assert not any(name.endswith(".npz") for name in files)


def test_values_are_set(apgc: Apgc, tmp_path: Path) -> None:
    fixed = [
        "--set",
        "width=45cm",
        "--set",
        "wood=pine",
        "--set",
        "knobs=3",
        "--set",
        "swing=90deg",
        "--set",
        "share=20%",
    ]
    assert apgc("sample", CHEST, "-n", 6, "-o", tmp_path / "o", *SMALL, *fixed)[0] == 0
    for annotation in annotations(tmp_path / "o"):
        drawn = annotation["drawn"]
        assert (drawn["width"], drawn["wood"], drawn["knobs"], drawn["share"]) == (0.45, "pine", 3, 0.2)
        assert drawn["swing"] == pytest.approx(np.pi / 2, abs=1e-8)
        assert drawn["height"] <= 0.8 * 0.45 + 1e-9


def test_only_picks_objects(apgc: Apgc, tmp_path: Path) -> None:
    assert apgc("sample", CHEST, "--only", "37,4..6", "-o", tmp_path / "o", *SMALL)[0] == 0
    assert [a["object"] for a in annotations(tmp_path / "o")] == [4, 5, 6, 37]


def test_statistics_name_the_line(apgc: Apgc, tmp_path: Path) -> None:
    program = tmp_path / "pair.apg"
    program.write_text(
        "apg 1\nuse primitives { Cuboid }\ncategory Pair {\n"
        "  param a : length in 1cm .. 9cm = 2cm\n  param b : length in 1cm .. 9cm = 2cm\n"
        '  require abs(a - b) <= 2cm else "the sides differ too much"\n'
        "  root part body : Cuboid(size = [a, b, 4cm])\n}\n"
    )
    code, out, _ = apgc("sample", program, "-n", 200, "-o", tmp_path / "o", "--points", 4, "--stats")
    assert code == 0 and "200 objects" in out
    counts = json.loads((tmp_path / "o" / "manifest.json").read_text())["counts"]
    if counts["first_valid"] < 200:  # the planner may have learnt to draw the second within reach of the first
        assert f"{program}:6: the sides differ too much" in out


def test_a_seed_gives_other_objects(apgc: Apgc, tmp_path: Path) -> None:
    for seed in (1, 2):
        apgc("sample", CHEST, "-n", 2, "--seed", seed, "-o", tmp_path / str(seed), *SMALL)
    assert annotations(tmp_path / "1")[0]["drawn"] != annotations(tmp_path / "2")[0]["drawn"]


WRONG = [
    (["--set", "widht=45cm"], 2, "did you mean `width`?"),
    (["--set", "width=45"], 2, "has no unit: `width` is a length"),
    (["--set", "width=45deg"], 2, "wrong unit"),
    (["--set", "width=45cmm"], 2, "`cmm` in width=45cmm is not a unit"),
    (["--set", "width=wide"], 2, "a number is needed"),
    (["--set", "width=4m"], 2, "30cm .. 60cm"),
    (["--set", "share=20cm"], 2, "a number without a unit"),
    (["--set", "width=nan"], 2, "a number is needed"),
    (["--set", "width=1e999m"], 2, "too large"),
    (["--set", "wood=teak"], 2, "one of oak, pine"),
    (["--set", "wood=pin"], 2, "did you mean `pine`?"),
    (["--set", "knobs=2.5"], 2, "not a whole number"),
    (["--set", "knobs=7"], 2, "1 .. 3"),
    (
        ["--set", "lid.at.z=3cm"],
        2,
        "`lid.at.z` follows from other values: it cannot be set\n  = help: set `height` or `share`, from which it follows",
    ),
    (["--set", "width"], 2, "sets nothing"),
    (["--set", "width=40cm", "--set", "width=50cm"], 2, "set twice"),
    (["--set", "width=30cm", "--set", "height=40cm"], 1, "chest.apg:"),
    (["-n", "0"], 2, "0 is not a number from 1"),
    (["-n", "-3"], 2, "-3"),
    (["-n", "many"], 2, "not a whole number"),
    (["-n", "999999999999"], 2, "999999999999"),
    (["--points", "0"], 2, "0"),
    (["--only", "5..3"], 2, "empty"),
    (["--only", "x"], 2, "not an object number"),
    (["--shard", "3/2"], 2, "2/8"),
    (["--format", "step"], 2, "the formats are points"),
    (["--frobnicate"], 2, "--frobnicate"),
]


@pytest.mark.parametrize("arguments, expected, message", WRONG, ids=[" ".join(w[0]) for w in WRONG])
def test_wrong_input(apgc: Apgc, tmp_path: Path, arguments: list[str], expected: int, message: str) -> None:
    code, out, err = apgc("sample", CHEST, "-o", tmp_path / "o", *arguments)
    assert (code, out) == (expected, "") and message in err
    assert not (tmp_path / "o" / "points-00000.npz").exists()


def test_no_valid_object_names_the_worst(apgc: Apgc, tmp_path: Path) -> None:
    fixed = ["--set", "width=30cm", "--set", "height=40cm"]
    code, _, err = apgc("sample", CHEST, "-n", 3, "-o", tmp_path / "o", *fixed)
    assert code == 1 and "no valid Chest exists with these settings" in err and "3 times: " in err and "`height`" in err


def test_unknown_category(apgc: Apgc) -> None:
    code, _, err = apgc("sample", "Microvave")
    assert code == 1 and "did you mean `Microwave`?" in err


def test_a_module_is_no_category(apgc: Apgc, tmp_path: Path) -> None:
    (tmp_path / "m.apg").write_text("apg 1\nlet size = 3cm\n")
    code, _, err = apgc("sample", tmp_path / "m.apg", "-o", tmp_path / "o")
    assert code == 1 and "no-category" in err


def test_a_file_in_the_way(apgc: Apgc, tmp_path: Path) -> None:
    (tmp_path / "o").write_text("mine")
    for out in ("o", "o/deeper"):
        code, _, err = apgc("sample", CHEST, "-o", tmp_path / out)
        assert code == 1 and "is a file: a folder is needed" in err
    assert (tmp_path / "o").read_text() == "mine"


def test_a_folder_that_cannot_be_written(apgc: Apgc) -> None:
    code, _, err = apgc("sample", CHEST, "-n", 1, "-o", "/proc/samples")
    assert code == 1 and "/proc/samples" in err and "help:" in err


def test_other_options_need_force(apgc: Apgc, tmp_path: Path) -> None:
    arguments = ["sample", CHEST, "-n", 3, "-o", tmp_path / "o", *SMALL]
    assert apgc(*arguments)[0] == 0
    code, _, err = apgc(*arguments, "--seed", 5)
    assert code == 1 and "the seed (0, now 5)" in err and "--force" in err
    assert apgc(*arguments, "--seed", 5, "--force")[0] == 0
    assert annotations(tmp_path / "o")[0]["seed"] == 5
    (tmp_path / "o" / "manifest.json").write_text("")  # as a machine leaves it that lost its power
    code, _, err = apgc(*arguments, "--seed", 6)
    assert code == 1 and "cannot read" in err and "--force" in err
    assert apgc(*arguments, "--seed", 6, "--force")[0] == 0
    assert annotations(tmp_path / "o")[0]["seed"] == 6


def test_numbers() -> None:
    assert numbers("3") == [3]
    assert numbers(" 7 , 2..4,3") == [2, 3, 4, 7]


# ---------------------------------------------------------------- render


def size(path: Path) -> tuple[int, int]:
    data = path.read_bytes()
    assert data[:8] == b"\x89PNG\r\n\x1a\n"
    return int.from_bytes(data[16:20], "big"), int.from_bytes(data[20:24], "big")


def test_render_draws_a_folder_again(apgc: Apgc, tmp_path: Path) -> None:
    apgc("sample", CHEST, "-n", 4, "--seed", 3, "-o", tmp_path / "o", *SMALL, "--set", "width=40cm")
    code, out, err = apgc("render", tmp_path / "o", "-o", tmp_path / "a.png", "--tile", 48)
    assert (code, out) == (0, "") and "drew 4 of Chest" in err
    assert size(tmp_path / "a.png")[0] % 48 == 0
    drawn = (tmp_path / "a.png").read_bytes()
    code, _, err = apgc("render", CHEST, "-n", 1, "-o", tmp_path / "a.png", "--tile", 48)
    assert code == 1 and "a.png exists" in err and (tmp_path / "a.png").read_bytes() == drawn
    assert apgc("render", tmp_path / "o", "-o", tmp_path / "a.png", "--tile", 48, "--force")[0] == 0
    same = ["render", CHEST, "--seed", 3, "--set", "width=40cm", "-n", 4, "--tile", 48]
    assert apgc(*same, "-o", tmp_path / "b.png")[0] == 0
    assert (tmp_path / "a.png").read_bytes() == (tmp_path / "b.png").read_bytes()


def test_render_open_and_by_material(apgc: Apgc, tmp_path: Path) -> None:
    pictures = []
    for more in ([], ["--open"], ["--colour", "material"]):
        path = tmp_path / f"{len(pictures)}.png"
        assert apgc("render", CHEST, "-n", 1, "--tile", 48, "-o", path, *more)[0] == 0
        pictures.append(path.read_bytes())
    assert len(set(pictures)) == 3


def test_a_moved_folder_finds_its_program(apgc: Apgc, tmp_path: Path) -> None:
    (tmp_path / "work").mkdir()
    program = tmp_path / "work" / "chest.apg"
    program.write_text(Path(CHEST).read_text())
    apgc("sample", program, "-n", 2, "-o", tmp_path / "work" / "o", *SMALL)
    (tmp_path / "work").rename(tmp_path / "elsewhere")
    assert apgc("render", tmp_path / "elsewhere" / "o", "-o", tmp_path / "s.png", "--tile", 48)[0] == 0
    assert str(tmp_path) not in (tmp_path / "elsewhere" / "o" / "manifest.json").read_text()


def test_a_program_that_is_gone_is_named_where_it_would_be(apgc: Apgc, tmp_path: Path) -> None:
    program = tmp_path / "own" / "chest.apg"
    program.parent.mkdir()
    program.write_text(Path(CHEST).read_text())
    apgc("sample", program, "-n", 1, "-o", tmp_path / "o", *SMALL)
    program.unlink()
    code, _, err = apgc("render", tmp_path / "o", "-o", tmp_path / "s.png", "--tile", 48)
    assert code == 1 and f"{tmp_path}/o/../own/chest.apg" in err


def test_render_of_a_changed_program(apgc: Apgc, tmp_path: Path) -> None:
    program = tmp_path / "chest.apg"
    program.write_text(Path(CHEST).read_text())
    apgc("sample", program, "-n", 2, "-o", tmp_path / "o", *SMALL)
    program.write_text(program.read_text().replace("0.8 * width", "0.7 * width"))
    code, _, err = apgc("render", tmp_path / "o", "-o", tmp_path / "s.png")
    assert code == 1 and "has changed since" in err and not (tmp_path / "s.png").exists()
    assert "artipg_dsl" not in err
    manifest = tmp_path / "o" / "manifest.json"
    manifest.write_text(manifest.read_text().replace(f'"artipg_dsl": "{__version__}"', '"artipg_dsl": "0.2.0"'))
    err = apgc("render", tmp_path / "o", "-o", tmp_path / "s.png")[2]
    assert f"artipg_dsl 0.2.0 made them, and this is {__version__}" in err and "in version 0.2.0, or make" in err


def test_wrong_render(apgc: Apgc, tmp_path: Path) -> None:
    code, _, err = apgc("render", tmp_path, "-o", tmp_path / "s.png")
    assert code == 1 and "has no manifest.json" in err
    code, _, err = apgc("render", CHEST, "-o", tmp_path / "s.jpg")
    assert code == 2 and ".png" in err
    apgc("sample", CHEST, "-n", 2, "-o", tmp_path / "o", *SMALL)
    code, _, err = apgc("render", tmp_path / "o", "--only", "9", "-o", tmp_path / "s.png")
    assert code == 1 and "there is no object 9" in err
    assert apgc("render", tmp_path / "o", "--seed", "9", "-o", tmp_path / "s.png")[0] == 2
    code, _, err = apgc("render", tmp_path / "o", "--view", "below", "-o", tmp_path / "s.png")
    assert code == 2 and "left, right, top" in err
    assert apgc("render", CHEST, "-o", "/proc/s.png", "-n", 1, "--tile", 16)[0] == 1


def test_wild_values_are_repaired_and_told(apgc: Apgc, tmp_path: Path) -> None:
    program = tmp_path / "pair.apg"
    program.write_text(
        "apg 1\nuse primitives { Cuboid }\ncategory Pair {\n  param a : length in 1cm .. 9cm = 2cm\n"
        '  param b : length in 1cm .. 9cm = 2cm\n  require b <= a + 2cm else "b is too long"\n'
        "  root part body : Cuboid(size = [a, b, 4cm])\n}\n"
    )
    wild = tmp_path / "wild.json"
    wild.write_text('[{"a": 1e300, "b": NaN}, {"a": "2cm", "b": -Infinity}, {"a": 0.03, "b": 0.08}]')
    code, out, err = apgc("sample", program, "--params", wild, "-o", tmp_path / "o", *SMALL, "--stats")
    assert code == 0 and "failed  repaired  rejected" in out
    assert "values of 3 of 3 objects were changed" in err and "`a` lies outside" in err and "1 other reason" in err
    assert re.search(rf"1 +1 +0  {re.escape(str(program))}:6: b is too long", out)
    repairs = [a["repairs"] for a in annotations(tmp_path / "o")]
    assert [[(r["path"], r["from"], r["how"]) for r in found] for found in repairs] == [
        [("a", 1e300, "clipped"), ("b", None, "redrawn")],
        [("b", -1.7976931348623157e308, "clipped")],
        [("b", 0.08, "clipped")],
    ]
    assert repairs[2][0] | {"where": None} == {
        "path": "b",
        "from": 0.08,
        "to": 0.05,
        "how": "clipped",
        "because": "b is too long (b <= a + 2cm)",
        "where": None,
    }
    assert repairs[2][0]["where"] == f"{program}:6:3"
    assert apgc("export", tmp_path / "o", "--format", "obj")[0] == 0  # from its manifest


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ('{"a": "wide"}', "`a` cannot be `wide`"),
        ('{"lid": "Cubiod"}', "`lid` cannot be `Cubiod`"),
        ('{"a": {"b": 1}}', "a number is needed"),
        ('{"q": 1}', "draws no `q`"),
        ('{"q": 1}', "these can be set: a, n, lid"),
        ('{"a": "5cm", "n": 2, "a": "6cm"}', "`a` is given twice in one object"),
        ('[{"a": "5cm"}, {"a": "5cm", "a": "6cm"}]', "`a` is given twice in one object"),
        ('{"n": 2.5}', "not a whole number"),
        ("{", "is not JSON"),
        ('{"a": "5cm"}\n\n{"a": 5cm}', "v.json:3:8: it is not JSON"),
        ('{"a": "5cm"}\n{"a": "5cm", "a": 5}', "`a` is given twice in one object"),
        ('{"lid": "Cu\u2028b"}\n{"a": "5cm"}', "`lid` cannot be `Cu"),
        ('[{"a": "5cm"},\n{"a": 5cm}]', "v.json:2:8: it is not JSON"),
        ('{\n  "a": "5cm",\n  "n" 2\n}', "v.json:3:7: it is not JSON"),
        ("\n", "holds no objects"),
        ('[{"a": "5cm"}, 3]', "v.json, object 1: 3 is no table of names and values"),
        ('{"a": "5kg"}', "wrong unit"),
    ],
)
def test_values_of_a_wrong_kind_are_errors(apgc: Apgc, tmp_path: Path, text: str, message: str) -> None:
    program = tmp_path / "p.apg"
    program.write_text(
        "apg 1\nuse primitives { Cuboid }\ncategory P {\n  param a : length in 1cm .. 9cm = 2cm\n  count n in 1 .. 3\n"
        "  root part body : Cuboid(size = [a, a, n * 1cm])\n"
        "  part lid : Cuboid(size = [a, a, 1cm]) | none\n  connect lid.bottom on body.top\n}\n"
    )
    (tmp_path / "v.json").write_text(text)
    code, _, err = apgc("sample", program, "--params", tmp_path / "v.json", "-o", tmp_path / "o", *SMALL)
    assert code in (1, 2) and message in err and not (tmp_path / "o").exists()


@pytest.mark.parametrize(
    ("values", "message", "hint"),
    [
        ('{"lid": "none", "edge": "1cm"}', "object 1 gives `edge`, which no object has with lid=none", "leave it out"),
        ('{"edge": "1cm"}', "object 1 gives `edge`, which no object has with lid=none", "give `lid`, too"),
        ('{"lid": "none", "edge": null}', "", ""),
        ('{"lid": "Cuboid", "edge": "1cm"}', "", ""),
    ],
)
def test_values_of_what_an_object_does_not_have_are_errors(
    apgc: Apgc, tmp_path: Path, values: str, message: str, hint: str
) -> None:
    program = tmp_path / "p.apg"
    program.write_text(
        "apg 1\nuse primitives { Cuboid }\ncategory P {\n  root part body : Cuboid(size = [5cm, 5cm, 5cm])\n"
        "  part lid : none weight 1000 | Cuboid(size = [5cm, 5cm, 1cm]) weight 1\n  connect lid.bottom on body.top\n"
        "  when lid {\n    param edge : length in 1cm .. 2cm\n"
        "    part rim : Cuboid(size = [edge, edge, 1cm])\n    connect rim.bottom on lid.top\n  }\n}\n"
    )
    (tmp_path / "v.json").write_text(f'[{{"lid": "Cuboid", "edge": "2cm"}}, {values}]')
    code, _, err = apgc("sample", program, "--params", tmp_path / "v.json", "-o", tmp_path / "o", *SMALL)
    assert message in err and hint in err and (code == 0) == (tmp_path / "o").exists() == (not message)


def test_values_are_looked_through_before_the_run(apgc: Apgc, tmp_path: Path) -> None:
    program, file = tmp_path / "p.apg", tmp_path / "v.jsonl"
    program.write_text(
        "apg 1\nuse primitives { Cuboid }\ncategory P {\n  count n in 1 .. 3\n"
        "  repeat row[i] in 0 ..< n {\n    param edge : length in 1cm .. 2cm\n  }\n"
        "  root part body : Cuboid(size = [1cm, 1cm, n * 1cm])\n}\n"
    )
    file.write_text('{"n": 2}\n' * 300 + '{"n": 2, "row.edge": [0.01, 0.01, 0.01]}\n')
    code, _, err = apgc("sample", program, "--params", file, "-o", tmp_path / "o", *SMALL)
    assert code == 1 and f"{file}: object 300 gives 3 values of `row.edge`, but has 2" in err
    assert not (tmp_path / "o").exists()


CANS = """apg 1
use primitives { Cuboid }
category Cans {
  param gap : length in 1cm .. 10cm
  param high : length in 1cm .. 3cm
  root part body : Cuboid(size = [10cm, 4cm, 4cm])
  part first : Cuboid(size = [6cm, 4cm, high])
  part second : Cuboid(size = [6cm, 4cm, 4cm])
  joint one : prismatic body.top -> first.bottom at center gap 1mm along x range 0 .. 1cm
  joint two : prismatic body.top -> second.bottom gap 1mm at y = PLACE, x = 0 along x range 0 .. 1cm
}
"""


@pytest.mark.parametrize(
    ("place", "told"),
    [
        ("gap", "without `gap=2cm`, 19 % of the first attempts are valid: choose another value"),
        ("1cm", "leave a gap between links"),  # whatever is set
    ],
)
@pytest.mark.parametrize("command", ["sample", "validate"])
def test_settings_that_make_parts_collide_are_told(apgc, tmp_path, place, told, command):
    program = tmp_path / "cans.apg"
    program.write_text(CANS.replace("PLACE", place))
    where = ("-o", tmp_path / "o") if command == "sample" else ()
    code, out, err = apgc(command, program, "-n", 3, "--set", "gap=2cm", "--set", "high=2cm", *where)
    assert code == 1 and told in out + err and "first and second collide" in out + err
