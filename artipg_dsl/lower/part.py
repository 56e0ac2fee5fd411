"""Parts: one use of a template, of a primitive, or of one of several alternatives of a role."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, field, replace
from typing import TYPE_CHECKING

from ..graph import expr as E
from ..graph.expr import Column, Expr, Scope
from ..graph.program import Draw, Pose
from ..semantics.symbols import Symbol, is_a
from ..source import Span
from ..syntax import ast
from .context import Abort, Context, Unknown, where
from .draws import draw_choice, open_parameter
from .env import Env
from .evaluate import Evaluator
from .style import Style
from .values import (
    HERE,
    IDENTITY,
    ORIGIN,
    Box,
    Branch,
    Choice,
    Ports,
    Ref,
    Surface,
    Value,
    Vec,
    along,
    compose,
    extent,
    merged,
    moved,
    product,
    rotation_about,
    times,
)

if TYPE_CHECKING:
    from .primitives import Lowered

HALF = E.const(0.5)


@dataclass(slots=True, eq=False)
class Option:
    """An alternative of a part as the text gives it, resolved."""

    name: str
    symbol: Symbol
    source: ast.Alternative
    code: int


@dataclass(slots=True, eq=False)
class Part:
    context: Context
    env: Env
    name: str
    path: str
    declaration: ast.PartDecl
    role: Symbol | None = None
    options: list[Option] = field(default_factory=list)
    instances: list[Instance] = field(default_factory=list)
    choice: Choice | None = None
    exists: Expr = E.TRUE
    inputs: dict[str, Value] = field(default_factory=dict)
    attachment: object = None  # set by ``attach``
    style: Style | None = None
    _pose: Pose | None = None
    _posing: bool = False
    _unplaced: bool = False
    _chain: Pose | None = None
    _box: Box | None = None

    @property
    def span(self) -> Span:
        return self.declaration.name_span

    @property
    def pose(self) -> Pose:
        """Its placement in the frame of the environment that declares it."""
        if self._pose is None:
            from .place import pose_of

            if self._posing:
                return self.chain()
            if self._unplaced:
                raise Abort(f"`{self.name}` could not be placed")
            self._posing = True
            try:
                pose = pose_of(self)
                self._pose = pose if self._chain is None else self.chained(pose, self._chain)
            except Abort:
                self._unplaced = True
                raise
            finally:
                self._posing = False
        return self._pose

    def chain(self) -> Pose:
        """The pose while it is being sought: of the element before, in a chain through ``previous``."""
        if self.env.scope.kind != "repeat":
            raise circular_place(self)
        if self._chain is None:
            names = [f"{self.path}.at.{letter}" for letter in "xyz"]
            columns = [self.context.column(self.env.scope, name, "real", self.span) for name in names]
            self._chain = Pose(IDENTITY, tuple(map(E.col, columns)), E.ONE)  # type: ignore[arg-type]
        return self._chain

    def chained(self, pose: Pose, chain: Pose) -> Pose:
        """Close the chain: each element stands on the one before, all turned alike."""
        from .recurrent import closed

        if pose.rotation != chain.rotation or pose.mirror is not E.ONE:
            raise self.context.error(
                "recurrence", self.span, f"each `{self.name}` is turned against the one before, which is no sum of offsets",
                hint="place the elements straight at joint values 0 and turn them by their joints",
            )  # fmt: skip
        for name, value in zip(chain.translation, pose.translation, strict=True):
            self.context.program.definitions[name.value] = closed(self.context, name.value, value)  # type: ignore[index,arg-type]
        return chain

    @property
    def primitive(self) -> bool:
        return all(i.symbol.kind == "primitive" for i in self.instances)

    def own(self, name: str, span: Span) -> Value | None:
        """A declared member in the part's own frame, in the table of its environment where alternatives differ."""
        if name in self.inputs:
            return self.inputs[name]
        found: list[tuple[Scope, Value]] = []
        for instance in self.instances:
            value = instance.member(name)
            if value is not None:
                found.append((instance.scope, value))
        if not found:
            return None
        if all(isinstance(v, Ref) for _, v in found):
            branches = [
                Branch(s if b.scope is None and s is not self.env.scope else b.scope, b.members)
                for s, v in found
                for b in v.branches  # type: ignore[union-attr]
            ]
            return Ref(name, tuple(branches))
        if len(found) == 1 and found[0][0] is self.env.scope:
            return found[0][1]
        if all(isinstance(v, Surface) for _, v in found):
            return Surface(tuple(b if b[0] is not None else (s, *b[1:]) for s, v in found for b in v.branches))  # type: ignore[union-attr]
        if any(not hasattr(v, "__dataclass_fields__") and not isinstance(v, Expr) for _, v in found):
            return found[0][1]
        return merged(self.env.scope, found)

    def box(self) -> Box:
        """The box of the part in its own frame."""
        if self._box is None:
            size = self.inputs.get("size")
            if isinstance(size, Vec) and len(size.items) == 3 and all(i.takes_size for i in self.instances):
                half = times(size.items, HALF)  # type: ignore[arg-type]
                self._box = Box(times(half, E.const(-1.0)), half, on=(self,))
            elif len(self.instances) == 1 and self.instances[0].scope is self.env.scope:
                box = self.instances[0].box()
                self._box = Box(box.low, box.high, on=(self,))
            elif not self.instances:
                raise Abort(f"`{self.name}` could not be built")
            else:
                boxes = [(i.scope, i.box()) for i in self.instances]
                box = merged(self.env.scope, boxes)  # type: ignore[arg-type]
                self._box = Box(box.low, box.high, on=(self,))  # type: ignore[union-attr]
        return self._box


