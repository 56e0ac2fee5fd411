"""The other pages: the notebook runs, the examples of the design parse, links lead somewhere."""

from __future__ import annotations

import json
import re
from pathlib import Path

import pytest

from artipg_dsl.diagnostics import Report
from artipg_dsl.source import Source
from artipg_dsl.syntax.parse import parse

from .fences import fences

DOCS = Path(__file__).parents[2] / "docs"
PAGES = sorted(DOCS.rglob("*.md"))


LONG = {"fitting"}  # notebooks
NOTEBOOKS = [
    pytest.param(path, id=path.stem, marks=pytest.mark.slow if path.stem in LONG else ())
    for path in sorted((DOCS / "notebooks").glob("*.ipynb"))
]


@pytest.mark.parametrize("path", NOTEBOOKS)
def test_notebook(path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    """Its cells run in order, and those print that have an output stored. Numbers and names may change."""
    book = json.loads(path.read_text(encoding="utf-8"))
    assert book["nbformat"] == 4
    names: dict[str, object] = {}
    for cell in book["cells"]:
        if cell["cell_type"] != "code":
            continue
        exec(compile("".join(cell["source"]), cell["id"], "exec"), names)
        printed = capsys.readouterr().out
        assert bool(printed) == bool(cell["outputs"]), cell["id"]


@pytest.mark.parametrize("fence", fences(DOCS / "design.md"), ids=lambda f: f"line-{f.line}")
def test_examples_of_the_design_parse(fence) -> None:
    """Each is a file, declarations of one, or statements of a body."""
    wraps = ("{}", "apg 1\n{}", "apg 1\ncategory Example {{\n{}}}\n")
    reports = [Report() for _ in wraps]
    for wrap, report in zip(wraps, reports, strict=True):
        parse(Source("design.md", wrap.format(fence.text)), report)
    assert any(not report.failed for report in reports), reports[1].diagnostics


@pytest.mark.parametrize("page", PAGES, ids=lambda p: p.relative_to(DOCS).as_posix())
def test_links(page: Path) -> None:
    """Links to files and to headings."""
    text = re.sub(r"^```.*?^```$", "", page.read_text(encoding="utf-8"), flags=re.MULTILINE | re.DOTALL)
    headings = {slug(h) for h in re.findall(r"^#+ (.*)$", text, re.MULTILINE)}
    for target in re.findall(r"(?<!`)\]\(([^)\s]+)\)", text):
        place, _, anchor = target.partition("#")
        if place.startswith("https://"):
            continue
        if place:
            assert (page.parent / place).exists(), target
        else:
            assert anchor in headings, target


def slug(heading: str) -> str:
    return re.sub(r"[^\w\- ]", "", heading.lower()).replace(" ", "-")
