"""Parts: one use of a template, of a primitive, or of one of several alternatives of a role."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import field, replace
from typing import TYPE_CHECKING

from ...graph import expr as E
from ...graph.expr import Expr, Scope
from ...graph.primitive import Triple
from ...graph.program import Pose
from ...records import dataclass
from ...semantics.symbols import Symbol, is_a
from ...source import Span
from ...syntax import ast
from ..expressions.context import Abort, Draft, Unknown
from ..expressions.env import Env
from ..expressions.evaluate import Evaluator
from ..expressions.extents import frame_in, union_of
from ..expressions.members import refuse_repeats
from ..expressions.rows import has_row
from ..values.carry import merged, moved, united
from ..values.faces import centred
from ..values.kinds import Box, Branch, Choice, Lying, Ports, Ref, Surface, Value, Vec
from ..values.vectors import IDENTITY, Matrix, compose, matrix
from .paths import Reached, walk
from .style import Style
from .turns import apply_placements

if TYPE_CHECKING:
    from ..solids.lowered import Lowered
    from .connect import Attachment


@dataclass(slots=True, eq=False)
class Option:
    """An alternative of a part as the text gives it, resolved."""

    name: str
    symbol: Symbol
    source: ast.Alternative
    code: int


@dataclass(slots=True, eq=False)
class Component:
    """A part of a body: what it can be, one ``Instance`` of a template or primitive for each alternative, and where it is placed."""

    context: Draft
    env: Env
    name: str
    path: str
    declaration: ast.PartDecl
    placing: Callable[[Component], Pose]  # finds its pose (``place.pose_of``), once
    role: Symbol | None = None
    options: list[Option] = field(default_factory=list)
    instances: list[Instance] = field(default_factory=list)
    choice: Choice | None = None
    exists: Expr = E.TRUE
    inputs: dict[str, Value] = field(default_factory=dict)
    given: dict[str, Span] = field(default_factory=dict)  # which of them the text gives
    more: tuple[ast.Argument, ...] = ()  # given to each of a style's alternatives, whose role does not take them
    attachments: list[Attachment] = field(default_factory=list)  # once, or once in each branch of a ``when``
    style: Style | None = None
    found: Pose | None = None  # its pose, once it is known
    seeking: bool = False  # its pose, just now
    unplaced: bool = False
    mounted: Span | None = None  # the statement that fixes its whole pose, where one does
    previous: Pose | None = None  # of the element before, while that is what its own is sought from
    _box: Box | None = None

    @property
    def span(self) -> Span:
        return self.declaration.name_span

    @property
    def pose(self) -> Pose:
        """Its placement in the frame of the environment that declares it."""
        return self.placing(self)

    def guard(self, option: Option) -> Expr:
        """Where it is made of one of its alternatives."""
        if self.choice is None or len(self.options) == 1:
            return self.exists
        chosen = E.call("eq", self.choice.code, E.const(float(option.code)))
        if self.style is not None and (alone := self.declaration.alternatives[0].guard) is not None:
            ev = Evaluator(self.env)
            return E.both(ev.condition(alone), chosen)
        return chosen

    def matches(self, symbol: Symbol) -> Expr:
        """Where ``part is Name`` holds."""
        options = [o for o in self.options if is_a(o.symbol, symbol)]
        if len(options) == len(self.options):
            return self.exists
        return E.any_of(self.guard(o) for o in options)

    def rotation(self) -> Matrix:
        """``along`` and ``turned`` of the part and of the alternative that is there; the identity without any."""
        own = self.declaration.placements
        if self.style is not None:  # what the style says, then what its user does
            home, user = self.style.env, self.declaration.alternatives[0].placements
            outer = apply_placements(self.env, (*own, *user))
            found = [(o, apply_placements(home, o.source.placements, outer)) for o in self.options]
        else:
            found = [(o, apply_placements(self.env, (*own, *o.source.placements))) for o in self.options]
        result = found[-1][1] if found else IDENTITY  # what could not be built has been reported
        for option, other in reversed(found[:-1]):
            guard = self.guard(option)
            result = matrix(
                tuple(E.where(guard, a, b) for a, b in zip(row, rest, strict=True))
                for row, rest in zip(other, result, strict=True)
            )
        return result

    def position(self) -> Triple:
        """Three unknown coordinates of its origin, registered with its environment."""
        columns = []
        for axis, letter in enumerate("xyz"):
            column = self.context.column(self.env.scope, f"{self.path}.at.{letter}", "real", self.span)
            name = f"the position of `{self.name}` along {letter}"
            self.env.unknowns.append(Unknown(column, "position", self.span, name, self, axis))
            columns.append(E.col(column))
        return columns[0], columns[1], columns[2]

    def member(
        self, name: str, own: bool = False, without: frozenset[Symbol] = frozenset(), span: Span | None = None
    ) -> Value | None:
        """A declared member in the frame of its environment (``own``: in its own frame), of the alternatives ``without`` some."""
        value = self.own(name, without, span)
        if value is None:
            return None
        if isinstance(value, Ports):
            value = Ports(value.name, {k: carried(v, self) for k, v in value.settled().items()})
        value = carried(value, self)
        if own or name in self.inputs or isinstance(value, Expr | Choice):
            return value
        return moved(value, self.pose)

    @property
    def bodies(self) -> list[Env]:
        """The bodies of the templates that it may be made of."""
        return [instance.env for instance in self.instances if instance.env is not None]

    @property
    def primitive(self) -> bool:
        return all(i.symbol.kind == "primitive" for i in self.instances)

    def handed(self, name: str) -> Value | None:
        """The value of a parameter that all alternatives take as it is handed to the part; None where one of them says another."""
        said = any(a.name == name for option in self.options for a in option.source.arguments)
        alone = self.role is None and len(self.options) == 1  # then what it says is what is handed in
        return self.inputs.get(name) if alone or not said else None

    def own(self, name: str, without: frozenset[Symbol] = frozenset(), span: Span | None = None) -> Value | None:
        """A declared member in the part's own frame, in the table of its environment where alternatives differ."""
        if (handed := self.handed(name)) is not None:
            return handed
        found: list[tuple[Scope, Value]] = []
        for instance in self.instances:
            value = None if instance.symbol in without else instance.member(name)
            if value is not None:
                found.append((instance.scope, value))
        if not found:
            return None
        home = self.env.scope
        if (whole := united(name, [(None if scope is home else scope, value) for scope, value in found])) is not None:
            return whole
        if len(found) == 1 and found[0][0] is home:
            return found[0][1]
        if len(found) > 1:
            refuse_repeats(self.context, name, (value for _, value in found), span)
        return merged(home, found)

    def box(self) -> Box:
        """The box of the part in its own frame."""
        if self._box is None:
            size = self.handed("size")
            if isinstance(size, Vec) and len(size.items) == 3 and all(i.takes_size for i in self.instances):
                self._box = centred(size.items, (self,))
            elif not self.instances:
                raise Abort(f"`{self.name}` could not be built")
            else:
                own, *others = self.instances
                if others or own.scope is not self.env.scope:
                    box = merged(self.env.scope, [(i.scope, i.box()) for i in self.instances])
                else:
                    box = own.box()
                self._box = Box(box.low, box.high, on=(self,))
        return self._box