@dataclass(slots=True, eq=False)
class Instance:
    """A template or primitive with its arguments, in the table where it exists."""

    part: Part
    symbol: Symbol
    scope: Scope
    path: str
    env: Env | None = None  # the body of a template
    solid: Lowered | None = None  # of a primitive
    values: dict[str, Value] = field(default_factory=dict)
    bindings: dict[str, tuple[Env, ast.SlotDecl]] = field(default_factory=dict)
    _box: Box | None = None

    @property
    def takes_size(self) -> bool:
        if self.solid is not None:
            return self.solid.centred_size
        size = self.values.get("size")
        return isinstance(size, Vec) and len(size.items) == 3

    def member(self, name: str) -> Value | None:
        """A member in the instance's own frame and table."""
        if self.solid is not None:
            found = self.solid.member(self, name)
            return found if found is not None else self.values.get(name)
        assert self.env is not None
        if name in self.bindings:
            return self.slot(name)
        if name in self.env.names:
            return self.env.force(name)
        for branch in self.env.branches.values():
            if name in branch.names:
                value = branch.force(name)
                if branch.scope is self.env.scope or isinstance(value, Ref):
                    return Ref(name, tuple(Branch(b.scope or branch.scope, b.members) for b in value.branches)) if isinstance(
                        value, Ref
                    ) else value  # fmt: skip
                return merged(self.env.scope, [(branch.scope, value)])
        return None

    def bound(self, name: str) -> list[tuple[Value, Env]]:
        """What a slot binds, each value with the environment it lives in; paths may run through repeats."""
        from .labels import walk

        env, statement = self.bindings[name]
        return [found for node in statement.targets for found in walk(env, node)]

    def slot(self, name: str) -> Value:
        """A slot as one reference to all the parts it binds (or the first surface, where it binds surfaces)."""
        members = []
        for value, _ in self.bound(name):
            if isinstance(value, Surface):
                table, part, outer, surface = value.branches[0]
                return Surface(((table, part, compose(frame_in(part.env, self.env), compose(part.pose, outer)), surface),))
            if not isinstance(value, Ref):
                return value
            for branch in value.branches:
                members.extend((part, frame_in(part.env, self.env)) for part, _ in branch.members)
        return Ref(name, (Branch(None, tuple(members)),))

    def box(self) -> Box:
        if self._box is None:
            if self.solid is not None:
                self._box = self.solid.box(self)
            elif self.takes_size:
                half = times(self.values["size"].items, HALF)  # type: ignore[union-attr]
                self._box = Box(times(half, E.const(-1.0)), half)
            else:
                assert self.env is not None
                self._box = union_of(self.env, self.env.scope)
        return self._box

    def parts(self) -> list[Part]:
        return self.env.all_parts() if self.env is not None else []


