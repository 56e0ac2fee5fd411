"""``apgc report``."""

from __future__ import annotations

import json
from html.parser import HTMLParser
from pathlib import Path

import pytest

from artipg_dsl.quality.text import HEAD
from artipg_dsl.session import categories

from .helpers import CHEST, ROOT, Apgc, spawn


def test_the_card_in_words(apgc: Apgc) -> None:
    code, out, _ = apgc("report", CHEST, "-n", 30, "--seed", 3)
    assert code == 0
    names = [line[:18].strip() for line in out.splitlines()[1:] if not line.startswith("    ")]
    assert names == [
        "valid",
        "graphs",
        "edit distance",
        "joints",
        "duplicates",
        "pairs",
        "sizes",
        "dead parameters",
        "dead alternatives",
        "dead labels",
        "lines",
    ]
    assert out.startswith("Chest: 30 objects, seed 3\n")
    assert "goal >= 99%: met" in out and "nothing is known of real ones" in out


def test_the_card_as_json_is_the_same_each_time(apgc: Apgc) -> None:
    first = apgc("report", CHEST, "-n", 20, "--json")[1]
    found = json.loads(first)
    assert list(found) == [
        "version",
        "category",
        "program",
        "seed",
        "objects",
        "checked",
        "valid",
        "graphs",
        "duplicates",
        "pairs",
        "sizes",
        "variants",
        "dead",
        "meshes",
        "lines",
        "goals",
        "met",
    ]
    assert found["meshes"] is None
    assert (found["category"], found["objects"], found["checked"]) == ("Chest", 20, True)
    assert found["valid"]["first"] == 20 and found["valid"]["share"] == 1.0
    assert sum(kind["objects"] for kind in found["graphs"]["kinds"]) == 20
    assert spawn("report", CHEST, "-n", "20", "--json", hash_seed="5").stdout == first


def test_the_meshes_of_the_first_objects_are_a_figure_too(apgc: Apgc) -> None:
    asked = ("report", CHEST, "-n", 6, "--meshes", 2)
    out = apgc(*asked)[1]
    assert "100% of 2 apart in every state (100% at rest, 100% while each joint moves)  goal >= 99%: met" in out
    seen, alone = (
        json.loads(apgc(*asked, "--json")[1]),
        json.loads(apgc("validate", CHEST, "-n", 2, "--meshes", "--json")[1]),
    )
    assert seen["meshes"] == {**alone["meshes"], "share": 1.0}
    head, _, row, *_ = apgc(*asked, "--markdown")[1].splitlines()
    assert head.endswith("| meshes apart |") and row.endswith("| 100% of 2 |")


def test_goals_decide_the_exit_code_where_that_is_asked_for(apgc: Apgc, tmp_path: Path) -> None:
    real = tmp_path / "real.json"
    real.write_text(json.dumps({"categories": {"Chest": {"height": [5, 6, 7], "graphs": 9, "why": "so be it"}}}))
    code, out, _ = apgc("report", CHEST, "-n", 10, "--reference", real)
    assert code == 0 and "goal >= 9: NOT MET" in out and "so be it" in out and "height 0%" in out
    assert apgc("report", CHEST, "-n", 10, "--reference", real, "--strict")[0] == 1


def _known(folder: Path, **entry: object) -> Path:
    """A file of what is known of real chests."""
    file = folder / "known.json"
    file.write_text(json.dumps({"categories": {"Chest": entry}}))
    return file


def test_variants_are_counted_and_tried(apgc: Apgc, tmp_path: Path) -> None:
    models = {"oak, three knobs": {"wood": "oak", "knobs": 3}, "of pine": {"wood": "pine"}, "tall": {"share": 0.12345}}
    known = _known(tmp_path, variants=models)
    asked = ("report", CHEST, "-n", 20, "--unchecked", "--reference", known)
    found = json.loads(apgc(*asked, "--json")[1])
    oak, pine, tall = found["variants"]["list"]
    assert (found["variants"]["seen"], found["variants"]["known"]) == (2, 3)
    assert oak == {"name": "oak, three knobs", "settings": "wood=oak knobs=3", "objects": oak["objects"], "refused": ""}
    assert 0 < oak["objects"] < 20 - pine["objects"] and (tall["objects"], tall["refused"]) == (0, "")
    assert {"figure": "variants", "goal": "all", "met": False} in found["goals"]
    out = apgc(*asked)[1]
    assert "2 of 3 seen  goal all: NOT MET" in out and "not seen: tall (share=0.12345)" in out
    assert "| 2 of 3 |" in apgc(*asked, "--markdown")[1]
    fixed = json.loads(apgc(*asked, "--set", "wood=oak", "--json")[1])
    assert [v["name"] for v in fixed["variants"]["list"]] == ["oak, three knobs", "tall"]


