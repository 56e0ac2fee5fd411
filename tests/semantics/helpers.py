"""Checks small programs written in a test."""

from __future__ import annotations

from pathlib import Path

from artipg_dsl.diagnostics import Report
from artipg_dsl.semantics.check import TypedProgram, check
from artipg_dsl.semantics.modules import Workspace
from artipg_dsl.source import Source
from artipg_dsl.syntax import ast
from artipg_dsl.syntax.parse import parse

HEAD = "apg 1\nuse primitives { Cuboid, Cylinder }\nuse handles { Handle, BarHandle, BowHandle, BracketHandle }\n"


_TREES: dict[str, ast.Module] = {}  # the library does not change while tests run


def _load(source: Source, report: Report) -> ast.Module | None:
    if not source.name.startswith("library/"):
        return parse(source, report)
    if source.name not in _TREES:
        tree = parse(source, report)
        if tree is None:
            return None
        _TREES[source.name] = tree
    return _TREES[source.name]


def check_file(path: Path) -> tuple[Report, TypedProgram | None]:
    """The findings on a file, and its typed program (None where it could not be parsed)."""
    report = Report()
    workspace = Workspace(report, loader=_load)
    module = workspace.load_file(path)
    return report, None if module is None else check(workspace, module, report)


def check_text(folder: Path, text: str, **modules: str) -> tuple[Report, TypedProgram | None]:
    """The findings on a text that stands in ``folder`` as main.apg, beside the modules given by name."""
    for name, body in modules.items():
        (folder / f"{name}.apg").write_text(body)
    main = folder / "main.apg"
    main.write_text(text)
    return check_file(main)


def codes(report: Report) -> list[str]:
    return [d.code for d in report.diagnostics]
