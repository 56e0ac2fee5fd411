"""Named top-level declarations, the scope of a module, and what a role or a template effectively declares."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import field
from typing import TypeAlias

from ..records import dataclass
from ..source import Source, Span
from ..syntax import ast
from ..syntax.trees import KeptTree
from ..syntax.walk import in_branches

KINDS: dict[type[ast.Decl], str] = {
    ast.RoleDecl: "role",
    ast.TemplateDecl: "template",
    ast.PrimitiveDecl: "primitive",
    ast.CategoryDecl: "category",
    ast.MaterialDecl: "material",
    ast.VocabularyDecl: "vocabulary",
    ast.FunctionDecl: "function",
}


@dataclass(frozen=True, slots=True, eq=False)
class Symbol:
    """A top-level declaration of ``module``, shared by every scope that imports it."""

    name: str
    kind: str  # role, template, primitive, category, material, vocabulary, function
    module: ModuleScope = field(repr=False)
    number: int = field(repr=False)  # among the declarations of the module

    @property
    def decl(self) -> ast.Decl:
        return self.module.held.declaration(self.number)

    @property
    def body(self) -> tuple[ast.Stmt, ...]:
        """The statements of a role, template, primitive or category; empty for anything else."""
        return getattr(self.decl, "body", ())


@dataclass(slots=True, eq=False)
class ModuleScope:
    """One file: its tree as it is ``held``, and the names that stand in it (its own declarations and what ``use`` brings in)."""

    name: str
    source: Source
    held: ast.Module | KeptTree
    names: dict[str, Symbol] = field(default_factory=dict)
    lost: set[str] = field(default_factory=set)  # names whose import failed, which is reported at the `use`

    @property
    def tree(self) -> ast.Module:
        return self.held.whole

    def find(self, name: str) -> Symbol | None:
        return self.names.get(name)

    def named(self, *kinds: str) -> list[str]:
        """The names of declarations of some kinds, for suggestions."""
        return [s.name for s in self.names.values() if s.kind in kinds]

    def used(self) -> list[ModuleScope]:
        """All modules that it takes names from, and those that these do, each behind what it uses; itself last."""
        found: list[ModuleScope] = []
        seen: set[ModuleScope] = set()

        def visit(module: ModuleScope) -> None:
            seen.add(module)
            for symbol in module.names.values():
                if symbol.module not in seen:
                    visit(symbol.module)
            found.append(module)

        visit(self)
        return found

    def own(self) -> list[Symbol]:
        """The module's own declarations, in the order of the text."""
        return [s for s in self.names.values() if s.module is self]


def parent_of(symbol: Symbol) -> Symbol | None:
    """The role that a template plays or that a role refines; None where there is none or it is unknown."""
    decl = symbol.decl
    name = decl.parent if isinstance(decl, ast.RoleDecl) else decl.role if isinstance(decl, ast.TemplateDecl) else None
    found = symbol.module.find(name) if name is not None else None
    return found if found is not None and found.kind == "role" else None


def lacks_role(symbol: Symbol) -> bool:
    """Whether the role that a template is said to play is unknown."""
    decl = symbol.decl
    return isinstance(decl, ast.TemplateDecl) and decl.role is not None and parent_of(symbol) is None


def lineage(symbol: Symbol) -> list[Symbol]:
    """The symbol, its role, that role's parent and so on; a circle of roles is cut where it closes."""
    chain: list[Symbol] = []
    at: Symbol | None = symbol
    while at is not None and at not in chain:
        chain.append(at)
        at = parent_of(at)
    return chain


def is_a(symbol: Symbol, other: Symbol) -> bool:
    """Whether ``symbol`` is ``other``, plays it (a template its role) or refines it (a role its parent)."""
    return other in lineage(symbol)


def members(symbol: Symbol) -> tuple[ast.Stmt, ...]:
    """The effective declarations, outermost role first.

    Of a role: its parents' statements, then its own. Of a template: the role parameters (``inherit``, ``param``,
    ``out``) that it takes over, then its own statements; a role parameter that the template declares again is left
    out. Of anything else: its own statements.
    """
    chain = lineage(symbol)
    if symbol.kind != "template":
        return tuple(stmt for at in reversed(chain) for stmt in at.body)
    own = set(_declared_names(symbol.body))
    inherited = (stmt for at in reversed(chain[1:]) for stmt in at.body if isinstance(stmt, ast.ParamDecl))
    return tuple(stmt for stmt in inherited if not own.intersection(stmt.names)) + symbol.body


def _declared_names(body: tuple[ast.Stmt, ...]) -> Iterator[str]:
    """The names that stand in a body, those under ``when`` included, those inside a ``repeat`` not."""
    return (name for stmt in in_branches(body) for name in names_of(stmt))


def names_of(stmt: ast.Stmt) -> tuple[str, ...]:
    """What a statement declares in its body."""
    if isinstance(stmt, ast.ParamDecl):
        return stmt.names
    return (stmt.name,) if isinstance(stmt, Named) else ()


def name_spans_of(stmt: ast.Stmt) -> tuple[Span, ...]:
    """Where it says these names."""
    if isinstance(stmt, ast.ParamDecl):
        return stmt.name_spans
    return (stmt.name_span,) if isinstance(stmt, Named) else ()


Named: TypeAlias = (
    ast.CountDecl
    | ast.LetDecl
    | ast.PartDecl
    | ast.StyleDecl
    | ast.SlotDecl
    | ast.PortDecl
    | ast.JointDecl
    | ast.RepeatStmt
    | ast.SurfaceDecl
    | ast.CurveDecl
)
"""What declares a single name."""

NAMED: dict[type[ast.Stmt], str] = {
    ast.CountDecl: "count",
    ast.LetDecl: "let",
    ast.PartDecl: "part",
    ast.StyleDecl: "style",
    ast.SlotDecl: "slot",
    ast.PortDecl: "port",
    ast.JointDecl: "joint",
    ast.RepeatStmt: "repeat",
    ast.SurfaceDecl: "surface",
    ast.CurveDecl: "curve",
}
"""As what each declares it."""
