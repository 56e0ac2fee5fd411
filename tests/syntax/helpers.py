"""Parsing in tests, and a compact text form of trees."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import fields
from typing import Any

from artipg_dsl.diagnostics import Report
from artipg_dsl.diagnostics.text import render
from artipg_dsl.source import Source, Span
from artipg_dsl.syntax import ast
from artipg_dsl.syntax.parse import parse


def tree_of(text: str, name: str = "test.apg") -> ast.Module:
    report = Report()
    tree = parse(Source(name, text), report)
    assert tree is not None, render(report.diagnostics, colour=False)
    return tree


def body_of(*statements: str) -> tuple[Any, ...]:
    """The statements of a category with these lines."""
    tree = tree_of("category C {\n" + "\n".join(statements) + "\n}\n")
    return tree.declarations[0].body  # type: ignore[attr-defined]


def value_of(expression: str) -> str:
    """An expression in prefix form, as the parser understands it."""
    return prefix(body_of(f"let x = {expression}")[0].value)


def prefix(e: Any) -> str:
    match e:
        case ast.NumberExpr():
            return f"{e.value:g}{e.unit}"
        case ast.NameExpr():
            return e.name
        case ast.HoleExpr():
            return "_"
        case ast.VectorExpr():
            return "[" + " ".join(map(prefix, e.items)) + "]"
        case ast.UnaryExpr():
            return f"({e.op} {prefix(e.operand)})"
        case ast.BinaryExpr():
            return f"({e.op} {prefix(e.left)} {prefix(e.right)})"
        case ast.IsExpr():
            return f"(is {prefix(e.subject)} {e.type_name})"
        case ast.IfExpr():
            return f"(if {prefix(e.condition)} {prefix(e.then)} {prefix(e.otherwise)})"
        case ast.AllExpr():
            return f"(all {prefix(e.value)})"
        case ast.MemberExpr():
            return f"{prefix(e.obj)}.{e.name}"
        case ast.IndexExpr():
            return f"{prefix(e.obj)}[{prefix(e.index)}]"
        case ast.CallExpr():
            return f"{prefix(e.function)}({' '.join(map(prefix, e.arguments))})"
        case ast.StringExpr():
            return repr(e.value)
        case ast.ChainExpr():
            return "chain " + " ".join(map(prefix, e.pieces))
        case ast.RangeExpr():
            return f"{prefix(e.low)}..{prefix(e.high)}"
        case ast.Clause():
            values = e.value if isinstance(e.value, tuple) else (e.value,)
            return " ".join([e.word, *(prefix(v) for v in values if v is not None)])
        case ast.Argument():
            return (f"{e.name}=" if e.name else "") + prefix(e.value)
    raise TypeError(e)


def nodes(node: ast.Node) -> Iterator[tuple[ast.Node, ast.Node | None]]:
    """All nodes below with the node that holds each, the node itself first."""
    waiting: list[tuple[ast.Node, ast.Node | None]] = [(node, None)]
    while waiting:
        child, holder = waiting.pop()
        yield child, holder
        for field in fields(child):
            value = getattr(child, field.name)
            waiting += [
                (v, child) for v in (value if isinstance(value, tuple) else (value,)) if isinstance(v, ast.Node)
            ]


def without_spans(value: Any) -> Any:
    """A tree as plain tuples, equal for equal programs wherever their tokens stand."""
    if isinstance(value, Span):
        return None
    if isinstance(value, tuple):
        return tuple(map(without_spans, value))
    if isinstance(value, ast.Node):
        return type(value).__name__, *((f.name, without_spans(getattr(value, f.name))) for f in fields(value))
    return value
