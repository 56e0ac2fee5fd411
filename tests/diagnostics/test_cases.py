"""Every program in cases/ gives exactly the findings that stand beside its lines."""

from collections.abc import Iterator
from pathlib import Path

import pytest

from artipg_dsl.diagnostics import Report
from artipg_dsl.semantics import modules
from artipg_dsl.session import check_text
from artipg_dsl.source import Source
from artipg_dsl.syntax import ast
from artipg_dsl.syntax.parse import parse

from .annotated import annotate, bare

CASES = Path(__file__).parent / "cases"


@pytest.fixture(autouse=True, scope="module")
def library_parsed_once() -> Iterator[None]:
    """Hundreds of programs use the same modules, whose trees never change: they are parsed once for all."""
    trees: dict[tuple[str, str], ast.Module | None] = {}

    def remembered(source: Source, report: Report) -> ast.Module | None:
        key = (source.name, source.text)
        if key not in trees or report.diagnostics:
            trees[key] = parse(source, report)
        return trees[key]

    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(modules, "parse", remembered)
        yield


@pytest.mark.parametrize("path", sorted(CASES.glob("*.apg")), ids=lambda p: p.stem)
def test_findings(path: Path, update_golden: bool) -> None:
    expected = path.read_text(encoding="utf-8")
    source = Source(str(path), bare(expected))
    found = annotate(source, check_text(source).diagnostics)
    if update_golden:
        path.write_text(found, encoding="utf-8")
    else:
        assert found == expected


def test_an_annotation_is_removed_whole() -> None:
    assert bare("a  #! 1 syntax: x  #! 2 tie: y\nb # c\n") == "a\nb # c\n"
