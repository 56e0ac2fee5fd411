"""The state of one check: the report, the types found so far, and the entry points that the rules call."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping
from contextlib import contextmanager
from dataclasses import field, replace
from typing import Any

from ..diagnostics import Report
from ..records import dataclass
from ..source import Span
from ..syntax import ast
from ..syntax.walk import walk
from ..units import Dimension
from . import conditions, entries, expressions
from .fold import is_unitless
from .guards import TRUE, Condition, conjunction, implies
from .meanings import Inner, Meaning
from .modules import Workspace
from .presence import excludes
from .remedies import instead, usual_unit, with_likely_units
from .scope import BodyScope, Entry, Guards, build_scope, interface
from .symbols import ModuleScope, Symbol
from .types import LENGTH_DIM, NONE, POINT, UNKNOWN, ScalarType, Type, VecType, fits


@dataclass(frozen=True, slots=True)
class Context:
    """Where an expression stands.

    ``condition``: what is known to hold there.
    ``extra``: names that only this place has (parameters of a function, ``p`` and ``n`` in a label).
    ``many``: the name of a repeat stands for all of its elements.
    ``lenient``: where a list, presence is not demanded but noted in it.
    ``asked``: so is that of values, since the question is whether they are there.
    ``subject``: the statement goes with what is named, so what only some alternatives have may be named too.
    ``ends``: it names an end of a connection.
    ``holes``: ``_`` may stand for a component.
    ``component``: the dimension that the components of this vector should have.
    ``making``: the expression that may make a curve, as the value of a `let` and the argument of an operator do.
    ``silent``: the types are not recorded (the body of a function, once per call).
    ``leads``: by the identity of a path, that it stands for the value of the joint that it names, and the type of that.
    """

    module: ModuleScope
    scope: BodyScope | None = None
    condition: Condition = TRUE
    extra: Mapping[str, Type] = field(default_factory=dict)
    many: bool = False
    lenient: list[Condition] | None = None
    asked: bool = False
    holes: bool = False
    silent: bool = False
    ends: bool = False
    subject: bool = False
    component: Dimension | None = None
    making: ast.Expr | None = None
    leads: Mapping[int, Type] = field(default_factory=dict)

    def but(self, **changes: Any) -> Context:
        return replace(self, **changes)

    def given(self, *more: Condition) -> Context:
        """The same place where more is known to hold."""
        known = conjunction((self.condition, *more)) if more else self.condition
        return self if known == self.condition else replace(self, condition=known)

    def names(self) -> list[str]:
        """All names that could be meant here, for suggestions."""
        own = self.scope.names() if self.scope is not None else []
        return [*self.extra, *own, *self.module.names]


_DECLARE = "check the spelling, declare it, or bring it in: `use module { Name }`"


def _summed(entry: Entry) -> str | None:
    """What to write for a value that adds to that of the element before."""
    if not isinstance(entry.node, ast.LetDecl) or (repeat := entry.scope.repeat) is None:
        return None
    value = entry.node.value
    if not any(isinstance(node, ast.NameExpr) and node.name == "previous" for node in walk(value)):
        return None
    return (
        f"a total is `sum({repeat.name}.w)`, of any number `w` of the elements; to put each element behind the one before, "
        "write `align part.left = previous.part.right`"
    )


class Checker:
    """One check of a workspace. The rules are functions of a checker, a context and a piece of the tree."""

    def __init__(self, workspace: Workspace, report: Report) -> None:
        self.workspace = workspace
        self.report = report
        self.types: dict[int, Type] = {}
        self.meanings: dict[int, Meaning] = {}
        self.measured: dict[int, Type] = {}  # paths to joints of roles, by identity -> what their values have to be
        self.vocabularies: dict[str, set[str]] = {}
        self._scopes: dict[int, BodyScope] = {}
        self._entries: dict[int, Type] = {}
        self._open: list[Entry] = []
        self._muted = 0
        self._boxless: set[int] = set()
        self._interfaces: dict[int, dict[str, tuple[Symbol, ast.Stmt]]] = {}
        self._conditions: dict[int, Condition] = {}
        self.subjects: dict[int, Condition] = {}  # subjects of statements, by identity -> where these have one
        # by scope, name and target: where they stand, and under what condition
        self.marks: dict[tuple[BodyScope | None, str, str, str], list[tuple[Condition, Span]]] = {}
        self.sayings: dict[tuple[BodyScope | None, tuple[str, ...]], list[tuple[Condition, Span, str]]] = {}
        self.calls: dict[tuple[Any, ...], Type] = {}
        self.calling: list[int] = []

    def error(
        self, code: str, span: Span, message: str, hint: str | None = None, notes: tuple[tuple[Span, str], ...] = ()
    ) -> Type:
        """Reports an error; the unknown type, to go on with."""
        if not self._muted:
            self.report.error(code, span, message, hint=hint, notes=notes)
        return UNKNOWN

    def unfit(self, expr: ast.Node, kind: Type, need: str, hint: str | None) -> Type:
        """Reports that ``expr`` is of a kind that its place has no use for; ``need`` says what it needs."""
        return self.error("wrong-type", expr.span, f"{need}, but this is {kind}", hint=hint)

    def many_elements(self, name: str, span: Span) -> Type:
        """Reports a repeat that is named where one element is meant."""
        hint = f"name one: `{name}[0]` or `{name}[last]`"
        return self.error("many-elements", span, f"`{name}` means all elements of a repeat here", hint=hint)

    def warning(
        self, code: str, span: Span, message: str, hint: str | None = None, notes: tuple[tuple[Span, str], ...] = ()
    ) -> None:
        """Reports what is allowed and hardly meant."""
        if not self._muted:
            self.report.warning(code, span, message, hint=hint, notes=notes)

    def is_first(self, owner: Symbol) -> bool:
        """Whether it is told for the first time that a template has no box of its own: once is enough."""
        if self._muted:
            return True
        known = id(owner) in self._boxless
        self._boxless.add(id(owner))
        return not known

    def unknown(self, module: ModuleScope, name: str, code: str, span: Span, message: str, hint: str | None) -> Type:
        """Reports a name that nothing declares, unless it is missing because its import failed."""
        return UNKNOWN if name in module.lost else self.error(code, span, message, hint=hint or _DECLARE)

    @contextmanager
    def muted(self) -> Iterator[None]:
        """Looks without reporting: for what is reported when it is checked in its own place."""
        self._muted += 1
        try:
            yield
        finally:
            self._muted -= 1

    def interface_of(self, symbol: Symbol) -> dict[str, tuple[Symbol, ast.Stmt]]:
        """What the roles of a template (or a role and its parents) declare: name -> (role, declaration)."""
        if id(symbol) not in self._interfaces:
            self._interfaces[id(symbol)] = interface(symbol)
        return self._interfaces[id(symbol)]

    def scope_of(self, symbol: Symbol) -> BodyScope:
        """The (shared) scope of a role, template, primitive or category."""
        if id(symbol) not in self._scopes:
            self._scopes[id(symbol)] = build_scope(symbol)
        return self._scopes[id(symbol)]

    def mean(self, node: ast.Node, meaning: Meaning) -> None:
        """Notes what a name stands for; it is the same in every check of its place."""
        self.meanings[id(node)] = meaning

    def mean_member(self, node: ast.MemberExpr, meaning: Meaning) -> None:
        """Notes what a member is. In a function it has to be the same for whatever calls hand in."""
        before = self.meanings.setdefault(id(node), meaning)
        if before != meaning:
            said = "is declared for the argument of one call, and a member of every box or place for that of another"
        elif isinstance(before, Inner) and isinstance(meaning, Inner) and not before.alike(meaning):
            said = f"is {before.kind} for the argument of one call, and {meaning.kind} for that of another"
        else:
            if isinstance(before, Inner) and isinstance(meaning, Inner):
                self.meanings[id(node)] = replace(meaning, without=before.without | meaning.without)
            return
        self.error("wrong-type", node.name_span, f"`{node.name}` {said}", hint="write one function for each of them")

    def infer(self, ctx: Context, expr: ast.Expr) -> Type:
        """The type of an expression, recorded; errors are reported once per place."""
        if (value := ctx.leads.get(id(expr))) is not None:
            return value
        kind = expressions.infer(self, ctx, expr)
        if not ctx.silent:
            self.types[id(expr)] = kind
        return kind

    def expect(
        self, ctx: Context, expr: ast.Expr, wanted: Type, what: str, beside: Iterable[ast.Expr | None] = ()
    ) -> Type:
        """Infers, and reports where the type does not fit; ``what`` names the thing ("the margin"), ``beside`` what has its unit."""
        if isinstance(expr, ast.VectorExpr) and (wanted == POINT or isinstance(wanted, VecType)):
            ctx = ctx.but(component=wanted.dimension if isinstance(wanted, VecType) else LENGTH_DIM)
        given = self.infer(ctx, expr)
        if not fits(given, wanted):
            self.mismatch(expr, given, wanted, what, beside)
        return given

    def mismatch(
        self, expr: ast.Expr, given: Type, wanted: Type, what: str, beside: Iterable[ast.Expr | None] = ()
    ) -> None:
        """Reports that ``expr`` of type ``given`` stands where ``wanted`` is expected."""
        if isinstance(wanted, ScalarType | VecType) and isinstance(given, ScalarType | VecType):
            need = wanted.dimension
            if given.dimension == NONE and need not in (NONE, None) and is_unitless(expr):
                hint = f"give the numbers units: {usual_unit(need)}"
                if isinstance(expr, ast.NumberExpr):
                    hint = f"write {with_likely_units(expr, need, beside)}"
                self.error("missing-unit", expr.span, f"{what} needs a unit: {wanted} is expected", hint=hint)
                return
            self.error(
                "wrong-dimension",
                expr.span,
                f"{what} is {wanted}, but this is {given}",
                hint=instead(expr, given, wanted),
            )
            return
        self.error(
            "wrong-type", expr.span, f"{what} is {wanted}, but this is {given}", hint=instead(expr, given, wanted)
        )

    def entry_type(self, entry: Entry) -> Type:
        """The type of a declaration (of a part: all its variants); circular definitions are reported."""
        key = id(entry)
        if key not in self._entries:
            if entry in self._open:
                ring = [e.name for e in self._open[self._open.index(entry) :]]
                self._entries[key] = self.error(
                    "circular-definition",
                    entry.span,
                    f"`{entry.name}` is defined by itself: {' -> '.join([*ring, entry.name])}",
                    hint=_summed(entry) or "give one of them a value that names none of the others",
                )
                return UNKNOWN
            self._open.append(entry)
            muted, self._muted = self._muted, 0  # a declaration is typed once: its errors must not get lost
            kind = entries.type_of(self, entry)
            self._muted = muted
            self._open.pop()
            self._entries.setdefault(key, kind)
        return self._entries[key]

    def set_aside(self, entry: Entry) -> None:
        """A declaration that cannot be: what names it is not judged."""
        self._entries[id(entry)] = UNKNOWN

    def condition(self, guards: Guards) -> Condition:
        """What holds under the guards."""
        known: list[Condition] = []
        for guard in guards:
            key = id(guard)
            if key not in self._conditions:
                self._conditions[key] = TRUE  # a guard that leads back to itself says nothing
                ctx = self.context(guard.scope).given(*known)
                self._conditions[key] = conditions.of_guard(self, ctx, guard)
            known.append(self._conditions[key])
        return conjunction(known)

    def entry_condition(self, entry: Entry) -> Condition:
        """What holds wherever the declaration exists."""
        return self.condition(entry.guards)

    def context(self, scope: BodyScope) -> Context:
        """The plain context of a body, with what its outer guards ensure."""
        return Context(scope.owner.module, scope, self.condition(scope.guards))

    def demand(
        self,
        ctx: Context,
        wanted: Condition,
        span: Span,
        message: str,
        hint: str | None,
        notes: tuple[tuple[Span, str], ...] = (),
        value: bool = False,
        handed: bool = False,
    ) -> None:
        """Reports an optional name outside a guard that ensures it, unless the place is lenient.

        Nothing can do without a ``value``: it may be absent only where it is ``asked`` for. What is ``handed`` to a template may be
        excluded by what else is, not by the guard around the statement alone.
        """
        if implies(ctx.condition, wanted):
            return
        if ctx.condition != TRUE and not ctx.asked and not handed and excludes(ctx.condition, wanted):
            self.error(
                "optional-outside-when",
                span,
                f"`{span.words}` never exists here: the guard around this statement excludes it",
                hint="move this to where it exists, or change the guard",
                notes=notes,
            )
            return
        needed = ctx.lenient is None or value and not ctx.asked
        if ctx.lenient is not None and (self._muted or not needed):
            ctx.lenient.append(wanted)
        if needed:
            self.error("optional-outside-when", span, message, hint=hint, notes=notes)