def frame_in(env: Env, root: Env | None) -> Pose:
    """The frame of an environment in that of a body around it, through repeats and parts."""
    pose, at = HERE, env
    while at is not root:
        if at.outer is not None:
            pose, at = compose(at.frame, pose), at.outer
        elif at.instance is not None:
            pose, at = compose(at.instance.part.pose, pose), at.instance.part.env
        else:
            break
    return pose


def raised(box: Box, scope: Scope | None, to: Scope) -> Box:
    """A box of the rows of ``scope``, as the box around all its rows per row of ``to``."""
    while scope is not None and scope is not to and scope.within(to) and scope.parent is not None:
        if scope.kind == "repeat":
            low = tuple(E.reduce("min", scope, c) for c in box.low)
            high = tuple(E.reduce("max", scope, c) for c in box.high)
        else:
            inf = E.const(float("inf"))
            low = tuple(E.phi(scope.parent, [(scope, c)], inf) for c in box.low)
            high = tuple(E.phi(scope.parent, [(scope, c)], E.neg(inf)) for c in box.high)
        box, scope = Box(low, high, on=box.on), scope.parent  # type: ignore[arg-type]
    return box


def circular_place(part: Part) -> Abort:
    """Report a part whose mount leads back to it, with the statements that lead there."""
    from .place import mounts

    waiting = [p for p in part.env.parts if p._posing]
    others = [p for p in waiting if p is not part]
    via = f", by way of {' and '.join(f'`{p.name}`' for p in others)}" if others else ""
    notes = [(m.statement.span, f"places `{p.name}`") for p in waiting for m in mounts(part.env, p.name)]
    return part.context.error(
        "circular-definition", part.span, f"the place of `{part.name}` depends on itself{via}", notes=tuple(notes[:4]),
        hint="`to` and `between` take the place from their target: let one of these parts hang on something that stands",
    )  # fmt: skip


def boxes_in(env: Env) -> Iterator[tuple[Part, Box]]:
    """Every part of an environment and of those inside it with its box, in the environment's frame."""
    for part in env.parts:
        yield part, moved(part.box(), part.pose)  # type: ignore[misc]
    for inner in env.inner:
        for part, box in boxes_in(inner):
            yield part, moved(box, inner.frame)  # type: ignore[misc]


def union_of(env: Env, scope: Scope) -> Box:
    """The axis-aligned box around all parts of an environment and of those inside it, in its frame and ``scope``."""
    lows: list[list[Expr]] = [[], [], []]
    highs: list[list[Expr]] = [[], [], []]
    for part, found in boxes_in(env):
        box = extent(found)
        if part.exists is not E.TRUE:
            box = Box(
                tuple(E.where(part.exists, c, E.const(float("inf"))) for c in box.low),  # type: ignore[arg-type]
                tuple(E.where(part.exists, c, E.const(float("-inf"))) for c in box.high),  # type: ignore[arg-type]
            )
        box = raised(box, part.env.scope, scope)
        for k in range(3):
            lows[k].append(box.low[k])
            highs[k].append(box.high[k])
    if not lows[0]:
        return Box(ORIGIN, ORIGIN)
    return Box(tuple(E.minimum(*c) for c in lows), tuple(E.maximum(*c) for c in highs))  # type: ignore[arg-type]


def part_member(part: Part, name: str, span: Span, ev: Evaluator, own: bool = False) -> Value | None:
    """A declared member of a part in the frame of its environment (``own``: in its own frame)."""
    value = part.own(name, span)
    if value is None:
        return None
    if isinstance(value, Ports):
        value = Ports(value.name, {k: carried(v, part) for k, v in value.settled().items()})
    value = carried(value, part)
    if own or name in part.inputs:
        return value
    return moved(value, part.pose)


def carried(value: Value, part: Part) -> Value:
    """A value that names no inner part lies on the part itself."""
    if isinstance(value, Ref) or not hasattr(value, "on") or value.on:  # type: ignore[union-attr]
        return value
    return replace(value, on=(part,))  # type: ignore[type-var]


