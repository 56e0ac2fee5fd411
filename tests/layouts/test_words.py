"""Every shipped category is in each vocabulary or is said not to be: a new one cannot be forgotten."""

from __future__ import annotations

import json
import re
from importlib import resources

import pytest

from artipg_dsl.layouts.registry import LAYOUTS
from artipg_dsl.layouts.words import vocabulary
from artipg_dsl.resources import categories_dir

_WORDS = resources.files("artipg_dsl.layouts").joinpath("words")
VOCABULARIES = sorted(path.name.removesuffix(".json") for path in _WORDS.iterdir() if path.name.endswith(".json"))
SHIPPED = sorted(
    name
    for path in categories_dir().glob("*.apg")
    for name in re.findall(r"^category (\w+)", path.read_text(encoding="utf-8"), re.M)
)
PATHS = json.loads(resources.files("artipg_dsl.export.partnet").joinpath("paths.json").read_text(encoding="utf-8"))


@pytest.mark.parametrize("name", VOCABULARIES)
def test_every_category_is_mapped_or_said_to_have_no_class(name: str) -> None:
    """One that is neither is a category that somebody added: map it, or add it to `none` of the file."""
    known = vocabulary(name)
    mapped = set(known.categories) | (set(known.classes) & set(PATHS) if name == "partnet" else set())
    assert not mapped & set(known.none), "both mapped and without a class"
    forgotten = [category for category in SHIPPED if category not in mapped | set(known.none)]
    assert not forgotten, f"words/{name}.json says nothing of {', '.join(forgotten)}"
    assert {entry["class"] for entry in known.categories.values()} <= set(known.classes)
    assert set(known.near.values()) <= set(known.classes)


@pytest.mark.parametrize("layout", [entry.name for entry in LAYOUTS.values() if entry.vocabulary])
def test_maps_are_in_the_words_of_both_sides(layout: str) -> None:
    """Parts are those of the class; words of shipped categories are those of the vocabulary that they are labelled with."""
    own = categories_dir().parent / "library" / "vocabularies.apg"
    said = re.search(r"vocabulary semantic \{(.*?)\}", own.read_text(encoding="utf-8"), re.S)
    assert said is not None
    words = set(said[1].split()) | {"*"}
    known = vocabulary(LAYOUTS[layout].vocabulary)
    for category in known.categories:
        term = LAYOUTS[layout].term(category)
        assert term is not None
        for key in term.parts if category in SHIPPED else ():
            link, _, rest = key.partition("/")
            assert link in words, f"{category}: {key}"
            assert rest in {"", "revolute", "continuous", "prismatic", "screw", "ball"} | words, f"{category}: {key}"


def test_levels_of_partnet_and_paths_of_its_trees_agree() -> None:
    """A category with levels has paths, and most of its words lie in a class of the first level."""
    known = vocabulary("partnet")
    assert set(known.classes) == set(PATHS) - {"about"}
    for category, own in known.classes.items():
        coarse = own["levels"].get("1") or own["levels"]["3"]
        for case in PATHS[category]:
            full = [f"{case['root']}/{path}/".replace("|", "/") for path in case["paths"].values()]
            placed = [path for path in full if any(path.startswith(f"{name}/") for name in coarse)]
            assert 2 * len(placed) > len(full), f"{category}: {sorted(set(full) - set(placed))}"


PAGE = (categories_dir().parent / "docs" / "layouts.md").read_text(encoding="utf-8")


def test_the_page_names_the_categories_that_layouts_take() -> None:
    """Those of a closed vocabulary that are shipped; a row that says `the same` repeats the one above."""
    named: list[str] = []
    rows = re.findall(r"^\| `([\w-]+)` \|.*\| ([^|]+) \|$", PAGE, re.M)
    assert {layout for layout, _ in rows} == set(LAYOUTS)
    for layout, text in rows:
        if text != "the same":
            named = text.partition(";")[0].rpartition(": ")[2].split(", ")
        if LAYOUTS[layout].vocabulary:
            assert named == sorted(set(vocabulary(LAYOUTS[layout].vocabulary).categories) & set(SHIPPED)), layout


def test_the_page_names_the_levels_of_partnet() -> None:
    (found,) = re.findall(r"^\* Levels: (.*?)\. A\s+category", PAGE, re.M | re.DOTALL)
    text = " ".join(found.split())
    named = {
        name: levels.split(", ")
        for levels, _, names in (row.partition(" of ") for row in text.split("; "))
        for name in names.split(", ")
    }
    assert named == {name: sorted(own["levels"]) for name, own in vocabulary("partnet").classes.items()}
