"""A file: what it uses and what it declares."""

from __future__ import annotations

from typing import Any

from ...records import dataclass
from ...source import Span
from .expressions import Expr, RangeExpr
from .nodes import Clause, Node, Stmt


@dataclass(frozen=True, slots=True, kw_only=True)
class Decl(Stmt):
    """A named top-level declaration."""

    name: str
    name_span: Span


@dataclass(frozen=True, slots=True, kw_only=True)
class RoleDecl(Decl):
    parent: str | None
    parent_span: Span | None
    body: tuple[Stmt, ...]


@dataclass(frozen=True, slots=True, kw_only=True)
class TemplateDecl(Decl):
    role: str | None
    role_span: Span | None
    body: tuple[Stmt, ...]


@dataclass(frozen=True, slots=True, kw_only=True)
class PrimitiveDecl(Decl):
    body: tuple[Stmt, ...]


@dataclass(frozen=True, slots=True, kw_only=True)
class CategoryDecl(Decl):
    body: tuple[Stmt, ...]


@dataclass(frozen=True, slots=True, kw_only=True)
class MaterialDecl(Decl):
    """``material oak { density 700kg/m3  colour [0.6, 0.4, 0.2] .. [0.7, 0.5, 0.3] }``: a value is a range with equal ends.

    Any word may stand in the braces: ``unknown`` are those that a material does not have.
    """

    density: Clause[RangeExpr] | None = None
    friction: Clause[RangeExpr] | None = None
    static_friction: Clause[RangeExpr] | None = None
    dynamic_friction: Clause[RangeExpr] | None = None
    restitution: Clause[RangeExpr] | None = None
    colour: Clause[RangeExpr] | None = None
    roughness: Clause[RangeExpr] | None = None
    metalness: Clause[RangeExpr] | None = None
    transparency: Clause[RangeExpr] | None = None
    unknown: tuple[Clause[Any], ...] = ()


@dataclass(frozen=True, slots=True, kw_only=True)
class VocabularyDecl(Decl):
    """``vocabulary affordance { push, turn : about, lift : along }``: words, and by which kind of joint some of them move."""

    words: tuple[str, ...]
    word_spans: tuple[Span, ...]
    motions: tuple[str, ...]


@dataclass(frozen=True, slots=True, kw_only=True)
class FunctionDecl(Decl):
    """A module-level ``let f(x) = ...`` or constant (no parameters)."""

    parameters: tuple[str, ...]
    value: Expr


@dataclass(frozen=True, slots=True, kw_only=True)
class UseDecl(Node):
    module: str
    module_span: Span
    names: tuple[str, ...]
    name_spans: tuple[Span, ...]


@dataclass(frozen=True, slots=True)
class Head:
    """What a declaration is called, and its class."""

    kind: type[Decl]
    name: str
    name_span: Span


@dataclass(frozen=True, slots=True, kw_only=True)
class Module(Node):
    version: int
    uses: tuple[UseDecl, ...]
    declarations: tuple[Decl, ...]

    @property
    def heads(self) -> tuple[Head, ...]:
        return tuple(Head(type(decl), decl.name, decl.name_span) for decl in self.declarations)

    def declaration(self, number: int) -> Decl:
        return self.declarations[number]

    @property
    def whole(self) -> Module:
        """Itself: of a tree that is read piece by piece, all of it (see ``trees``)."""
        return self