def matches(part: Part, name: str, span: Span, env: Env) -> Expr:
    """The guard of ``part is Name``."""
    symbol = env.module.find(name)
    if symbol is None:
        raise part.context.error("unknown-name", span, f"there is no role or template `{name}`")
    codes = [o.code for o in part.options if is_a(o.symbol, symbol)]
    if not codes:
        return E.FALSE
    if part.choice is None or len(codes) == len(part.options) and part.exists is E.TRUE:
        return E.TRUE
    if len(codes) == len(part.options):
        return part.exists
    result = E.FALSE
    for code in codes:
        result = E.either(result, E.call("eq", part.choice.code, E.const(float(code))))
    return result


# ---------------------------------------------------------------- building


def build_part(env: Env, declaration: ast.PartDecl) -> Part:
    """Lower the declaration of a part: its choice, its inputs, its instances; registers its unknowns."""
    context = env.context
    part = Part(context, env, declaration.name, env.path + declaration.name, declaration)
    env.parts.append(part)
    context.parts.append(part)
    alternatives, arguments = declaration.alternatives, declaration.arguments
    if declaration.role is None and len(alternatives) == 1 and isinstance(
        style := env.find(alternatives[0].name or ""), Style
    ):
        arguments = alternatives[0].arguments
        part.style, part.role, alternatives = style, style.role, style.declaration.alternatives
    elif declaration.role is not None:
        part.role = resolve(env, declaration.role, declaration.role_span or declaration.span)
    resolve_options(part, alternatives, env if part.style is None else part.style.env)
    make_choice(part, alternatives)
    if part.role is None and len(part.options) == 1:
        arguments = arguments + part.options[0].source.arguments
    interface = part.role if part.role is not None else part.options[0].symbol if len(part.options) == 1 else None
    if interface is not None:
        make_inputs(part, interface, arguments)
    for option in part.options:
        part.instances.append(instantiate(part, option))
    return part


def resolve(env: Env, name: str, span: Span) -> Symbol:
    symbol = env.module.find(name)
    if symbol is None:
        raise env.context.error("unknown-name", span, f"there is no template, role or primitive `{name}`")
    return symbol


def resolve_options(part: Part, alternatives: tuple[ast.Alternative, ...], env: Env) -> None:
    for code, alternative in enumerate(alternatives):
        if alternative.name is None:
            continue
        symbol = resolve(env, alternative.name, alternative.name_span)
        if symbol.kind not in ("template", "primitive"):
            raise part.context.error(
                "wrong-kind", alternative.name_span, f"`{alternative.name}` is a {symbol.kind}; a part is made of a template or a primitive"
            )  # fmt: skip
        part.options.append(Option(alternative.name, symbol, alternative, code))
    if not part.options:
        raise part.context.error("wrong-kind", part.span, f"`{part.name}` has no alternative but none")


def make_choice(part: Part, alternatives: tuple[ast.Alternative, ...]) -> None:
    if len(alternatives) == 1:
        return
    names = tuple(a.name or "none" for a in alternatives)
    if part.style is not None:
        part.choice = part.style.choice
    else:
        part.choice = draw_choice(part.env, part.path, names, alternatives, part.span, part.declaration)
    absent = [k for k, a in enumerate(alternatives) if a.name is None]
    for code in absent:
        part.exists = E.both(part.exists, E.negate(E.call("eq", part.choice.code, E.const(float(code)))))


def option_guard(part: Part, option: Option) -> Expr:
    if part.choice is None:
        return E.TRUE
    if len(part.options) == 1:
        return part.exists
    return E.call("eq", part.choice.code, E.const(float(option.code)))


def make_inputs(part: Part, interface: Symbol, arguments: tuple[ast.Argument, ...]) -> None:
    """Values of the interface's parameters: the arguments, and open columns for what is not given."""
    from .body import parameters_of

    env = part.env
    given = {a.name: a for a in arguments if a.name is not None}
    declared = parameters_of(interface)
    for argument, (_, _, name, _) in zip([a for a in arguments if a.name is None], declared, strict=False):
        given[name] = argument
    names = {name for _, _, name, _ in declared}
    counts = {s.name for s in interface.body if isinstance(s, ast.CountDecl)}
    for name, argument in given.items():
        if name in counts:
            part.inputs[name] = Evaluator(env).scalar(argument.value)
        elif name not in names and part.role is None:
            raise part.context.error("unknown-argument", argument.span, f"`{interface.name}` has no parameter `{name}`")
    local = Env(env.context, interface.module, interface, env.scope, part.path + ".", names=dict())
    for symbol, declaration, name, span in declared:
        if declaration.keyword == "out":
            continue
        local.module = symbol.module
        argument = given.get(name)
        if argument is not None and not has_hole(argument.value):
            value = Evaluator(env).value(argument.value) if not is_option(declaration, argument) else option_value(declaration, argument)
        else:
            value = open_parameter(part, local, declaration, name, span, argument)
        part.inputs[name] = value
        local.names[name] = value


