"""AST to typed program: resolves names, infers types and reports what does not hold together."""

from __future__ import annotations

import re
from pathlib import Path

from ..diagnostics import Report
from ..diagnostics.suggest import did_you_mean
from ..graph.program import UNLABELLED
from ..records import dataclass
from ..resources import library_dir
from ..source import Span
from ..syntax import ast
from . import attachments, declarations, names, primitives, roles, statements
from .checker import Checker, Context
from .fold import constant
from .meanings import Meaning
from .modules import Workspace
from .symbols import ModuleScope, Symbol
from .types import DIMENSIONS, NONE, RATIO, UNKNOWN, ScalarType, Type, VecType

_NAME = re.compile(r"[A-Za-z_]\w*")


@dataclass(slots=True, eq=False)
class TypedProgram:
    """The outcome of a check of some declarations, ``symbols``. ``types`` and ``meanings`` map ``id`` of an expression to its type
    and, of a name, to what it stands for; ``modules`` keep the trees alive.

    In the body of a function they are those of no call in particular: there is a type for each call, by those of its arguments
    (``Checker.calls``). Lowering asks for none there. It evaluates a body anew for each call, where every value says what
    it is; what it does ask for is the type of the target of a keypoint and of the value of a ``let`` without parameters.
    """

    modules: dict[str, ModuleScope]
    main: ModuleScope
    category: Symbol | None
    symbols: tuple[Symbol, ...]
    types: dict[int, Type]
    meanings: dict[int, Meaning]
    checker: Checker
    unshaped: set[Symbol]  # shipped primitives: what shapes them is typed when they are lowered

    def shape(self, symbol: Symbol) -> None:
        """Type the surfaces, curves, pieces, ... of a primitive, unless that is done: a lowered one that was kept needs no types."""
        if symbol in self.unshaped:
            self.unshaped.discard(symbol)
            shapes = tuple(stmt for stmt in symbol.body if isinstance(stmt, statements.SHAPE))
            statements.check_body(self.checker, self.checker.scope_of(symbol), shapes, ())

    def type_of(self, expr: ast.Expr) -> Type:
        """The type of an expression; unknown where an error stands or nothing asked for it."""
        return self.types.get(id(expr), UNKNOWN)


def check(workspace: Workspace, module: ModuleScope, report: Report) -> TypedProgram:
    """Checks what there is to check, once (see ``_to_check``); errors are collected in ``report``."""
    ck = Checker(workspace, report)
    library = _library(workspace, module)
    symbols = _to_check(workspace, library)
    for scope in workspace.modules.values():
        for symbol in scope.own():
            if symbol.kind == "vocabulary":
                assert isinstance(symbol.decl, ast.VocabularyDecl)
                ck.vocabularies.setdefault(symbol.name, set()).update(symbol.decl.words)
    unshaped = {s for s in symbols if s.kind == "primitive" and s.module in library}
    for symbol in symbols:
        _declaration(ck, symbol, statements.SHAPE if symbol in unshaped else ())
    roles.check_nesting(ck, symbols)
    if not module.tree.declarations and not report.failed:
        start = module.tree.span.start
        report.error(
            "nothing-declared",
            Span(module.source, start, start),
            "nothing is declared in this file",
            hint="`apgc new Name` writes a category to start from; is it the right file, and saved?",
        )
    categories = [s for s in module.own() if s.kind == "category"]
    for extra in categories[1:]:
        report.error(
            "two-categories",
            extra.decl.name_span,
            "a file holds one category",
            notes=((categories[0].decl.name_span, "the first one"),),
            hint="put each category into a file of its own; what both use can go into a third, brought in with `use`",
        )
    category = categories[0] if categories else None
    return TypedProgram(workspace.modules, module, category, tuple(symbols), ck.types, ck.meanings, ck, unshaped)


def _library(workspace: Workspace, module: ModuleScope) -> set[ModuleScope]:
    """The modules of the shipped library, but for the one that is checked."""
    shipped = library_dir().resolve()
    return {scope for key, scope in workspace.modules.items() if Path(key).parent == shipped and scope is not module}


def _to_check(workspace: Workspace, library: set[ModuleScope]) -> list[Symbol]:
    """All declarations of the file and of the modules beside it; of the shipped library, which was checked when it was made,
    those that they name, and those that these do.
    """
    every = [s for scope in workspace.modules.values() for s in scope.own()]
    reached = {symbol for symbol in every if symbol.module not in library}
    found = list(reached)
    while found:
        symbol = found.pop()
        span = symbol.decl.span
        for name in set(_NAME.findall(span.source.text, span.start, span.end)):
            named = symbol.module.names.get(name)
            if named is not None and named not in reached:
                reached.add(named)
                found.append(named)
    return [symbol for symbol in every if symbol in reached]


