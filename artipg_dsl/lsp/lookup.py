"""The name at a place of a text: what it stands for, in the words of the program and of the language, and where it is declared."""

from __future__ import annotations

import re
from collections.abc import Iterator, Sequence
from dataclasses import replace

from ..language import FUNCTIONS, JOINTS, MEMBERS, TYPES, WORDS
from ..records import dataclass
from ..semantics.alternatives import taken
from ..semantics.check import TypedProgram
from ..semantics.meanings import BuiltIn, Declared, Feature, Global, Inner, Local, Word
from ..semantics.parts import box_member, place_member, place_names
from ..semantics.scope import BodyScope, Entry
from ..semantics.symbols import Symbol, members, name_spans_of
from ..semantics.types import UNKNOWN, ElementType, NamedType, PartType, ScalarType, SlotType, Type, VecType
from ..source import Span
from ..syntax import ast
from ..syntax.walk import walk
from .analysis import Analysis

_LOCAL = "a variable of this formula, or a parameter of this function"
_SHOWN = 24  # statements of a template that are shown, at most


@dataclass(frozen=True, slots=True)
class Found:
    """A name at ``span``: ``code`` says what it is in the language, ``about`` in words; ``declared`` is where."""

    span: Span
    code: str
    about: str = ""
    declared: tuple[Span, ...] = ()


def find(analysis: Analysis, offset: int) -> Found | None:
    """What the name at a place stands for; None where there is none, or nothing is known of it."""
    typed, module = analysis.typed, analysis.module
    if typed is None or module is None:
        return None
    for use in module.tree.uses:
        if use.span.holds(offset):
            return _used(typed, use, offset)
    symbol = analysis.around(offset)
    if symbol is None:
        return None
    if symbol.decl.name_span.holds(offset):
        return _of_symbol(symbol, symbol.decl.name_span)
    scope = analysis.scope(offset)
    narrow = [node for node in walk(symbol.decl) if node.span.holds(offset)]
    variables = {name: span for node in narrow for name, span in _variables(node).items()}
    if at := next((span for span in variables.values() if span.holds(offset)), None):
        return Found(at, at.text, _LOCAL, (at,))
    for node in reversed(narrow):
        found = _in_node(typed, symbol, scope, node, offset)
        if found is not None:
            own = variables.get(found.span.text) if _is_variable(typed, scope, node) else None
            return found if own is None else replace(found, declared=(own,))
    return None


def _is_variable(typed: TypedProgram, scope: BodyScope | None, node: ast.Node) -> bool:
    """Whether a name stands for a variable of the statement around it."""
    if not isinstance(node, ast.NameExpr):
        return False
    entries = [] if scope is None else scope.find(node.name)
    return isinstance(typed.meanings.get(id(node)), Local) or bool(entries) and entries[0].kind == "index"


def _used(typed: TypedProgram, use: ast.UseDecl, offset: int) -> Found | None:
    for name, span in zip(use.names, use.name_spans, strict=True):
        if span.holds(offset):
            symbol = typed.main.find(name)
            return None if symbol is None else _of_symbol(symbol, span)
    modules = [m for m in typed.modules.values() if m.name == use.module]
    if not use.module_span.holds(offset) or not modules:
        return None
    names = ", ".join(symbol.name for symbol in modules[0].own())
    start = Span(modules[0].source, 0, 0)
    return Found(use.module_span, f"use {use.module}", f"declares {names}", (start,))


def _in_node(typed: TypedProgram, owner: Symbol, scope: BodyScope | None, node: ast.Node, offset: int) -> Found | None:
    """What stands at a place of a node itself, not of those in it."""
    match node:
        case ast.RoleDecl(parent=str(name), parent_span=Span() as span) if span.holds(offset):
            return _named(owner, scope, name, span)
        case ast.TemplateDecl(role=str(name), role_span=Span() as span) if span.holds(offset):
            return _named(owner, scope, name, span)
        case ast.PartDecl(role=str(name), role_span=Span() as span) if span.holds(offset):
            return _named(owner, scope, name, span)
        case ast.StyleDecl(role=name, role_span=span) if span.holds(offset):
            return _named(owner, scope, name, span)
        case ast.Alternative(name=str(name), name_span=span) if span.holds(offset):
            return _named(owner, scope, name, span)
        case (
            ast.Alternative(name=str(name), arguments=arguments) | ast.PartDecl(role=str(name), arguments=arguments)
        ) if found := _argument(typed, owner.module.find(name), arguments, offset):
            return found
        case ast.IsExpr(type_name=name, type_span=span) if span.holds(offset):
            return _named(owner, scope, name, span)
        case ast.MaterialStmt(material=name, material_span=span) if span.holds(offset):
            return _named(owner, scope, name, span)
        case ast.LabelStmt(vocabulary=vocabulary, label=word, label_span=span) if span.holds(offset):
            return _word(typed, vocabulary, word, span)
        case ast.LabelStmt(vocabulary=vocabulary, label_span=span) if (
            span.start - len(vocabulary) - 1 <= offset < span.start
        ):
            return _named(owner, scope, vocabulary, Span(span.source, span.start - len(vocabulary) - 1, span.start - 1))
        case ast.JointDecl(kind=str(kind), kind_span=Span() as span) if span.holds(offset) and kind in JOINTS:
            needed, taken = (
                ", ".join(f"`{word}`" for word in words) for words in (JOINTS[kind].needs, JOINTS[kind].takes)
            )
            return Found(span, f"joint : {kind}", "; ".join([f"needs {needed}"] * bool(needed) + [f"takes {taken}"]))
        case ast.TypeRef(name=name, span=span):
            return _named(owner, scope, name, span) or _language(name, span)
        case ast.NameExpr(span=span):
            return _name(typed, scope, node)
        case ast.MemberExpr(name_span=span) if span.holds(offset):
            return _member(typed, node)
        case ast.Stmt():
            return _declaration(typed, scope, node, offset)
    return None