@dataclass(slots=True, eq=False)
class Instance:
    """A template or primitive with its arguments, in the table where it exists."""

    part: Component
    symbol: Symbol
    scope: Scope
    path: str
    env: Env | None = None  # the body of a template
    solid: Lowered | None = None  # of a primitive
    values: dict[str, Value] = field(default_factory=dict)
    bindings: dict[str, list[tuple[Env, ast.SlotDecl]]] = field(default_factory=dict)  # one, or one in each branch
    _box: Box | None = None

    @property
    def size(self) -> Triple | None:
        """Its size, where that is handed in."""
        size = self.values.get("size")
        return size.items if isinstance(size, Vec) and len(size.items) == 3 else None

    @property
    def takes_size(self) -> bool:
        return self.size is not None if self.solid is None else self.solid.centred_size

    def member(self, name: str) -> Value | None:
        """A member in the instance's own frame and table."""
        if self.solid is not None:
            found = self.solid.member(self, name)
            return found if found is not None else self.values.get(name)
        assert self.env is not None
        if name in self.bindings:
            return self.slot(name)
        return self.env.declared(name)

    def bound(self, name: str) -> list[Reached]:
        """What a slot binds, each value with the environment it lives in; paths may run through repeats."""
        return [found for home, statement in self.bindings[name] for found in self.targets(home, statement)]

    def targets(self, env: Env, statement: ast.SlotDecl) -> list[Reached]:
        """What one statement binds; under a guard, all of it lives in its branch."""
        found: list[Reached] = []
        for node in statement.targets:
            for value, home, named in walk(env, node):
                if named is not E.TRUE:
                    raise self.part.context.error(
                        "wrong-kind",
                        node.span,
                        "a slot must bind all elements of a repeat, not a single one",
                        hint="omit the number, or bind a part outside the repeat",
                    )
                within = env.scope is self.scope or home.scope.within(env.scope)
                if not within and has_row(home.scope, self.scope) is not E.TRUE:
                    repeat = self._repeat_below(home.scope)
                    what = "a slot bound in another" if repeat is None else f"the elements of the repeat `{repeat}`"
                    raise self.part.context.error(
                        "wrong-kind",
                        node.span,
                        f"a slot bound in one `when` cannot refer to {what}",
                        hint="name the part itself, or bind the slot in every branch of the same `when`"
                        if repeat is None
                        else "put the repeat into the same `when`, or bind the slot outside of it",
                    )
                found.append(Reached(value, home if within else env))
        return found

    def _repeat_below(self, scope: Scope) -> str | None:
        """The repeat of this part that rows of ``scope`` are elements of, None for no repeat."""
        return next((s.name for s in scope.ancestors() if s.kind == "repeat" and not self.scope.within(s)), None)

    def slot(self, name: str) -> Value:
        """A slot as one reference to all the parts, or all the surfaces, it binds."""
        surfaces: list[tuple[Scope | None, Component, Pose, str]] = []
        branches: list[Branch] = []
        for home, statement in self.bindings[name]:
            scope = None if home.scope is self.scope else home.scope
            members: list[tuple[Component, Pose]] = []
            for value, _, _ in self.targets(home, statement):
                if isinstance(value, Surface):
                    for table, part, outer, surface in value.branches:
                        pose = compose(frame_in(part.env, self.env), compose(part.pose, outer))
                        surfaces.append((table or scope, part, pose, surface))
                    continue
                if not isinstance(value, Ref):
                    return value
                for branch in value.branches:
                    members.extend((part, frame_in(part.env, self.env)) for part, _ in branch.members)
            branches += [Branch(scope, tuple(members))] if members else []
        return Surface(tuple(surfaces)) if surfaces else Ref(name, tuple(branches))

    def box(self) -> Box:
        if self._box is None:
            if self.solid is not None:
                self._box = self.solid.box(self)
            elif self.size is not None:
                self._box = centred(self.size)
            else:
                assert self.env is not None
                self._box = union_of(self.env, self.env.scope)
        return self._box

    def parts(self) -> list[Component]:
        return self.env.all_parts() if self.env is not None else []


def carried(value: Value, part: Component) -> Value:
    """A value that names no inner part lies on the part itself."""
    return replace(value, on=(part,)) if isinstance(value, Lying) and not value.on else value