def _declaration(ck: Checker, symbol: Symbol, later: tuple[type[ast.Stmt], ...]) -> None:
    """Check a declaration, but for statements of the kinds that are left for ``later``."""
    match symbol.decl:
        case ast.RoleDecl() | ast.TemplateDecl() | ast.PrimitiveDecl() | ast.CategoryDecl():
            _body(ck, symbol, later)
        case ast.FunctionDecl(parameters=parameters, value=value):
            ck.infer(Context(symbol.module, extra=dict.fromkeys(parameters, UNKNOWN)), value)
        case ast.MaterialDecl() as decl:
            _material(ck, symbol, decl)
        case ast.VocabularyDecl() as decl:
            if decl.name == "field":
                ck.error(
                    "reserved-name",
                    decl.name_span,
                    "a vocabulary cannot be called `field`: fields have their arrays there",
                    hint="choose another name",
                )
            seen: set[str] = set()
            for word, span in zip(decl.words, decl.word_spans, strict=True):
                if word == UNLABELLED:
                    ck.error(
                        "reserved-name",
                        span,
                        f"`{word}` is reserved for surface without a label",
                        hint="leave it out: surface without a label has this word already",
                    )
                if word in seen:
                    ck.error(
                        "duplicate-name",
                        span,
                        f"`{word}` appears twice in this vocabulary",
                        hint="leave one of them out",
                    )
                seen.add(word)


def _body(ck: Checker, symbol: Symbol, later: tuple[type[ast.Stmt], ...]) -> None:
    roles.check_parent(ck, symbol)
    scope = ck.scope_of(symbol)
    names.check_names(ck, scope)
    statements.check_body(ck, scope, tuple(stmt for stmt in symbol.body if not isinstance(stmt, later)), ())
    if symbol.kind == "template":
        roles.check_template(ck, symbol)
    if symbol.kind == "primitive":
        primitives.check_whole(ck, symbol)
    if symbol.kind in ("template", "category"):
        attachments.check(ck, scope)


def _check_frictions(
    ck: Checker, module: ModuleScope, static: ast.Clause[ast.RangeExpr], dynamic: ast.Clause[ast.RangeExpr]
) -> None:
    """What slides is not held back more than what rests, whatever is drawn; ranges may overlap a little, as measured ones do."""
    most, least = constant(static.value.high, module), constant(dynamic.value.low, module)
    if most is not None and least is not None and most < least:
        ck.error(
            "illegal-value",
            static.span,
            f"the static friction is less than the dynamic one, {most:g} against {least:g}",
            hint="what lies still is harder to move than what slides: exchange them, or write `friction` for both",
            notes=((dynamic.span, "the dynamic friction"),),
        )


_PROPERTIES = {
    "density": ScalarType(DIMENSIONS["density"]),
    "colour": VecType(3, NONE),
}  # of materials; others are ratios


def _material(ck: Checker, symbol: Symbol, decl: ast.MaterialDecl) -> None:
    ctx, words = Context(symbol.module), ast.clause_words(ast.MaterialDecl)
    apart = decl.static_friction or decl.dynamic_friction
    if decl.friction is not None and apart is not None:
        ck.error(
            "unknown-clause",
            decl.friction.span,
            f"`friction` is both the static and the dynamic one, and `{apart.word}` is given, too",
            hint="write `static_friction 0.5  dynamic_friction 0.4`, or `friction` alone",
        )
    if decl.static_friction is not None and decl.dynamic_friction is not None:
        _check_frictions(ck, symbol.module, decl.static_friction, decl.dynamic_friction)
    for clause in ast.clauses(decl):
        kind = _PROPERTIES.get(clause.word, RATIO)
        if clause.word not in words:
            ck.error(
                "unknown-argument",
                clause.span,
                f"a material has no property `{clause.word}`",
                hint=did_you_mean(clause.word, words) or "it has " + ", ".join(words),
            )
        elif clause.value.low is clause.value.high:
            ck.expect(ctx, clause.value.low, kind, f"`{clause.word}`")
        else:
            declarations.check_range(ck, ctx, clause.value, kind, f"an end of the range of `{clause.word}`")