def _named(owner: Symbol, scope: BodyScope | None, name: str, span: Span) -> Found | None:
    """What a name stands for where a template, a role, a material or a style is expected."""
    entries = [] if scope is None else scope.find(name)
    if entries:
        return _of_entries(entries, span)
    symbol = owner.module.find(name)
    return None if symbol is None else _of_symbol(symbol, span)


def _argument(
    typed: TypedProgram, symbol: Symbol | None, arguments: Sequence[ast.Argument], offset: int
) -> Found | None:
    """The parameter that an argument names."""
    for argument in arguments:
        if argument.name is None or symbol is None:
            continue
        span = Span(argument.span.source, argument.span.start, argument.span.start + len(argument.name))
        if span.holds(offset):
            entries = [entry for entry in taken(typed.checker, symbol) if entry.name == argument.name]
            return _of_entries(entries, span) if entries else None
    return None


def _word(typed: TypedProgram, vocabulary: str, word: str, span: Span) -> Found | None:
    """A word of a vocabulary, which several modules may add to."""
    for module in typed.modules.values():
        for symbol in module.own():
            decl = symbol.decl if symbol.kind == "vocabulary" and symbol.name == vocabulary else None
            if isinstance(decl, ast.VocabularyDecl) and word in decl.words:
                at = decl.words.index(word)
                motion = decl.motions[at]
                return Found(
                    span, f"{vocabulary}.{word}" + (f" : {motion}" if motion else ""), decl.doc, (decl.word_spans[at],)
                )
    return None


def _name(typed: TypedProgram, scope: BodyScope | None, node: ast.NameExpr) -> Found | None:
    meaning, span = typed.meanings.get(id(node)), node.span
    if isinstance(meaning, Global):
        return _of_symbol(meaning.symbol, span)
    kind = typed.type_of(node)
    if isinstance(meaning, Local | Word):
        code = node.name if kind == UNKNOWN else f"{node.name} : {kind}"
        return Found(span, code, _LOCAL if isinstance(meaning, Local) else "")
    if isinstance(meaning, BuiltIn):
        forms = FUNCTIONS.get(node.name, (meaning.form,))
        return Found(span, "\n".join(form.call for form in forms), meaning.form.about)
    entries = [] if scope is None else scope.find(node.name)
    if entries and (meaning is None or isinstance(meaning, Declared) or entries[0].kind in ("repeat", "index")):
        return _of_entries(entries, span, typed.checker.entry_type(entries[0]))
    if node.name in WORDS or node.name in MEMBERS["box"]:
        return _language(node.name, span)
    return None if kind == UNKNOWN else Found(span, f"{node.name} : {kind}")


def _member(typed: TypedProgram, node: ast.MemberExpr) -> Found | None:
    meaning, kind = typed.meanings.get(id(node)), typed.type_of(node)
    if isinstance(meaning, Inner):
        entries = list(inside(typed, typed.type_of(node.obj), node.name))
        return _of_entries(entries, node.name_span, kind) if entries else None
    if isinstance(meaning, Feature):
        about = features(typed.type_of(node.obj)).get(node.name, "")
        return Found(node.name_span, f"{node.span.words} : {kind}", about)
    return None if kind == UNKNOWN else Found(node.name_span, f"{node.span.words} : {kind}")


