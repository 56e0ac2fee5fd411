"""`check` warns of ranges whose ends have different units, one of them probably a wrong one."""

import pytest

from artipg_dsl.session import Session

TEXT = """apg 1
use primitives {{ Cuboid }}
category Stool {{
  param a : {}
  root part seat : Cuboid(size = {})
}}
"""


@pytest.mark.parametrize(
    ("declared", "meant"),
    [
        ("length in 40mm .. 60cm = 50cm", "`40cm .. 60cm`"),
        ("length in 14mm .. 20cm = 16mm", "`14mm .. 20mm`"),
        ("length in 1.5mm .. 4cm ~ normal(3mm, 1mm)", "`1.5mm .. 4mm`"),
        ("length in 18mm .. 28cm", "`18mm .. 28mm` or `18cm .. 28cm`"),
        ("length[3] in [10mm, 1cm, 1cm] .. [20cm, 2cm, 4cm] = [15cm, 15mm, 2cm]", "`10cm .. 20cm`"),
        ("length in 1mm .. 3cm = 5mm", None),
        ("length in 20mm .. 200mm = 30mm", None),
        ("length in 5mm .. 6cm", None),
        ("length in 35mm .. 14cm", None),
    ],
)
def test_a_range_in_two_units(declared: str, meant: str | None) -> None:
    session = Session.of_text(TEXT.format(declared, "a" if "[3]" in declared else "[a, a, a]"))
    session.advise()
    assert not session.report.failed
    found = [d for d in session.report.diagnostics if d.code == "mixed-units"]
    assert len(found) == (meant is not None)
    for one in found:
        assert one.span is not None and one.span.text.startswith(declared.split(" in ")[1].strip("[")[:4])
        assert f"Write {meant};" in str(one.hint)


@pytest.mark.parametrize(
    ("declared", "meant"),
    [
        ("length in 3cm .. 45cm = 37mm", "`37cm`; if it is right, write `3.7cm`"),
        ("length in 5mm .. 21cm = 20cm", None),
        ("length in 4mm .. 210mm = 20cm", "`20mm`; if it is right, write `200mm`"),
        (
            "length[3] in [3cm, 1cm, 1cm] .. [45cm, 2cm, 4cm] = [37mm, 15mm, 2cm]",
            "`37cm`; if it is right, write `3.7cm`",
        ),
        ("length in 0mm .. 35mm = 2cm", None),  # in the middle
        ("length in 3cm .. 45cm = 55mm", None),  # 55cm would be too much
        ("length in 3cm .. 45cm = 3cm", None),
    ],
)
def test_a_default_in_another_unit(declared: str, meant: str | None) -> None:
    session = Session.of_text(TEXT.format(declared, "a" if "[3]" in declared else "[a, a, a]"))
    session.advise()
    assert not session.report.failed
    found = [d for d in session.report.diagnostics if d.code == "mixed-units" and "beside" in d.message]
    assert [str(one.hint).removeprefix("is its unit wrong? Write ") for one in found] == [meant] * (meant is not None)
