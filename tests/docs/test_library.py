"""`docs/library.md` is what the texts of the library say, and each of its declarations says what it is."""

from __future__ import annotations

from collections import Counter
from pathlib import Path

from artipg_dsl.resources import library_dir
from artipg_dsl.semantics.offers import DECLARED

from .library_index import SOUGHT, entries, materials, page

PAGE = Path(__file__).parents[2] / "docs" / "library.md"


def test_the_page_is_up_to_date(update_golden: bool) -> None:
    current = page()
    if update_golden:
        PAGE.write_text(current, encoding="utf-8")
    assert PAGE.read_text(encoding="utf-8") == current, "run pytest tests/docs/test_library.py --update-golden"


def test_everything_says_what_it_is() -> None:
    assert [f"{e.module}.{e.name}" for e in entries() if not e.doc] == []


def test_a_name_is_declared_in_one_module() -> None:
    """Whoever misses a name is told which module to import it from."""
    declared = Counter(
        word for path in library_dir().glob("*.apg") for _, word in DECLARED.findall(path.read_text(encoding="utf-8"))
    )
    assert [word for word, modules in declared.items() if modules > 1] == []


def test_whatever_is_sought_is_found() -> None:
    known = list(entries())
    for title, words in SOUGHT.items():
        assert any(e.words & set(words.split()) for e in known), title


def test_a_parameter_is_shown_with_its_type_range_and_default() -> None:
    text = PAGE.read_text(encoding="utf-8")
    assert "| `BracketHandle` | `Handle` | `thickness` in 8mm .. 14mm = 10mm" in text
    assert "| `Handle` | role | `size` (three lengths) in [34mm, 1cm, 3cm] .. [6cm, 3cm, 40cm] |" in text


def test_what_can_be_named_from_outside_is_shown() -> None:
    """Whoever places a template, or labels a piece of it, finds the names on the page."""
    lines = {line.split("`")[1]: line for line in page().splitlines() if line.startswith("| `")}
    assert "| port `mount`; slot `grip` |" in lines["Handle"]
    assert "| slot `leaf`; joint `motion` |" in lines["Closed"] and "| role, a `Front` |" in lines["Closed"]
    assert "| port `inner` |" in lines["OpenBox"]


def test_all_materials_are_listed() -> None:
    text = PAGE.read_text(encoding="utf-8")
    assert "| `oak` | `materials` | " in text and "| `brown_leather` | `knives` | " in text
    assert "| `chrome` | `materials` | 7150 .. 7190 | `#e0e3e3` | metal |" in text
    texts = [path.read_text(encoding="utf-8") for path in library_dir().glob("*.apg")]
    declared = {word for text in texts for kind, word in DECLARED.findall(text) if kind == "material"}
    assert declared == {node.name for _, node in materials()} and len(declared) > 100
