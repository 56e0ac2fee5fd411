"""Symbol tables of bodies: what a category, template, role, primitive or repeat declares, and under which guards."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import field

from ..records import dataclass
from ..source import Span
from ..syntax import ast
from .guards import Compare, Condition
from .symbols import NAMED, Symbol, lineage, members, name_spans_of, names_of

Guards = tuple["Guard", ...]
"""The guards under which something stands, outermost first."""


@dataclass(frozen=True, slots=True, eq=False)
class Guard:
    """The ``when`` (``truth`` True) or ``else`` (False) branch of a statement that stands in ``scope``."""

    scope: BodyScope
    test: ast.Expr
    truth: bool


@dataclass(frozen=True, slots=True)
class Variant:
    """One thing that a part can be. ``symbol`` is None where the name is unknown (reported where it stands)."""

    name: str
    symbol: Symbol | None


@dataclass(frozen=True, slots=True, eq=False)
class Entry:
    """One declaration in a body. ``kind``: param count let part style repeat slot port joint index surface curve.

    ``scope`` is the body in which it is written, ``key`` its name among the variables of guards.
    """

    name: str
    kind: str
    node: ast.Stmt
    span: Span
    scope: BodyScope = field(repr=False)
    guards: Guards = field(repr=False)
    key: str

    @property
    def private(self) -> bool:
        """Whether only the body itself may name it."""
        return self.kind in ("style", "index")


@dataclass(slots=True, eq=False)
class BodyScope:
    """The declarations of one body. ``repeat`` is set for the body of a repeat, whose elements are its rows."""

    owner: Symbol
    path: str
    parent: BodyScope | None = None
    repeat: ast.RepeatStmt | None = None
    guards: Guards = ()
    table: dict[str, list[Entry]] = field(default_factory=dict)
    inner: dict[int, BodyScope] = field(default_factory=dict)  # id(RepeatStmt) -> the scope of its body
    branches: dict[tuple[int, bool], Guards] = field(default_factory=dict)  # (id(WhenStmt), branch) -> its guards

    @property
    def entries(self) -> Iterator[Entry]:
        for entries in self.table.values():
            yield from entries

    @property
    def root(self) -> BodyScope:
        scope = self
        while scope.parent is not None:
            scope = scope.parent
        return scope

    @property
    def depth(self) -> int:
        """How many repeats are around the body, itself included."""
        return 0 if self.parent is None else self.parent.depth + 1

    @property
    def rank_key(self) -> str:
        """The guard variable for the rank of an element of this repeat."""
        return f"{self.path}#rank"

    @property
    def after_first(self) -> Condition:
        """Holds for all elements of this repeat but the first."""
        return Compare(self.rank_key, ">", 0)

    def below(self) -> Iterator[BodyScope]:
        """This scope, then those of its repeats and of the repeats in them."""
        yield self
        for inner in self.inner.values():
            yield from inner.below()

    def chain(self) -> Iterator[BodyScope]:
        """This scope, then the ones around it."""
        scope: BodyScope | None = self
        while scope is not None:
            yield scope
            scope = scope.parent

    def find(self, name: str) -> list[Entry]:
        """The declarations of a name in the innermost scope that has it (several under exclusive guards)."""
        home = self.home(name)
        return home.table[name] if home is not None else []

    def home(self, name: str) -> BodyScope | None:
        """The innermost scope that declares a name."""
        return next((scope for scope in self.chain() if name in scope.table), None)

    def names(self) -> list[str]:
        return [name for scope in self.chain() for name in scope.table]


def build_scope(symbol: Symbol) -> BodyScope:
    """The scope of a role, template, primitive or category, with those of its repeats.

    A template's scope holds the parameters of its role too; a role's what its parents declare.
    """
    scope = BodyScope(symbol, symbol.name)
    _collect(scope, members(symbol), ())
    return scope


def interface(symbol: Symbol) -> dict[str, tuple[Symbol, ast.Stmt]]:
    """What the roles of a template (or a role and its parents) declare: name -> (role, declaration)."""
    found: dict[str, tuple[Symbol, ast.Stmt]] = {}
    for role in lineage(symbol):
        if role.kind == "role":
            for stmt in role.body:
                for name in names_of(stmt):
                    found.setdefault(name, (role, stmt))
    return found


def _collect(scope: BodyScope, body: tuple[ast.Stmt, ...], guards: Guards) -> None:
    def add(name: str, kind: str, node: ast.Stmt, span: Span, into: BodyScope = scope) -> None:
        entries = into.table.setdefault(name, [])
        key = f"{into.path}.{name}" + (f"~{len(entries)}" if entries else "")
        entries.append(Entry(name, kind, node, span, scope, guards, key))

    for stmt in body:
        match stmt:
            case ast.ParamDecl():
                for name, span in zip(stmt.names, stmt.name_spans, strict=True):
                    add(name, "param", stmt, span)
            case ast.PortDecl():
                # an indexed port bound inside a repeat is the template's own
                add(stmt.name, "port", stmt, stmt.name_span, scope.root if stmt.index is not None else scope)
            case ast.RepeatStmt():
                add(stmt.name, "repeat", stmt, stmt.name_span)
                inner = BodyScope(scope.owner, f"{scope.path}.{stmt.name}@{stmt.name_span.start}", scope, stmt, guards)
                scope.inner[id(stmt)] = inner
                if stmt.index is not None:
                    entry = Entry(stmt.index, "index", stmt, stmt.name_span, inner, guards, inner.rank_key)
                    inner.table[stmt.index] = [entry]
                _collect(inner, stmt.body, guards)
            case ast.WhenStmt():
                for truth, branch in ((True, stmt.body), (False, stmt.otherwise)):
                    within = (*guards, Guard(scope, stmt.guard, truth))
                    scope.branches[id(stmt), truth] = within
                    _collect(scope, branch, within)
            case _ if (kind := NAMED.get(type(stmt))) is not None:
                ((name,), (span,)) = names_of(stmt), name_spans_of(stmt)
                add(name, kind, stmt, span)
