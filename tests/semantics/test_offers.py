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
        ("label semantic.body on body", "bring it in: `use vocabularies { semantic }`"),
        ("label mine.body on body", "declare it: `vocabulary mine { body }`"),
    ],
)
def test_hint(statement: str, hint: str) -> None:
    session = Session.of_text(PROGRAM.format(statement))
    assert session.typed is None or session.report.failed
    assert hint in [d.hint for d in session.report.diagnostics]
