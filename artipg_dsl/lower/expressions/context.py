"""What one lowering shares: the program that grows, the report, the order of draws, shared guard scopes."""

from __future__ import annotations

from collections.abc import Callable, Hashable, Iterator, Mapping
from contextlib import contextmanager
from dataclasses import field, replace
from typing import TYPE_CHECKING, Any, TypeAlias

from ...diagnostics import Report
from ...errors import InternalError
from ...graph import expr as E
from ...graph.expr import Column, Expr, Scope, ScopeError
from ...graph.interval import Interval
from ...graph.primitive import Triple
from ...graph.program import Draw, Label, Program, Requirement, Where
from ...language import Form
from ...records import dataclass
from ...semantics.meanings import BuiltIn, Global, Meaning
from ...semantics.symbols import Symbol
from ...source import Span
from ...syntax import ast
from .rows import either_of

if TYPE_CHECKING:
    from ...semantics.check import TypedProgram
    from ..elaborate.handed import Handed
    from ..elaborate.nowhere import Holding
    from ..elaborate.overridden import Said
    from ..elaborate.part import Component
    from ..elaborate.ranges import Quantity
    from ..solids.lowered import Lowered
    from ..values.kinds import Value
    from .env import Env
    from .evaluate import Evaluator


class Abort(Exception):
    """A statement cannot be lowered; its diagnostic is in the report already."""


@dataclass(slots=True, eq=False)
class Equation:
    """``left = right`` in the scope of the environment that states it, where ``guard`` holds.

    ``near`` are pairs of sides that are about equal at the root that is meant.
    """

    left: Expr
    right: Expr
    span: Span
    text: str
    guard: Expr = E.TRUE
    near: tuple[tuple[Expr, Expr], ...] = ()


@dataclass(frozen=True, slots=True, eq=False)
class Settled:
    """How an unknown is settled where ``when`` holds: by an equation, solved together with ``others`` (by name) of the
    same block (known by its first column), searched from ``start`` (in words) where there is no closed form; or, without one, for a ``reason``.
    """

    when: Expr
    equation: Equation | None = None
    others: tuple[str, ...] = ()
    block: Column | None = None
    start: str = ""
    reason: str = ""


@dataclass(slots=True, eq=False)
class Unknown:
    """A scalar that equations may determine.

    ``kind``: "position" (a coordinate of a part; free ones are centred), "size" (no domain: must be determined),
    "default" (no domain, but a default), "param" (drawn when free) or "derived" (must be determined).
    """

    column: Column
    kind: str
    span: Span
    name: str
    part: Component | None = None
    axis: int = 0
    draw: Draw | None = None
    default: Expr | None = None
    positive: bool = False
    reason: str = ""  # how it was settled, in short
    settled: list[Settled] = field(default_factory=list)  # the same for the ledger, case by case


@dataclass(frozen=True, slots=True, eq=False)
class Fetched:
    """An element of a repeat that is named by its rank, of ``count``, in the rows of ``scope`` where ``guard`` holds."""

    scope: Scope
    rank: Expr
    count: Expr
    span: Span
    guard: Expr


Makes: TypeAlias = "Callable[[Evaluator, ast.CallExpr, Form], Value]"


@dataclass(frozen=True, slots=True)
class Makers:
    """What rooms above make when an expression asks for it: the branches of a ``when``, each with its statements, as soon
    as a name is looked for there; what calls of functions mean, by the ``meaning`` of a form."""

    enter_when: Callable[[Env, ast.WhenStmt], list[tuple[Env, tuple[ast.Stmt, ...]]]]
    functions: Mapping[str, Makes]


@dataclass(frozen=True, slots=True, eq=False)
class Bend:
    """A requirement on a path: its name in words and its place, the part that goes along it and where that is stated; how
    far its section reaches towards the inside of the bend, and the radius of curvature.
    """

    path: str
    place: Span
    part: str
    span: Span
    reach: Expr
    radius: Expr


@dataclass(frozen=True, slots=True)
class Present:
    """That a part (or a style) of a path is there: as the alternative ``option``, or at all."""

    path: str
    option: str | None = None


