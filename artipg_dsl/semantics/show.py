"""Typed programs as text, for ``apgc compile --emit typed``: declarations with their types, then what the names in them stand for."""

from __future__ import annotations

from collections.abc import Iterator

from ..syntax import ast
from ..syntax.walk import walk
from .check import TypedProgram
from .meanings import Base, BuiltIn, Clearance, Current, Declared, Global, Last, Local, Meaning, OwnBox, Previous
from .scope import BodyScope, Entry
from .types import UNKNOWN, ElementType, FunctionType, PartType


def show_typed(typed: TypedProgram) -> str:
    """The declarations of the main module, then those that were checked of the modules it uses, each body indented under its name;
    in the main module also what the names and paths of a body stand for, each once."""
    lines: list[str] = []
    ordered = [typed.main, *(m for m in typed.modules.values() if m is not typed.main)]
    for module in ordered:
        lines.append(f"module {module.name}")
        for symbol in (s for s in typed.symbols if s.module is module):
            role = getattr(symbol.decl, "role", None) or getattr(symbol.decl, "parent", None)
            lines.append(f"  {symbol.kind} {symbol.name}" + (f" : {role}" if role else ""))
            if symbol.body:
                _scope(typed, typed.checker.scope_of(symbol), 2, lines)
                if module is typed.main:
                    lines += dict.fromkeys(f"    {line}" for line in _names(typed, symbol.body))
            elif isinstance(symbol.decl, ast.VocabularyDecl):
                lines[-1] += " { " + " ".join(symbol.decl.words) + " }"
            elif isinstance(symbol.decl, ast.FunctionDecl) and not symbol.decl.parameters:
                lines[-1] += f" : {typed.type_of(symbol.decl.value)}"
    return "\n".join(lines) + "\n"


def _scope(typed: TypedProgram, scope: BodyScope, depth: int, lines: list[str]) -> None:
    for entry in scope.entries:
        if entry.kind == "index":
            continue
        lines.append("  " * depth + _entry(typed, entry))
        if isinstance(entry.node, ast.RepeatStmt):
            _scope(typed, entry.scope.inner[id(entry.node)], depth + 1, lines)


def _entry(typed: TypedProgram, entry: Entry) -> str:
    kind = typed.checker.entry_type(entry)
    word = entry.node.keyword if isinstance(entry.node, ast.ParamDecl) else entry.kind
    if isinstance(kind, PartType):
        shown = " | ".join("none" if v is None else v.name for v in kind.domain)
        word = "root part" if isinstance(entry.node, ast.PartDecl) and entry.node.root else word
    elif isinstance(kind, ElementType):
        shown = ""
    elif isinstance(kind, FunctionType) and isinstance(entry.node, ast.LetDecl):
        return f"{word} {entry.name}({', '.join(entry.node.parameters)}){_guards(entry)}"
    else:
        shown = str(kind)
    return f"{word} {entry.name}" + (f" : {shown}" if shown else "") + _guards(entry)


def _guards(entry: Entry) -> str:
    texts = []
    for guard in entry.guards:
        text = guard.test.span.words
        texts.append(text if guard.truth else f"not ({text})")
    return f"  when {' and '.join(texts)}" if texts else ""


def _names(typed: TypedProgram, nodes: object) -> Iterator[str]:
    """What each path in some nodes stands for: its type, and where its first name comes from."""
    within: set[int] = set()  # the beginnings of paths that have been shown
    for node in walk(nodes):
        if not isinstance(node, ast.NameExpr | ast.MemberExpr | ast.IndexExpr) or id(node) in within:
            continue
        first: ast.Expr = node
        while isinstance(first, ast.MemberExpr | ast.IndexExpr):
            first = first.obj
            within.add(id(first))
        meaning = typed.meanings.get(id(first))
        if meaning is not None:
            kind, origin = typed.type_of(node), _origin(meaning)
            shown = "" if kind == UNKNOWN else f" : {kind}"
            yield f"name {node.span.words}{shown}" + (f"  ({origin})" if origin else "")


_ORIGINS: dict[type[Meaning], str] = {
    Current: "the element itself",
    Previous: "the element before",
    Last: "the last element",
    BuiltIn: "a function of the language",
    OwnBox: "of the own box",
    Base: "what it is attached to",
    Clearance: "as far as nothing is in the way",
    Local: "of the formula",
}


def _origin(meaning: Meaning) -> str:
    """Where a name comes from, unless it is declared in the body itself or says so by what it is."""
    match meaning:
        case Declared(depth=depth) if depth:
            return "of the element" if depth == 1 else f"of the element, {depth} deep"
        case Global(symbol=symbol):
            return f"a {symbol.kind} of {symbol.module.name}"
    return _ORIGINS.get(type(meaning), "")
