"""Every error of lowering that a user can meet stands in a case; what no program reaches is an internal error, or not there."""

from __future__ import annotations

import ast
import re
from collections.abc import Iterator
from pathlib import Path

import pytest

import artipg_dsl

from .test_cases import CASES

LOWER = Path(artipg_dsl.__file__).parent / "lower"
# they warn where `check` asks: tests/annotate/test_unlabelled.py, tests/lower/test_idle.py
ELSEWHERE = ("unlabelled.py", "idle.py")
FUNCTIONS = [
    node
    for path in sorted(LOWER.rglob("*.py"))
    if path.name not in ELSEWHERE
    for node in ast.walk(ast.parse(path.read_text(encoding="utf-8")))
    if isinstance(node, ast.FunctionDef)
]
CALLS = [(node, function) for function in FUNCTIONS for node in ast.walk(function) if isinstance(node, ast.Call)]
CASE = re.compile(r"#! \S+ (?:warning )?(.*?)(?=  #! |$)", re.MULTILINE)
TOLD = [text for path in CASES.glob("*.apg") for text in CASE.findall(path.read_text(encoding="utf-8"))]


def called(node: ast.Call) -> str:
    return getattr(node.func, "attr", getattr(node.func, "id", ""))


def patterns(node: ast.expr | None, within: ast.FunctionDef) -> Iterator[str]:
    """What a message can look like: a pattern for each text that an expression stands for in a function of lowering."""
    match node:
        case ast.Constant(value=str() as text):
            yield re.escape(text)
        case ast.JoinedStr(values=values):
            yield "".join(re.escape(v.value) if isinstance(v, ast.Constant) else ".*" for v in values)
        case ast.IfExp(body=body, orelse=other):
            yield from patterns(body, within)
            yield from patterns(other, within)
        case ast.BinOp(left=left):
            yield from (f"{begin}.*" for begin in patterns(left, within))
        case ast.Name(id=name):
            parameters = [a.arg for a in within.args.args]
            for call, caller in CALLS if name in parameters else ():
                if called(call) == within.name:
                    yield from patterns(call.args[parameters.index(name)], caller)
            for node in ast.walk(within):
                if isinstance(node, ast.Assign) and any(getattr(target, "id", "") == name for target in node.targets):
                    yield from patterns(node.value, within)
        case ast.Call():
            made = next((f for f in FUNCTIONS if f.name == called(node)), None)
            for end in ast.walk(made) if made is not None else ():
                if isinstance(end, ast.Return) and made is not None:
                    yield from patterns(end.value, made)


def sites() -> Iterator[tuple[str, str]]:
    """What lowering tells users: the code, and a pattern of the message, of each place and each text."""
    for node, function in CALLS:
        if called(node) in ("error", "warning") and isinstance(node.args[0], ast.Constant):
            found = list(patterns(node.args[2], function))
            assert found, f"{function.name}: the text of {node.args[0].value} is not found"
            yield from ((str(node.args[0].value), pattern) for pattern in found)


@pytest.mark.parametrize(("code", "pattern"), sorted(set(sites())))
def test_a_case_reaches_it(code: str, pattern: str) -> None:
    assert any(re.match(f"{code}: {pattern}", text) for text in TOLD), "write a case that reaches it"
