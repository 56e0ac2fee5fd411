"""What is not imported is found in the library."""

from __future__ import annotations

import pytest

from artipg_dsl.session import Session

PROGRAM = """apg 1
use primitives {{ Cuboid }}
category Thing {{
  root part body : Cuboid(size = [1cm, 1cm, 1cm])
  {}
}}
"""


def test_an_import_that_is_not_there_is_told_with_what_is_of_its_kind() -> None:
    session = Session.of_text(PROGRAM.format("").replace("1\n", "1\nuse materials { brushed_steel }\n", 1))
    assert session.typed is None or session.report.failed
    (found,) = (d for d in session.report.diagnostics if d.code == "unknown-import")
    assert found.hint == "did you mean `steel`, `black_steel`, `clad_steel` or `steel_tube`?"


@pytest.mark.parametrize(
    "statement, hint",
    [
        ("part leg : Cylinder(radius = 1cm, height = 1cm)", "bring it in: `use primitives { Cylinder }`"),
        (
            "part leg : Cylindre(radius = 1cm, height = 1cm)",
            "did you mean `Cylinder`? bring it in: `use primitives { Cylinder }`",
        ),
        ("part leg : Cubiod(size = [1cm, 1cm, 1cm])", "did you mean `Cuboid`?"),
        ("part pull : Handle = Cuboid", "bring it in: `use handles { Handle }`"),
        ("style pull : Handle = Cuboid", "bring it in: `use handles { Handle }`"),
        ("when body is BarHandle { }", "bring it in: `use handles { BarHandle }`"),
        ("material oak on body", "bring it in: `use materials { oak }`"),
        ("material oaak on body", "did you mean `oak`? bring it in: `use materials { oak }`"),
        (
            "material brushed_steel on body",
            "did you mean `steel`, `black_steel`, `clad_steel` or `steel_tube`? "
            "bring it in, as in `use materials { steel }`",
        ),
        ("label semantic.body on body", "bring it in: `use vocabularies { semantic }`"),
        ("label mine.body on body", "declare it: `vocabulary mine { body }`"),
    ],
)
def test_hint(statement: str, hint: str) -> None:
    session = Session.of_text(PROGRAM.format(statement))
    assert session.typed is None or session.report.failed
    assert hint in [d.hint for d in session.report.diagnostics]
