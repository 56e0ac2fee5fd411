"""Environments: where names stand while a body is lowered.

A body (a category or an instance of a template) has a root environment; each ``repeat`` and each ``when`` opens one
inside. An environment has a table, a frame (a repeat's element may be turned or mirrored) and the unknowns and
equations that are matched together.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import field, replace
from itertools import takewhile
from typing import TYPE_CHECKING

from ...graph import expr as E
from ...graph.expr import Expr, Scope
from ...graph.program import Pose
from ...records import dataclass
from ...semantics.symbols import ModuleScope, Symbol, names_of
from ...source import Span
from ...syntax import ast
from ...syntax.walk import in_branches
from ..values.carry import merged, moved, united
from ..values.kinds import Box, Choice, Frame, Line, Placed, Plane, Ports, Ref, Value, Vec
from ..values.vectors import HERE, compose, inverse
from .context import Abort, Draft, Equation, Unknown
from .rows import has_row

if TYPE_CHECKING:
    from ..elaborate.part import Component, Instance
    from ..elaborate.ranges import Quantity


_MERGED = (Expr, Vec, Frame, Plane, Line, Box, Choice, Ports, Ref)  # one value out of those of branches


@dataclass(slots=True, eq=False)
class Thunk:
    """A declaration that is lowered when its name is first read."""

    make: Callable[[], Value]
    span: Span
    by_reader: bool = False  # the places on surfaces that it asks for count where it is read, as those of a `let`
    running: bool = False
    failed: bool = False


@dataclass(slots=True, eq=False)
class Function:
    """``let r(v) = ...`` with the environment it was written in."""

    name: str
    parameters: tuple[str, ...]
    value: ast.Expr
    env: Env


@dataclass(slots=True, eq=False)
class Element(Placed):
    """What a repeat's name means: its environment, its scope, how many, and the box of an element.

    ``seen`` carries values from the frame around the repeat into that of the expression that names it.
    """

    name: str
    env: Env
    scope: Scope
    count: Expr
    box: Box | None
    gap: Box | None = None
    seen: Pose = HERE

    def carried(self, pose: Pose) -> Element:
        return replace(self, seen=compose(pose, self.seen))


@dataclass(frozen=True, slots=True)
class Hinge:
    """A joint by its name: where it is declared; ``links`` says which joint it became."""

    env: Env
    statement: ast.JointDecl

    def __hash__(self) -> int:
        return hash((self.env, self.statement.span))  # not all that stands in the statement


@dataclass(slots=True, eq=False)
class Env:
    context: Draft
    module: ModuleScope
    symbol: Symbol | None
    scope: Scope
    path: str  # prefix of the columns declared here: "" or "door.handle."
    outer: Env | None = None
    depth: int = 0  # how many repeats are around
    frame: Pose = HERE  # this frame in the outer environment's
    instance: Instance | None = None  # whose body this is
    box: Box | None = None  # the template's own box, in the root environment of a body
    names: dict[str, Value | Thunk] = field(default_factory=dict)
    held: dict[str, list[Quantity]] = field(default_factory=dict)  # what a `let` asks for where it is read
    unknowns: list[Unknown] = field(default_factory=list)
    equations: list[Equation] = field(default_factory=list)
    inner: list[Env] = field(default_factory=list)
    branches: dict[Expr, Env] = field(default_factory=dict)
    entered: dict[ast.WhenStmt, list[tuple[Env, tuple[ast.Stmt, ...]]]] = field(default_factory=dict)
    deciding: list[ast.WhenStmt] = field(default_factory=list)  # those whose guards are being evaluated
    statements: list[ast.Stmt] = field(default_factory=list)
    parts: list[Component] = field(default_factory=list)
    element: Element | None = None

    @property
    def root(self) -> Env:
        return self if self.outer is None else self.outer.root

    def chain(self) -> Iterator[Env]:
        """This environment, then those around it in its body."""
        env: Env | None = self
        while env is not None:
            yield env
            env = env.outer

    def force(self, name: str) -> Value:
        """The value of a name declared right here, to be read."""
        value, context = self.lower(name), self.context
        for quantity in self.held.get(name, ()):
            wanted, scope = E.both(context.known, context.subject), context.reader or self.scope
            if wanted.scope is not None and not scope.within(wanted.scope):
                scope = wanted.scope
            context.ask(replace(quantity, guard=E.both(quantity.guard, has_row(scope, quantity.scope, wanted))))
        return value

    def lower(self, name: str) -> Value:
        """The value of a name declared right here, lowering its declaration if that has not happened yet."""
        value = self.names[name]
        if isinstance(value, Thunk):
            if value.failed:
                raise Abort(f"`{name}` could not be lowered")
            if value.running:
                running = [n for n, v in self.names.items() if isinstance(v, Thunk) and v.running and n != name]
                via = f", by way of {' and '.join(f'`{n}`' for n in running)}" if running else ""
                raise self.context.error(
                    "circular-definition",
                    value.span,
                    f"`{name}` depends on itself{via}",
                    hint="give one of them a value of its own, or leave a size open (`_`) and state an equation with `align`",
                )
            value.running = True
            try:
                held: list[Quantity] | None = [] if value.by_reader else None
                with self.context.going_with(E.TRUE), self.context.holding_back(held):
                    made = value.make()
            except Abort:
                value.failed = True
                raise
            finally:
                value.running = False
            if held:
                self.held[name] = held
            self.names[name] = made
            return made
        return value

    def find(self, name: str, depth: int) -> Value | None:
        """What the body with ``depth`` repeats around it declares under a name, in this environment's frame."""
        found = self.declared(name) if self.depth == depth else None
        if found is not None:
            return found
        if self.outer is None:
            return None
        value = self.outer.find(name, depth)
        if value is None or self.frame is HERE:
            return value
        return moved(value, inverse(self.frame))

    def declared(self, name: str) -> Value | None:
        """The value of a name that is declared here, or in branches of ``when``: of the branch that is there."""
        if name in self.names:
            return self.force(name)
        found = [(branch.scope, value) for branch, value in self.branched(name)]
        if len(found) == 1 and not isinstance(found[0][1], _MERGED):
            return found[0][1]  # an element's values are fetched from its own table; styles and functions have a home
        if not found or not all(isinstance(value, _MERGED) for _, value in found):
            return None
        references = united(name, [(None if scope is self.scope else scope, value) for scope, value in found])
        if references is not None:
            return references
        return found[0][1] if found[0][0] is self.scope else merged(self.scope, found)

    def branched(self, name: str) -> list[tuple[Env, Value]]:
        """What branches of ``when`` declare under a name, be they further down in the text."""
        for statement in self.statements:
            if isinstance(statement, ast.WhenStmt) and _declares(statement, name):
                self.context.makers.enter_when(self, statement)
        found: list[tuple[Env, Value]] = []
        for branch in self.branches.values():
            found.extend([(branch, branch.force(name))] if name in branch.names else branch.branched(name))
        return found

    def foregoes(self, name: str) -> bool:
        """Whether a ``when`` declares a name, in branches that are never taken where ``branched`` finds none."""
        return any(isinstance(s, ast.WhenStmt) and _declares(s, name) for s in self.statements)

    def refuse_circle(self, name: str, span: Span) -> None:
        """Refuse a guard, here or around, that asks for a name declared under it."""
        if any(_declares(statement, name) for env in self.chain() for statement in env.deciding):
            raise self.context.error(
                "circular-definition",
                span,
                f"`{name}` depends on itself: the `when` that it stands under asks for it",
                hint="for a part that may be absent, use the alternative `none`; or let the condition name something else",
            )

    def all_parts(self) -> list[Component]:
        """Parts declared here and in the environments inside, in the order of the text."""
        found = list(self.parts)
        for env in self.inner:
            found.extend(env.all_parts())
        return found

    def nested(self, scope: Scope, path: str, deeper: int = 0) -> Env:
        """An environment inside: of a repeat, ``deeper`` by 1, or of a branch of ``when``."""
        env = Env(
            self.context, self.module, self.symbol, scope, path, self, self.depth + deeper, instance=self.instance
        )
        self.inner.append(env)
        return env

    def element_at(self, depth: int) -> Element | None:
        """The element in which this stands, of the repeat whose body is ``depth`` deep."""
        return next((env.element for env in self.chain() if env.element is not None and env.depth == depth), None)

    def pose_in(self, around: Env) -> Pose:
        """This frame in that of an environment around it, of the same body."""
        pose = HERE
        for env in takewhile(lambda env: env is not around, self.chain()):
            pose = compose(env.frame, pose)
        return pose


def pose_between(env: Env, other: Env) -> Pose:
    """The frame of an environment in that of another one of the same body."""
    around = next(e for e in env.chain() if any(e is one for one in other.chain()))
    return compose(inverse(other.pose_in(around)), env.pose_in(around))


def exists_in(env: Env, guard: Expr) -> bool:
    """Whether rows of the environment's table are rows for which ``guard`` holds."""
    return guard is E.TRUE or any(scope.count is guard for scope in env.scope.ancestors())


def _declares(statement: ast.WhenStmt, name: str) -> bool:
    """Whether a branch of a ``when`` declares a name."""
    return any(name in names_of(inner) for inner in in_branches((statement,)))
