"""Every program in cases/ gives exactly the findings that stand beside its lines."""

from pathlib import Path

import pytest

from artipg_dsl.session import check_text
from artipg_dsl.source import Source

from .annotated import annotate, bare

CASES = Path(__file__).parent / "cases"


@pytest.mark.parametrize("path", sorted(CASES.glob("*.apg")), ids=lambda p: p.stem)
def test_findings(path: Path, update_golden: bool) -> None:
    expected = path.read_text(encoding="utf-8")
    source = Source(str(path), bare(expected))
    diagnostics = check_text(source).diagnostics
    assert [d.message for d in diagnostics if not d.hint] == []  # every finding says what to try
    found = annotate(source, diagnostics)
    if update_golden:
        path.write_text(found, encoding="utf-8")
    else:
        assert found == expected


def test_an_annotation_is_removed_whole() -> None:
    assert bare("a  #! 1 syntax: x  #! 2 tie: y\nb # c\n") == "a\nb # c\n"
