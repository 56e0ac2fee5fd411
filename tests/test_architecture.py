"""The house: an import inside a function says why it stands there. Arrows between rooms are held by ``lint-imports``."""

from __future__ import annotations

import ast
from collections.abc import Iterator
from pathlib import Path

ROOT = Path(__file__).parents[1] / "artipg_dsl"
REASONS = ("start-up", "extra", "circle")
START = ("cli", "api.py", "__init__.py", "session.py")  # they load what a command needs, and nothing else


def late_imports(path: Path) -> Iterator[tuple[int, str]]:
    """Line and text of every import of our own modules inside a function."""
    text = path.read_text(encoding="utf-8")
    lines = text.splitlines()
    for function in ast.walk(ast.parse(text)):
        if isinstance(function, ast.FunctionDef | ast.AsyncFunctionDef):
            for node in ast.walk(function):
                if isinstance(node, ast.ImportFrom) and node.level:
                    yield node.lineno, lines[node.lineno - 1].strip()


def test_imports_inside_functions_say_why() -> None:
    silent = [
        f"{path.relative_to(ROOT)}:{line}: {text}"
        for path in sorted(ROOT.rglob("*.py"))
        if path.relative_to(ROOT).parts[0] not in START
        for line, text in late_imports(path)
        if text.partition("# ")[2].partition(":")[0] not in REASONS
    ]
    assert not silent