def has_hole(node: ast.Expr) -> bool:
    return isinstance(node, ast.VectorExpr) and any(isinstance(i, ast.HoleExpr) for i in node.items)


def is_option(declaration: ast.ParamDecl, argument: ast.Argument) -> bool:
    """``open = front`` for a ``choice`` parameter."""
    return isinstance(argument.value, ast.NameExpr) and argument.value.name in declaration.type.values


def option_value(declaration: ast.ParamDecl, argument: ast.Argument) -> Choice:
    options = declaration.type.values
    return Choice(E.const(float(options.index(argument.value.name))), options)  # type: ignore[attr-defined]


def instantiate(part: Part, option: Option) -> Instance:
    """The alternative in its own table (that of the environment when there is nothing to choose)."""
    from .body import lower_body
    from .primitives import lower_primitive

    context = part.context
    guard = option_guard(part, option)
    scope = context.guard(part.env.scope, guard, f"{part.path}={option.name}")
    instance = Instance(part, option.symbol, scope, part.path + ".")
    if len(context.trace) > 40:
        raise context.error("circular-definition", part.span, f"`{option.name}` contains itself")
    context.trace.append((part.span, f"in `{part.path}` ({option.name})"))
    try:
        own = dict(part.inputs)
        arguments = option.source.arguments if part.role is not None or len(part.options) > 1 else ()
        for argument in arguments:
            own[argument.name or ""] = Evaluator(part.env).value(argument.value)
        instance.values = own
        if option.symbol.kind == "primitive":
            complete(instance)
            instance.solid = lower_primitive(context, option.symbol, own)
            instance.solid.require(instance)
        else:
            instance.env = lower_body(instance, option, scope, own)
    finally:
        context.trace.pop()
    return instance


def complete(instance: Instance) -> None:
    """Parameters of a primitive that one alternative among several leaves out: drawn, or their defaults."""
    from .body import own_parameter, parameters_of

    part, symbol = instance.part, instance.symbol
    local = Env(part.context, symbol.module, symbol, instance.scope, instance.path, names=dict(instance.values))
    for _, declaration, name, _ in parameters_of(symbol):
        if name in instance.values:
            continue
        if declaration.default is None and declaration.domain is None:
            raise part.context.error(
                "missing-argument", part.span, f"`{symbol.name}` needs `{name}`",
                hint=f"give it with the alternative: {symbol.name}({name} = ...)",
            )  # fmt: skip
        local.names[name] = instance.values[name] = own_parameter(local, declaration, name)


def rotation_of(part: Part) -> tuple:
    """``along`` and ``turned`` of the part and of a sole alternative; the identity without any."""
    ev = Evaluator(part.env)
    rotation = IDENTITY
    placements = part.declaration.placements
    if len(part.options) == 1:
        placements = placements + part.options[0].source.placements
    for placement in placements:
        direction = ev.direction(placement.direction)
        if placement.kind == "along":
            step = along(direction)
        else:
            assert placement.angle is not None
            step = rotation_about(direction, ev.scalar(placement.angle))
        rotation = product(step, rotation)
    return rotation


def position_columns(part: Part) -> tuple:
    """Three unknown coordinates of the part's origin, registered with its environment."""
    context, columns = part.context, []
    for axis, letter in enumerate("xyz"):
        column = context.column(part.env.scope, f"{part.path}.at.{letter}", "real", part.span)
        part.env.unknowns.append(Unknown(column, "position", part.span, f"the position of `{part.name}` along {letter}", part, axis))
        columns.append(E.col(column))
    return tuple(columns)


__all__ = ["Abort", "Column", "Draw", "HERE", "Part", "Instance", "build_part", "part_member", "where"]