def inside(typed: TypedProgram, kind: Type, name: str | None = None) -> Iterator[Entry]:
    """What the alternatives of a part, or the element of a repeat, declare for others: all of it, or what is called ``name``."""
    bodies: list[BodyScope] = []
    if isinstance(kind, PartType):
        symbols = dict.fromkeys(v.symbol for v in kind.variants if v.symbol is not None and v.symbol.body)
        bodies = [typed.checker.scope_of(symbol) for symbol in symbols]
    elif isinstance(kind, ElementType):
        bodies = [kind.entry.scope.inner[id(kind.entry.node)]]
    for body in bodies:
        for entry in body.entries if name is None else body.table.get(name, ()):
            if not entry.private:
                yield entry


def features(kind: Type) -> dict[str, str]:
    """What may follow a dot behind a value of a type and is the language's own, and what it is."""
    if isinstance(kind, VecType):
        return {axis: f"its component along {axis}" for axis in place_names(kind)}
    known = MEMBERS.get("box" if isinstance(kind, _BOXED) else str(getattr(kind, "name", "")), {})
    return {name: member.about for name, member in known.items()}


def feature(kind: Type, name: str) -> Type:
    """The type of such a member."""
    if isinstance(kind, VecType):
        return ScalarType(kind.dimension) if kind.dimension is not None and name in place_names(kind) else UNKNOWN
    found = box_member(name) if isinstance(kind, _BOXED) else None
    return found or (place_member(kind, name) if isinstance(kind, NamedType) else None) or UNKNOWN


_BOXED = (PartType, SlotType, ElementType)


def _declaration(typed: TypedProgram, scope: BodyScope | None, node: ast.Stmt, offset: int) -> Found | None:
    """The name that a statement itself declares."""
    for span in name_spans_of(node):
        if span.holds(offset):
            entries = [] if scope is None else [e for e in scope.find(span.text) if e.node is node]
            return _of_entries(entries, span, typed.checker.entry_type(entries[0])) if entries else None
    return None


def _variables(node: ast.Node) -> dict[str, Span]:
    """The variables that a statement itself has: parameters of a function, the index of a repeat, u and v of a surface."""
    match node:
        case ast.LetDecl(parameters=names, name_span=head) | ast.FunctionDecl(parameters=names, name_span=head):
            pass
        case ast.SurfaceDecl(u=u, v=v, index=index, name_span=head):
            names = (u, v) if index is None else (index, u, v)
        case ast.CurveDecl(parameter=parameter, name_span=head):
            names = (parameter,)
        case ast.RepeatStmt(index=str(index), name_span=head) | ast.PieceDecl(index=str(index), name_span=head):
            names = (index,)
        case ast.GraspStmt(parameter=str(parameter), target=target):
            names, head = (parameter,), target.span
        case _:
            return {}
    text = node.span.text
    found: dict[str, Span] = {}
    for name in names:
        at = re.compile(rf"\b{name}\b").search(text, head.end - node.span.start)
        if at is not None:
            found[name] = Span(node.span.source, node.span.start + at.start(), node.span.start + at.end())
    return found


def _language(name: str, span: Span) -> Found | None:
    """A word of the language itself."""
    word = TYPES.get(name) or WORDS.get(name)
    if word is not None:
        return Found(span, name, word.about)
    member = MEMBERS["box"].get(name)
    return None if member is None else Found(span, f"{name} : {member.type}", member.about)


def _of_entries(entries: Sequence[Entry], span: Span, kind: Type = UNKNOWN) -> Found:
    """What a body declares by one name, once or in several branches or alternatives."""
    codes = dict.fromkeys(_head(entry.node) for entry in entries)
    docs = dict.fromkeys(entry.node.doc for entry in entries if entry.node.doc)
    node = entries[0].node
    if isinstance(node, ast.LetDecl | ast.PortDecl) and kind != UNKNOWN:
        docs[str(kind)] = None
    spans = tuple(dict.fromkeys(entry.span for entry in entries))
    return Found(span, "\n".join(codes), "\n\n".join(docs), spans)


def _of_symbol(symbol: Symbol, span: Span) -> Found:
    """A declaration of a file: its head, and what it takes and shows."""
    decl = symbol.decl
    shown = [_head(stmt) for stmt in members(symbol) if isinstance(stmt, _INTERFACE)]
    lines = [_head(decl), *(f"  {text}" for text in shown[:_SHOWN])]
    if len(shown) > _SHOWN:
        lines.append(f"  # and {len(shown) - _SHOWN} more")
    return Found(span, "\n".join(lines), decl.doc, (decl.name_span,))


_INTERFACE = (ast.ParamDecl, ast.CountDecl, ast.StyleDecl, ast.PartDecl, ast.SlotDecl, ast.PortDecl, ast.JointDecl)


def _head(stmt: ast.Stmt) -> str:
    """A statement on one line, without the body that it has."""
    text = stmt.span.text.partition("{")[0] if hasattr(stmt, "body") else stmt.span.text
    return " ".join(text.split())