def test_a_card_says_by_which_prior_it_is(apgc: Apgc, tmp_path: Path) -> None:
    prior = tmp_path / "own.json"
    prior.write_text('{"draws": {"Chest": {"wood": {"oak": 1}}}}')
    models = {"of oak": {"wood": "oak"}, "of pine": {"wood": "pine"}}
    asked = ("report", CHEST, "-n", 12, "--unchecked", "--reference", _known(tmp_path, variants=models))
    assert "drawn by the prior own.json (wood)" in apgc(*asked, "--prior", prior)[1].split("\n")[0]
    found, plain = (json.loads(apgc(*asked, *more, "--json")[1]) for more in (("--prior", prior), ()))
    assert found["prior"] == "own.json (wood)" and "prior" not in plain
    assert [v["name"] for v in found["variants"]["list"]] == ["of oak"]  # what it leaves out is no fault


def test_a_variant_that_its_settings_do_not_reach_is_told(apgc: Apgc, tmp_path: Path) -> None:
    file = tmp_path / "box.apg"
    file.write_text("""apg 1
use primitives { Cuboid, Cylinder }
category Box {
  count n in 1 .. 2
  root part body : Cuboid(size = [10cm, 10cm, 10cm])
  part top : Cuboid(size = [1cm, 1cm, 1cm]) weight 0 | Cylinder(radius = 1cm, height = 1cm) | none
  connect top.bottom on body.top
  when top is Cylinder { count m in 1 .. 2  require n == m else "as many" }
  when top is Cuboid { count k in 1 .. 2 }
}
""")
    known = tmp_path / "known.json"
    impossible, absent = {"n": 1, "m": 2, "top": "Cylinder"}, {"k": 1}
    known.write_text(json.dumps({"categories": {"Box": {"variants": {"odd": impossible, "never": absent}}}}))
    out = apgc("report", file, "-n", 9, "--reference", known)[1]
    assert "--set does not reach odd (n=1 m=2 top=Cylinder): it leaves no valid object" in out
    assert "--set does not reach never (k=1): it has no effect" in out and "0 of 2 seen" in out
    known.write_text(json.dumps({"categories": {"Box": {"variants": {"bare": {"m": 1, "top": "none"}}}}}))
    code, out, err = apgc("report", file, "-n", 9, "--reference", known)
    assert (code, out) == (1, "")
    assert "the variant `bare` of Box cannot be set: no object has `m` with top=none" in err


def test_ratios_stand_beside_real_ones(apgc: Apgc, tmp_path: Path) -> None:
    known = _known(tmp_path, **{"width/height": [0.1, 1, 9], "depth/height": [0.01, 0.02, 0.03], "source": "a shop"})
    asked = ("report", CHEST, "-n", 10, "--unchecked", "--reference", known)
    out = apgc(*asked)[1]
    assert "width/height 100%, depth/height 0%  goal >= 80% of each: NOT MET" in out
    wide, deep = json.loads(apgc(*asked, "--json")[1])["sizes"]["ratios"]
    assert wide["within"] == 1.0 and deep["within"] == 0.0 and wide["real"] == [0.1, 1, 9]
    assert "| 100, 0% |" in apgc(*asked, "--markdown")[1]


@pytest.mark.parametrize(
    "entry, words",
    [
        ({"variants": {"gold": {"legs": 3}}}, ("the variant `gold` of Chest cannot be set", "draws no `legs`")),
        ({"variants": {"gold": {"wood": "gold"}}}, ("cannot be `gold`: it is one of oak, pine",)),
        ({"variants": {"gold": {"wood": ["oak"]}}}, ("the variant `gold` is not a table of settings",)),
        ({"variants": {"gold": 3}}, ("the variant `gold` is not a table of settings",)),
        ({"variants": ["gold"]}, ("`variants` is not a table",)),
        ({"width/height": [3, 2, 1]}, ("width/height is not three rising ratios",)),
        ({"wdth": [1, 2, 3]}, ("there is no `wdth`", "did you mean `width`?")),
        ({"width": 3}, ("width is not a list of three numbers",)),
        ({"width": [1, "2", 3]}, ("width is not a list of three numbers",)),
    ],
)
def test_what_is_wrong_in_what_is_known_is_told(apgc: Apgc, tmp_path: Path, entry: dict, words: tuple) -> None:
    code, _, err = apgc("report", CHEST, "-n", 3, "--unchecked", "--reference", _known(tmp_path, **entry))
    assert code != 0 and all(word in err for word in words), err