@dataclass(slots=True, eq=False)
class Draft:
    """What the lowering of one program shares: the program as far as it is made, and what only later passes need."""

    report: Report
    program: Program
    typed: TypedProgram
    makers: Makers
    guards: dict[tuple[Scope, Expr], Scope] = field(default_factory=dict)
    present: dict[Scope, Present] = field(default_factory=dict)  # guards that are no branches of a `when`
    draws: list[Draw] = field(default_factory=list)
    spans: dict[Column, Span] = field(default_factory=dict)
    # where the numbers stand that a draw follows from: the values of its distribution, say, and which of them
    values: dict[Column, dict[tuple[str, int], Span]] = field(default_factory=dict)
    stated: dict[int, tuple[Span, bool]] = field(
        default_factory=dict
    )  # requirement -> its place, if the category's own
    # requirement -> the value that it keeps in its range, which equations determine: its declaration, its name, and what it must
    settled: dict[int, tuple[Span, str, str]] = field(default_factory=dict)
    operations: dict[Expr, Span] = field(default_factory=dict)  # where the text first has them
    # requirement -> the operation that it asks to have a value: where, and why it may have none
    undefined: dict[int, tuple[Span, str]] = field(default_factory=dict)
    endless: dict[int, tuple[Span, str]] = field(default_factory=dict)  # the same, of what makes a number infinite
    # places of `turned` in repeats whose elements turn: its table, what it turns by, and the frame of an element
    spun: list[tuple[Span, Scope, tuple[Triple, ...], tuple[Triple, ...]]] = field(default_factory=list)
    axes: dict[int, Triple] = field(
        default_factory=dict
    )  # closures by number that keep two axes together -> their direction
    remedies: dict[int, str] = field(default_factory=dict)  # requirement -> what to try where it is broken
    bends: dict[int, Bend] = field(default_factory=dict)  # those of the requirements that are about one
    ledger: list[tuple[Component | None, Unknown]] = field(default_factory=list)
    parts: list[Component] = field(default_factory=list)
    centred: dict[Component, set[int]] = field(
        default_factory=dict
    )  # the axes along which nothing says where a part is
    preferred: dict[int, Span] = field(
        default_factory=dict
    )  # the preferences that the category itself states, and where
    said: dict[tuple[object, ...], list[Said]] = field(default_factory=dict)  # of one thing, in the order of the text
    holding: dict[int, list[Holding]] = field(default_factory=dict)  # of each label and field, where it holds
    guarded: list[tuple[Expr, ast.Alternative]] = field(
        default_factory=list
    )  # alternatives behind which a `when` stands
    branched: dict[int, tuple[ast.IfExpr, list[Expr]]] = field(
        default_factory=dict
    )  # `a if c else b`, and what c has been
    handed: list[Handed] = field(default_factory=list)  # arguments for parameters that have a range
    counted: dict[Scope, Span] = field(default_factory=dict)  # the tables of repeats and where they are stated
    asked: list[Quantity] = field(default_factory=list)  # numbers with a legal range that no record keeps
    fetched: list[Fetched] = field(default_factory=list)  # elements of repeats that have to be there
    named: list[Fetched] = field(default_factory=list)  # elements without which the statement that names them is void
    # the same that the `let` asks which is being lowered: they count where it is read
    held: list[Quantity] | None = None
    known: Expr = E.TRUE  # what holds where the expression that is being lowered counts
    subject: Expr = E.TRUE  # where that is there which the statement that is being lowered goes with
    reader: Scope | None = None  # the table of the expression that reads a name
    solids: dict[Hashable, Lowered] = field(default_factory=dict)  # by their symbols and the shapes of their paths
    labels: list[tuple[int, Label]] = field(default_factory=list)  # with the depths of their targets
    fields: dict[str, ast.FieldStmt] = field(default_factory=dict)  # the first of each name
    # of sites, with the depths of the targets
    materials: dict[int, list[tuple[int, tuple[tuple[str, Expr], ...]]]] = field(default_factory=dict)
    strict: set[int] = field(default_factory=set)  # requirements by `<` whose sides may come as near as one likes
    near: dict[Span, bool] = field(default_factory=dict)  # statements with `near` -> whether a search began there
    clearances: dict[int, Span] = field(default_factory=dict)  # joints that go as far as nothing is in the way
    whatever: set[int] = field(default_factory=set)  # those of them for which the other joints may be anywhere
    unclear: list[tuple[Span, str]] = field(default_factory=list)  # such ends that are not solved for, and why not
    driven: dict[Span, bool] = field(default_factory=dict)  # `pushes(joint)` -> whether the joint carries a target
    trace: list[tuple[Span, str]] = field(default_factory=list)
    blamed: tuple[Span, str] | None = None  # where and how errors begin while a primitive is shaped by its user's curve
    tested: dict[str, Interval] = field(default_factory=dict)  # what its other parameters are tested over then

    def error(self, code: str, span: Span, message: str, **more: Any) -> Abort:
        """Report an error with the present trace of instantiations; returns what the caller raises."""
        if self.blamed is not None:
            more["notes"] = (*more.get("notes", ()), (span, "the section along it"))
            span, message = self.blamed[0], f"{self.blamed[1]}: {message}"
        self.report.error(code, span, message, trace=tuple(self.trace), **more)
        return Abort(message)

    @contextmanager
    def knowing(self, condition: Expr) -> Iterator[None]:
        """While what counts only where a condition holds is lowered."""
        before, self.known = self.known, E.both(self.known, condition)
        try:
            yield
        finally:
            self.known = before

    @contextmanager
    def going_with(self, subject: Expr) -> Iterator[None]:
        """While a statement is lowered that exists where its ``subject`` does, or a declaration by itself."""
        before = self.known, self.subject
        self.known, self.subject = E.TRUE, subject
        try:
            yield
        finally:
            self.known, self.subject = before

    @contextmanager
    def holding_back(self, held: list[Quantity] | None) -> Iterator[None]:
        """While a declaration is lowered: the places that it asks for are ``held``, or (None) count wherever it is there."""
        before = self.held, self.reader
        self.held, self.reader = held, None
        try:
            yield
        finally:
            self.held, self.reader = before

    def ask(self, quantity: Quantity) -> None:
        """Ask for a place on a surface: once, wherever one that asks for it is there."""
        asked = self.asked if self.held is None else self.held
        k = next((k for k, other in enumerate(asked) if other.place is not None and other.is_of(quantity)), None)
        if k is None:
            asked.append(quantity)
        else:
            asked[k] = replace(asked[k], guard=either_of(asked[k].guard, quantity.guard))

    def meaning(self, node: ast.Node) -> Meaning | None:
        """What a name stands for, as the checker found; None for what is no name."""
        return self.typed.meanings.get(id(node))

    def form(self, node: ast.Expr) -> Form | None:
        """The function of the language that is called, in the form that the checker chose; None for what is no such call."""
        meaning = self.meaning(node.function) if isinstance(node, ast.CallExpr) else None
        return meaning.form if isinstance(meaning, BuiltIn) else None

    def symbol(self, node: ast.Node) -> Symbol | None:
        """The declaration of a file that a node names: a role, a template, a material, a vocabulary."""
        meaning = self.meaning(node)
        return meaning.symbol if isinstance(meaning, Global) else None

    def internal(self, span: Span, what: str) -> InternalError | Abort:
        """What the checker should have ruled out, or what is left of a statement that was reported; the caller raises it."""
        return Abort() if self.report.failed else InternalError(span, what)

    @contextmanager
    def attempt(self, span: Span) -> Iterator[None]:
        """Go on after a statement that cannot be lowered; what is not in the report yet is put there."""
        try:
            yield
        except Abort:
            pass
        except ScopeError as error:
            self.mixed(error, span)

    def mixed(self, error: ScopeError, span: Span) -> Abort:
        """Report that values of two tables meet that have no rows in common."""
        first, second = self.in_words(error.first), self.in_words(error.second)
        message = f"this mixes values of {first} and of {second}, and nothing says which belong together"
        hint = "move it inside the one that contains both, or reduce one side with sum, min or max"
        if error.first.within(error.second):
            message = f"each element of {first} has a value of its own here, but the target lies outside"
            hint = "name a part of the repeat, in its body without an index, or reduce the values to one with sum, min or max"
            if f"{error.first.name}[" in span.words:
                hint = f"within the repeat, `{error.first.name}` alone is this element, and `previous` the one before"
        elif "guard" in (error.first.kind, error.second.kind):
            hint = (
                "write it separately in each `when` or template, or use what all alternatives share: ports and `size`"
            )
        return self.error("unrelated-rows", span, message, hint=hint)

    def scope(self, name: str, parent: Scope, kind: str, count: Expr) -> Scope:
        scope = Scope(name, parent, kind, count)
        self.program.scopes.append(scope)
        return scope

    def guard(self, parent: Scope, condition: Expr, name: str, present: Present | None = None) -> Scope:
        """The table of the rows of ``parent`` where ``condition`` holds, which may say that something is ``present``; one table
        per condition."""
        if condition is E.TRUE:
            return parent
        key = (parent, condition)
        if key not in self.guards:
            self.guards[key] = self.scope(name, parent, "guard", condition)
            if present is not None:
                self.present[self.guards[key]] = present
        return self.guards[key]

    def require(
        self,
        scope: Scope,
        holds: Expr,
        span: Span,
        message: str,
        guard: Expr = E.TRUE,
        sides: tuple[Expr, Expr] | None = None,
        text: str = "",
        repair: tuple[int, ...] = (),
    ) -> int:
        """Add a requirement that is stated at ``span``, and give its number; the rest as in ``Requirement``."""
        requirements = self.program.requirements
        requirements.append(Requirement(scope, holds, guard, message, where(span), sides, repair, text))
        return len(requirements) - 1

    def column(self, scope: Scope, name: str, kind: str, span: Span) -> Column:
        column = Column(scope, name, kind)
        self.spans[column] = span
        return column

    def in_words(self, scope: Scope) -> str:
        """A table as the author knows it: a repeat, an alternative, a ``when``."""
        if scope.kind == "repeat":
            return f"the repeat `{scope.name}`"
        if scope.kind != "guard":
            return f"`{scope.name}`"
        there = self.present.get(scope)
        if there is None:
            return "a `when`"
        return (
            f"the optional part `{there.path}`"
            if there.option is None
            else f"the alternative {there.option} of `{there.path}`"
        )


def where(span: Span) -> Where:
    return Where(span.source.name, span.line, span.column)
