"""Typed programs as text: one declaration per line with its type, for ``apgc compile --emit typed``."""

from __future__ import annotations

from ..syntax import ast
from .check import TypedProgram
from .scope import Entry, Scope
from .types import Element, Function, Part


def show_typed(typed: TypedProgram) -> str:
    """The declarations of the main module, then of the modules it uses, each body indented under its name."""
    lines: list[str] = []
    ordered = [typed.main, *(m for m in typed.modules.values() if m is not typed.main)]
    for module in ordered:
        lines.append(f"module {module.name}")
        for symbol in module.own():
            role = getattr(symbol.decl, "role", None) or getattr(symbol.decl, "parent", None)
            lines.append(f"  {symbol.kind} {symbol.name}" + (f" : {role}" if role else ""))
            if symbol.body:
                _scope(typed, typed.checker.scope_of(symbol), 2, lines)
            elif isinstance(symbol.decl, ast.VocabularyDecl):
                lines[-1] += " { " + " ".join(symbol.decl.words) + " }"
            elif isinstance(symbol.decl, ast.FunctionDecl) and not symbol.decl.parameters:
                lines[-1] += f" : {typed.type_of(symbol.decl.value)}"
    return "\n".join(lines) + "\n"


def _scope(typed: TypedProgram, scope: Scope, depth: int, lines: list[str]) -> None:
    for entry in scope.entries:
        if entry.kind == "index":
            continue
        lines.append("  " * depth + _entry(typed, entry))
        if isinstance(entry.node, ast.RepeatStmt):
            _scope(typed, entry.scope.inner[id(entry.node)], depth + 1, lines)


def _entry(typed: TypedProgram, entry: Entry) -> str:
    kind = typed.checker.entry_type(entry)
    word = entry.node.keyword if isinstance(entry.node, ast.ParamDecl) else entry.kind
    if isinstance(kind, Part):
        shown = " | ".join("none" if v is None else v.name for v in kind.domain)
        word = "root part" if isinstance(entry.node, ast.PartDecl) and entry.node.root else word
    elif isinstance(kind, Element):
        shown = ""
    elif isinstance(kind, Function) and isinstance(entry.node, ast.LetDecl):
        return f"{word} {entry.name}({', '.join(entry.node.parameters)}){_guards(entry)}"
    else:
        shown = str(kind)
    return f"{word} {entry.name}" + (f" : {shown}" if shown else "") + _guards(entry)


def _guards(entry: Entry) -> str:
    texts = []
    for guard in entry.guards:
        span = guard.test.span
        text = " ".join(span.source.text[span.start : span.end].split())
        texts.append(text if guard.truth else f"not ({text})")
    return f"  when {' and '.join(texts)}" if texts else ""