@pytest.mark.parametrize("text", ["[]", "3", '{"Chest": {}}', '{"categories": []}', '{"categories": {"Chest": 3}}'])
def test_a_file_of_another_form_is_told(apgc: Apgc, tmp_path: Path, text: str) -> None:
    (tmp_path / "known.json").write_text(text)
    code, _, err = apgc("report", CHEST, "-n", 3, "--unchecked", "--reference", tmp_path / "known.json")
    assert code == 1 and ('it has no table "categories"' in err or "the entry of Chest is not a table" in err), err


def test_what_says_nothing_of_the_category_is_told(apgc: Apgc, tmp_path: Path) -> None:
    file = tmp_path / "known.json"
    file.write_text(json.dumps({"categories": {"Chests": {"source": "a shop"}}}))
    code, _, err = apgc("report", CHEST, "-n", 3, "--unchecked", "--reference", file)
    assert code == 0 and "says nothing of Chest: did you mean `Chests`?" in err


@pytest.mark.slow
def test_a_table_of_several(apgc: Apgc) -> None:
    arguments = ("report", CHEST, CHEST, "-n", 5, "--markdown", "--unchecked")
    code, out, _ = apgc(*arguments)
    assert code == 0
    assert apgc(*arguments, "--workers", 2) == (code, out, "")
    head, line, first, second, *rest = out.splitlines()
    assert head.count("|") == line.count("|") == first.count("|") and first == second
    assert first.startswith("| Chest | 100.0% |")
    assert rest == ["", "All goals are met."] or rest[1].startswith("Goals not met: Chest, ")


def test_the_page_of_the_categories_has_a_row_and_a_picture_of_each() -> None:
    page = (ROOT / "docs" / "categories.md").read_text()
    rows = [line.split("|")[1].strip() for line in page.splitlines() if line.startswith("| ")]
    assert rows == ["category", *categories()]
    assert "| " + " | ".join(HEAD) + " |" in page
    assert all(f"gallery/{path.stem}.webp" in page for path in categories().values())


class Page(HTMLParser):
    def __init__(self) -> None:
        super().__init__()
        self.seen: list[str] = []
        self.sources: list[str] = []

    def handle_starttag(self, tag: str, attrs: list) -> None:
        self.seen.append(tag)
        self.sources += [value for name, value in attrs if name in ("src", "href")]


def test_the_page_holds_all_it_needs(apgc: Apgc, tmp_path: Path) -> None:
    file = tmp_path / "chest.html"
    assert apgc("report", CHEST, "-n", 6, "--html", file)[0] == 0
    page = Page()
    page.feed(file.read_text())
    assert page.seen.count("h1") == 1 and page.seen.count("tr") >= 10
    assert len(page.sources) == 1 and page.sources[0].startswith("data:image/png;base64,")
    code, _, err = apgc("report", CHEST, "-n", 6, "--html", file)
    assert code == 1 and "exists" in err
    assert apgc("report", CHEST, "-n", 6, "--html", file, "--force")[0] == 0


@pytest.mark.parametrize(
    "arguments, code, word",
    [
        ((), 2, "no category is named"),
        (("--all", "Microwave"), 2, "--all"),
        (("--all", "--set", "width=3cm"), 2, "name the category"),
        (("--all", "--prior", "partnet"), 2, "name those that it speaks of"),
        ((CHEST, "--prior", "partnet"), 1, "says nothing of Chest"),
        (("Chestt",), 1, "there is no category"),
        ((CHEST, "--set", "nothing=3"), 2, "nothing"),
        ((CHEST, "--reference", "absent.json"), 1, "absent.json"),
        ((CHEST, "-n", "0"), 2, "0"),
        ((CHEST, "--json", "--markdown"), 2, "not allowed"),
    ],
)
def test_what_cannot_be_reported_is_told(arguments: tuple, code: int, word: str, apgc: Apgc) -> None:
    found, _, err = apgc("report", *arguments)
    assert found == code and word in err
