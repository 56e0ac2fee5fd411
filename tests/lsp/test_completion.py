"""What may be written at a place."""

import pytest

from artipg_dsl.lsp.completion import complete

LAST = "label semantic.shelf on shelf\n"
CASES = [  # a line that is being typed, what is offered among others, what is not
    ("align back.|", {"front", "center", "size"}, {"height", "align"}),
    ("align shelf.|", {"depth", "edge", "plank", "top"}, {"height"}),
    ("align leg[0].|", {"post", "aside", "top"}, {"depth"}),
    ("align leg[last].post.|", {"size", "top"}, {"aside"}),
    ("align back.top = shelf.plank.size.|", {"x", "y", "z"}, {"top"}),
    ("label semantic.|", {"shelf", "leg", "door"}, {"pull", "height"}),
    ("label affordance.pu|", {"push", "pull"}, {"leg"}),
    ("part more : Board(|", {"depth", "holes", "height"}, {"plank", "align"}),
    ("part more : Bo|", {"Board", "Cuboid"}, {"align"}),
    ("joint more : |", {"revolute", "prismatic"}, {"height", "length"}),
    ("joint more : revolute shelf -> back |", {"about", "range", "rest"}, set()),
    ("param more : |", {"length", "choice"}, {"height", "revolute"}),
    ("let more = hei|", {"height", "min", "pi"}, {"about"}),
    ("|", {"part", "joint", "when", "let"}, {"height", "category"}),
    ("# hei|", set(), {"height"}),
    ('require height > 1cm else "hei|', set(), {"height"}),
]


@pytest.mark.parametrize("line, some, none", CASES)
def test_what_may_follow(texts, line, some, none):
    analysis, offset = texts.at(LAST, f"{line}\n  {LAST}")
    names = [suggestion.name for suggestion in complete(analysis, offset)]
    assert some <= set(names) and not none & set(names)
    assert len(names) == len(set(names)) and (some or not names)


def test_parameters_come_before_what_else_a_value_may_name(texts):
    analysis, offset = texts.at("Board(depth = 28cm)", "Board(|)")
    assert [s.name for s in complete(analysis, offset)][:2] == ["depth", "holes"]


def test_what_stands_in_a_repeat_is_offered_there_alone(texts):
    within, outside = texts.at("y + aside", "y + |"), texts.at("align back.back = shelf.back", "let more = |")
    assert "aside" in {s.name for s in complete(*within)}
    assert "aside" not in {s.name for s in complete(*outside)}


@pytest.mark.parametrize(
    "new, some", [("use |\nuse shelves", {"shelves", "stand", "handles"}), ("use shelves { |", {"Board"})]
)
def test_modules_and_what_they_declare(texts, new, some):
    offered = {s.name for s in complete(*texts.at("use shelves", new))}
    assert some <= offered and "part" not in offered


def test_a_file_begins_with_declarations(texts):
    offered = {s.name for s in complete(*texts.at("category Stand", "|\ncategory Stand"))}
    assert {"template", "use", "material"} <= offered and "part" not in offered
