"""What is wrong with a system of equations, in words: the statements, the guard and the degree of freedom."""

from __future__ import annotations

import pytest

from .test_solve import HEAD, PAIR, Session, category

SOLID = "  part a : Cuboid(size = [1cm, 1cm, 1cm])\n  connect a to body\n"
OPEN = "  part a : Cuboid(size = [1cm, _, 1cm])\n  connect a to body\n"
CHOICE = "  param k : choice one | two | three = one\n"
PLACE = "the position of `a` along y"


@pytest.mark.parametrize(
    ("body", "code", "message", "lines"),
    [
        (
            SOLID + "  align a.left = body.left\n  align a.left = body.left + 1cm",
            "contradictory",
            "this equation contradicts the others: its two sides always differ by 10mm",
            {9: "", 8: f"determines {PLACE}"},
        ),
        (
            CHOICE + SOLID + "  when k == one {\n    align a.left = body.left\n    align a.left = body.left + 1cm\n  }",
            "contradictory",
            "this equation contradicts the others where k = one: its two sides always differ by 10mm",
            {11: "", 10: f"determines {PLACE}"},
        ),
        (
            CHOICE + SOLID + "  align a.left = body.left\n  when k == two { align a.right = body.right - w / 2 }",
            "over-determined",
            f"this equation is one too many where k = two: {PLACE} is already determined",
            {10: "", 9: f"determines {PLACE}"},
        ),
        (
            CHOICE + SOLID + "  align a.left = body.left\n  when k == one { } else { align body.left = a.left }",
            "redundant",
            "this equation follows from the others where k is not one",
            {10: "", 9: f"determines {PLACE}"},
        ),
        (
            OPEN + "  align a.left = body.left\n  align 2 * body.left = 2 * a.left",
            "not-solvable",
            f"these equations are equivalent for `a.size.y` and {PLACE}: one more is needed",
            {8: "", 9: "together with this"},
        ),
        (
            OPEN + "  align a.left = body.left\n  align a.left = body.left + 2mm",
            "contradictory",
            "this equation contradicts the others: its two sides always differ by 2mm",
            {8: "the other", 9: ""},
        ),
        (OPEN, "under-determined", "nothing determines the size of `a` along y (`a.size.y`)", {6: ""}),
        (
            OPEN.replace("_", "d").replace("  part", "  param d : length derived\n  part", 1)
            + CHOICE
            + "  when k == two { align d = w / 2 }",
            "under-determined",
            "nothing determines `d` where k is not two",
            {6: "", 10: "determines it, but only under a guard"},
        ),
        (
            SOLID + SOLID.replace("a ", "b ") + "  align a.left = b.left + 1cm\n  align a.right = b.right + w",
            "not-solvable",
            f"these equations only place {PLACE} and the position of `b` along y relative to one another: nothing ties them to the rest",
            {10: "", 11: "together with this"},
        ),
    ],
    ids=[
        "contradiction",
        "contradiction under a guard",
        "one too many",
        "redundant in the else",
        "the same twice",
        "a contradiction of an open size",
        "an open size",
        "open in the other case",
        "afloat together",
    ],
)
def test_a_finding_names_statements_guard_and_degree(body: str, code: str, message: str, lines: dict[int, str]) -> None:
    session = Session.of_text(HEAD + category(body))
    _ = session.lowering
    found = next(d for d in session.report.diagnostics if d.code == code)
    assert found.message == message and found.hint
    told = {span.line: text for span, text in found.notes}
    assert found.span is not None and {found.span.line: "", **told}.items() >= lines.items()


def test_a_tie_under_a_guard_names_it_and_both_parameters() -> None:
    body = CHOICE + "  part a : Pair\n  connect a to body\n  when k == one { align a.long + a.wide = 6cm }"
    session = Session.of_text(HEAD + PAIR + category(body))
    assert session.lowering is None
    (found,) = session.report.diagnostics
    assert found.message == "this could determine `a.long` or `a.wide` where k = one: nothing says which"


@pytest.mark.parametrize("count", [3, 8, 9])
def test_large_coupled_blocks_end_in_an_answer_or_an_error(count: int) -> None:
    """A ring of coupled curves: up to eight unknowns are searched for together, more are an error in words."""
    names = [f"x{k}" for k in range(count)]
    body = "".join(f"  param {n} : length in 1cm .. 90cm derived\n" for n in names)
    for n, m in zip(names, [*names[1:], names[0]], strict=True):
        body += f"  align {n} + 2cm * sin({n} * 10rad / 1m + {m} * 3rad / 1m) = w + {m} * {m} / 10m\n"
    session = Session.of_text(
        HEAD + category(body + "  part p : Cuboid(size = [x0, x1, x2])\n  connect p.back on body.front")
    )
    if count > 8:
        assert session.lowering is None and [d.code for d in session.report.diagnostics] == ["not-solvable"]
    else:
        assert session.lowering is not None
        assert (session.sampler.batch(range(20), seed=1).state.attempt == 0).all()  # type: ignore[arg-type]
