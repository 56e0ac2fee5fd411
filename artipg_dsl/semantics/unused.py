"""Names of a file that nothing reads: what ``use`` brings in, and the values that a category and the templates beside it declare."""

from __future__ import annotations

from collections.abc import Iterator

from ..diagnostics import Report
from ..source import Span
from ..syntax import ast
from ..syntax.walk import walk
from .check import TypedProgram
from .symbols import NAMED, ModuleScope, Symbol

_VALUES = ("param", "count", "let", "style", "curve")
_SHARED = ("template", "role", "primitive", "function")  # at the top of a file
_DECLARING = (*NAMED, ast.ParamDecl, ast.Argument)  # what they are called is no use of it

_Read = list[tuple[ast.Decl, set[str]]]  # the declarations of a file, and the names in each


def warn_unused(typed: TypedProgram, report: Report) -> None:
    """Report imports that the file does not use; of a file with a category, values that change no object too."""
    read = _read_by(typed.main)
    for names, span in find_imports(typed.main, read):
        listed = " and ".join(filter(None, (", ".join(names[:-1]), names[-1])))
        be, it = ("are", "them") if len(names) > 1 else ("is", "it")
        report.warning("unused", span, f"{listed} {be} imported and not used", hint=f"leave {it} out of `use`")
    for symbol in _find_materials(typed.main, read) if typed.category is not None else ():
        hint = f"write `material {symbol.name} on ...`, or leave it out: its properties are not checked"
        report.warning("unused", symbol.decl.name_span, f"nothing is made of `{symbol.name}`", hint=hint)
    for symbol in _find_shared(typed.main, read) if typed.category is not None else ():
        said = f"nothing uses the {_kind_of(symbol)} `{symbol.name}`"
        report.warning("unused", symbol.decl.name_span, said, hint="use it, or leave it out")
    for name, owner, span in _find_parameters(typed.main) if typed.category is not None else ():
        report.warning(
            "unused",
            span,
            f"{owner} does not read `{name}`" + (": all of its grasps are the same" if owner == "the grasp" else ""),
            hint="use it, or leave it out",
        )
    for name, span in _find_values(typed, read) if typed.category is not None else ():
        report.warning("unused", span, f"nothing reads `{name}`: it changes no object", hint="use it, or leave it out")


def _read_by(module: ModuleScope) -> _Read:
    return [(decl, _words(decl)) for decl in module.tree.declarations]


def find_imports(module: ModuleScope, read_by: _Read | None = None) -> Iterator[tuple[list[str], Span]]:
    """Of each ``use`` the names that stand nowhere else, with the place of the first.

    A vocabulary counts as used: its words join those of the program.
    """
    read = set[str]().union(*[words for _, words in read_by or _read_by(module)])
    for use in module.tree.uses:
        idle = {
            f"`{name}`": span
            for name, span in zip(use.names, use.name_spans, strict=True)
            if name not in read and (symbol := module.find(name)) is not None and symbol.kind != "vocabulary"
        }
        if idle:
            yield list(idle), next(iter(idle.values()))


def _find_materials(module: ModuleScope, read_by: _Read) -> Iterator[Symbol]:
    read = set[str]().union(*[words for decl, words in read_by if not isinstance(decl, ast.MaterialDecl)])
    return (symbol for symbol in module.own() if symbol.kind == "material" and symbol.name not in read)


def _find_shared(module: ModuleScope, read_by: _Read) -> Iterator[Symbol]:
    """Templates and the like beside a category that nothing else in the file names."""
    for symbol in module.own():
        if symbol.kind in _SHARED and not any(
            symbol.name in words for decl, words in read_by if decl is not symbol.decl
        ):
            yield symbol


def _kind_of(symbol: Symbol) -> str:
    return "value" if isinstance(symbol.decl, ast.FunctionDecl) and not symbol.decl.parameters else symbol.kind


def _find_parameters(module: ModuleScope) -> Iterator[tuple[str, str, Span]]:
    """Parameters of functions and of grasps that their formulas do not read: name, whose, where."""
    for node in walk(module.tree.declarations):
        if isinstance(node, ast.LetDecl | ast.FunctionDecl) and node.parameters:
            read = _words(node.value)
            yield from ((name, f"`{node.name}`", node.name_span) for name in node.parameters if name not in read)
        elif isinstance(node, ast.GraspStmt) and node.parameter is not None:
            if node.parameter not in _words(
                (node.at, node.approach, node.close, node.opening, node.quality, *node.hand)
            ):
                yield node.parameter, "the grasp", node.name_span


def _find_values(typed: TypedProgram, read_by: _Read) -> Iterator[tuple[str, Span]]:
    """What a role asks for may be idle in a template that plays it."""
    module, words = typed.main, {id(decl): words for decl, words in read_by}
    members = {node.name for node in walk(module.tree.declarations) if isinstance(node, ast.MemberExpr)}
    for symbol in module.own():
        if symbol.kind not in ("category", "template"):
            continue
        read = words[id(symbol.decl)] | members | set(typed.checker.interface_of(symbol))
        for scope in typed.checker.scope_of(symbol).below():
            for entry in scope.entries:
                if entry.kind in _VALUES and entry.name not in read:
                    yield entry.name, entry.span


def _words(tree: object) -> set[str]:
    """The names in a piece of the tree, but for those that it declares and those of arguments."""
    found: set[str] = set()
    held = [tree]
    while held:  # a tree has tens of thousands of values
        node = held.pop()
        if isinstance(node, tuple):
            held += node
        elif isinstance(node, ast.Node):
            left = ("span", "name", "names") if isinstance(node, _DECLARING) else ("span",)
            held += [getattr(node, field) for field in node.__dataclass_fields__ if field not in left]
        elif isinstance(node, str):
            found.add(node)
    return found
